//! Spectral projected gradients: slower than `solver`, but convergent on every surface.
//!
//! The problem is the same as in `solver`, in double precision throughout:
//!
//! ```text
//! minimize  E = p.Kp/2 - p.h   over  p >= 0,  sum p = load
//! ```
//!
//! 1. d = project(p - t g) - p with the gap g = Kp - h; `project` finds the nearest feasible pressures;
//! 2. p + s d with s = 1, or with the s of least energy where s = 1 would exceed the highest recent energy;
//! 3. t from the curvature along d.
//!
//! E. G. Birgin, J. M. Martínez and M. Raydan, SIAM J. Optim. 10, 1196 (2000), prove convergence from any start. E is
//! quadratic, so that one pair of transforms, K d, gives the energy at every s and the next gap. The step lengths t are
//! those of J. Barzilai and J. M. Borwein, IMA J. Numer. Anal. 8, 141 (1988), selected by the rule of G. Frassoldati,
//! L. Zanni and G. Zanghirati, J. Ind. Manag. Optim. 4, 299 (2008). Surfaces on which conjugate gradients fail take
//! about 100 iterations; pixels of 1 x 20 take up to 800.

use std::collections::VecDeque;

use crate::topography::fourier::FourierWork;

use crate::contact::area::{ContactArea, contact_area};
use crate::contact::kernels::{GapStatistics, measure_gap, sum_positive};
use crate::contact::rough_contact::{Convergence, RoughContact, SolveOptions};
use crate::contact::solver::{AREA_DECADE, Failure, Outcome, lower_to_mean, relative_error};
use crate::contact::{Monitor, kernels};

/// Number of recent energies among which the highest bounds the next one: 10 as in the paper of Birgin, Martínez and
/// Raydan.
const ENERGY_MEMORY: usize = 10;
/// Fraction of the decrease of energy predicted by the gradient that a step must reach.
const SUFFICIENT_DECREASE: f64 = 1e-4;
/// The shorter of the two Barzilai-Borwein step lengths is used if it is below this share of the longer one. Shares of
/// 0.3 to 0.8 need the same number of iterations within a tenth.
const SHORT_STEP_SHARE: f64 = 0.5;
/// Number of recent short step lengths that are stored; if a short step length is used, it is the smallest of these.
const STEP_MEMORY: usize = 6;
/// Maximum number of Newton steps for the level c of a projection max(v + c, 0); about five are needed.
const MAX_LEVEL_STEPS: usize = 100;

struct State<'a> {
    contact: &'a RoughContact<'a>,
    work: FourierWork<'a>,
    fourier_pairs: usize,
    load: f64,
    pressure: Vec<f64>,
    /// Displacement u = K p.
    displacement: Vec<f64>,
    gap: GapStatistics,
    direction: Vec<f64>,
    /// Displacement K d that belongs to the direction d.
    image: Vec<f64>,
    /// Level c of the last projection, which replaced values v by max(v + c, 0).
    level: f64,
    step_length: f64,
    recent_short_lengths: VecDeque<f64>,
    /// Decreases of the energy in recent iterations, latest first.
    recent_decreases: VecDeque<f64>,
}

