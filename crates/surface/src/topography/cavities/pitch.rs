//! Pitches of a grid of cavities along the map's sides.

use slipgrid_base::statistics::median;

use super::found::Found;

/// Maximum deviation of the shift of neighbours in staggered rows from half a pitch, in pitches.
const MAX_OFF_HALF: f64 = 0.1;

/// Pitches along both axes, in metres, of the cavities `whole` with the given centres; `None` for an axis along which
/// no neighbours determine the pitch.
///
/// The pitch along an axis is the distance of neighbours that face each other along it. In staggered rows wide cavities
/// hide the ones behind them; then the pitch is twice the distance along the axis between neighbours in successive
/// rows.
pub(super) fn pitches_m(found: &Found, centers_m: &[Vec<f64>; 2], whole: &[usize]) -> [Option<f64>; 2] {
    let mut is_whole = vec![false; centers_m[0].len()];
    whole.iter().for_each(|&region| is_whole[region] = true);
    let apart_m = |pair: [u32; 2]| {
        let [one, other] = pair.map(|region| region as usize);
        (is_whole[one] && is_whole[other])
            .then(|| [0, 1].map(|axis: usize| (centers_m[axis][other] - centers_m[axis][one]).abs()))
    };
    let faced_m = [0, 1].map(|axis| {
        let pairs = found.neighbours(axis).into_iter().filter_map(|(pair, _)| apart_m(pair));
        positive_median(pairs.map(|apart_m| apart_m[axis]))
    });
    [0, 1].map(|axis| {
        faced_m[axis].or_else(|| {
            let hidden_m: Vec<f64> = match faced_m[1 - axis] {
                Some(pitch_m) => {
                    let is_shifted = |apart_m: &[f64; 2]| (apart_m[1 - axis] / pitch_m - 0.5).abs() <= MAX_OFF_HALF;
                    let pairs = found.gaps(axis).into_keys().filter_map(apart_m).filter(is_shifted);
                    pairs.map(|apart_m| apart_m[axis]).collect()
                }
                None => nearest_m(found, is_whole.len(), apart_m).into_iter().map(|apart_m| apart_m[axis]).collect(),
            };
            positive_median(hidden_m.into_iter()).map(|half_m| 2.0 * half_m)
        })
    })
}

/// Distances along both axes between each cavity and the nearest one that it faces on any line.
fn nearest_m(
    found: &Found,
    regions: usize,
    apart_m: impl Fn([u32; 2]) -> Option<[f64; 2]>,
) -> impl IntoIterator<Item = [f64; 2]> {
    let length_m = |[x_m, y_m]: [f64; 2]| x_m.hypot(y_m);
    let mut nearest: Vec<Option<[f64; 2]>> = vec![None; regions];
    for pair in [0, 1].into_iter().flat_map(|axis| found.gaps(axis).into_keys()) {
        let Some(own_m) = apart_m(pair) else { continue };
        for region in pair {
            let known = &mut nearest[region as usize];
            if known.is_none_or(|known_m| length_m(own_m) < length_m(known_m)) {
                *known = Some(own_m);
            }
        }
    }
    nearest.into_iter().flatten()
}

fn positive_median(values: impl Iterator<Item = f64>) -> Option<f64> {
    median(&mut values.collect::<Vec<_>>()).filter(|&value| value > 0.0)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use slipgrid_base::monitor::Unwatched;

    use crate::topography::{Arrangement, Form, HeightMap, MeanPeriod};

    /// Discs of a given diameter in staggered rows, on 260 x 420 pixels of 1 um: rows are `row_um` apart along x, discs
    /// in a row `pitch_um` along y.
    fn staggered([row_um, pitch_um]: [f64; 2], shift: f64, diameter_um: f64) -> HeightMap {
        let height = |n: usize| {
            let (x, y) = ((n / 420) as f64 + 0.5 - 11.0, (n % 420) as f64 + 0.5 - 7.0);
            let row = (x / row_um).floor();
            let away = [row - 1.0, row, row + 1.0, row + 2.0].map(|row| {
                let along = y / pitch_um - shift * row.rem_euclid(2.0);
                (x - row * row_um).hypot((along - along.round()) * pitch_um)
            });
            -5e-6 * (0.5 * diameter_um + 0.5 - away.into_iter().fold(f64::INFINITY, f64::min)).clamp(0.0, 1.0)
        };
        HeightMap::new(260, 420, 1e-6, 1e-6, (0..260 * 420).map(height).collect()).unwrap()
    }

    /// Asserts that adjacent copies match and have two discs each.
    fn check_tiles(period: &MeanPeriod, [along_um, across_um]: [f64; 2], diameter_um: f64) {
        let map = &period.map;
        let (rows, cols) = (map.rows(), map.cols());
        let sides_um = [rows as f64 * map.dx_m(), cols as f64 * map.dy_m()].map(|side_m| side_m * 1e6);
        assert!((sides_um[0] - along_um).abs() < 0.2 && (sides_um[1] - across_um).abs() < 0.2, "{sides_um:?}");
        assert_eq!(map.missing(), 0);
        let depth = |i: usize, j: usize| -map.heights_m()[(i % rows) * cols + j % cols] / 5e-6;
        let deep = (0..rows * cols).filter(|n| depth(n / cols, n % cols) > 0.5).count();
        let taken = deep as f64 / (rows * cols) as f64;
        let share = 2.0 * 0.25 * PI * diameter_um.powi(2) / (along_um * across_um);
        assert!((taken / share - 1.0).abs() < 0.02, "{taken} {share}");
        // Shifted by half of both sides, across the seams, the period equals itself, except for walls of a pixel.
        let moved = |i: usize, j: usize| depth(i + rows.div_ceil(2), j + cols.div_ceil(2));
        let differ = (0..rows * cols).filter(|n| (depth(n / cols, n % cols) - moved(n / cols, n % cols)).abs() > 0.9);
        assert!(differ.count() < rows * cols / 100);
    }

    #[test]
    fn wide_discs_in_staggered_rows_have_a_period_although_they_hide_those_behind_them() {
        // Hidden along x; along y; along both.
        for (rows_um, diameter_um) in [([52.0, 60.0], 44.0), ([35.0, 80.0], 50.0), ([40.0, 80.0], 54.0)] {
            let map = staggered(rows_um, 0.5, diameter_um);
            for (map, turned) in [(map.transposed(), true), (map, false)] {
                let period = map.mean_cavity_period(Form::Mean, &Unwatched).unwrap();
                assert_eq!(period.arrangement, Arrangement::Staggered);
                let mut sides_um = [2.0 * rows_um[0], rows_um[1]];
                if turned {
                    sides_um.reverse();
                }
                check_tiles(&period, sides_um, diameter_um);
            }
        }
    }

    #[test]
    fn rows_that_are_shifted_by_another_share_have_none() {
        for (shift, diameter_um, reason) in [
            (0.35, 40.0, "every second row is shifted by another share of the pitch than half"),
            (0.38, 46.0, "neither in a rectangular nor in a staggered grid"),
        ] {
            let refused = staggered([52.0, 60.0], shift, diameter_um).mean_cavity_period(Form::Mean, &Unwatched);
            let said = refused.unwrap_err().to_string();
            assert!(said.contains(reason), "{shift}: {said}");
        }
    }
}
