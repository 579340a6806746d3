//! The fit itself.

mod dynamic_corrections;
mod feasibility;
mod fit_notes;
mod profile_likelihood;

pub use feasibility::{check_speeds, local_static_over_dynamic, planned_steps, seconds};

use slipgrid_material::{AreaLaw, LocalFriction};
use slipgrid_monitor::{Monitor, Part};

use crate::flat_sample::Pairs;
use crate::flat_sample_emulator::Emulator;
use crate::least_squares::{LeastSquares, Solution};
use crate::{Coefficients, FitError, Measurement, Problem};
use dynamic_corrections::{Corrections, average_slopes, borrow_slopes, confirm, correct, flat_peaks};

/// Rounds of fit and dynamic runs at most. delta hardly depends on the coefficients: where no static peaks are fitted one
/// round is enough.
const MAX_ROUNDS: usize = 6;
/// Change of the coefficients between rounds below which they are settled, relative; three standard
/// errors of the dynamic runs where those are larger.
const SETTLED: f64 = 5e-4;
/// Fitted coefficients: of one measurement, or of all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedPair {
    /// Mean local static coefficient.
    pub static_mean: f64,
    /// Its standard error; `None` where it was assumed, not fitted, and where the data do not determine it.
    pub static_std_error: Option<f64>,
    /// Mean local dynamic coefficient.
    pub dynamic_mean: f64,
    /// Its standard error, from the measurements' standard deviations and those of the dynamic runs; `None` where the data
    /// do not determine it.
    pub dynamic_std_error: Option<f64>,
    /// That at the given area law, that of flat friction, where `dynamic_std_error` is one whatever Young's modulus and the
    /// area law are ([`Fit::free_of_the_law`]).
    pub dynamic_std_error_given_law: Option<f64>,
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
    /// Dynamic friction over mu_d f(P), that of an endless sample in steady sliding.
    pub over_local_law: f64,
    /// Standard error of the dynamic run behind delta, relative.
    pub relative_stderr: f64,
    /// Static friction of the flat sample in the last run in time; `None` where no static peak was fitted.
    pub mu_static: Option<f64>,
}

/// One fitted number.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// What it is: `dynamic_mean`, `static_mean`, `area_law_scale_pa`; with the measurement's number where
    /// there are several.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Standard error from the curvature; infinite where the data do not determine it.
    pub std_error: f64,
    /// Least and greatest value allowed.
    pub bounds: [f64; 2],
    /// The value ended at a bound: the data ask for one beyond it.
    pub at_bound: bool,
    /// Least chi-square, over all other parameters, above the fit's own: value and increase.
    pub profile: Vec<[f64; 2]>,
    /// Ends of the 95 % interval by the profile (an increase of 3.84); `None` where it reaches a bound.
    pub interval: [Option<f64>; 2],
}

/// What a fit found.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// One pair for all measurements, or one each.
    pub pairs: Vec<FittedPair>,
    /// One per measurement.
    pub predictions: Vec<Prediction>,
    /// All fitted numbers.
    pub parameters: Vec<Parameter>,
    /// Their covariance, from the measurements' standard deviations alone.
    pub covariance: Vec<Vec<f64>>,
    /// The area law of the predictions; `None` is Amontons-Coulomb.
    pub area_law: Option<AreaLaw>,
    /// Sum of squared residuals in standard deviations.
    pub chi_square: f64,
    /// Measured numbers less fitted ones.
    pub degrees_of_freedom: usize,
    /// delta settled within the rounds allowed.
    pub settled: bool,
    /// How values were obtained, what was assumed, what stays undetermined; one sentence each.
    pub notes: Vec<String>,
    /// What makes fitted values doubtful, one sentence each.
    pub warnings: Vec<String>,
}

impl Fit {
    /// Chi-square over its degrees of freedom from which on the model does not describe the measurements.
    const POOR: f64 = 3.0;

    /// Whether the model does not describe the measurements.
    #[must_use]
    pub fn is_poor(&self) -> bool {
        self.degrees_of_freedom > 0 && self.chi_square > Self::POOR * self.degrees_of_freedom as f64
    }
}

