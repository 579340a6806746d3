//! Prediction of a cut sample: the one distribution that all chances, intervals and shares are computed from.

use crate::results::PatternReport;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::statistics::NORMAL_95;
use slipgrid_base::units::{HUMIDITY_PCT, PRESSURE_MPA, SPEED_MM_S, tidy};
use slipgrid_infer::discrepancy::{Distribution, Predictor, Score, Unknown, information};

use crate::as_cut::{CutTexture, Known, sums};
use crate::band::Asked;
use crate::inputs::{FLAT_FRICTION, InputEffect, LOCAL_LAW, MODULUS, Part, SCATTER};
use crate::search::Search;

/// Assumed relative standard deviation of a measured ratio, to compute the information that a trial gives.
pub const MEASURED_STD: f64 = 0.01;
/// Demands besides a goal count as met if the chance is at least this: a sample meets them more likely than not.
const KEPT: f64 = 0.5;

/// Prediction of a cut sample of one texture: the joint distribution of its ratio at all loads and conditions, given the
/// errors of the model, the material, the trials and manufacturing.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// The texture.
    pub texture: CutTexture,
    /// Distribution of ln(true ratio / modelled ratio) at every load: a mixture of normal distributions.
    distribution: Distribution,
    score: Score,
    /// Score for the ranking of textures.
    value: f64,
}

impl Prediction {
    /// Predicts a sample of `texture` from the trials, at the loads of `asked`.
    pub fn new(texture: CutTexture, predictor: &Predictor, asked: &Asked) -> Self {
        let distribution = predictor.of(&texture.candidate());
        let score = match texture.known {
            Known::Interpolated => asked.wanted.rough_score(&distribution, &texture.ratio),
            Known::Solved | Known::AsCut => asked.wanted.score(&distribution, &texture.ratio),
        };
        let mut new = Self { texture, distribution, score, value: 0.0 };
        new.value = if new.texture.excess > 0.0 {
            -new.texture.excess
        } else if asked.goal.is_none() {
            new.score.value()
        } else if new.score.chance < KEPT {
            new.score.chance - 1.0
        } else {
            // Higher than the value of any texture that is likelier to miss.
            2.0 + asked.goal_gain(&new.medians())
        };
        new
    }

    /// Probability that a cut sample is on target at all loads and conditions; 1 if nothing is demanded.
    pub fn chance(&self) -> f64 {
        self.score.chance
    }

    /// Score for the ranking of textures: the chance plus a small weight of the closeness to the target; with a goal,
    /// the expected value of the goal if demands are met; negative if a limit is violated.
    pub fn value(&self) -> f64 {
        self.value
    }

    /// Whether the median of samples is accepted at every load.
    pub fn is_within(&self, asked: &Asked) -> bool {
        asked.has_medians_within(&self.texture.ratio, &self.distribution)
    }

    /// Quantile of the ratio at `load`: a share `p` of samples lies below.
    pub fn quantile(&self, load: usize, p: f64) -> f64 {
        self.texture.ratio[load] * self.distribution.quantile(load, p).exp()
    }

    /// Quantiles `p` of the ratio at the first `count` loads.
    pub fn ratios(&self, count: usize, p: f64) -> Vec<f64> {
        (0..count).map(|load| self.quantile(load, p)).collect()
    }

    /// Medians of the ratio at all loads.
    pub fn medians(&self) -> Vec<f64> {
        self.texture.ratio.iter().zip(self.distribution.medians()).map(|(ratio, median)| ratio * median.exp()).collect()
    }

    /// Standard deviations of the natural logarithm of the ratio at all loads.
    pub fn log_stds(&self) -> Vec<f64> {
        (0..self.texture.ratio.len()).map(|load| self.distribution.moments(load).1).collect()
    }

    /// Information that a measurement of a sample gives about the form of the discrepancy, in bits.
    pub fn information_bits(&self) -> f64 {
        information(&self.distribution, MEASURED_STD, |form| *form) / std::f64::consts::LN_2
    }

