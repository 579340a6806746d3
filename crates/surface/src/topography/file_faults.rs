//! Detects faults of a file that show in the heights: pixels in two units, and zeros in place of points that were not
//! measured.

use crate::topography::error::significant;
use crate::topography::{HeightMap, MapDoubt, MapWarning, limits};

impl HeightMap {
    /// Warning on implausible pixel sides; `None` if they are plausible.
    pub fn pixel_warning(&self) -> Option<MapWarning> {
        let pixel_m @ [x_m, y_m] = [self.dx_m(), self.dy_m()];
        let [least, most] = limits::WARNED_PIXEL_M;
        let is_usual = pixel_m.iter().all(|side_m| (least..=most).contains(side_m));
        let is_oblong = (x_m / y_m).max(y_m / x_m) > limits::WARNED_PIXEL_RATIO;
        (!is_usual || is_oblong).then(|| MapWarning {
            doubt: MapDoubt::Pixels,
            text: format!(
                "pixels of {} x {} um are implausible: a side of the map may be missing in the file, or in another unit",
                significant(x_m * 1e6, 5),
                significant(y_m * 1e6, 5)
            ),
        })
    }

    /// Warning on exact zeros that fill blocks of 3 x 3 points or more in the measured map; `None` if zeros are few,
    /// are all heights, fill no block, or fill no more blocks than other equal heights do.
    pub fn zeros_warning(&self) -> Option<MapWarning> {
        let (rows, cols, heights_m) = (self.rows(), self.cols(), self.heights_m());
        let least = (limits::WARNED_ZEROS_SHARE * heights_m.len() as f64).ceil() as usize;
        let zeros = heights_m.iter().filter(|height| **height == 0.0).count();
        // A map without relief has no other heights.
        if zeros < least || zeros == heights_m.len() {
            return None;
        }
        let is_block = |i: usize, j: usize| {
            let height = heights_m[i * cols + j];
            (i - 1..i + 2).all(|i| heights_m[i * cols + j - 1..i * cols + j + 2].iter().all(|other| *other == height))
        };
        let inner = (1..rows.saturating_sub(1)).flat_map(|i| (1..cols.saturating_sub(1)).map(move |j| (i, j)));
        let (mut of_zeros, mut of_others) = (0_usize, 0_usize);
        for (i, j) in inner.filter(|&(i, j)| is_block(i, j)) {
            let count = if heights_m[i * cols + j] == 0.0 { &mut of_zeros } else { &mut of_others };
            *count += 1;
        }
        // Coarsely quantised heights fill blocks at many values; the floors of ideal cavities fill blocks at a value
        // other than zero.
        (of_zeros > 0 && of_zeros > of_others).then(|| MapWarning {
            doubt: MapDoubt::Zeros,
            text: format!(
                "{zeros} of {} points are exactly 0 in blocks, as some instruments write points that they did not measure: \
                 if they are, export them as NaN or BAD",
                heights_m.len()
            ),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topography::plausibility::tests::rough;

    #[test]
    fn blocks_of_zeros_are_named_unless_other_heights_come_in_blocks_too() {
        let map = rough(0.8);
        let inside = |n: usize| (40..50).contains(&(n / 128)) && (10..20).contains(&(n % 128));
        let holed = map.changed(|n, h| if inside(n) { 0.0 } else { h });
        assert!(holed.zeros_warning().unwrap().to_string().starts_with("zeros: 100 of 16384 points are exactly 0"));
        let step_m = 2.0 * map.sq_m();
        for (other, name) in [
            (map.clone(), "measured"),
            (map.changed(|n, h| if n % 97 == 0 { 0.0 } else { h }), "single zeros"),
            (map.changed(|_, _| 0.0), "no relief"),
            (map.changed(|_, h| (h / step_m).round() * step_m - step_m), "coarse heights"),
            (map.changed(|n, h| if inside(n) { -1e-6 } else { h }), "a floor"),
        ] {
            assert_eq!(other.zeros_warning(), None, "{name}");
        }
    }

    #[test]
    fn pixels_of_which_a_side_is_in_another_unit_are_named() {
        let with = |dx_m, dy_m| HeightMap::new(2, 2, dx_m, dy_m, vec![0.0; 4]).unwrap().pixel_warning();
        for [dx_m, dy_m] in [[1e-6, 1e-6], [1e-6, 8e-6], [0.2e-9, 0.2e-9], [1e-4, 1e-5]] {
            assert_eq!(with(dx_m, dy_m), None);
        }
        for [dx_m, dy_m] in [[0.5e-6, 1.0 / 48.0], [1e-3, 1e-6], [1.0, 1.0], [1e-12, 1e-12]] {
            assert_eq!(with(dx_m, dy_m).map(|warning| warning.doubt), Some(MapDoubt::Pixels));
        }
        let said = with(0.5e-6, 1.0 / 48.0).unwrap().to_string();
        assert!(said.starts_with("pixels: pixels of 0.5 x 20833 um are implausible"), "{said}");
    }
}
