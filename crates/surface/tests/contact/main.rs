//! Contact against closed forms, other codes and laws.

#![allow(clippy::unwrap_used, reason = "a test that unwraps in vain fails, as it should")]

mod any_surface;
mod closed_form;
mod common;
mod convergence;
mod laws;
mod validation;
mod windows;
