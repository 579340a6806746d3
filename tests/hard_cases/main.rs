//! Difficult cases: one scene file per case, with the expected outcome in its first lines.
//!
//! Lines that begin with `#=` are a TOML table. `exit` is the exit code (default 0), and `says` a part of the refusal.
//! Any other key is a key of the results of `simulate --json`, and is checked at every load: a string or a boolean is
//! the required value (`"null"` for none), a pair of numbers the required range, and a list of strings the possible
//! values. `model` is a part of one of the model's statements.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test that cannot go on fails, and tells what it measured"
)]

mod outcomes;
mod properties;
mod scaling;
mod scenes;
