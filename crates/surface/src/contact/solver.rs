//! Projected, preconditioned conjugate gradients.
//!
//! The contact problem of an elastic half-space on a rigid plane is a quadratic program for the pressures p, with the
//! compliance K and the heights h,
//!
//! ```text
//! minimize  p.Kp/2 - p.h   over  p >= 0,  mean p = P
//! ```
//!
//! I. A. Polonsky and L. M. Keer, Wear 231, 206 (1999), solve it by conjugate gradients on the points in contact; V.
//! Rey, G. Anciaux and J.-F. Molinari, Comput. Mech. 60, 69 (2017), apply K in Fourier space. Here the directions are
//! preconditioned by an approximate inverse of K on the free points (`preconditioner`), which makes the number of
//! iterations nearly independent of the grid. The step length follows from the energy of the direction on two grids
//! (`two_grids`), which is accurate to better than a tenth. An iteration therefore needs only one pair of transforms of
//! the whole map, for the change of the pressures:
//!
//! 0. p = max(c + f, 0), where f is the pressure that flattens the surface minus its mean, and c is such that mean p =
//!    P. This is the solution at full contact, and at other loads saves a tenth to a fifth of the iterations compared
//!    with p = P.
//! 1. Gap g = Kp - h, shifted to zero mean over p > 0. Free points have p > 0 or g < 0.
//! 2. r = g on free points; z = K^-1 r, approximately, on free points, minus its mean there.
//! 3. d = -z + beta d on free points, Polak-Ribiere; d = -z if d would not descend or the residual doubled.
//! 4. p + alpha d with alpha = -r.d / d.Kd, approximately, minus the excess of the load. Negative pressures are set to
//!    zero; if this changes the load by more than a hundredth, the others are lowered by a common pressure.
//! 5. g + K c, where c is the change of the pressures.
//! 6. If the residual grew and less than half of the step would have been better, go back to the least energy along c.
//!    This keeps overlong steps and pressures set to zero from raising the energy again and again. A state in double
//!    precision stays: c is no longer known there.
//!
//! Scaling the pressures instead of lowering them would take the excess load from the highest pressures. On maps where
//! single high pixels carry most of the load the iteration would then never end.
//!
//! Transforms and gaps are in single precision: directions need no more, and the rounding of gaps under pressure
//! shrinks with the gaps. A transform in double precision removes the rounding error when the residual nears it, and
//! before a state counts as converged.
//!
//! Convergence is not proven: pressures that one step sets to zero may return with the next. If the residual stops
//! falling, `projected_gradient` starts afresh.

use crate::topography::fourier::FourierWork;

use crate::contact::area::{ContactArea, contact_area};
use crate::contact::kernels::{GapStatistics, ResidualProducts, ResidualSums};
use crate::contact::rough_contact::{Convergence, RoughContact, SolveOptions};
use crate::contact::two_grids::TwoGridsWork;
use crate::contact::{Monitor, kernels, projected_gradient};

/// Solution of the contact problem at one pressure, in the normalized units of [`RoughContact`].
pub(crate) struct Outcome {
    pub(crate) pressure: Vec<f64>,
    /// Displacement u = K p.
    pub(crate) displacement: Vec<f64>,
    pub(crate) convergence: Convergence,
    /// Contact area when the residual first fell to [`AREA_DECADE`] times the tolerance.
    pub(crate) area_before: Option<ContactArea>,
}

pub(crate) enum Failure {
    Cancelled,
    NotConverged { iterations: usize, residual: f64 },
}

/// Buffers from earlier solves of the same map, for reuse.
#[derive(Default)]
pub(crate) struct BufferPool {
    double: Vec<Vec<f64>>,
    single: Vec<Vec<f32>>,
}

impl BufferPool {
    /// Returns the buffers of a solution to the pool.
    pub(crate) fn recycle(&mut self, outcome: Outcome) {
        self.double.extend([outcome.pressure, outcome.displacement]);
    }
}

