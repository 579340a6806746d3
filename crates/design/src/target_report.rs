//! A target as result.json holds it, and what became of its goal.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use slipgrid_optimize::{Demand, Goal, Quantity, Target, Wanted};

use slipgrid_results::{ErrorsReport, PressureErrors};
use slipgrid_results::{fixed, with_error};
use slipgrid_units::{PRESSURE_MPA, tidy};

/// A target as result.json holds it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TargetReport {
    /// `ratio` or `mu_dynamic`.
    pub quantity: Cow<'static, str>,
    /// Nominal pressures.
    pub pressure_mpa: Vec<f64>,
    /// Wanted values; null where a band or a goal is given instead.
    pub value: Option<Vec<f64>>,
    /// Largest accepted distance, one number where all pressures share it; null as the values.
    pub tolerance: Option<Tolerance>,
    /// Lowest accepted values; null where anything is.
    pub lowest: Vec<Option<f64>>,
    /// Highest accepted values; null where anything is.
    pub highest: Vec<Option<f64>>,
    /// `lowest`, `highest` or `even`; null without a goal.
    pub goal: Option<Cow<'static, str>>,
    /// How much each pressure counts in means; null where all count alike.
    pub weights: Option<Vec<f64>>,
}

/// One for all pressures, or one for each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Tolerance {
    /// For all.
    One(f64),
    /// For each.
    Each(Vec<f64>),
}

impl From<&Target> for TargetReport {
    fn from(target: &Target) -> Self {
        let points = target.points();
        let near = |point: &Demand| match point.wanted {
            Wanted::Near { value, tolerance } => Some((value, tolerance)),
            _ => None,
        };
        let near: Option<Vec<(f64, f64)>> = points.iter().map(near).collect();
        let (value, tolerance): (Option<Vec<f64>>, Option<Vec<f64>>) =
            near.map(|near| near.into_iter().unzip()).unzip();
        let tolerance = tolerance.map(|each| match each.first() {
            Some(&one) if each.iter().all(|tolerance| *tolerance == one) => Tolerance::One(one),
            _ => Tolerance::Each(each),
        });
        let weights: Vec<f64> = points.iter().map(|point| point.weight).collect();
        Self {
            quantity: target.quantity().name().into(),
            pressure_mpa: points.iter().map(|point| PRESSURE_MPA.from_si(point.pressure_pa)).collect(),
            value,
            tolerance,
            lowest: points.iter().map(|point| point.wanted.band()[0]).collect(),
            highest: points.iter().map(|point| point.wanted.band()[1]).collect(),
            goal: target.goal().map(|goal| goal.name().into()),
            weights: weights.windows(2).any(|pair| pair[0] != pair[1]).then_some(weights),
        }
    }
}

impl TargetReport {
    /// What is wanted at a pressure, in words.
    #[must_use]
    pub fn wanted(&self, row: usize) -> String {
        if let Some(value) = &self.value {
            return fixed(value.get(row).copied(), 4);
        }
        let edge = |edges: &[Option<f64>]| edges.get(row).copied().flatten();
        match (edge(&self.lowest), edge(&self.highest)) {
            (Some(lowest), Some(highest)) => format!("{lowest:.4} to {highest:.4}"),
            (Some(lowest), None) => format!(">= {lowest:.4}"),
            (None, Some(highest)) => format!("<= {highest:.4}"),
            (None, None) => self.goal.as_deref().unwrap_or("-").to_owned(),
        }
    }

    /// The tolerance, in words.
    #[must_use]
    pub fn tolerance_words(&self) -> String {
        match &self.tolerance {
            Some(Tolerance::One(one)) => format!("the tolerance {one}"),
            _ => "what is accepted".to_owned(),
        }
    }

    /// Whether anything is demanded at some pressure.
    #[must_use]
    pub fn has_demands(&self) -> bool {
        self.lowest.iter().chain(&self.highest).any(Option::is_some)
    }
}

/// What became of a goal.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GoalReport {
    /// `lowest`, `highest` or `even`.
    pub goal: Cow<'static, str>,
    /// What was made as low, as high or as even as possible, in words.
    pub of: String,
    /// By the search's model.
    pub predicted: Option<f64>,
    /// Standard deviation of a mean: the mean of those at the pressures, which are off together; null of an even one.
    pub predicted_std: Option<f64>,
    /// By the confirming run; null where it has no value at some pressure.
    pub confirmed: Option<f64>,
    /// Its standard deviation, likewise.
    pub confirmed_std: Option<f64>,
    /// Highest less lowest value over the pressures, at the condition where that is most, by the search's model.
    pub range_predicted: Option<f64>,
    /// The same by the confirming run.
    pub range_confirmed: Option<f64>,
}

impl GoalReport {
    /// The goal of `target`, where it has one, with what the search and the confirming run say, and their `errors`.
    #[must_use]
    pub fn new(target: &Target, predicted: &[f64], confirmed: Option<&[f64]>, errors: &ErrorsReport) -> Option<Self> {
        let goal = target.goal()?;
        let std_of = |of: &dyn Fn(&PressureErrors) -> Option<f64>| {
            let all: Option<Vec<f64>> = errors.by_pressure.iter().map(of).collect();
            all.and_then(|all| target.at_conditions(1).goal_value(&all)).filter(|_| goal != Goal::Even).map(tidy)
        };
        let is_ratio = target.quantity() == Quantity::Ratio;
        let quantity = match target.quantity() {
            Quantity::Ratio => "ratio",
            Quantity::DynamicFriction => "friction coefficient",
        };
        let weighted = target.points().windows(2).any(|pair| pair[0].weight != pair[1].weight);
        let by = if weighted { ", by weight" } else { "" };
        let at = if target.conditions() > 1 { ", at the worst condition" } else { "" };
        let range = |values: &[f64]| {
            let of = |own: &[f64]| {
                let (lowest, highest) = (own.iter().copied().reduce(f64::min)?, own.iter().copied().reduce(f64::max)?);
                Some(highest - lowest)
            };
            values.chunks(target.points().len()).filter_map(of).reduce(f64::max)
        };
        Some(Self {
            goal: goal.name().into(),
            of: match goal {
                Goal::Lowest | Goal::Highest => format!("mean {quantity} over the pressures{by}{at}"),
                Goal::Even => format!("standard deviation of the {quantity} over its mean{by}{at}"),
            },
            predicted: target.goal_value(predicted),
            predicted_std: std_of(&|at| at.predicted.as_ref()?.std),
            confirmed: confirmed.and_then(|values| target.goal_value(values)),
            confirmed_std: std_of(&|at| if is_ratio { at.ratio.as_ref()?.std } else { at.mu.std }),
            range_predicted: range(predicted),
            range_confirmed: confirmed.and_then(range),
        })
    }

    /// The goal in one line.
    #[must_use]
    pub fn words(&self) -> String {
        let (what, digits) = if self.goal == "even" { ("least", 5) } else { (self.goal.as_ref(), 4) };
        let value = |value: Option<f64>, std: Option<f64>| {
            value.map_or_else(|| fixed(None, digits), |value| with_error(value, std, digits))
        };
        format!(
            "{what} {}: {} predicted, {} confirmed (highest less lowest: {}, {})",
            self.of,
            value(self.predicted, self.predicted_std),
            value(self.confirmed, self.confirmed_std),
            fixed(self.range_predicted, 4),
            fixed(self.range_confirmed, 4),
        )
    }
}
