//! Trade-offs: textures that no other texture beats in every goal of `[trade_offs]`, by the table.
//!
//! A texture dominates another if it is at least as good by every goal and better by one (V. Pareto).

use std::borrow::Cow;

use crate::results::PatternReport;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::units::{PRESSURE_MPA, counted, tidy};
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::Simulation;

use crate::prediction::{Prediction, percent};
use crate::search::Search;
use crate::steps::Steps;
use crate::task::{TradeOffGoal, TradeOffsWanted};

/// Maximum number of non-dominated designs listed in a report; trade-offs.csv has all.
const LISTED: usize = 12;

/// Design with its values by each goal.
#[derive(Clone, Debug, PartialEq)]
pub struct TradeOff {
    /// Compared design.
    pub design: Pattern,
    /// Value by each goal, in the unit of [`TradeOffGoal::name`].
    pub goals: Vec<f64>,
}

/// Designs compared by goals.
#[derive(Clone, Debug)]
pub struct Compared {
    /// Goals of the comparison.
    pub wanted: TradeOffsWanted,
    /// Designs that no other design dominates, sorted by the first goal.
    pub front: Vec<TradeOff>,
    /// All dominated designs.
    pub dominated: Vec<TradeOff>,
}

/// Record of the trade-offs in result.json.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TradeOffsReport {
    /// Columns of trade-offs.csv for the goals.
    pub goals: Vec<Cow<'static, str>>,
    /// Goals in words.
    pub words: Vec<Cow<'static, str>>,
    /// Number of designs compared.
    pub designs: usize,
    /// Number of designs that no other design dominates.
    pub front: usize,
    /// Values of the chosen design, one per goal.
    pub chosen: Vec<f64>,
    /// Selected designs that no other design dominates, from the best to the worst by the first goal.
    pub listed: Vec<ListedDesign>,
    /// Best design by each goal.
    pub best: Vec<ListedDesign>,
}

/// Design that no other design dominates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ListedDesign {
    /// Texture of the design.
    pub design: PatternReport,
    /// Values of the design, one per goal.
    pub goals: Vec<f64>,
}

impl ListedDesign {
    fn new(known: &TradeOff) -> Self {
        let goals = known.goals.iter().copied().map(tidy).collect();
        Self { design: PatternReport::from(&known.design), goals }
    }
}