    /// Expected values of a sample in the quantity of the target, one per load.
    pub fn expected(&self, asked: &Asked) -> Vec<Expected> {
        let of = |(load, band): (usize, &crate::band::Band)| {
            let quantile = |p: f64| tidy(band.flat * self.quantile(load, p));
            let [target_low, target_high] = band.accepted.map(|end| end.map(tidy));
            Expected {
                pressure_mpa: tidy(PRESSURE_MPA.from_si(band.load.pressure_pa)),
                speed_mm_s: tidy(SPEED_MM_S.from_si(band.load.speed_m_s)),
                humidity_pct: tidy(HUMIDITY_PCT.from_si(band.load.humidity)),
                sliding_angle_deg: band.sliding_angle_deg,
                median: quantile(0.5),
                low_95: quantile(0.025),
                high_95: quantile(0.975),
                target_low,
                target_high,
            }
        };
        asked.bands.iter().enumerate().map(of).collect()
    }

    /// Ratios by the model alone, one per load, with the standard deviation from the material and from numerical errors.
    /// `modulus_std` is the relative standard deviation of Young's modulus.
    pub fn modelled(&self, asked: &Asked, modulus_std: f64) -> Vec<ModelledRatio> {
        let n = self.texture.ratio.len();
        let of = |(load, ratio): (usize, &f64)| {
            let diagonal = |of: &[f64]| of.get(load * n + load).copied().unwrap_or(0.0);
            // Friction as a target is uncertain with flat friction, the ratio is not.
            let of_flat = |part: &Part| match &part.effect {
                InputEffect::Shared(own) if part.name == FLAT_FRICTION && asked.bands[load].flat != 1.0 => {
                    diagonal(own)
                }
                _ => 0.0,
            };
            let own = diagonal(&self.texture.covariance) - self.texture.parts.iter().map(of_flat).sum::<f64>();
            let of_modulus = self.texture.sensitivity.get(load).map_or(0.0, |slope| slope.modulus * modulus_std);
            let pressure_mpa = tidy(PRESSURE_MPA.from_si(asked.loads[load].pressure_pa));
            ModelledRatio {
                pressure_mpa,
                ratio: tidy(*ratio),
                std: tidy(ratio * own.max(0.0).sqrt().hypot(of_modulus)),
                flat: tidy(asked.bands[load].flat),
            }
        };
        self.texture.ratio.iter().enumerate().map(of).collect()
    }

