//! The material of a design, given or calibrated first.

use std::path::Path;

use slipgrid_calibrate::Selection;
use slipgrid_material::Material;

use crate::commands::calibrate::{outcome, provisional};
use crate::formats::calibration::Calibration;
use crate::formats::design::{Design, MaterialInput};
use crate::{CliError, Console};
use slipgrid_calibrate::uncertainty::MaterialUncertainty;

/// The material of `design` and what is known of its errors; the conditions of the design are known then.
///
/// # Errors
/// [`CliError`] for a calibration that is refused or fails.
pub fn of_design(design: &mut Design, console: &mut Console<'_>) -> Result<(Material, MaterialUncertainty), CliError> {
    let (mut material, uncertainty) = match design.material.clone() {
        MaterialInput::Given(material) => (*material, design.uncertainty.clone()),
        MaterialInput::Calibration(path) => calibrated(&path, design, console)?,
    };
    let conditions = design.condition.iter().chain(&design.also_at);
    let interpolated = conditions.filter_map(|condition| material.friction.interpolation(Some(condition)));
    material.provenance.notes.extend(interpolated);
    Ok((material, uncertainty))
}

/// The material of the calibration file at `path`, as far as `design` needs it.
fn calibrated(
    path: &Path,
    design: &mut Design,
    console: &mut Console<'_>,
) -> Result<(Material, MaterialUncertainty), CliError> {
    let calibration = Calibration::read(path)?;
    // A pressure or condition that was not measured is refused before anything is computed.
    let measured = provisional(&calibration)?;
    design.resolve(&measured.friction)?;
    design.loads(&measured)?;
    let has_patterned = calibration.pattern.is_some() && !calibration.patterned.is_empty();
    if design.discrepancy && !(has_patterned && calibration.discrepancy.is_some()) {
        return Err(design.refuse_discrepancy("needs patterned samples in the calibration, which has none").into());
    }
    let conditions = design.condition.iter().chain(&design.also_at).copied().collect();
    let selection = Selection { conditions, pressures_pa: design.pressures_pa() };
    let (_, found) = outcome(path, &calibration, (design.layer, design.seed), selection, console)?;
    let (material, uncertainty) = (found.material, found.uncertainty);
    if design.discrepancy && uncertainty.discrepancy_at(design.humidity()).is_none() {
        let reason = "needs conditions measured on both flat and patterned samples, which the calibration lacks";
        return Err(design.refuse_discrepancy(reason).into());
    }
    Ok((material, uncertainty))
}
