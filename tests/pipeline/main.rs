//! Whole commands on the files that ship.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod designs;
