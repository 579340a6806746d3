//! The speeds and humidities beside the one designed for at which the target must hold.

use slipgrid_material::{Condition, Material};
use slipgrid_springblock::{Load, Simulation};

use super::aim::factors;
use crate::CliError;
use crate::formats::design::Design;
use crate::formats::material_uncertainty::MaterialUncertainty;

/// A condition beside the one designed for.
#[derive(Clone, Debug)]
pub struct Further {
    /// Speed and humidity.
    pub condition: Condition,
    /// The target's pressures with the coefficients that hold here.
    pub loads: Vec<Load>,
    /// Whether each pressure lies outside the measured range.
    pub outside: Vec<bool>,
    /// The confirming run of the best design here, where it was run in time.
    pub confirmed: Option<Simulation>,
}

/// The conditions of `design` beside the one designed for.
///
/// # Errors
/// [`CliError`] for a condition outside those measured.
pub fn further(design: &Design, material: &Material) -> Result<Vec<Further>, CliError> {
    let mut all = Vec::new();
    for condition in &design.also_at {
        let (loads, outside) = design.loads_at(material, condition)?;
        all.push(Further { condition: *condition, loads, outside, confirmed: None });
    }
    Ok(all)
}

/// What values are multiplied by before they are compared with the target: at each of `loads` of the condition designed for,
/// then at those of each of `further`, with the discrepancy of its humidity.
#[must_use]
pub fn all_factors(design: &Design, material: &MaterialUncertainty, loads: &[Load], further: &[Further]) -> Vec<f64> {
    let at = |further: &Further| factors(design, material, Some(further.condition.humidity), &further.loads);
    factors(design, material, design.humidity(), loads).into_iter().chain(further.iter().flat_map(at)).collect()
}
