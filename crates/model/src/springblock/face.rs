//! Face of a specimen: strips along the sliding direction, each with its own cavities and ends.

use crate::pattern::Pattern;

use crate::springblock::SceneError;

/// A strip of a specimen's face along the sliding direction, uniform across its width.
#[derive(Clone, Debug, PartialEq)]
pub struct Strip {
    /// Index of the band of the face, counted across the sliding direction. Each strip is the middle of its band;
    /// strips on both sides of a hole are in the same band.
    pub band: usize,
    /// Width that the strip represents, in metres; the sum of width times length is the area of the face.
    pub width_m: f64,
    /// Length along the sliding direction, in metres.
    pub length_m: f64,
    /// Start and end of each cavity from the strip's left end, in metres; ascending and disjoint.
    pub cavities_m: Vec<[f64; 2]>,
}

impl Strip {
    /// Total length of the cavities, in metres.
    pub fn cavity_length_m(&self) -> f64 {
        self.cavities_m.iter().map(|[start, end]| end - start).sum()
    }

    /// Area that the strip represents, in square metres.
    pub fn area_m2(&self) -> f64 {
        self.width_m * self.length_m
    }
}

/// Face of a specimen with the layout of its cavities, divided into strips.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    strips: Vec<Strip>,
    cavity_share: f64,
}

impl Face {
    /// Creates a face of `strips`. `cavity_share` is the exact area fraction of cavities on the face, from 0 to less
    /// than 1; the strips only sample this fraction.
    ///
    /// # Errors
    /// [`SceneError::OutOfRange`] without strips, for a cavity fraction out of range, nonpositive lengths, and cavities
    /// out of order or outside their strip.
    pub fn new(strips: Vec<Strip>, cavity_share: f64) -> Result<Self, SceneError> {
        let refuse = |quantity, value, expected| Err(SceneError::OutOfRange { quantity, value, expected });
        if strips.is_empty() {
            return refuse("strips", 0.0, "at least one strip of the face");
        }
        if !(0.0..1.0).contains(&cavity_share) {
            return refuse("cavity_share", cavity_share, "a share from 0 to less than 1");
        }
        for strip in &strips {
            for (quantity, value) in [("strip width_m", strip.width_m), ("strip length_m", strip.length_m)] {
                if !(value.is_finite() && value > 0.0) {
                    return refuse(quantity, value, "a positive number");
                }
            }
            let mut reached_m = 0.0;
            for &[start_m, end_m] in &strip.cavities_m {
                if !(start_m >= reached_m && end_m > start_m && end_m <= strip.length_m) {
                    return refuse("strip cavities_m", start_m, "intervals within the strip, ascending and apart");
                }
                reached_m = end_m;
            }
        }
        // Rounding to twelve digits removes the rounding errors of decimal numbers in files.
        Ok(Self { strips, cavity_share: (cavity_share * 1e12).round() * 1e-12 })
    }

    /// Strips of the face, in order.
    pub fn strips(&self) -> &[Strip] {
        &self.strips
    }

    /// Area fraction of cavities on the face.
    pub const fn cavity_share(&self) -> f64 {
        self.cavity_share
    }

    /// Cavity fraction D of the face over the cavity fraction D_cell of a section of `pattern`. The friction reduction
    /// of the face over that of a periodic cell equals this ratio.
    pub fn share_of(&self, pattern: &Pattern) -> f64 {
        self.cavity_share / pattern.section_density()
    }

    /// Strip for the dynamic run: the longest strip with cavities, or the longest strip if none has cavities; the first
    /// among equals.
    pub(crate) fn longest(&self) -> &Strip {
        let textured = |strip: &Strip| !strip.cavities_m.is_empty();
        let better = |a: &Strip, b: &Strip| (textured(a), a.length_m) > (textured(b), b.length_m);
        let first = &self.strips[0];
        self.strips.iter().fold(first, |best, strip| if better(strip, best) { strip } else { best })
    }

    /// Number of bands of the face.
    pub(crate) fn bands(&self) -> usize {
        self.strips.iter().map(|strip| strip.band + 1).max().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strip(length_m: f64, cavities_m: &[[f64; 2]]) -> Strip {
        Strip { band: 0, width_m: 1e-3, length_m, cavities_m: cavities_m.to_vec() }
    }

    #[test]
    fn strips_that_mean_nothing_are_refused() {
        let face = |strips: Vec<Strip>, share: f64| Face::new(strips, share);
        assert!(face(vec![], 0.1).is_err());
        assert!(face(vec![strip(1e-3, &[])], 1.0).is_err());
        assert!(face(vec![strip(f64::NAN, &[])], 0.1).is_err());
        assert!(face(vec![strip(1e-3, &[[1e-4, 2e-4], [1.5e-4, 3e-4]])], 0.1).is_err());
        assert!(face(vec![strip(1e-3, &[[9e-4, 1.1e-3]])], 0.1).is_err());
        let good = face(vec![strip(2e-3, &[]), strip(1e-3, &[[1e-4, 2e-4]])], 0.1).unwrap();
        assert_eq!(good.longest().length_m, 1e-3, "the longest that has cavities");
    }
}
