//! Errors of a simulated scene, and its numbers times the discrepancy of patterned samples.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::errors::ErrorReport;
use super::table::{Table, fixed};

/// Ratio and friction times measured over modelled ratio of patterned samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CorrectedReport {
    /// The patterned samples behind it.
    pub pattern: String,
    /// The scene's planform, where that of the patterned samples was another.
    pub other_planform: Option<Cow<'static, str>>,
    /// Measured ratios less coefficients.
    pub degrees_of_freedom: usize,
    /// One per pressure.
    pub by_pressure: Vec<CorrectedAt>,
}

/// The same at one pressure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
            self.other_planform
                .as_ref()
                .map_or_else(String::new, |own| format!(", which {own}s are not: take it as a guess")),
            if outside.is_empty() {
                String::new()
            } else {
                format!("; {} MPa lies outside the pressures measured", outside.join(", "))
            },
        )
    }
}
