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
//! Here directions are preconditioned by K's inverse, masked to the points that are free to move, which
//! makes the number of iterations nearly independent of the grid:
//!
//! 1. gap g = Kp - h, shifted so that its mean over p > 0 is zero; free points: p > 0 or g < 0;
//! 2. r = g on free points; z = K^-1 r on free points, less its mean there;
//! 3. d = -z + beta d on free points, Polak-Ribiere; d = -z again where d would not descend or the residual
//!    doubled;
//! 4. p + alpha d with the exact step alpha; negative pressures to zero, the load restored by scaling.

use slipgrid_topography::fourier::{FourierWork, Multiplier};

use crate::area::{ContactArea, contact_area};
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

/// Growth of the residual in one iteration after which directions start anew.
const RESTART_GROWTH: f64 = 2.0;
/// A state is kept as the best when it halves the residual of the best so far: keeping every one would
/// copy the map in each iteration.
const BEST_RATIO: f64 = 0.5;

/// The evolving state, all fields as long as the map.
struct State<'a> {
    contact: &'a RoughContact,
    work: FourierWork,
    fourier_pairs: usize,
    pressure: Vec<f64>,
    /// u = K p.
    displacement: Vec<f64>,
    /// r, the gap on free points, zero elsewhere.
    residual: Vec<f64>,
    previous_residual: Vec<f64>,
    /// z, before it is masked.
    preconditioned: Vec<f64>,
    direction: Vec<f64>,
    /// K d.
    image: Vec<f64>,
}

impl<'a> State<'a> {
    fn new(contact: &'a RoughContact, nominal: f64) -> Self {
        let zero = || vec![0.0; contact.height.len()];
        Self {
            contact,
            work: contact.fourier.work(),
            fourier_pairs: 0,
            pressure: vec![nominal; contact.height.len()],
            displacement: zero(),
            residual: zero(),
            previous_residual: zero(),
            preconditioned: zero(),
            direction: zero(),
            image: zero(),
        }
    }
}

/// `output` = `multiplier` applied to `input`.
macro_rules! apply {
    ($state:ident, $multiplier:ident, $input:ident, $output:ident) => {{
        let multiplier: &Multiplier = &$state.contact.$multiplier;
        $state.contact.fourier.filter(&$state.$input, multiplier, &mut $state.$output, &mut $state.work);
        $state.fourier_pairs += 1;
    }};
}

/// Solves for the normalized mean pressure `nominal` > 0.
pub(crate) fn minimize(contact: &RoughContact, nominal: f64, options: &SolveOptions, monitor: &dyn Monitor) -> Outcome {
    let mut state = State::new(contact, nominal);
    let points = contact.height.len() as f64;
    let load = nominal * points;
    let mut best = (f64::INFINITY, Vec::new());
    let mut error_before = f64::INFINITY;
    let mut fit_before = f64::INFINITY;
    let mut restart = true;
    let mut iterations = 0;
    let mut area_before = None;
    let (status, error) = loop {
        let gap = kernels::measure(&state.pressure, &state.displacement, &contact.height);
        // |sum (g - min g) p| / (sum p Sq), Sq = 1
        let error = ((gap.work - gap.lowest * load) / load).abs();
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
        if error < BEST_RATIO * best.0 {
            best.0 = error;
            best.1.clone_from(&state.pressure);
        }
        restart |= error > RESTART_GROWTH * error_before;
        error_before = error;

        std::mem::swap(&mut state.residual, &mut state.previous_residual);
        kernels::masked_gap(&mut state.residual, &state.pressure, &state.displacement, &contact.height, gap.shift);
        apply!(state, stiffness, residual, preconditioned);
        let fit = kernels::fit(&state.preconditioned, &state.residual, &state.previous_residual, &state.pressure);
        // beta = z.(r - r_before) / (z_before.r_before), Polak and Ribiere
        let mut beta = if restart { 0.0 } else { ((fit.now - fit.before) / fit_before).max(0.0) };
        if !beta.is_finite() {
            beta = 0.0;
        }
        fit_before = fit.now;
        let turn = |beta: f64, state: &mut State| {
            kernels::turn(&mut state.direction, &state.preconditioned, &state.residual, &state.pressure, fit.mean, beta)
        };
        let mut slope = turn(beta, &mut state);
        if slope >= 0.0 && beta > 0.0 {
            slope = turn(0.0, &mut state);
        }
        apply!(state, compliance, direction, image);
        let curvature = kernels::dot(&state.direction, &state.image);
        // alpha = -r.d / d.Kd
        let step = -slope / curvature;
        if !(step.is_finite() && step > 0.0) {
            if restart {
                break (Status::Stalled, error);
            }
            restart = true;
            iterations += 1;
            continue;
        }
        restart = false;
        let moved =
            kernels::advance(&mut state.pressure, &mut state.displacement, &state.direction, &state.image, step);
        let scale = load / moved.sum;
        if !scale.is_finite() {
            break (Status::Stalled, error);
        }
        kernels::scale(&mut state.pressure, scale);
        if moved.clipped {
            apply!(state, compliance, pressure, displacement);
        } else {
            kernels::scale(&mut state.displacement, scale);
        }
        iterations += 1;
    };
    Outcome { area_before, ..finish(state, status, error, iterations, best) }
}

/// The last state, or the best one where the last is worse.
fn finish(mut state: State, status: Status, mut error: f64, iterations: usize, best: (f64, Vec<f64>)) -> Outcome {
    if best.0 < error && status != Status::Converged {
        error = best.0;
        state.pressure = best.1;
        apply!(state, compliance, pressure, displacement);
    }
    let State { pressure, displacement: mut gap, contact, fourier_pairs, .. } = state;
    let mut lowest = f64::INFINITY;
    for (g, h) in gap.iter_mut().zip(&contact.height) {
        *g -= h;
        lowest = lowest.min(*g);
    }
    gap.iter_mut().for_each(|g| *g -= lowest);
    Outcome {
        pressure,
        gap,
        convergence: Convergence { status, iterations, fourier_pairs, residual: error },
        area_before: None,
    }
}
