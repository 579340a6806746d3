//! The fit itself.

use argmin::core::Error;
use slipgrid_material::LocalFriction;
use slipgrid_springblock::{Monitor, Unwatched};

use crate::flat::{self, DynamicFlat, Pairs, Portion};
use crate::least_squares::{LeastSquares, Solution};
use crate::{CalibrationError, Coefficients, Problem, StaticPeak};

/// Rounds of fit and dynamic runs at most. delta hardly depends on the coefficients: the second round
/// confirms the first.
const MOST_ROUNDS: usize = 6;
/// Change of the coefficients between rounds below which they are settled, relative; three standard
/// errors of the dynamic runs where those are larger.
const SETTLED: f64 = 5e-4;
/// Relative step of mu_s that finds how the static peak follows it: large against the noise of a
/// peak (1e-3), small against the range in which the peak is nearly linear.
const STATIC_STEP: f64 = 0.05;

/// Fitted coefficients: of one measurement, or of all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedPair {
    /// Mean local static coefficient.
    pub static_mean: f64,
    /// Its standard error; `None` where it was assumed, not fitted.
    pub static_std_error: Option<f64>,
    /// Mean local dynamic coefficient.
    pub dynamic_mean: f64,
    /// Its standard error, from the measurements' standard deviations and those of the dynamic runs.
    pub dynamic_std_error: f64,
}

/// What was fitted to one measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Dynamic mu of the flat sample by the model at the fitted coefficients.
    pub mu_dynamic: f64,
    /// Model minus measurement.
    pub residual: f64,
    /// delta: dynamic over steady friction.
    pub dynamic_over_steady: f64,
    /// Standard error of the dynamic run behind delta, relative.
    pub relative_stderr: f64,
}

/// What a fit found.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// One pair for all measurements, or one each.
    pub pairs: Vec<FittedPair>,
    /// One per measurement.
    pub predictions: Vec<Prediction>,
    /// Sum of squared residuals in standard deviations.
    pub chi_square: f64,
    /// Measured numbers less fitted ones.
    pub degrees_of_freedom: usize,
    /// delta settled within the rounds allowed.
    pub settled: bool,
    /// How values were obtained, what was assumed, what stays undetermined; one sentence each.
    pub notes: Vec<String>,
}

/// How parameters map to measurements: parameter numbers of mu_d and, where fitted, mu_s.
struct Layout {
    dynamic: Vec<usize>,
    fixed_static: Vec<Option<usize>>,
    count: usize,
}

impl Layout {
    fn new(problem: &Problem) -> Self {
        let measured = &problem.measurements;
        let groups = match problem.coefficients {
            Coefficients::Single => 1,
            Coefficients::PerCondition => measured.len(),
        };
        let group_of = |i: usize| if groups == 1 { 0 } else { i };
        let mut count = groups;
        let mut of_group = vec![None; groups];
        for (i, measured) in measured.iter().enumerate() {
            if measured.static_peak.is_some() && of_group[group_of(i)].is_none() {
                of_group[group_of(i)] = Some(count);
                count += 1;
            }
        }
        Self {
            dynamic: (0..measured.len()).map(group_of).collect(),
            fixed_static: (0..measured.len()).map(|i| of_group[group_of(i)]).collect(),
            count,
        }
    }

    /// Local coefficients at measurement `i`.
    fn pair(&self, problem: &Problem, parameters: &[f64], i: usize) -> Result<LocalFriction, CalibrationError> {
        let dynamic_mean = parameters[self.dynamic[i]];
        let static_mean =
            self.fixed_static[i].map_or(problem.static_over_dynamic * dynamic_mean, |number| parameters[number]);
        Ok(LocalFriction::new(static_mean, dynamic_mean, problem.relative_std)?)
    }

    fn pairs(&self, problem: &Problem, parameters: &[f64]) -> Result<Pairs, CalibrationError> {
        (0..self.dynamic.len()).map(|i| self.pair(problem, parameters, i)).collect()
    }
}

/// Dynamic runs relative to what the fit can compute at once.
struct Corrections {
    /// Dynamic over steady friction.
    delta: Vec<f64>,
    relative_stderr: Vec<f64>,
    /// How the static peak follows the local coefficient, where a peak was measured.
    peaks: Vec<Option<PeakLine>>,
}

/// The static peak near the current coefficients: peak = at_current + slope (mu_s - current).
#[derive(Clone, Copy, Debug)]
struct PeakLine {
    at_current: f64,
    slope: f64,
    current: f64,
}

