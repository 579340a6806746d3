//! The flat sample in the spring-block model, for many loads at once.

use slipgrid_material::LocalFriction;
use slipgrid_springblock::{Extent, Fidelity, Load, Monitor, RunOptions, Scene, Status, SurfaceOutcome, simulate};

use crate::{CalibrationError, Measurement, Problem};

/// Travel of a dynamic run from steady sliding, in metres: a hundred stick-slip cycles of a block.
/// Against four times the travel the mean moves by less than 0.03 %.
const WARM_TRAVEL_M: f64 = 0.4e-6;
/// Travel of a run from rest, which finds the static peak, in metres.
const COLD_TRAVEL_M: f64 = 2e-6;

/// Periods of the layer's first shear mode that a run lasts at least: its last two fifths, which are averaged, must hold
/// ten. At high speeds the travels above are over sooner.
const LEAST_PERIODS: f64 = 40.0;

/// `usual_m`, or what `speed_m_s` covers in [`LEAST_PERIODS`], in metres.
fn travel_m(problem: &Problem, speed_m_s: f64, usual_m: f64) -> f64 {
    let elastic = &problem.elastic;
    // c_s = sqrt(G / rho), G = 3 E / 8
    let shear_wave_m_s = (0.375 * elastic.youngs_modulus_pa() / elastic.density_kg_m3()).sqrt();
    // T = 4 h / c_s
    let period_s = 4.0 * problem.layer.height_m / shear_wave_m_s;
    usual_m.max(LEAST_PERIODS * period_s * speed_m_s)
}

/// Coefficients at each measurement.
pub type Pairs = Vec<LocalFriction>;

fn scene(problem: &Problem, speed_m_s: f64, loads: Vec<Load>, run: RunOptions) -> Scene {
    Scene {
        elastic: problem.elastic,
        area_law: problem.area_law.clone(),
        pattern: None,
        layer: problem.layer,
        loads,
        speed_m_s,
        run: RunOptions { extent: Extent::Sample, seed: problem.seed, ..run },
    }
}

fn load(measured: &Measurement, friction: LocalFriction) -> Load {
    Load { pressure_pa: measured.pressure_pa, friction }
}

/// mu of the flat sample in steady sliding, one per measurement.
pub fn steady(problem: &Problem, pairs: &Pairs) -> Result<Vec<f64>, CalibrationError> {
    let loads = problem.measurements.iter().zip(pairs).map(|(measured, pair)| load(measured, *pair)).collect();
    // Speed plays no part in steady sliding.
    let scene = scene(problem, problem.measurements[0].speed_m_s, loads, RunOptions::default());
    let simulation = simulate(&scene, &slipgrid_springblock::Unwatched)?;
    simulation.loads.iter().map(|outcome| slid(outcome.pressure_pa, &outcome.surface)).collect()
}

fn slid(pressure_pa: f64, surface: &SurfaceOutcome) -> Result<f64, CalibrationError> {
    match (surface.status, surface.mu_dynamic) {
        (Status::Converged, Some(mu)) => Ok(mu),
        (Status::Cancelled, _) => Err(CalibrationError::Cancelled),
        (status, _) => Err(CalibrationError::NoSliding { pressure_pa, status: status.name() }),
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
pub fn dynamic(problem: &Problem, pairs: &Pairs, monitor: &dyn Monitor) -> Result<Vec<DynamicFlat>, CalibrationError> {
    let count = problem.measurements.len();
    let mut found = vec![DynamicFlat::default(); count];
    // Measurements that differ in nothing the model sees, as humidities do under one pair, share a run.
    let seen = |i: usize| {
        let measured = &problem.measurements[i];
        (measured.pressure_pa, measured.speed_m_s, measured.static_peak.is_some(), pairs[i])
    };
    let run_of: Vec<usize> = (0..count).map(|i| (0..i).find(|&j| seen(j) == seen(i)).unwrap_or(i)).collect();
    let mut done: Vec<bool> = (0..count).map(|i| run_of[i] != i).collect();
    while let Some(first) = done.iter().position(|done| !done) {
        // One scene for all measurements of the same speed and kind of start.
        let kind = |measured: &Measurement| (measured.speed_m_s, measured.static_peak.is_some());
        let (speed_m_s, from_rest) = kind(&problem.measurements[first]);
        let group: Vec<usize> =
            (first..count).filter(|&i| !done[i] && kind(&problem.measurements[i]) == (speed_m_s, from_rest)).collect();
        let loads = group.iter().map(|&i| load(&problem.measurements[i], pairs[i])).collect();
        let run = RunOptions {
            fidelity: Fidelity::Dynamic,
            warm_start: !from_rest,
            sliding_m: travel_m(problem, speed_m_s, if from_rest { COLD_TRAVEL_M } else { WARM_TRAVEL_M }),
            ..RunOptions::default()
        };
        let runs = (0..count).filter(|&i| run_of[i] == i).count();
        let portion = Portion { whole: monitor, share: group.len() as f64 / runs as f64 };
        let simulation = simulate(&scene(problem, speed_m_s, loads, run), &portion)?;
        for (&i, outcome) in group.iter().zip(&simulation.loads) {
            done[i] = true;
            found[i] = DynamicFlat {
                mu_dynamic: slid(outcome.pressure_pa, &outcome.surface)?,
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
