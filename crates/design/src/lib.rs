//! The main job: the pattern that brings dynamic friction to a target, confirmed in time, with the chance that a cut sample is
//! on target and what limits it.
//!
//! ```text
//! task -> [search by the steady model <-> specimen, steady and in time] -> chance, slopes, robustness, trade-offs -> outcome
//! ```
//!
//! [`run`] is the job. It needs a [`DesignTask`], a place for the answers of its model that may outlive the run
//! ([`EvaluationCache`], [`NoCache`]), and a [`Monitor`] that shows progress, tells the time
//! and may cancel.
//!
//! | module | role |
//! |---|---|
//! | `task`, `prepared_task`, `job`, `design_report` | what is asked, what follows from it, how it is answered, what is found |
//! | `assessment` | how far the design found can be trusted, and what moves it |
//! | `steady_model`, `directional_cells` | the model that the search asks: the steady cell, corrected by what specimens add to it |
//! | `multi_fidelity`, `best_round` | searches and confirming runs in turn, and which of them is reported |
//! | `confirmation`, `confirmed_peak`, `flat_sample`, `dynamic_excess` | specimens, steady and in time: of the design, its largest pressure, of the flat sample, and how both agree with calibration |
//! | `operating_conditions`, `decisive_conditions`, `conditions_report` | further speeds, humidities and sliding directions |
//! | `constraint_quantities` | what limits hold |
//! | `learned_discrepancy` | what trials say that the model lacks, which designs may aim with |
//! | `selection`, `chance`, `chance_report` | the choice among designs on target by their chance |
//! | `uncertainty_budget`, `scene_errors`, `discrepancy_correction` | the error beside every number |
//! | `robustness`, `robust_search`, `sensitivity`, `rim_sensitivity` | what tolerances make of the design, and its slopes |
//! | `infeasibility`, `flat_is_best`, `reachable_range` | why a target is out of reach, and what is within |
//! | `lattice_table`, `trade_offs`, `explorer` | every design of a lattice; trade-offs between goals; a surface of all of them to ask |
//! | `evaluation_cache`, `cache_key` | answers kept beyond a run, and what they depend on |
//! | `time_budget`, `timings`, `cost_estimate` | the seconds allowed, taken, and expected |
//!
//! Friction that is proportional to load is changed by no pattern, but for a per cent of stick-slip on a sample this small: where
//! that is the material's law a ratio of 0.9 is out of reach. Where contact area saturates, so that f(P) falls with pressure, there
//! is a pattern that has it:
//!
//! ```
//! use slipgrid_design::export::{Outline, Specimen};
//! use slipgrid_design::material::{AreaLaw, Elastic, Friction, LocalFriction, Material, Provenance};
//! use slipgrid_design::optimize::{DesignSpace, Quantity, Target, TargetPoint};
//! use slipgrid_design::{DesignTask, NoCache, Unwatched, pattern::Planform, run, springblock::Layer};
//!
//! let ratio_of = |area_law: Option<AreaLaw>| -> Result<(String, f64), Box<dyn std::error::Error>> {
//!     let friction = Friction::Single(LocalFriction::new(0.30, 0.27, 0.05)?);
//!     let elastic = Elastic::new(0.38e9, 900.0)?;
//!     let material = Material { elastic, friction, area_law, provenance: Provenance::default() };
//!     let target = Target::new(Quantity::Ratio, vec![TargetPoint { pressure_pa: 2.6e6, value: 0.9 }], 0.02)?;
//!     let space = DesignSpace::new(Planform::Groove, [50e-6, 100e-6], [50e-6, 300e-6], [5e-6, 30e-6])?;
//!     let specimen = Specimen { outline: Outline::Rectangle { length_m: 3e-3, width_m: 3e-3 }, is_clipped: false };
//!     let layer = Layer { length_m: 3e-3, height_m: 60e-6, block_m: 10e-6, thickness_m: None };
//!     let found = run(&DesignTask::new(material, target, space, specimen, layer), &mut NoCache, &Unwatched)?;
//!     let confirmed = found.report.confirmed[0].ratio.ok_or("no ratio")?;
//!     Ok((found.report.status.to_string(), confirmed))
//! };
//! let (status, ratio) = ratio_of(None)?;
//! assert!(status == "unreachable" && (ratio - 1.0).abs() < 0.02);
//! let (status, ratio) = ratio_of(Some(AreaLaw::new(vec![0.7e6, 2.6e6, 26e6], vec![1.0, 0.8, 0.3])?))?;
//! assert!(status == "met" && (ratio - 0.9).abs() < 0.02);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! This crate opens no files, reads no clock, prints nothing, and does not touch the environment.

