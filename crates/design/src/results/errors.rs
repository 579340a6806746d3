//! Errors of friction coefficients and ratios, separated into their sources: run, calibration and, for corrected
//! values, the discrepancy.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::statistics::NORMAL_95;
use slipgrid_base::units::tidy;
use slipgrid_infer::calibrate::uncertainty::Deviation;

/// Name of a source of error of a run: the finite duration of the run.
pub const TIME_AVERAGE: &str = "time average";
/// Name of a source of error of a run: the random draw of the local coefficients.
pub const DRAWS: &str = "local coefficients drawn";
/// Name of a source of error of a run: which blocks stick together, as neither the run's duration nor the coefficients
/// tell.
pub const PHASES: &str = "phases of stick-slip";
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

impl PartsReport {
    /// Contribution of the source `input` with the standard deviation `std`; `None` if this is not known.
    pub fn known(input: &str, std: Option<f64>) -> Option<Self> {
        Some(Self { input: input.to_owned(), std: std? })
    }
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
            // Friction of a sliding surface and ratios of friction are not negative.
            [value - below, value + above].map(|end| tidy(end.max(0.0)))
        });
        let of_material = known.into_iter().flat_map(|known| &known.parts);
        let of_material = of_material.map(|&(source, std)| PartsReport { input: source.name().to_owned(), std });
        let parts =
            own.into_iter().chain(of_material).map(|part| PartsReport { std: tidy(part.std), ..part }).collect();
        Self { value: value.map(tidy), std: is_known.then(|| tidy(square.sqrt())), interval_95: interval, parts }
    }
}

impl ErrorsReport {
    /// Creates the report of the errors `by_pressure`. `unknown` names the sources of error that the material does not
    /// give.
    pub fn new(by_pressure: Vec<PressureErrors>, unknown: Vec<String>) -> Self {
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
        words += "; it does not include how far the model itself is off";
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_model::springblock::Effect;

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
        let [from, to] = ErrorReport::new(Some(0.4), part(0.3), None).interval_95.unwrap();
        assert!(from == 0.0 && (to - 0.988).abs() < 1e-3, "{from} to {to}");
        let narrow = ErrorReport::new(Some(0.4), part(0.1), None).interval_95.unwrap();
        assert!((narrow[0] - 0.204).abs() < 1e-3, "{narrow:?}");
    }
}
