//! Errors of friction coefficients and ratios, separated into their sources: run, calibration and, for corrected
//! values, the discrepancy.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::statistics::NORMAL_95;
use slipgrid_base::units::tidy;
use slipgrid_infer::calibrate::uncertainty::Deviation;
use slipgrid_model::springblock::Effect;

/// Name of a source of error of a run: the finite duration of the run.
pub const TIME_AVERAGE: &str = "time average";
/// Name of a source of error of a run: the random draw of the local coefficients.
pub const DRAWS: &str = "local coefficients drawn";
/// Name of a source of error of a static peak: the static coefficient of the material. The relative error of the peak
/// is at most that of the coefficient.
pub const STATIC: &str = "static coefficient";
/// Entry of [`ErrorsReport::unknown`] for loads at which derivatives by the material's values could not be computed.
pub const NO_SLOPES: &str =
    "errors of the material's values (with slightly changed values the scene could not be solved)";

/// Errors of the results of one scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ErrorsReport {
    /// Summary of the included and the unknown errors in one sentence.
    pub meaning: String,
    /// Sources of error that the standard deviations include.
    pub includes: Vec<String>,
    /// Sources of error that are not included, because the material does not give them.
    pub unknown: Vec<String>,
    /// Values with errors, one entry per pressure.
    pub by_pressure: Vec<PressureErrors>,
}

/// Values at one pressure with their errors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PressureErrors {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// Ratio of dynamic friction, patterned over flat; left out for a flat scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ratio: Option<ErrorReport>,
    /// Dynamic friction coefficient.
    pub mu: ErrorReport,
    /// Dynamic friction coefficient of the flat surface; left out for a flat scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mu_flat: Option<ErrorReport>,
    /// Static friction coefficient; left out if the run has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mu_static: Option<ErrorReport>,
    /// Static friction coefficient of the flat surface; left out if the run has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mu_static_flat: Option<ErrorReport>,
}

/// Value with its standard deviation and interval.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ErrorReport {
    /// Value; null if the run gave none.
    pub value: Option<f64>,
    /// Standard deviation from all parts together; null if no part is known.
    pub std: Option<f64>,
    /// Ends of the 95 % interval, not below zero; it is asymmetric if Young's modulus dominates. Null if no part is
    /// known.
    pub interval_95: Option<[f64; 2]>,
    /// Contributions of the single sources of error.
    pub parts: Vec<PartsReport>,
}

/// Contribution of one source of error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PartsReport {
    /// Name of the source.
    pub input: String,
    /// Standard deviation of the value from this source alone.
    pub std: f64,
}

/// Sets negative ends of an interval to zero: friction of a sliding surface and ratios of friction are not negative.
fn physical(ends: [f64; 2]) -> [f64; 2] {
    ends.map(|end| tidy(end.max(0.0)))
}

impl ErrorReport {
    /// Combines the errors `own` of a run with the deviation due to the `material`; all parts are taken as independent.
    pub fn new(value: Option<f64>, own: Vec<PartsReport>, material: Option<&Deviation>) -> Self {
        let known = material.filter(|known| !known.parts.is_empty());
        let square =
            own.iter().map(|part| part.std.powi(2)).sum::<f64>() + known.map_or(0.0, |known| known.std.powi(2));
        let is_known = value.is_some() && (known.is_some() || !own.is_empty());
        let of_run = own.iter().map(|part| part.std.powi(2)).sum::<f64>() * NORMAL_95 * NORMAL_95;
        let interval = value.filter(|_| is_known).map(|value| {
            let [below, above] =
                known.map_or([0.0; 2], |known| known.reach_95).map(|reach| (reach * reach + of_run).sqrt());
            physical([value - below, value + above])
        });
        let of_material = known.into_iter().flat_map(|known| &known.parts);
        let of_material = of_material.map(|&(source, std)| PartsReport { input: source.name().to_owned(), std });
        let parts =
            own.into_iter().chain(of_material).map(|part| PartsReport { std: tidy(part.std), ..part }).collect();
        Self { value: value.map(tidy), std: is_known.then(|| tidy(square.sqrt())), interval_95: interval, parts }
    }

    /// Adds an error contribution of source `input` with the standard deviation `std`, independent of the others.
    #[must_use]
    pub fn and(mut self, input: &str, std: f64) -> Self {
        let Some(value) = self.value else { return self };
        let reach = NORMAL_95 * std;
        let [below, above] = self.reach(value);
        self.interval_95 = Some(physical([value - below.hypot(reach), value + above.hypot(reach)]));
        self.std = Some(tidy(self.std.unwrap_or(0.0).hypot(std)));
        self.parts.push(PartsReport { input: input.to_owned(), std: tidy(std) });
        self
    }

    /// Moves value and interval to `value`; the errors are unchanged.
    #[must_use]
    pub fn about(mut self, value: f64) -> Self {
        let [below, above] = self.reach(self.value.unwrap_or(value));
        self.interval_95 = self.interval_95.map(|_| physical([value - below, value + above]));
        self.value = Some(tidy(value));
        self
    }

