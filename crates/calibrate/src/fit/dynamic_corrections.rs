//! What runs in time add to steady sliding, beside which a fit is made.

use slipgrid_material::LocalFriction;
use slipgrid_springblock::{Monitor, Unwatched};

use super::Layout;
use crate::flat_sample::{self, DynamicFlat, Pairs};
use crate::{FitError, Problem};

/// |d ln delta / d ln(mu_d f)| over delta - 1 at most: what time adds to steady sliding follows friction no faster than the
/// root of it (0.2 where it is largest, `one_run_stands_for_all_at_its_load_and_speed`).
const FOLLOWS: f64 = 0.5;
/// The same as a standard deviation, for measurements that another's run stands for.
pub const STANDING_FOR: f64 = 0.2;

/// Slope of the static peak against mu_s below which it does not follow it: the noise of the two runs behind it.
const MIN_SLOPE: f64 = 0.05;
/// Relative step of mu_s that finds how the static peak follows it: large against the noise of a
/// peak (1e-3), small against the range in which the peak is nearly linear.
const STATIC_STEP: f64 = 0.05;

/// Dynamic runs relative to what the fit can compute at once.
#[derive(Clone, Debug)]
pub struct Corrections {
    /// Dynamic over steady friction.
    pub delta: Vec<f64>,
    pub relative_stderr: Vec<f64>,
    /// How the static peak follows the local coefficient, where a peak was measured.
    pub peaks: Vec<Option<PeakLine>>,
}

/// The static peak near the current coefficients: peak = at_current + slope (mu_s - current).
#[derive(Clone, Copy, Debug)]
pub struct PeakLine {
    pub at_current: f64,
    pub slope: f64,
    pub current: f64,
}

/// Peaks that do not follow mu_s, by measurement.
pub fn flat_peaks(peaks: &[Option<PeakLine>]) -> Vec<usize> {
    (0..peaks.len()).filter(|&i| peaks[i].is_some_and(|line| line.slope < MIN_SLOPE)).collect()
}

/// Gives every peak the mean of its slopes in all rounds, which `slopes` keep by measurement: the two peaks of one draw behind
/// a slope scatter by as much as they differ.
pub fn average_slopes(peaks: &mut [Option<PeakLine>], slopes: &mut [Vec<f64>]) {
    for (line, slopes) in peaks.iter_mut().zip(slopes) {
        let Some(line) = line else { continue };
        slopes.push(line.slope);
        line.slope = slopes.iter().sum::<f64>() / slopes.len() as f64;
    }
}

/// Gives peaks that do not follow mu_s the mean slope of the others: away from the solution a peak of one draw may fall where
/// mu_s rises, which says nothing of it there.
pub fn borrow_slopes(peaks: &mut [Option<PeakLine>]) {
    let slopes: Vec<f64> = peaks.iter().flatten().map(|line| line.slope).filter(|slope| *slope >= MIN_SLOPE).collect();
    let mean = slopes.iter().sum::<f64>() / slopes.len().max(1) as f64;
    for line in peaks.iter_mut().flatten().filter(|line| line.slope < MIN_SLOPE) {
        line.slope = mean;
    }
}

impl Corrections {
    /// Most that delta can move, relative, as the parameters go from those of the runs to others.
    pub fn moved(&self, problem: &Problem, layout: &Layout, parameters: [&[f64]; 2]) -> Result<f64, FitError> {
        let laws = [layout.law(problem, parameters[0])?.0, layout.law(problem, parameters[1])?.0];
        let moved = (0..problem.measurements.len()).map(|i| {
            let pressure_pa = problem.pressure_pa(&problem.measurements[i]);
            let friction = |side: usize| {
                let factor = laws[side].as_ref().map_or(1.0, |law| law.factor(pressure_pa));
                parameters[side][layout.dynamic[i]] * factor
            };
            // |d delta| <= 0.5 |delta - 1| |d ln(mu_d f)|
            FOLLOWS * (self.delta[i] - 1.0).abs() * (friction(1) / friction(0)).ln().abs()
        });
        Ok(moved.fold(0.0, f64::max))
    }
}

/// Runs in time at `parameters`, and at slightly larger mu_s where peaks were measured.
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

/// Runs in time at the `parameters` of a fit that was made with the corrections `of_the_fit`, where any peaks were fitted: delta depends on
/// mu_s, and that of the fit is the one before its last step. The slopes of peaks stay those of the fit.
pub fn confirm(
    problem: &Problem,
    layout: &Layout,
    parameters: &[f64],
    of_the_fit: &Corrections,
    monitor: &dyn Monitor,
) -> Result<Corrections, FitError> {
    if of_the_fit.peaks.iter().all(Option::is_none) {
        return Ok(of_the_fit.clone());
    }
    let runs = Runs::new(problem, layout, parameters, monitor)?;
    let found = runs.dynamic.iter().zip(&runs.pairs).zip(&of_the_fit.peaks);
    let peak = |((found, pair), line): ((&DynamicFlat, &LocalFriction), &Option<PeakLine>)| {
        let (line, at_current) = ((*line)?, found.mu_static?);
        Some(PeakLine { at_current, current: pair.static_mean(), ..line })
    };
    let peaks = found.map(peak).collect();
    Ok(runs.corrections(peaks))
}

/// Flat samples in time at some parameters.
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
        let steady = flat_sample::steady(&problem, &pairs)?;
        let representatives = flat_sample::representatives(&problem, &pairs);
        let dynamic = flat_sample::dynamic(&problem, &pairs, &representatives, monitor)?;
        let delta = dynamic.iter().zip(&representatives).map(|(d, &of)| d.mu_dynamic / steady[of]).collect();
        Ok(Self { problem, pairs, representatives, dynamic, delta })
    }

    fn corrections(self, peaks: Vec<Option<PeakLine>>) -> Corrections {
        let Self { pairs, representatives, dynamic, delta, .. } = self;
        let relative_stderr = |i: usize| {
            let away = (pairs[i].dynamic_mean() / pairs[representatives[i]].dynamic_mean()).ln();
            (dynamic[i].stderr / dynamic[i].mu_dynamic).hypot(STANDING_FOR * (delta[i] - 1.0) * away)
        };
        Corrections { relative_stderr: (0..delta.len()).map(relative_stderr).collect(), delta, peaks }
    }
}

/// The slope of every measured static peak, by runs at slightly larger mu_s.
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
