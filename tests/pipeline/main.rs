//! Runs whole commands on the shipped files.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test that cannot go on fails, and tells what it measured"
)]

mod designs;
mod synthetic_material;
