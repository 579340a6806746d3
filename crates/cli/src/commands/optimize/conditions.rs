//! A target that must hold at several speeds and humidities: searched and confirmed at the first of them, under a target
//! narrowed so that flat friction at the others leaves room, and judged at every one.

use serde::Serialize;
use slipgrid_material::{Condition, Material};
use slipgrid_optimize::{Demand, ModelFailure, Quantity, Target, Wanted};
use slipgrid_springblock::Load;

use super::robustness::About;
use super::target_report::TargetReport;
use crate::CliError;
use crate::formats::design::Design;
use crate::report::table::fixed;
use crate::units::{HUMIDITY_PCT, PRESSURE_MPA, SPEED_MM_S, tidy};

/// A condition beside the one designed for.
struct Other {
    condition: Condition,
    /// Its mu_d over that of the condition designed for, at each load.
    share: Vec<f64>,
    outside: Vec<bool>,
}

/// The conditions beside the one designed for, and the target that they and it were asked to meet.
pub struct Others {
    asked: Target,
    all: Vec<Other>,
}

/// What the design does at the other conditions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ConditionsReport {
    /// The target at every condition; that of the search is narrowed where it is a friction coefficient.
    pub asked: TargetReport,
    /// How the values were obtained.
    pub meaning: &'static str,
    /// One per condition.
    pub at: Vec<ConditionReport>,
    /// The target holds at all of them.
    pub held: bool,
}

/// What the design does at one of them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ConditionReport {
    /// Sliding speed.
    pub speed_mm_s: f64,
    /// Relative humidity.
    pub humidity_pct: f64,
    /// One per target pressure.
    pub by_pressure: Vec<ConditionValue>,
    /// Largest distance from the target, in tolerances.
    pub misfit: f64,
}

/// Values at one pressure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ConditionValue {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// Ratio, as it is compared with the target.
    pub ratio: f64,
    /// Dynamic friction, likewise.
    pub mu: f64,
    /// The pressure lies outside the measured range of the coefficients.
    pub friction_extrapolated: bool,
}

const MEANING: &str = "at further conditions: the confirming run's ratio with what the steady model makes of other coefficients, times \
                       the flat friction calibrated there";

impl Others {
    /// The further conditions of `design`, whose coefficients at the first are those of `loads`.
    ///
    /// # Errors
    /// [`CliError`] for a condition outside those measured.
    pub fn new(design: &Design, material: &Material, loads: &[Load]) -> Result<Self, CliError> {
        let mut all = Vec::new();
        for condition in &design.also_at {
            let (own, outside) = design.loads_at(material, condition)?;
            let share = |(own, first): (&Load, &Load)| own.friction.dynamic_mean() / first.friction.dynamic_mean();
            all.push(Other { condition: *condition, share: own.iter().zip(loads).map(share).collect(), outside });
        }
        Ok(Self { asked: design.target.clone(), all })
    }

    /// The target at the condition designed for under which it holds at all: friction goes with that of the flat sample,
    /// the ratio hardly changes.
    ///
    /// # Errors
    /// [`CliError`] where nothing at the first condition is accepted at all of them.
    pub fn narrowed(&self, design: &Design) -> Result<Target, CliError> {
        if self.all.is_empty() || self.asked.quantity() == Quantity::Ratio {
            return Ok(self.asked.clone());
        }
        let demands: Option<Vec<Demand>> =
            self.asked.points().iter().enumerate().map(|(place, point)| self.narrowed_at(place, point)).collect();
        let refuse = |reason: String| CliError::from(design.refuse(reason));
        let demands = demands.ok_or_else(|| {
            refuse(
                "flat friction differs so much between condition and also_at that no design is accepted at all"
                    .to_owned(),
            )
        })?;
        Target::of(self.asked.quantity(), demands, self.asked.goal()).map_err(|error| refuse(error.to_string()))
    }