/// How parameters map to measurements: parameter numbers of mu_d and, where fitted, mu_s.
struct Layout {
    dynamic: Vec<usize>,
    fixed_static: Vec<Option<usize>>,
    /// Number of the logarithm of the area law's scale, where that is fitted.
    log_scale: Option<usize>,
    count: usize,
}

/// Bounds of mean local coefficients: beyond them no dry contact is meant.
const FRICTION_BOUNDS: [f64; 2] = [1e-3, 5.0];
/// Bounds of mu_s over the first guess of mu_d. Below, sliding would take more than rest; above, a larger mu_s gives
/// the model's sample no larger peak, because the ends slip long before its middle does.
pub const STATIC_OVER_DYNAMIC: [f64; 2] = [0.9, 3.5];
/// Scales of the area law from which a fit starts: chi-square may have more than one valley.
const STARTS: usize = 7;

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
            log_scale: problem.area_law_scale.as_ref().map(|_| count),
            count: count + usize::from(problem.area_law_scale.is_some()),
        }
    }

    fn bounds(&self, problem: &Problem) -> Vec<[f64; 2]> {
        let mut bounds = vec![FRICTION_BOUNDS; self.count];
        let first = first_guess(problem, self);
        for (dynamic, fixed) in self.dynamic.iter().zip(&self.fixed_static) {
            if let Some(number) = fixed {
                bounds[*number] = STATIC_OVER_DYNAMIC.map(|ratio| ratio * first[*dynamic]);
            }
        }
        if let (Some(number), Some(unknown)) = (self.log_scale, &problem.area_law_scale) {
            bounds[number] = unknown.bounds_pa.map(f64::ln);
        }
        bounds
    }

    /// The area law at the parameters, and the logarithm of its scale.
    fn law(&self, problem: &Problem, parameters: &[f64]) -> Result<(Option<AreaLaw>, f64), FitError> {
        let log_scale = self.log_scale.map_or(0.0, |number| parameters[number]);
        Ok((problem.law_at(log_scale.exp())?, log_scale))
    }

    /// Local coefficients at measurement `i`.
    fn pair(&self, problem: &Problem, parameters: &[f64], i: usize) -> Result<LocalFriction, FitError> {
        let dynamic_mean = parameters[self.dynamic[i]];
        let static_mean =
            self.fixed_static[i].map_or(problem.static_over_dynamic * dynamic_mean, |number| parameters[number]);
        Ok(LocalFriction::new(static_mean, dynamic_mean, problem.relative_std)?)
    }

    fn pairs(&self, problem: &Problem, parameters: &[f64]) -> Result<Pairs, FitError> {
        (0..self.dynamic.len()).map(|i| self.pair(problem, parameters, i)).collect()
    }
}

/// Fits local coefficients to `problem`. A static peak that says nothing of mu_s is left out, and named in the warnings.
///
/// # Errors
/// [`FitError`] if a number has no meaning, the flat sample does not slide in the model, or the
/// monitor asks to stop. What can be known before the first run is.
pub fn fit_coefficients(problem: &Problem, monitor: &dyn Monitor) -> Result<Fit, FitError> {
    problem.validate()?;
    let (mut problem, mut left_out) = feasibility::without_hidden_peaks(problem);
    feasibility::check(&problem)?;
    loop {
        match attempt(&problem, monitor)? {
            Attempt::Fitted(mut fit) => {
                fit.warnings.extend(left_out);
                return Ok(*fit);
            }
            Attempt::LeftOut(numbers, why) => {
                for number in numbers {
                    left_out.push(feasibility::left_out(&problem, number, why));
                    problem.measurements[number].static_peak = None;
                }
            }
        }
    }
}

/// Why static peaks are left out.
const FLAT: &str = "hardly depends on mu_s in the model";
const UNMET: &str = "is not met by the model together with dynamic friction";

