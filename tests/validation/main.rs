//! Against others' numbers, or one of our methods against another. Long ones are ignored by default;
//! the README says how to run them.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod calibrated_flat;
mod dynamic_against_reference;
mod excess;
mod steady_against_dynamic;