/// Compares textures within the bounds and limits of `search`, those that it `solved` and `best`, one of these, among
/// them, by the goals of its task; `None` if the task has no goals, or `best` breaks a limit. `run` is the confirming run
/// of `best`.
pub fn of(
    search: &Search<'_>,
    (best, run): (&Prediction, Option<&Simulation>),
    solved: &[Prediction],
) -> Option<(TradeOffsReport, Compared)> {
    let wanted = search.task.trade_offs.clone().filter(|_| best.texture.excess == 0.0)?;
    let own = best.texture.pattern;
    let mut patterns = Steps::new(search.task).spread(wanted.designs);
    let solved = solved.iter().map(|of| of.texture.pattern).filter(|pattern| !patterns.contains(pattern));
    patterns.extend(solved.collect::<Vec<_>>());
    let off = search.off_at(best);
    // The run of a specimen adds borders and stick-slip to the peak pressure by the table: taken as equal for all.
    let peak_off = run.zip(search.table.answer(&own));
    let peak_off = peak_off.map_or(1.0, |(run, own)| run.peak_pressure_pa() / own.peak_pressure_pa());
    let value = |found: &Prediction, goal: &TradeOffGoal| value(search, found, *goal, peak_off);
    let roughly = |pattern: &Pattern| {
        let laid = search.table.lay(pattern)?;
        search.roughly_with((pattern, &laid), &off, &best.texture.covariance, peak_off.max(1.0))
    };
    // Rough predictions leave out unlikely members: all odds p / (1 - p) change by the factor at `best`.
    let odds = |chance: f64| chance / (1.0 - chance);
    let factor = roughly(&own).map(|own| odds(best.chance()) / odds(own.chance()));
    let factor = factor.filter(|factor| factor.is_finite() && *factor > 0.0).unwrap_or(1.0);
    let corrected = |chance: f64| chance * factor / (1.0 - chance + chance * factor);
    let one = |pattern: &Pattern| {
        let found = roughly(pattern);
        let found = found.filter(|found| found.texture.excess == 0.0 && !search.stage.cancelled())?;
        let of = |goal: &TradeOffGoal| match goal {
            TradeOffGoal::Chance => Some(corrected(found.chance())),
            goal => value(&found, goal),
        };
        Some(TradeOff { design: *pattern, goals: wanted.goals.iter().map(of).collect::<Option<Vec<f64>>>()? })
    };
    let mut all: Vec<TradeOff> = patterns.par_iter().filter(|pattern| **pattern != own).filter_map(one).collect();
    let chosen: Vec<f64> = wanted.goals.iter().map(|goal| value(best, goal).unwrap_or(f64::NAN)).collect();
    if chosen.iter().all(|goal| goal.is_finite()) {
        all.push(TradeOff { design: own, goals: chosen.clone() });
    }
    let less: Vec<Vec<f64>> = all.iter().map(|known| lesser(&wanted.goals, &known.goals)).collect();
    let is_on_front = on_front(&less);
    let (mut front, mut dominated) = (Vec::new(), Vec::new());
    for (known, is_on_front) in all.into_iter().zip(is_on_front) {
        if is_on_front { front.push(known) } else { dominated.push(known) }
    }
    // A stable sort, so that the earlier of equal designs comes first.
    front.sort_by(|a, b| in_order(&lesser(&wanted.goals, &a.goals), &lesser(&wanted.goals, &b.goals)));
    let best_by = |goal: usize| {
        let by = |known: &&TradeOff| lesser(&wanted.goals, &known.goals)[goal];
        front.iter().min_by(|a, b| by(a).total_cmp(&by(b))).map(ListedDesign::new)
    };
    let stride = front.len().saturating_sub(1).div_ceil(LISTED - 1).max(1);
    let listed = front.iter().step_by(stride).chain(front.last().filter(|_| (front.len() - 1) % stride != 0));
    let report = TradeOffsReport {
        goals: wanted.goals.iter().map(|goal| goal.name().into()).collect(),
        words: wanted.goals.iter().map(|goal| goal.words()[0].into()).collect(),
        designs: front.len() + dominated.len(),
        front: front.len(),
        chosen: chosen.into_iter().map(tidy).collect(),
        listed: listed.map(ListedDesign::new).collect(),
        best: (0..wanted.goals.len()).filter_map(best_by).collect(),
    };
    Some((report, Compared { wanted, front, dominated }))
}

/// Value of `found` by `goal`, in the unit of [`TradeOffGoal::name`], with `peak_off` times the peak pressure by the
/// table; `None` if unknown.
fn value(search: &Search<'_>, found: &Prediction, goal: TradeOffGoal, peak_off: f64) -> Option<f64> {
    let pattern = &found.texture.pattern;
    match goal {
        TradeOffGoal::Chance => Some(found.chance()),
        TradeOffGoal::Misfit => Some(search.asked.misfit(&found.medians())),
        TradeOffGoal::LaserTime => search.task.laser_time_s(pattern),
        TradeOffGoal::Volume => Some(1e9 * search.task.specimen.layout(*pattern).ok()?.cavity_volume_m3()),
        TradeOffGoal::PeakPressure => {
            Some(PRESSURE_MPA.from_si(peak_off * search.table.answer(pattern)?.peak_pressure_pa()))
        }
        TradeOffGoal::Spread => {
            let (medians, stds) = (found.medians(), found.log_stds());
            let each = medians.iter().zip(stds).zip(&search.asked.bands);
            let squares = each.map(|((median, std), band)| {
                (band.flat * median * std / band.tolerance.unwrap_or_else(|| search.task.target.tolerance())).powi(2)
            });
            Some((squares.sum::<f64>() / medians.len() as f64).sqrt())
        }
    }
}

