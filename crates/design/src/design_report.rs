//! Result of `optimize`, as JSON and as text.

mod brief;
mod summary;

pub(crate) use summary::samples_table;

use std::borrow::Cow;

use crate::optimize::{Goal, Quantity};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::units::{counted, tidy};
use slipgrid_laser::export::{Laser, MadeBy, Removal, SpecimenRecord, Tolerances};
use slipgrid_model::material::Provenance;
use slipgrid_model::springblock::{Dimension, Extent, Fidelity};

use crate::blocked::LiftedReport;
use crate::prediction::{Prediction, SampleReport};
use crate::results::LoadReport;
use crate::search::Search;
use crate::slopes::SlopeReport;
use crate::table::TableReport;
use crate::target_report::TargetReport;
use crate::timings::Timings;
use crate::trade_offs::TradeOffsReport;

/// Schema version of the results of `optimize` and `next`: version 2 has one chance and the expected values of a sample.
pub const SCHEMA: u32 = 2;

/// result.json of `optimize`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DesignReport {
    /// Program that made the result.
    #[serde(flatten)]
    pub made_by: MadeBy,
    /// Name of the design.
    pub name: String,
    /// Date of the task; left out where the task names none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
    /// Recommended action: `series` (cut a series), `trial` (cut a trial), `trial_meets_it` (a measured trial
    /// is on target), `cannot_be_met`, `measure_again` (two trials of one texture contradict each other) or
    /// `do_not_texture`.
    pub advice: Cow<'static, str>,
    /// Recommended action in one sentence.
    pub words: String,
    /// Number of trials that the result uses.
    pub trials: usize,
    /// Texture with its chance, the expected values of a sample, and the inputs that limit the chance.
    #[serde(flatten)]
    pub sample: SampleReport,
    /// Expected value of the goal; null without a goal.
    pub goal: Option<GoalReport>,
    /// Other textures worth cutting, different from this texture and from each other.
    pub others: Vec<SampleReport>,
    /// Limits and bounds that keep a target out of reach; empty if the target can be met.
    pub blocked_by: Vec<LiftedReport>,
    /// Bounds that the texture rests on, in words, where the target can be met.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub at_bounds: Vec<String>,
    /// Derivatives of the expected values with respect to the dimensions.
    pub slopes: Vec<SlopeReport>,
    /// Designs that no other design beats in every goal; null where the design file names no goals.
    pub trade_offs: Option<TradeOffsReport>,
    /// Number of designs that were compared.
    pub compared: usize,
    /// Size and error of the table by which designs were compared.
    pub table: TableReport,
    /// Share of the specimen's face that is cavity, in the layout.
    pub specimen_areal_density: f64,
    /// Bursts per cavity; null where the design file gives no depth per burst.
    pub bursts: Option<u32>,
    /// Passes over the lines of a hatch; null where the laser settings do not give them.
    pub passes: Option<u32>,
    /// Removal by the passes from the cavities of the layout; null where the laser settings do not give passes.
    #[serde(default)]
    pub removal: Option<Removal>,
    /// Deviations of the laser from the design and remedies, where no passes are planned.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub laser_warnings: Vec<String>,
    /// Size of the model's blocks.
    #[serde(default)]
    pub block_um: f64,
    /// Dimensions of the model, 2 or 3.
    pub dimensions: u8,
    /// True if the vertical plane is a section of a planform that needs three dimensions.
    pub section_model: bool,
    /// Fidelity of the confirming run.
    pub fidelity: Cow<'static, str>,
    /// Extent of the confirming run: a cell, a strip or the whole sample.
    pub extent: Cow<'static, str>,
    /// Friction target of the task.
    pub target: TargetReport,
    /// Confirming run of the model alone, at the pressures of the target.
    pub confirmed: Vec<LoadReport>,
    /// Stages for which the time limit was too short.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cut_short: Vec<Cow<'static, str>>,
    /// Modelling decisions with reasons.
    pub model: Vec<String>,
    /// Numerical method.
    #[serde(default)]
    pub method: Vec<String>,
    /// Lowest and highest pressure at which friction was measured; left out unless a target pressure lies outside.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub measured_mpa: Option<[f64; 2]>,
    /// Material and its provenance.
    pub material: Provenance,
    /// Specimen on which the design is laid out.
    pub specimen: SpecimenRecord,
    /// Laser settings.
    pub laser: Laser,
    /// Assumed manufacturing tolerances of samples; absent where the design file does not give them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerances: Option<Tolerances>,
    /// Seconds by stage; timings.json has these with the total and the number of threads.
    #[serde(default)]
    pub timings_s: Timings,
    /// Total seconds.
    #[serde(default)]
    pub wall_s: f64,
    /// Number of threads used.
    #[serde(default)]
    pub threads: usize,
    /// Seed of the random local coefficients.
    pub seed: u64,
}

