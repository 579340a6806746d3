//! Trade-offs: the designs that no other beats in every goal of `[trade_offs]`.

use std::borrow::Cow;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use slipgrid_optimize::{
    Choice, Linearization, ModelFailure, Response, SearchError, Target, TradeOff, TradeOffOptions, TradeOffs,
    Uncertainty, compare, trade_offs,
};
use slipgrid_pattern::Pattern;

use crate::DesignError;
use crate::chance_report::percent;
use crate::constraint_quantities::Limited;
use crate::evaluation_cache::Answer;
use crate::job::Compared;
use crate::learned_discrepancy::LearnedDiscrepancy;
use crate::selection::{Chosen, Effort};
use crate::steady_model::SteadyModel;
use crate::task::DesignTask;
use crate::task::{TradeOffGoal, TradeOffsWanted};
use slipgrid_monitor::{Monitor, Stage};
use slipgrid_results::PatternReport;
use slipgrid_units::{PRESSURE_MPA, tidy};

/// What the chances of trade-offs are.
pub const BEFORE: &str = "chances by the steady model, before any confirming run, are to be compared with one another, not with the chance \
                          above; but for those that come first they are interpolated between designs, to about 1 %; designs whose chances \
                          differ by less than the error of the choice count as equal, and the one with less effort is listed";

/// Designs of the front that a report lists; the table beside it has all.
const LISTED: usize = 12;

/// The trade-offs as result.json holds them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TradeOffsReport {
    /// Columns of trade-offs.csv that designs were compared by.
    pub goals: Vec<Cow<'static, str>>,
    /// The same in words.
    pub words: Vec<Cow<'static, str>>,
    /// Designs compared.
    pub designs: usize,
    /// Designs left out: not computable, or beyond a limit.
    pub left_out: usize,
    /// Designs that no other one dominates.
    pub front: usize,
    /// What the chosen design does by each goal; null where it cannot be compared.
    pub chosen: Option<Vec<f64>>,
    /// Whether none of the others is at least as good by every goal and better by one.
    pub chosen_is_on_front: bool,
    /// `listed` and `best` are of designs that meet the target alone; otherwise there are none, or misfit is no goal.
    pub on_target: bool,
    /// Some of the front, from one end by the first goal to the other.
    pub listed: Vec<ListedDesign>,
    /// The best of the front by each goal.
    pub best: Vec<ListedDesign>,
    /// The model by which designs were compared.
    pub model: String,
    /// Why no design could be compared; absent where some were.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub none_because: Option<String>,
}

/// A design of the front.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ListedDesign {
    /// The design.
    pub design: PatternReport,
    /// Its value by each goal.
    pub goals: Vec<f64>,
}

impl ListedDesign {
    fn new(known: &TradeOff) -> Self {
        let goals = known.goals.iter().copied().map(tidy).collect();
        Self { design: PatternReport::from(&known.design), goals }
    }
}

/// Designs by their vertical section, calibrated at the chosen one.
struct Plane<'a> {
    cell: SteadyModel<'a>,
    /// The search's model sees what lies between rows of cavities; one of a section takes its target for grooves.
    sees_face: bool,
    /// What ratios are multiplied by at each load.
    scale: Vec<f64>,
    /// Lowering of friction by the search's model over that by the section's strip estimate, at the chosen design.
    lowering: Vec<f64>,
    /// Added to values after that.
    offset: Vec<f64>,
    /// What designs aim with beside the physics, and slopes along the modulus at the chosen design, taken for those of all.
    learned: Option<(Arc<LearnedDiscrepancy<'a>>, Vec<f64>)>,
}

impl<'a> Plane<'a> {
    fn new(model: &SteadyModel<'a>, chosen: &Pattern, value: &[f64]) -> Result<Self, ModelFailure> {
        let cell = model.in_plane();
        let scale = (0..value.len()).map(|load| model.scale(load)).collect();
        let sees_face = model.dimension().sees_face();
        let learned = match model.learned() {
            Some(learned) => Some((Arc::clone(learned), learned.modulus_sensitivity(chosen)?)),
            None => None,
        };
        let (lowering, offset) = (vec![1.0; value.len()], vec![0.0; value.len()]);
        let mut plane = Self { cell, sees_face, lowering, offset, scale, learned };
        let (own, _) = plane.answer(chosen)?;
        let physics = value.iter().zip(plane.factors(chosen)).map(|(value, factor)| value / factor);
        for (load, (value, own)) in physics.zip(&own).enumerate() {
            let scale = plane.scale[load];
            // In space 1 - ratio is corrected by a factor: no cavities, no lowering.
            let factor = (1.0 - value / scale) / (1.0 - own / scale);
            if sees_face && factor.is_finite() && factor > 0.0 {
                plane.lowering[load] = factor;
            } else {
                plane.offset[load] = value - own;
            }
        }
        Ok(plane)
    }