    fn narrowed_at(&self, place: usize, point: &Demand) -> Option<Demand> {
        let shares = || self.all.iter().map(|other| other.share[place]).chain([1.0]);
        let [lowest, highest] = point.wanted.band();
        // v s >= lowest and v s <= highest for every s
        let lowest = lowest.map(|edge| shares().map(|share| edge / share).fold(0.0, f64::max));
        let highest = highest.map(|edge| shares().map(|share| edge / share).fold(f64::INFINITY, f64::min));
        let wanted = match (point.wanted, lowest, highest) {
            (Wanted::AtLeast { margin, .. }, Some(lowest), _) => Wanted::AtLeast { lowest, margin },
            (Wanted::AtMost { margin, .. }, _, Some(highest)) => Wanted::AtMost { highest, margin },
            (_, Some(lowest), Some(highest)) if lowest < highest => Wanted::Between { lowest, highest },
            (_, Some(_), Some(_)) => return None,
            (wanted, ..) => wanted,
        };
        Some(Demand { wanted, ..*point })
    }

    /// What the design of `about` does at the further conditions, times `factors`; `None` without any, and where the
    /// confirming run has no friction.
    ///
    /// # Errors
    /// [`CliError::Other`] where the model has no answer.
    pub fn report(&self, about: &About<'_>, factors: &[f64]) -> Result<Option<ConditionsReport>, CliError> {
        let known: Option<Vec<(f64, f64)>> = about
            .confirmed
            .loads
            .iter()
            .map(|load| Some((load.ratio?, load.flat.as_ref().and_then(|flat| flat.mu_dynamic)?)))
            .collect();
        let Some(known) = known.filter(|_| !self.all.is_empty()) else { return Ok(None) };
        let failed = |failure: ModelFailure| CliError::Other(format!("also_at: {failure}"));
        let steady = |share: &[f64]| {
            let relative: Vec<f64> = share.iter().map(|share| share - 1.0).collect();
            about.model.ratios_where(about.pattern, &relative, about.model.area_law().cloned()).map_err(failed)
        };
        let first = steady(&vec![1.0; known.len()])?;
        let mut at = Vec::new();
        for other in &self.all {
            let own = steady(&other.share)?;
            let by_pressure: Vec<ConditionValue> = self
                .asked
                .points()
                .iter()
                .enumerate()
                .map(|(place, point)| {
                    let (confirmed, flat) = known[place];
                    let ratio = (confirmed + own[place] - first[place]) * factors[place];
                    ConditionValue {
                        pressure_mpa: PRESSURE_MPA.from_si(point.pressure_pa),
                        ratio: tidy(ratio),
                        mu: tidy(ratio * flat * other.share[place]),
                        friction_extrapolated: other.outside[place],
                    }
                })
                .collect();
            let is_ratio = self.asked.quantity() == Quantity::Ratio;
            let values: Vec<f64> =
                by_pressure.iter().map(|value| if is_ratio { value.ratio } else { value.mu }).collect();
            at.push(ConditionReport {
                speed_mm_s: SPEED_MM_S.from_si(other.condition.speed_m_s),
                humidity_pct: HUMIDITY_PCT.from_si(other.condition.humidity),
                by_pressure,
                misfit: tidy(self.asked.misfit(&values).max),
            });
        }
        let held = at.iter().all(|at| at.misfit <= 1.0);
        Ok(Some(ConditionsReport { asked: (&self.asked).into(), meaning: MEANING, at, held }))
    }
}

impl ConditionsReport {
    /// One line a condition.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![self.meaning.to_owned()];
        lines.extend(self.at.iter().map(|at| {
            let each = |of: fn(&ConditionValue) -> f64| {
                at.by_pressure.iter().map(|value| fixed(Some(of(value)), 4)).collect::<Vec<_>>().join(", ")
            };
            let outside = at.by_pressure.iter().any(|value| value.friction_extrapolated);
            format!(
                "  {} mm/s, {} %: ratio {}; mu {}; misfit {}{}{}",
                at.speed_mm_s,
                at.humidity_pct,
                each(|value| value.ratio),
                each(|value| value.mu),
                fixed(Some(at.misfit), 2),
                if at.misfit > 1.0 { ": target missed" } else { "" },
                if outside { " (a pressure lies outside those measured)" } else { "" },
            )
        }));
        lines
    }
}
