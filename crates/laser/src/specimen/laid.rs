//! Cavity fraction of a specimen's face for the actual layout.

use crate::export::{ExportError, Layout, Specimen};
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::{Dimension, Strip};

/// Cavity fraction of the face of `layout` over that of the infinite pattern. If the model has only one section of the
/// planform, both are fractions of the length of the row of cavities through the specimen's centre.
pub(crate) fn density_share(layout: &Layout, dimension: Dimension) -> f64 {
    let pattern = layout.pattern();
    if dimension.section_of(pattern).is_none() {
        return layout.areal_density() / pattern.areal_density();
    }
    cavity_fraction(&layout.central_strip()) / pattern.section_density()
}

/// Cavity fraction of a design that is laid out on a specimen. Cut samples of the design, whose dimensions deviate from
/// the design, have the same number of cavities.
#[derive(Clone, Copy, Debug)]
pub struct Laid {
    dimension: Dimension,
    /// Cavity fraction of the face over that of a period of the design, and size of this period in m^2 or m
    /// (`period_size`); `None` for an infinite pattern.
    on_face: Option<(f64, f64)>,
}

impl Laid {
    /// Lays out `designed` on `specimen`; without a specimen, the pattern is infinite.
    ///
    /// # Errors
    /// [`ExportError`] if the pattern does not fit on the specimen.
    pub fn new(specimen: Option<&Specimen>, designed: &Pattern, dimension: Dimension) -> Result<Self, ExportError> {
        let endless = Self { dimension, on_face: None };
        specimen.map_or(Ok(endless), |specimen| Ok(Self::from_layout(&specimen.layout(*designed)?, dimension)))
    }

    /// Takes pattern and cavity fraction from `layout`.
    pub fn from_layout(layout: &Layout, dimension: Dimension) -> Self {
        Self::of_share(density_share(layout, dimension), layout.pattern(), dimension)
    }

    /// Lays out `designed` on a face whose cavity fraction is `share` times that of a period.
    pub fn of_share(share: f64, designed: &Pattern, dimension: Dimension) -> Self {
        Self { dimension, on_face: Some((share, period_size(designed, dimension))) }
    }

    /// Areal density of the face of a cut sample with the dimensions `made`, over that of an infinite pattern with
    /// these dimensions: D / `D_period` = (n `A_cavity` / `A_face`) / (`A_cavity` / `A_period`), with the number n of
    /// cavities of the design. For crossing grooves this holds to first order. 1 for an infinite pattern.
    pub fn share(&self, made: &Pattern) -> f64 {
        self.on_face.map_or(1.0, |(share, designed)| share * (period_size(made, self.dimension) / designed))
    }
}

/// Size of a period of `pattern`: an area in square metres in three dimensions, a length in metres for grooves and for
/// models of one section.
fn period_size(pattern: &Pattern, dimension: Dimension) -> f64 {
    let across_m = pattern.pitch_across_m().filter(|_| dimension.section_of(pattern).is_none());
    pattern.pitch_m() * across_m.unwrap_or(1.0)
}

/// Fraction of the area of `strips` that is cavity.
pub(crate) fn cavity_fraction(strips: &[Strip]) -> f64 {
    let area_m2: f64 = strips.iter().map(Strip::area_m2).sum();
    strips.iter().map(|strip| strip.width_m * strip.cavity_length_m()).sum::<f64>() / area_m2
}

/// Converts the friction ratio of an infinite pattern to that of a specimen whose cavity fraction is `share` times that
/// of the infinite pattern.
pub fn on_face(ratio: f64, share: f64) -> f64 {
    1.0 - share * (1.0 - ratio)
}