    /// The discrepancy's medians at `design`, one a load: 1 where designs do not aim with it.
    fn factors(&self, design: &Pattern) -> Vec<f64> {
        let ones = || vec![1.0; self.scale.len()];
        self.learned.as_ref().map_or_else(ones, |(learned, slopes)| learned.factors(design, slopes))
    }

    /// The target's quantity at each load, as it is compared with the target.
    fn value(&self, design: &Pattern) -> Result<Vec<f64>, ModelFailure> {
        let (physics, _) = self.answer(design)?;
        Ok(physics.iter().zip(self.factors(design)).map(|(value, factor)| value * factor).collect())
    }

    /// The target's quantity at each load by the physics alone, and what it was made of.
    fn answer(&self, design: &Pattern) -> Result<(Vec<f64>, Answer), ModelFailure> {
        let answer = self.cell.steady(&design.as_groove())?;
        let value: Vec<f64> = answer
            .ratio
            .iter()
            .enumerate()
            .map(|(load, ratio)| {
                let own = if self.sees_face { design.strip_estimate(*ratio) } else { *ratio };
                let ratio = 1.0 - self.lowering[load] * (1.0 - own);
                ratio * self.scale[load] + self.offset[load]
            })
            .collect();
        Ok((value, answer))
    }
}

/// Compares the designs of `design` by its goals, the chosen one among them, and adds a table and a picture. `value` is
/// what the search's model says of `chosen`. Where the chance is a goal, what it was chosen from, `selection`, is what is
/// compared. `None` where nothing is to be compared, and where `bar` ends before that.
///
/// Where no design respects every limit the report says so, and the table is empty.
///
/// # Errors
/// [`DesignError`] where the model is broken, or the picture cannot be drawn.
pub fn report(
    design: &DesignTask,
    model: &SteadyModel,
    (chosen, value): (&Pattern, &[f64]),
    selection: Option<&Chosen>,
    bar: &Stage<'_>,
) -> Result<Option<(TradeOffsReport, Compared)>, DesignError> {
    let Some(input) = &design.trade_offs else { return Ok(None) };
    let chance_at = input.goals.iter().position(|goal| *goal == TradeOffGoal::Chance);
    let pool = match (chance_at, selection) {
        (None, _) => None,
        (Some(_), Some(selection)) => Some(Pool::new(selection)),
        // No design on target was compared by its chance.
        (Some(_), None) => return Ok(None),
    };
    let failed = |reason: String| DesignError::Failed(format!("trade-offs: {reason}"));
    let plane = match Plane::new(model, chosen, value) {
        Ok(plane) => plane,
        Err(ModelFailure::Trial { reason }) => {
            let reason = format!("the design found cannot be computed in the vertical plane: {reason}");
            return Ok(Some(nothing(input, model, 0, &reason)));
        }
        Err(failure) => return Err(failed(failure.to_string())),
    };
    let spread = input.goals.contains(&TradeOffGoal::Spread);
    let tolerances = design.tolerances.filter(|_| spread).map(|input| input.tolerances);
    let uncertainty = tolerances
        .map(|tolerances| Uncertainty::new(&tolerances, &[]))
        .transpose()
        .map_err(|error| failed(error.to_string()))?;
    let limited = Limited::of(design, model);
    let by =
        By { design, input, plane: &plane, limited: &limited, uncertainty: uncertainty.as_ref(), pool: pool.as_ref() };
    let goals = |at: &Pattern| {
        if bar.cancelled() {
            return Err(ModelFailure::Cancelled);
        }
        bar.advance(0.5 / input.designs as f64);
        by.goals(at)
    };
    let options = TradeOffOptions { lattice: input.designs, ..TradeOffOptions::default() };
    let found = match &pool {
        Some(pool) => compare(&design.constraints, &pool.designs(), &goals),
        None => trade_offs(&design.space, &design.constraints, &[*chosen], &options, &goals),
    };
    let mut found = match found {
        Ok(found) => found,
        Err(_) if bar.cancelled() => return Ok(None),
        Err(SearchError::EveryTrialFailed { trials, reason }) => {
            let reason = format!("no design respects every limit; of the first, {reason}");
            return Ok(Some(nothing(input, model, trials, &reason)));
        }
        Err(error) => return Err(failed(error.to_string())),
    };
    let order = found.front.clone();
    if let (Some(place), Some(pool)) = (chance_at, &pool) {
        for known in found.front.iter_mut().chain(&mut found.dominated) {
            known.goals[place] = pool.place(&known.design).map_or(0.0, |own| pool.choices[own].chance.share);
        }
    }
    let found = found;
    let own = found.front.iter().chain(&found.dominated).find(|known| known.design == *chosen);
    let chosen_goals = own.map(|known| known.goals.clone());
    let misfit = input.goals.iter().position(|goal| *goal == TradeOffGoal::Misfit);
    let is_met = |known: &&TradeOff| pool.is_some() || misfit.is_some_and(|place| known.goals[place] <= 1.0);
    let met: Vec<&TradeOff> = found.front.iter().filter(is_met).collect();
    let shown = if met.is_empty() { found.front.iter().collect() } else { met.clone() };
    let report = TradeOffsReport {
        goals: input.goals.iter().map(|goal| goal.column().into()).collect(),
        words: input.goals.iter().map(|goal| goal.words().into()).collect(),
        designs: found.front.len() + found.dominated.len(),
        left_out: found.left_out,
        front: found.front.len(),
        chosen: chosen_goals.map(|goals| goals.into_iter().map(tidy).collect()),
        chosen_is_on_front: found.front.iter().any(|known| known.design == *chosen),
        on_target: !met.is_empty(),
        listed: listed(&shown),
        best: (0..input.goals.len()).filter_map(|goal| best(&shown, &order, goal, chance_at)).collect(),
        model: model_words(model),
        none_because: None,
    };
    Ok(Some((report, Compared { wanted: input.clone(), found })))
}

