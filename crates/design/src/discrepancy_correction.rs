//! Aiming with the model's error on patterned samples: values compared with the target are those of the physics times
//! the discrepancy's factor, where a design asks for that. What the other reading says stands beside it.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use slipgrid_calibrate::uncertainty::DiscrepancyAt;
use slipgrid_pattern::Pattern;
use slipgrid_springblock::Load;

use crate::task::DesignTask;
use crate::trial_domain::DomainReport;
use crate::uncertainty_budget::DesignErrors;
use slipgrid_calibrate::uncertainty::MaterialUncertainty;
use slipgrid_results::Table;
use slipgrid_results::{ErrorReport, PressureErrors};
use slipgrid_results::{fixed, with_error};
use slipgrid_units::{PRESSURE_MPA, tidy};

/// Modelled values with and without the discrepancy of the calibration's patterned samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DiscrepancyReport {
    /// The search aimed with it: everything compared with the target is times `factor`.
    pub used: bool,
    /// `ratio` or `mu_dynamic`: the target's quantity.
    pub quantity: Cow<'static, str>,
    /// The patterned samples behind it.
    pub pattern: String,
    /// The design's planform, where that of the patterned samples was another.
    pub other_planform: Option<Cow<'static, str>>,
    /// The patterns that it is used for, beside the design; null where the material does not say what the samples were.
    pub domain: Option<DomainReport>,
    /// Measured ratios less coefficients.
    pub degrees_of_freedom: usize,
    /// One per target pressure.
    pub by_pressure: Vec<FactorReport>,
    /// Largest distance of the confirming run from the target, in tolerances; null where nothing is demanded.
    pub misfit: MisfitReading,
}

/// The discrepancy at one pressure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FactorReport {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// exp(d): measured over modelled ratio.
    pub factor: f64,
    /// Its standard deviation over itself, widened for few measurements as Student's t is; without the modulus.
    pub relative_std: f64,
    /// The patterned samples were measured at lower or higher pressures only.
    pub outside_measured_range: bool,
    /// The target's quantity by the search's model.
    pub predicted: Reading,
    /// The same by the confirming run.
    pub confirmed: Reading,
    /// Dynamic friction by the confirming run.
    pub mu: Reading,
}

/// One value read twice, each with its standard deviation; null where there is none.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// By the physics alone.
    pub physics: Option<f64>,
    /// Its standard deviation.
    pub physics_std: Option<f64>,
    /// Times the discrepancy's factor.
    pub with_discrepancy: Option<f64>,
    /// Its standard deviation.
    pub with_discrepancy_std: Option<f64>,
}

/// A misfit read twice; null where there is none.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MisfitReading {
    /// By the physics alone.
    pub physics: Option<f64>,
    /// Times the discrepancy's factor.
    pub with_discrepancy: Option<f64>,
}

impl Reading {
    /// Both values with their errors, as text.
    fn cells(&self) -> [String; 2] {
        let cell = |value: Option<f64>, std: Option<f64>| {
            value.map_or_else(|| fixed(None, 4), |value| with_error(value, std, 4))
        };
        [cell(self.physics, self.physics_std), cell(self.with_discrepancy, self.with_discrepancy_std)]
    }
}

/// The factors exp(d(P)) that a search aims with at `loads` and a humidity: 1 where `design` does not ask for it.
#[must_use]
pub fn factors(design: &DesignTask, material: &MaterialUncertainty, humidity: Option<f64>, loads: &[Load]) -> Vec<f64> {
    let found = material.discrepancy_at(humidity).filter(|_| design.discrepancy);
    loads.iter().map(|load| found.as_ref().map_or(1.0, |found| found.factor(load.pressure_pa))).collect()
}

