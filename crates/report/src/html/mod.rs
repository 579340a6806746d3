//! Results as one page for a browser or a printer: a single file that asks the network for nothing.
//!
//! | function | page |
//! |---|---|
//! | [`design`] | what `optimize` found, from its result.json and pictures |
//! | [`validation`] | measured ratios beside modelled ones, from what `validate` writes |
//!
//! A page takes what the result holds and leaves out what it does not. It says neither time nor threads:
//! the same result gives the same bytes.

mod background;
mod conditions;
mod design;
mod page;
mod section;
mod uncertainty;
mod validation;

pub use design::design;
pub use validation::validation;

#[cfg(test)]
mod tests;
