//! Corrections from dynamic runs to steady sliding, for use in the fit.

use slipgrid_model::material::LocalFriction;
use slipgrid_model::springblock::{Monitor, Unwatched};

use super::layout::Layout;
use crate::calibrate::flat_sample::{self, DynamicFlat, Pairs};
use crate::calibrate::{FitError, Problem};

/// Upper bound of |d ln delta / d ln(mu_d f)| / |delta - 1|, with delta = dynamic over steady friction, the local
/// dynamic coefficient mu_d and the area factor f: the excess delta - 1 grows no faster than the square root of
/// friction (0.2 at most in the test `one_run_stands_for_all_at_its_load_and_speed`).
const MAX_EXCESS_SENSITIVITY: f64 = 0.5;
/// Standard deviation of the ratio that `MAX_EXCESS_SENSITIVITY` bounds, for measurements that use the run of another
/// measurement.
pub const EXCESS_SENSITIVITY_STD: f64 = 0.2;

/// A static peak is considered independent of the local static coefficient mu_s if its slope against mu_s is below this
/// number, which is the noise of the two runs from which the slope is computed.
const MIN_SLOPE: f64 = 0.05;
/// Relative step of mu_s, the local static coefficient, for the slope of the static peak: large against the noise of a
/// peak (1e-3), small against the range in which the peak is nearly linear.
const STATIC_STEP: f64 = 0.05;

/// Results of dynamic runs, relative to the steady model.
#[derive(Clone, Debug)]
pub struct Corrections {
    /// Dynamic over steady friction, one per measurement.
    pub delta: Vec<f64>,
    /// Relative standard error of `delta`, one per measurement.
    pub relative_stderr: Vec<f64>,
    /// Dependence of the static peak on the local static coefficient mu_s, one per measurement; `None` if no peak was
    /// measured.
    pub peaks: Vec<Option<PeakLine>>,
}

/// Static peak of the flat sample for mu_s near its current value: peak = at_current + slope (mu_s - current).
#[derive(Clone, Copy, Debug)]
pub struct PeakLine {
    pub at_current: f64,
    pub slope: f64,
    pub current: f64,
}

/// Indices of the measurements whose static peaks hardly depend on mu_s: their slope is below `MIN_SLOPE`.
pub fn flat_peaks(peaks: &[Option<PeakLine>]) -> Vec<usize> {
    (0..peaks.len()).filter(|&i| peaks[i].is_some_and(|line| line.slope < MIN_SLOPE)).collect()
}

/// Replaces the slope of every peak by its mean over all rounds, which `slopes` accumulates by measurement. A single
/// slope comes from two runs with one draw of the local coefficients, and its error is as large as the slope.
pub fn average_slopes(peaks: &mut [Option<PeakLine>], slopes: &mut [Vec<f64>]) {
    for (line, slopes) in peaks.iter_mut().zip(slopes) {
        let Some(line) = line else { continue };
        slopes.push(line.slope);
        line.slope = slopes.iter().sum::<f64>() / slopes.len() as f64;
    }
}

/// Replaces slopes below `MIN_SLOPE` by the mean of the other slopes. Far from the solution, one draw of the local
/// coefficients may give a slope that is not typical, even a negative one.
pub fn borrow_slopes(peaks: &mut [Option<PeakLine>]) {
    let slopes: Vec<f64> = peaks.iter().flatten().map(|line| line.slope).filter(|slope| *slope >= MIN_SLOPE).collect();
    let mean = slopes.iter().sum::<f64>() / slopes.len().max(1) as f64;
    for line in peaks.iter_mut().flatten().filter(|line| line.slope < MIN_SLOPE) {
        line.slope = mean;
    }
}

impl Corrections {
    /// Upper bound over all measurements of the relative change of delta (dynamic over steady friction) between two
    /// sets of parameters, first those of the runs.
    pub fn moved(&self, problem: &Problem, layout: &Layout, parameters: [&[f64]; 2]) -> Result<f64, FitError> {
        let laws = [layout.law(problem, parameters[0])?.0, layout.law(problem, parameters[1])?.0];
        let moved = (0..problem.measurements.len()).map(|i| {
            let pressure_pa = problem.pressure_pa(&problem.measurements[i]);
            let friction = |side: usize| {
                let factor = laws[side].as_ref().map_or(1.0, |law| law.factor(pressure_pa));
                parameters[side][layout.dynamic[i]] * factor
            };
            // |d delta| <= 0.5 |delta - 1| |d ln(mu_d f)|
            MAX_EXCESS_SENSITIVITY * (self.delta[i] - 1.0).abs() * (friction(1) / friction(0)).ln().abs()
        });
        Ok(moved.fold(0.0, f64::max))
    }
}

