//! Projected, preconditioned conjugate gradients.
//!
//! The contact problem of an elastic half-space on a rigid plane is a quadratic program,
//!
//! ```text
//! minimize  p.Kp/2 - p.h   over  p >= 0,  mean p = P
//! ```
//!
//! I. A. Polonsky and L. M. Keer, Wear 231, 206 (1999), solve it by conjugate gradients on the points in
//! contact; V. Rey, G. Anciaux and J.-F. Molinari, Comput. Mech. 60, 69 (2017), apply K in Fourier space.
//! Here directions are preconditioned by nearly K's inverse on the points that are free to move (`preconditioner`), which makes the
//! number of iterations nearly independent of the grid. How long a step is follows from the energy of its direction on two grids
//! (`two_grids`), known to less than a tenth. So one pair of transforms of the whole map does in an iteration, that of what the
//! pressures changed by:
//!
//! 0. p = max(c + f, 0), f the pressures that flatten the surface less their mean, c such that mean p = P: the solution at full contact,
//!    and a tenth to a fifth of the iterations less than from p = P at other loads;
//! 1. gap g = Kp - h, shifted so that its mean over p > 0 is zero; free points: p > 0 or g < 0;
//! 2. r = g on free points; z = K^-1 r, about, on free points, less its mean there;
//! 3. d = -z + beta d on free points, Polak-Ribiere; d = -z again where d would not descend or the residual
//!    doubled;
//! 4. p + alpha d with alpha = -r.d / d.Kd, about, less what the load was too high by; where that made pressures negative, these to
//!    zero, and where it changed the load by more than a hundredth, the others lower by the same pressure;
//! 5. g + K c, c what the pressures changed by;
//! 6. where the residual grew and less than half of the step would have been better, back to where the energy along c is least, so
//!    that no step too long and no pressure set to zero raises the energy again and again.
//!
//! Scaling the pressures instead of lowering them would take the load that was set free from where pressures are highest. Where single
//! pixels stand out of the map and carry most of the load, the iteration then never ends.
//!
//! Transforms and gaps are in single precision: a direction need not be better, and gaps under pressure round by ever
//! less as they vanish. What rounding leaves in them is removed by one transform in double precision where the residual
//! nears it and before a state counts as converged.
//!
//! Nothing proves that this converges: pressures that each step sets to zero may come back with the next. Where the residual stops
//! falling, `projected_gradient` begins anew.

use slipgrid_topography::fourier::FourierWork;

use crate::area::{ContactArea, contact_area};
use crate::kernels::{Fit, FitSums, Gap};
use crate::rough_contact::{Convergence, RoughContact, SolveOptions};
use crate::two_grids::TwoGridsWork;
use crate::{Monitor, kernels, projected_gradient};

/// What the solver found, normalized.
pub(crate) struct Outcome {
    pub(crate) pressure: Vec<f64>,
    /// u = K p
    pub(crate) displacement: Vec<f64>,
    pub(crate) convergence: Convergence,
    /// The area when the residual first was within [`AREA_DECADE`] of the tolerance.
    pub(crate) area_before: Option<ContactArea>,
}

/// Why there is no outcome.
pub(crate) enum Failure {
    /// The monitor asked to stop.
    Cancelled,
    /// The residual did not reach the tolerance.
    NotConverged { iterations: usize, residual: f64 },
}

/// Fields of earlier solves of one map, for the next one to write to.
#[derive(Default)]
pub(crate) struct Spare {
    double: Vec<Vec<f64>>,
    single: Vec<Vec<f32>>,
}

impl Spare {
    /// Takes what a solve found back.
    pub(crate) fn take_back(&mut self, outcome: Outcome) {
        self.double.extend([outcome.pressure, outcome.displacement]);
    }
}

/// A field of zeros, in place of one that a solve no longer needs where there is one.
fn zeros<T: Copy + Default>(spare: &mut Vec<Vec<T>>, points: usize) -> Vec<T> {
    let Some(mut field) = spare.pop() else { return vec![T::default(); points] };
    field.fill(T::default());
    field
}

/// How far before the end the area is noted, for the estimate of its error.
pub(crate) const AREA_DECADE: f64 = 10.0;
/// Share of the sum of pressures down to which the load is restored by lowering them.
const MIN_SHARE: f64 = 1e-9;
/// Share of the load that a step may leave to the next one.
const NEGLIGIBLE_SHARE: f64 = 1e-2;
/// Share of a step that was best, below which it is taken back to that.
const OVERSHOT: f64 = 0.5;
/// Growth of the residual in one iteration after which directions start anew.
const RESTART_GROWTH: f64 = 2.0;
/// Residual at which the gap is first computed anew in double precision: single precision rounds it by a few 1e-7.
const FIRST_REFRESH: f64 = 1e-5;
/// Part of the residual at one refresh that calls for the next.
const NEXT_REFRESH: f64 = 1e-5;

/// Iterations in which the residual must halve. In solves that converge it halves within 12, in one of 500 within 56; an iteration of
/// `projected_gradient` takes about as long.
const PATIENCE: usize = 30;

