//! Comparison of the speed and the error of every method of solution.
//!
//! | module | content |
//! |---|---|
//! | `scene` | the source paper's specimen, and its reduced form |
//! | `plan` | methods as named changes to a scene |
//! | `measure` | runs of a method, with their time |
//! | `comparison` | errors against the reference, and the front of time and error |
//! | `output` | Markdown, CSV and a picture |

mod comparison;
mod measure;
mod output;
mod plan;
mod scene;

use serde::Serialize;
use slipgrid_base::monitor::{Monitor, Stage};
use slipgrid_base::units::{LENGTH_UM, PRESSURE_MPA, SPEED_MM_S};
use slipgrid_design::results::{MadeBy, SCHEMA};
use slipgrid_model::springblock::{Scene, SceneError, Unwatched, simulate};

use crate::Failure;
use comparison::Compared;

pub use output::{csv, markdown, picture};
pub use plan::Size;
pub use scene::{base, paper_scene, reduced};

/// Result of a comparison, as `accuracy --json` prints it.
#[derive(Clone, Debug, Serialize)]
pub struct Accuracy {
    #[serde(flatten)]
    made_by: MadeBy,
    /// `quick` or `full`.
    size: &'static str,
    /// Description of the scene and of the comparison.
    model: Vec<String>,
    /// Smallest distinguishable error in dynamic mu, static mu and the ratio, in per cent; null where it is unknown.
    resolution_pct: [Option<f64>; 3],
    /// Methods, the reference first.
    methods: Vec<Compared>,
    /// Architecture of the processor, and operating system.
    machine: [&'static str; 2],
    /// Total wall time, in seconds.
    wall_s: f64,
    /// Number of threads.
    threads: usize,
}

/// Checks that the reference method accepts the scene `base`, without running the scene.
///
/// # Errors
/// [`SceneError`] for a scene that the reference method refuses.
pub fn check_reference(base: &Scene) -> Result<(), SceneError> {
    base.validate()?;
    // A step that is too long is refused with the stability limit, which the step of the reference must not exceed.
    let mut probe = base.clone();
    probe.run.step_s = Some(f64::MAX);
    match simulate(&probe, &Unwatched) {
        Err(SceneError::UnstableStep { limit_s, scheme, .. }) if REFERENCE_STEP_S > limit_s => {
            Err(SceneError::UnstableStep { step_s: REFERENCE_STEP_S, limit_s, scheme })
        }
        Err(SceneError::UnstableStep { .. }) | Ok(_) => Ok(()),
        Err(error) => Err(error),
    }
}

/// Time step of the published scheme, in seconds.
const REFERENCE_STEP_S: f64 = 1e-9;

/// Estimated wall time of the comparison of all methods of `size` on the scene `base`, in seconds.
pub fn expected_wall_s(size: Size, base: &Scene, seeds: u64) -> f64 {
    plan::methods(size, base).iter().map(|method| measure::expected_wall_s(method, base, seeds)).sum()
}

/// Runs the methods of `size` on the scene `base`, each for `seeds` random draws of the local friction coefficients,
/// and compares them with the reference. `source` describes the origin of the scene; `machine` is the architecture and
/// the operating system. Times are measured with the monitor's clock.
///
/// # Errors
/// [`Failure::Cancelled`] once the monitor has cancelled.
pub fn compare(
    size: Size,
    base: &Scene,
    source: &str,
    seeds: u64,
    machine: [&'static str; 2],
    monitor: &dyn Monitor,
) -> Result<Accuracy, Failure> {
    let methods = plan::methods(size, base);
    let progress = Stage::new(monitor, "accuracy", None);
    let all_s = expected_wall_s(size, base, seeds);
    let runs: Vec<Vec<measure::Run>> =
        methods.iter().map(|method| measure::measure_all(method, base, seeds, all_s, &progress)).collect();
    let wall_s = progress.finish();
    monitor.heed()?;
    let (resolution_pct, methods) = comparison::compare(methods, &runs);
    Ok(Accuracy {
        made_by: MadeBy::slipgrid(SCHEMA),
        size: size.name(),
        model: describe(size, base, source, seeds),
        resolution_pct,
        methods,
        machine,
        wall_s,
        threads: rayon::current_num_threads(),
    })
}

/// Describes the scene and the comparison.
fn describe(size: Size, scene: &Scene, source: &str, seeds: u64) -> Vec<String> {
    let um = |length_m: f64| (LENGTH_UM.from_si(length_m) * 1e3).round() / 1e3;
    let mut notes = vec![source.to_owned()];
    if size == Size::Quick {
        notes.push(
            "quick: a short specimen, a thin layer and little travel; --full takes the scene as it is".to_owned(),
        );
    }
    if let Some(load) = scene.loads.first() {
        notes.push(format!(
            "{} x {} blocks of {} um, {} MPa, {} mm/s, {} um of travel, damping {} sqrt(k/m)",
            scene.layer.columns(),
            scene.layer.rows(),
            um(scene.layer.block_m),
            PRESSURE_MPA.from_si(load.pressure_pa),
            SPEED_MM_S.from_si(scene.speed_m_s),
            um(scene.run.sliding_m),
            scene.run.damping,
        ));
    }
    notes.extend(scene.pattern.map(|pattern| {
        let [width_um, spacing_um, depth_um] = pattern.lengths_m().map(um);
        let name = pattern.planform().name();
        format!(
            "{name} {width_um} um wide, spacing {spacing_um} um, {depth_um} um deep; the ratio is to the flat surface"
        )
    }));
    notes.extend(
        [
            "reference: the whole sample by the published scheme (Runge-Kutta of order 4, 1 ns, exact springs), from rest",
            "+-: standard error of a difference, the larger of the scatter between draws and the batch means of both runs",
            "n.s.: not significant, below 2 standard errors (Student's t where only the draws tell, as for static mu)",
            "the reference's own blocks have an error, so that methods with other blocks are not on the front",
        ]
        .map(str::to_owned),
    );
    notes.push(format!("{seeds} draws of the local coefficients for each method, equal for all methods"));
    notes
}

#[cfg(test)]
mod tests;
