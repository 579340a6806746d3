//! Advice on the texture that was found: cut a series, cut a trial, or nothing.

use slipgrid_base::statistics::extremes;
use slipgrid_base::units::tidy;
use slipgrid_infer::discrepancy::{Features, Trial};

use crate::band::Asked;
use crate::prediction::{Prediction, percent};
use crate::results::length_in_words;
use crate::search::{ALIKE, Search};

/// Minimum chance at which a series is advised.
const SERIES: f64 = 0.9;
/// Minimum chance of another sample at which the texture of a trial on target meets it: below, the trial was luck.
const LIKELY: f64 = 0.5;
/// Two textures are near each other if width, pitch, depth and areal density differ by at most this factor, and a load
/// is near measured ones if it lies outside their pressures by at most this factor.
const NEARBY: f64 = 1.5;

/// Recommended next action.
#[derive(Clone, Debug, PartialEq)]
pub enum Advice {
    /// Cut a series: the chance is high and a trial of a similar texture confirms it.
    Series,
    /// Cut a trial: the chance is too low for a series, or no trial of a similar texture exists.
    Trial,
    /// Cut nothing new: a trial is on target, and another sample of its texture is likely to be.
    TrialMeetsIt {
        /// Name and texture of the trial, in words.
        trial: String,
        /// Chance that another sample of its texture is on target.
        another: f64,
        /// Whether the best texture is that of the trial.
        is_best: bool,
    },
    /// Cut nothing: no texture has a median within the accepted band, or none keeps all limits.
    CannotBeMet {
        /// Whether the best texture, as it would be cut, keeps all limits.
        keeps_limits: bool,
    },
    /// Measure two trials again: they are samples of one texture that contradict each other, with both no texture has a
    /// median within the accepted band, and without one of them the chance is greater.
    MeasureAgain {
        /// Names of the two trials.
        trials: [String; 2],
    },
    /// Cut nothing: the flat surface is on target or is best by the goal.
    DoNotTexture,
}

impl Advice {
    /// Chooses the advice for `best`, the best texture found. `is_within_reach`: some texture has a median within the
    /// accepted band.
    pub fn of(search: &Search<'_>, best: &Prediction, is_within_reach: bool) -> Self {
        let asked = search.asked;
        let flat = vec![1.0; asked.loads.len()];
        let is_flat_best = match asked.goal {
            None => asked.accepts(&flat),
            Some(_) => asked.accepts(&flat) && asked.goal_gain(&flat) >= asked.goal_gain(&best.medians()),
        };
        if is_flat_best {
            return Self::DoNotTexture;
        }
        let is_nearby = |trial: &Trial| is_near(trial, &best.texture.features) && is_near_loads(trial, asked);
        let is_nearby = asked.learned.trials().iter().any(is_nearby);
        if best.texture.excess == 0.0 && best.chance() >= SERIES && is_nearby {
            return Self::Series;
        }
        for trial in asked.met_by() {
            let is_best = trial.has_texture(&best.texture.features);
            let another = if is_best { Some(best.chance()) } else { search.another_of(trial, best) };
            if let Some(another) = another.filter(|another| *another >= LIKELY) {
                return Self::TrialMeetsIt { trial: named(trial), another, is_best };
            }
        }
        if best.texture.excess > 0.0 {
            return Self::CannotBeMet { keeps_limits: false };
        }
        // Before any trial the model error is unknown, so only a trial can be advised.
        let has_trials = !asked.learned.trials().is_empty();
        if !is_within_reach && asked.has_demands() && has_trials {
            let pairs = asked.learned.contradictions();
            let with_all = if pairs.is_empty() { 0.0 } else { greatest_chance(search) };
            let contradicting = pairs.into_iter().find(|pair| is_in_doubt(search, pair.trials, with_all));
            let name = |trial: usize| asked.learned.trials()[trial].name.clone();
            return contradicting.map_or(Self::CannotBeMet { keeps_limits: true }, |pair| Self::MeasureAgain {
                trials: pair.trials.map(name),
            });
        }
        Self::Trial
    }

