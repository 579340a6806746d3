//! Record of a target in result.json.

use std::borrow::Cow;

use crate::optimize::{Demand, Target, Wanted};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::units::PRESSURE_MPA;

/// Record of a target in result.json.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TargetReport {
    /// `ratio` or `mu_dynamic`.
    pub quantity: Cow<'static, str>,
    /// Nominal pressures.
    pub pressure_mpa: Vec<f64>,
    /// Wanted values; null where a band or a goal is given instead.
    pub value: Option<Vec<f64>>,
    /// Largest accepted distance from `value`, one number where all pressures share it; null where a band or a goal is
    /// given instead.
    pub tolerance: Option<Tolerance>,
    /// Lowest accepted values; null where there is no lower limit.
    pub lowest: Vec<Option<f64>>,
    /// Highest accepted values; null where there is no upper limit.
    pub highest: Vec<Option<f64>>,
    /// `lowest`, `highest` or `even`; null without a goal.
    pub goal: Option<Cow<'static, str>>,
    /// Weight of each pressure in means; null where all weights are equal.
    pub weights: Option<Vec<f64>>,
}

/// Tolerance for all pressures, or for each pressure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Tolerance {
    /// One tolerance for all pressures.
    One(f64),
    /// One tolerance per pressure.
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
    /// Whether some pressure has a demand.
    pub fn has_demands(&self) -> bool {
        self.lowest.iter().chain(&self.highest).any(Option::is_some)
    }
}
