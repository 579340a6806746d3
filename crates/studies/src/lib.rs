//! The program's own evidence.
//!
//! | module | answers |
//! |---|---|
//! | [`accuracy`] | what each method costs, and how far it is from the reference |
//! | [`validation`] | what was measured on patterned samples beside what the model says |
//!
//! This crate opens no files, prints nothing and reads no clock: times come through a
//! [`Monitor`](slipgrid_monitor::Monitor), bytes through [`slipgrid_formats::source::Files`].

pub mod accuracy;
mod error;
pub mod validation;

pub use error::StudyError;
