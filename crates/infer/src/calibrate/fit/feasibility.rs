//! Checks before the first dynamic run: peaks without information, coefficients out of reach, and run time.

use slipgrid_model::material::Elastic;
use slipgrid_model::springblock::{MAX_EXTENSION_FOR_STDERR, MAX_STEPS, max_run_speed_m_s};

use super::layout::{FRICTION_BOUNDS, Layout, first_guess};
use crate::calibrate::{FitError, Measurement, Problem, flat_sample};

/// Largest ratio of static peak to dynamic friction that the modelled flat sample shows. At 0.64 MPa on the default
/// layer the ratio is 1.03 for mu_s / mu_d = 1.2, 1.4 for 2 and 1.83 for 3, and decreases beyond.
const MAX_PEAK_RATIO: f64 = 2.0;
/// A static peak hardly determines mu_s if it exceeds dynamic friction by less than this fraction. At 0.64 MPa on the
/// default layer the model shows an excess of 0.0016 for mu_s / mu_d = 1 and 0.004 for 1.1, so that the relative error
/// of mu_s is ten times that of the peak or more.
const MIN_EXCESS: f64 = 5e-3;
/// Pairs of the relative excess of the static peak over dynamic friction and the local mu_s / mu_d for which the model
/// shows this excess at 0.64 MPa.
const PEAK_TABLE: [[f64; 2]; 4] = [[0.004, 1.1], [0.03, 1.2], [0.4, 2.0], [0.83, 3.0]];
/// Maximum planned number of time steps for a measurement without a static peak. A run may be extended by the factor
/// `MAX_EXTENSION_FOR_STDERR` until its mean is known, and must not exceed `MAX_STEPS` then.
const MAX_PLANNED_STEPS: u64 = MAX_STEPS / MAX_EXTENSION_FOR_STDERR;
/// Maximum number of time steps in one round: ten of the longest runs, about ten hours.
const MAX_ROUND_STEPS: u64 = 10 * MAX_STEPS;

/// Maximum number of coefficients. Covariance and profiles take a time that grows with the fourth power of this number,
/// half an hour at this limit, and memory that grows with its square.
const MAX_COEFFICIENTS: usize = 250;
/// Range of delta, dynamic over steady friction, for which dynamic runs resemble steady sliding. At 10 Pa and 2 mm/s,
/// where the inertia of the layer exceeds friction, delta is 0.46.
const DELTA_RANGE: [f64; 2] = [0.5, 1.5];

/// Approximate local `mu_s` / `mu_d` for a flat sample with this ratio of static peak to dynamic friction: linear
/// interpolation of the values at 0.64 MPa on the default layer. `None` if the peak does not determine mu_s.
pub fn local_static_over_dynamic(peak_over_dynamic: f64) -> Option<f64> {
    let excess = peak_over_dynamic - 1.0;
    let between = |pair: &[[f64; 2]]| {
        let ([from, low], [to, high]) = (pair[0], pair[1]);
        (excess <= to).then(|| low + (excess - from) / (to - from) * (high - low))
    };
    let [.., [_, highest]] = PEAK_TABLE;
    (excess >= MIN_EXCESS).then(|| PEAK_TABLE.windows(2).find_map(between).unwrap_or(highest))
}

/// Returns [`FitError::NotQuasiStatic`] for the first of `deltas`, dynamic over steady friction, that is outside
/// `DELTA_RANGE`.
pub fn check_deltas(deltas: &[f64]) -> Result<(), FitError> {
    match (1..).zip(deltas).find(|(_, delta)| !(DELTA_RANGE[0]..=DELTA_RANGE[1]).contains(*delta)) {
        Some((number, &delta)) => Err(FitError::NotQuasiStatic { number, delta }),
        None => Ok(()),
    }
}

/// Removes static peaks that exceed dynamic friction by less than `MIN_EXCESS`; returns a warning for each.
pub fn drop_hidden_peaks(problem: &Problem) -> (Problem, Vec<String>) {
    let mut problem = problem.clone();
    let mut notes = Vec::new();
    for number in 0..problem.measurements.len() {
        let measured = problem.measurements[number];
        let Some(peak) = measured.static_peak else { continue };
        if peak.mu < (1.0 + MIN_EXCESS) * measured.mu_dynamic {
            notes.push(left_out_warning(&problem, number, "hardly exceeds dynamic friction"));
            problem.measurements[number].static_peak = None;
        }
    }
    (problem, notes)
}

