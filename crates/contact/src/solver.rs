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
//! Here directions are preconditioned by nearly K's inverse (`preconditioner`), masked to the points that are free to
//! move, which makes the number of iterations nearly independent of the grid:
//!
//! 0. p = max(c + f, 0), f the pressures that flatten the surface less their mean, c such that mean p = P: the solution at full contact,
//!    and a tenth to a fifth of the iterations less than from p = P at other loads;
//! 1. gap g = Kp - h, shifted so that its mean over p > 0 is zero; free points: p > 0 or g < 0;
//! 2. r = g on free points; z = K^-1 r, about, on free points, less its mean there;
//! 3. d = -z + beta d on free points, Polak-Ribiere; d = -z again where d would not descend or the residual
//!    doubled;
//! 4. p + alpha d with the exact step alpha; where that made pressures negative, these to zero, the others lower by the same
//!    pressure that the load asks for; what is left of the load by scaling; g follows by K d, or by K of what the pressures
//!    changed by where some were set to zero.
//!
//! Scaling alone would take the load that was set free from where pressures are highest. Where single pixels stand out of
//! the map and carry most of the load, the iteration then never ends.
//!
//! Transforms and gaps are in single precision: a direction need not be better, and gaps under pressure round by ever
//! less as they vanish. What rounding leaves in them is removed by one transform in double precision where the residual
//! nears it and before a state counts as converged. A gap is known up to a constant, which the shift takes out, so that
//! the scaling of the load reaches it as g + (scale - 1) h; pressures take their scale up in the next step.

use slipgrid_topography::fourier::FourierWork;

use crate::area::{ContactArea, contact_area};
use crate::kernels::{Gap, Settling};
use crate::preconditioner::PreconditionerWork;
use crate::rough_contact::{Convergence, RoughContact, SolveOptions, Status};
use crate::{Monitor, kernels};

/// What the solver found, normalized.
pub(crate) struct Outcome {
    pub(crate) pressure: Vec<f64>,
    pub(crate) gap: Vec<f64>,
    pub(crate) convergence: Convergence,
    /// The area when the residual first was within [`AREA_DECADE`] of the tolerance.
    pub(crate) area_before: Option<ContactArea>,
}

/// How far before the end the area is noted, for the estimate of its error.
const AREA_DECADE: f64 = 10.0;
/// Share of the sum of pressures down to which the load is restored by lowering them.
const LEAST_SHARE: f64 = 1e-9;
/// Growth of the residual in one iteration after which directions start anew.
const RESTART_GROWTH: f64 = 2.0;
/// Residual at which the gap is first computed anew in double precision: single precision rounds it by a few 1e-7.
const FIRST_REFRESH: f64 = 1e-5;
/// Part of the residual at one refresh that calls for the next.
const NEXT_REFRESH: f64 = 1e-5;

/// The evolving state, all fields as long as the map.
struct State<'a> {
    contact: &'a RoughContact,
    work: FourierWork<'a>,
    work_single: FourierWork<'a, f32>,
    preconditioner_work: PreconditionerWork,
    fourier_pairs: usize,
    /// p over `scale`.
    pressure: Vec<f64>,
    scale: f64,
    /// The pressures of the best state but this one, over `best_scale`.
    best: Vec<f64>,
    best_scale: f64,
    /// u = K p over `scale` where the state is exact.
    displacement: Vec<f64>,
    /// The gap is that of K p in double precision.
    exact: bool,
    /// g up to a constant.
    gap: Vec<f32>,
    found: Gap,
    /// r, the gap on free points, zero elsewhere and nowhere else.
    residual: Vec<f32>,
    previous_residual: Vec<f32>,
    /// z, before it is masked; later what the pressures changed by.
    preconditioned: Vec<f32>,
    direction: Vec<f32>,
    /// K d, or K of what the pressures changed by.
    image: Vec<f32>,
}