/// |sum (g - min g) p| / (sum p Sq), Sq = 1, and what the load lacks of it.
pub(crate) fn relative_error(gap: &Gap, sum: f64, load: f64) -> f64 {
    ((gap.work - gap.lowest * sum) / load).abs() + (sum / load - 1.0).abs()
}

/// The evolving state, all fields as long as the map.
struct State<'a> {
    contact: &'a RoughContact,
    work: FourierWork<'a>,
    work_single: FourierWork<'a, f32>,
    preconditioner_work: TwoGridsWork,
    compliance_work: TwoGridsWork,
    fourier_pairs: usize,
    /// The sum of p that the load asks for.
    load: f64,
    /// p.
    pressure: Vec<f64>,
    /// Its sum, what the last step changed of that, and over how many points it is spread.
    sum: f64,
    sum_change: f64,
    pressed: f64,
    /// u = K p where the state is exact.
    displacement: Vec<f64>,
    /// The gap is that of K p in double precision.
    exact: bool,
    /// g up to a constant.
    gap: Vec<f32>,
    found: Gap,
    /// r, the gap on free points, zero elsewhere and nowhere else.
    residual: Vec<f32>,
    previous_residual: Vec<f32>,
    /// z, before it is masked; later c, what the pressures changed by.
    preconditioned: Vec<f32>,
    direction: Vec<f32>,
    /// K c.
    image: Vec<f32>,
}

impl<'a> State<'a> {
    fn new(contact: &'a RoughContact, nominal: f64, monitor: &'a dyn Monitor, spare: &mut Spare) -> Self {
        let points = contact.height.len();
        let mut single = || zeros(&mut spare.single, points);
        let [mut gap, mut preconditioned] = [single(), single()];
        let mut pressure = zeros(&mut spare.double, points);
        contact.press_flat(nominal, &mut pressure);
        gap.iter_mut().zip(&contact.height).for_each(|(g, &h)| *g = -h as f32);
        // All that the surface bears is a change from nothing.
        preconditioned.iter_mut().zip(&pressure).for_each(|(c, &p)| *c = p as f32);
        let load = nominal * points as f64;
        let mut state = Self {
            contact,
            work: contact.fourier.work_watched(monitor),
            work_single: contact.fourier_single.work_watched(monitor),
            preconditioner_work: contact.preconditioner.work(),
            compliance_work: contact.compliance_about.work(),
            fourier_pairs: 0,
            load,
            preconditioned,
            pressure,
            sum: load,
            sum_change: load,
            pressed: points as f64,
            displacement: zeros(&mut spare.double, points),
            exact: false,
            gap,
            found: Gap { shift: 0.0, lowest: 0.0, work: 0.0 },
            residual: single(),
            previous_residual: single(),
            direction: single(),
            image: single(),
        };
        state.follow();
        state
    }

    /// g = g + K c after pressures have changed by c.
    fn follow(&mut self) {
        let Self { contact, preconditioned, image, work_single, .. } = self;
        contact.fourier_single.filter(preconditioned, &contact.compliance_single, image, work_single);
        self.fourier_pairs += 1;
        self.settle(1.0);
    }

    /// g = g + `share` K c, less its mean before.
    fn settle(&mut self, share: f64) {
        self.found = kernels::settle(&mut self.gap, &self.image, &self.pressure, self.found.shift, share);
    }

    /// u = K p and g = u - h less its mean under pressure, in double precision before it is rounded.
    fn refresh(&mut self) {
        let Self { contact, pressure, displacement, work, gap, .. } = self;
        contact.fourier.filter(pressure, &contact.compliance, displacement, work);
        self.found = kernels::measure(pressure, displacement, &contact.height);
        kernels::gap(gap, displacement, &contact.height, self.found.shift);
        self.found.shift = 0.0;
        self.fourier_pairs += 1;
        self.exact = true;
    }

    fn error(&self) -> f64 {
        relative_error(&self.found, self.sum, self.load)
    }

    /// r on free points; z = K^-1 r, about.
    fn precondition(&mut self) -> Fit {
        let Self {
            contact,
            pressure,
            gap,
            found,
            residual,
            previous_residual,
            preconditioned,
            preconditioner_work,
            ..
        } = self;
        std::mem::swap(residual, previous_residual);
        let mut sums = FitSums::default();
        contact.preconditioner.apply(
            residual,
            preconditioned,
            preconditioner_work,
            |points, residual| kernels::masked_gap(residual, &pressure[points.clone()], &gap[points], found.shift),
            |points, z, residual| sums.add(z, residual, &previous_residual[points]),
        );
        sums.fit()
    }

    /// d = -z + beta d.
    fn turn(&mut self, mean: f64, beta: f64) -> Direction {
        let Self { contact, preconditioned, residual, direction, compliance_work, .. } = self;
        let mut slope = 0.0;
        let curvature = contact.compliance_about.energy(direction, compliance_work, |points, direction| {
            let (z, residual) = (&preconditioned[points.clone()], &residual[points]);
            slope += kernels::turn(direction, z, residual, mean as f32, beta as f32);
        });
        Direction { slope, curvature }
    }

