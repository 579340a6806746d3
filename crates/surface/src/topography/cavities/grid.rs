//! Arrangement of whole cavities: staggered rows, and grids rotated on the map.

use std::collections::BTreeMap;
use std::fmt;

use slipgrid_base::statistics::{mean_and_std, median};
use slipgrid_model::pattern::Arrangement;

use super::found::Found;
use super::period::middle_line;
use super::{Estimate, Spread};

/// Rows are staggered if at least this fraction of the pairs in neighbouring rows is shifted by half a pitch.
const MAX_PAIRS: f64 = 0.8;
/// A pair counts as shifted by half a pitch if its shift differs from half a pitch by less than this number of pitches.
const MAX_OFF_HALF: f64 = 0.15;
/// Maximum of the median offset between neighbours in a row, measured across the row, in pitches.
const MAX_DRIFT: f64 = 0.1;
/// Cavities in neighbouring rows form a pair if their shift along the rows is below this number of pitches.
const MAX_PAIR_OFFSET: f64 = 0.75;
/// Maximum deviation of the distance of two neighbouring rows from the median distance, relative to the median.
const MAX_ROW_OFF: f64 = 0.25;
/// Distance of hexagonal rows over their pitch, sqrt(3)/2.
const HEXAGONAL: f64 = 0.866_025_4;
/// Maximum relative deviation of the measured distance of rows from that of hexagonal rows.
const MAX_OFF_HEXAGONAL: f64 = 0.02;
/// Minimum rotation that is reported, in degrees: it changes a length by 0.02 %.
const MIN_TURN_DEG: f64 = 1.0;
/// Minimum rotation that is reported, in standard errors.
const MIN_ERRORS: f64 = 4.0;
/// Maximum difference of the rotations measured along x and along y, relative to the mean of both.
const MAX_SHEAR: f64 = 0.25;
/// Maximum area of the parallelogram between neighbours along x and along y, over the map area per cavity; the ratio is
/// two for second neighbours.
const MAX_CELL: f64 = 1.5;

/// Rows of which every second one is shifted by half a pitch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StaggeredRows {
    /// Whether rows run along y, as columns of the map. Rows of a pattern run along x.
    pub along_y: bool,
    /// Staggered, or hexagonal if rows are sqrt(3)/2 of a pitch apart.
    pub arrangement: Arrangement,
}

impl fmt::Display for StaggeredRows {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([row, rows], [along, across]) =
            if self.along_y { (["column", "columns"], ["y", "x"]) } else { (["row", "rows"], ["x", "y"]) };
        write!(
            f,
            "the {rows} are staggered: every second {row} is shifted along {along} by half a pitch, and the spacing along {across} \
             is the land to the next {row}, the key spacing_across_um of a pattern with arrangement = \"{}\"",
            Arrangement::Staggered
        )?;
        if self.arrangement == Arrangement::Hexagonal {
            write!(
                f,
                "; they are as far apart as those of arrangement = \"{}\", which has no such key",
                self.arrangement
            )?;
        }
        if self.along_y {
            f.write_str("; the rows of a pattern run along x, so that this map shows it turned by 90 degrees")?;
        }
        Ok(())
    }
}

/// A cavity that the map's sides do not cut.
#[derive(Clone, Copy)]
struct Whole {
    center_m: [f64; 2],
    width_m: [f64; 2],
}

/// Cavities that the map's sides do not cut, and pairs of these that face each other along x and along y.
pub(super) struct Grid {
    whole: BTreeMap<u32, Whole>,
    pairs: [Vec<[Whole; 2]>; 2],
    /// Map area per cavity, in square metres.
    cell_m2: f64,
}

impl Grid {
    /// Collects the cavities of `found` that the map's sides do not cut, and the pairs that face each other; `width_m`
    /// gives the widths of a region along x and y, in metres.
    pub(super) fn of(found: &Found, width_m: impl Fn(usize) -> [Option<f64>; 2]) -> Self {
        let centers_m = [0, 1].map(|axis| found.centers_m(axis));
        let regions = &found.regions;
        let mut whole = BTreeMap::new();
        let mut points = 0;
        for region in (1..=regions.count()).filter(|&region| found.is_whole(region)) {
            let [Some(x_m), Some(y_m)] = width_m(region) else { continue };
            let center_m = [0, 1].map(|axis| centers_m[axis][region]);
            // At most 2^28 regions: the cast is exact.
            whole.insert(region as u32, Whole { center_m, width_m: [x_m, y_m] });
            points += regions.points[region];
        }
        let pairs = [0, 1].map(|axis| {
            let both = |([one, other], _): ([u32; 2], f64)| Some([*whole.get(&one)?, *whole.get(&other)?]);
            found.neighbours(axis).into_iter().filter_map(both).collect()
        });
        // The cavity fraction of the map equals that of a cell.
        let share = regions.points.iter().sum::<usize>() as f64 / regions.label.len() as f64;
        let mean_m2 = points as f64 / whole.len() as f64 * found.pixel_m[0] * found.pixel_m[1];
        Self { whole, pairs, cell_m2: mean_m2 / share }
    }