/// Value of the target's goal: expected over samples, and by the model alone.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GoalReport {
    /// `lowest`, `highest` or `even`.
    pub goal: Cow<'static, str>,
    /// Quantity that the goal optimizes, in words.
    pub of: String,
    /// Value of the goal with the median of samples at every load.
    pub expected: f64,
    /// Values of the goal at the ends of the 95 % interval of samples; null for an even goal, to which these ends do not
    /// apply.
    pub interval_95: Option<[f64; 2]>,
    /// Value of the goal by the model alone.
    pub modelled: f64,
}

impl GoalReport {
    /// Evaluates the goal for the prediction `best`; `None` if the task of `search` has no goal.
    pub fn of(search: &Search<'_>, best: &Prediction) -> Option<Self> {
        let asked = search.asked;
        let goal = asked.goal?;
        let quantity = match search.task.target.quantity() {
            Quantity::Ratio => "ratio",
            Quantity::DynamicFriction => "friction coefficient",
        };
        let of = |ratios: &[f64]| asked.goal_value(ratios).map(tidy);
        let at = |p: f64| of(&best.ratios(asked.loads.len(), p));
        let mut weights = search.task.target.points().iter().map(|demand| demand.weight);
        let first = weights.next();
        let weighted = if weights.all(|weight| Some(weight) == first) { "" } else { "weighted " };
        let worst = if asked.count < asked.loads.len() { ", at the worst condition" } else { "" };
        Some(Self {
            goal: goal.name().into(),
            of: match goal {
                Goal::Lowest | Goal::Highest => format!("{weighted}mean {quantity} over the pressures{worst}"),
                Goal::Even => format!("standard deviation of the {quantity} over its mean{worst}"),
            },
            expected: at(0.5)?,
            interval_95: if goal == Goal::Even { None } else { Some([at(0.025)?, at(0.975)?]) },
            modelled: of(&best.texture.ratio)?,
        })
    }
}

impl DesignReport {
    /// Whether the target is a ratio to the flat surface.
    pub fn is_ratio(&self) -> bool {
        self.target.quantity == Quantity::Ratio.name()
    }

    /// Number of exposures of a cavity by the laser, in words; empty if unknown.
    fn exposure_words(&self) -> String {
        match (self.bursts, self.passes) {
            (Some(bursts), _) => format!(" ({})", counted(bursts as usize, "burst")),
            (None, Some(1)) => " (1 pass)".to_owned(),
            (None, Some(passes)) => format!(" ({passes} passes)"),
            (None, None) => String::new(),
        }
    }

    /// Whether the model solved the whole interface, and not a single line along the sliding direction.
    pub const fn sees_face(&self) -> bool {
        Dimension::numbered(self.dimensions).sees_face()
    }

    /// Describes the confirming run in words.
    pub fn confirmation(&self) -> String {
        let named = Extent::ALL.into_iter().find(|extent| extent.name() == self.extent);
        let extent = match named {
            Some(Extent::Sample) => "whole sample",
            Some(Extent::Strip) => "strip of the specimen",
            Some(Extent::Cell) | None => "cell",
        };
        let time = if self.fidelity == Fidelity::Steady.name() { ", steady" } else { " in time" };
        let space = if self.sees_face() { " in space" } else { "" };
        format!("{extent}{space}{time}")
    }
}
