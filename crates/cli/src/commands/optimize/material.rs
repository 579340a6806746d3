//! The material of a design, calibrated where its file names a calibration.

use std::path::Path;

use slipgrid_calibrate::Selection;
use slipgrid_design::KnownMaterial;
use slipgrid_formats::calibration::Calibration;
use slipgrid_formats::design::Design;

use crate::commands::calibrate::{outcome, provisional};
use crate::input::disk;
use crate::{CliError, Console};

/// Gives the task of `design` its material where that has to be calibrated first, and returns the calibration.
///
/// # Errors
/// [`CliError`] for a calibration that is refused or fails.
pub fn complete(design: &mut Design, console: &mut Console<'_>) -> Result<Option<Calibration>, CliError> {
    let Some(path) = design.calibration.clone() else { return Ok(None) };
    let (material, calibration) = calibrated(&path, design, console)?;
    design.task.material = Some(material);
    Ok(Some(calibration))
}

/// The material of the calibration file at `path`, as far as `design` needs it.
fn calibrated(
    path: &Path,
    design: &mut Design,
    console: &mut Console<'_>,
) -> Result<(KnownMaterial, Calibration), CliError> {
    let calibration = Calibration::read(&disk(), path)?;
    // A pressure or condition that was not measured is refused before anything is computed.
    let measured = provisional(&calibration)?;
    let checked = design.task.resolve(&measured.friction);
    checked.map_err(|refused| design.refuse(&refused))?;
    let task = &design.task;
    task.loads(&measured).map_err(|refused| design.refuse(&refused))?;
    let conditions = task.condition.iter().chain(&task.also_at).copied().collect();
    let selection = Selection { conditions, pressures_pa: task.pressures_pa() };
    let (_, found) = outcome(path, &calibration, (task.layer, task.seed), selection, console)?;
    Ok((KnownMaterial { material: found.material, uncertainty: found.uncertainty }, calibration))
}
