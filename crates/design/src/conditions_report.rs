//! What a design does at every condition, as JSON and as text.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use slipgrid_optimize::Quantity;
use slipgrid_springblock::Scene;

use crate::DesignError;
use crate::decisive_conditions::{greatest, misfits};
use crate::multi_fidelity::MultiFidelityLoop;
use crate::operating_conditions::Setting;
use crate::task::DesignTask;
use crate::uncertainty_budget::of_condition;
use slipgrid_calibrate::uncertainty::{DiscrepancyAt, MaterialUncertainty};
use slipgrid_results::ErrorsReport;
use slipgrid_results::{fixed, with_error};
use slipgrid_units::{HUMIDITY_PCT, PRESSURE_MPA, SPEED_MM_S, tidy};

/// What the design does at every condition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConditionsReport {
    /// How the values were obtained.
    pub meaning: Cow<'static, str>,
    /// One per condition, the one designed for first.
    pub at: Vec<ConditionReport>,
    /// Place of the one with the largest misfit; null where nothing is demanded.
    pub worst: Option<usize>,
    /// The target holds at all of them.
    pub held: bool,
    /// The two that no pattern like the best brings within the target together; null where the target holds, and where
    /// there are none.
    pub conflict: Option<ConflictReport>,
}

/// What the design does at one of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConditionReport {
    /// Sliding speed.
    pub speed_mm_s: f64,
    /// Relative humidity; null where coefficients do not depend on it.
    pub humidity_pct: Option<f64>,
    /// Sliding direction, from the specimen's x axis; null where the design names one alone.
    pub sliding_angle_deg: Option<f64>,
    /// All this in words.
    pub words: String,
    /// Run in time; else the steady model about the run at the condition designed for.
    pub in_time: bool,
    /// One per target pressure.
    pub by_pressure: Vec<ConditionValue>,
    /// Largest distance from the target, in tolerances.
    pub misfit: f64,
}

/// Values at one pressure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConditionValue {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// Ratio, as it is compared with the target.
    pub ratio: f64,
    /// Its standard deviation; null where nothing is known.
    pub ratio_std: Option<f64>,
    /// Dynamic friction, likewise.
    pub mu: f64,
    /// Its standard deviation.
    pub mu_std: Option<f64>,
    /// Dynamic friction of the flat sample.
    pub mu_flat: f64,
    /// Its standard deviation.
    pub mu_flat_std: Option<f64>,
    /// What modelled values are multiplied by: 1, or the discrepancy's factor at this humidity.
    pub factor: f64,
    /// Largest local pressure, steady.
    pub peak_pressure_mpa: f64,
    /// The pressure lies outside the measured range of the coefficients.
    pub friction_extrapolated: bool,
}

/// Two conditions at which values differ by more than the target allows, whatever the pattern.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConflictReport {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// Where values are lowest, in words.
    pub lowest_at: String,
    /// Where they are highest.
    pub highest_at: String,
    /// Flat friction at the latter over that at the former, times the discrepancies where designs aim with them.
    pub flat_factor: f64,
    /// The same of the values of the best design.
    pub factor: f64,
    /// Lowest and highest value accepted.
    pub accepted: [f64; 2],
    /// A band about the same middle, wide enough for both conditions of the best design.
    pub needed: [f64; 2],
    /// All this in one sentence.
    pub words: String,
}

const MEANING: &str = "at the condition designed for, and where values are lowest, highest or farthest from the target, by runs in time \
                       of their own; elsewhere the steady model about the first of these, times the flat friction calibrated there";

