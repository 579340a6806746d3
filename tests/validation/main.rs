//! Comparison with independent results, or of one method with another. Long tests are ignored by default; the README
//! says how to run them.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test that cannot go on fails, and tells what it measured"
)]

mod blocks;
mod calibrated_flat;
mod coverage;
mod dynamic_against_reference;
mod excess;
mod finite_elements;
mod floor;
mod lattices;
mod rims;
mod steady_against_dynamic;
mod work_precision;
