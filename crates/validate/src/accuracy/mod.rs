//! Comparison of speed and error of every method, on one page.

mod difference;
mod front;
mod measure;
mod page;
mod plan;
mod report;
mod scene;
mod text;

use slipgrid_base::monitor::{Monitor, Stage};
use slipgrid_model::springblock::{Scene, SceneError, Unwatched, simulate};

use crate::StudyError;
use plan::{Role, rows};
use report::model_notes;

pub use page::page;
pub use plan::Size;
pub use report::{AccuracyReport, Machine};
pub use scene::{base, paper_scene, reduced};
pub use text::{csv, markdown, picture};

/// Checks that the reference accepts the scene, without running it.
///
/// # Errors
/// [`SceneError`] of the reference.
pub fn check_reference(base: &Scene) -> Result<(), SceneError> {
    base.validate()?;
    // The check of the step reports its limit: the step of the reference must be within that limit.
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

/// Time step of the published scheme.
const REFERENCE_STEP_S: f64 = 1e-9;

/// Estimated wall time for comparing the methods of `size` on `base` with all threads, in seconds.
#[must_use]
pub fn expected_wall_s(size: Size, base: &Scene, seeds: u64) -> f64 {
    measure::expected_wall_s(&rows(size, base, seeds), base, rayon::current_num_threads())
}

/// Runs the rows of `size` on `base`, each for `seeds` draws of the local coefficients, on a `machine`, and makes the
/// page; `source` names the origin of the scene. Times are measured with the monitor's clock.
///
/// # Errors
/// [`StudyError::Cancelled`] if the monitor has cancelled.
pub fn compare(
    size: Size,
    base: &Scene,
    source: &str,
    seeds: u64,
    machine: Machine,
    monitor: &dyn Monitor,
) -> Result<AccuracyReport, StudyError> {
    let rows = rows(size, base, seeds);
    let progress = Stage::new(monitor, "accuracy", None);
    let runs = measure::measure_all(&rows, base, size == Size::Full, &progress);
    let wall_s = progress.finish();
    monitor.heed()?;
    debug_assert!(rows.iter().filter(|row| row.role == Role::Judge).count() == 1);
    let size_name = match size {
        Size::Quick => "quick",
        Size::Full => "full",
    };
    let model = model_notes(base, source, size_name, seeds);
    Ok(AccuracyReport::new(size_name, model, &rows, &runs, machine, wall_s, rayon::current_num_threads()))
}

#[cfg(test)]
mod tests;
