//! The chance that a cut sample is on target, as JSON and in words.

use serde::{Deserialize, Serialize};
use slipgrid_optimize::ModelFailure;
use slipgrid_springblock::{LoadOutcome, Simulation};

use crate::DesignError;
use crate::chance::{About, Chances, Expansion, Gain, Judged, Numerical};
use crate::multi_fidelity::MultiFidelityLoop;
use crate::next_trial::AdviceReport;
use crate::task::DesignTask;
use slipgrid_calibrate::uncertainty::MaterialUncertainty;
use slipgrid_results::ErrorsReport;
use slipgrid_results::errors::{self, BEHIND, LAYOUT, TIME_AVERAGE};
use slipgrid_units::{PRESSURE_MPA, tidy};

/// Draws of the expansion: a half is known to 0.4 %.
const DRAWS: usize = 20_000;
/// The first of them, of which the steady model itself is asked in the vertical plane, and those of each part. It judges one in fifty to
/// seventy otherwise, so that the chance is known to 0.7 %.
const SAMPLED: usize = 400;
const SAMPLED_PARTS: usize = 150;
/// Standard errors of a gain by which it must be above 0 to be told.
const BEYOND_DRAWS: f64 = 2.0;
/// How the numerical errors are called.
const NUMERICAL: &str = "numerical error";
/// What is never known unless a design aims with it.
const MODEL: &str = "how far the model itself is off";

/// The chance that a cut sample is on target, at all pressures and conditions at once.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChanceReport {
    /// Share of draws; null where nothing is known that could be drawn.
    pub value: Option<f64>,
    /// Its standard error: that of the draws of the expansion, and of what the model says otherwise of its own.
    pub stderr: Option<f64>,
    /// The chance in words, with what limits it most.
    pub words: String,
    /// What was drawn, with how well it is known.
    pub included: Vec<String>,
    /// What it does not include, because no error is given.
    pub not_known: Vec<String>,
    /// The part without which the chance would be greatest; null where it is nearly certain, or where no part makes a difference
    /// beyond that of the draws.
    pub limited_by: Option<PartReport>,
    /// The same of every part, the greatest gain first.
    pub parts: Vec<PartReport>,
    /// Draws of the steady model's expansion about the confirming runs.
    pub draws: usize,
    /// The first of them, which the steady model itself judged too; 0 in space.
    #[serde(default)]
    pub draws_of_the_model: usize,
}

/// Something that is not known exactly.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartReport {
    /// The input, in words.
    pub input: String,
    /// How well it is known, in words.
    pub known_to: String,
    /// The chance if it were known exactly: greater by what the same draws gain.
    pub chance_without: f64,
}