/// Corrections from dynamic runs at `parameters`, and at a slightly larger local static coefficient if peaks were
/// measured.
pub fn correct(
    problem: &Problem,
    layout: &Layout,
    parameters: &[f64],
    monitor: &dyn Monitor,
) -> Result<Corrections, FitError> {
    let runs = Runs::new(problem, layout, parameters, monitor)?;
    let peaks = peak_lines(&runs)?;
    Ok(runs.corrections(peaks))
}

/// Recomputes the corrections by dynamic runs at the fitted `parameters`: delta (dynamic over steady friction) depends
/// on the local static coefficient, and the fit used delta from before its last step. Keeps the slopes d(static
/// peak)/d(mu_s) of `fitted`. Returns `fitted` unchanged if no peak was fitted.
pub fn confirm(
    problem: &Problem,
    layout: &Layout,
    parameters: &[f64],
    fitted: &Corrections,
    monitor: &dyn Monitor,
) -> Result<Corrections, FitError> {
    if fitted.peaks.iter().all(Option::is_none) {
        return Ok(fitted.clone());
    }
    let runs = Runs::new(problem, layout, parameters, monitor)?;
    let found = runs.dynamic.iter().zip(&runs.pairs).zip(&fitted.peaks);
    let peak = |((found, pair), line): ((&DynamicFlat, &LocalFriction), &Option<PeakLine>)| {
        let (line, at_current) = ((*line)?, found.mu_static?);
        Some(PeakLine { at_current, current: pair.static_mean(), ..line })
    };
    let peaks = found.map(peak).collect();
    Ok(runs.corrections(peaks))
}

/// Dynamic runs of the flat sample at given parameters.
struct Runs {
    problem: Problem,
    pairs: Pairs,
    representatives: Vec<usize>,
    dynamic: Vec<DynamicFlat>,
    delta: Vec<f64>,
}

impl Runs {
    fn new(problem: &Problem, layout: &Layout, parameters: &[f64], monitor: &dyn Monitor) -> Result<Self, FitError> {
        let pairs = layout.pairs(problem, parameters)?;
        let (area_law, _) = layout.law(problem, parameters)?;
        let problem = Problem { area_law, ..problem.clone() };
        let representatives = flat_sample::representatives(&problem, &pairs);
        let steady = flat_sample::steady(&problem, &pairs, &representatives)?;
        let dynamic = flat_sample::dynamic(&problem, &pairs, &representatives, monitor)?;
        let delta = dynamic.iter().zip(&steady).map(|(run, steady)| run.mu_dynamic / steady).collect();
        Ok(Self { problem, pairs, representatives, dynamic, delta })
    }

    fn corrections(self, peaks: Vec<Option<PeakLine>>) -> Corrections {
        let Self { pairs, representatives, dynamic, delta, .. } = self;
        let relative_stderr = |i: usize| {
            let away = (pairs[i].dynamic_mean() / pairs[representatives[i]].dynamic_mean()).ln();
            (dynamic[i].stderr / dynamic[i].mu_dynamic).hypot(EXCESS_SENSITIVITY_STD * (delta[i] - 1.0) * away)
        };
        Corrections { relative_stderr: (0..delta.len()).map(relative_stderr).collect(), delta, peaks }
    }
}

/// Dependence of each measured static peak on mu_s, from runs with slightly larger mu_s; `None` where no peak was
/// measured.
fn peak_lines(runs: &Runs) -> Result<Vec<Option<PeakLine>>, FitError> {
    let Runs { problem, pairs, representatives, dynamic, .. } = runs;
    if dynamic.iter().all(|d| d.mu_static.is_none()) {
        return Ok(vec![None; dynamic.len()]);
    }
    let raised: Pairs = pairs
        .iter()
        .map(|pair| {
            LocalFriction::new(pair.static_mean() * (1.0 + STATIC_STEP), pair.dynamic_mean(), pair.relative_std())
        })
        .collect::<Result<_, _>>()?;
    let moved = flat_sample::dynamic(problem, &raised, representatives, &Unwatched)?;
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
