//! Friction of a pattern on the specimen that it is cut into, for the layout that is exported. A ratio is the friction
//! of the patterned sample over that of the flat one.
//!
//! Grooves across the sliding direction are solved strip by strip ([`slipgrid_model::springblock::simulate_specimen`]).
//! For other planforms one period (a cell) is solved, which has the ratio r_cell and the areal density D_period. The
//! friction reduction is then scaled by the areal density D of the face, which includes untextured parts along the
//! border; this gives the ratio r of the specimen:
//!
//! ```text
//! 1 - r = (1 - r_cell) D / D_period
//! ```
//!
//! The search uses this formula for all designs. The error of the formula comes from the ends of strips; it is
//! estimated from grooves of the same section in two dimensions.
//!
//! | type | role |
//! |---|---|
//! | [`simulate_on`] | solves a scene on a specimen, dynamic or steady |
//! | [`SteadyOnFace`], [`time_changes_on`] | cheap corrections of steady ratios for specimen and dynamic sliding |
//! | [`Laid`], [`on_face`] | areal density of a design and its samples on a face, and the ratio that follows from it |
//!
//! On a disc as wide as eleven periods, the border leaves some squares out, and friction is reduced less:
//!
//! ```
//! use slipgrid_laser::export::{Outline, Specimen};
//! use slipgrid_model::pattern::{Pattern, Planform};
//! use slipgrid_laser::specimen::{Laid, on_face};
//! use slipgrid_model::springblock::Dimension;
//! let squares = Pattern::new(Planform::Square, 130e-6, 370e-6, 5.2e-6)?;
//! // A face of eleven periods along both sides has the density of the infinite pattern.
//! let side_m = 11.0 * squares.pitch_m();
//! let square = Specimen { outline: Outline::Rectangle { length_m: side_m, width_m: side_m }, is_clipped: false };
//! let share = Laid::new(Some(&square), &squares, Dimension::of(None, squares.texture()))?.share(&squares);
//! assert!((share - 1.0).abs() < 1e-9);
//! // The border of a disc leaves some squares out.
//! let disc = Specimen { outline: Outline::Disc { diameter_m: side_m }, is_clipped: false };
//! let share = Laid::new(Some(&disc), &squares, Dimension::of(None, squares.texture()))?.share(&squares);
//! assert!(share > 0.85 && share < 1.0 && on_face(0.9, share) > 0.9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod laid;
mod on_specimen;
mod strips;

pub use laid::{Laid, on_face};
pub use on_specimen::{SpecimenError, SteadyOnFace, layout_errors, nearest_known, simulate_on, time_changes_on};