/// By what model designs are compared.
fn model_words(model: &SteadyModel) -> String {
    if model.dimension().sees_face() {
        "steady cells of the vertical section in the plane, strips between rows of cavities counted as flat, corrected to \
         the model in space at the chosen design; peak pressures are those of the section"
            .to_owned()
    } else {
        "steady cells in the vertical plane".to_owned()
    }
}

/// The report where no design can be compared, and a table without rows.
fn nothing(input: &TradeOffsWanted, model: &SteadyModel, left_out: usize, reason: &str) -> (TradeOffsReport, Compared) {
    let found = TradeOffs { front: Vec::new(), dominated: Vec::new(), left_out };
    let report = TradeOffsReport {
        goals: input.goals.iter().map(|goal| goal.column().into()).collect(),
        words: input.goals.iter().map(|goal| goal.words().into()).collect(),
        designs: 0,
        left_out,
        front: 0,
        chosen: None,
        chosen_is_on_front: false,
        on_target: false,
        listed: Vec::new(),
        best: Vec::new(),
        model: model_words(model),
        none_because: Some(reason.to_owned()),
    };
    (report, Compared { wanted: input.clone(), found })
}

/// The designs on target, with their chances.
struct Pool<'a> {
    choices: &'a [Choice],
    /// What each is ranked by.
    merits: Vec<f64>,
    /// Those from here on are alike.
    alike_from: f64,
}

impl<'a> Pool<'a> {
    fn new(chosen: &'a Chosen) -> Self {
        let merits = chosen.selection.merits();
        let alike_from = merits.iter().copied().fold(0.0, f64::max) - chosen.selection.alike;
        Self { choices: &chosen.selection.pool, merits, alike_from }
    }

    fn designs(&self) -> Vec<Pattern> {
        self.choices.iter().map(|choice| choice.candidate.design).collect()
    }

    fn place(&self, design: &Pattern) -> Option<usize> {
        self.choices.iter().position(|choice| choice.candidate.design == *design)
    }
}

/// What designs are compared by.
struct By<'a> {
    design: &'a DesignTask,
    input: &'a TradeOffsWanted,
    plane: &'a Plane<'a>,
    limited: &'a Limited,
    uncertainty: Option<&'a Uncertainty>,
    pool: Option<&'a Pool<'a>>,
}