    /// Name of the advice in result files.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Series => "series",
            Self::Trial => "trial",
            Self::TrialMeetsIt { .. } => "trial_meets_it",
            Self::CannotBeMet { .. } => "cannot_be_met",
            Self::MeasureAgain { .. } => "measure_again",
            Self::DoNotTexture => "do_not_texture",
        }
    }

    /// Describes the advice in one sentence with the `chance` of the texture. `has_demands`: the target has accepted
    /// bands. `is_within_reach`: some texture has a median within the accepted band.
    pub fn words(&self, chance: f64, has_demands: bool, is_within_reach: bool) -> String {
        let chance = percent(chance);
        let of_sample = format!("{chance} chance that a cut sample is on target");
        match self {
            Self::Series => format!("make a series: {of_sample}"),
            Self::Trial if has_demands && !is_within_reach => format!(
                "cut a trial: {of_sample}; the model alone reaches no texture on target, and one trial shows how far it is off"
            ),
            Self::Trial if has_demands => format!("cut a trial: {of_sample}"),
            Self::Trial => "cut a trial: the best texture found for the goal".to_owned(),
            Self::TrialMeetsIt { trial, another, is_best } => {
                let another = percent(*another);
                let other = if *is_best { String::new() } else { format!(", the likeliest other texture {chance}") };
                format!(
                    "nothing need be cut: trial {trial} already meets the target; another sample of it has a chance of {another}{other}"
                )
            }
            Self::CannotBeMet { keeps_limits: false } => {
                "this target cannot be met: no texture found keeps all limits as it would be cut; of those computed so, this one breaks them least"
                    .to_owned()
            }
            Self::CannotBeMet { keeps_limits: true } => format!(
                "this target cannot be met within the bounds and limits: no texture is expected to lie within it; the likeliest has a chance of {chance}"
            ),
            Self::MeasureAgain { trials: [first, second] } => format!(
                "measure \"{first}\" and \"{second}\" again: these samples of one texture contradict each other, and with both no texture is expected on target; the likeliest has a chance of {chance}"
            ),
            Self::DoNotTexture => "do not texture: the flat surface is what is asked for".to_owned(),
        }
    }
}

/// Greatest chance of any texture by the table; 0 without a texture.
fn greatest_chance(search: &Search<'_>) -> f64 {
    search.greatest(&|_| true).0.map_or(0.0, |best| best.chance())
}

/// Whether the greatest chance is greater without one of two `trials` than `with_all`, so that the target may be met if
/// this one was measured wrong; true if there was no time to tell.
fn is_in_doubt(search: &Search<'_>, trials: [usize; 2], with_all: f64) -> bool {
    let without = |trial: usize| {
        let mut prepared = search.prepared.clone();
        let learned = prepared.uncertainty.learned.as_mut()?;
        let mut kept = learned.trials().to_vec();
        kept.remove(trial);
        *learned = learned.with_trials(kept).ok()?;
        Some(greatest_chance(&search.asking(&Asked::new(&prepared).ok()?)))
    };
    trials.into_iter().filter_map(without).any(|chance| chance > with_all + ALIKE) || search.stage.cancelled()
}

/// Name of `trial` in quotes, with width, spacing and depth in micrometres and the areal density.
fn named(trial: &Trial) -> String {
    let Features { width_m, pitch_m, depth_m, areal_density, .. } = trial.features;
    let lengths_um = [width_m, pitch_m - width_m, depth_m].map(|length_m| length_in_words(tidy(1e6 * length_m)));
    let percent = 100.0 * areal_density;
    format!("\"{}\" (width/spacing/depth {} um, {percent:.1} % of a period)", trial.name, lengths_um.join("/"))
}

/// Whether width, pitch, depth and areal density of `trial` differ from those of the texture with the features `of` by
/// at most the factor [`NEARBY`].
fn is_near(trial: &Trial, of: &Features) -> bool {
    let near = |own: fn(&Features) -> f64| (own(&trial.features) / own(of)).ln().abs() <= NEARBY.ln();
    near(|of| of.width_m) && near(|of| of.pitch_m) && near(|of| of.depth_m) && near(|of| of.areal_density)
}

/// Whether `trial` was measured at the pressures of `asked`, or at most the factor [`NEARBY`] beside them.
fn is_near_loads(trial: &Trial, asked: &Asked) -> bool {
    let [least_pa, most_pa] = extremes(trial.measured.iter().map(|at| at.load.pressure_pa));
    asked.loads.iter().all(|load| (least_pa / NEARBY..=most_pa * NEARBY).contains(&load.pressure_pa))
}