mod assessment;
mod best_round;
mod between_designs;
mod cache_key;
mod chance;
mod chance_report;
mod conditions_report;
mod confirmation;
mod confirmed_peak;
mod constraint_quantities;
mod cost_estimate;
mod decisive_conditions;
mod design_report;
mod directional_cells;
mod discrepancy_correction;
mod dynamic_excess;
mod error;
mod evaluation_cache;
mod explorer;
mod flat_is_best;
mod flat_sample;
mod infeasibility;
mod job;
mod kept_nodes;
mod lattice_table;
mod learned_discrepancy;
mod multi_fidelity;
mod next_trial;
mod operating_conditions;
mod prepared_task;
mod reachable_range;
mod rim_sensitivity;
mod robust_search;
mod robustness;
mod robustness_report;
mod scene_errors;
mod selection;
mod sensitivity;
mod steady_model;
mod stored_result;
mod target_report;
mod task;
mod time_budget;
mod timings;
mod trade_offs;
mod uncertainty_budget;

// What a task is made of, so that a program needs no other crate.
pub use slipgrid_export as export;
pub use slipgrid_material as material;
pub use slipgrid_monitor::{Monitor, Unwatched};
pub use slipgrid_optimize as optimize;
pub use slipgrid_pattern as pattern;
pub use slipgrid_springblock as springblock;

pub use constraint_quantities::ConstraintQuantity;
pub use cost_estimate::{cost_line, run_line};
pub use design_report::{DesignReport, MisfitReport, Verdict};
pub use dynamic_excess::correct;
pub use error::{DesignError, Refusal, TaskPart};
pub use evaluation_cache::{Answer, Answered, Evaluation, EvaluationCache, Evaluations, Fault, LARGEST, NoCache};
pub use explorer::{Explored, Explorer, RimChanges, SurfaceError, explore_bounds};
pub use job::{Compared, DesignOutcome, Lattice, run};
pub use lattice_table::lattice;
pub use next_trial::{
    AdviceReport, NextOptions, NextReport, NextTrials, OneDiscReport, PredictedRatio, RatioPrediction, SectorReport,
    TrialCandidateReport, next_trials,
};
pub use scene_errors::{Solved, of_scene};
pub use slipgrid_specimen::{SpecimenError, simulate_on};
pub use slipgrid_springblock::Expense;
pub use stored_result::{StoredDesign, StoredError};
pub use task::{
    DEFAULT_MAX_EVALUATIONS, DEFAULT_SPEED_M_S, DesignTask, FurtherDirections, KnownMaterial, MOST_STRAIN,
    SampleScatter, TradeOffGoal, TradeOffsWanted, check_pressures, loads,
};

/// What a [`DesignReport`] is made of: the records of result.json.
pub mod records {
    pub use crate::chance_report::{ChanceReport, PartReport};
    pub use crate::conditions_report::{ConditionReport, ConditionValue, ConditionsReport, ConflictReport};
    pub use crate::discrepancy_correction::{DiscrepancyReport, FactorReport, Reading};
    pub use crate::flat_is_best::FlatReport;
    pub use crate::infeasibility::{ExplanationReport, NearestReport, ReliefReport};
    pub use crate::lattice_table::{NodeReport, TableReport};
    pub use crate::reachable_range::ReachableReport;
    pub use crate::rim_sensitivity::{RimSensitivityReport, RimSlopeReport};
    pub use crate::robustness_report::{
        BESIDE, Distribution, InputReport, OptimumReport, PressureParts, PressureReport, RobustnessReport,
        ScatterReport, SpreadReport,
    };
    pub use crate::selection::SelectionReport;
    pub use crate::sensitivity::{Dimensions, SensitivityReport, SlopesReport};
    pub use crate::target_report::{GoalReport, TargetReport, Tolerance};
    pub use crate::timings::{ImprovementReport, Timings};
    pub use crate::trade_offs::{BEFORE, ListedDesign, TradeOffsReport};
}
