//! The flat sample in the spring-block model, for many loads at once.

use slipgrid_material::LocalFriction;
use slipgrid_springblock::{
    Extent, Fidelity, Load, LoadOutcome, Monitor, RunOptions, Scene, Status, SurfaceOutcome, simulate,
};

use crate::{FitError, Measurement, Problem};

/// Travel of a dynamic run from steady sliding, in metres: a hundred stick-slip cycles of a block.
/// Against four times the travel the mean moves by less than 0.03 %.
const WARM_TRAVEL_M: f64 = 0.4e-6;
/// Travel of a run from rest, which finds the static peak, in metres.
const COLD_TRAVEL_M: f64 = 2e-6;

/// Periods of the layer's first shear mode that a run is planned to last at least: an average must hold ten, of a record of
/// which at most half is left out. At high speeds the travels above are over sooner.
const LEAST_PERIODS: f64 = 40.0;

/// Travel over what takes the layer to the onset of sliding above which it is long enough: what comes before the onset may be half
/// of it, and the block that holds longest has a sixth more friction than the mean of a thousand.
const ENOUGH: f64 = 1.9;
/// Travel of a run that would be too short, from rest, over what shears the layer to the onset of sliding: at most half of
/// it is left out of the average.
const COLD_ONSETS: f64 = 2.5;
/// The same from steady sliding, over what takes the layer from the dynamic to the static friction.
const WARM_ONSETS: f64 = 4.0;

/// Travel of a dynamic run of `measured` with the coefficients `pair`, in metres: the usual one, or what
/// [`LEAST_PERIODS`] or the onset of sliding take at high speeds and loads.
fn travel_m(problem: &Problem, measured: &Measurement, pair: &LocalFriction) -> f64 {
    let elastic = &problem.elastic;
    // G = 3 E / 8, c_s = sqrt(G / rho)
    let shear_modulus_pa = 0.375 * elastic.youngs_modulus_pa();
    let shear_wave_m_s = (shear_modulus_pa / elastic.density_kg_m3()).sqrt();
    // T = 4 h / c_s
    let period_s = 4.0 * problem.layer.height_m / shear_wave_m_s;
    let (usual_m, onsets, mu) = if measured.static_peak.is_some() {
        (COLD_TRAVEL_M, COLD_ONSETS, pair.static_mean())
    } else {
        (WARM_TRAVEL_M, WARM_ONSETS, (pair.static_mean() - pair.dynamic_mean()).max(0.0))
    };
    let factor = problem.area_law.as_ref().map_or(1.0, |law| law.factor(problem.pressure_pa(measured)));
    // u = mu f P h / G
    let onset_m = mu * factor * problem.pressure_pa(measured) / shear_modulus_pa * problem.layer.height_m;
    let travel_m = usual_m.max(LEAST_PERIODS * period_s * measured.speed_m_s);
    if travel_m > ENOUGH * onset_m { travel_m } else { onsets * onset_m }
}

fn run_options(problem: &Problem, measured: &Measurement, pair: &LocalFriction) -> RunOptions {
    RunOptions {
        fidelity: Fidelity::Dynamic,
        warm_start: measured.static_peak.is_none(),
        sliding_m: travel_m(problem, measured, pair),
        ..RunOptions::default()
    }
}

/// Time steps of the dynamic run of each measurement.
pub fn planned_steps(problem: &Problem, pairs: &Pairs) -> Vec<u64> {
    let of = |(measured, pair): (&Measurement, &LocalFriction)| {
        let run = run_options(problem, measured, pair);
        slipgrid_springblock::planned_steps(&scene(
            problem,
            measured.speed_m_s,
            vec![load(problem, measured, *pair)],
            run,
        ))
    };
    problem.measurements.iter().zip(pairs).map(of).collect()
}

/// Coefficients at each measurement.
pub type Pairs = Vec<LocalFriction>;

fn scene(problem: &Problem, speed_m_s: f64, loads: Vec<Load>, run: RunOptions) -> Scene {
    Scene {
        elastic: problem.elastic,
        area_law: problem.area_law.clone(),
        pattern: None,
        relief: None,
        layer: problem.layer,
        loads,
        speed_m_s,
        run: RunOptions { extent: Extent::Sample, seed: problem.seed, ..run },
    }
}

fn load(problem: &Problem, measured: &Measurement, friction: LocalFriction) -> Load {
    Load { pressure_pa: problem.pressure_pa(measured), friction }
}

