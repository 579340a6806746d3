//! Against others' numbers, or one of our methods against another. Long ones are ignored by default;
//! the README says how to run them.

mod dynamic_against_reference;
mod steady_against_dynamic;
