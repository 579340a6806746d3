//! Fit of local coefficients to measurements on flat samples.

mod dynamic_corrections;
mod feasibility;
mod fit_notes;
mod layout;
mod profile_likelihood;

pub use layout::STATIC_OVER_DYNAMIC;

pub use feasibility::{check_speeds, local_static_over_dynamic, planned_steps, seconds};

use schemars::JsonSchema;
use serde::Serialize;
use slipgrid_base::monitor::{Monitor, Part};
use slipgrid_model::material::AreaLaw;

use crate::calibrate::flat_sample_emulator::Emulator;
use crate::calibrate::least_squares::{LeastSquares, Solution};
use crate::calibrate::{Coefficients, FitError, Measurement, Problem};
use dynamic_corrections::{Corrections, average_slopes, borrow_slopes, confirm, correct, flat_peaks};
use layout::{Layout, first_guess};

/// Maximum number of rounds, each of dynamic runs and a fit. delta, dynamic over steady friction, hardly depends on the
/// coefficients, so that one round is enough if no static peaks are fitted.
const MAX_ROUNDS: usize = 6;
/// The fit has settled if the coefficients change between rounds by less than this fraction, or by less than three
/// standard errors of the dynamic runs.
const SETTLED_CHANGE: f64 = 5e-4;
/// Fitted values at one measured pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedRow {
    /// Nominal pressure, in pascals.
    pub pressure_pa: f64,
    /// Fitted coefficients.
    pub pair: FittedPair,
    /// Modelled minus measured dynamic friction coefficient.
    pub residual: f64,
    /// Dynamic friction of the flat sample over mu_d f(P), the local dynamic coefficient times the area factor, to five
    /// decimals.
    pub dynamic_over_steady: f64,
}

/// Fitted local coefficients for one measurement, or for all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedPair {
    /// Mean local static coefficient.
    pub static_mean: f64,
    /// Standard error of `static_mean`; `None` if the ratio to `dynamic_mean` was assumed, or the data do not determine
    /// it.
    pub static_std_error: Option<f64>,
    /// Mean local dynamic coefficient.
    pub dynamic_mean: f64,
    /// Standard error of `dynamic_mean`, from the standard deviations of the measurements and of the dynamic runs;
    /// `None` if the data do not determine it.
    pub dynamic_std_error: Option<f64>,
    /// Standard error of `dynamic_mean` for a given area law, as it applies to flat friction. Given if
    /// `dynamic_std_error` includes the errors of Young's modulus and of the area law ([`Fit::include_law_errors`]).
    pub dynamic_std_error_given_law: Option<f64>,
}

/// Model results for one measurement with the fitted coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelledRow {
    /// Modelled dynamic friction of the flat sample with the fitted coefficients.
    pub mu_dynamic: f64,
    /// Modelled minus measured dynamic friction coefficient.
    pub residual: f64,
    /// delta: dynamic friction over friction in steady sliding.
    pub dynamic_over_steady: f64,
    /// Dynamic friction over mu_d f(P), the local dynamic coefficient times the area factor, which is steady friction
    /// of an infinite sample.
    pub over_local_law: f64,
    /// Relative standard error of mean friction in the dynamic run from which delta is computed.
    pub relative_stderr: f64,
    /// Static friction of the flat sample in the last dynamic run; `None` if no static peak was fitted.
    pub mu_static: Option<f64>,
}

/// A fitted parameter.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Parameter {
    // `dynamic_mean`, `static_mean` or `area_law_scale_pa`.
    /// Name, with the number of the measurement if each measurement has its own parameter.
    pub name: String,
    /// Value in the best fit.
    pub value: f64,
    /// Standard error from the curvature of chi-square; null if infinite.
    #[schemars(with = "Option<f64>")]
    pub std_error: f64,
    /// Lower and upper bound of the value.
    pub bounds: [f64; 2],
    /// The value lies at a bound.
    pub at_bound: bool,
    // Where the profile has risen by 3.84.
    /// Ends of the 95 % profile-likelihood interval; null where the interval reaches a bound.
    #[serde(rename = "interval_95")]
    pub interval: [Option<f64>; 2],
    // Minimized over all other parameters.
    /// Profile likelihood: pairs of parameter value and increase of chi-square over the best fit.
    pub profile: Vec<[f64; 2]>,
}

