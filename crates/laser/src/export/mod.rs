//! Files for a laser, from a pattern and the outline of a specimen.
//!
//! A [`Layout`] places cavities on the specimen, complete or cut at the border: one at the centre, the others at x = i
//! times the pitch and y = j times the pitch across, with odd rows shifted by half a pitch in staggered arrangements;
//! grooves may have any angle. x is the sliding direction unless the texture has a sliding angle. With cavities of area
//! a and depth d on a face of area A,
//!
//! ```text
//! areal density = sum a / A        volume = d sum a
//! ```
//!
//! | type or function | role |
//! |---|---|
//! | [`Outline`] | face of the specimen: disc, rectangle or ring |
//! | [`Specimen`] | the face, and treatment of cavities that cross its border |
//! | [`Layout`], [`Cavity`], [`Boundary`] | cavities on the face, computed one by one in a fixed order |
//! | [`Division`], [`Sector`] | several patterns on one specimen, one per sector |
//! | [`Heading`] | name, version and notes of a drawing |
//! | [`Laser`], [`Ablation`], [`Exposure`] | parameters of the laser, depth per burst against fluence, hatch or mask |
//! | [`Marking`], [`Line`] | lines that the spot follows |
//! | [`Removal`] | depth removed by passes over the lines, and the number of passes for a depth |
//! | [`laser_warnings`], [`burst_warnings`] | deviations of the cut cavities from the design |
//! | [`dxf`], [`dxf_of_sectors`] | drawing for the laser, AutoCAD R12 |
//! | [`svg`], [`svg_of_sectors`] | drawing to scale, for people |
//! | [`hpgl`] | plot for marking software, HP-GL/2 |
//! | [`gcode`], [`GcodePlan`] | program for controllers with a laser mode |
//! | [`csv`], [`corners_csv`], [`hatch_csv`] | tables of cavities, of their corners, and of marking lines |
//! | [`height_map`], [`HeightMap`] | surface as a 16-bit PNG |
//! | [`stl`], [`check_stl`] | removed volume as closed solids |
//! | [`ProcessSheet`], [`ProcessInput`], [`MadeBy`], [`WorkSheet`], [`Tolerances`], [`MaterialNote`] | process sheet for the operator of the laser, as TOML |
//! | [`SectorsSheet`], [`SectorSheet`], [`DividedSheet`], [`MEASURE_EACH_ALONE`] | process sheet of sectors |
//! | [`ExportError`] | reasons why nothing can be exported |
//!
//! Coordinates in files are millimetres from the specimen's centre, rounded to [`COORDINATE_DECIMALS`] decimals, one
//! nanometre. Equal layouts give equal bytes. Files are streamed to any [`std::io::Write`], so that memory does not
//! grow with the number of cavities.
//!
//! This module does not depend on a solver and opens no files.
//!
//! ```
//! use slipgrid_laser::export::{Layout, Outline};
//! use slipgrid_model::pattern::{Pattern, Planform};
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
pub(crate) mod layout;
mod marking;
mod number;
mod outline;
mod process;
mod removal;
mod sector_sheet;
mod sectors;
mod specimen;
mod specimen_record;
mod stl;
mod stream;
mod svg;
mod unreached;
mod words;
mod work;

#[cfg(test)]
mod tests;

pub use ablation::{Ablation, AblationPoint};
pub(crate) use ascii::ascii;
pub use cavity::{Boundary, Cavity};
pub use csv::{corners_csv, csv, csv_header, hatch_csv};
pub use dxf::{
    LAYER_CAVITIES, LAYER_MARK, LAYER_ORIGIN, LAYER_OUTLINE, LAYER_SLIDING_DIRECTION, dxf, dxf_of_sectors, sector_layer,
};
pub use error::ExportError;
pub(crate) use error::{all_positive, mm, positive};
pub use gcode::{GcodePlan, gcode};
pub use height_map::{HeightMap, MAX_PIXELS, height_map};
pub use hpgl::hpgl;
pub use laser::{Exposure, Laser};
pub use layout::{Layout, MAX_CAVITIES};
pub use marking::{Line, Marking};
pub use number::COORDINATE_DECIMALS;
pub(crate) use number::{
    MICROMETRE_DECIMALS, decimal, depth, depth_words, micrometres, millimetres, push_decimal, round_decimals,
    six_digits,
};
pub use outline::Outline;
pub(crate) use outline::left_of;
pub use process::{MadeBy, MaterialNote, PatternSheet, ProcessInput, ProcessSheet, Tolerances, not_modelled};
pub use removal::{Removal, burst_warnings, depth_within_um, laser_warnings};
pub use sector_sheet::{DividedSheet, MEASURE_EACH_ALONE, SectorSheet, SectorsSheet};
pub use sectors::{Division, MAX_SECTORS, MIN_PERIODS, Sector};
pub use specimen::{AT_THE_RIM, Specimen};
pub use specimen_record::SpecimenRecord;
pub use stl::{CHORDS, check as check_stl, stl};
pub(crate) use stream::{flush_full, flush_rest};
pub use svg::{is_xml_letter, svg, svg_of_sectors};
pub(crate) use words::{ANGLE_DECIMALS, cavities, degrees, groove_direction, lattice, sliding_direction, steps};
pub use work::{WorkSheet, exposure_time_s, laser_time_s, one_exposure};

/// Title block of drawings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heading<'a> {
    /// Name of the design.
    pub name: &'a str,
    /// Version of the program that made the design.
    pub version: &'a str,
    /// Notes, one line each, for example that the surface is synthetic.
    pub notes: &'a [&'a str],
}
