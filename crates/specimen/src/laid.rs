//! Shares of a face that cavities take, as they are laid.

use slipgrid_export::{ExportError, LaidStrip, Layout, Specimen};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::Dimension;

/// Share of the face of `layout` that is cavity over that of its endless pattern; where only a section is solved, along
/// the row of cavities through the specimen's centre.
pub(crate) fn density_share(layout: &Layout, dimension: Dimension) -> f64 {
    let pattern = layout.pattern();
    if dimension.section_of(pattern).is_none() {
        return layout.areal_density() / pattern.areal_density();
    }
    share_of(&layout.central_strip()) / pattern.section_density()
}

/// A design as it lies on a specimen: as many of its cavities lie on every sample that is made of it.
#[derive(Clone, Copy, Debug)]
pub struct Laid {
    dimension: Dimension,
    /// Its share of cavities over that of a period, and what one of its periods takes of the face; `None` of an endless pattern.
    on_face: Option<(f64, f64)>,
}

impl Laid {
    /// `designed` on `specimen`, or an endless pattern.
    ///
    /// # Errors
    /// [`ExportError`] where the specimen does not take the pattern.
    pub fn new(specimen: Option<&Specimen>, designed: &Pattern, dimension: Dimension) -> Result<Self, ExportError> {
        let endless = Self { dimension, on_face: None };
        specimen.map_or(Ok(endless), |specimen| Ok(Self::of(&specimen.layout(*designed)?, dimension)))
    }

    /// The pattern of `layout` as that has it.
    pub(crate) fn of(layout: &Layout, dimension: Dimension) -> Self {
        let on_face = (density_share(layout, dimension), period(layout.pattern(), dimension));
        Self { dimension, on_face: Some(on_face) }
    }

    /// Share of the face that is cavity over that of an endless pattern, of `made`, a sample of the design:
    /// D / `D_period` = (n `A_cavity` / `A_face`) / (`A_cavity` / `A_period`), n cavities as designed. Of crossing grooves to first order.
    #[must_use]
    pub fn share(&self, made: &Pattern) -> f64 {
        self.on_face.map_or(1.0, |(share, designed)| share * (period(made, self.dimension) / designed))
    }
}

/// What one period of `pattern` takes of a face: an area in space, a length of grooves and of sections.
fn period(pattern: &Pattern, dimension: Dimension) -> f64 {
    let across_m = pattern.pitch_across_m().filter(|_| dimension.section_of(pattern).is_none());
    pattern.pitch_m() * across_m.unwrap_or(1.0)
}

/// Share of strips that is cavity.
pub(crate) fn share_of(strips: &[LaidStrip]) -> f64 {
    let cavity_m = |strip: &LaidStrip| strip.cavities_m.iter().map(|[from_m, to_m]| to_m - from_m).sum::<f64>();
    let area_m2: f64 = strips.iter().map(|strip| strip.width_m * strip.length_m).sum();
    strips.iter().map(|strip| strip.width_m * cavity_m(strip)).sum::<f64>() / area_m2
}

/// A ratio on a specimen whose cavities take `share` of what an endless pattern's take.
#[must_use]
pub fn on_face(ratio: f64, share: f64) -> f64 {
    1.0 - share * (1.0 - ratio)
}
