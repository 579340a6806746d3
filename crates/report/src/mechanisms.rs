//! Picture of the predictions of `next --learn` by mechanism.

use slipgrid_design::{LearningReport, RatioPrediction, percent};

use crate::ChartError;
use crate::charts::{self, MechanismRow};

/// Name of the file.
pub const FILE: &str = "mechanisms.svg";

/// Draws the ratios of both sectors and their quotient by mechanism, at the load that teaches most, for the design `name`.
///
/// # Errors
/// [`ChartError`] if a value is not finite.
pub fn picture(name: &str, learning: &LearningReport) -> Result<String, ChartError> {
    let value = |of: &RatioPrediction| (of.ratio, of.interval_95);
    let mut pressure_mpa = 0.0;
    let rows: Vec<MechanismRow> = learning
        .mechanisms
        .iter()
        .filter_map(|of| Some((of, of.loads.get(learning.load)?)))
        .map(|(of, at)| {
            pressure_mpa = at.quotient.pressure_mpa;
            let [first, second] = &at.ratios;
            let name = format!("{}, {}", of.mechanism, percent(of.weight));
            MechanismRow { name, values: [first, second, &at.quotient].map(value).to_vec() }
        })
        .collect();
    let title = format!("{name}: ratio to the flat surface at {pressure_mpa} MPa, median and 95 % of samples");
    charts::mechanisms(&title, &["sector 1", "sector 2", "sector 2 / sector 1"], &rows)
}