/// Takes a buffer from `pool` or allocates one, filled with zeros.
fn zeros<T: Copy + Default>(pool: &mut Vec<Vec<T>>, points: usize) -> Vec<T> {
    let Some(mut field) = pool.pop() else { return vec![T::default(); points] };
    field.fill(T::default());
    field
}

/// The contact area is recorded when the residual first falls to this multiple of the tolerance; the change of the area
/// from then on estimates the error of the area.
pub(crate) const AREA_DECADE: f64 = 10.0;
/// If the load is below this fraction of the sum of pressures, the load is restored by scaling all pressures, not by
/// subtracting a constant, in which rounding would lose the load.
const MIN_LOAD_SHARE: f64 = 1e-9;
/// Error of the sum of pressures, relative to the load, up to which a step leaves the correction to the next step.
const NEGLIGIBLE_SHARE: f64 = 1e-2;
/// A step is shortened to the energy minimum along it if this minimum lies at less than this fraction of the step.
const OVERSHOOT_SHARE: f64 = 0.5;
/// Maximum number of Newton steps for the level c of the initial pressures max(c + f, 0); a dozen are needed.
const MAX_LEVEL_STEPS: usize = 50;
/// The level of the initial pressures is first found on every 16th group of eight points, which is cheaper.
const SAMPLED_EVERY: usize = 16;
/// The search for the level of the initial pressures ends once a Newton step changes the level by at most this fraction
/// of the nominal pressure; scaling the pressures removes the remaining error of the load.
const NEGLIGIBLE_LOAD_ERROR: f64 = 1e-3;

/// Factor by which the residual must grow in one iteration to restart the search directions.
const RESTART_GROWTH: f64 = 2.0;
/// Residual at which the gap is first recomputed in double precision: single precision rounds the gap by a few 1e-7.
const FIRST_REFRESH: f64 = 1e-5;
/// Fraction of the residual at the last recomputation to which the residual must fall before the gap is recomputed
/// again.
const NEXT_REFRESH: f64 = 1e-5;

/// Number of iterations within which the residual must halve. In solves that converge the residual halves within 12
/// iterations, in one of 500 such solves within 56. An iteration of `projected_gradient` costs about as much as one of
/// conjugate gradients.
const MAX_STALLED_ITERATIONS: usize = 30;

/// Residual of a state: |sum (g - min g) p| / (`load` Sq) with gap g, pressures p and Sq = 1, plus the relative error
/// of `sum`, the sum of the pressures.
pub(crate) fn relative_error(gap: &GapStatistics, sum: f64, load: f64) -> f64 {
    ((gap.work - gap.lowest * sum) / load).abs() + (sum / load - 1.0).abs()
}

/// Writes pressures p = max(c + f, 0), where f is the `fluctuation` of the pressure that flattens the surface and c is
/// such that mean p = `nominal` > 0. They are close to the solution near full contact.
pub(crate) fn lower_to_mean(fluctuation: &[f64], nominal: f64, pressure: &mut [f64]) {
    let mut level = nominal;
    // m(c) = mean max(c + f, 0) is convex: after at most one step from below, Newton's iterates descend to m(c) = P.
    for every in [SAMPLED_EVERY, 1] {
        for _ in 0..MAX_LEVEL_STEPS {
            let sums = kernels::sum_positive(fluctuation, level, every);
            // (m - P) / m'
            let lowering = (sums.sum - nominal * sums.points) / sums.count;
            if !lowering.is_finite() || lowering.abs() <= NEGLIGIBLE_LOAD_ERROR * nominal {
                break;
            }
            level -= lowering;
        }
    }
    pressure.iter_mut().zip(fluctuation).for_each(|(p, f)| *p = (level + f).max(0.0));
    let scale = nominal * pressure.len() as f64 / pressure.iter().sum::<f64>();
    if !scale.is_finite() {
        pressure.fill(nominal);
        return;
    }
    pressure.iter_mut().for_each(|pressure| *pressure *= scale);
}

