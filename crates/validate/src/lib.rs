//! Studies of the program's accuracy.
//!
//! | module | study |
//! |---|---|
//! | [`accuracy`] | cost and error of each method, relative to the reference |
//! | [`validation`] | measurements on patterned samples, compared with the model |
//!
//! This crate opens no files, prints nothing and reads no clock: times come from a
//! [`Monitor`](slipgrid_base::monitor::Monitor), bytes from [`slipgrid_io::formats::source::Files`].

pub mod accuracy;
pub mod validation;

pub use slipgrid_io::Failure;
