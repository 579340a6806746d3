//! The program's own evidence.
//!
//! | module | answers |
//! |---|---|
//! | [`accuracy`] | what each method costs, and how far it is from the reference |
//! | [`laboratories`] | how many samples must be cut until one is on target |
//! | [`validation`] | what was measured on patterned samples beside what the model says |
//!
//! This crate opens no files, prints nothing and reads no clock: times come through a
//! [`Monitor`](slipgrid_monitor::Monitor), bytes through [`slipgrid_formats::source::Files`].
//!
//! ```
//! use slipgrid_studies::laboratories::{Job, Options, Policy, Start};
//! // Every laboratory of each start goes its way by each policy, and by the mixture once more whatever its target.
//! let options = Options { laboratories: 20, ..Options::default() };
//! let jobs = Job::all(&options, &[Policy::ALL[0], Policy::ALL[1]]);
//! assert_eq!(jobs.len(), Start::ALL.len() * (2 + 1) * 20);
//! ```

pub mod accuracy;
mod error;
pub mod laboratories;
pub mod validation;

pub use error::StudyError;
