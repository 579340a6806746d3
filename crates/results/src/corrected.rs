//! A simulated scene's numbers times what trials say that the model lacks.

use serde::{Deserialize, Serialize};

use super::errors::ErrorReport;
use super::table::{Table, fixed};

/// Ratio and friction times what trials say that the model lacks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CorrectedReport {
    /// Trials behind it.
    pub trials: usize,
    /// One per pressure.
    pub by_pressure: Vec<CorrectedAt>,
}

/// The same at one pressure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CorrectedAt {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// Median of a sample's true ratio over the modelled one.
    pub factor: f64,
    /// Standard deviation of its logarithm; Young's modulus is in it.
    pub factor_relative_std: f64,
    /// The ratio times the factor.
    pub ratio: Option<ErrorReport>,
    /// Dynamic friction times the factor.
    pub mu: ErrorReport,
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
        let trials = if self.trials == 1 { "one trial says".to_owned() } else { format!("{} trials say", self.trials) };
        format!("\n  with what {trials} that the model lacks\n{table}")
    }
}
