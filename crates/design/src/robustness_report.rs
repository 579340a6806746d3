//! The spread of a design's friction, as JSON and as text.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use slipgrid_optimize::Spread;

use slipgrid_results::PartsReport;
use slipgrid_results::PatternReport;
use slipgrid_results::Table;
use slipgrid_results::fixed;
use slipgrid_units::tidy;

/// What `_std_um` means.
pub const MEANING: &str = "Standard deviations of the dimensions are those of a sample's mean: samples differ by so much, \
                           and how the cavities of one sample scatter about its mean is averaged away by friction";

/// How shares by the steady model stand to the chance that a design is announced with.
pub const BESIDE: &str = "these shares are about the confirmed values, with what is not known as one normal distribution; chances among \
                          trade-offs and in the explorer are about the steady model's values: compare each with its like";

/// What samples made after a design do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobustnessReport {
    /// What the standard deviations are of.
    pub meaning: Cow<'static, str>,
    /// The condition designed for, which values by pressure and parts are those of, where the target is asked at several: shares count
    /// all of these together.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub condition: Option<String>,
    /// `sampled`: the steady model at every draw; `linearized`: its first-order form.
    pub method: Cow<'static, str>,
    /// What scatters; the parts are independent unless stated otherwise.
    pub inputs: Vec<InputReport>,
    /// From tolerances alone: how samples differ from one another where the material is exactly as it was calibrated.
    pub samples: ScatterReport,
    /// What is not known of the material as well, which all samples share: how far the prediction holds. Null where
    /// nothing is known of the material's errors.
    pub with_material: Option<ScatterReport>,
    /// Parts of the scatter to first order, one per pressure.
    pub parts: Vec<PressureParts>,
    /// How the design was chosen, where it was searched for being robust.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub optimum: Option<OptimumReport>,
}

/// Draws and what came of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScatterReport {
    /// Draws.
    pub draws: usize,
    /// Draws that the model could not compute: counted as outside the tolerance.
    pub failed: usize,
    /// Draws with a dimension that was not positive: drawn again.
    pub redrawn: usize,
    /// Share of what is accepted at all pressures of all conditions; null where the target has a goal alone.
    pub probability: Option<f64>,
    /// Its binomial standard error.
    pub probability_stderr: Option<f64>,
    /// One per pressure.
    pub by_pressure: Vec<PressureReport>,
}

/// Something that scatters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InputReport {
    /// The input, in words.
    pub name: String,
    /// Standard deviation; one, or one per pressure.
    pub std: Vec<f64>,
    /// Its unit.
    pub unit: Cow<'static, str>,
    /// Where it comes from, and how it is assumed to act.
    pub basis: String,
}

/// The spread at one pressure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PressureReport {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// Ratio and friction coefficient.
    #[serde(flatten)]
    pub spread: SpreadReport,
}

/// Parts of the scatter at one pressure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PressureParts {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// Standard deviation of the target's quantity to first order.
    pub std: f64,
    /// The same where one input alone varies: one table for each input.
    pub of: Vec<PartsReport>,
}

/// Ratio and friction coefficient.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpreadReport {
    /// Patterned over flat.
    pub ratio: Distribution,
    /// Dynamic friction coefficient.
    pub mu: Distribution,
}

/// How a number scatters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Distribution {
    /// Mean.
    pub mean: f64,
    /// Standard error of the mean, from the number of draws.
    pub mean_stderr: f64,
    /// Standard deviation.
    pub std: f64,
    /// Ends of the band that holds 95 % of samples.
    pub band_95: [f64; 2],
}

/// The robust optimum beside the nominal one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OptimumReport {
    /// The design that misses the target least if it is made exactly.
    pub nominal: PatternReport,
    /// Root-mean-square misfit over made samples, in tolerances: of that design; null where a
    /// sample of it cannot be computed.
    pub nominal_expected_rms: Option<f64>,
    /// Of the design chosen.
    pub expected_rms: f64,
    /// Share of samples of the nominal design within the tolerance at all pressures of all conditions, drawn alike; null
    /// where it could not be computed.
    pub nominal_probability: Option<f64>,
    /// Designs that the search for it evaluated.
    pub evaluations: usize,
}

/// A spread as it is reported.
pub fn distribution(spread: &Spread) -> Distribution {
    Distribution {
        mean: tidy(spread.mean),
        mean_stderr: tidy(spread.mean_stderr),
        std: tidy(spread.std),
        band_95: spread.band.map(tidy),
    }
}

