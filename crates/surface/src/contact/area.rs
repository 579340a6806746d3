//! Real contact area, counted in the pixels of a pressure map.

use std::f64::consts::{LN_2, PI};

/// Real contact area as a fraction of the nominal area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactArea {
    /// Pixels in contact over all pixels.
    pub fraction: f64,
    /// `fraction` minus the systematic excess of counting whole pixels along the contact boundary.
    pub fraction_corrected: f64,
}

impl ContactArea {
    pub(crate) const NONE: Self = Self { fraction: 0.0, fraction_corrected: 0.0 };
    pub(crate) const FULL: Self = Self { fraction: 1.0, fraction_corrected: 1.0 };

    pub(crate) fn distance(&self, other: &Self) -> f64 {
        let counted = (self.fraction - other.fraction).abs();
        counted.max((self.fraction_corrected - other.fraction_corrected).abs())
    }
}

/// Counts the pixels with positive pressure on a periodic map with rows of `cols` pixels, and corrects the count for
/// the boundary.
///
/// V. A. Yastrebov, G. Anciaux and J.-F. Molinari, Tribology International 114, 161 (2017): the corrected area is A -
/// (pi - 1 + ln 2)/24 S d, where S is the length of the boundary between contact and open pixels and d the pixel size.
/// On pixels of dx by dy each boundary edge of length dy stands for a width dx, so that every edge counts dx dy.
pub(crate) fn contact_area(pressure: &[f64], cols: usize) -> ContactArea {
    let (mut pixels, mut edges) = (0_usize, 0_usize);
    let rows = pressure.len() / cols;
    for (i, row) in pressure.chunks_exact(cols).enumerate() {
        let below = (i + 1) % rows * cols;
        let mut left = row[cols - 1] > 0.0;
        for (&here, &next) in row.iter().zip(&pressure[below..below + cols]) {
            let here = here > 0.0;
            pixels += usize::from(here);
            edges += usize::from(here != left) + usize::from(here != (next > 0.0));
            left = here;
        }
    }
    let points = pressure.len() as f64;
    let fraction = pixels as f64 / points;
    // A_corrected = A - (pi - 1 + ln 2)/24 edges dx dy / (Lx Ly)
    let fraction_corrected = fraction - (PI - 1.0 + LN_2) / 24.0 * edges as f64 / points;
    ContactArea { fraction, fraction_corrected }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_counted_around_the_period() {
        let c = (PI - 1.0 + LN_2) / 24.0;
        // Two pixels that are neighbours across the periodic boundary: six edges.
        let mut pressure = vec![0.0; 20];
        pressure[5] = 1.0;
        pressure[9] = 2.0;
        let area = contact_area(&pressure, 5);
        assert!((area.fraction - 0.1).abs() < 1e-15);
        assert!((area.fraction_corrected - (0.1 - 6.0 * c / 20.0)).abs() < 1e-15);
        // A stripe along y: two edges per column, of which one crosses the periodic boundary.
        let stripe: Vec<f64> = (0..20).map(|n| if (5..15).contains(&n) { 0.0 } else { 1.0 }).collect();
        assert!((contact_area(&stripe, 5).fraction_corrected - (0.5 - 10.0 * c / 20.0)).abs() < 1e-15);
        let full = contact_area(&[1.0; 20], 5);
        assert_eq!((full.fraction, full.fraction_corrected), (1.0, 1.0));
        let none = contact_area(&[0.0; 20], 5);
        assert_eq!((none.fraction, none.fraction_corrected), (0.0, 0.0));
    }
}