impl MultiFidelityLoop<'_> {
    /// What the best design does at every condition; `None` where there is one, and where the confirming run has no
    /// friction. `lacking` is what designs aim with beside the physics, at each load of each condition, `errors` are
    /// those at the first, `outside`: whether each pressure lies outside the measured range there.
    ///
    /// # Errors
    /// [`DesignError::Failed`] where the model has no answer.
    pub(super) fn conditions_report(
        &self,
        design: &DesignTask,
        material: &MaterialUncertainty,
        lacking: Option<&[DiscrepancyAt]>,
        errors: &ErrorsReport,
        outside: &[bool],
    ) -> Result<Option<ConditionsReport>, DesignError> {
        let (Some(best), Some(confirmed)) = (&self.round.best, &self.round.confirmed) else { return Ok(None) };
        let flat: Option<Vec<f64>> =
            confirmed.loads.iter().map(|load| load.flat.as_ref().and_then(|flat| flat.mu_dynamic)).collect();
        let (Some(values), Some(flat)) = (self.confirmed_values(), flat.filter(|_| !self.further.is_empty())) else {
            return Ok(None);
        };
        let model = &self.model;
        let (factors, scales) = (model.factors(&best.design), model.scales(&best.design));
        let peaks_pa = model
            .peak_pressures_pa(&best.design)
            .map_err(|failure| DesignError::Failed(format!("further conditions: {failure}")))?;
        let count = design.target.points().len();
        let is_ratio = design.target.quantity() == Quantity::Ratio;
        let misfits = misfits(&design.target, &values);
        let conditions: Vec<Setting> =
            std::iter::once(Setting::first(design)).chain(self.further.iter().map(|further| further.at)).collect();
        let report = |(place, setting): (usize, &Setting)| {
            let further = place.checked_sub(1).map(|place| &self.further[place]);
            let run = further.map_or(Some(confirmed), |at| at.confirmed.as_ref());
            let outside = further.map_or(outside, |at| &at.outside);
            let at = |pressure: usize| {
                let own = place * count + pressure;
                let load = &model.asked().loads[own];
                let share = load.friction.dynamic_mean() / self.scene.loads[pressure].friction.dynamic_mean();
                let run = run.and_then(|run| run.loads.get(pressure));
                let own_flat = run.and_then(|load| load.flat.as_ref()).and_then(|flat| flat.mu_dynamic);
                // mu_flat = mu_d f(P): at one pressure it goes as mu_d
                let mu_flat = own_flat.unwrap_or(flat[pressure] * share);
                let factor = factors[own];
                let (ratio, mu) = match run.and_then(|load| Some((load.ratio?, load.surface.mu_dynamic?))) {
                    Some((ratio, mu)) => (ratio * factor, mu * factor),
                    None if is_ratio => (values[own], values[own] * mu_flat),
                    None => (values[own] / mu_flat, values[own]),
                };
                ConditionValue {
                    pressure_mpa: PRESSURE_MPA.from_si(load.pressure_pa),
                    ratio: tidy(ratio),
                    ratio_std: None,
                    mu: tidy(mu),
                    mu_std: None,
                    mu_flat: tidy(mu_flat),
                    mu_flat_std: None,
                    factor: tidy(factor),
                    peak_pressure_mpa: tidy(PRESSURE_MPA.from_si(peaks_pa[own])),
                    friction_extrapolated: outside[pressure],
                }
            };
            ConditionReport {
                speed_mm_s: tidy(SPEED_MM_S.from_si(setting.condition.map_or(self.scene.speed_m_s, |at| at.speed_m_s))),
                humidity_pct: setting.condition.map(|at| tidy(HUMIDITY_PCT.from_si(at.humidity))),
                sliding_angle_deg: setting.sliding_angle_deg,
                words: setting.in_words(),
                in_time: run.is_some(),
                by_pressure: (0..count).map(at).collect(),
                misfit: tidy(misfits[place]),
            }
        };
        let mut at: Vec<ConditionReport> = conditions.iter().enumerate().map(report).collect();
        for (place, (own, condition)) in at.iter_mut().zip(&conditions).enumerate() {
            let further = place.checked_sub(1).map(|place| &self.further[place]);
            let loads = further.map_or(&self.scene.loads, |at| &at.loads).clone();
            let pattern = Some(condition.turned(&best.design));
            let scene = Scene { pattern, loads, run: self.round.confirming, ..self.scene.clone() };
            let run = further.map_or(Some(confirmed), |at| at.confirmed.as_ref());
            let ratios: Vec<f64> = own.by_pressure.iter().map(|value| value.ratio / value.factor).collect();
            let mu_flat: Vec<f64> = own.by_pressure.iter().map(|value| value.mu_flat).collect();
            let found = of_condition(
                material,
                lacking.map(|all| all[place * count..(place + 1) * count].to_vec()),
                (&scene, condition.condition.as_ref()),
                run,
                (&ratios, &mu_flat),
                errors,
            )?;
            for (value, of) in own.by_pressure.iter_mut().zip(found) {
                [value.ratio_std, value.mu_std, value.mu_flat_std] =
                    [of.ratio, of.mu, of.mu_flat].map(|std| std.map(tidy));
            }
        }
        let held = misfits.iter().all(|misfit| *misfit <= 1.0);
        Ok(Some(ConditionsReport {
            meaning: MEANING.into(),
            at,
            worst: design.target.has_demands().then(|| greatest(misfits.iter().copied())),
            held,
            conflict: if held { None } else { conflict(design, &conditions, &scales, &values) },
        }))
    }
}