/// State of the iteration; every vector is as long as the map.
struct State<'a> {
    contact: &'a RoughContact<'a>,
    work: FourierWork<'a>,
    work_single: FourierWork<'a, f32>,
    two_grids_work: TwoGridsWork,
    fourier_pairs: usize,
    /// Required sum of the pressures.
    load: f64,
    /// Pressures p.
    pressure: Vec<f64>,
    /// Sum of the pressures.
    sum: f64,
    /// Change of `sum` in the last step.
    sum_change: f64,
    /// Number of points with positive pressure.
    positive_count: f64,
    shared: Shared,
    /// True if the gap was computed from K p in double precision.
    is_exact: bool,
    /// Gap g, plus the constant `gap_statistics.shift`.
    gap: Vec<f32>,
    gap_statistics: GapStatistics,
    /// Residual r: the gap on free points, 0 elsewhere. The residual of a free point is never 0.
    residual: Vec<f32>,
    direction: Vec<f32>,
}

/// Memory of one double-precision number per point. It holds u = K p from `refresh` until the next iteration begins,
/// then two single-precision fields. A solve that converges returns u before another iteration begins.
struct Shared(Vec<f64>);

impl Shared {
    /// Two single-precision fields: z before masking and the new residual while directions are preconditioned; later
    /// the change c of the pressures and K c.
    fn change_and_image(&mut self) -> [&mut [f32]; 2] {
        let points = self.0.len();
        let (change, image) = bytemuck::cast_slice_mut(&mut self.0).split_at_mut(points);
        [change, image]
    }
}

impl<'a> State<'a> {
    fn new(contact: &'a RoughContact<'a>, nominal: f64, monitor: &'a dyn Monitor, pool: &mut BufferPool) -> Self {
        let points = contact.heights.len();
        let mut single = || zeros(&mut pool.single, points);
        let [mut gap, residual, direction] = [single(), single(), single()];
        let [mut pressure, shared] = [zeros(&mut pool.double, points), zeros(&mut pool.double, points)];
        let mut shared = Shared(shared);
        let mut work = contact.fourier.work_watched(monitor);
        contact.flatten(&mut pressure, &mut shared.0, &mut work);
        lower_to_mean(&shared.0, nominal, &mut pressure);
        // The gap starts as that of zero pressure, so the initial pressures are the first change.
        gap.iter_mut().zip(contact.heights.iter()).for_each(|(g, h)| *g = -h as f32);
        let [change, _] = shared.change_and_image();
        change.iter_mut().zip(&pressure).for_each(|(c, &p)| *c = p as f32);
        let load = nominal * points as f64;
        let mut state = Self {
            contact,
            work,
            work_single: contact.fourier_single.work_watched(monitor),
            two_grids_work: contact.preconditioner.work(),
            fourier_pairs: 1,
            load,
            pressure,
            sum: load,
            sum_change: load,
            positive_count: points as f64,
            shared,
            is_exact: false,
            gap,
            gap_statistics: GapStatistics { shift: 0.0, lowest: 0.0, work: 0.0 },
            residual,
            direction,
        };
        state.apply_compliance();
        state
    }

    /// Updates the gap, g = g + K c, after the pressures have changed by c.
    fn apply_compliance(&mut self) {
        let Self { contact, shared, work_single, .. } = self;
        let [change, image] = shared.change_and_image();
        contact.fourier_single.filter(change, &contact.compliance_single, image, work_single);
        self.fourier_pairs += 1;
        self.update_gap(1.0);
    }

    /// Updates the gap, g = g + `share` K c, and subtracts the previous mean gap under pressure.
    fn update_gap(&mut self, share: f64) {
        let Self { gap, shared, pressure, gap_statistics, .. } = self;
        let [_, image] = shared.change_and_image();
        *gap_statistics = kernels::update_gap(gap, image, pressure, gap_statistics.shift, share);
    }

    /// Computes the displacement u = K p, and the gap g = u - h minus its mean under pressure, in double precision
    /// until g is rounded.
    fn refresh(&mut self) {
        let Self { contact, pressure, shared: Shared(displacement), work, gap, .. } = self;
        contact.displace(pressure, displacement, work);
        self.gap_statistics = kernels::measure_gap(pressure, displacement, contact.heights);
        kernels::compute_gap(gap, displacement, contact.heights, self.gap_statistics.shift);
        self.gap_statistics.shift = 0.0;
        self.fourier_pairs += 1;
        self.is_exact = true;
    }

