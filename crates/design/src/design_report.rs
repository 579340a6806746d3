//! What `optimize` found, as JSON and as text.

mod summary;

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use slipgrid_export::{Laser, Removal, Tolerances};
use slipgrid_optimize::{Goal, Quantity};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::{Dimension, Extent, Fidelity};

use crate::chance_report::ChanceReport;
use crate::conditions_report::ConditionsReport;
use crate::discrepancy_correction::DiscrepancyReport;
use crate::flat_is_best::FlatReport;
use crate::infeasibility::ExplanationReport;
use crate::lattice_table::TableReport;
use crate::multi_fidelity::{MOST_ROUNDS, MOST_RUNS};
use crate::next_trial::AdviceReport;
use crate::reachable_range::ReachableReport;
use crate::robustness_report::RobustnessReport;
use crate::selection::SelectionReport;
use crate::sensitivity::SensitivityReport;
use crate::target_report::{GoalReport, TargetReport};
use crate::timings::{ImprovementReport, Timings};
use crate::trade_offs::TradeOffsReport;
use slipgrid_results::{ErrorReport, ErrorsReport, LoadReport, MaterialReport, PatternReport, SpecimenReport};

/// result.json of `optimize`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DesignReport {
    /// `slipgrid`.
    pub program: Cow<'static, str>,
    /// Its version.
    pub version: Cow<'static, str>,
    /// Schema of the file.
    #[serde(default = "slipgrid_results::first_schema")]
    pub schema: u32,
    /// Name of the design.
    pub name: String,
    /// Day that the task names; left out where it names none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
    /// `met`, `unreachable`, `budget`, or `flat_is_best`: no pattern is needed.
    pub status: Cow<'static, str>,
    /// The chance that a cut sample is on target; null where nothing is demanded.
    pub chance: Option<ChanceReport>,
    /// Whether to cut it as a series or as a trial, by what trials say that the model lacks; null where nothing is demanded, where the
    /// flat surface is better than any pattern, and where the design does not slide evenly.
    pub advice: Option<AdviceReport>,
    /// Why the flat surface is better than any pattern; null where one is.
    pub flat: Option<FlatReport>,
    /// How the design was chosen among those on target; null where none meets the target, and with a goal.
    pub selection: Option<SelectionReport>,
    /// The best design.
    pub design: PatternReport,
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
    /// Extent of the confirmation: a cell or the whole sample.
    pub extent: Cow<'static, str>,
    /// What was asked for.
    pub target: TargetReport,
    /// The steady cell at the target's pressures, in the layer's blocks and not corrected by confirming runs.
    pub predicted: Vec<LoadReport>,
    /// The target's quantity as the search took it, by pressure: the steady cell's ratio, times the flat
    /// sample's dynamic friction where that is wanted, times the discrepancy where designs aim with it, with what the
    /// specimens of earlier designs, in steady sliding or in time, corrected; at the condition designed for.
    pub predicted_value: Vec<f64>,
    /// The confirming run at the target's pressures.
    pub confirmed: Vec<LoadReport>,
    /// Values as they are compared with the target, each with one error and its parts.
    pub errors: ErrorsReport,
    /// The error of the model by the calibration's patterned samples, and what follows from it; null where none are
    /// known.
    pub discrepancy: Option<DiscrepancyReport>,
    /// What the design does at every condition; null where there is one.
    pub conditions: Option<ConditionsReport>,
    /// The result for the goal; null without a goal.
    pub goal: Option<GoalReport>,
    /// Largest distance from the target in tolerances.
    pub misfit: MisfitReport,
    /// Constraints that the best design breaks.
    pub violations: Vec<String>,
    /// How the target's quantity moves with the dimensions; null where designs beside it have no response.
    pub sensitivities: Option<SensitivityReport>,
    /// What samples made after the design do; null where the design file has no tolerances.
    pub robustness: Option<RobustnessReport>,
    /// The designs that no other beats in every goal; null where the design file names no goals.
    pub trade_offs: Option<TradeOffsReport>,
    /// Lowest and highest value among the designs tried that respect every constraint, at the condition designed for.
    pub reachable: Vec<ReachableReport>,
    /// How many designs that is known of, where it is of those alone that were solved in space in the search that found the design.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reachable_among: Option<usize>,
    /// Which limits and bounds keep designs from a target out of reach; null otherwise.
    pub explanation: Option<ExplanationReport>,
    /// Every design of a lattice beside the one found; null unless asked for.
    pub table: Option<TableReport>,
    /// Other designs that the search's model found to meet the target.
    pub alternatives: Vec<PatternReport>,
    /// Designs that the search's model, or its guide, evaluated.
    pub evaluations: usize,
    /// Designs solved in space at the layer's own block size.
    pub solid_evaluations: usize,
    /// Seconds, not evaluations, were spent.
    pub out_of_time: bool,
    /// Stages for which the allowed seconds were not enough.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cut_short: Vec<Cow<'static, str>>,
    /// Designs that the model could not compute.
    pub failed_trials: usize,
    /// Searches made: each after the first corrected by what was solved of the designs before it, without time or in time.
    pub rounds: usize,
    /// Designs that were run in time.
    #[serde(default)]
    pub runs: usize,
    /// Improvements during the searches.
    pub history: Vec<ImprovementReport>,
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
    /// Seed of search and local coefficients.
    pub seed: u64,
}

