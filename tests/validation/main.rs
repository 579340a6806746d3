//! Against others' numbers, or one of our methods against another. Long ones are ignored by default;
//! the README says how to run them.

mod calibrated_flat;
mod dynamic_against_reference;
mod excess;
mod steady_against_dynamic;