    fn error(&self) -> f64 {
        relative_error(&self.gap_statistics, self.sum, self.load)
    }

    /// Computes the residual r on free points and the approximation z of K^-1 r; returns their scalar products.
    fn precondition(&mut self) -> ResidualProducts {
        let Self { contact, pressure, gap, gap_statistics, residual: before, shared, two_grids_work, .. } = self;
        let [preconditioned, residual] = shared.change_and_image();
        let mut sums = ResidualSums::default();
        contact.preconditioner.apply(
            residual,
            preconditioned,
            two_grids_work,
            |points, residual| {
                kernels::masked_gap(residual, &pressure[points.clone()], &gap[points], gap_statistics.shift)
            },
            |points, z, residual| {
                let before = &mut before[points];
                sums.add(z, residual, before);
                before.copy_from_slice(residual);
            },
        );
        sums.products()
    }

    /// Updates the search direction, d = -(z - `mean`) + `beta` d on free points; returns slope and curvature of the
    /// energy along the direction.
    fn update_direction(&mut self, mean: f64, beta: f64) -> Direction {
        let Self { contact, shared, residual, direction, two_grids_work, .. } = self;
        let [preconditioned, _] = shared.change_and_image();
        let mut slope = 0.0;
        let curvature = contact.compliance_two_grids.energy(direction, two_grids_work, |points, direction| {
            let (z, residual) = (&preconditioned[points.clone()], &residual[points]);
            slope += kernels::update_direction(direction, z, residual, mean as f32, beta as f32);
        });
        Direction { slope, curvature }
    }

    /// Takes the step p + `step` d, sets negative pressures to zero, restores the load and updates the gap. Returns
    /// false if the sum of the pressures is not a positive finite number.
    fn advance(&mut self, step: f64) -> bool {
        let excess = (self.sum - self.load) / self.positive_count;
        let Self { load, pressure, direction, shared, .. } = self;
        let [change, _] = shared.change_and_image();
        let step_sums = kernels::advance(pressure, direction, change, step, excess);
        let (mut sum, load) = (step_sums.sum, *load);
        if (sum - load).abs() > NEGLIGIBLE_SHARE * load {
            // Lowering computes differences of pressures, in which a load far below the sum is lost to rounding.
            if load > MIN_LOAD_SHARE * sum {
                sum = kernels::lower(pressure, change, (sum - load) / step_sums.count);
            } else {
                kernels::scale(pressure, change, load / sum);
                sum = load;
            }
        }
        self.sum_change = sum - self.sum;
        (self.sum, self.positive_count, self.is_exact) = (sum, step_sums.count, false);
        if !(sum.is_finite() && sum > 0.0) {
            return false;
        }
        self.apply_compliance();
        true
    }

    /// Goes back to the state of least energy along the last change of the pressures, if this state lies before the
    /// fraction [`OVERSHOOT_SHARE`] of the change. Returns whether it did.
    fn line_search_back(&mut self) -> bool {
        // E(s) = E(1) - (1 - s) g.c + (1 - s)^2 c.Kc/2
        let [change, image] = self.shared.change_and_image();
        let work = kernels::dot(change, &self.gap) - self.gap_statistics.shift * self.sum_change;
        let back = work / kernels::dot(change, image);
        if !(back > 1.0 - OVERSHOOT_SHARE && back < 1.0) {
            return false;
        }
        self.is_exact = false;
        self.sum = kernels::step_back(&mut self.pressure, change, back);
        self.update_gap(-back);
        true
    }
}

/// Slope and curvature of the energy along the search direction.
struct Direction {
    /// Slope r . d, with the residual r and the direction d.
    slope: f64,
    /// Curvature d . K d, approximately.
    curvature: f64,
}

enum Ending {
    Converged { residual: f64, area_before: Option<ContactArea> },
    Failed(Failure),
    NoProgress,
}