impl MultiFidelityLoop<'_> {
    /// The chance of the design found, about its confirming runs, with the expansion that it rests on where it is known; `None` where
    /// nothing is demanded, so that nothing can be missed.
    pub(super) fn chance(
        &self,
        design: &DesignTask,
        material: &MaterialUncertainty,
        chances: &Chances,
        errors: &ErrorsReport,
    ) -> Result<Option<(ChanceReport, Option<Expansion>)>, DesignError> {
        let (Some(best), Some(confirmed)) = (&self.round.best, &self.round.confirmed) else { return Ok(None) };
        if !design.target.has_demands() {
            return Ok(None);
        }
        let known = material.at_loads(self.scene.area_law.as_ref(), &self.scene.loads, design.condition.as_ref())?;
        let mut not_known: Vec<String> = Vec::new();
        if design.tolerances.is_none() {
            not_known.push(TOLERANCES.to_owned());
        }
        let has_exact_rims = design.tolerances.is_none_or(|scatter| scatter.tolerances.rim_height_std_m == 0.0);
        if best.design.texture().rim().is_some() && has_exact_rims {
            not_known.push("tolerance of the rims' height".to_owned());
        }
        not_known.extend(material.unknown(&known, self.model.area_law()).into_iter().map(str::to_owned));
        let (numerical, discretization) = numerical(design, &self.model.scales(&best.design), confirmed, errors);
        if !discretization {
            not_known.push("discretization".to_owned());
        }
        if !design.discrepancy {
            not_known.push(MODEL.to_owned());
        }
        let values = self.confirmed_values();
        let nothing = |words: &str, not_known| ChanceReport {
            value: None,
            stderr: None,
            words: words.to_owned(),
            included: Vec::new(),
            not_known,
            limited_by: None,
            parts: Vec::new(),
            draws: 0,
            draws_of_the_model: 0,
        };
        let Some(values) = values else {
            let (each, count) = (self.confirmed_each(), design.target.points().len());
            let first = each.iter().position(Option::is_none).unwrap_or(0);
            let further = (first / count).checked_sub(1).and_then(|place| self.further.get(place));
            let words = match further {
                _ if self.out_of_time => "chance not known: the confirming run was cut short".to_owned(),
                Some(at) => format!(
                    "chance not known: at {} the design or the flat sample does not slide evenly in the model",
                    at.at.in_words()
                ),
                None => format!(
                    "chance not known: at {} MPa the design or the flat sample does not slide evenly in the model",
                    tidy(PRESSURE_MPA.from_si(design.target.points()[first % count].pressure_pa))
                ),
            };
            return Ok(Some((nothing(&words, not_known), None)));
        };
        if !chances.is_known() {
            let words = "chance not known: neither tolerances nor errors of the material are given";
            return Ok(Some((nothing(words, not_known), None)));
        }
        // A search compares designs in the guide's blocks; what is announced is of the blocks asked for.
        let asked = self.model.without_guide();
        let asked = asked.map(|model| Chances::new(design, material, &model, &self.further)).transpose()?;
        let chances = asked.as_ref().unwrap_or(chances);
        let still = chances.still(&best.design);
        let expanded = still.and_then(|still| {
            let about = About { design: &best.design, still: &still, values: &values, numerical: &numerical };
            Ok((chances.expand(&about)?, still))
        });
        let (expansion, still) = match expanded {
            Ok(found) => found,
            Err(ModelFailure::Trial { reason }) => {
                let words = format!("chance not known: neighbours of the design cannot be computed ({reason})");
                return Ok(Some((nothing(&words, not_known), None)));
            }
            Err(ModelFailure::Cancelled) => return Err(DesignError::Cancelled),
            Err(failure) => return Err(DesignError::Failed(format!("chance: {failure}"))),
        };
        let about = About { design: &best.design, still: &still, values: &values, numerical: &numerical };
        let is_sampled = self.model.is_cheap_per_design();
        let failed = |failure: ModelFailure| DesignError::Failed(format!("chance: {failure}"));
        let draws = chances.draws_about(&best.design, DRAWS, design.seed).map_err(failed)?;
        let judged = |count: usize, of: &(dyn Fn(usize) -> bool + Sync)| {
            let sampled = if is_sampled { chances.sampled(&about, count, design.seed, of) } else { Ok(Vec::new()) };
            Ok::<_, DesignError>(Judged {
                expanded: chances.expanded(&draws, &expansion, of),
                sampled: sampled.map_err(failed)?,
            })
        };
        let drawn = judged(SAMPLED, &|_| true)?;
        let all = drawn.probability();
        let gains = gains(chances, &numerical, &|of| Ok(judged(SAMPLED_PARTS, of)?.gain_over(&drawn)))?;
        let mut included: Vec<String> =
            chances.inputs().iter().map(|input| format!("{} ({})", input.name, input.known_to)).collect();
        included.push(if discretization {
            format!("{NUMERICAL} (time average, discretization)")
        } else {
            format!("{NUMERICAL} (time average)")
        });
        let is_clear = |gain: &Gain| all.share < 0.995 && gain.share > BEYOND_DRAWS * gain.stderr;
        let is_limit = gains.first().is_some_and(|(_, gain)| is_clear(gain));
        let without = |(part, gain): (Part<'_>, Gain)| PartReport {
            input: part.input.to_owned(),
            known_to: part.known_to,
            chance_without: tidy((all.share + gain.share).clamp(0.0, 1.0)),
        };
        let parts: Vec<PartReport> = gains.into_iter().map(without).collect();
        let limited_by = parts.first().filter(|_| is_limit).cloned();
        let report = ChanceReport {
            words: format!("{} {ON_TARGET}{}", percent(all.share), limits(limited_by.as_ref(), &not_known)),
            value: Some(tidy(all.share)),
            stderr: Some(tidy(all.stderr)),
            included,
            not_known,
            limited_by,
            parts,
            draws: DRAWS,
            draws_of_the_model: drawn.sampled.len(),
        };
        Ok(Some((report, Some(expansion))))
    }
}