/// How a fit ended.
enum Attempt {
    /// With coefficients.
    Fitted(Box<Fit>),
    /// The static peaks of these measurements say nothing of mu_s, and why.
    LeftOut(Vec<usize>, &'static str),
}

fn attempt(problem: &Problem, monitor: &dyn Monitor) -> Result<Attempt, FitError> {
    let layout = Layout::new(problem);
    let mut parameters = first_guess(problem, &layout);
    let mut emulator = None;
    let mut corrections: Option<Corrections> = None;
    let mut settled = false;
    let mut solution: Option<Solution> = None;
    // Progress counts on one round of dynamic runs, on two where peaks are fitted.
    let rounds = if problem.has_peaks() { 2.0 } else { 1.0 };
    let portion = Part::new(monitor, 1.0 / rounds);
    let mut slopes = vec![Vec::new(); problem.measurements.len()];
    for round in 0..MAX_ROUNDS {
        let mut found = correct(problem, &layout, &parameters, &portion)?;
        feasibility::check_deltas(&found.delta)?;
        average_slopes(&mut found.peaks, &mut slopes);
        let flat = flat_peaks(&found.peaks);
        if !flat.is_empty() && (flat.len() == found.peaks.iter().flatten().count() || round + 1 == MAX_ROUNDS) {
            return Ok(Attempt::LeftOut(flat, FLAT));
        }
        borrow_slopes(&mut found.peaks);
        let means: Vec<f64> = layout.dynamic.iter().map(|&number| parameters[number]).collect();
        let about = Emulator::new(problem, &means)?;
        let fitted =
            Model { problem, layout: &layout, corrections: &found, emulator: &about }.fit(&parameters, round == 0)?;
        emulator = Some(about);
        let noise = found.relative_stderr.iter().copied().fold(0.0, f64::max);
        let size = |i: usize| if layout.log_scale == Some(i) { 1.0 } else { fitted.parameters[i].abs() };
        // The scale is a logarithm: its change is relative as it is.
        let same = |before: &Solution| {
            (0..layout.count).all(|i| {
                let change = (before.parameters[i] - fitted.parameters[i]).abs();
                change < (SETTLED.max(3.0 * noise) * size(i)).max(0.1 * fitted.standard_error(i).min(size(i)))
            })
        };
        settled = solution.as_ref().is_some_and(same)
            || found.peaks.iter().all(Option::is_none)
                && found.moved(problem, &layout, [&parameters, &fitted.parameters])? < SETTLED;
        parameters.clone_from(&fitted.parameters);
        solution = Some(fitted);
        corrections = Some(found);
        if settled && !flat.is_empty() {
            return Ok(Attempt::LeftOut(flat, FLAT));
        }
        if settled {
            break;
        }
    }
    let (Some(solution), Some(corrections), Some(emulator)) = (solution, corrections, emulator) else {
        return Err(FitError::NoMeasurement);
    };
    let confirmed = confirm(problem, &layout, &solution.parameters, &corrections, &portion)?;
    let unmet = unmet_peaks(problem, &layout, [&corrections, &confirmed], &solution, settled);
    if !unmet.is_empty() {
        return Ok(Attempt::LeftOut(unmet, UNMET));
    }
    let model = Model { problem, layout: &layout, corrections: &corrections, emulator: &emulator };
    Ok(Attempt::Fitted(Box::new(report(&model, &confirmed, &solution, settled)?)))
}

/// Measurements whose static peaks the model does not meet together with dynamic friction, for which that must not pay: where the fit did
/// not settle those whose mu_s ended at a bound; otherwise those whose dynamic friction in time, at the coefficients found, is further from
/// that of the fit than its standard error.
fn unmet_peaks(
    problem: &Problem,
    layout: &Layout,
    [of_the_fit, confirmed]: [&Corrections; 2],
    found: &Solution,
    settled: bool,
) -> Vec<usize> {
    let with_peak = || (0..layout.fixed_static.len()).filter(|&i| of_the_fit.peaks[i].is_some());
    let at_bound = |i: &usize| !settled && layout.fixed_static[*i].is_some_and(|number| found.at_bound[number]);
    let held: Vec<usize> = with_peak().filter(at_bound).collect();
    let off = |i: &usize| {
        let measured = &problem.measurements[*i];
        let change = (confirmed.delta[*i] / of_the_fit.delta[*i] - 1.0).abs();
        let noise = confirmed.relative_stderr[*i].hypot(of_the_fit.relative_stderr[*i]);
        change * measured.mu_dynamic > measured.mu_dynamic_std.max(3.0 * noise * measured.mu_dynamic)
    };
    if held.is_empty() { with_peak().filter(off).collect() } else { held }
}

/// The model as the fit sees it: steady sliding by the emulator, dynamic runs by their corrections.
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

