//! Structure of the workspace: allowed dependencies between crates, no access of libraries to the environment, and a
//! program outside the workspace that does the main job.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test that cannot go on fails, and tells what it measured"
)]

mod cancelling;
mod debug_texts;
mod first_pages;
mod lines;
mod outside;
mod rooms;
mod whole_maps;
