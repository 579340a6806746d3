//! The material of a design, given or calibrated first.

use std::path::Path;

use slipgrid_material::Material;

use crate::commands::calibrate::{Purpose, material, provisional};
use crate::formats::calibration::Calibration;
use crate::formats::design::{Design, MaterialInput};
use crate::formats::material_uncertainty::MaterialUncertainty;
use crate::{CliError, Console};

/// The material of `design` and what is known of its errors.
///
/// # Errors
/// [`CliError`] for a calibration that is refused or fails.
pub fn of_design(design: &Design, console: &mut Console<'_>) -> Result<(Material, MaterialUncertainty), CliError> {
    match &design.material {
        MaterialInput::Given(material) => Ok((material.as_ref().clone(), design.uncertainty.clone())),
        MaterialInput::Calibration(path) => calibrated(path, design, console),
    }
}

/// The material of the calibration file at `path`, as far as `design` needs it.
fn calibrated(
    path: &Path,
    design: &Design,
    console: &mut Console<'_>,
) -> Result<(Material, MaterialUncertainty), CliError> {
    let calibration = Calibration::read(path)?;
    // A pressure or condition that was not measured is refused before anything is computed.
    design.loads(&provisional(&calibration)?)?;
    let errors = design.tolerances.is_some();
    let purpose = Purpose { condition: design.condition, layer: design.layer, seed: design.seed, errors };
    material(path, &calibration, &purpose, console)
}