/// Fits local coefficients to `problem`.
///
/// # Errors
/// [`CalibrationError`] if a number has no meaning, the flat sample does not slide in the model, or the
/// monitor asks to stop.
pub fn calibrate(problem: &Problem, monitor: &dyn Monitor) -> Result<Fit, CalibrationError> {
    problem.validate()?;
    let layout = Layout::new(problem);
    let mut parameters = first_guess(problem, &layout);
    let mut corrections = None;
    let mut settled = false;
    let mut solution: Option<Solution> = None;
    // Progress counts on the usual two rounds of dynamic runs.
    let portion = Portion { whole: monitor, share: 0.5 };
    for _ in 0..MOST_ROUNDS {
        let found = correct(problem, &layout, &parameters, &portion)?;
        let fitted = fit_with(problem, &layout, &found, &parameters)?;
        let noise = found.relative_stderr.iter().copied().fold(0.0, f64::max);
        settled = solution.as_ref().is_some_and(|before| {
            let same = |(a, b): (&f64, &f64)| (a / b - 1.0).abs() < SETTLED.max(3.0 * noise);
            before.parameters.iter().zip(&fitted.parameters).all(same)
        });
        parameters.clone_from(&fitted.parameters);
        solution = Some(fitted);
        corrections = Some(found);
        if settled {
            break;
        }
    }
    let (Some(solution), Some(corrections)) = (solution, corrections) else {
        return Err(CalibrationError::NoMeasurement);
    };
    report(problem, &layout, &solution, &corrections, settled)
}

/// mu_d = measured / f(P), averaged over what shares a parameter.
fn first_guess(problem: &Problem, layout: &Layout) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); layout.count];
    for (i, measured) in problem.measurements.iter().enumerate() {
        let factor = problem.area_law.as_ref().map_or(1.0, |law| law.factor(measured.pressure_pa));
        let mut add = |number: usize, mu: f64| {
            sums[number].0 += mu / factor;
            sums[number].1 += 1.0;
        };
        add(layout.dynamic[i], measured.mu_dynamic);
        if let (Some(number), Some(peak)) = (layout.fixed_static[i], measured.static_peak) {
            add(number, peak.mu);
        }
    }
    sums.into_iter().map(|(sum, count): (f64, f64)| sum / count.max(1.0)).collect()
}

fn correct(
    problem: &Problem,
    layout: &Layout,
    parameters: &[f64],
    monitor: &dyn Monitor,
) -> Result<Corrections, CalibrationError> {
    let pairs = layout.pairs(problem, parameters)?;
    let steady = flat::steady(problem, &pairs)?;
    let dynamic: Vec<DynamicFlat> = flat::dynamic(problem, &pairs, monitor)?;
    let peaks = peak_lines(problem, &pairs, &dynamic)?;
    Ok(Corrections {
        delta: dynamic.iter().zip(&steady).map(|(d, s)| d.mu_dynamic / s).collect(),
        relative_stderr: dynamic.iter().map(|d| d.stderr / d.mu_dynamic).collect(),
        peaks,
    })
}

/// The slope of every measured static peak, by runs at slightly larger mu_s.
fn peak_lines(
    problem: &Problem,
    pairs: &Pairs,
    dynamic: &[DynamicFlat],
) -> Result<Vec<Option<PeakLine>>, CalibrationError> {
    if dynamic.iter().all(|d| d.mu_static.is_none()) {
        return Ok(vec![None; dynamic.len()]);
    }
    let raised: Pairs = pairs
        .iter()
        .map(|pair| {
            LocalFriction::new(pair.static_mean() * (1.0 + STATIC_STEP), pair.dynamic_mean(), pair.relative_std())
        })
        .collect::<Result<_, _>>()?;
    let moved = flat::dynamic(problem, &raised, &Unwatched)?;
    Ok(dynamic
        .iter()
        .zip(&moved)
        .zip(pairs)
        .map(|((here, there), pair)| {
            let (at_current, raised) = (here.mu_static?, there.mu_static?);
            let current = pair.static_mean();
            Some(PeakLine { at_current, slope: (raised - at_current) / (STATIC_STEP * current), current })
        })
        .collect())
}

fn fit_with(
    problem: &Problem,
    layout: &Layout,
    corrections: &Corrections,
    start: &[f64],
) -> Result<Solution, CalibrationError> {
    let peaks: Vec<(usize, PeakLine, StaticPeak)> = (0..problem.measurements.len())
        .filter_map(|i| Some((layout.fixed_static[i]?, corrections.peaks[i]?, problem.measurements[i].static_peak?)))
        .collect();
    let mut depends_on: Vec<Vec<usize>> = layout.dynamic.iter().map(|&number| vec![number]).collect();
    depends_on.extend(peaks.iter().map(|(number, _, _)| vec![*number]));
    let residuals = |parameters: &[f64]| -> Result<Vec<f64>, Error> {
        let pairs = layout.pairs(problem, parameters)?;
        let steady = flat::steady(problem, &pairs)?;
        let mut residuals: Vec<f64> = problem
            .measurements
            .iter()
            .zip(steady.iter().zip(&corrections.delta))
            // [delta steady - measured] / std
            .map(|(measured, (steady, delta))| (delta * steady - measured.mu_dynamic) / measured.mu_dynamic_std)
            .collect();
        for (number, line, peak) in &peaks {
            let modelled = line.at_current + line.slope * (parameters[*number] - line.current);
            residuals.push((modelled - peak.mu) / peak.std);
        }
        Ok(residuals)
    };
    LeastSquares::new(residuals, depends_on).solve(start.to_vec()).map_err(|error| {
        error.downcast::<CalibrationError>().unwrap_or(CalibrationError::OutOfRange {
            quantity: "coefficient",
            value: f64::NAN,
            expected: "measurements that determine it",
        })
    })
}