/// mu of the flat sample in steady sliding, one per measurement.
pub fn steady(problem: &Problem, pairs: &Pairs) -> Result<Vec<f64>, FitError> {
    let loads = problem.measurements.iter().zip(pairs).map(|(measured, pair)| load(problem, measured, *pair)).collect();
    // Speed plays no part in steady sliding.
    let scene = scene(problem, problem.measurements[0].speed_m_s, loads, RunOptions::default());
    let simulation = simulate(&scene, &slipgrid_springblock::Unwatched)?;
    let slid =
        |(i, outcome): (usize, &LoadOutcome)| slid(outcome.pressure_pa, &outcome.surface).map_err(|error| error.at(i));
    simulation.loads.iter().enumerate().map(slid).collect()
}

fn slid(pressure_pa: f64, surface: &SurfaceOutcome) -> Result<f64, FitError> {
    match (surface.status, surface.mu_dynamic) {
        (Status::Converged, Some(mu)) => Ok(mu),
        (Status::Cancelled, _) => Err(FitError::Cancelled),
        (status, _) => Err(FitError::NoSliding { number: 1, pressure_pa, status: status.name() }),
    }
}

/// What dynamic runs say of one measurement.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DynamicFlat {
    /// Dynamic friction coefficient.
    pub mu_dynamic: f64,
    /// Its standard error.
    pub stderr: f64,
    /// Static friction coefficient; only where a static peak was measured.
    pub mu_static: Option<f64>,
}

/// Dynamic runs of the flat sample, one per measurement. Runs start from steady sliding, but from rest
/// where a static peak was measured.
pub fn dynamic(problem: &Problem, pairs: &Pairs, monitor: &dyn Monitor) -> Result<Vec<DynamicFlat>, FitError> {
    let count = problem.measurements.len();
    let mut found = vec![DynamicFlat::default(); count];
    // Measurements that differ in nothing the model sees, as humidities do under one pair, share a run.
    let seen = |i: usize| {
        let measured = &problem.measurements[i];
        (problem.pressure_pa(measured), measured.speed_m_s, measured.static_peak.is_some(), pairs[i])
    };
    let run_of: Vec<usize> = (0..count).map(|i| (0..i).find(|&j| seen(j) == seen(i)).unwrap_or(i)).collect();
    let mut done: Vec<bool> = (0..count).map(|i| run_of[i] != i).collect();
    while let Some(first) = done.iter().position(|done| !done) {
        // One scene for all measurements of the same speed, kind of start and travel.
        let kind = |i: usize| {
            let measured = &problem.measurements[i];
            (measured.speed_m_s, measured.static_peak.is_some(), travel_m(problem, measured, &pairs[i]))
        };
        let speed_m_s = problem.measurements[first].speed_m_s;
        let group: Vec<usize> = (first..count).filter(|&i| !done[i] && kind(i) == kind(first)).collect();
        let loads = group.iter().map(|&i| load(problem, &problem.measurements[i], pairs[i])).collect();
        let run = run_options(problem, &problem.measurements[first], &pairs[first]);
        let runs = (0..count).filter(|&i| run_of[i] == i).count();
        let portion = Portion { whole: monitor, share: group.len() as f64 / runs as f64 };
        let simulation = simulate(&scene(problem, speed_m_s, loads, run), &portion)?;
        for (&i, outcome) in group.iter().zip(&simulation.loads) {
            done[i] = true;
            found[i] = DynamicFlat {
                mu_dynamic: slid(outcome.pressure_pa, &outcome.surface).map_err(|error| error.at(i))?,
                stderr: outcome.surface.mu_dynamic_stderr.unwrap_or(0.0),
                mu_static: outcome.surface.mu_static,
            };
        }
    }
    for i in 0..count {
        found[i] = found[run_of[i]];
    }
    Ok(found)
}

/// A part of the work that a monitor watches.
pub struct Portion<'a> {
    /// The monitor of the whole work.
    pub whole: &'a dyn Monitor,
    /// Share of the whole.
    pub share: f64,
}

impl Monitor for Portion<'_> {
    fn seconds(&self) -> f64 {
        self.whole.seconds()
    }

    fn advance(&self, share: f64) {
        self.whole.advance(self.share * share);
    }

    fn cancelled(&self) -> bool {
        self.whole.cancelled()
    }
}