/// Largest distances from the target over pressures and conditions, in tolerances: up to 1 where it is met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MisfitReport {
    /// Of the search's model.
    pub predicted: f64,
    /// Of the confirming runs; null where one has no value at some pressure.
    pub confirmed: Option<f64>,
}

/// How a design stands towards what was asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// Its confirming runs do what was asked for.
    pub is_met: bool,
    /// What is shown is the nearest design alone.
    pub shows_nearest: bool,
    /// In words.
    pub words: String,
}

impl DesignReport {
    /// What the laser does to the cavities other than the design says: of passes over lines, or of bursts on spots.
    pub fn of_laser(&self) -> impl Iterator<Item = &String> {
        self.removal.iter().flat_map(|removal| &removal.warnings).chain(&self.laser_warnings)
    }

    /// The target's quantity by the confirming run at a pressure, as it is compared with the target.
    #[must_use]
    pub fn confirmed_at(&self, row: usize) -> Option<&ErrorReport> {
        let at = self.errors.at(row)?;
        if self.is_ratio() { at.ratio.as_ref() } else { Some(&at.mu) }
    }

    /// Whether the target is a ratio to the flat surface.
    #[must_use]
    pub fn is_ratio(&self) -> bool {
        self.target.quantity == Quantity::Ratio.name()
    }

    /// The chance, before the verdict.
    fn chance_words(&self) -> String {
        self.chance.as_ref().map_or_else(String::new, |chance| format!("{}; ", chance.announced(self.advice.as_ref())))
    }

    /// What ran out, in words.
    fn spent(&self) -> &'static str {
        if self.out_of_time { "the seconds allowed were spent" } else { "the evaluations allowed were spent" }
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