/// Result of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Fitted coefficients: one pair for all measurements, or one per measurement.
    pub pairs: Vec<FittedPair>,
    /// One prediction per measurement.
    pub predictions: Vec<ModelledRow>,
    /// All fitted parameters, with bounds, intervals and profiles.
    pub parameters: Vec<Parameter>,
    /// Covariance matrix in the order of `parameters`, with the logarithm of the area law's scale in place of the
    /// scale, from the standard deviations of the measurements only.
    pub covariance: Vec<Vec<f64>>,
    /// Area law of the predictions; `None` if friction is proportional to load (Amontons-Coulomb).
    pub area_law: Option<AreaLaw>,
    /// Sum of squared residuals, each over the standard deviation of the measured value.
    pub chi_square: f64,
    /// Number of measured values minus number of parameters.
    pub degrees_of_freedom: usize,
    /// Whether the coefficients settled within `MAX_ROUNDS` rounds.
    pub settled: bool,
    /// Notes on methods, assumptions and undetermined values, one sentence each.
    pub notes: Vec<String>,
    /// Reasons to doubt fitted values, one sentence each.
    pub warnings: Vec<String>,
}

impl Fit {
    /// Reduced chi-square above which the fit is poor.
    const POOR_REDUCED_CHI_SQUARE: f64 = 3.0;

    /// Whether the model does not describe the measurements, by reduced chi-square.
    pub fn is_poor(&self) -> bool {
        self.degrees_of_freedom > 0 && self.chi_square > Self::POOR_REDUCED_CHI_SQUARE * self.degrees_of_freedom as f64
    }
}

/// Number of start values for the area law's scale, because chi-square may have several minima.
const SCALE_STARTS: usize = 7;

/// Fits local coefficients to the measurements of `problem`. A static peak that does not determine mu_s is left out,
/// with a warning.
///
/// # Errors
/// [`FitError`] if a number is invalid, the flat sample does not slide in the model, or the monitor cancels. Errors
/// that can be known in advance are found before the first dynamic run.
pub fn fit_coefficients(problem: &Problem, monitor: &dyn Monitor) -> Result<Fit, FitError> {
    problem.validate()?;
    let (mut problem, mut left_out) = feasibility::drop_hidden_peaks(problem);
    feasibility::check(&problem)?;
    loop {
        match attempt(&problem, monitor)? {
            Attempt::Fitted(mut fit) => {
                fit.warnings.extend(left_out);
                return Ok(*fit);
            }
            Attempt::LeftOut(numbers, why) => {
                for number in numbers {
                    left_out.push(feasibility::left_out_warning(&problem, number, why));
                    problem.measurements[number].static_peak = None;
                }
            }
        }
    }
}

/// Reason for leaving out a static peak: its slope against the local static coefficient mu_s is too small.
const PEAK_INDEPENDENT_OF_MU_S: &str = "hardly depends on mu_s in the model";
/// Reason for leaving out a static peak: no coefficients reproduce both the peak and dynamic friction.
const PEAK_NOT_REPRODUCED: &str = "is not met by the model together with dynamic friction";