impl RobustnessReport {
    /// The spread as a table with a verdict.
    #[must_use]
    pub fn text(&self) -> String {
        let shown = self.with_material.as_ref().unwrap_or(&self.samples);
        let mut table = Table::new(["P MPa", "95 % of samples", "and material", "mu", "95 % of mu", "mostly by"]);
        let band = |found: &Distribution| format!("{:.4}-{:.4}", found.band_95[0], found.band_95[1]);
        for ((samples, all), parts) in self.samples.by_pressure.iter().zip(&shown.by_pressure).zip(&self.parts) {
            let largest = parts.of.iter().max_by(|a, b| a.std.total_cmp(&b.std));
            table.row([
                samples.pressure_mpa.to_string(),
                band(&samples.spread.ratio),
                if self.with_material.is_some() { band(&all.spread.ratio) } else { "-".to_owned() },
                fixed(Some(all.spread.mu.mean), 4),
                band(&all.spread.mu),
                largest.map_or_else(String::new, |part| part.input.clone()),
            ]);
        }
        let names = |is_length: bool| {
            let named = self.inputs.iter().filter(|input| (input.unit == "um") == is_length);
            named.map(InputReport::words).collect::<Vec<_>>().join(", ")
        };
        let at = self
            .condition
            .as_ref()
            .map_or_else(String::new, |words| format!(", at the condition designed for, {words}"));
        let mut text = format!("  ratio of samples made with {}{at}\n", names(true));
        text += &table.to_string();
        if self.samples.probability.is_some() {
            text += &format!(
                "  within the tolerance at {}, from tolerances alone: {}\n",
                self.everywhere(),
                self.samples.words("of samples", self.how())
            );
        }
        if let Some(material) = self.with_material.as_ref().filter(|material| material.probability.is_some()) {
            text += &format!(
                "  from tolerances and what is not known of the material ({}), numerical error aside: {}\n",
                names(false),
                material.words("", "")
            );
        }
        if self.samples.probability.is_some() {
            text += &format!("  {BESIDE}\n");
        }
        if let Some(optimum) = &self.optimum {
            text += &optimum.words();
        }
        text
    }

    /// Where a sample must be within the tolerance to count.
    #[must_use]
    pub const fn everywhere(&self) -> &'static str {
        if self.condition.is_some() { "all pressures of all conditions" } else { "all pressures" }
    }

    fn how(&self) -> &'static str {
        if self.method == "sampled" { "draws of the steady model" } else { "draws of the steady model to first order" }
    }
}

impl InputReport {
    fn words(&self) -> String {
        if self.unit == "um" {
            return format!("{} +- {} um", self.name, self.std[0]);
        }
        self.name.clone()
    }
}

impl ScatterReport {
    /// The share: "all", "none", or per cent with the binomial standard error after `plus_minus`; a dash where it is not known.
    #[must_use]
    pub fn share(&self, plus_minus: &str) -> String {
        match self.probability {
            None => "-".to_owned(),
            Some(share) if share >= 1.0 => "all".to_owned(),
            Some(share) if share <= 0.0 => "none".to_owned(),
            share => {
                let percent = |of: Option<f64>| fixed(of.map(|of| 100.0 * of), 1);
                format!("{} {plus_minus} {} %", percent(share), percent(self.probability_stderr))
            }
        }
    }

    /// The share in words, of what and by what.
    fn words(&self, of: &str, by: &str) -> String {
        let by = if by.is_empty() { "draws" } else { by };
        let share = self.share("+-");
        let mut words = match self.probability {
            Some(all_or_none) if all_or_none <= 0.0 || all_or_none >= 1.0 => format!("{share} of {} {by}", self.draws),
            _ if of.is_empty() => share,
            _ => format!("{share} {of} ({} {by})", self.draws),
        };
        if self.failed > 0 {
            words += &format!("; {} draws could not be computed and count as outside", self.failed);
        }
        if self.redrawn > 0 {
            words += &format!("; {} without a positive dimension were drawn again", self.redrawn);
        }
        words
    }
}

impl OptimumReport {
    fn words(&self) -> String {
        let nominal = &self.nominal;
        let share = self
            .nominal_probability
            .map_or_else(String::new, |share| format!(", {:.1} % of its samples within the tolerance", 100.0 * share));
        format!(
            "  chosen for its samples: expected misfit {:.2} tolerances; the best design on paper, {} um, has {}{share}\n",
            self.expected_rms,
            nominal.lengths_in_words(),
            fixed(self.nominal_expected_rms, 2),
        )
    }
}
