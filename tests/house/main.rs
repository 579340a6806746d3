//! The house: which room may use which, what no library touches, and a program outside that does the main job.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test that cannot go on fails, and tells what it measured"
)]

mod cancelling;
mod debug_texts;
mod first_pages;
mod outside;
mod rooms;
mod whole_maps;