    /// The best fit from `start`; with `everywhere` from scales over all their range as well.
    fn fit(&self, start: &[f64], everywhere: bool) -> Result<Solution, FitError> {
        let problem = self.least_squares();
        let mut best = problem.solve(start)?;
        let (Some(number), Some(unknown), true) = (self.layout.log_scale, &self.problem.area_law_scale, everywhere)
        else {
            return Ok(best);
        };
        let [from, to] = unknown.bounds_pa.map(f64::ln);
        for i in 0..STARTS {
            let mut start = start.to_vec();
            start[number] = from + (to - from) * (i as f64 + 0.5) / STARTS as f64;
            let found = problem.solve(&start)?;
            if found.chi_square() < best.chi_square() * (1.0 - 1e-12) {
                best = found;
            }
        }
        Ok(best)
    }
}

/// mu_d = measured / f(P), averaged over what shares a parameter.
fn first_guess(problem: &Problem, layout: &Layout) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); layout.count];
    // An unknown law begins in the middle of its scales.
    let middle =
        problem.area_law_scale.as_ref().map_or(0.0, |unknown| unknown.bounds_pa.map(f64::ln).iter().sum::<f64>() / 2.0);
    let law = problem.law_at(middle.exp()).ok().flatten();
    for (i, measured) in problem.measurements.iter().enumerate() {
        let factor = law.as_ref().map_or(1.0, |law| law.factor(problem.pressure_pa(measured)));
        let mut add = |number: usize, mu: f64| {
            sums[number].0 += mu / factor;
            sums[number].1 += 1.0;
        };
        add(layout.dynamic[i], measured.mu_dynamic);
        if let (Some(number), Some(peak)) = (layout.fixed_static[i], measured.static_peak) {
            add(number, peak.mu);
        }
    }
    if let Some(number) = layout.log_scale {
        sums[number] = (middle, 1.0);
    }
    sums.into_iter().map(|(sum, count): (f64, f64)| sum / count.max(1.0)).collect()
}

/// Relative standard deviation of friction about the one pair that is fitted to several measurements, beyond what they are known to: flat
/// friction at one of them is not the pair's. It is 0 where each has a pair of its own.
fn scatter_beyond(problem: &Problem, layout: &Layout, solution: &Solution) -> f64 {
    let count = problem.measurements.len();
    // Static coefficients fit no dynamic friction.
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

/// What was found, with what `confirmed` says of dynamic friction and of peaks at it.
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
            // One draw of coefficients serves all runs: their errors are not averaged away.
            let of_runs = pair.dynamic_mean() * corrections.relative_stderr[i].hypot(beyond);
            Ok(FittedPair {
                static_mean: pair.static_mean(),
                static_std_error: layout.fixed_static[i]
                    .map(|number| solution.standard_error(number))
                    .filter(|error| error.is_finite()),
                dynamic_mean: pair.dynamic_mean(),
                dynamic_std_error: Some(solution.standard_error(layout.dynamic[i]).hypot(of_runs))
                    .filter(|error| error.is_finite()),
                dynamic_std_error_given_law: None,
            })
        })
        .collect::<Result<Vec<FittedPair>, FitError>>()?;
    let area_law = layout.law(problem, &solution.parameters)?.0;
    let predictions = (0..count)
        .map(|i| {
            let measured = &problem.measurements[i];
            let of_the_fit = solution.residuals[i] * measured.mu_dynamic_std;
            let moved = (measured.mu_dynamic + of_the_fit) * (confirmed.delta[i] / corrections.delta[i] - 1.0);
            let mu_dynamic = measured.mu_dynamic + of_the_fit + moved;
            let pair = pairs.get(i).unwrap_or(&pairs[0]);
            let factor = area_law.as_ref().map_or(1.0, |law| law.factor(problem.pressure_pa(measured)));
            Prediction {
                mu_dynamic,
                over_local_law: mu_dynamic / (pair.dynamic_mean * factor),
                residual: of_the_fit + moved,
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
