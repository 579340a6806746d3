//! Tests of the program as a user runs it: every command with its messages and files.

#![allow(clippy::unwrap_used, reason = "a test that unwraps in vain fails, as it should")]

mod cache;
mod calibrations;
mod campaign;
mod commands;
mod common;
mod conditions;
mod ctrl_c;
mod directions;
mod discrepancy;
mod doubtful_maps;
mod durations;
mod guards;
mod interruptions;
mod land;
mod learning;
mod local_law;
mod mutations;
mod optimize;
mod outside;
mod planforms;
mod refusals;
mod relief;
mod repeats;
mod rims;
mod studies;
mod study_file;
mod surface;
mod targets;
mod templates;
mod tolerances;
mod trials;