impl DiscrepancyReport {
    /// Both readings of the values of `best` that `errors` holds; `None` for a material of which no patterned samples are known.
    #[must_use]
    pub fn new(
        design: &DesignTask,
        material: &MaterialUncertainty,
        loads: &[Load],
        errors: &DesignErrors,
        best: &Pattern,
    ) -> Option<Self> {
        let (found, corrected) = material.discrepancy_at(design.humidity()).zip(errors.corrected.as_ref())?;
        let quantity = design.target.quantity().name();
        let at = DiscrepancyAt::each(&found, loads);
        let by_pressure: Vec<FactorReport> = errors
            .physics
            .iter()
            .zip(corrected)
            .zip(loads.iter().zip(&at))
            .map(|((physics, corrected), (load, at))| {
                let reading = |of: &dyn Fn(&PressureErrors) -> Option<ErrorReport>| {
                    let [physics, corrected] = [of(physics), of(corrected)];
                    Reading {
                        physics: physics.as_ref().and_then(|of| of.value),
                        physics_std: physics.and_then(|of| of.std),
                        with_discrepancy: corrected.as_ref().and_then(|of| of.value),
                        with_discrepancy_std: corrected.and_then(|of| of.std),
                    }
                };
                FactorReport {
                    pressure_mpa: PRESSURE_MPA.from_si(load.pressure_pa),
                    factor: tidy(at.factor),
                    relative_std: tidy(at.relative_std()),
                    outside_measured_range: found.is_outside_measured_range(load.pressure_pa),
                    predicted: reading(&|row| row.predicted.clone()),
                    confirmed: reading(&|row| {
                        if quantity == "ratio" { row.ratio.clone() } else { Some(row.mu.clone()) }
                    }),
                    mu: reading(&|row| Some(row.mu.clone())),
                }
            })
            .collect();
        let misfit = |read: fn(&Reading) -> Option<f64>| {
            let values: Option<Vec<f64>> = by_pressure.iter().map(|row| read(&row.confirmed)).collect();
            let values = values.filter(|_| design.target.has_demands());
            values.map(|values| tidy(design.target.misfit(&values).max))
        };
        let misfit = MisfitReading {
            physics: misfit(|read| read.physics),
            with_discrepancy: misfit(|read| read.with_discrepancy),
        };
        let pattern = material.discrepancy_pattern.clone().unwrap_or_default();
        let planform = design.space.texture().planform().name();
        Some(Self {
            used: design.discrepancy,
            quantity: quantity.into(),
            other_planform: (!pattern.starts_with(planform)).then(|| planform.into()),
            pattern,
            domain: material.discrepancy_domain.as_ref().map(|domain| DomainReport::new(domain, best)),
            degrees_of_freedom: found.degrees_of_freedom,
            by_pressure,
            misfit,
        })
    }

    /// What the reader must know of the factors, in one sentence.
    #[must_use]
    pub fn meaning(&self) -> String {
        let outside: Vec<String> = self
            .by_pressure
            .iter()
            .filter(|row| row.outside_measured_range)
            .map(|row| row.pressure_mpa.to_string())
            .collect();
        let outside = if outside.is_empty() {
            String::new()
        } else {
            format!("; {} MPa lies outside the pressures measured", outside.join(", "))
        };
        let domain = self.domain.as_ref().map_or_else(String::new, |domain| {
            let far = if domain.far.is_empty() {
                String::new()
            } else {
                format!("; this one is far from them in {}: take it as a guess", domain.far.join(" and "))
            };
            format!(". Near them are {}{far}", domain.words())
        });
        format!(
            "Discrepancy: measured over modelled ratios of patterned samples ({}; degrees of freedom: {}). It holds for patterns like theirs{}{outside}{domain}",
            self.pattern,
            self.degrees_of_freedom,
            self.other_planform.as_ref().map_or_else(String::new, |planform| format!(
                ", which this one ({planform}) is not: take it as a guess"
            )),
        )
    }

    /// Why a target that was aimed at with the discrepancy was not met; `None` where the search aimed with the physics alone.
    #[must_use]
    pub fn restriction(&self) -> Option<String> {
        let domain = self.domain.as_ref().filter(|_| self.used)?;
        let guess = if domain.far.is_empty() {
            String::new()
        } else {
            format!(". The nearest design is far from them in {}, and its values are guesses", domain.far.join(" and "))
        };
        Some(format!(
            "the discrepancy counts near the patterns that it was measured on alone, and where the physics by itself moves friction by more \
             than the tolerance at some pressure: near are {}{guess}",
            domain.words()
        ))
    }

    /// Both readings as text.
    #[must_use]
    pub fn text(&self) -> String {
        let list = |of: &dyn Fn(&FactorReport) -> Option<f64>| {
            self.by_pressure.iter().map(|row| fixed(of(row), 3)).collect::<Vec<_>>().join(", ")
        };
        let misfit = self.misfit.with_discrepancy;
        if !self.used {
            return format!(
                "\n  physics alone; times the discrepancy of the calibration's patterned samples ({}) confirmed values would be {}{}. \
                 `discrepancy = true` in [target] aims with it\n",
                list(&|row| Some(row.factor)),
                self.by_pressure.iter().map(|row| row.confirmed.cells()[1].clone()).collect::<Vec<_>>().join(", "),
                misfit.map_or_else(String::new, |misfit| format!(": misfit {misfit:.2}")),
            );
        }
        let mut table = Table::new(["P MPa", "factor", "+-", "predicted", "+-", "confirmed", "+-", "mu", "+-"]);
        for row in &self.by_pressure {
            let cells =
                [row.predicted, row.confirmed, row.mu].into_iter().flat_map(|read| [read.physics, read.physics_std]);
            let cells = cells.map(|cell| fixed(cell, 4));
            let first = [
                row.pressure_mpa.to_string(),
                fixed(Some(row.factor), 3),
                fixed(Some(row.factor * row.relative_std), 3),
            ];
            table.row(first.into_iter().chain(cells));
        }
        format!(
            "\n  by the physics alone, which the values above are times the factor of: misfit {}\n{table}",
            fixed(self.misfit.physics, 2),
        )
    }
}
