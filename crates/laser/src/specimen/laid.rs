//! Fraction of a specimen's face that is cavity, for the actual layout.

use crate::export::{ExportError, Layout, Specimen};
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::{Dimension, Strip};

/// Areal density of the face of `layout` over that of the infinite pattern. For a two-dimensional model, both along the
/// row of cavities through the specimen's centre.
pub(crate) fn density_share(layout: &Layout, dimension: Dimension) -> f64 {
    let pattern = layout.pattern();
    if dimension.section_of(pattern).is_none() {
        return layout.areal_density() / pattern.areal_density();
    }
    cavity_fraction(&layout.central_strip()) / pattern.section_density()
}

/// A design laid out on a specimen. Every sample of the design has the same number of cavities.
#[derive(Clone, Copy, Debug)]
pub struct Laid {
    dimension: Dimension,
    /// Areal density over that of a period, and size of a period of the design; `None` for an infinite pattern.
    on_face: Option<(f64, f64)>,
}

impl Laid {
    /// Lays out `designed` on `specimen`; `None` for an infinite pattern.
    ///
    /// # Errors
    /// [`ExportError`] if the pattern does not fit on the specimen.
    pub fn new(specimen: Option<&Specimen>, designed: &Pattern, dimension: Dimension) -> Result<Self, ExportError> {
        let endless = Self { dimension, on_face: None };
        specimen.map_or(Ok(endless), |specimen| Ok(Self::from_layout(&specimen.layout(*designed)?, dimension)))
    }

    /// The design with the pattern and layout of `layout`.
    pub(crate) fn from_layout(layout: &Layout, dimension: Dimension) -> Self {
        let on_face = (density_share(layout, dimension), period_size(layout.pattern(), dimension));
        Self { dimension, on_face: Some(on_face) }
    }

    /// Areal density of the face of `made`, a sample of the design, over that of its infinite pattern: D / `D_period` =
    /// (n `A_cavity` / `A_face`) / (`A_cavity` / `A_period`), with n cavities as designed. For crossing grooves this
    /// holds to first order.
    pub fn share(&self, made: &Pattern) -> f64 {
        self.on_face.map_or(1.0, |(share, designed)| share * (period_size(made, self.dimension) / designed))
    }
}

/// Size of a period of `pattern` on a face: an area in three dimensions, a length for grooves and sections.
fn period_size(pattern: &Pattern, dimension: Dimension) -> f64 {
    let across_m = pattern.pitch_across_m().filter(|_| dimension.section_of(pattern).is_none());
    pattern.pitch_m() * across_m.unwrap_or(1.0)
}

/// Fraction of strips that is cavity.
pub(crate) fn cavity_fraction(strips: &[Strip]) -> f64 {
    let area_m2: f64 = strips.iter().map(Strip::area_m2).sum();
    strips.iter().map(|strip| strip.width_m * strip.cavity_length_m()).sum::<f64>() / area_m2
}

/// Converts the ratio of an infinite pattern to that on a specimen, whose cavities take `share` of the density of the
/// infinite pattern.
pub fn on_face(ratio: f64, share: f64) -> f64 {
    1.0 - share * (1.0 - ratio)
}