impl State<'_> {
    /// Computes the displacement u = K p and the gap statistics.
    fn refresh(&mut self) {
        self.contact.displace(&self.pressure, &mut self.displacement, &mut self.work);
        self.fourier_pairs += 1;
        self.gap = measure_gap(&self.pressure, &self.displacement, self.contact.heights);
    }

    /// Computes the direction d = project(p - t g) - p from the gap g with the step length t.
    fn find_direction(&mut self) {
        let Self { contact, load, pressure, displacement, direction, level, step_length, .. } = self;
        for (((d, p), u), h) in direction.iter_mut().zip(&*pressure).zip(&*displacement).zip(contact.heights.iter()) {
            *d = p - *step_length * (u - h);
        }
        *level = project(direction, *load, *level);
        direction.iter_mut().zip(&*pressure).for_each(|(d, p)| *d -= p);
    }

    /// Does one iteration; returns false if rounding leaves no descent direction.
    fn advance(&mut self) -> bool {
        self.find_direction();
        let Self { contact, work, pressure, displacement, direction, image, .. } = self;
        contact.displace(direction, image, work);
        self.fourier_pairs += 1;
        // Since d has the sum zero, a constant added to the gap changes nothing; this constant keeps the products
        // small.
        let shift = self.level / self.step_length;
        let mut sums = Sums::default();
        for (((d, k), u), h) in direction.iter().zip(&*image).zip(&*displacement).zip(contact.heights.iter()) {
            sums.add(*d, *k, u - h - shift);
        }
        if !(sums.slope < 0.0 && sums.d_kd > 0.0) {
            return false;
        }
        let allowed_rise = self.recent_decreases.iter().scan(0.0, |above, decrease| {
            *above += decrease;
            Some(*above)
        });
        let allowed_rise = allowed_rise.fold(0.0, f64::max) + SUFFICIENT_DECREASE * sums.slope;
        let is_accepted = sums.slope + 0.5 * sums.d_kd <= allowed_rise;
        let step = if is_accepted { 1.0 } else { (-sums.slope / sums.d_kd).min(1.0) };
        pressure.iter_mut().zip(&*direction).for_each(|(p, d)| *p = (*p + step * d).max(0.0));
        displacement.iter_mut().zip(&*image).for_each(|(u, k)| *u += step * k);
        self.gap = measure_gap(pressure, displacement, contact.heights);
        push_recent(&mut self.recent_decreases, -step * (sums.slope + 0.5 * step * sums.d_kd), ENERGY_MEMORY);
        self.update_step_length(&sums);
        true
    }

    /// Sets the step length to d.d / d.Kd. If the latest short length, d.Kd / Kd.Kd with the mean of K d removed, is
    /// below [`SHORT_STEP_SHARE`] of this, sets the smallest recent short length instead.
    fn update_step_length(&mut self, sums: &Sums) {
        let long = sums.d_d / sums.d_kd;
        let short = sums.d_kd / (sums.kd_kd - sums.kd * sums.kd / sums.moved);
        push_recent(&mut self.recent_short_lengths, short, STEP_MEMORY);
        let is_short = short < SHORT_STEP_SHARE * long;
        let next =
            if is_short { self.recent_short_lengths.iter().copied().fold(f64::INFINITY, f64::min) } else { long };
        if next.is_finite() && next > 0.0 {
            self.step_length = next;
        }
    }
}

fn push_recent(values: &mut VecDeque<f64>, value: f64, memory: usize) {
    values.push_front(value);
    values.truncate(memory);
}

/// Scalar products of a direction d, its image K d and the gap.
#[derive(Default)]
struct Sums {
    slope: f64,
    d_d: f64,
    d_kd: f64,
    /// Scalar product of K d with itself over the points where d is not zero.
    kd_kd: f64,
    /// Sum of K d over the points where d is not zero.
    kd: f64,
    /// Number of points where d is not zero.
    moved: f64,
}

impl Sums {
    fn add(&mut self, d: f64, kd: f64, gap: f64) {
        if d != 0.0 {
            self.slope += d * gap;
            self.d_d += d * d;
            self.d_kd += d * kd;
            self.kd_kd += kd * kd;
            self.kd += kd;
            self.moved += 1.0;
        }
    }
}