    fn in_space(&self) -> &'static str {
        if self.sees_face() { " in space" } else { "" }
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
        format!("{extent}{}{time}", self.in_space())
    }

    /// How the design stands towards what was asked for, with what that holds for where a section stands for the planform.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        let scope = if self.section_model { " by the vertical section, as grooves" } else { "" };
        let target = if self.goal.is_some() { "" } else { "target " };
        let verdict = |is_met, shows_nearest, words| Verdict { is_met, shows_nearest, words };
        if let Some(flat) = &self.flat {
            let name = if flat.suffices { "not a matter of patterns" } else { "not reachable" };
            let is_raised = self.goal.as_ref().is_none_or(|goal| goal.goal == Goal::Highest.name());
            let best = if is_raised { "pattern that lowers it least" } else { "best pattern found" };
            let then = format!("What follows is the {best}; cut none");
            return verdict(false, false, format!("{target}{name}{scope}: {}. {then}", flat.words));
        }
        let is_confirmed = self.misfit.confirmed.is_some_and(|misfit| misfit <= 1.0) && self.violations.is_empty();
        match self.status.as_ref() {
            "met" if self.goal.is_some() => verdict(true, false, format!("best found within bounds and limits{scope}")),
            "met" => verdict(true, false, format!("{target}met by the model{scope}")),
            "unreachable" => verdict(false, true, format!("{target}not reachable within bounds and limits{scope}")),
            _ if self.goal.is_some() && self.misfit.predicted <= 1.0 && (self.out_of_time || is_confirmed) => {
                let words = format!("best so far{scope}: {} before the search had ended", self.spent());
                verdict(is_confirmed, false, words)
            }
            _ => verdict(false, true, format!("{target}{}{scope}", self.unmet())),
        }
    }

    /// Why a target that the search does not call out of reach was not met, in words that follow "target".
    fn unmet(&self) -> String {
        let searches = if self.rounds == 1 { "one search".to_owned() } else { format!("{} searches", self.rounds) };
        let is_found = self.misfit.predicted <= 1.0 && self.violations.is_empty();
        if self.out_of_time {
            format!("not met before {}", self.spent())
        } else if is_found {
            format!("met by the steady model, not confirmed in time after {searches}")
        } else if self.rounds >= MOST_ROUNDS || self.runs >= MOST_RUNS {
            format!("not met after {searches}")
        } else {
            format!("not met before {}", self.spent())
        }
    }
}

/// The patterns of `candidates`.
#[must_use]
pub fn patterns<'a>(candidates: impl IntoIterator<Item = &'a Pattern>) -> Vec<PatternReport> {
    candidates.into_iter().map(PatternReport::from).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_laser_does_other_than_the_design_says_stands_with_the_doubts() {
        let removal = Removal { warnings: vec!["2 passes make 7 um".to_owned()], ..Removal::default() };
        let laser_warnings = vec!["lines lie 11.6 um apart".to_owned()];
        let report = DesignReport { removal: Some(removal), laser_warnings, ..DesignReport::default() };
        let text = report.summary();
        let changed =
            LoadReport { pressure_mpa: 4.24, ratio_discretization_error: Some(-0.27), ..LoadReport::default() };
        let coarse = DesignReport { confirmed: vec![changed], block_um: 10.0, ..DesignReport::default() }.summary();
        assert!(
            coarse.contains("! at 4.24 MPa the ratio would change by up to 0.27 with vanishing blocks"),
            "{coarse}"
        );
        assert!(
            coarse.contains("blocks of 10 um do not resolve the pattern; a smaller block_um in [sample], such as 5")
        );
        assert!(!text.contains("do not resolve"), "{text}");
        assert!(text.contains("! laser: 2 passes make 7 um\n! laser: lines lie 11.6 um apart\n"), "{text}");
    }

    #[test]
    fn what_ended_a_search_without_its_target_is_said_as_it_was() {
        let missed = |predicted: f64, rounds: usize, out_of_time: bool| {
            let misfit = MisfitReport { predicted, confirmed: Some(1.3) };
            DesignReport { status: "budget".into(), misfit, rounds, out_of_time, ..DesignReport::default() }
        };
        for (report, says) in [
            (missed(0.8, 4, false), "target met by the steady model, not confirmed in time after 4 searches"),
            (missed(0.8, 1, false), "target met by the steady model, not confirmed in time after one search"),
            (missed(1.1, MOST_ROUNDS, false), "target not met after 8 searches"),
            (missed(1.1, 2, false), "target not met before the evaluations allowed were spent"),
            (missed(1.1, 2, true), "target not met before the seconds allowed were spent"),
        ] {
            let verdict = report.verdict();
            assert_eq!((verdict.is_met, verdict.shows_nearest, verdict.words.as_str()), (false, true, says));
        }
        // A confirmed design whose search for a goal was cut short is the best so far.
        let goal = missed(0.8, 1, false);
        let misfit = MisfitReport { predicted: 0.8, confirmed: Some(0.9) };
        let verdict = DesignReport { misfit, goal: Some(GoalReport::default()), ..goal }.verdict();
        assert!(verdict.is_met && !verdict.shows_nearest);
        assert_eq!(verdict.words, "best so far: the evaluations allowed were spent before the search had ended");
    }
}