/// How exactly the values were computed, at each load of each condition as at the same pressure of the condition designed for, and
/// whether that includes the discretization.
pub(super) fn numerical(
    design: &DesignTask,
    scales: &[f64],
    confirmed: &Simulation,
    errors: &ErrorsReport,
) -> (Numerical, bool) {
    let count = design.target.points().len();
    let is_ratio = design.target.quantity() == slipgrid_optimize::Quantity::Ratio;
    let discretization = |row: usize| confirmed.loads.get(row).and_then(|load| load.ratio_discretization_error);
    let run = |row: usize, parts: &[&str]| {
        let at = errors.at(row)?;
        let of = if is_ratio { at.ratio.as_ref()? } else { &at.mu };
        Some(of.std_of_all(parts))
    };
    let scatter = |place: usize| run(place % count, &[TIME_AVERAGE]).unwrap_or(0.0);
    let common = |place: usize| {
        let row = place % count;
        // What errors hardly exceed, as two standard deviations.
        let of_blocks = 0.5 * scales[place] * discretization(row).unwrap_or(0.0);
        run(row, &[errors::DRAWS, LAYOUT, BEHIND]).unwrap_or(0.0).hypot(of_blocks)
    };
    let tilt = |place: usize| {
        let load = confirmed.loads.get(place % count);
        scales[place] * load.and_then(LoadOutcome::tilt_error).unwrap_or(0.0)
    };
    let of = |std: &dyn Fn(usize) -> f64| (0..scales.len()).map(std).collect();
    let numerical = Numerical { scatter: of(&scatter), common: of(&common), tilt: of(&tilt) };
    (numerical, (0..count).all(|row| discretization(row).is_some()))
}

/// Which inputs are off.
type Off<'a> = dyn Fn(usize) -> bool + Sync + 'a;

/// Something that is not known exactly: how it is called, and how well it is known in words.
struct Part<'a> {
    input: &'a str,
    known_to: String,
}

/// How much greater the chance would be if each part were known exactly, the greatest gain first.
fn gains<'a>(
    chances: &'a Chances,
    numerical: &Numerical,
    gain: &dyn Fn(&Off<'_>) -> Result<Gain, DesignError>,
) -> Result<Vec<(Part<'a>, Gain)>, DesignError> {
    let mut gains: Vec<(Part, Gain)> = Vec::new();
    for input in chances.inputs() {
        let part = Part { input: input.name, known_to: input.known_to.clone() };
        gains.push((part, gain(&|place| !input.places.contains(&place))?));
    }
    let places = chances.numerical();
    let known_to = format!("up to {:.4}", numerical.most());
    gains.push((Part { input: NUMERICAL, known_to }, gain(&|place| !places.contains(&place))?));
    // Stable: of equal gains the earlier first.
    gains.sort_by(|(_, a), (_, b)| b.share.total_cmp(&a.share));
    Ok(gains)
}

/// A share in per cent, as one says it.
#[must_use]
pub fn percent(share: f64) -> String {
    match 100.0 * share {
        percent if percent < 0.5 => "less than 1 %".to_owned(),
        percent if percent > 99.5 => "more than 99 %".to_owned(),
        percent => format!("{percent:.0} %"),
    }
}

/// What the chance is of.
const ON_TARGET: &str = "chance that a cut sample is on target";
/// Where the chance leaves out scatter that nobody told it.
const TOLERANCES: &str = "tolerances of width, spacing and depth";

/// What limits a chance, in parentheses behind it.
fn limits(limited_by: Option<&PartReport>, not_known: &[String]) -> String {
    let is_unknown = |name: &str| not_known.iter().any(|unknown| unknown == name);
    let mut of = Vec::new();
    if let Some(part) = limited_by {
        of.push(format!("limited by {}, {}", part.input, part.known_to));
    }
    if is_unknown(TOLERANCES) {
        of.push("from the material alone: tolerances are not given".to_owned());
    } else if ["flat friction", "Young's modulus", "scale of the area law"].into_iter().any(is_unknown) {
        of.push("not all errors of the material are given".to_owned());
    }
    if of.is_empty() { String::new() } else { format!(" ({})", of.join("; ")) }
}

impl ChanceReport {
    /// What a design is announced with: the chance by what trials say that the model lacks, where `advice` has it and the chance
    /// itself does not count it.
    #[must_use]
    pub fn announced(&self, advice: Option<&AdviceReport>) -> String {
        match (self.value, self.beside(advice)) {
            (_, Some(advice)) => format!("{} {ON_TARGET}", percent(advice.chance)),
            _ => self.words.clone(),
        }
    }