impl By<'_> {
    /// What a design does by each goal.
    fn goals(&self, at: &Pattern) -> Result<Vec<f64>, ModelFailure> {
        let trial = |reason: &str| ModelFailure::Trial { reason: reason.to_owned() };
        let (physics, answer) = self.plane.answer(at)?;
        let limited = self.limited.values(at, &answer)?;
        let value = physics.iter().zip(self.plane.factors(at)).map(|(value, factor)| value * factor).collect();
        let response = Response { value, limited };
        // Those of the pool respect every limit by the search's own model.
        let broken = self.design.constraints.violations(at, &response);
        if let Some(broken) = broken.first().filter(|_| self.pool.is_none()) {
            return Err(trial(&broken.to_string()));
        }
        self.input
            .goals
            .iter()
            .map(|goal| match goal {
                TradeOffGoal::Chance => {
                    let pool = self.pool.ok_or_else(|| trial("there are no chances"))?;
                    let place = pool.place(at).ok_or_else(|| trial("its chance is not known"))?;
                    Ok((pool.alike_from - pool.merits[place]).max(0.0))
                }
                TradeOffGoal::Misfit => Ok(self.design.target.misfit(&response.value).max),
                TradeOffGoal::LaserTime => Effort::LaserTime.of(self.design, at),
                TradeOffGoal::Volume => Effort::Volume.of(self.design, at),
                TradeOffGoal::PeakPressure => Ok(PRESSURE_MPA.from_si(answer.peak_pressure_pa())),
                TradeOffGoal::Spread => match self.uncertainty {
                    Some(uncertainty) => spread(&self.design.target, self.plane, uncertainty, at),
                    None => Err(ModelFailure::Broken { reason: "there are no tolerances".to_owned() }),
                },
            })
            .collect()
    }
}

/// Root mean square over pressures of the standard deviation over samples, to first order, in tolerances.
fn spread(target: &Target, plane: &Plane, uncertainty: &Uncertainty, at: &Pattern) -> Result<f64, ModelFailure> {
    let model = |made: &Pattern, _: &[f64]| plane.value(made);
    let std = Linearization::new(&model, at, uncertainty)?.std(uncertainty);
    let mean_square = std.iter().map(|std| (std / target.tolerance()).powi(2)).sum::<f64>() / std.len() as f64;
    Ok(mean_square.sqrt())
}

/// Some of `front`, evenly by place, both ends among them.
fn listed(front: &[&TradeOff]) -> Vec<ListedDesign> {
    let most = LISTED.min(front.len());
    let place = |step: usize| if most > 1 { step * (front.len() - 1) / (most - 1) } else { 0 };
    (0..most).map(|step| ListedDesign::new(front[place(step)])).collect()
}

/// The best by one goal as it was compared in `order`; the earliest of equals. Chances alike were compared as one: of these, by goal number
/// `chance_at`, the greatest itself.
fn best(front: &[&TradeOff], order: &[TradeOff], goal: usize, chance_at: Option<usize>) -> Option<ListedDesign> {
    if chance_at == Some(goal) {
        let greatest =
            front.iter().reduce(|best, next| if next.goals[goal] > best.goals[goal] { next } else { best })?;
        return Some(ListedDesign::new(greatest));
    }
    let shown = |compared: &&TradeOff| front.iter().any(|known| known.design == compared.design);
    let best = order.iter().filter(shown).min_by(|a, b| a.goals[goal].total_cmp(&b.goals[goal]))?;
    front.iter().find(|known| known.design == best.design).map(|known| ListedDesign::new(known))
}

/// A goal's name in files as words, and its unit.
fn words(name: &str) -> [&str; 2] {
    let (goal, unit) = name.rsplit_once('_').unwrap_or((name, ""));
    let goal = match goal {
        "laser_time" => "laser time",
        "peak_pressure" => "peak pressure",
        other => other,
    };
    [goal, if unit == "mpa" { "MPa" } else { unit }]
}

impl TradeOffsReport {
    /// A line or two for people.
    #[must_use]
    pub fn text(&self) -> String {
        if let Some(reason) = &self.none_because {
            return format!("  trade-offs: none: {reason}\n");
        }
        let numbers = |goals: &[f64]| {
            let told = self.goals.iter().zip(goals).map(|(name, goal)| {
                let [goal_name, unit] = words(name);
                if *name == "chance" {
                    format!("chance by the steady model {}", percent(*goal))
                } else {
                    format!("{goal_name} {goal:.3} {unit}")
                }
            });
            told.collect::<Vec<_>>().join(", ")
        };
        let mut text = format!(
            "  trade-offs: of {} designs {} are not beaten by another in every goal (trade-offs.csv, trade-offs.svg)\n",
            self.designs, self.front
        );
        let among = if self.on_target { " on target" } else { "" };
        for (found, name) in self.best.iter().zip(&self.goals) {
            let design = &found.design;
            let told = numbers(&found.goals);
            text += &format!(
                "    {}{among}: {} um: {told}\n",
                if *name == "chance" {
                    "greatest chance of these".to_owned()
                } else {
                    format!("least {}", words(name)[0])
                },
                design.lengths_in_words(),
            );
        }
        if let Some(chosen) = &self.chosen {
            text += &format!(
                "    chosen{}: {}\n",
                if self.chosen_is_on_front { "" } else { ", beaten by others in these goals" },
                numbers(chosen)
            );
        }
        if self.goals.iter().any(|name| name == "chance") {
            text += &format!("    {BEFORE}\n");
        }
        text
    }
}