/// Outcome of one attempt to fit all peaks.
enum Attempt {
    /// Fitted coefficients.
    Fitted(Box<Fit>),
    /// Indices of the measurements whose static peaks do not determine mu_s, and the reason.
    LeftOut(Vec<usize>, &'static str),
}

fn attempt(problem: &Problem, monitor: &dyn Monitor) -> Result<Attempt, FitError> {
    let layout = Layout::new(problem);
    let mut parameters = first_guess(problem, &layout);
    let mut settled = false;
    let mut last: Option<(Solution, Corrections, Emulator<'_>)> = None;
    // One round of dynamic runs is typical, two with static peaks.
    let rounds = if problem.has_peaks() { 2.0 } else { 1.0 };
    let portion = Part::new(monitor, 1.0 / rounds);
    let mut slopes = vec![Vec::new(); problem.measurements.len()];
    for round in 0..MAX_ROUNDS {
        let mut found = correct(problem, &layout, &parameters, &portion)?;
        feasibility::check_deltas(&found.delta)?;
        average_slopes(&mut found.peaks, &mut slopes);
        let flat = flat_peaks(&found.peaks);
        if !flat.is_empty() && (flat.len() == found.peaks.iter().flatten().count() || round + 1 == MAX_ROUNDS) {
            return Ok(Attempt::LeftOut(flat, PEAK_INDEPENDENT_OF_MU_S));
        }
        borrow_slopes(&mut found.peaks);
        let means: Vec<f64> = layout.dynamic.iter().map(|&number| parameters[number]).collect();
        let about = Emulator::new(problem, &means, &portion)?;
        let fitted =
            Model { problem, layout: &layout, corrections: &found, emulator: &about }.fit(&parameters, round == 0)?;
        let noise = found.relative_stderr.iter().copied().fold(0.0, f64::max);
        let size = |i: usize| if layout.log_scale == Some(i) { 1.0 } else { fitted.parameters[i].abs() };
        // The scale is a logarithm, so that its change is already relative.
        let same = |before: &Solution| {
            (0..layout.count).all(|i| {
                let change = (before.parameters[i] - fitted.parameters[i]).abs();
                change < (SETTLED_CHANGE.max(3.0 * noise) * size(i)).max(0.1 * fitted.standard_error(i).min(size(i)))
            })
        };
        settled = last.as_ref().is_some_and(|(before, ..)| same(before))
            || found.peaks.iter().all(Option::is_none)
                && found.moved(problem, &layout, [&parameters, &fitted.parameters])? < SETTLED_CHANGE;
        parameters.clone_from(&fitted.parameters);
        last = Some((fitted, found, about));
        if settled && !flat.is_empty() {
            return Ok(Attempt::LeftOut(flat, PEAK_INDEPENDENT_OF_MU_S));
        }
        if settled {
            break;
        }
    }
    let Some((solution, corrections, emulator)) = last else { return Err(FitError::NoMeasurement) };
    let confirmed = confirm(problem, &layout, &solution.parameters, &corrections, &portion)?;
    let unmet = unreproduced_peaks(problem, &layout, [&corrections, &confirmed], &solution, settled);
    if !unmet.is_empty() {
        return Ok(Attempt::LeftOut(unmet, PEAK_NOT_REPRODUCED));
    }
    let model = Model { problem, layout: &layout, corrections: &corrections, emulator: &emulator };
    Ok(Attempt::Fitted(Box::new(report(&model, &confirmed, &solution, settled)?)))
}

/// Indices of the measurements whose static peak and dynamic friction the model cannot reproduce together; such peaks
/// must not distort dynamic friction. If the fit did not settle, these are the measurements with mu_s at a bound.
/// Otherwise they are the measurements whose dynamic friction, in runs with the fitted coefficients, differs from the
/// fit by more than the standard error.
fn unreproduced_peaks(
    problem: &Problem,
    layout: &Layout,
    [fitted, confirmed]: [&Corrections; 2],
    found: &Solution,
    settled: bool,
) -> Vec<usize> {
    let with_peak = || (0..layout.fixed_static.len()).filter(|&i| fitted.peaks[i].is_some());
    let at_bound = |i: &usize| !settled && layout.fixed_static[*i].is_some_and(|number| found.at_bound[number]);
    let held: Vec<usize> = with_peak().filter(at_bound).collect();
    let off = |i: &usize| {
        let measured = &problem.measurements[*i];
        let change = (confirmed.delta[*i] / fitted.delta[*i] - 1.0).abs();
        let noise = confirmed.relative_stderr[*i].hypot(fitted.relative_stderr[*i]);
        change * measured.mu_dynamic > measured.mu_dynamic_std.max(3.0 * noise * measured.mu_dynamic)
    };
    if held.is_empty() { with_peak().filter(off).collect() } else { held }
}

/// The model used in the fit: steady sliding from the emulator, times the corrections from dynamic runs.
struct Model<'a> {
    problem: &'a Problem,
    layout: &'a Layout,
    corrections: &'a Corrections,
    emulator: &'a Emulator<'a>,
}

impl Model<'_> {
    fn least_squares(&self) -> LeastSquares<impl Fn(&[f64]) -> Result<Vec<f64>, FitError>> {
        LeastSquares::new(|parameters: &[f64]| self.residuals(parameters), self.layout.bounds(self.problem))
    }

    fn residuals(&self, parameters: &[f64]) -> Result<Vec<f64>, FitError> {
        let Self { problem, layout, corrections, emulator } = self;
        let (law, log_scale) = layout.law(problem, parameters)?;
        let law = law.as_ref();
        let mut residuals: Vec<f64> = (0..problem.measurements.len())
            .map(|i| {
                let measured = &problem.measurements[i];
                let steady = emulator.steady(i, parameters[layout.dynamic[i]], law, log_scale);
                // [delta steady - measured] / std
                (corrections.delta[i] * steady - measured.mu_dynamic) / measured.mu_dynamic_std
            })
            .collect();
        for (i, measured) in problem.measurements.iter().enumerate() {
            let (Some(number), Some(line), Some(peak)) =
                (layout.fixed_static[i], corrections.peaks[i], measured.static_peak)
            else {
                continue;
            };
            let modelled = line.at_current + line.slope * (parameters[number] - line.current);
            residuals.push((modelled - peak.mu) / peak.std);
        }
        Ok(residuals)
    }