    /// What the chance announced counts, and what it would be if the model lacked nothing; `None` where the two are the same.
    #[must_use]
    pub fn with_and_without_trials(&self, advice: Option<&AdviceReport>) -> Option<String> {
        let advice = self.beside(advice)?;
        let Some(share) = self.value else {
            let words = self.words.replacen("chance not known", "the chance is not known", 1);
            return Some(format!("the chance counts only {}; for the model alone {words}", advice.known_of()));
        };
        Some(format!(
            "the chance counts {}; if it lacked nothing, it would be {}{}",
            advice.known_of(),
            percent(share),
            limits(self.limited_by.as_ref(), &self.not_known)
        ))
    }

    /// The chance that is announced.
    #[must_use]
    pub fn announced_value(&self, advice: Option<&AdviceReport>) -> Option<f64> {
        self.beside(advice).map(|advice| advice.chance).or(self.value)
    }

    /// The chance if the model lacked nothing; `None` where the chance counts what it may lack.
    #[must_use]
    pub fn if_model_lacked_nothing(&self) -> Option<f64> {
        self.value.filter(|_| self.not_known.iter().any(|unknown| unknown == MODEL))
    }

    /// The advice, where the chance does not count what trials say.
    fn beside<'a>(&self, advice: Option<&'a AdviceReport>) -> Option<&'a AdviceReport> {
        advice.filter(|_| self.not_known.iter().any(|unknown| unknown == MODEL))
    }

    /// What is in the chance and what is not, one line each. Where `advice` counts how far the model is off, that is
    /// in the chance announced.
    #[must_use]
    pub fn lines(&self, advice: Option<&AdviceReport>) -> Vec<String> {
        let both = self.with_and_without_trials(advice);
        let [includes, leaves_out] = match (&both, self.value) {
            (Some(_), Some(_)) => ["both include", "neither chance includes"],
            (Some(_), None) => ["the chance also includes", "the chance does not include"],
            (None, _) => ["the chance includes", "it does not include"],
        };
        let is_left = |of: &&str| both.is_none() || *of != MODEL;
        let left: Vec<&str> = self.not_known.iter().map(String::as_str).filter(is_left).collect();
        let mut lines: Vec<String> = both.into_iter().collect();
        if !self.included.is_empty() {
            lines.push(format!("{includes} {}", self.included.join(", ")));
        }
        if !left.is_empty() {
            lines.push(format!("{leaves_out} the following, for which no error is given: {}", left.join(", ")));
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chance_that_counts_what_the_model_lacks_is_not_that_of_a_model_without_faults() {
        let of = |not_known: &[&str]| ChanceReport {
            value: Some(0.7),
            stderr: None,
            words: String::new(),
            included: Vec::new(),
            not_known: not_known.iter().map(|&name| name.to_owned()).collect(),
            limited_by: None,
            parts: Vec::new(),
            draws: 1,
            draws_of_the_model: 1,
        };
        let advice = AdviceReport { chance: 0.2, ..advice() };
        let (without, with) = (of(&[TOLERANCES, MODEL]), of(&[TOLERANCES]));
        assert_eq!((without.announced_value(Some(&advice)), without.if_model_lacked_nothing()), (Some(0.2), Some(0.7)));
        assert_eq!((with.announced_value(Some(&advice)), with.if_model_lacked_nothing()), (Some(0.7), None));
        assert_eq!((without.announced_value(None), without.if_model_lacked_nothing()), (Some(0.7), Some(0.7)));
    }

    fn advice() -> AdviceReport {
        AdviceReport {
            advice: String::new(),
            chance: 0.1,
            trials: 0,
            words: String::new(),
            predicted: Vec::new(),
            rather: Vec::new(),
        }
    }

    #[test]
    fn a_chance_that_is_not_known_is_said_so_in_sentences() {
        let chance = ChanceReport {
            value: None,
            stderr: None,
            words: "chance not known: neither tolerances nor errors of the material are given".to_owned(),
            included: Vec::new(),
            not_known: vec![MODEL.to_owned(), "area law".to_owned()],
            limited_by: None,
            parts: Vec::new(),
            draws: 0,
            draws_of_the_model: 0,
        };
        let lines = chance.lines(Some(&advice()));
        assert_eq!(
            lines,
            [
                "the chance counts only how far the model may be off, as it is believed before any trial; for the model alone the \
                 chance is not known: neither tolerances nor errors of the material are given",
                "the chance does not include the following, for which no error is given: area law"
            ]
        );
    }
}
