//! A specimen: its face, and what becomes of cavities at the rim.

use slipgrid_pattern::Pattern;

use crate::{ExportError, Layout, Outline};

/// The specimen's face, and what becomes of cavities that pass its rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Specimen {
    /// The face.
    pub outline: Outline,
    /// Cavities that pass the rim are cut there instead of left out.
    pub is_clipped: bool,
}

impl Specimen {
    /// `pattern` on it.
    ///
    /// # Errors
    /// [`ExportError`] if no cavity fits, or far too many.
    pub fn layout(&self, pattern: Pattern) -> Result<Layout, ExportError> {
        if self.is_clipped { Layout::clipped(pattern, self.outline) } else { Layout::new(pattern, self.outline) }
    }

    /// Length along the sliding direction to the nearest whole number of blocks of `block_m`, at least one, in metres.
    #[must_use]
    pub fn whole_length_m(&self, block_m: f64) -> f64 {
        (self.outline.extents_m()[0] / block_m).round().max(1.0) * block_m
    }

    /// Whether it takes `pattern`.
    ///
    /// # Errors
    /// As [`Specimen::layout`].
    pub fn check(&self, pattern: Pattern) -> Result<(), ExportError> {
        Layout::check(pattern, self.outline, self.is_clipped)
    }
}

/// Names of what becomes of cavities that pass the rim: left out, or cut.
pub const AT_THE_RIM: [&str; 2] = ["whole", "clipped"];