/// The two conditions, and the pressure, at which values differ most beyond what the target allows, by what ratios are multiplied
/// by and by the `values` of the best design alike: ratios hardly depend on the coefficients.
fn conflict(design: &DesignTask, conditions: &[Setting], scales: &[f64], values: &[f64]) -> Option<ConflictReport> {
    let count = design.target.points().len();
    let mut worst: Option<(f64, ConflictReport)> = None;
    for (pressure, point) in design.target.points().iter().enumerate() {
        let [Some(lowest), Some(highest)] = point.wanted.band() else { continue };
        let scale: Vec<f64> = (0..conditions.len()).map(|place| scales[place * count + pressure]).collect();
        let (low, high) = (greatest(scale.iter().map(|s| -s)), greatest(scale.iter().copied()));
        let flat_factor = scale[high] / scale[low];
        let factor = values[high * count + pressure] / values[low * count + pressure];
        // v at the one and q v at the other lie within [a, b] for some v where q a <= b
        let beyond = flat_factor.min(factor) * lowest / highest;
        if beyond <= 1.0 || worst.as_ref().is_some_and(|(most, _)| beyond <= *most) {
            continue;
        }
        // (m + t) / (m - t) = q
        let middle = f64::midpoint(lowest, highest);
        let tolerance = middle * (factor - 1.0) / (factor + 1.0);
        let mut report = ConflictReport {
            pressure_mpa: PRESSURE_MPA.from_si(point.pressure_pa),
            lowest_at: conditions[low].in_words(),
            highest_at: conditions[high].in_words(),
            flat_factor: tidy(flat_factor),
            factor: tidy(factor),
            accepted: [tidy(lowest), tidy(highest)],
            needed: [tidy(middle - tolerance), tidy(middle + tolerance)],
            words: String::new(),
        };
        report.words = report.in_words(design.discrepancy);
        worst = Some((beyond, report));
    }
    worst.map(|(_, report)| report)
}

impl ConflictReport {
    fn in_words(&self, with_discrepancy: bool) -> String {
        format!(
            "at {} MPa {} at {} is {:.3} times that at {}, and this pattern leaves {:.3}: within {:.4} to {:.4} there is room for {:.3}; \
             about its middle {:.4} to {:.4} would do",
            self.pressure_mpa,
            if with_discrepancy { "flat friction times the discrepancy" } else { "flat friction" },
            self.highest_at,
            self.flat_factor,
            self.lowest_at,
            self.factor,
            self.accepted[0],
            self.accepted[1],
            self.accepted[1] / self.accepted[0],
            self.needed[0],
            self.needed[1],
        )
    }
}

impl ConditionsReport {
    /// One line a condition, and the worst of them.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![format!("at {} conditions, by pressure, the one designed for first:", self.at.len())];
        lines.extend(self.at.iter().map(|at| {
            let each = |of: fn(&ConditionValue) -> (f64, Option<f64>)| {
                let words = |value: &ConditionValue| {
                    let (value, std) = of(value);
                    with_error(value, std, 4)
                };
                at.by_pressure.iter().map(words).collect::<Vec<_>>().join(", ")
            };
            let outside = at.by_pressure.iter().any(|value| value.friction_extrapolated);
            format!(
                "  {}: ratio {}; mu {}; misfit {}, {}{}{}",
                at.words,
                each(|value| (value.ratio, value.ratio_std)),
                each(|value| (value.mu, value.mu_std)),
                fixed(Some(at.misfit), 2),
                if at.in_time { "run in time" } else { "by the steady model about the first" },
                if at.misfit > 1.0 { ": target missed" } else { "" },
                if outside { " (a pressure lies outside those measured)" } else { "" },
            )
        }));
        if let Some(worst) = self.worst.and_then(|place| self.at.get(place)) {
            lines.push(format!("worst: {}, misfit {}", worst.words, fixed(Some(worst.misfit), 2)));
        }
        lines
    }
}
