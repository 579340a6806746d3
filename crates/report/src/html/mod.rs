//! Results as one page for a browser or a printer: a single file that asks the network for nothing.
//!
//! | function | page |
//! |---|---|
//! | [`design`] | what `optimize` found, from its record and pictures |
//! | [`exploration`] | what any design of a task does, before any is searched |
//! | [`calibration`] | what `calibrate` fitted, and what the data leave open |
//! | [`surface`] | an altitude map: its parameters, and what makes them doubtful |
//! | [`trials`] | the ledger of trials |
//! | [`page`] | the parts of any page |
//!
//! A page is drawn from a record by its type, shows what the record holds and leaves out what is `None`. It says neither
//! time nor threads: the same result gives the same bytes.

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

pub use calibration::{Fitted, calibration};
pub use design::design;
pub use explorer::exploration;
pub use surface::surface;
pub use trials::trials;

#[cfg(test)]
mod fixture;
#[cfg(test)]
mod tests;
