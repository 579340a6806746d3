//! Results as one page for a browser or a printer: a single file that asks the network for nothing.
//!
//! | function | page |
//! |---|---|
//! | [`design`] | what `optimize` found, from its record and pictures |
//! | [`exploration`] | what any design of a task does, before any is searched |
//! | [`page`] | the parts of any page |
//!
//! A page is drawn from a record by its type, shows what the record holds and leaves out what is `None`. It says neither
//! time nor threads: the same result gives the same bytes.

mod background;
mod conditions;
mod design;
mod explorer;
mod first_screen;
pub mod page;
mod section;
mod uncertainty;

pub use design::design;
pub use explorer::exploration;

#[cfg(test)]
mod fixture;
#[cfg(test)]
mod tests;
