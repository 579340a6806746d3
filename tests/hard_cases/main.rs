//! Where others break: one scene file a case, each with what is expected of it in its first lines.
//!
//! Lines that begin with `#=` are a TOML table. `exit` is the exit code (0 when absent) and `says` a
//! part of the refusal. Any other key is one of `simulate --json`'s results and holds for every load: a
//! string or a truth value is what it must be (`"null"` for none), a pair of numbers the range it must
//! lie in, a list of strings the choices there are; `model` is a part of one of the model's statements.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test that cannot go on fails, and tells what it measured"
)]

mod outcomes;
mod properties;
mod scaling;
mod scenes;