    /// Returns the staggered rows and the width of the land between successive rows; `None` if rows are not staggered,
    /// or if successive rows overlap. Rows along x come first, because most staggered grids can be read either way.
    pub(super) fn staggered(&self) -> Option<(StaggeredRows, Spread)> {
        [0, 1].into_iter().filter_map(|axis| self.staggered_along(axis)).find(|(_, spacing)| spacing.mean_m > 0.0)
    }

    fn staggered_along(&self, along: usize) -> Option<(StaggeredRows, Spread)> {
        let across = 1 - along;
        let apart_m = |axis: usize| move |[one, other]: &[Whole; 2]| other.center_m[axis] - one.center_m[axis];
        let of_pairs = |axis: usize| median(&mut self.pairs[along].iter().map(apart_m(axis)).collect::<Vec<f64>>());
        let pitch_m = of_pairs(along)?.abs();
        if of_pairs(across)?.abs() > MAX_DRIFT * pitch_m {
            return None;
        }
        let mut sorted: Vec<Whole> = self.whole.values().copied().collect();
        sorted.sort_by(|one, other| one.center_m[across].total_cmp(&other.center_m[across]));
        // Cavities of other rows next to each one, the nearest row first.
        let beside = |number: usize| {
            let one = sorted[number];
            let pairs = sorted[number + 1..].iter().map(move |&other| [one, other]);
            pairs.filter(move |pair| apart_m(along)(pair).abs() < MAX_PAIR_OFFSET * pitch_m)
        };
        let mut rows_m: Vec<f64> =
            (0..sorted.len()).filter_map(|number| beside(number).next().map(|pair| apart_m(across)(&pair))).collect();
        let row_m = median(&mut rows_m)?;
        let next_row: Vec<[Whole; 2]> = (0..sorted.len())
            .flat_map(|number| {
                let before = |pair: &[Whole; 2]| apart_m(across)(pair) < (1.0 + MAX_ROW_OFF) * row_m;
                beside(number).take_while(before)
            })
            .filter(|pair| apart_m(across)(pair) > (1.0 - MAX_ROW_OFF) * row_m)
            .collect();
        let is_half = |pair: &&[Whole; 2]| (apart_m(along)(pair).abs() / pitch_m - 0.5).abs() < MAX_OFF_HALF;
        if (next_row.iter().filter(is_half).count() as f64) < MAX_PAIRS * next_row.len() as f64 {
            return None;
        }
        let land_m =
            |pair: &[Whole; 2]| apart_m(across)(pair) - 0.5 * (pair[0].width_m[across] + pair[1].width_m[across]);
        let spacing = Spread::of(next_row.iter().map(land_m))?;
        let is_hexagonal = (row_m / (HEXAGONAL * pitch_m) - 1.0).abs() < MAX_OFF_HEXAGONAL;
        let arrangement = if is_hexagonal { Arrangement::Hexagonal } else { Arrangement::Staggered };
        Some((StaggeredRows { along_y: along == 1, arrangement }, spacing))
    }

