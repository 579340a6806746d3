//! Aiming with what trials say that the model lacks: values compared with the target are those of the physics times the
//! discrepancy's median, where a design asks for that. What the physics alone says stands beside it.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use slipgrid_calibrate::uncertainty::DiscrepancyAt;
use slipgrid_results::{ErrorReport, PressureErrors, Table, fixed};
use slipgrid_units::tidy;

use crate::task::DesignTask;

/// What designs aimed with beside the physics.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DiscrepancyReport {
    /// `ratio` or `mu_dynamic`: the target's quantity.
    pub quantity: Cow<'static, str>,
    /// Trials that it rests on.
    pub trials: usize,
    /// One per target pressure.
    pub by_pressure: Vec<FactorReport>,
    /// Largest distance of the confirming run from the target by the physics alone, in tolerances; null where nothing is demanded.
    pub physics_misfit: Option<f64>,
}

/// The discrepancy at one pressure, and what the physics alone says there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FactorReport {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// Median of a sample's true ratio over the modelled one.
    pub factor: f64,
    /// Standard deviation of its logarithm; Young's modulus is in it.
    pub relative_std: f64,
    /// The factors that 95 % of samples lie between.
    pub interval_95: [f64; 2],
    /// The target's quantity by the search's model without it.
    pub predicted: Reading,
    /// The same by the confirming run.
    pub confirmed: Reading,
    /// Dynamic friction by the confirming run, without it.
    pub mu: Reading,
}

/// A value by the physics alone, with its standard deviation; null where there is none.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// The value.
    pub physics: Option<f64>,
    /// Its standard deviation.
    pub std: Option<f64>,
}

impl From<Option<&ErrorReport>> for Reading {
    fn from(of: Option<&ErrorReport>) -> Self {
        Self { physics: of.and_then(|of| of.value), std: of.and_then(|of| of.std) }
    }
}

impl DiscrepancyReport {
    /// What `lacking`, by so many `trials`, makes of the values that `physics` holds at each pressure of `design`.
    #[must_use]
    pub fn new(design: &DesignTask, trials: usize, lacking: &[DiscrepancyAt], physics: &[PressureErrors]) -> Self {
        let quantity = design.target.quantity().name();
        let at = |(row, at): (&PressureErrors, &DiscrepancyAt)| {
            let [low, high] = at.log_reach_95;
            FactorReport {
                pressure_mpa: row.pressure_mpa,
                factor: tidy(at.factor),
                relative_std: tidy(at.log_std),
                interval_95: [tidy(at.factor * (-low).exp()), tidy(at.factor * high.exp())],
                predicted: row.predicted.as_ref().into(),
                confirmed: if quantity == "ratio" { row.ratio.as_ref().into() } else { Some(&row.mu).into() },
                mu: Some(&row.mu).into(),
            }
        };
        let by_pressure: Vec<FactorReport> = physics.iter().zip(lacking).map(at).collect();
        let values: Option<Vec<f64>> = by_pressure.iter().map(|row| row.confirmed.physics).collect();
        let values = values.filter(|_| design.target.has_demands());
        Self {
            quantity: quantity.into(),
            trials,
            physics_misfit: values.map(|values| tidy(design.target.misfit(&values).max)),
            by_pressure,
        }
    }

    /// What the reader must know of the factors, in one sentence.
    #[must_use]
    pub fn meaning(&self) -> String {
        let known = match self.trials {
            0 => "what is believed before any trial".to_owned(),
            1 => "what one trial says".to_owned(),
            trials => format!("what {trials} trials say"),
        };
        format!(
            "Discrepancy: a sample's true ratio over the modelled one, its median, by {known}; how it depends on the texture no single \
             trial tells, and its standard deviation has that, and Young's modulus, in it"
        )
    }

    /// What the physics alone says, as text.
    #[must_use]
    pub fn text(&self) -> String {
        let mut table = Table::new(["P MPa", "factor", "+-", "predicted", "+-", "confirmed", "+-", "mu", "+-"]);
        for row in &self.by_pressure {
            let cells = [row.predicted, row.confirmed, row.mu].into_iter().flat_map(|read| [read.physics, read.std]);
            let first = [
                row.pressure_mpa.to_string(),
                fixed(Some(row.factor), 3),
                fixed(Some(row.factor * row.relative_std), 3),
            ];
            table.row(first.into_iter().chain(cells.map(|cell| fixed(cell, 4))));
        }
        format!(
            "\n  by the physics alone, which the values above are times the factor of: misfit {}\n{table}",
            fixed(self.physics_misfit, 2),
        )
    }
}