fn report(
    problem: &Problem,
    layout: &Layout,
    solution: &Solution,
    corrections: &Corrections,
    settled: bool,
) -> Result<Fit, CalibrationError> {
    let count = problem.measurements.len();
    let pairs_per_fit = match problem.coefficients {
        Coefficients::Single => 1,
        Coefficients::PerCondition => count,
    };
    let pairs = (0..pairs_per_fit)
        .map(|i| {
            let pair = layout.pair(problem, &solution.parameters, i)?;
            // One draw of coefficients serves all runs: their errors are not averaged away.
            let of_runs = pair.dynamic_mean() * corrections.relative_stderr[i];
            Ok(FittedPair {
                static_mean: pair.static_mean(),
                static_std_error: layout.fixed_static[i].map(|number| solution.standard_errors[number]),
                dynamic_mean: pair.dynamic_mean(),
                dynamic_std_error: solution.standard_errors[layout.dynamic[i]].hypot(of_runs),
            })
        })
        .collect::<Result<Vec<FittedPair>, CalibrationError>>()?;
    let predictions = (0..count)
        .map(|i| {
            let measured = &problem.measurements[i];
            let residual = solution.residuals[i] * measured.mu_dynamic_std;
            Prediction {
                mu_dynamic: measured.mu_dynamic + residual,
                residual,
                dynamic_over_steady: corrections.delta[i],
                relative_stderr: corrections.relative_stderr[i],
            }
        })
        .collect();
    let chi_square = solution.residuals.iter().map(|r| r * r).sum();
    let degrees_of_freedom = solution.residuals.len().saturating_sub(layout.count);
    Ok(Fit {
        pairs,
        predictions,
        chi_square,
        degrees_of_freedom,
        settled,
        notes: notes(problem, layout, corrections, chi_square, degrees_of_freedom, settled),
    })
}

