//! The error beside every number of a design.

use slipgrid_calibrate::uncertainty::{DiscrepancyAt, Slopes};
use slipgrid_optimize::Quantity;
use slipgrid_springblock::{Scene, Simulation};

use crate::CliError;
use crate::formats::design::Design;
use crate::formats::material_uncertainty::MaterialUncertainty;
use crate::report::errors::{ErrorReport, ErrorsReport, Solved};
use crate::units::tidy;

/// Errors of the values of `confirmed`, which came of `scene`: `predicted` is the target's quantity as the search took it.
/// The design itself is taken as exact.
///
/// # Errors
/// [`CliError::Other`] for an area law that cannot be moved.
pub fn of_design(
    design: &Design,
    material: &MaterialUncertainty,
    scene: &Scene,
    confirmed: &Simulation,
    predicted: &[f64],
) -> Result<ErrorsReport, CliError> {
    let mut knowledge = material
        .knowledge(scene.area_law.as_ref(), &scene.loads, design.condition.as_ref())
        .map_err(|error| CliError::Other(error.to_string()))?;
    let discrepancy = material.discrepancy.as_ref().filter(|_| design.discrepancy);
    knowledge.discrepancy = discrepancy.map(|found| DiscrepancyAt::each(found, &scene.loads));
    let slopes = Slopes::new(scene, &knowledge);
    let solved = Solved { scene, simulation: confirmed, knowledge: &knowledge, slopes: &slopes };
    let mut rows = solved.errors();
    for (place, (row, value)) in rows.iter_mut().zip(predicted).enumerate() {
        let material = solved.deviations(place).map(|of| match design.target.quantity() {
            Quantity::Ratio => of.ratio,
            Quantity::DynamicFriction => of.mu,
        });
        row.predicted = Some(ErrorReport::new(Some(tidy(*value)), Vec::new(), material.as_ref()));
    }
    let unknown = solved.unknown(material, &rows);
    Ok(ErrorsReport::new(rows, unknown, design.discrepancy))
}