/// Replaces the values v by the nearest nonnegative values with the sum `load` > 0, which are max(v + c, 0). Returns c;
/// the search for c begins at `start`.
fn project(values: &mut [f64], load: f64, start: f64) -> f64 {
    let highest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut level = start;
    // The sum is convex in c: after at most one step from below, Newton's iterates descend monotonically to the root.
    for _ in 0..MAX_LEVEL_STEPS {
        let sums = sum_positive(values, level, 1);
        let next = if sums.count > 0.0 { level - (sums.sum - load) / sums.count } else { load - highest };
        if next == level {
            break;
        }
        level = next;
    }
    let mut sum = 0.0;
    for value in values.iter_mut() {
        *value = (*value + level).max(0.0);
        sum += *value;
    }
    // A load far below the size of the values is lost in rounding.
    if sum > 0.0 {
        values.iter_mut().for_each(|value| *value *= load / sum);
    } else if let Some(value) = values.iter_mut().max_by(|a, b| a.total_cmp(b)) {
        *value = load;
    }
    level
}

/// Solves the contact problem at the normalized mean pressure `nominal` > 0. The counts of iterations and of Fourier
/// pairs continue from those that conjugate gradients spent; the four fields are buffers as long as the map.
pub(crate) fn minimize(
    contact: &RoughContact<'_>,
    nominal: f64,
    options: &SolveOptions,
    monitor: &dyn Monitor,
    (mut iterations, fourier_pairs): (usize, usize),
    [mut pressure, displacement, mut direction, mut image]: [Vec<f64>; 4],
) -> Result<Outcome, Failure> {
    let mut work = contact.fourier.work_watched(monitor);
    contact.flatten(&mut direction, &mut image, &mut work);
    lower_to_mean(&image, nominal, &mut pressure);
    let mut state = State {
        contact,
        work,
        fourier_pairs,
        load: nominal * pressure.len() as f64,
        pressure,
        displacement,
        gap: GapStatistics { shift: 0.0, lowest: 0.0, work: 0.0 },
        direction,
        image,
        level: 0.0,
        step_length: contact.preconditioner.centre(),
        recent_short_lengths: VecDeque::new(),
        recent_decreases: VecDeque::new(),
    };
    state.refresh();
    let mut is_exact = true;
    let mut area_before: Option<ContactArea> = None;
    let residual = loop {
        if monitor.cancelled() {
            return Err(Failure::Cancelled);
        }
        let sum = kernels::sum_positive(&state.pressure, 0.0, 1).sum;
        let error = relative_error(&state.gap, sum, state.load);
        if error <= AREA_DECADE * options.tolerance && area_before.is_none() {
            area_before = Some(contact_area(&state.pressure, contact.cols));
        }
        // The incremental update of the displacement accumulates rounding errors, so recompute before accepting.
        if error <= options.tolerance && !is_exact {
            state.refresh();
            is_exact = true;
            continue;
        }
        if error <= options.tolerance {
            break error;
        }
        if iterations >= options.max_iterations || !state.advance() {
            return Err(Failure::NotConverged { iterations, residual: error });
        }
        is_exact = false;
        iterations += 1;
    };
    let State { pressure, displacement, fourier_pairs, .. } = state;
    let convergence = Convergence { iterations, fourier_pairs, residual };
    Ok(Outcome { pressure, displacement, convergence, area_before })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_projection_keeps_the_load_and_lowers_all_alike() {
        for load in [1e-30, 0.3, 5.0, 1e6] {
            for start in [-1e3, 0.0, 1e3] {
                let values = [3.0, -1.0, 2.5, 0.0, 2.9];
                let mut projected = values;
                project(&mut projected, load, start);
                let sum: f64 = projected.iter().sum();
                assert!(
                    (sum / load - 1.0).abs() < 1e-12 && projected.iter().all(|p| *p >= 0.0),
                    "{load}: {projected:?}"
                );
                let lowered: Vec<f64> =
                    projected.iter().zip(values).filter(|(p, _)| **p > 0.0).map(|(p, v)| p - v).collect();
                assert!(lowered.iter().all(|l| (l - lowered[0]).abs() < 1e-9 * load.max(1.0)), "{load}: {projected:?}");
            }
        }
    }
}
