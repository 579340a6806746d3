//! Texture patterns: a periodic array of equal cavities.
//!
//! Along a row `pitch = width + spacing`, where `spacing` is the gap between two cavities. Across the rows `pitch
//! across = length + spacing across`, where the spacing across equals the spacing by default. In staggered arrangements
//! every second row is shifted by half a pitch. The fraction of the surface covered by cavities is
//!
//! | planform | areal density |
//! |---|---|
//! | groove | width / pitch |
//! | square, rectangle | (width / pitch) (length / pitch across) |
//! | disc | (pi / 4) (width / pitch) (width / pitch across) |
//! | polygon | area / (pitch pitch across) |
//! | crosshatch | 1 - (1 - width / pitch)^2 |
//!
//! There are three sets of axes: X and Y of the specimen; x (along a row) and y (across) of the pattern, which are
//! turned against them for grooves; and the sliding direction, at any angle. The periodic cell is a rectangle in the
//! pattern's axes, whose origin is the centre of a cavity. The sliding direction is given in these axes.
//!
//! | type | role |
//! |---|---|
//! | [`Texture`] | shape, extent across, arrangement, directions and rims: everything except width, spacing and depth |
//! | [`Planform`], [`Contour`], [`Arrangement`] | shape of a cavity seen from above, curve around it, and arrangement of rows |
//! | [`Rim`], [`RimProfile`] | recast material along the edge of a cavity |
//! | [`ReliefMap`], [`LandRelief`] | measured heights of a face over one period, and of the lands between cavities |
//! | [`Polygon`] | outline of a cavity of arbitrary shape |
//! | [`TextureRecord`] | a texture as keys of a file |
//! | [`Pattern`] | a texture with width, spacing and depth in SI units: cell, coverage, densities |
//! | [`ManufacturingLimits`] | limits of the laser, and the [`LimitViolation`]s of a pattern |
//! | [`geometry`] | points, segments and polygons in the plane |
//! | [`PatternError`] | reasons why a texture or a pattern is refused |
//!
//! This module does not depend on a solver and opens no files.
//!
//! ```
//! use slipgrid_model::pattern::{Arrangement, Pattern, Planform, Texture};
//! let squares = Pattern::new(Planform::Square, 130e-6, 370e-6, 20e-6)?;
//! assert!((squares.areal_density() - 0.0676).abs() < 1e-12);
//! // A block of 10 um whose left half lies in the cavity that ends 65 um from its centre.
//! assert!((squares.coverage(60e-6, 70e-6, 0.0, 10e-6) - 0.5).abs() < 1e-12);
//!
//! let discs = Texture::new(Planform::Disc).with_arrangement(Arrangement::Staggered)?;
//! let discs = Pattern::new(discs.with_sliding_angle_deg(90.0)?, 100e-6, 100e-6, 20e-6)?;
//! assert_eq!((discs.cell_m(), discs.sliding_direction()), ([200e-6, 400e-6], [0.0, 1.0]));
//! let density = std::f64::consts::PI / 16.0;
//! assert!((discs.coverage(0.0, 200e-6, 0.0, 400e-6) - density).abs() < 1e-12);
//! # Ok::<(), slipgrid_model::pattern::PatternError>(())
//! ```

mod array;
mod coverage;
mod error;
pub mod geometry;
mod grown;
mod limits;
mod planform;
mod polygon;
mod record;
mod relief_map;
mod rim;
mod rim_share;
mod texture;

pub use array::Pattern;
pub(crate) use array::snap_fraction;
pub use error::PatternError;
pub use limits::{LimitViolation, ManufacturingLimits};
pub use planform::{Arrangement, Contour, Planform};
pub use polygon::Polygon;
pub use record::TextureRecord;
pub use relief_map::{LandRelief, ReliefMap};
pub use rim::{Rim, RimProfile};
pub use texture::{Texture, folded_deg};

#[cfg(test)]
pub(crate) use polygon::tests::regular;
#[cfg(test)]
mod tests;
