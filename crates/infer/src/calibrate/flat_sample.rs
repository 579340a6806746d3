//! Flat sample in the spring-block model, for many loads at once.

use slipgrid_base::monitor::Part;
use slipgrid_model::material::LocalFriction;
use slipgrid_model::springblock::{
    Extent, Fidelity, Load, LoadOutcome, Monitor, RunOptions, Scene, Status, run_speed_m_s, shear_modulus_pa,
    shear_period_s, simulate, warm_travel_m,
};

use crate::calibrate::{FitError, Measurement, Problem};

/// Minimum planned travel of a run from rest, in metres; runs from rest determine static peaks.
const MIN_COLD_TRAVEL_M: f64 = 2e-6;
/// Minimum planned duration of a run from rest, in periods of the layer's first shear mode. The average must cover ten
/// periods, and up to half of the record is discarded. At high speeds the travel [`MIN_COLD_TRAVEL_M`] would take less
/// time.
const MIN_PERIODS: f64 = 40.0;
/// The travel of a run from rest is long enough if it exceeds this multiple of the shear displacement at the onset of
/// sliding: the part before the onset may be half of the travel, and the strongest of a thousand blocks exceeds the
/// mean by a sixth.
const MIN_TRAVEL_OVER_ONSET: f64 = 1.9;
/// Multiple of the shear displacement at the onset that replaces a too short travel of a run from rest: at most half of
/// the travel is discarded before averaging.
const TRAVEL_OVER_ONSET: f64 = 2.5;

/// Requested standard error of mean friction in a run from the sheared layer, over the standard deviation of the
/// measurement: both together are 3 % larger than the latter.
const STDERR_OVER_MEASURED: f64 = 0.25;
/// Minimum and maximum of the requested standard error, relative to dynamic friction.
const STDERR_RANGE: [f64; 2] = [2e-4, 2e-3];

/// Speed of the dynamic run for `measured`, in m/s: the measured one, or less if the layer would not slide evenly.
pub fn speed_m_s(problem: &Problem, measured: &Measurement) -> f64 {
    run_speed_m_s(&problem.elastic, problem.pressure_pa(measured), measured.speed_m_s)
}

/// Planned travel of a dynamic run of `measured` with the coefficients `pair`, in metres.
fn travel_m(problem: &Problem, measured: &Measurement, pair: &LocalFriction) -> f64 {
    let (elastic, area_law) = (&problem.elastic, problem.area_law.as_ref());
    if measured.static_peak.is_none() {
        let load = load(problem, measured, *pair);
        return warm_travel_m((elastic, area_law), &problem.layer, &[load], speed_m_s(problem, measured));
    }
    let factor = area_law.map_or(1.0, |law| law.factor(problem.pressure_pa(measured)));
    // u = mu_s f P h / G
    let onset_m = pair.static_mean() * factor * problem.pressure_pa(measured) / shear_modulus_pa(elastic)
        * problem.layer.height_m;
    let travel_m = MIN_COLD_TRAVEL_M
        .max(MIN_PERIODS * shear_period_s(elastic, problem.layer.height_m) * speed_m_s(problem, measured));
    if travel_m > MIN_TRAVEL_OVER_ONSET * onset_m { travel_m } else { TRAVEL_OVER_ONSET * onset_m }
}

fn run_options(problem: &Problem, measured: &Measurement, pair: &LocalFriction) -> RunOptions {
    let [least, most] = STDERR_RANGE;
    let wanted = (STDERR_OVER_MEASURED * measured.mu_dynamic_std / measured.mu_dynamic).clamp(least, most);
    RunOptions {
        fidelity: Fidelity::Dynamic,
        warm_start: measured.static_peak.is_none(),
        sliding_m: travel_m(problem, measured, pair),
        mu_stderr: measured.static_peak.is_none().then_some(wanted),
        ..RunOptions::default()
    }
}

/// Index, for each measurement, of the measurement whose dynamic run represents it. Measurements without a peak at
/// equal load and speed share the run of the measurement with the median coefficient: the excess over steady sliding
/// depends on load and speed, and changes by less than 0.001 over a quarter of friction
/// (`one_run_stands_for_all_at_its_load_and_speed`).
pub fn representatives(problem: &Problem, pairs: &Pairs) -> Vec<usize> {
    let setting = |i: usize| {
        let measured = &problem.measurements[i];
        (measured.static_peak.is_none(), problem.pressure_pa(measured), speed_m_s(problem, measured))
    };
    let for_measurement = |i: usize| {
        if problem.measurements[i].static_peak.is_some() {
            // A measurement with a peak has its own run, except if the coefficients are equal.
            return (0..i).find(|&j| setting(j) == setting(i) && pairs[j] == pairs[i]).unwrap_or(i);
        }
        let mut alike: Vec<usize> = (0..pairs.len()).filter(|&j| setting(j) == setting(i)).collect();
        alike.sort_by(|&a, &b| pairs[a].dynamic_mean().total_cmp(&pairs[b].dynamic_mean()));
        let median = alike[(alike.len() - 1) / 2];
        // Of equal coefficients the first one.
        alike.into_iter().filter(|&j| pairs[j] == pairs[median]).min().unwrap_or(median)
    };
    (0..pairs.len()).map(for_measurement).collect()
}

