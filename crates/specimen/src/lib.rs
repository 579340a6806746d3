//! Friction of a pattern on the specimen that it is cut into: what is exported is what is solved.
//!
//! Grooves across the sliding direction are solved strip by strip ([`slipgrid_springblock::simulate_specimen`]). A specimen of any other
//! planform is a cell and what its rim leaves untextured: cavities lower friction in proportion to their share D of the face,
//!
//! ```text
//! 1 - r = (1 - r_cell) D / D_period
//! ```
//!
//! The same is what a search takes for every design. What the ends of strips do beside that is known from grooves of
//! the same section in the plane, and is the error of the formula.
//!
//! | type | role |
//! |---|---|
//! | [`simulate_on`], [`strips_on`] | solves a scene on a specimen, in time or steady, or both in turn |
//! | [`SteadyOnFace`], [`time_changes_on`] | what a specimen, and time, make of steady ratios, cheaply: how trials are modelled |
//! | [`Laid`], [`on_face`] | the share of cavities of a design, of samples of it, and what follows for the ratio |
//!
//! Of squares on a disc as wide as eleven periods, the rim leaves some untextured, and friction is lowered that much less:
//!
//! ```
//! use slipgrid_export::{Outline, Specimen};
//! use slipgrid_pattern::{Pattern, Planform};
//! use slipgrid_specimen::{Laid, on_face};
//! use slipgrid_springblock::Dimension;
//! let squares = Pattern::new(Planform::Square, 130e-6, 370e-6, 5.2e-6)?;
//! // A face that eleven periods fill along both sides has as many cavities as the endless pattern.
//! let side_m = 11.0 * squares.pitch_m();
//! let square = Specimen { outline: Outline::Rectangle { length_m: side_m, width_m: side_m }, is_clipped: false };
//! let share = Laid::new(Some(&square), &squares, Dimension::of(None, squares.texture()))?.share(&squares);
//! assert!((share - 1.0).abs() < 1e-9);
//! // The rim of a disc leaves some out.
//! let disc = Specimen { outline: Outline::Disc { diameter_m: side_m }, is_clipped: false };
//! let share = Laid::new(Some(&disc), &squares, Dimension::of(None, squares.texture()))?.share(&squares);
//! assert!(share > 0.85 && share < 1.0 && on_face(0.9, share) > 0.9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod laid;
mod on_specimen;

pub use laid::{Laid, on_face};
pub use on_specimen::{SpecimenError, SteadyOnFace, nearest_known, onto, simulate_on, strips_on, time_changes_on};
