//! Results as a single HTML page for browsers and printers, without network access.
//!
//! | function | page |
//! |---|---|
//! | [`design()`] | result of `optimize`, from its record and pictures |
//! | [`exploration`] | predictions for any design of a task, before a search |
//! | [`calibration()`] | result of `calibrate`, and the remaining uncertainty |
//! | [`surface()`] | altitude map: parameters and warnings |
//! | [`trials()`] | the ledger of trials |
//! | [`page`] | parts of any page |
//!
//! A page is drawn from a typed record, shows all values of the record and leaves out values that are `None`. It
//! contains neither times nor thread counts: identical results give identical bytes.

mod background;
mod calibration;
mod design;
mod explorer;
mod first_screen;
pub mod page;
mod points;
mod section;
mod surface;
mod trials;
mod words;

pub use calibration::calibration;
pub use design::design;
pub use explorer::exploration;
pub use surface::surface;
pub use trials::trials;

#[cfg(test)]
pub(crate) mod tests;
