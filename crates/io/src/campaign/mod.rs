//! Campaigns: many scenes or designs as tasks that any machine can do in any order, with one table of results.
//!
//! A campaign file names a scene or a design and the keys that vary. [`plan()`] makes a task of every combination. The id
//! of a task is a hash of its text and of the files that it reads, so that equal tasks are done once. The files are
//! stored with the campaign, so that a task needs nothing else from the machine where it was planned. [`Worker`] does
//! tasks, and [`Results`] collects them into a table that does not depend on who did which task.
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
//! | [`plan()`], [`Campaign`], [`Task`] | campaign with its tasks |
//! | [`Worker`], [`Done`] | doing a task, and its result |
//! | [`Results`] | all results as CSV, with counts |
//! | [`Folder`], [`Store`] | a campaign in a folder that several machines share |
//! | [`Engine`] | job script for a cluster |
//!
//! This module opens no files, reads no clock, prints nothing, and does not use the environment: files are accessed
//! through [`Store`], which adds writing to [`crate::formats::source::Files`].

mod engine;
mod folder;
pub(crate) mod inputs;
pub(crate) mod plan;
mod records;
mod results;
mod varied;
mod worker;

pub use engine::Engine;
pub use folder::{Folder, Share, Store, Worked};
pub use inputs::Contents;
pub use plan::{Planned, plan};
pub use records::{Campaign, Kind, Task};
pub use results::{Counts, Results};
pub use worker::{Done, Outcome, Worker};
