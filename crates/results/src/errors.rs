//! One error beside every friction coefficient and ratio: what the run, the calibration and, where values are corrected
//! by it, the discrepancy leave open, with its parts kept apart.

use serde::{Deserialize, Serialize};
use slipgrid_calibrate::uncertainty::Deviation;
use slipgrid_units::tidy;

/// Part of a run: how long it lasted.
pub const TIME_AVERAGE: &str = "time average";
/// Part of a run: which local coefficients it drew.
pub const DRAWS: &str = "local coefficients drawn";
/// Part of a run: what stands for the specimen as it is laid out.
pub const LAYOUT: &str = "layout on the specimen";
/// Part of a ratio: how far it is from that of vanishing blocks.
pub const BLOCKS: &str = "size of blocks";
/// Part of a run: what is behind the layer that it holds, added by the steady cell.
pub const BEHIND: &str = "specimen behind the layer";
/// How far friction tilts the pressure on the specimen.
pub const TILT: &str = "tilt of the pressure";
/// Part of what a search took for its target's quantity: how far the run that confirmed the design is from it.
pub const OFF_THE_RUN: &str = "distance from the confirming run";
/// Part of a static peak, which follows them at most one to one.
pub const STATIC: &str = "static coefficient";
/// The 97.5 % point of the normal distribution.
const NORMAL_95: f64 = 1.959_964;
/// What is open where slopes could not be computed.
pub const NO_SLOPES: &str =
    "errors of the material's values (with slightly changed values the scene could not be solved)";

/// Errors of the numbers of one scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorsReport {
    /// What the errors combine, in words.
    pub meaning: String,
    /// What they include.
    pub includes: Vec<String>,
    /// What they do not include, because the material does not give it.
    pub unknown: Vec<String>,
    /// One per pressure.
    pub by_pressure: Vec<PressureErrors>,
}

/// Values at one pressure, each with its error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PressureErrors {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// What a search took for its target's quantity, with the errors of the confirming run and how far that is from it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub predicted: Option<ErrorReport>,
    /// Patterned over flat; of a patterned surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ratio: Option<ErrorReport>,
    /// Dynamic friction.
    pub mu: ErrorReport,
    /// Dynamic friction of the flat surface beside a patterned one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mu_flat: Option<ErrorReport>,
    /// Static friction, where the run has it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mu_static: Option<ErrorReport>,
    /// The same of the flat surface beside a patterned one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mu_static_flat: Option<ErrorReport>,
}

/// A value with one standard deviation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorReport {
    /// The value; null where the run gave none.
    pub value: Option<f64>,
    /// All parts together; null where none is known.
    pub std: Option<f64>,
    /// Ends of the 95 % interval, which reaches farther to one side where Young's modulus decides, and not below nil; null where none is
    /// known.
    pub interval_95: Option<[f64; 2]>,
    /// Each part alone.
    pub parts: Vec<PartsReport>,
}

/// What one input alone would do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartsReport {
    /// The input.
    pub input: String,
    /// Standard deviation of the value.
    pub std: f64,
}

/// Ends of an interval: friction of a sliding surface and its ratio are not negative.
fn physical(ends: [f64; 2]) -> [f64; 2] {
    ends.map(|end| tidy(end.max(0.0)))
}

impl ErrorReport {
    /// `own` parts are independent of one another and of what the material leaves open.
    #[must_use]
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

    /// The same with one more part, independent of the others.
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

    /// The same errors about another `value`.
    #[must_use]
    pub fn about(mut self, value: f64) -> Self {
        let [below, above] = self.reach(self.value.unwrap_or(value));
        self.interval_95 = self.interval_95.map(|_| physical([value - below, value + above]));
        self.value = Some(tidy(value));
        self
    }

    /// How far the interval reaches below and above `value`, its own; where it ends at nil, below as far as the standard deviation says.
    fn reach(&self, value: f64) -> [f64; 2] {
        let below_of = |from: f64| match self.std {
            Some(std) if from <= 0.0 => (value - from).max(NORMAL_95 * std),
            _ => value - from,
        };
        self.interval_95.map_or([0.0; 2], |[from, to]| [below_of(from), to - value])
    }

    /// Standard deviation by the part `input` alone, where it is known.
    #[must_use]
    pub fn std_of(&self, input: &str) -> Option<f64> {
        self.parts.iter().find(|part| part.input == input).map(|part| part.std)
    }

    /// The part of the run itself: how long it lasted and what it drew.
    #[must_use]
    pub fn std_of_run(&self) -> f64 {
        self.std_of_all(&[TIME_AVERAGE, DRAWS, LAYOUT, BEHIND, TILT])
    }

    /// Standard deviation by the parts `inputs` together.
    #[must_use]
    pub fn std_of_all(&self, inputs: &[&str]) -> f64 {
        let of = self.parts.iter().filter(|part| inputs.contains(&part.input.as_str()));
        of.map(|part| part.std.powi(2)).sum::<f64>().sqrt()
    }
}

impl ErrorsReport {
    /// The report on `rows`, whose material leaves `unknown` open; `corrected` values have the discrepancy in them.
    #[must_use]
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

    /// The 95 % intervals of what `of` picks at each pressure, in one line; `None` where none is known.
    #[must_use]
    pub fn intervals(&self, name: &str, of: impl Fn(&PressureErrors) -> Option<ErrorReport>) -> Option<String> {
        let ends = |row: &PressureErrors| of(row)?.interval_95.map(|[from, to]| format!("{from:.4} to {to:.4}"));
        let all: Vec<String> = self.by_pressure.iter().map(|row| ends(row).unwrap_or_else(|| "-".to_owned())).collect();
        let is_known = all.iter().any(|ends| ends != "-");
        is_known.then(|| format!("95 % of {name}: {}", all.join(", ")))
    }

    /// The errors at one pressure.
    #[must_use]
    pub fn at(&self, row: usize) -> Option<&PressureErrors> {
        self.by_pressure.get(row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
