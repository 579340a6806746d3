//! What `optimize` found, as JSON and as text.

mod brief;
mod summary;

pub(crate) use summary::samples_table;

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use slipgrid_export::{Laser, Removal, Tolerances};
use slipgrid_optimize::{Goal, Quantity};
use slipgrid_springblock::{Dimension, Extent, Fidelity};
use slipgrid_units::tidy;

use crate::blocked::LiftedReport;
use crate::prediction::{Prediction, SampleReport};
use crate::search::Search;
use crate::slopes::SlopeReport;
use crate::table::TableReport;
use crate::target_report::TargetReport;
use crate::timings::Timings;
use crate::trade_offs::TradeOffsReport;
use slipgrid_results::{LoadReport, MaterialReport, SpecimenReport};

/// The schema of the results of `optimize` and `next`: the second names one chance, and what is expected of a sample.
pub const SCHEMA: u32 = 2;

/// result.json of `optimize`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DesignReport {
    /// `slipgrid`.
    pub program: Cow<'static, str>,
    /// Its version.
    pub version: Cow<'static, str>,
    /// Schema of the file.
    pub schema: u32,
    /// Name of the design.
    pub name: String,
    /// Day that the task names; left out where it names none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
    /// What to do: `series`, `trial`, `trial_meets_it`, `cannot_be_met` or `do_not_texture`.
    pub advice: Cow<'static, str>,
    /// The same in one sentence.
    pub words: String,
    /// Trials that it rests on.
    pub trials: usize,
    /// The texture, its chance, what is expected of a sample of it, and what limits the chance.
    #[serde(flatten)]
    pub sample: SampleReport,
    /// What becomes of the goal; null without one.
    pub goal: Option<GoalReport>,
    /// Other textures that are worth cutting, unlike it and each other.
    pub others: Vec<SampleReport>,
    /// What keeps a target that cannot be met out of reach; empty otherwise.
    pub blocked_by: Vec<LiftedReport>,
    /// How what is expected moves with the dimensions.
    pub slopes: Vec<SlopeReport>,
    /// The designs that no other beats in every goal; null where the design file names no goals.
    pub trade_offs: Option<TradeOffsReport>,
    /// Designs that were compared.
    pub compared: usize,
    /// The table of the bounds that they were compared by.
    pub table: TableReport,
    /// Share of the specimen's face that is cavity, as they are laid out.
    pub specimen_areal_density: f64,
    /// Bursts per cavity; null where the design file gives no depth per burst.
    pub bursts: Option<u32>,
    /// Passes over the lines of a hatch; null where the laser's settings do not give them.
    pub passes: Option<u32>,
    /// What these remove from the cavities as they are laid out; null as above.
    #[serde(default)]
    pub removal: Option<Removal>,
    /// What the laser does other than the design says, and what to do, where no passes are planned.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub laser_warnings: Vec<String>,
    /// Size of blocks.
    #[serde(default)]
    pub block_um: f64,
    /// Dimensions of the model.
    pub dimensions: u8,
    /// The vertical plane took a section of a planform that needs three dimensions.
    pub section_model: bool,
    /// What confirmed the design.
    pub fidelity: Cow<'static, str>,
    /// Extent of the confirmation: a cell, a strip or the whole sample.
    pub extent: Cow<'static, str>,
    /// What was asked for.
    pub target: TargetReport,
    /// The confirming run of the model alone, at the target's pressures.
    pub confirmed: Vec<LoadReport>,
    /// Limits that the design breaks.
    pub violations: Vec<String>,
    /// Stages for which the allowed seconds were not enough.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cut_short: Vec<Cow<'static, str>>,
    /// What was modelled and why.
    pub model: Vec<String>,
    /// How it was computed.
    #[serde(default)]
    pub method: Vec<String>,
    /// From where to where friction was measured, where a pressure lies outside.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub measured_mpa: Option<[f64; 2]>,
    /// The material and where it came from.
    pub material: MaterialReport,
    /// The specimen.
    pub specimen: SpecimenReport,
    /// The laser.
    pub laser: Laser,
    /// How exactly samples are assumed to be cut; absent where the design file does not say.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerances: Option<Tolerances>,
    /// Seconds by stage; with those in all and threads in timings.json.
    #[serde(default)]
    pub timings_s: Timings,
    /// Seconds in all.
    #[serde(default)]
    pub wall_s: f64,
    /// Threads that computed.
    #[serde(default)]
    pub threads: usize,
    /// Seed of local coefficients.
    pub seed: u64,
}

/// What becomes of a goal.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GoalReport {
    /// `lowest`, `highest` or `even`.
    pub goal: Cow<'static, str>,
    /// What is as low, as high or as even as possible, in words.
    pub of: String,
    /// Its value where every load has the median of samples.
    pub expected: f64,
    /// The same at the ends of 95 % of samples; null for an even one, whose ends these are not.
    pub interval_95: Option<[f64; 2]>,
    /// The same by the model alone.
    pub modelled: f64,
}

impl GoalReport {
    /// The goal of the task of `search`, where it has one, as `best` does it.
    #[must_use]
    pub fn of(search: &Search<'_>, best: &Prediction) -> Option<Self> {
        let asked = search.asked;
        let goal = asked.goal?;
        let quantity = match search.task.target.quantity() {
            Quantity::Ratio => "ratio",
            Quantity::DynamicFriction => "friction coefficient",
        };
        let of = |ratios: &[f64]| asked.goal_value(ratios).map(tidy);
        let at = |p: f64| of(&best.ratios(asked.loads.len(), p));
        let worst = if asked.count < asked.loads.len() { ", at the worst condition" } else { "" };
        Some(Self {
            goal: goal.name().into(),
            of: match goal {
                Goal::Lowest | Goal::Highest => format!("mean {quantity} over the pressures{worst}"),
                Goal::Even => format!("standard deviation of the {quantity} over its mean{worst}"),
            },
            expected: at(0.5)?,
            interval_95: if goal == Goal::Even { None } else { Some([at(0.025)?, at(0.975)?]) },
            modelled: of(&best.texture.ratio)?,
        })
    }
}

impl DesignReport {
    /// What the laser does to the cavities other than the design says: of passes over lines, or of bursts on spots.
    pub fn of_laser(&self) -> impl Iterator<Item = &String> {
        self.removal.iter().flat_map(|removal| &removal.warnings).chain(&self.laser_warnings)
    }

    /// Whether the target is a ratio to the flat surface.
    #[must_use]
    pub fn is_ratio(&self) -> bool {
        self.target.quantity == Quantity::Ratio.name()
    }

    /// How often the laser goes over a cavity; empty where nothing says so.
    fn exposure_words(&self) -> String {
        match (self.bursts, self.passes) {
            (Some(bursts), _) => format!(" (bursts: {bursts})"),
            (None, Some(passes)) => format!(" (passes: {passes})"),
            (None, None) => String::new(),
        }
    }

    /// Whether the whole interface was solved, not one line along the sliding direction.
    #[must_use]
    pub const fn sees_face(&self) -> bool {
        Dimension::numbered(self.dimensions).sees_face()
    }

    /// What confirmed the design, in words.
    #[must_use]
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