/// Values `goals` of the goals `of`, with the sign of a chance reversed, so that less is better for every goal.
fn lesser(of: &[TradeOffGoal], goals: &[f64]) -> Vec<f64> {
    of.iter().zip(goals).map(|(of, goal)| if *of == TradeOffGoal::Chance { -goal } else { *goal }).collect()
}

/// Lexicographic order of two lists of values.
fn in_order(left: &[f64], right: &[f64]) -> std::cmp::Ordering {
    let differing = left.iter().zip(right).map(|(l, r)| l.total_cmp(r)).find(|order| order.is_ne());
    differing.unwrap_or(std::cmp::Ordering::Equal)
}

/// For each element of `goals`, whether no other element dominates it. Equal elements do not dominate each other.
fn on_front(goals: &[Vec<f64>]) -> Vec<bool> {
    // In lexicographic order a dominating element comes first, and an element dominated by a dominated one is also
    // dominated by one on the front.
    let mut order: Vec<usize> = (0..goals.len()).collect();
    order.sort_by(|&a, &b| in_order(&goals[a], &goals[b]));
    let (mut front, mut is_on_front): (Vec<usize>, Vec<bool>) = (Vec::new(), vec![false; goals.len()]);
    for index in order {
        if !front.iter().any(|&other| dominates(&goals[other], &goals[index])) {
            front.push(index);
            is_on_front[index] = true;
        }
    }
    is_on_front
}

/// Whether `left` is at least as good as `right` by every goal, and better by one; less is better.
fn dominates(left: &[f64], right: &[f64]) -> bool {
    left.iter().zip(right).all(|(l, r)| l <= r) && left.iter().zip(right).any(|(l, r)| l < r)
}

impl TradeOffsReport {
    /// Formats the number of designs, the best design by each goal, and the chosen design.
    pub fn text(&self) -> String {
        let numbers = |goals: &[f64]| {
            let told = self.goals.iter().zip(goals).map(|(name, goal)| match name.as_ref() {
                "chance" => format!("chance {}", percent(*goal)),
                name => {
                    let [name, unit] = words(name);
                    format!("{name} {goal:.3} {unit}")
                }
            });
            told.collect::<Vec<_>>().join(", ")
        };
        let mut text = format!(
            "  trade-offs: {}, {} of them not beaten by another in every goal (trade-offs.csv, trade-offs.svg)\n",
            counted(self.designs, "design"),
            self.front
        );
        for (found, name) in self.best.iter().zip(&self.goals) {
            let best =
                if name == "chance" { "greatest chance".to_owned() } else { format!("least {}", words(name)[0]) };
            text += &format!("    {best}: {} um: {}\n", found.design.lengths_in_words(), numbers(&found.goals));
        }
        text + &format!("    the design: {}\n", numbers(&self.chosen))
    }
}

/// Name and unit of the goal with the column name `column`.
fn words(column: &str) -> [&str; 2] {
    let goal = TradeOffGoal::ALL.into_iter().find(|goal| goal.name() == column);
    goal.map_or([column, ""], |goal| [goal.words()[1], goal.words()[2]])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_agrees_with_the_definition_on_random_sets() {
        let mut normals = slipgrid_base::statistics::Normals::new(11);
        for count in [1, 2, 30, 200] {
            for dimensions in [2, 3] {
                // Rounded, so that equal goals occur.
                let goals: Vec<Vec<f64>> =
                    (0..count).map(|_| (0..dimensions).map(|_| (3.0 * normals.draw()).round()).collect()).collect();
                let expected: Vec<bool> =
                    goals.iter().map(|own| !goals.iter().any(|other| dominates(other, own))).collect();
                assert_eq!(on_front(&goals), expected);
            }
        }
    }
}
