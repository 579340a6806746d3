//! Errors of a simulated scene, and its numbers times the discrepancy of patterned samples.

use serde::Serialize;
use slipgrid_calibrate::uncertainty::{DiscrepancyAt, InputUncertainty, Slopes};
use slipgrid_springblock::Simulation;

use super::errors::{ErrorReport, ErrorsReport, Solved};
use super::table::{Table, fixed};
use crate::CliError;
use crate::formats::scene::SceneInput;
use slipgrid_units::{PRESSURE_MPA, tidy};

/// Ratio and friction times measured over modelled ratio of patterned samples.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CorrectedReport {
    /// The patterned samples behind it.
    pub pattern: String,
    /// The scene's planform, where that of the patterned samples was another.
    pub other_planform: Option<&'static str>,
    /// Measured ratios less coefficients.
    pub degrees_of_freedom: usize,
    /// One per pressure.
    pub by_pressure: Vec<CorrectedAt>,
}

/// The same at one pressure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CorrectedAt {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// Measured over modelled ratio.
    pub factor: f64,
    /// Its standard deviation over itself, widened for few measurements; without the modulus.
    pub factor_relative_std: f64,
    /// The patterned samples were measured at lower or higher pressures only.
    pub outside_measured_range: bool,
    /// The ratio times the factor.
    pub ratio: Option<ErrorReport>,
    /// Dynamic friction times the factor.
    pub mu: ErrorReport,
}

/// Errors of the solved scene of `input`, and its numbers with the discrepancy where its material has one.
///
/// # Errors
/// [`CliError::Material`] for an area law that cannot be moved by its errors.
pub fn of_scene(
    input: &SceneInput,
    simulation: &Simulation,
) -> Result<(ErrorsReport, Option<CorrectedReport>), CliError> {
    let (scene, uncertainty) = (&input.scene, &input.uncertainty);
    let knowledge = uncertainty.at_loads(scene.area_law.as_ref(), &scene.loads, input.condition.as_ref())?;
    let slopes = Slopes::new(scene, &knowledge);
    let solved = Solved { scene, simulation, knowledge: &knowledge, slopes: &slopes };
    let rows = solved.errors();
    let errors = ErrorsReport::new(rows.clone(), solved.unknown(uncertainty, &rows), false);
    let found = uncertainty.discrepancy_at(input.condition.map(|condition| condition.humidity));
    let Some((found, pattern)) = found.zip(scene.pattern.as_ref()) else {
        return Ok((errors, None));
    };
    let factors = DiscrepancyAt::each(&found, &scene.loads);
    let aimed = InputUncertainty { discrepancy: Some(factors.clone()), ..knowledge.clone() };
    let corrected = Solved { knowledge: &aimed, ..solved }.errors();
    let samples = uncertainty.discrepancy_pattern.clone().unwrap_or_default();
    let planform = pattern.planform().name();
    let by_pressure = corrected
        .into_iter()
        .zip(&factors)
        .zip(&scene.loads)
        .map(|((row, factor), load)| CorrectedAt {
            pressure_mpa: PRESSURE_MPA.from_si(load.pressure_pa),
            factor: tidy(factor.factor),
            factor_relative_std: tidy(factor.relative_std()),
            outside_measured_range: found.is_outside_measured_range(load.pressure_pa),
            ratio: row.ratio,
            mu: row.mu,
        })
        .collect();
    let report = CorrectedReport {
        other_planform: (!samples.starts_with(planform)).then_some(planform),
        pattern: samples,
        degrees_of_freedom: found.degrees_of_freedom,
        by_pressure,
    };
    Ok((errors, Some(report)))
}

impl CorrectedReport {
    /// As text: what it is, and the numbers.
    #[must_use]
    pub fn text(&self) -> String {
        let mut table = Table::new(["P MPa", "factor", "+-", "ratio", "+-", "mu", "+-"]);
        for row in &self.by_pressure {
            let (ratio, mu) = (row.ratio.as_ref(), &row.mu);
            let factor = [row.factor, row.factor * row.factor_relative_std].map(|value| fixed(Some(value), 3));
            let cells = [ratio.and_then(|of| of.value), ratio.and_then(|of| of.std), mu.value, mu.std];
            let cells = cells.into_iter().map(|cell| fixed(cell, 4));
            table.row([row.pressure_mpa.to_string()].into_iter().chain(factor).chain(cells));
        }
        let outside: Vec<String> = self
            .by_pressure
            .iter()
            .filter(|row| row.outside_measured_range)
            .map(|row| row.pressure_mpa.to_string())
            .collect();
        format!(
            "\n  were the model as far off as on patterned samples ({}; degrees of freedom: {}){}{}\n{table}",
            self.pattern,
            self.degrees_of_freedom,
            self.other_planform.map_or_else(String::new, |own| format!(", which {own}s are not: take it as a guess")),
            if outside.is_empty() {
                String::new()
            } else {
                format!("; {} MPa lies outside the pressures measured", outside.join(", "))
            },
        )
    }
}