/// Warning that the static peak of measurement `number`, counted from 0, is not fitted; `why` is the predicate, for
/// example "hardly exceeds dynamic friction".
pub fn left_out_warning(problem: &Problem, number: usize, why: &str) -> String {
    let measured = &problem.measurements[number];
    let peak = measured.static_peak.map_or_else(String::new, |peak| format!(" {:.4} +- {:.4}", peak.mu, peak.std));
    format!(
        "static_mean {}: not determined by the data; its static peak{peak} {why} ({:.4} +- {:.4}) and is not fitted",
        number + 1,
        measured.mu_dynamic,
        measured.mu_dynamic_std
    )
}

/// Returns the first error that is known before the first run, otherwise the number of time steps of every run in the
/// first round.
pub fn check(problem: &Problem) -> Result<Vec<u64>, FitError> {
    let layout = Layout::new(problem);
    let (count, most) = (layout.count, MAX_COEFFICIENTS);
    if count > most {
        return Err(FitError::TooManyCoefficients { count, most });
    }
    check_speeds(&problem.elastic, problem.specimen_area_m2, &problem.measurements)?;
    let most = FRICTION_BOUNDS[1];
    for (measured, number) in problem.measurements.iter().zip(1..) {
        if let Some(peak) = measured.static_peak {
            let ratio = peak.mu / measured.mu_dynamic;
            if ratio > MAX_PEAK_RATIO {
                return Err(FitError::PeakTooHigh { number, ratio, most: MAX_PEAK_RATIO });
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
    let guess = first_guess(problem, &layout);
    let steps = flat_sample::planned_steps(problem, &layout.pairs(problem, &guess)?);
    for ((measured, &steps), number) in problem.measurements.iter().zip(&steps).zip(1..) {
        let most = if measured.static_peak.is_some() { MAX_STEPS } else { MAX_PLANNED_STEPS };
        if steps > most {
            let (steps, most) = (steps as f64, most as f64);
            // A run needs a given travel at any speed, so that steps are proportional to 1/speed.
            let least_m_s = flat_sample::speed_m_s(problem, measured) * steps / most;
            let hours = seconds(problem, steps) / 3600.0;
            return Err(FitError::TooManySteps { number, steps, most, hours, least_m_s });
        }
    }
    let all = steps.iter().fold(0_u64, |sum, steps| sum.saturating_add(*steps));
    if all > MAX_ROUND_STEPS {
        return Err(FitError::TooMuchWork { steps: all as f64, most: MAX_ROUND_STEPS as f64 });
    }
    Ok(steps)
}

/// Refuses `measurements` that are too fast for a dynamic run, based on speed, pressure and elastic constants.
pub fn check_speeds(elastic: &Elastic, area_m2: f64, measurements: &[Measurement]) -> Result<(), FitError> {
    for (measured, number) in measurements.iter().zip(1..) {
        // P = F / A
        let (pressure_pa, speed_m_s) = (measured.force_n / area_m2, measured.speed_m_s);
        let most_m_s = max_run_speed_m_s(elastic, pressure_pa);
        if speed_m_s > most_m_s {
            let modulus_pa = elastic.youngs_modulus_pa();
            // The limit of v is proportional to 1 / sqrt(E).
            let most_modulus_pa = modulus_pa * (most_m_s / speed_m_s).powi(2);
            return Err(FitError::TooFast { number, speed_m_s, pressure_pa, modulus_pa, most_m_s, most_modulus_pa });
        }
    }
    Ok(())
}

/// Approximate number of time steps per second on one core, for a lattice of 20,000 blocks.
const STEPS_PER_SECOND: f64 = 1e4;

/// Approximate time, in seconds, of `steps` time steps of the flat sample on one core.
pub fn seconds(problem: &Problem, steps: f64) -> f64 {
    let blocks = problem.layer.columns() as f64 * problem.layer.rows() as f64;
    steps * (blocks / 2e4) / STEPS_PER_SECOND
}

/// Number of time steps of every dynamic run in the first round. A fit takes two rounds or more, and twice as many
/// steps if static peaks are fitted.
///
/// # Errors
/// [`FitError`], as in [`fit_coefficients`](crate::calibrate::fit_coefficients), for errors that are known before the first run.
pub fn planned_steps(problem: &Problem) -> Result<Vec<u64>, FitError> {
    problem.validate()?;
    check(&drop_hidden_peaks(problem).0)
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