    /// Best fit from `start`; with `everywhere` also from start values over the whole range of the area law's scale, if
    /// the scale is fitted.
    fn fit(&self, start: &[f64], everywhere: bool) -> Result<Solution, FitError> {
        let problem = self.least_squares();
        let mut best = problem.solve(start)?;
        let (Some(number), Some(unknown), true) = (self.layout.log_scale, &self.problem.area_law_scale, everywhere)
        else {
            return Ok(best);
        };
        let [from, to] = unknown.bounds_pa.map(f64::ln);
        for i in 0..SCALE_STARTS {
            let mut start = start.to_vec();
            start[number] = from + (to - from) * (i as f64 + 0.5) / SCALE_STARTS as f64;
            let found = problem.solve(&start)?;
            if found.chi_square() < best.chi_square() * (1.0 - 1e-12) {
                best = found;
            }
        }
        Ok(best)
    }
}

/// Relative scatter of measured dynamic friction about the model with one pair of coefficients for all measurements,
/// beyond the standard deviations of the measurements. 0 if each measurement has its own pair, or if there are too few
/// measurements.
fn scatter_beyond(problem: &Problem, layout: &Layout, solution: &Solution) -> f64 {
    let count = problem.measurements.len();
    // Static coefficients do not take part in the fit of dynamic friction.
    let parameters = 1 + usize::from(layout.log_scale.is_some());
    if problem.coefficients != Coefficients::Single || count <= parameters {
        return 0.0;
    }
    // s^2 = sum (r_i s_i / mu_i)^2 / (n - p) - sum (s_i / mu_i)^2 / n, r_i residuals in standard deviations s_i
    let relative = |measured: &Measurement| measured.mu_dynamic_std / measured.mu_dynamic;
    let each = || problem.measurements.iter().map(relative).zip(&solution.residuals);
    let about: f64 = each().map(|(relative, residual)| (residual * relative).powi(2)).sum();
    let known: f64 = each().map(|(relative, _)| relative.powi(2)).sum();
    (about / (count - parameters) as f64 - known / count as f64).max(0.0).sqrt()
}

/// Assembles the fit; `confirmed` holds dynamic friction and peaks from runs with the fitted coefficients.
fn report(model: &Model<'_>, confirmed: &Corrections, solution: &Solution, settled: bool) -> Result<Fit, FitError> {
    let Model { problem, layout, corrections, .. } = *model;
    let count = problem.measurements.len();
    let pairs_per_fit = match problem.coefficients {
        Coefficients::Single => 1,
        Coefficients::PerCondition => count,
    };
    let beyond = scatter_beyond(problem, layout, solution);
    let pairs = (0..pairs_per_fit)
        .map(|i| {
            let pair = layout.pair(problem, &solution.parameters, i)?;
            // One draw of local coefficients is used in all runs, so that averaging over runs does not reduce their
            // errors.
            let run_error = pair.dynamic_mean() * corrections.relative_stderr[i].hypot(beyond);
            Ok(FittedPair {
                static_mean: pair.static_mean(),
                static_std_error: layout.fixed_static[i]
                    .map(|number| solution.standard_error(number))
                    .filter(|error| error.is_finite()),
                dynamic_mean: pair.dynamic_mean(),
                dynamic_std_error: Some(solution.standard_error(layout.dynamic[i]).hypot(run_error))
                    .filter(|error| error.is_finite()),
                dynamic_std_error_given_law: None,
            })
        })
        .collect::<Result<Vec<FittedPair>, FitError>>()?;
    let area_law = layout.law(problem, &solution.parameters)?.0;
    let predictions = (0..count)
        .map(|i| {
            let measured = &problem.measurements[i];
            let fitted = solution.residuals[i] * measured.mu_dynamic_std;
            let moved = (measured.mu_dynamic + fitted) * (confirmed.delta[i] / corrections.delta[i] - 1.0);
            let mu_dynamic = measured.mu_dynamic + fitted + moved;
            let pair = pairs.get(i).unwrap_or(&pairs[0]);
            let factor = area_law.as_ref().map_or(1.0, |law| law.factor(problem.pressure_pa(measured)));
            ModelledRow {
                mu_dynamic,
                over_local_law: mu_dynamic / (pair.dynamic_mean * factor),
                residual: fitted + moved,
                dynamic_over_steady: confirmed.delta[i],
                relative_stderr: confirmed.relative_stderr[i],
                mu_static: confirmed.peaks[i].map(|line| line.at_current),
            }
        })
        .collect();
    let parameters = profile_likelihood::parameters(model, solution)?;
    let mut fit = Fit {
        pairs,
        predictions,
        parameters,
        covariance: solution.covariance.clone(),
        area_law,
        chi_square: solution.chi_square(),
        degrees_of_freedom: solution.residuals.len().saturating_sub(layout.count),
        settled,
        notes: Vec::new(),
        warnings: Vec::new(),
    };
    (fit.notes, fit.warnings) = (fit_notes::notes(model, &fit), fit_notes::warnings(&fit));
    Ok(fit)
}

#[cfg(test)]
mod tests;
