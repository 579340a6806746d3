//! Files that a laser takes: from a pattern and a specimen's outline to bytes.
//!
//! A [`Layout`] puts whole cavities on the specimen, one of them on its centre, at x = i pitch and
//! y = j pitch across, odd rows half a pitch aside where staggered, grooves at any angle. x is the
//! sliding direction unless the texture turns that. With N cavities of area a and depth d on a face
//! of area A,
//!
//! ```text
//! areal density = sum a / A        volume = d sum a
//! ```
//!
//! | type or function | role |
//! |---|---|
//! | [`Outline`] | the specimen's face: disc or rectangle |
//! | [`Layout`], [`Cavity`], [`Boundary`] | the cavities on it, made one by one in a fixed order |
//! | [`Heading`] | name, version and notes that drawings carry |
//! | [`dxf`] | drawing for the laser, AutoCAD R12 |
//! | [`svg`] | drawing for people, at scale |
//! | [`csv`] | table of the cavities |
//! | [`ProcessSheet`], [`ProcessInput`], [`Laser`], [`Tolerances`], [`MaterialNote`] | what the person at the laser needs, as TOML |
//! | [`ExportError`] | why nothing can be exported |
//!
//! Coordinates in files are millimetres from the specimen's centre, rounded to
//! [`COORDINATE_DECIMALS`] decimals, one nanometre. The same layout gives the same bytes.
//!
//! This crate knows no solver and opens no files.
//!
//! ```
//! use slipgrid_export::{Layout, Outline};
//! use slipgrid_pattern::{Pattern, Planform};
//! let pattern = Pattern::new(Planform::Square, 130e-6, 370e-6, 5.2e-6)?;
//! // Lattice points from -1 to 1 mm in x and -0.5 to 0.5 mm in y: five by three.
//! let layout = Layout::new(pattern, Outline::Rectangle { length_m: 2.13e-3, width_m: 1.13e-3 })?;
//! assert_eq!(layout.cavities(), 15);
//! assert!((layout.areal_density() - 15.0 * 0.0169 / (2.13 * 1.13)).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod cavity;
mod csv;
mod dxf;
mod error;
mod layout;
mod number;
mod outline;
mod process;
mod svg;
mod words;

pub use cavity::{Boundary, Cavity};
pub use csv::{csv, csv_header};
pub use dxf::{LAYER_CAVITIES, LAYER_OUTLINE, LAYER_SLIDING_DIRECTION, dxf};
pub use error::ExportError;
pub use layout::{Layout, MOST_CAVITIES};
pub use number::COORDINATE_DECIMALS;
pub use outline::Outline;
pub use process::{
    Laser, MaterialNote, NOT_MODELLED, PatternSheet, ProcessInput, ProcessSheet, SpecimenSheet, Tolerances, WorkSheet,
};
pub use svg::svg;

/// What drawings say about themselves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heading<'a> {
    /// Name of the design.
    pub name: &'a str,
    /// Version of the program that made it.
    pub version: &'a str,
    /// Remarks, one line each: for instance that the surface behind the design is synthetic.
    pub notes: &'a [&'a str],
}