    /// Inputs that limit the chance, sorted by decreasing chance without their error, in whole per cent, then by the
    /// deviation that they cause: for each, the resulting standard
    /// deviation of the ratio, and the chance if the input were exactly its current value, or if samples did not
    /// scatter. `modulus_std` is the relative standard deviation of Young's modulus.
    pub fn limited_by(&self, asked: &Asked, predictor: &Predictor, modulus_std: f64) -> Vec<LimitedBy> {
        let (n, sensitivity) = (self.texture.ratio.len(), &self.texture.sensitivity);
        let medians = self.medians();
        let ratio_std = |log: &dyn Fn(usize) -> f64| (0..n).map(|load| tidy(medians[load] * log(load))).collect();
        let own_ratio = &self.texture.ratio[..];
        let mut all = Vec::new();
        let mut add = |input: &str, known_to: String, std: Vec<f64>, distribution: &Distribution| {
            let chance_if_known = tidy(asked.wanted.score(distribution, own_ratio).chance.max(self.score.chance));
            all.push(LimitedBy { input: input.to_owned(), known_to, std, chance_if_known });
        };
        let trials = match asked.learned.trials().len() {
            0 => "no trial yet".to_owned(),
            1 => "known from one trial".to_owned(),
            trials => format!("known from {trials} trials"),
        };
        let log_medians = self.distribution.medians();
        let mut known = predictor.of_known(&self.texture.candidate(), Unknown::Form);
        known.components.iter_mut().for_each(|component| component.mean.clone_from(&log_medians));
        // Normal errors add their variances: sqrt(s^2 - s_without^2) of the moments.
        let added = |without: &Distribution, load: usize| {
            let [all, rest] = [&self.distribution, without].map(|of| of.moments(load).1);
            (all * all - rest * rest).max(0.0).sqrt()
        };
        // Model error and scatter are mixtures, whose moments are dominated by rare large errors and would exceed the
        // stated interval. Their contribution is therefore the widening of this interval: s = R (exp q_97.5 - exp
        // q_2.5) / (2 1.96).
        let width = |of: &Distribution, load: usize| {
            let [low, high] = [0.025, 0.975].map(|share| of.quantile(load, share).exp());
            own_ratio[load] * (high - low) / (2.0 * NORMAL_95)
        };
        let widths: Vec<f64> = (0..n).map(|load| width(&self.distribution, load)).collect();
        let widening = |without: &Distribution| -> Vec<f64> {
            let of = |(load, all): (usize, &f64)| tidy((all * all - width(without, load).powi(2)).max(0.0).sqrt());
            widths.iter().enumerate().map(of).collect()
        };
        add("model error", trials, widening(&known), &known);
        let alike = predictor.without_scatter().of(&self.texture.candidate());
        let known_to = "as samples of one texture differ".to_owned();
        add(SCATTER, known_to, widening(&alike), &alike);
        if modulus_std > 0.0 {
            // A texture chosen for zero slope scatters by the second order.
            let second = self.texture.parts.iter().position(|part| part.name == MODULUS);
            let (covariance, dimension_shifts) = sums(&self.texture.parts, second);
            let still = CutTexture { covariance, dimension_shifts, ..self.texture.clone() };
            let of_modulus = |load: usize| {
                let curved = match second.map(|place| &self.texture.parts[place].effect) {
                    Some(InputEffect::Shared(own)) => own[load * n + load].max(0.0).sqrt(),
                    _ => 0.0,
                };
                (self.texture.sensitivity[load].modulus * modulus_std).hypot(curved)
            };
            let known_to = crate::inputs::known_to(modulus_std);
            let known = predictor.of_known(&still.candidate(), Unknown::Modulus);
            add(MODULUS, known_to, ratio_std(&of_modulus), &known);
        }
        if sensitivity.iter().any(|of| of.local_law != 0.0) {
            let (_, std) = asked.learned.local_law();
            let known_to = if asked.learned.trials().is_empty() {
                "nothing says whether friction follows the local or the nominal pressure".to_owned()
            } else {
                format!("known from trials to {:.0} % of its effect", 100.0 * std)
            };
            let of_law = ratio_std(&|load| std * sensitivity[load].local_law.abs());
            add(LOCAL_LAW, known_to, of_law, &predictor.of_known(&self.texture.candidate(), Unknown::LocalLaw));
        }
        // The first and second order of the modulus are one input, which is handled above.
        for (place, part) in self.texture.parts.iter().enumerate().filter(|(_, part)| part.name != MODULUS) {
            let (covariance, dimension_shifts) = sums(&self.texture.parts, Some(place));
            let still = CutTexture { covariance, dimension_shifts, ..self.texture.clone() };
            let without = if part.name == FLAT_FRICTION {
                predictor.of_known(&still.candidate(), Unknown::Flat)
            } else {
                predictor.of(&still.candidate())
            };
            add(part.name, part.known_to.clone(), ratio_std(&|load| added(&without, load)), &without);
        }
        // Where chances are equal in whole per cent, the scatter of the ratio decides.
        let most = |of: &LimitedBy| of.std.iter().copied().fold(0.0, f64::max);
        let points = |of: &LimitedBy| (100.0 * of.chance_if_known).round();
        all.sort_by(|a, b| points(b).total_cmp(&points(a)).then(most(b).total_cmp(&most(a))));
        all
    }

    /// Builds the report of the sample for the task of `search`, without the inputs that limit the chance.
    pub fn report(&self, search: &Search<'_>) -> SampleReport {
        let asked = search.asked;
        SampleReport {
            design: PatternReport::from(&self.texture.pattern),
            chance: asked.has_demands().then(|| tidy(self.chance())),
            expected: self.expected(asked),
            modelled: self.modelled(asked, search.prepared.modulus_std()),
            limited_by: Vec::new(),
            information_bits: tidy(self.information_bits()),
            laser_s: search.task.laser_time_s(&self.texture.pattern).map(tidy),
            violations: search.violated_by(&self.texture).iter().map(ToString::to_string).collect(),
            is_as_cut: self.texture.known == Known::AsCut,
        }
    }

