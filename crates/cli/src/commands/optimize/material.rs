//! The material of a design, calibrated where its file names a calibration.

use std::path::Path;

use slipgrid_calibrate::Selection;
use slipgrid_design::{DesignTask, KnownMaterial};
use slipgrid_formats::calibration::Calibration;
use slipgrid_formats::design::Design;

use crate::commands::calibrate::{outcome, provisional};
use crate::input::disk;
use crate::{CliError, Console};

/// Gives the task of `design` its material where that has to be calibrated first.
///
/// # Errors
/// [`CliError`] for a calibration that is refused or fails.
pub fn complete(design: &mut Design, console: &mut Console<'_>) -> Result<(), CliError> {
    if let Some(path) = design.calibration.clone() {
        design.task.material = Some(calibrated(&path, design, console)?);
    }
    Ok(())
}

/// The material of the calibration file at `path`, as far as `design` needs it.
fn calibrated(path: &Path, design: &mut Design, console: &mut Console<'_>) -> Result<KnownMaterial, CliError> {
    let calibration = Calibration::read(&disk(), path)?;
    // A pressure or condition that was not measured is refused before anything is computed.
    let measured = provisional(&calibration)?;
    let checked = design.task.resolve(&measured.friction);
    checked.map_err(|refused| design.refuse(&refused))?;
    let task = &design.task;
    task.loads(&measured).map_err(|refused| design.refuse(&refused))?;
    let has_patterned = calibration.pattern.is_some() && !calibration.patterned.is_empty();
    if task.discrepancy && !(has_patterned && calibration.discrepancy.is_some()) {
        let reason = "needs patterned samples in the calibration, which has none";
        return Err(design.refuse(&DesignTask::refuse_discrepancy(reason)).into());
    }
    let conditions = task.condition.iter().chain(&task.also_at).copied().collect();
    let selection = Selection { conditions, pressures_pa: task.pressures_pa() };
    let (_, found) = outcome(path, &calibration, (task.layer, task.seed), selection, console)?;
    let (material, uncertainty) = (found.material, found.uncertainty);
    if task.discrepancy && uncertainty.discrepancy_at(task.humidity()).is_none() {
        let reason = "needs conditions measured on both flat and patterned samples, which the calibration lacks";
        return Err(design.refuse(&DesignTask::refuse_discrepancy(reason)).into());
    }
    Ok(KnownMaterial { material, uncertainty })
}
