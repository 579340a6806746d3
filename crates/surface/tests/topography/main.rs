//! Maps, readers and parameters against other codes.

#![allow(clippy::unwrap_used, reason = "a test that unwraps in vain fails, as it should")]

mod properties_readers;
mod validation_functional;
mod validation_parameters;
mod validation_readers;