impl<'a> State<'a> {
    fn new(contact: &'a RoughContact, nominal: f64, monitor: &'a dyn Monitor) -> Self {
        let points = contact.height.len();
        let zeros = || vec![0.0; points];
        // All that the surface bears is a change from nothing.
        let pressure = contact.pressed_flat(nominal);
        let mut state = Self {
            contact,
            work: contact.fourier.work_watched(monitor),
            work_single: contact.fourier_single.work_watched(monitor),
            preconditioner_work: contact.preconditioner.work(),
            fourier_pairs: 0,
            preconditioned: pressure.iter().map(|&p| p as f32).collect(),
            pressure,
            scale: 1.0,
            best: Vec::new(),
            best_scale: 1.0,
            displacement: vec![0.0; points],
            exact: false,
            gap: contact.height_single.iter().map(|h| -h).collect(),
            found: Gap { shift: 0.0, lowest: 0.0, work: 0.0 },
            residual: zeros(),
            previous_residual: zeros(),
            direction: zeros(),
            image: zeros(),
        };
        state.follow_changes();
        state.settle(1.0);
        state
    }

    /// image = K of what the pressures changed by.
    fn follow_changes(&mut self) {
        let Self { contact, preconditioned, image, work_single, .. } = self;
        contact.fourier_single.filter(preconditioned, &contact.compliance_single, image, work_single);
        self.fourier_pairs += 1;
    }

    /// g after pressures have changed, where K of that is `share` of the image.
    fn settle(&mut self, share: f64) {
        let change = Settling { shift: self.found.shift, step: share, scale: self.scale };
        self.found = kernels::settle(&mut self.gap, &self.image, &self.contact.height_single, &self.pressure, change);
    }

    /// u = K p and g = u - h less its mean under pressure, in double precision before it is rounded.
    fn refresh(&mut self) {
        let Self { contact, pressure, displacement, work, gap, scale, .. } = self;
        contact.fourier.filter(pressure, &contact.compliance, displacement, work);
        self.found = kernels::measure(pressure, displacement, &contact.height, *scale);
        kernels::gap(gap, displacement, &contact.height, *scale, self.found.shift);
        self.found.shift = 0.0;
        self.fourier_pairs += 1;
        self.exact = true;
    }

    /// z = K^-1 r, about
    fn precondition(&mut self) {
        let Self { contact, residual, preconditioned, preconditioner_work, .. } = self;
        contact.preconditioner.apply(residual, preconditioned, preconditioner_work);
    }

    /// d = -z + beta d; returns r . d.
    fn turn(&mut self, mean: f64, beta: f64) -> f64 {
        kernels::turn(&mut self.direction, &self.preconditioned, &self.residual, mean as f32, beta as f32)
    }

    /// image = K d; returns d . K d.
    fn curvature(&mut self) -> f64 {
        let Self { contact, direction, image, work_single, .. } = self;
        contact.fourier_single.filter(direction, &contact.compliance_single, image, work_single);
        self.fourier_pairs += 1;
        kernels::dot(&self.direction, &self.image)
    }

    /// p + step d without negative pressures, the load restored; g follows. What was before is kept where it is the
    /// best. False where that is not finite.
    fn advance(&mut self, step: f64, load: f64, is_best: bool) -> bool {
        if is_best {
            std::mem::swap(&mut self.pressure, &mut self.best);
            self.best_scale = self.scale;
            self.pressure.resize(self.best.len(), 0.0);
        } else {
            std::mem::swap(&mut self.pressure, &mut self.displacement);
        }
        let Self { pressure, best, displacement, direction, preconditioned, .. } = self;
        let before = if is_best { best } else { displacement };
        let moved = kernels::advance(pressure, before, direction, preconditioned, self.scale, step);
        self.exact = false;
        let (mut sum, mut share) = (moved.sum, step);
        // Differences of pressures know a load that is too small a share of them no longer.
        if moved.clipped && load > LEAST_SHARE * moved.sum {
            sum = kernels::lower(pressure, preconditioned, (sum - load) / moved.count);
        }
        self.scale = load / sum;
        if !self.scale.is_finite() {
            return false;
        }
        if moved.clipped {
            self.follow_changes();
            share = 1.0;
        }
        self.settle(share);
        true
    }
}