    /// Rotation of a rectangular grid on the map, in degrees from x towards y; `None` if it is not rotated, or if
    /// cavities do not face their neighbours along both axes.
    pub(super) fn turned_deg(&self) -> Option<Estimate> {
        let apart_m = |[one, other]: &[Whole; 2]| [0, 1].map(|axis| other.center_m[axis] - one.center_m[axis]);
        let mut turns = [(0.0, 0.0); 2];
        let mut mean_m = [[0.0; 2]; 2];
        for axis in [0, 1] {
            let pairs = &self.pairs[axis];
            let turn_deg = |pair: &[Whole; 2]| {
                let [x_m, y_m] = apart_m(pair);
                if axis == 0 { libm::atan2(y_m, x_m) } else { libm::atan2(-x_m, y_m) }.to_degrees()
            };
            let (value, std) = mean_and_std(pairs.iter().map(turn_deg))?;
            turns[axis] = (value, std? / (pairs.len() as f64).sqrt());
            mean_m[axis] = [0, 1].map(|k| pairs.iter().map(|pair| apart_m(pair)[k]).sum::<f64>() / pairs.len() as f64);
        }
        let [(x_deg, x_error), (y_deg, y_error)] = turns;
        let (value, error) = (0.5 * (x_deg + y_deg), 0.5 * x_error.hypot(y_error));
        let [[ax, ay], [bx, by]] = mean_m;
        let faces_next = (ax * by - ay * bx).abs() < MAX_CELL * self.cell_m2;
        let is_turn = value.abs() >= MIN_TURN_DEG.max(MIN_ERRORS * error);
        let is_rigid = (x_deg - y_deg).abs() <= MAX_SHEAR * value.abs();
        (faces_next && is_turn && is_rigid).then_some(Estimate { value, error: Some(error) })
    }
}

/// Rotation of grooves on the map, in degrees from x towards y; `None` if they are not rotated.
pub(super) fn grooves_turned_deg(found: &Found) -> Option<Estimate> {
    let turns_deg = [0, 1].into_iter().flat_map(|axis| {
        let is_groove = move |region: &usize| found.counts(axis, *region) && !found.counts(1 - axis, *region);
        let grooves = (1..=found.regions.count()).filter(is_groove);
        grooves.map(move |groove| {
            let turn_deg = libm::atan(middle_line(found, axis, groove)[1] / found.pixel_m[1 - axis]).to_degrees();
            // Grooves along y turn against dx/dy.
            if axis == 0 { -turn_deg } else { turn_deg }
        })
    });
    let turns_deg: Vec<f64> = turns_deg.collect();
    Estimate::mean(turns_deg.iter().copied())
        .filter(|turn| turn.value.abs() >= MIN_TURN_DEG.max(MIN_ERRORS * turn.error.unwrap_or_default()))
}

#[cfg(test)]
mod tests {
    use slipgrid_base::monitor::Unwatched;

    use super::*;
    use crate::topography::form::Form;
    use crate::topography::{CavityMetrology, HeightMap};

    /// Rectangles or ellipses of `width_um` on a grid of `pitch_um`, with every second row along x shifted by `shift`
    /// pitches, rotated by `turn_deg`, on 500 x 600 pixels of 2 um.
    struct Cut {
        round: bool,
        width_um: [f64; 2],
        pitch_um: [f64; 2],
        shift: f64,
        turn_deg: f64,
    }

    const STAGGERED: Cut =
        Cut { round: false, width_um: [60.0, 120.0], pitch_um: [160.0, 240.0], shift: 0.5, turn_deg: 0.0 };

    impl Cut {
        fn map(&self) -> HeightMap {
            let (sin, cos) = self.turn_deg.to_radians().sin_cos();
            let height = |n: usize| {
                let (x, y) = (2.0 * (n / 600) as f64 + 37.0, 2.0 * (n % 600) as f64 + 23.0);
                let (x, y) = (cos * x + sin * y, cos * y - sin * x);
                let row = (y / self.pitch_um[1]).floor();
                let x = x - self.shift * self.pitch_um[0] * row.rem_euclid(2.0);
                let [u, v] = [(x, 0), (y, 1)]
                    .map(|(at, axis)| (at.rem_euclid(self.pitch_um[axis]) - 0.5 * self.pitch_um[axis]).abs());
                let [a, b] = self.width_um.map(|width_um| 0.5 * width_um);
                let inside_um = if self.round { a - u.hypot(v) } else { (a - u).min(b - v) };
                -6e-6 * (inside_um / 8.0 + 0.5).clamp(0.0, 1.0)
            };
            HeightMap::new(500, 600, 2e-6, 2e-6, (0..300_000).map(height).collect()).unwrap()
        }

        fn measured(&self) -> CavityMetrology {
            self.map().measure_cavities(Form::Plane, &Unwatched).unwrap()
        }
    }

    /// Agreement within a quarter of a pixel.
    fn close(spacing: Option<Spread>, expected_um: f64) {
        let spacing = spacing.unwrap();
        assert!(
            (spacing.mean_m * 1e6 - expected_um).abs() < 0.5 && spacing.std_m < 0.2e-6,
            "{expected_um}: {spacing:?}"
        );
        assert!(spacing.count >= 10, "{spacing:?}");
    }