    /// p + step d without negative pressures, the load restored; g follows. False where that is not finite.
    fn advance(&mut self, step: f64) -> bool {
        let excess = (self.sum - self.load) / self.pressed;
        let Self { load, pressure, direction, preconditioned, .. } = self;
        let moved = kernels::advance(pressure, direction, preconditioned, step, excess);
        let (mut sum, load) = (moved.sum, *load);
        if (sum - load).abs() > NEGLIGIBLE_SHARE * load {
            // Differences of pressures know a load that is too small a share of them no longer.
            if load > MIN_SHARE * sum {
                sum = kernels::lower(pressure, preconditioned, (sum - load) / moved.count);
            } else {
                kernels::scale(pressure, preconditioned, load / sum);
                sum = load;
            }
        }
        self.sum_change = sum - self.sum;
        (self.sum, self.pressed, self.exact) = (sum, moved.count, false);
        if !(sum.is_finite() && sum > 0.0) {
            return false;
        }
        self.follow();
        true
    }

    /// Back to where the energy is least between the pressures before the last step and these, where that is far from here; says
    /// whether it was.
    fn retreat(&mut self) -> bool {
        // E(s) = E(1) - (1 - s) g.c + (1 - s)^2 c.Kc/2
        let changed = &self.preconditioned;
        let work = kernels::dot(changed, &self.gap) - self.found.shift * self.sum_change;
        let back = work / kernels::dot(changed, &self.image);
        if !(back > 1.0 - OVERSHOT && back < 1.0) {
            return false;
        }
        self.exact = false;
        self.sum = kernels::step_back(&mut self.pressure, &self.preconditioned, back);
        self.settle(-back);
        true
    }
}

/// A direction and what is known of the energy along it.
struct Direction {
    /// r . d
    slope: f64,
    /// d . K d, about
    curvature: f64,
}

/// How conjugate gradients ended.
enum Ending {
    Converged { residual: f64, area_before: Option<ContactArea> },
    Failed(Failure),
    NoProgress,
}

/// Solves for the normalized mean pressure `nominal` > 0.
pub(crate) fn minimize(
    contact: &RoughContact,
    nominal: f64,
    options: &SolveOptions,
    monitor: &dyn Monitor,
    spare: &mut Spare,
) -> Result<Outcome, Failure> {
    let mut state = State::new(contact, nominal, monitor, spare);
    let mut iterations = 0;
    let ending = descend(&mut state, options, monitor, &mut iterations);
    let State { pressure, displacement, fourier_pairs, .. } = state;
    let State { gap, residual, previous_residual, preconditioned, direction, image, .. } = state;
    spare.single.extend([gap, residual, previous_residual, preconditioned, direction, image]);
    match ending {
        // What a filter left undone may look like anything.
        _ if monitor.cancelled() => Err(Failure::Cancelled),
        Ending::Converged { residual, area_before } => {
            let convergence = Convergence { iterations, fourier_pairs, residual };
            Ok(Outcome { pressure, displacement, convergence, area_before })
        }
        Ending::Failed(failure) => Err(failure),
        Ending::NoProgress => {
            let mut double = || zeros(&mut spare.double, contact.height.len());
            let fields = [pressure, displacement, double(), double()];
            projected_gradient::minimize(contact, nominal, options, monitor, (iterations, fourier_pairs), fields)
        }
    }
}

/// Conjugate gradients until the tolerance is met or the residual no longer falls.
fn descend(state: &mut State, options: &SolveOptions, monitor: &dyn Monitor, iterations: &mut usize) -> Ending {
    let mut error_before = f64::INFINITY;
    let mut fit_before = f64::INFINITY;
    let mut refresh_at = FIRST_REFRESH.max(options.tolerance);
    let mut restart = true;
    // The last residual that counts as progress, and the iteration that reached it.
    let mut progress = (f64::INFINITY, 0);
    let mut area_before = None;
    loop {
        let mut error = state.error();
        if error > error_before {
            restart |= error > RESTART_GROWTH * error_before;
            if state.retreat() {
                restart = true;
                error = state.error();
            }
        }
        if error <= refresh_at && !state.exact {
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
        if *iterations - progress.1 > PATIENCE {
            return Ending::NoProgress;
        }
        if monitor.cancelled() {
            return Ending::Failed(Failure::Cancelled);
        }
        error_before = error;

        let fit = state.precondition();
        // On large maps the passes from here to the next transform take as long as those before.
        if monitor.cancelled() {
            return Ending::Failed(Failure::Cancelled);
        }
        // beta = z.(r - r_before) / (z_before.r_before), Polak and Ribiere
        let mut beta = if restart { 0.0 } else { ((fit.now - fit.before) / fit_before).max(0.0) };
        if !beta.is_finite() {
            beta = 0.0;
        }
        fit_before = fit.now;
        let mut direction = state.turn(fit.mean, beta);
        if direction.slope >= 0.0 && beta > 0.0 {
            direction = state.turn(fit.mean, 0.0);
        }
        *iterations += 1;
        // alpha = -r.d / d.Kd, about
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
