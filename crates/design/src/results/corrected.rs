//! Results of a scene multiplied by the discrepancy that trials show.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::errors::ErrorReport;
use super::table::{Table, fixed};

/// Ratio and friction corrected by the discrepancy that trials show.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CorrectedReport {
    /// Number of trials used.
    pub trials: usize,
    /// Corrected values, one entry per pressure.
    pub by_pressure: Vec<CorrectedAt>,
}

/// Corrected values at one pressure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CorrectedAt {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// Correction factor: median of the true ratio of a sample over the modelled ratio.
    pub factor: f64,
    /// Standard deviation of the factor's logarithm; it contains the error of Young's modulus.
    pub factor_relative_std: f64,
    /// Ratio times the factor; null where the flat surface was not solved.
    pub ratio: Option<ErrorReport>,
    /// Dynamic friction times the factor.
    pub mu: ErrorReport,
}

impl CorrectedReport {
    /// Formats the corrected values as a heading and a table.
    pub fn text(&self) -> String {
        format!("\n  {}\n{}", self.meaning(), self.table())
    }

    /// States that the numbers include the discrepancy, and from how many trials.
    pub fn meaning(&self) -> String {
        let trials = if self.trials == 1 { "one trial".to_owned() } else { format!("{} trials", self.trials) };
        format!("the model corrected by {trials}")
    }

    /// Corrected values, one row per pressure.
    pub fn table(&self) -> Table {
        let mut table = Table::new(["P MPa", "factor", "+-", "ratio", "+-", "mu", "+-"]);
        for row in &self.by_pressure {
            let (ratio, mu) = (row.ratio.as_ref(), &row.mu);
            let factor = [row.factor, row.factor * row.factor_relative_std].map(|value| fixed(Some(value), 3));
            let cells = [ratio.and_then(|of| of.value), ratio.and_then(|of| of.std), mu.value, mu.std];
            let cells = cells.into_iter().map(|cell| fixed(cell, 4));
            table.row([row.pressure_mpa.to_string()].into_iter().chain(factor).chain(cells));
        }
        table
    }
}
