//! Campaigns: many scenes or designs as tasks that any machine can do, in any order, and one table of what came of them.
//!
//! A campaign file names a scene or a design and which of its keys vary. [`plan`] makes a task of every combination. The id of a
//! task is a hash of what it says and of the files that it reads, so that the same task is done once. Those files travel with the
//! campaign: a task needs nothing else of the machine that planned it. [`Worker`] does tasks, and [`Results`] puts together what
//! came of them: the same bytes whoever did what.
//!
//! ```text
//! name = "widths"
//! base = "scene.toml"                  # a scene or a design
//! [[grid]]                             # every combination of all grids
//! key = "pattern.width_um"
//! values = [40.0, 60.0, 80.0]
//! [[grid]]
//! key = "load.pressure_mpa"
//! values = [[0.65], [2.6]]
//! [[list]]                             # rows of keys that go together, each with every combination
//! "pattern.depth_um" = 5.0
//! "pattern.spacing_um" = 100.0
//! ```
//!
//! | item | role |
//! |---|---|
//! | [`plan`], [`Campaign`], [`Task`] | what is to be done |
//! | [`Worker`], [`Done`] | doing it: a record, or why there is none |
//! | [`Results`] | all results as CSV, and how many ended how |
//! | [`Folder`], [`Store`] | a campaign that many machines see: tasks, workers, results |
//! | [`Engine`] | the job script of a cluster |
//!
//! This crate opens no files, reads no clock, prints nothing, and does not touch the environment: files come and go through
//! [`Store`], which is [`slipgrid_formats::source::Files`] with a way to write.

mod campaign;
mod engine;
mod error;
mod folder;
mod inputs;
mod plan;
mod results;
mod varied;
mod worker;

pub use campaign::{Campaign, Kind, Task};
pub use engine::Engine;
pub use error::CampaignError;
pub use folder::{Folder, Share, Store, Worked};
pub use inputs::Contents;
pub use plan::{Planned, plan};
pub use results::{Counts, Results};
pub use worker::{Done, Outcome, Worker};
