//! Design job: finds the pattern that brings dynamic friction to a target and confirms it by a dynamic run. The report
//! gives the chance that a cut sample is on target and the inputs that limit the chance.
//!
//! ```text
//! task -> table over the bounds -> search for the greatest chance <-> the model itself -> confirming run -> report
//! ```
//!
//! [`run`] performs the job. It takes a [`DesignTask`], a cache of model results that may outlive the job
//! ([`EvaluationCache`], [`NoCache`]), and a [`Monitor`] that shows progress, gives the time and may cancel.
//!
//! | module | role |
//! |---|---|
//! | `task`, `prepared_task`, `band` | requirements, and data derived from them |
//! | `steady_model`, `directional_cells`, `sensitivities`, `inputs` | the model, and its uncertain inputs |
//! | `table` | interpolation of the model over every texture within the bounds |
//! | `as_cut`, `prediction` | a texture as its samples are cut, and the prediction of a sample |
//! | `steps`, `search`, `between_designs` | the search for the maximum chance |
//! | `session`, `job`, `confirmation`, `advice` | `optimize`: the search, the confirming run, the advice |
//! | `next_trial`, `next_report` | `next`: several samples at once |
//! | `learning_disc` | `next --learn`: two sectors that teach most about the model error |
//! | `slopes`, `blocked`, `trade_offs`, `lattice_table`, `explorer` | further results from the table |
//! | `design_report`, `target_report`, `stored_result` | the records of result.json |
//! | `constraint_quantities`, `operating_conditions` | limits, and further speeds, humidities and sliding directions |
//! | `dynamic_excess`, `scene_errors` | correction of runs to calibrated friction; errors of a scene's results |
//! | `evaluation_cache`, `cache_key` | model results stored for later jobs, and their cache key |
//! | `time_budget`, `timings`, `cost_estimate` | time limit, time used, and estimated time |
//!
//! A pattern does not change friction that is proportional to load, except for one per cent by stick-slip on a small
//! sample: with this material law a ratio of 0.9 cannot be reached. If contact area saturates, so that the area factor
//! f falls with pressure, a pattern can reach 0.9:
//!
//! ```
//! use slipgrid_design::export::{Outline, Specimen};
//! use slipgrid_design::material::{AreaLaw, Elastic, Friction, LocalFriction, Material, Provenance};
//! use slipgrid_design::optimize::{DesignSpace, Quantity, Target, TargetPoint};
//! use slipgrid_design::{DesignTask, NoCache, Unwatched, pattern::Planform, run, springblock::Layer};
//!
//! let advised = |area_law: Option<AreaLaw>| -> Result<(String, f64), Box<dyn std::error::Error>> {
//!     let friction = Friction::Single(LocalFriction::new(0.30, 0.27, 0.05)?);
//!     let elastic = Elastic::new(0.38e9, 900.0)?;
//!     let material = Material { elastic, friction, area_law, provenance: Provenance::default() };
//!     let target = Target::new(Quantity::Ratio, vec![TargetPoint { pressure_pa: 2.6e6, value: 0.9 }], 0.02)?;
//!     let space = DesignSpace::new(Planform::Groove, [50e-6, 100e-6], [50e-6, 300e-6], [5e-6, 30e-6])?;
//!     let specimen = Specimen { outline: Outline::Rectangle { length_m: 3e-3, width_m: 3e-3 }, is_clipped: false };
//!     let layer = Layer { length_m: 3e-3, height_m: 60e-6, block_m: 10e-6, thickness_m: None, holder: None };
//!     let found = run(&DesignTask::new(material, target, space, specimen, layer), &mut NoCache, &Unwatched)?;
//!     Ok((found.report.advice.to_string(), found.report.sample.modelled[0].ratio))
//! };
//! let (_, ratio) = advised(None)?;
//! assert!((ratio - 1.0).abs() < 0.02);
//! let (advice, ratio) = advised(Some(AreaLaw::new(vec![0.7e6, 2.6e6, 26e6], vec![1.0, 0.8, 0.3])?))?;
//! assert!(advice == "trial" && (ratio - 0.9).abs() < 0.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! This crate opens no files, reads no clock, prints nothing, and does not touch the environment.

mod advice;
mod as_cut;
mod band;
mod between_designs;
mod blocked;
mod cache_key;
mod confirmation;
mod constraint_quantities;
mod cost_estimate;
mod design_report;
mod directional_cells;
mod dynamic_excess;
mod error;
mod evaluation_cache;
mod explorer;
mod inputs;
mod job;
mod lattice_table;
mod learning_disc;
mod next_report;
mod next_trial;
mod operating_conditions;
pub mod optimize;
mod prediction;
mod prepared_task;
pub mod results;
mod scene_errors;
mod search;
mod sensitivities;
mod session;
mod slopes;
mod steady_model;
mod steps;
mod stored_result;
mod table;
mod target_report;
mod task;
#[cfg(test)]
mod tests;
mod time_budget;
mod timings;
mod trade_offs;
mod whole_steps;

// Re-exports the types of a task, so that a program needs no other crate.
pub use slipgrid_base::monitor::{Monitor, Unwatched};
pub use slipgrid_laser::export;
pub use slipgrid_model::material;
pub use slipgrid_model::pattern;
pub use slipgrid_model::springblock;

pub use advice::Advice;
pub use cost_estimate::{cost_line, run_line};
pub use design_report::DesignReport;
pub use dynamic_excess::correct;
pub use error::{DesignError, Refusal, TaskPart};
pub use evaluation_cache::{Answer, Answered, Evaluation, EvaluationCache, Evaluations, Fault, LARGEST, NoCache};
pub use explorer::{BOUND_ROUNDING, Explored, Explorer, explore_bounds};
pub use job::{DesignOutcome, run};
pub use lattice_table::{Lattice, LatticeSample};
pub use learning_disc::{LearningReport, MechanismReport, SectorRatios};
pub use next_report::{NextReport, OneDiscReport, RatioPrediction, SectorReport};
pub use next_trial::{NextOptions, NextTrials, next_trials};
pub use optimize::ConstraintQuantity;
pub use prediction::{Expected, LimitedBy, ModelledRatio, SampleReport, percent};
pub use scene_errors::{Solved, of_scene};
pub use slipgrid_laser::specimen::{SpecimenError, simulate_on};
pub use slipgrid_model::springblock::Expense;
pub use stored_result::{StoredDesign, StoredError};
pub use task::{
    DEFAULT_SPEED_M_S, DesignTask, FurtherDirections, KnownMaterial, MAX_STRAIN, SearchOptions, TradeOffGoal,
    TradeOffsWanted, check_pressures, loads,
};
pub use trade_offs::{Compared, TradeOff};
pub use whole_steps::lattice;

/// Records of result.json that a [`DesignReport`] is composed of.
pub mod records {
    pub use crate::blocked::LiftedReport;
    pub use crate::design_report::{GoalReport, SCHEMA};
    pub use crate::slopes::SlopeReport;
    pub use crate::table::TableReport;
    pub use crate::target_report::{TargetReport, Tolerance};
    pub use crate::timings::Timings;
    pub use crate::trade_offs::{ListedDesign, TradeOffsReport};
}