    /// Distances from `value`, the value of this report, to the lower and the upper end of the interval. If the lower
    /// end was set to zero, the lower distance is at least 1.96 standard deviations.
    fn reach(&self, value: f64) -> [f64; 2] {
        let below_of = |from: f64| match self.std {
            Some(std) if from <= 0.0 => (value - from).max(NORMAL_95 * std),
            _ => value - from,
        };
        self.interval_95.map_or([0.0; 2], |[from, to]| [below_of(from), to - value])
    }

    /// Standard deviation from the part `input` alone; `None` if there is no such part.
    pub fn std_of(&self, input: &str) -> Option<f64> {
        self.parts.iter().find(|part| part.input == input).map(|part| part.std)
    }

    /// Standard deviation from the run itself: duration, draws, and all corrections except the size of blocks.
    pub fn std_of_run(&self) -> f64 {
        let corrections = [Effect::Rims, Effect::Layout, Effect::Time, Effect::Behind, Effect::Tilt].map(Effect::name);
        self.std_of_all(&[&[TIME_AVERAGE, DRAWS][..], &corrections].concat())
    }

    /// Standard deviation from the parts `inputs` together.
    pub fn std_of_all(&self, inputs: &[&str]) -> f64 {
        let of = self.parts.iter().filter(|part| inputs.contains(&part.input.as_str()));
        of.map(|part| part.std.powi(2)).sum::<f64>().sqrt()
    }
}

impl ErrorsReport {
    /// Creates the report of the errors `by_pressure`. `unknown` names the sources of error that the material does not
    /// give; `corrected` tells whether the values include the discrepancy.
    pub fn new(by_pressure: Vec<PressureErrors>, unknown: Vec<String>, corrected: bool) -> Self {
        let mut includes: Vec<String> = Vec::new();
        let values = |row: &PressureErrors| {
            [row.ratio.clone(), Some(row.mu.clone()), row.mu_static.clone()].into_iter().flatten()
        };
        for part in by_pressure.iter().flat_map(values).flat_map(|value| value.parts) {
            if !includes.contains(&part.input) {
                includes.push(part.input);
            }
        }
        let mut words = if includes.is_empty() {
            "+-: nothing is known".to_owned()
        } else {
            format!("+-: one standard deviation of {}", includes.join(", "))
        };
        if !unknown.is_empty() {
            words += &format!("; not known of this material: {}", unknown.join(", "));
        }
        words += if corrected { "" } else { "; it does not include how far the model itself is off" };
        Self { meaning: words, includes, unknown, by_pressure }
    }

    /// Formats the 95 % intervals of the values selected by `of`, at all pressures, in one line; `None` if none is
    /// known.
    pub fn intervals(&self, name: &str, of: impl Fn(&PressureErrors) -> Option<ErrorReport>) -> Option<String> {
        let ends = |row: &PressureErrors| of(row)?.interval_95.map(|[from, to]| format!("{from:.4} to {to:.4}"));
        let all: Vec<String> = self.by_pressure.iter().map(|row| ends(row).unwrap_or_else(|| "-".to_owned())).collect();
        let is_known = all.iter().any(|ends| ends != "-");
        is_known.then(|| format!("95 % of {name}: {}", all.join(", ")))
    }

    /// Errors at the pressure with the index `row`; `None` if there is no such pressure.
    pub fn at(&self, row: usize) -> Option<&PressureErrors> {
        self.by_pressure.get(row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_and_corrections_name_an_effect_alike() {
        use Effect::{Behind, Blocks, Layout, Rims, Tilt, Time, WholeBlocks};
        for effect in [WholeBlocks, Rims, Layout, Time, Behind, Tilt, Blocks] {
            assert_eq!(serde_json::to_value(effect).unwrap(), effect.name());
        }
    }

    #[test]
    fn intervals_of_friction_and_of_ratios_end_at_nil() {
        let part = |std: f64| vec![PartsReport { input: "size of blocks".to_owned(), std }];
        let wide = ErrorReport::new(Some(0.4), part(0.3), None);
        let [from, to] = wide.interval_95.unwrap();
        assert!(from == 0.0 && (to - 0.988).abs() < 1e-3, "{from} to {to}");
        // Nothing is forgotten of what lies below nil.
        let [from, to] = wide.clone().about(0.9).interval_95.unwrap();
        assert!((from - 0.312).abs() < 1e-3 && (to - 1.488).abs() < 1e-3, "{from} to {to}");
        assert_eq!(wide.and("more", 0.1).interval_95.unwrap()[0], 0.0);
        let narrow = ErrorReport::new(Some(0.4), part(0.1), None).interval_95.unwrap();
        assert!((narrow[0] - 0.204).abs() < 1e-3, "{narrow:?}");
    }
}
