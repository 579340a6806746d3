//! Files that a laser takes: from a pattern and a specimen's outline to bytes.
//!
//! A [`Layout`] puts cavities on the specimen, whole or cut at the rim, one of them on its centre, at
//! x = i pitch and y = j pitch across, odd rows half a pitch aside where staggered, grooves at any angle. x is
//! the sliding direction unless the texture turns that. With N cavities of area a and depth d on a face
//! of area A,
//!
//! ```text
//! areal density = sum a / A        volume = d sum a
//! ```
//!
//! | type or function | role |
//! |---|---|
//! | [`Outline`] | the specimen's face: disc, rectangle or ring |
//! | [`Specimen`] | the face, with what becomes of cavities that pass its rim |
//! | [`Layout`], [`Cavity`], [`Boundary`] | the cavities on it, made one by one in a fixed order |
//! | [`Division`], [`Sector`] | several patterns on one specimen, each on a sector of its own |
//! | [`LaidStrip`] | a strip of it along the sliding direction, for solvers |
//! | [`Heading`] | name, version and notes that drawings carry |
//! | [`Laser`], [`Ablation`], [`Exposure`] | the laser, its depth per burst against fluence, hatch or mask |
//! | [`Marking`], [`Line`] | the lines that the spot follows |
//! | [`Removal`] | what passes over them remove, and how many a depth needs |
//! | [`laser_warnings`], [`burst_warnings`] | what the laser does other than the design says |
//! | [`dxf`], [`dxf_of_sectors`] | drawing for the laser, AutoCAD R12 |
//! | [`svg`], [`svg_of_sectors`] | drawing for people, at scale |
//! | [`hpgl`] | plot for marking software, HP-GL/2 |
//! | [`gcode`], [`GcodePlan`] | program for controllers with a laser mode |
//! | [`csv`], [`corners_csv`], [`hatch_csv`] | tables of the cavities, their corners, the lines |
//! | [`height_map`], [`HeightMap`] | the surface as a 16-bit PNG |
//! | [`stl`], [`check_stl`] | what is removed, as closed solids |
//! | [`ProcessSheet`], [`ProcessInput`], [`WorkSheet`], [`Tolerances`], [`MaterialNote`] | what the person at the laser needs, as TOML |
//! | [`SectorsSheet`], [`SectorSheet`], [`DividedSheet`], [`MEASURE_EACH_ALONE`] | the same of sectors |
//! | [`ExportError`] | why nothing can be exported |
//!
//! Coordinates in files are millimetres from the specimen's centre, rounded to
//! [`COORDINATE_DECIMALS`] decimals, one nanometre. The same layout gives the same bytes. Files are written
//! piece by piece to any [`std::io::Write`]: memory does not grow with the number of cavities.
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

mod ablation;
mod ascii;
mod cavity;
mod clip;
mod clip_simple;
mod crossing;
mod csv;
mod dxf;
mod error;
mod face;
mod gcode;
mod height_map;
mod hpgl;
mod laser;
mod layout;
mod marking;
mod number;
mod outline;
mod overlap;
mod process;
mod removal;
mod sector_sheet;
mod sectors;
mod specimen;
mod stl;
mod stream;
mod strips;
mod svg;
mod unreached;
mod words;
mod work;

#[cfg(test)]
mod tests;

pub use ablation::{Ablation, AblationPoint};
pub use cavity::{Boundary, Cavity};
pub use csv::{corners_csv, csv, csv_header, hatch_csv};
pub use dxf::{
    LAYER_CAVITIES, LAYER_MARK, LAYER_ORIGIN, LAYER_OUTLINE, LAYER_SLIDING_DIRECTION, dxf, dxf_of_sectors, sector_layer,
};
pub use error::ExportError;
pub use gcode::{GcodePlan, gcode};
pub use height_map::{HeightMap, MAX_PIXELS, height_map};
pub use hpgl::hpgl;
pub use laser::{Exposure, Laser};
pub use layout::{Layout, MAX_CAVITIES};
pub use marking::{Line, Marking};
pub use number::COORDINATE_DECIMALS;
pub use outline::Outline;
pub use overlap::{burst_warnings, laser_warnings};
pub use process::{MaterialNote, PatternSheet, ProcessInput, ProcessSheet, SpecimenSheet, Tolerances, not_modelled};
pub use removal::Removal;
pub use sector_sheet::{DividedSheet, MEASURE_EACH_ALONE, SectorSheet, SectorsSheet};
pub use sectors::{Division, MAX_SECTORS, MIN_PERIODS, Sector};
pub use specimen::{AT_THE_RIM, Specimen};
pub use stl::{CHORDS, check as check_stl, stl};
pub use strips::LaidStrip;
pub use svg::{is_xml_letter, svg, svg_of_sectors};
pub use work::{WorkSheet, laser_time_s};

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