fn notes(
    problem: &Problem,
    layout: &Layout,
    corrections: &Corrections,
    chi_square: f64,
    degrees_of_freedom: usize,
    settled: bool,
) -> Vec<String> {
    let least = corrections.delta.iter().copied().fold(f64::INFINITY, f64::min);
    let most = corrections.delta.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut notes = vec![format!(
        "dynamic_mean: fitted through the spring-block model of the flat sample; dynamic friction lies {:.2} to {:.2} % above steady sliding, and the fit corrects for it",
        (least - 1.0) * 100.0,
        (most - 1.0) * 100.0
    )];
    if layout.fixed_static.iter().any(Option::is_none) {
        notes.push(format!(
            "static_mean: not determined by the data where no static peak was measured; static_mean / dynamic_mean = {:.4} is assumed. A measured peak of friction at the onset of sliding would settle it",
            problem.static_over_dynamic
        ));
    }
    notes.push(format!(
        "relative_std: not determined by means of friction; {} is assumed. The spread of onset events in a trace would settle it",
        problem.relative_std
    ));
    if degrees_of_freedom > 0 {
        notes.push(format!(
            "chi-square {chi_square:.1} for {degrees_of_freedom} degrees of freedom{}",
            if chi_square > 3.0 * degrees_of_freedom as f64 {
                ": one pair of coefficients does not describe these measurements; fit coefficients per condition"
            } else {
                ""
            }
        ));
    }
    if !settled {
        notes.push(format!("the coefficients still changed by more than {SETTLED} after {MOST_ROUNDS} rounds"));
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Measurement;
    use slipgrid_material::{AreaLaw, Elastic};
    use slipgrid_springblock::Layer;

    /// A short specimen, so that dynamic runs take milliseconds.
    fn problem(coefficients: Coefficients) -> Problem {
        Problem {
            elastic: Elastic::new(0.38e9, 900.0).unwrap(),
            area_law: Some(AreaLaw::new(vec![0.7e6, 2.6e6, 10e6], vec![1.0, 0.8, 0.3]).unwrap()),
            layer: Layer { length_m: 500e-6, height_m: 40e-6, block_m: 10e-6 },
            measurements: [0.637e6, 1.273e6, 2.546e6]
                .map(|pressure_pa| Measurement {
                    pressure_pa,
                    speed_m_s: 2e-3,
                    mu_dynamic: 0.2,
                    mu_dynamic_std: 0.002,
                    static_peak: None,
                })
                .to_vec(),
            coefficients,
            relative_std: 0.05,
            static_over_dynamic: 1.1,
            seed: 3,
        }
    }

    /// What the model itself gives for known coefficients, as measurements.
    fn measured_by_the_model(problem: &mut Problem, dynamic_mean: f64, with_peaks: bool) {
        let pair = LocalFriction::new(1.1 * dynamic_mean, dynamic_mean, problem.relative_std).unwrap();
        if with_peaks {
            for measured in &mut problem.measurements {
                measured.static_peak = Some(StaticPeak { mu: 1.0, std: 0.005 });
            }
        }
        let pairs = vec![pair; problem.measurements.len()];
        let found = flat::dynamic(problem, &pairs, &Unwatched).unwrap();
        for (measured, found) in problem.measurements.iter_mut().zip(&found) {
            measured.mu_dynamic = found.mu_dynamic;
            measured.static_peak = measured.static_peak.map(|peak| StaticPeak { mu: found.mu_static.unwrap(), ..peak });
        }
    }

    #[test]
    fn coefficients_behind_the_models_own_data_are_recovered() {
        for coefficients in [Coefficients::Single, Coefficients::PerCondition] {
            let mut problem = problem(coefficients);
            measured_by_the_model(&mut problem, 0.25, false);
            let fit = calibrate(&problem, &Unwatched).unwrap();
            assert_eq!(fit.pairs.len(), if coefficients == Coefficients::Single { 1 } else { 3 });
            for pair in &fit.pairs {
                // A short specimen gives delta to about 1e-3.
                let noise = fit.predictions.iter().map(|p| p.relative_stderr).fold(0.0, f64::max);
                assert!((pair.dynamic_mean / 0.25 - 1.0).abs() < 4.0 * noise && noise < 2e-3, "{pair:?} {noise}");
                assert!(pair.static_std_error.is_none());
            }
            assert!(fit.settled && fit.notes.iter().any(|note| note.contains("static_mean: not determined")));
        }
    }

    #[test]
    fn standard_errors_follow_from_the_measured_ones() {
        let mut problem = problem(Coefficients::PerCondition);
        measured_by_the_model(&mut problem, 0.25, false);
        let fit = calibrate(&problem, &Unwatched).unwrap();
        for (pair, measured) in fit.pairs.iter().zip(&problem.measurements) {
            // mu is nearly proportional to mu_d: equal relative errors.
            let relative = pair.dynamic_std_error / pair.dynamic_mean / (measured.mu_dynamic_std / measured.mu_dynamic);
            assert!((relative - 1.0).abs() < 0.05, "{relative}");
        }
        assert_eq!(fit.degrees_of_freedom, 0);
    }

    #[test]
    fn a_measured_static_peak_determines_the_static_coefficient() {
        let mut problem = problem(Coefficients::Single);
        measured_by_the_model(&mut problem, 0.25, true);
        problem.static_over_dynamic = 2.0; // not used: every measurement has its peak
        let fit = calibrate(&problem, &Unwatched).unwrap();
        let pair = fit.pairs[0];
        // The peak follows mu_s with a slope well below one: its error is larger than the peak's own.
        let error = pair.static_std_error.unwrap();
        assert!(error > 0.005 / 3.0_f64.sqrt() && error < 0.03, "{pair:?}");
        assert!((pair.static_mean - 0.275).abs() < 2.0 * error, "{pair:?}");
        assert!((pair.dynamic_mean / 0.25 - 1.0).abs() < 0.01, "{pair:?}");
    }

    #[test]
    fn loads_that_one_pair_cannot_describe_show_in_chi_square() {
        let mut problem = problem(Coefficients::Single);
        measured_by_the_model(&mut problem, 0.25, false);
        for (measured, factor) in problem.measurements.iter_mut().zip([0.9, 1.0, 1.1]) {
            measured.mu_dynamic *= factor;
        }
        let fit = calibrate(&problem, &Unwatched).unwrap();
        assert!(fit.chi_square > 50.0 && fit.degrees_of_freedom == 2);
        assert!(fit.notes.iter().any(|note| note.contains("one pair of coefficients does not describe")));
    }

    #[test]
    fn measurements_without_meaning_are_refused() {
        let mut problem = problem(Coefficients::Single);
        problem.measurements[1].mu_dynamic_std = 0.0;
        let refused = calibrate(&problem, &Unwatched).unwrap_err().to_string();
        assert!(refused.contains("measurement 2") && refused.contains("mu_dynamic_std"), "{refused}");
    }
}