/// Solves for the normalized mean pressure `nominal` > 0.
pub(crate) fn minimize(contact: &RoughContact, nominal: f64, options: &SolveOptions, monitor: &dyn Monitor) -> Outcome {
    let mut state = State::new(contact, nominal, monitor);
    let load = nominal * contact.height.len() as f64;
    let mut best_error = f64::INFINITY;
    let mut error_before = f64::INFINITY;
    let mut fit_before = f64::INFINITY;
    let mut refresh_at = FIRST_REFRESH.max(options.tolerance);
    let mut restart = true;
    let mut iterations = 0;
    let mut area_before = None;
    let (status, error) = loop {
        // |sum (g - min g) p| / (sum p Sq), Sq = 1
        let error = ((state.found.work - state.found.lowest * load) / load).abs();
        if error <= refresh_at && !state.exact {
            refresh_at = options.tolerance.max(NEXT_REFRESH * error);
            state.refresh();
            continue;
        }
        if error <= AREA_DECADE * options.tolerance && area_before.is_none() {
            area_before = Some(contact_area(&state.pressure, contact.cols));
        }
        if error <= options.tolerance {
            break (Status::Converged, error);
        }
        if iterations >= options.max_iterations {
            break (Status::IterationLimit, error);
        }
        if monitor.cancelled() {
            break (Status::Cancelled, error);
        }
        let is_best = error < best_error;
        restart |= error > RESTART_GROWTH * error_before;
        error_before = error;

        std::mem::swap(&mut state.residual, &mut state.previous_residual);
        kernels::masked_gap(&mut state.residual, &state.pressure, &state.gap, state.found.shift);
        state.precondition();
        // On large maps the passes from here to the next transform take as long as those before.
        if monitor.cancelled() {
            break (Status::Cancelled, error);
        }
        let fit = kernels::fit(&state.preconditioned, &state.residual, &state.previous_residual);
        // beta = z.(r - r_before) / (z_before.r_before), Polak and Ribiere
        let mut beta = if restart { 0.0 } else { ((fit.now - fit.before) / fit_before).max(0.0) };
        if !beta.is_finite() {
            beta = 0.0;
        }
        fit_before = fit.now;
        let mut slope = state.turn(fit.mean, beta);
        if slope >= 0.0 && beta > 0.0 {
            slope = state.turn(fit.mean, 0.0);
        }
        // alpha = -r.d / d.Kd
        let step = -slope / state.curvature();
        if !(step.is_finite() && step > 0.0) {
            if restart {
                break (Status::Stalled, error);
            }
            restart = true;
            iterations += 1;
            continue;
        }
        restart = false;
        best_error = best_error.min(error);
        if !state.advance(step, load, is_best) {
            break (Status::Stalled, f64::INFINITY);
        }
        iterations += 1;
    };
    // What a filter left undone may look like anything.
    let status = if monitor.cancelled() { Status::Cancelled } else { status };
    finish(state, (status, error, iterations), best_error, area_before)
}

/// The last state, or the best one where the last is worse.
fn finish(
    mut state: State,
    (status, mut error, iterations): (Status, f64, usize),
    best_error: f64,
    area_before: Option<ContactArea>,
) -> Outcome {
    if best_error < error && status != Status::Converged {
        error = best_error;
        std::mem::swap(&mut state.pressure, &mut state.best);
        state.scale = state.best_scale;
        state.exact = false;
    }
    if status == Status::Cancelled {
        let convergence = Convergence { status, iterations, fourier_pairs: state.fourier_pairs, residual: error };
        return Outcome { pressure: Vec::new(), gap: Vec::new(), convergence, area_before: None };
    }
    if !state.exact {
        state.refresh();
    }
    let State { mut pressure, scale, displacement: mut gap, contact, fourier_pairs, .. } = state;
    let mut lowest = f64::INFINITY;
    for (g, h) in gap.iter_mut().zip(&contact.height) {
        *g = scale * *g - h;
        lowest = lowest.min(*g);
    }
    gap.iter_mut().for_each(|g| *g -= lowest);
    pressure.iter_mut().for_each(|p| *p *= scale);
    let convergence = Convergence { status, iterations, fourier_pairs, residual: error };
    Outcome { pressure, gap, convergence, area_before }
}