    /// Like [`Self::report`], with the inputs that limit the chance.
    pub fn full_report(&self, search: &Search<'_>) -> SampleReport {
        let limited_by = self.limited_by(search.asked, &search.predictor, search.prepared.modulus_std());
        SampleReport { limited_by, ..self.report(search) }
    }
}

/// Sample that could be cut, with its prediction; `optimize` and `next` use the same fields.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SampleReport {
    /// Texture of the sample.
    pub design: PatternReport,
    /// Probability that a cut sample is on target at all loads and conditions; null where nothing is demanded.
    pub chance: Option<f64>,
    /// Predicted values of a sample, one per load of each condition, in the quantity of the target.
    pub expected: Vec<Expected>,
    /// Ratios by the model alone, one per load as in `expected`.
    pub modelled: Vec<ModelledRatio>,
    /// Inputs that limit the chance, the strongest first; empty where not computed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub limited_by: Vec<LimitedBy>,
    /// Information that a measurement gives about the form of the discrepancy, in bits.
    pub information_bits: f64,
    /// Laser time of the sample, in seconds; null where the laser's speed is not given.
    pub laser_s: Option<f64>,
    /// Limits that the sample violates, in words.
    pub violations: Vec<String>,
    /// True if the effects of the specimen's ends, pressure tilt and, in the plane, time were computed for this
    /// texture, false if they were interpolated between textures.
    pub is_as_cut: bool,
}

impl SampleReport {
    /// Returns this sample as an alternative to the chosen sample `best`: its chance is limited to that of `best`,
    /// because a greater chance would only be an error of the table.
    #[must_use]
    pub fn beside(self, best: &Self) -> Self {
        let chance = self.chance.zip(best.chance).map(|(own, best)| own.min(best));
        Self { chance: chance.or(self.chance), ..self }
    }
}

/// Predicted values of a cut sample at one load, in the quantity of the target, with the accepted band.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Expected {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// Sliding speed.
    pub speed_mm_s: f64,
    /// Relative humidity.
    pub humidity_pct: f64,
    /// Sliding direction, from the specimen's x axis; absent where there is only one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sliding_angle_deg: Option<f64>,
    /// Median over samples.
    pub median: f64,
    /// Value that 2.5 % of samples lie below.
    pub low_95: f64,
    /// Value that 2.5 % of samples lie above.
    pub high_95: f64,
    /// Lowest accepted value; null where there is none.
    pub target_low: Option<f64>,
    /// Highest accepted value; null where there is none.
    pub target_high: Option<f64>,
}

impl Expected {
    /// Whether the median lies within the accepted band.
    pub fn is_within(&self) -> bool {
        self.target_low.is_none_or(|low| self.median >= low) && self.target_high.is_none_or(|high| self.median <= high)
    }
}

/// Ratio by the model alone for a texture as cut, at one load.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ModelledRatio {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// Dynamic friction over that of the flat surface.
    pub ratio: f64,
    /// Standard deviation of the ratio from the material and from numerical errors.
    pub std: f64,
    /// Friction of the flat surface in the quantity of the target: its coefficient, or 1 where the target is a ratio.
    pub flat: f64,
}

/// Uncertain input that limits the chance.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LimitedBy {
    /// Name of the input, in words.
    pub input: String,
    /// Accuracy of the input, in words.
    pub known_to: String,
    /// Standard deviation of the ratio due to this input alone, one per load; for the model error and the scatter
    /// between samples, computed from the widths of the 95 % interval with and without this input.
    pub std: Vec<f64>,
    /// Chance without the error of this input; not below the present chance.
    pub chance_if_known: f64,
}

/// Formats a chance in per cent.
pub fn percent(chance: f64) -> String {
    match 100.0 * chance {
        percent if percent < 0.5 => "less than 1 %".to_owned(),
        percent if percent > 99.5 => "more than 99 %".to_owned(),
        percent => format!("{percent:.0} %"),
    }
}