    #[test]
    fn the_spacing_across_staggered_rows_is_the_land_to_the_next_row() {
        let wide = Cut { width_um: [120.0, 60.0], pitch_um: [160.0, 100.0], ..STAGGERED };
        let hexagonal = Cut { round: true, width_um: [100.0; 2], pitch_um: [180.0, 155.884_572_7], ..STAGGERED };
        // Discs that face no other along y on most of their lines.
        let discs = Cut { round: true, width_um: [120.0; 2], pitch_um: [160.0, 160.0], ..STAGGERED };
        for (cut, spacing_um, arrangement) in [
            (STAGGERED, [100.0, 120.0], Arrangement::Staggered),
            (wide, [40.0, 40.0], Arrangement::Staggered),
            (hexagonal, [80.0, 55.884_572_7], Arrangement::Hexagonal),
            (discs, [40.0, 40.0], Arrangement::Staggered),
        ] {
            let found = cut.measured();
            assert_eq!(found.staggered, Some(StaggeredRows { along_y: false, arrangement }));
            assert_eq!(found.turned_deg, None);
            for (spacing, expected_um) in found.spacing.into_iter().zip(spacing_um) {
                close(spacing, expected_um);
            }
            let said = found.staggered.unwrap().to_string();
            assert!(said.contains(&format!("arrangement = \"{arrangement}\"")), "{said}");
        }
    }

    #[test]
    fn columns_are_staggered_where_rows_along_x_would_overlap() {
        let map = Cut { width_um: [60.0, 60.0], pitch_um: [100.0, 76.0], ..STAGGERED }.map().transposed();
        let found = map.measure_cavities(Form::Plane, &Unwatched).unwrap();
        assert_eq!(found.staggered, Some(StaggeredRows { along_y: true, arrangement: Arrangement::Staggered }));
        close(found.spacing[0], 16.0);
        close(found.spacing[1], 40.0);
        assert!(found.staggered.unwrap().to_string().starts_with("the columns are staggered"));
    }

    #[test]
    fn rows_that_are_not_shifted_by_half_a_pitch_are_not_staggered() {
        for (shift, turn_deg) in [(0.0, 0.0), (0.3, 0.0), (0.0, 24.0)] {
            let cut = Cut { width_um: [90.0; 2], pitch_um: [200.0, 150.0], shift, turn_deg, ..STAGGERED };
            assert_eq!(cut.measured().staggered, None, "{shift} {turn_deg}");
        }
    }

    #[test]
    fn turned_grooves_have_their_angle() {
        for turn_deg in [-20.0, -7.0, 0.0, 0.5, 2.0, 7.0] {
            let cut = Cut { width_um: [90.0, 1e9], pitch_um: [200.0, 1e6], shift: 0.0, turn_deg, ..STAGGERED };
            let map = cut.map();
            // The transposed map is mirrored.
            for (map, sign) in [(map.transposed(), -1.0), (map, 1.0)] {
                let turned_deg = map.measure_cavities(Form::Plane, &Unwatched).unwrap().turned_deg;
                if turn_deg.abs() < 1.0 {
                    assert_eq!(turned_deg, None);
                } else {
                    let value = sign * turned_deg.unwrap().value;
                    assert!((value - turn_deg).abs() < 0.02, "{turn_deg}: {value}");
                }
            }
        }
    }

    #[test]
    fn a_turned_grid_has_its_angle() {
        for turn_deg in [-12.0, -2.0, 0.0, 0.5, 6.0] {
            let cut = Cut { width_um: [90.0; 2], pitch_um: [200.0; 2], shift: 0.0, turn_deg, ..STAGGERED };
            let turned_deg = cut.measured().turned_deg;
            if turn_deg.abs() < 1.0 {
                assert_eq!(turned_deg, None);
            } else {
                let Estimate { value, error } = turned_deg.unwrap();
                assert!((value - turn_deg).abs() < 0.1 && error.unwrap() < 0.1, "{turn_deg}: {value} +- {error:?}");
            }
        }
        // At 30 deg squares face others than their neighbours.
        let cut = Cut { width_um: [90.0; 2], pitch_um: [200.0; 2], shift: 0.0, turn_deg: 30.0, ..STAGGERED };
        assert_eq!(cut.measured().turned_deg, None);
    }
}
