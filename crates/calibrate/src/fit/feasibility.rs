//! What can be known before the first dynamic run: peaks that say nothing, coefficients out of reach, time it takes.

use slipgrid_material::Elastic;
use slipgrid_springblock::{MAX_EXTENSION_FOR_STDERR, MAX_STEPS, max_run_speed_m_s};

use super::{FRICTION_BOUNDS, Layout, first_guess};
use crate::{FitError, Measurement, Problem, flat_sample};

/// Static peak over dynamic friction beyond which the model of the flat sample has none: at 0.64 MPa on the usual layer
/// it is 1.03 for mu_s / mu_d of 1.2, 1.4 for 2, 1.83 for 3, and falls again beyond.
const MAX_PEAK: f64 = 2.0;
/// Static peak over dynamic friction, less one, below which it says next to nothing of mu_s: at 0.64 MPa on the usual layer
/// the model shows 0.0016 where mu_s / mu_d is 1 and 0.004 where it is 1.1, so that mu_s follows with ten times the peak's
/// own error or more.
const MIN_EXCESS: f64 = 5e-3;
/// Static peak over dynamic friction, less one, and the `mu_s` / `mu_d` of blocks with which the model shows it there.
const PEAKS: [[f64; 2]; 4] = [[0.004, 1.1], [0.03, 1.2], [0.4, 2.0], [0.83, 3.0]];
/// Time steps that the run of a measurement without a static peak is planned for at most: it goes on for up to so many times as long
/// until its mean is known, and would be broken off before.
const MAX_PLANNED: u64 = MAX_STEPS / MAX_EXTENSION_FOR_STDERR;
/// Time steps of one round of dynamic runs at most: ten runs of the longest kind, some ten hours.
const MAX_WORK: u64 = 10 * MAX_STEPS;

/// Coefficients at most: time and memory of their covariance and profiles grow with the fourth and the second power of
/// their number, and reach half an hour here.
const MAX_COEFFICIENTS: usize = 250;
/// Dynamic over steady friction beyond which the two have little to do with one another: at 10 Pa and 2 mm/s, where
/// the inertia of the layer exceeds friction, it is 0.46.
const DELTAS: [f64; 2] = [0.5, 1.5];

/// `mu_s` / `mu_d` of blocks of which a flat sample shows a static peak of so many times its dynamic friction, roughly: as at 0.64 MPa on the
/// usual layer, straight between the points known. `None` where a peak says nothing.
#[must_use]
pub fn local_static_over_dynamic(peak_over_dynamic: f64) -> Option<f64> {
    let excess = peak_over_dynamic - 1.0;
    let between = |pair: &[[f64; 2]]| {
        let ([from, low], [to, high]) = (pair[0], pair[1]);
        (excess <= to).then(|| low + (excess - from) / (to - from) * (high - low))
    };
    let [.., [_, highest]] = PEAKS;
    (excess >= MIN_EXCESS).then(|| PEAKS.windows(2).find_map(between).unwrap_or(highest))
}

/// Refuses dynamic runs that say nothing of steady friction.
pub fn check_deltas(deltas: &[f64]) -> Result<(), FitError> {
    match (1..).zip(deltas).find(|(_, delta)| !(DELTAS[0]..=DELTAS[1]).contains(*delta)) {
        Some((number, &delta)) => Err(FitError::NotQuasiStatic { number, delta }),
        None => Ok(()),
    }
}

/// `problem` without the static peaks that do not exceed dynamic friction, and why.
pub fn without_hidden_peaks(problem: &Problem) -> (Problem, Vec<String>) {
    let mut problem = problem.clone();
    let mut notes = Vec::new();
    for number in 0..problem.measurements.len() {
        let measured = problem.measurements[number];
        let Some(peak) = measured.static_peak else { continue };
        if peak.mu < (1.0 + MIN_EXCESS) * measured.mu_dynamic {
            notes.push(left_out(&problem, number, "hardly exceeds dynamic friction"));
            problem.measurements[number].static_peak = None;
        }
    }
    (problem, notes)
}

/// Says that the static peak of a measurement, from 0, is not used.
pub fn left_out(problem: &Problem, number: usize, why: &str) -> String {
    let measured = &problem.measurements[number];
    let peak = measured.static_peak.map_or_else(String::new, |peak| format!(" {:.4} +- {:.4}", peak.mu, peak.std));
    format!(
        "static_mean {}: not determined by the data; its static peak{peak} {why} ({:.4} +- {:.4}) and is not fitted",
        number + 1,
        measured.mu_dynamic,
        measured.mu_dynamic_std
    )
}