/// Time steps of the dynamic run of each measurement; 0 for a measurement that uses the run of another.
pub fn planned_steps(problem: &Problem, pairs: &Pairs) -> Vec<u64> {
    let representatives = representatives(problem, pairs);
    let for_measurement = |i: usize| {
        let (measured, pair) = (&problem.measurements[i], &pairs[i]);
        let run = run_options(problem, measured, pair);
        let scene = scene(problem, speed_m_s(problem, measured), vec![load(problem, measured, *pair)], run);
        if representatives[i] == i { slipgrid_model::springblock::planned_steps(&scene) } else { 0 }
    };
    (0..pairs.len()).map(for_measurement).collect()
}

/// Local coefficients, one per measurement.
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

/// Friction of the flat sample in steady sliding; measurements that do not represent themselves in `representatives` get
/// the friction of their representative.
pub fn steady(problem: &Problem, pairs: &Pairs, representatives: &[usize]) -> Result<Vec<f64>, FitError> {
    let own: Vec<usize> = (0..pairs.len()).filter(|&i| representatives[i] == i).collect();
    let loads = own.iter().map(|&i| load(problem, &problem.measurements[i], pairs[i])).collect();
    // Steady sliding does not depend on speed.
    let scene = scene(problem, problem.measurements[0].speed_m_s, loads, RunOptions::default());
    let simulation = simulate(&scene, &slipgrid_model::springblock::Unwatched)?;
    let mut found = vec![0.0; pairs.len()];
    for (&i, outcome) in own.iter().zip(&simulation.loads) {
        found[i] = dynamic_friction(i, outcome)?;
    }
    Ok(representatives.iter().map(|&i| found[i]).collect())
}

/// Dynamic friction of the measurement with index `place`, from 0.
fn dynamic_friction(place: usize, outcome: &LoadOutcome) -> Result<f64, FitError> {
    let (number, pressure_pa) = (place + 1, outcome.pressure_pa);
    match (outcome.surface.status, outcome.surface.mu_dynamic) {
        // A standard error above the requested one is accepted, and propagated as it is.
        (Status::Converged | Status::StderrNotReached, Some(mu)) => Ok(mu),
        (Status::Cancelled, _) => Err(FitError::Cancelled),
        (status, _) => Err(FitError::NoSliding { number, pressure_pa, status: status.name() }),
    }
}

/// Result of a dynamic run for one measurement.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DynamicFlat {
    /// Dynamic friction coefficient.
    pub mu_dynamic: f64,
    /// Standard error of `mu_dynamic`.
    pub stderr: f64,
    /// Static friction coefficient, if a static peak was measured.
    pub mu_static: Option<f64>,
}

/// Makes dynamic runs of the flat sample for the measurements that represent themselves in `representatives`; other
/// measurements get the result of their representative. Runs start from a sheared layer, or from rest if a static peak
/// was measured.
pub fn dynamic(
    problem: &Problem,
    pairs: &Pairs,
    representatives: &[usize],
    monitor: &dyn Monitor,
) -> Result<Vec<DynamicFlat>, FitError> {
    let count = problem.measurements.len();
    let mut found = vec![DynamicFlat::default(); count];
    let mut left: Vec<usize> = (0..count).filter(|&i| representatives[i] == i).collect();
    let runs = left.len() as f64;
    while let Some(&first) = left.first() {
        // One scene for all measurements of equal speed and start.
        let kind =
            |i: usize| (speed_m_s(problem, &problem.measurements[i]), problem.measurements[i].static_peak.is_some());
        let (group, others): (Vec<usize>, Vec<usize>) = left.iter().partition(|&&i| kind(i) == kind(first));
        left = others;
        let (speed_m_s, _) = kind(first);
        let each = group.iter().map(|&i| run_options(problem, &problem.measurements[i], &pairs[i]));
        let run = each.reduce(|all, own| RunOptions {
            sliding_m: all.sliding_m.max(own.sliding_m),
            mu_stderr: all.mu_stderr.zip(own.mu_stderr).map(|(all, own)| all.min(own)),
            ..all
        });
        let run = run.unwrap_or_default();
        let loads = group.iter().map(|&i| load(problem, &problem.measurements[i], pairs[i])).collect();
        let portion = Part::new(monitor, group.len() as f64 / runs);
        let simulation = simulate(&scene(problem, speed_m_s, loads, run), &portion)?;
        for (&i, outcome) in group.iter().zip(&simulation.loads) {
            found[i] = DynamicFlat {
                mu_dynamic: dynamic_friction(i, outcome)?,
                stderr: outcome.surface.mu_dynamic_stderr.unwrap_or(0.0),
                mu_static: outcome.surface.mu_static,
            };
        }
    }
    Ok(representatives.iter().map(|&i| found[i]).collect())
}