/// Solves the contact problem at the normalized mean pressure `nominal` > 0 by conjugate gradients or, if these stall,
/// by projected gradients.
pub(crate) fn minimize(
    contact: &RoughContact<'_>,
    nominal: f64,
    options: &SolveOptions,
    monitor: &dyn Monitor,
    pool: &mut BufferPool,
) -> Result<Outcome, Failure> {
    let mut state = State::new(contact, nominal, monitor, pool);
    let mut iterations = 0;
    let ending = descend(&mut state, options, monitor, &mut iterations);
    let State { pressure, shared: Shared(displacement), fourier_pairs, gap, residual, direction, .. } = state;
    pool.single.extend([gap, residual, direction]);
    match ending {
        // A cancelled filter leaves arbitrary values.
        _ if monitor.cancelled() => Err(Failure::Cancelled),
        Ending::Converged { residual, area_before } => {
            let convergence = Convergence { iterations, fourier_pairs, residual };
            Ok(Outcome { pressure, displacement, convergence, area_before })
        }
        Ending::Failed(failure) => Err(failure),
        Ending::NoProgress => {
            pool.single.clear();
            let mut double = || zeros(&mut pool.double, contact.heights.len());
            let fields = [pressure, displacement, double(), double()];
            projected_gradient::minimize(contact, nominal, options, monitor, (iterations, fourier_pairs), fields)
        }
    }
}

/// Runs conjugate gradients until the tolerance is met or the residual no longer falls.
fn descend(state: &mut State, options: &SolveOptions, monitor: &dyn Monitor, iterations: &mut usize) -> Ending {
    let mut error_before = f64::INFINITY;
    let mut z_r_before = f64::INFINITY;
    let mut refresh_at = FIRST_REFRESH.max(options.tolerance);
    let mut restart = true;
    // Last residual that counts as progress, and its iteration.
    let mut progress = (f64::INFINITY, 0);
    let mut area_before = None;
    loop {
        let mut error = state.error();
        if error > error_before {
            restart |= error > RESTART_GROWTH * error_before;
            // A state in double precision has overwritten the change that led to it.
            if !state.is_exact && state.line_search_back() {
                restart = true;
                error = state.error();
            }
        }
        if error <= refresh_at && !state.is_exact {
            refresh_at = options.tolerance.max(NEXT_REFRESH * error);
            state.refresh();
            continue;
        }
        if error <= AREA_DECADE * options.tolerance && area_before.is_none() {
            area_before = Some(contact_area(&state.pressure, state.contact.cols));
        }
        if error <= options.tolerance {
            return Ending::Converged { residual: error, area_before };
        }
        if *iterations >= options.max_iterations {
            return Ending::Failed(Failure::NotConverged { iterations: *iterations, residual: error });
        }
        if error < 0.5 * progress.0 {
            progress = (error, *iterations);
        }
        if *iterations - progress.1 > MAX_STALLED_ITERATIONS {
            return Ending::NoProgress;
        }
        if monitor.cancelled() {
            return Ending::Failed(Failure::Cancelled);
        }
        error_before = error;

        let products = state.precondition();
        // On large maps the passes from here to the next transform take as long as those before it.
        if monitor.cancelled() {
            return Ending::Failed(Failure::Cancelled);
        }
        // beta = z.(r - r_before) / (z_before.r_before), Polak and Ribiere
        let mut beta = if restart { 0.0 } else { ((products.z_r - products.z_r_previous) / z_r_before).max(0.0) };
        if !beta.is_finite() {
            beta = 0.0;
        }
        z_r_before = products.z_r;
        let mut direction = state.update_direction(products.mean, beta);
        if direction.slope >= 0.0 && beta > 0.0 {
            direction = state.update_direction(products.mean, 0.0);
        }
        *iterations += 1;
        // alpha = -r.d / d.Kd, approximately
        let step = -direction.slope / direction.curvature;
        if !(step.is_finite() && step > 0.0) {
            if restart {
                return Ending::NoProgress;
            }
            restart = true;
            continue;
        }
        restart = false;
        if !state.advance(step) {
            return Ending::NoProgress;
        }
    }
}