/// Refuses what no run would bring nearer; time steps of the first round's run of every measurement otherwise.
pub fn check(problem: &Problem) -> Result<Vec<u64>, FitError> {
    let (count, most) = (Layout::new(problem).count, MAX_COEFFICIENTS);
    if count > most {
        return Err(FitError::TooManyCoefficients { count, most });
    }
    check_speeds(&problem.elastic, problem.specimen_area_m2, &problem.measurements)?;
    let most = FRICTION_BOUNDS[1];
    for (measured, number) in problem.measurements.iter().zip(1..) {
        if let Some(peak) = measured.static_peak {
            let ratio = peak.mu / measured.mu_dynamic;
            if ratio > MAX_PEAK {
                return Err(FitError::PeakTooHigh { number, ratio, most: MAX_PEAK });
            }
        }
        if let Some(law) = &problem.area_law {
            let factor = law.factor(problem.pressure_pa(measured));
            let mean = measured.mu_dynamic / factor;
            if !mean.is_finite() || mean > most {
                return Err(FitError::BeyondLaw { number, factor, mean, most });
            }
        }
    }
    let layout = Layout::new(problem);
    let guess = first_guess(problem, &layout);
    let steps = flat_sample::planned_steps(problem, &layout.pairs(problem, &guess)?);
    for ((measured, &steps), number) in problem.measurements.iter().zip(&steps).zip(1..) {
        let most = if measured.static_peak.is_some() { MAX_STEPS } else { MAX_PLANNED };
        if steps > most {
            let (steps, most) = (steps as f64, most as f64);
            // Travel is of slips, and slow sliding takes the same travel: steps go with 1/speed.
            let least_m_s = flat_sample::speed_m_s(problem, measured) * steps / most;
            let hours = seconds(problem, steps) / 3600.0;
            return Err(FitError::TooManySteps { number, steps, most, hours, least_m_s });
        }
    }
    let all = steps.iter().fold(0_u64, |sum, steps| sum.saturating_add(*steps));
    if all > MAX_WORK {
        return Err(FitError::TooMuchWork { steps: all as f64, most: MAX_WORK as f64 });
    }
    Ok(steps)
}

/// Refuses `measurements` that are too fast for any run in time: known from speed, pressure and bulk alone.
pub fn check_speeds(elastic: &Elastic, area_m2: f64, measurements: &[Measurement]) -> Result<(), FitError> {
    for (measured, number) in measurements.iter().zip(1..) {
        // P = F / A
        let (pressure_pa, speed_m_s) = (measured.force_n / area_m2, measured.speed_m_s);
        let most_m_s = max_run_speed_m_s(elastic, pressure_pa);
        if speed_m_s > most_m_s {
            let modulus_pa = elastic.youngs_modulus_pa();
            // v goes with 1 / sqrt(E).
            let most_modulus_pa = modulus_pa * (most_m_s / speed_m_s).powi(2);
            return Err(FitError::TooFast { number, speed_m_s, pressure_pa, modulus_pa, most_m_s, most_modulus_pa });
        }
    }
    Ok(())
}

/// Time steps of a lattice of 20,000 blocks in a second on one core, about.
const STEPS_PER_S: f64 = 1e4;

/// Seconds that so many `steps` of the flat sample take on one core, about.
pub fn seconds(problem: &Problem, steps: f64) -> f64 {
    let blocks = problem.layer.columns() as f64 * problem.layer.rows() as f64;
    steps * (blocks / 2e4) / STEPS_PER_S
}

/// Time steps of the first round's dynamic run of every measurement; a fit takes two rounds or more, and twice as many
/// where static peaks are fitted.
///
/// # Errors
/// [`FitError`] as [`fit_coefficients`](crate::fit_coefficients), of all that is known before the first run.
pub fn planned_steps(problem: &Problem) -> Result<Vec<u64>, FitError> {
    problem.validate()?;
    check(&without_hidden_peaks(problem).0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_tell_of_blocks_what_the_model_shows_of_these() {
        let told = |peak: f64| local_static_over_dynamic(peak);
        assert_eq!((told(0.99), told(1.004)), (None, None));
        for [excess, share] in [[0.03, 1.2], [0.4, 2.0], [0.83, 3.0], [1.4, 3.0]] {
            assert!((told(1.0 + excess).unwrap() - share).abs() < 1e-9);
        }
        assert!((told(1.215).unwrap() - 1.6).abs() < 1e-9);
    }
}
