//! Mean period of a pattern: the average of all cavities about their centres.

use std::fmt;

use slipgrid_base::monitor::Monitor;
use slipgrid_base::statistics::median;
use slipgrid_base::units::tidy;

use super::Crossing;
use super::found::Found;
use super::pitch::pitches_m;
use crate::topography::form::Form;
use crate::topography::{HeightMap, MapError};

/// Minimum number of whole cavities, or of grooves, for a mean period.
const LEAST: usize = 2;
/// Reason for which fewer than [`LEAST`] have no mean period.
const TOO_FEW: &str = "expected at least two that the map's sides do not cut off";
/// Maximum deviation of a centre from its lattice position, in pitches; at half a pitch it would belong to another
/// position.
const MAX_STRAY: f64 = 0.2;
/// Maximum deviation of the mean shift of every second row from half a pitch, in pitches.
const MAX_SHIFT: f64 = 0.05;
/// A pixel of the period counts as land if at least this fraction of its weight comes from land.
const ALL_LAND: f64 = 0.999;

/// Arrangement of the cavities.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Arrangement {
    /// Grooves along y; the period is their pitch along x.
    GroovesAlongY,
    /// Grooves along x; the period is their pitch along y.
    GroovesAlongX,
    /// A rectangular grid; the period is one cell.
    Rectangular,
    /// Every second row shifted by half a pitch, as in a hexagonal grid; the period is the rectangle with two cavities.
    Staggered,
}

impl fmt::Display for Arrangement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::GroovesAlongY => "grooves along y",
            Self::GroovesAlongX => "grooves along x",
            Self::Rectangular => "a rectangular grid",
            Self::Staggered => "a staggered grid",
        })
    }
}

/// Mean period of a pattern.
#[derive(Clone, Debug, PartialEq)]
pub struct MeanPeriod {
    /// Heights above the land, in metres, over one period, with a cavity's centre in the middle of the map.
    ///
    /// The land beyond the rims has mean height 0. Pixels are those of the measured map, adjusted to a whole number per
    /// period. The period of grooves is a square with their pitch as side and equal heights along the grooves. NaN if
    /// no cavity has a height.
    pub map: HeightMap,
    /// Arrangement of the cavities.
    pub arrangement: Arrangement,
    /// Number of averaged cavities, which are those that the map's sides do not cut.
    pub cavities: usize,
    /// Remaining roughness of the land: root mean square height of the mean period's land, in metres, which is the
    /// standard error of the mean relief; `None` if there is no land beyond the rims.
    pub relief_left_m: Option<f64>,
}

impl MeanPeriod {
    /// Description for the header of a file, one line each. The phrase "one period" marks the map as periodic for
    /// readers.
    pub fn description(&self) -> [String; 3] {
        let um = |length_m: f64| tidy((length_m * 1e10).round() / 1e4);
        let sides_m = [self.map.rows() as f64 * self.map.dx_m(), self.map.cols() as f64 * self.map.dy_m()];
        [
            "mean period of measured cavities, by slipgrid".to_owned(),
            format!(
                "{} cavities averaged about their centres, {}: x {} um, y {} um, heights above the land, cavity in the middle",
                self.cavities,
                self.arrangement,
                um(sides_m[0]),
                um(sides_m[1])
            ),
            "one period: opposite sides continue each other".to_owned(),
        ]
    }
}

impl HeightMap {
    /// Averages the cavities to a mean period; `form` is fitted to the land and subtracted.
    ///
    /// The surroundings of each cavity are shifted by the sub-pixel position of its centre with linear interpolation of
    /// heights, those of a groove by the position of its straight middle line. Missing points are left out of means.
    ///
    /// # Errors
    /// [`MapError`] as for [`Self::measure_cavities`], and [`MapError::NoPeriod`] for fewer than two whole cavities and
    /// for arrangements other than [`Arrangement`].
    pub fn mean_cavity_period(&self, form: Form, monitor: &dyn Monitor) -> Result<MeanPeriod, MapError> {
        let (found, is_land) = self.found_land(form, monitor)?;
        let regions = || 1..=found.regions.count();
        let along: [Vec<usize>; 2] =
            [0, 1].map(|axis| regions().filter(|&region| found.counts(axis, region)).collect());
        let whole: Vec<usize> = regions().filter(|&region| found.is_whole(region)).collect();
        let grooves = [0, 1].map(|axis| along[axis].len() - whole.len());
        let most = whole.len().max(grooves[0]).max(grooves[1]);
        if most < LEAST {
            return Err(match Crossing::of(&found, monitor)? {
                Some(crossing) => MapError::Crossing(crossing),
                None => MapError::NoPeriod { whole: most, reason: TOO_FEW },
            });
        }
        if whole.len() >= grooves[0].max(grooves[1]) {
            return of_cells(&found, &is_land, &whole, monitor);
        }
        let axis = usize::from(grooves[1] > grooves[0]);
        of_grooves(&found, &is_land, axis, &along[axis], monitor)
    }
}

/// For each complete chord of `region` along `axis`: index of its pixel line, and its middle in metres from the first
/// pixel's centre.
fn middles(found: &Found, axis: usize, region: usize) -> impl Iterator<Item = (f64, f64)> {
    let chords = found.chords[axis].iter().filter(move |chord| chord.region as usize == region);
    chords.filter_map(move |chord| {
        let (from, to) = chord.from.zip(chord.to)?;
        Some((chord.line as f64, 0.5 * (from + to) * found.pixel_m[axis]))
    })
}

/// Middle line of a groove whose width lies along `axis`: position in metres at a pixel line, `[a, b]` of a + b line.
pub(super) fn middle_line(found: &Found, axis: usize, groove: usize) -> [f64; 2] {
    let points: Vec<(f64, f64)> = middles(found, axis, groove).collect();
    line_through(points.iter().copied())
}

/// Fits the least-squares line y = a + b x to `points`; returns `[a, b]`.
pub(super) fn line_through(points: impl Iterator<Item = (f64, f64)> + Clone) -> [f64; 2] {
    let count = points.clone().count() as f64;
    let [x, y] = points.clone().fold([0.0; 2], |[sx, sy], (x, y)| [sx + x / count, sy + y / count]);
    let xx: f64 = points.clone().map(|point| (point.0 - x).powi(2)).sum();
    let xy: f64 = points.map(|point| (point.0 - x) * (point.1 - y)).sum();
    let slope = if xx > 0.0 { xy / xx } else { 0.0 };
    [y - slope * x, slope]
}

/// Weighted sum of heights in metres, sum of weights, and sum of the weights of land, for each pixel of a period.
struct Cells {
    sum: Vec<f64>,
    weight: Vec<f64>,
    land: Vec<f64>,
}

impl Cells {
    fn new(count: usize) -> Self {
        Self { sum: vec![0.0; count], weight: vec![0.0; count], land: vec![0.0; count] }
    }

    /// Adds to `cell` the bilinearly interpolated height at a position in pixels from the first point's centre; missing
    /// points are left out.
    fn add(&mut self, cell: usize, found: &Found, is_land: &[bool], place: [f64; 2]) {
        let rows = found.land.height_m.len() / found.cols();
        let inside = |place: f64, count: usize| (0.0..=(count - 1) as f64).contains(&place);
        if !inside(place[0], rows) || !inside(place[1], found.cols()) {
            return;
        }
        let near = place.map(f64::floor);
        for (di, dj) in [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)] {
            // 1 - |distance| along both axes
            let weight = (1.0 - (near[0] + di - place[0]).abs()) * (1.0 - (near[1] + dj - place[1]).abs());
            let n = (near[0] + di) as usize * found.cols() + (near[1] + dj) as usize;
            if weight > 0.0 && !found.land.height_m[n].is_nan() {
                self.sum[cell] += weight * found.land.height_m[n];
                self.weight[cell] += weight;
                self.land[cell] += if is_land[n] { weight } else { 0.0 };
            }
        }
    }

    /// Mean heights above the land, and the root mean square height of the land, both in metres; the latter is `None`
    /// without land.
    fn mean(self) -> (Vec<f64>, Option<f64>) {
        let mut height_m: Vec<f64> = self
            .sum
            .iter()
            .zip(&self.weight)
            .map(|(sum, &weight)| if weight > 0.0 { sum / weight } else { f64::NAN })
            .collect();
        let is_land = |cell: &usize| self.weight[*cell] > 0.0 && self.land[*cell] >= ALL_LAND * self.weight[*cell];
        let land: Vec<f64> = (0..height_m.len()).filter(is_land).map(|cell| height_m[cell]).collect();
        let Some((level_m, std_m)) = slipgrid_base::statistics::mean_and_std(land.iter().copied()) else {
            return (height_m, None);
        };
        for height in &mut height_m {
            *height -= level_m;
        }
        (height_m, std_m)
    }
}

/// Number of pixels per pitch, and the pixel size, in metres, for which this number is whole.
fn pixels(pitch_m: f64, pixel_m: f64) -> (usize, f64) {
    // A pitch lies within the map: the cast is exact.
    let count = ((pitch_m / pixel_m).round() as usize).max(2);
    (count, pitch_m / count as f64)
}

/// Mean period of grooves whose widths lie along `axis`.
fn of_grooves(
    found: &Found,
    is_land: &[bool],
    axis: usize,
    grooves: &[usize],
    monitor: &dyn Monitor,
) -> Result<MeanPeriod, MapError> {
    let rows = found.land.height_m.len() / found.cols();
    let lines = if axis == 0 { found.cols() } else { rows };
    let middle: Vec<[f64; 2]> = grooves.iter().map(|&groove| middle_line(found, axis, groove)).collect();
    // Turned grooves are longer along the axis than across, by 1 / cos.
    let slope = middle.iter().map(|[_, b]| b).sum::<f64>() / (middle.len() as f64 * found.pixel_m[1 - axis]);
    let stretch = slope.hypot(1.0);
    let mut centers: Vec<f64> = middle.iter().map(|[a, b]| a + b * 0.5 * (lines - 1) as f64).collect();
    centers.sort_by(f64::total_cmp);
    let mut gaps: Vec<f64> = centers.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let refuse = |reason| Err(MapError::NoPeriod { whole: grooves.len(), reason });
    let Some(typical_m) = median(&mut gaps).filter(|gap_m| *gap_m > 0.0) else {
        return refuse(TOO_FEW);
    };
    // Undetected grooves leave gaps of several pitches.
    let mut index = 0.0;
    let mut places = vec![(0.0, centers[0])];
    for pair in centers.windows(2) {
        index += ((pair[1] - pair[0]) / typical_m).round();
        places.push((index, pair[1]));
    }
    let [first_m, pitch_m] = line_through(places.iter().copied());
    if places.iter().any(|(index, at_m)| (at_m - first_m - index * pitch_m).abs() > MAX_STRAY * pitch_m) {
        return refuse("grooves stray from even distances by more than a fifth of their pitch");
    }
    let (count, pixel_m) = pixels(pitch_m / stretch, found.pixel_m[axis]);
    let mut cells = Cells::new(count);
    for [a, b] in middle {
        for line in 0..lines {
            monitor.heed()?;
            let center_m = a + b * line as f64;
            for cell in 0..count {
                let at = (center_m + stretch * (cell as f64 + 0.5) * pixel_m - 0.5 * pitch_m) / found.pixel_m[axis];
                cells.add(cell, found, is_land, if axis == 0 { [at, line as f64] } else { [line as f64, at] });
            }
        }
    }
    let (profile_m, relief_left_m) = cells.mean();
    let height_m = (0..count * count).map(|n| profile_m[if axis == 0 { n / count } else { n % count }]).collect();
    Ok(MeanPeriod {
        map: HeightMap::new(count, count, pixel_m, pixel_m, height_m)?,
        arrangement: [Arrangement::GroovesAlongY, Arrangement::GroovesAlongX][axis],
        cavities: grooves.len(),
        relief_left_m,
    })
}

/// Mean period of cavities that end within the map along both axes.
fn of_cells(found: &Found, is_land: &[bool], whole: &[usize], monitor: &dyn Monitor) -> Result<MeanPeriod, MapError> {
    let refuse = |reason| Err(MapError::NoPeriod { whole: whole.len(), reason });
    let centers_m = [0, 1].map(|axis| found.centers_m(axis));
    let [Some(x_m), Some(y_m)] = pitches_m(found, &centers_m, whole) else {
        return refuse(
            "expected two that face each other along x, and two along y, or rows each shifted by half a pitch from the next",
        );
    };
    let mut pitch_m = [x_m, y_m];
    // Positions in half pitches, and the pitches that fit them all.
    let mut places: [Vec<(f64, f64)>; 2] = [Vec::new(), Vec::new()];
    for (axis, places) in places.iter_mut().enumerate() {
        let mut first_m = centers_m[axis][whole[0]];
        for _ in 0..2 {
            let place = |at_m: f64| (2.0 * (at_m - first_m) / pitch_m[axis]).round();
            *places = whole.iter().map(|&region| (place(centers_m[axis][region]), centers_m[axis][region])).collect();
            let [a, b] = line_through(places.iter().copied());
            (first_m, pitch_m[axis]) = (a, 2.0 * b);
        }
        let stray = |(place, at_m): &(f64, f64)| (at_m - first_m - 0.5 * pitch_m[axis] * place).abs();
        if places.iter().any(|place| stray(place) > MAX_STRAY * pitch_m[axis]) {
            return refuse("they stray from a rectangular and from a staggered grid by more than a fifth of a pitch");
        }
    }
    // A staggered grid has a cavity where both numbers of half pitches are odd.
    let odd = |axis: usize, number: usize| (places[axis][number].0 - places[axis][0].0).rem_euclid(2.0) == 1.0;
    let both: Vec<[bool; 2]> = (0..whole.len()).map(|number| [odd(0, number), odd(1, number)]).collect();
    if both.iter().any(|[x, y]| x != y) {
        return refuse("they are arranged neither in a rectangular nor in a staggered grid");
    }
    let arrangement = if both.contains(&[true, true]) { Arrangement::Staggered } else { Arrangement::Rectangular };
    if arrangement == Arrangement::Staggered {
        // The mean deviations of the odd and the even rows differ if the shift is not half a pitch.
        let is_off = |axis: usize| {
            let stray_m = |is_between: bool| {
                let own = places[axis].iter().zip(&both).filter(|(_, [x, _])| *x == is_between);
                let strays: Vec<f64> = own.map(|((place, at_m), _)| at_m - 0.5 * pitch_m[axis] * place).collect();
                strays.iter().sum::<f64>() / strays.len() as f64
            };
            (stray_m(true) - stray_m(false)).abs() > MAX_SHIFT * pitch_m[axis]
        };
        if is_off(0) || is_off(1) {
            return refuse(
                "every second row is shifted by another share of the pitch than half: the mean would not tile",
            );
        }
    }
    let [(rows, dx_m), (cols, dy_m)] = [0, 1].map(|axis| pixels(pitch_m[axis], found.pixel_m[axis]));
    let mut cells = Cells::new(rows * cols);
    for &region in whole {
        for cell in 0..rows * cols {
            if cell % cols == 0 {
                monitor.heed()?;
            }
            let from_center_m = [
                ((cell / cols) as f64 + 0.5) * dx_m - 0.5 * pitch_m[0],
                ((cell % cols) as f64 + 0.5) * dy_m - 0.5 * pitch_m[1],
            ];
            let place = [0, 1].map(|axis| (centers_m[axis][region] + from_center_m[axis]) / found.pixel_m[axis]);
            cells.add(cell, found, is_land, place);
        }
    }
    let (height_m, relief_left_m) = cells.mean();
    Ok(MeanPeriod {
        map: HeightMap::new(rows, cols, dx_m, dy_m, height_m)?,
        arrangement,
        cavities: whole.len(),
        relief_left_m,
    })
}

#[cfg(test)]
mod tests {
    use slipgrid_base::monitor::Unwatched;

    use super::super::cut::tests::GROOVES;
    use super::*;
    use crate::topography::{CutPattern, CutRim, CutShape, RimProfile, SelfAffine};

    const PATTERN: CutPattern = CutPattern {
        shape: CutShape::Square,
        width_m: 60e-6,
        spacing_m: 141e-6,
        depth_m: 5.2e-6,
        wall_m: 10e-6,
        pitch_std_m: 2e-6,
        rim: Some(CutRim { height_m: 1e-6, width_m: 16e-6, profile: RimProfile::Flat, height_std_m: 0.0 }),
        seed: 5,
        ..GROOVES
    };

    /// A rough, tilted map of 2 um pixels, 1.024 mm wide, with one of 17 points missing.
    fn rough(pattern: &CutPattern) -> HeightMap {
        let mut map = SelfAffine { side_m: 1.024e-3, ..SelfAffine::STAND_IN }.map().unwrap();
        map.cut_cavities(pattern).unwrap();
        map.changed(|n, height| if n * 7919 % 17 == 0 { f64::NAN } else { height + 10e-6 * (n / 512) as f64 / 512.0 })
    }

    /// Minimum and maximum height within a square ring of distances from the middle, along x and y.
    fn range_um(map: &HeightMap, [from_um, to_um]: [f64; 2], axes: &[usize]) -> [f64; 2] {
        let (rows, cols) = (map.rows() as f64, map.cols());
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for (n, &height) in map.heights_m().iter().enumerate() {
            let place = [
                ((n / cols) as f64 + 0.5 - 0.5 * rows) * map.dx_m() * 1e6,
                ((n % cols) as f64 + 0.5 - 0.5 * cols as f64) * map.dy_m() * 1e6,
            ];
            let distance_um = axes.iter().map(|&axis| place[axis].abs()).fold(0.0, f64::max);
            let beside_um = axes.iter().map(|&axis| place[axis].abs()).fold(f64::INFINITY, f64::min);
            // Rims are rounded at corners, so only points in front of a side are used.
            if (from_um..to_um).contains(&distance_um) && (axes.len() == 1 || beside_um < 30.0 || to_um <= 30.0) {
                range = [range[0].min(height * 1e6), range[1].max(height * 1e6)];
            }
        }
        range
    }

    #[test]
    fn squares_have_a_cell_with_floor_rim_and_land_where_they_belong() {
        let period = rough(&PATTERN).mean_cavity_period(Form::Plane, &Unwatched).unwrap();
        assert_eq!((period.arrangement, period.cavities), (Arrangement::Rectangular, 25));
        let map = &period.map;
        for (count, pixel_m) in [(map.rows(), map.dx_m()), (map.cols(), map.dy_m())] {
            // Centres deviate by 2/sqrt 2 um: five of them determine the pitch to 0.45 um.
            assert!((count as f64 * pixel_m * 1e6 - 201.0).abs() < 1.0 && (pixel_m / 2e-6 - 1.0).abs() < 0.02);
        }
        // Remainder of 0.2 um of roughness in 25 cells.
        let left_um = period.relief_left_m.unwrap() * 1e6;
        assert!((0.015..0.06).contains(&left_um), "{left_um}");
        let off = 4.0 * left_um;
        for (ring, height) in [([0.0, 22.0], -5.2), ([38.0, 48.0], 1.0), ([55.0, 95.0], 0.0)] {
            let [low, high] = range_um(map, ring, &[0, 1]);
            assert!(low > height - off && high < height + off, "{ring:?}: {low} to {high}");
        }
        assert_eq!(map.missing(), 0);
        assert!(
            period.description()[1].starts_with("25 cavities averaged about their centres, a rectangular grid: x 20")
        );
    }

    #[test]
    fn grooves_have_one_profile_on_a_square_whichever_way_they_run() {
        let along_y = rough(&CutPattern { shape: CutShape::Groove, ..PATTERN });
        let period = along_y.mean_cavity_period(Form::Plane, &Unwatched).unwrap();
        assert_eq!((period.arrangement, period.cavities), (Arrangement::GroovesAlongY, 5));
        assert_eq!(period.map.rows(), period.map.cols());
        let row = period.map.heights_m()[40 * period.map.cols()..41 * period.map.cols()].to_vec();
        assert!(row.iter().all(|height| *height == row[0]));
        for (ring, height) in [([0.0, 22.0], -5.2), ([38.0, 48.0], 1.0), ([55.0, 95.0], 0.0)] {
            let [low, high] = range_um(&period.map, ring, &[0]);
            assert!(low > height - 0.2 && high < height + 0.2, "{ring:?}: {low} to {high}");
        }
        let other = along_y.transposed().mean_cavity_period(Form::Plane, &Unwatched).unwrap();
        assert_eq!(other.arrangement, Arrangement::GroovesAlongX);
        for (found, expected) in other.map.heights_m().iter().zip(period.map.transposed().heights_m()) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }

    #[test]
    fn turned_grooves_have_the_pitch_and_the_profile_across_them() {
        for turn_deg in [0.0_f64, 7.0, -20.0] {
            let (sin, cos) = turn_deg.to_radians().sin_cos();
            let height = |n: usize| {
                let across_um = 2.0 * (cos * (n / 512) as f64 + sin * (n % 512) as f64);
                let inside_um = 40.0 - (across_um.rem_euclid(200.0) - 100.0).abs();
                -8e-6 * (inside_um / 10.0 + 0.5).clamp(0.0, 1.0)
            };
            let map = HeightMap::new(512, 512, 2e-6, 2e-6, (0..512 * 512).map(height).collect()).unwrap();
            let period = map.mean_cavity_period(Form::Plane, &Unwatched).unwrap().map;
            let side_um = period.rows() as f64 * period.dx_m() * 1e6;
            assert!((side_um - 200.0).abs() < 0.02, "{turn_deg}: {side_um}");
            // The mean height is the depth over the share of the groove, from the land at 0.
            let mean_um = 1e6 * period.heights_m().iter().sum::<f64>() / period.heights_m().len() as f64;
            assert!((mean_um + 8.0 * 80.0 / 200.0).abs() < 0.01, "{turn_deg}: {mean_um}");
        }
    }

    /// Discs of 20 um at positions in micrometres, on 200 x 300 pixels of 1 um.
    fn discs(places: &[[f64; 2]]) -> HeightMap {
        let height = |n: usize| {
            let (x, y) = ((n / 300) as f64 + 0.5, (n % 300) as f64 + 0.5);
            let near = places.iter().map(|[px, py]| (x - px).hypot(y - py)).fold(f64::INFINITY, f64::min);
            -5e-6 * (10.5 - near).clamp(0.0, 1.0)
        };
        HeightMap::new(200, 300, 1e-6, 1e-6, (0..60_000).map(height).collect()).unwrap()
    }

    #[test]
    fn staggered_grids_have_a_rectangle_with_two_cavities() {
        let mut places = Vec::new();
        for row in 0..4 {
            // The map's side cuts the first disc of every second row.
            for col in -1..5 {
                let half = if row % 2 == 0 { 0.0 } else { 29.8 };
                places.push([25.3 + 45.0 * f64::from(row), 30.0 + 59.6 * f64::from(col) + half]);
            }
        }
        let period = discs(&places).mean_cavity_period(Form::Plane, &Unwatched).unwrap();
        assert_eq!(period.arrangement, Arrangement::Staggered);
        let map = &period.map;
        assert_eq!((map.rows(), map.cols()), (90, 60));
        assert!((map.dy_m() * 60.0 - 59.6e-6).abs() < 0.1e-6);
        let at = |i: usize, j: usize| map.heights_m()[i * 60 + j] * 1e6;
        for deep in [at(45, 30), at(0, 0), at(89, 59), at(0, 59), at(89, 0)] {
            assert!((deep + 5.0).abs() < 0.01, "{deep}");
        }
        assert!(at(45, 0).abs() < 0.01 && at(0, 30).abs() < 0.01);
    }

    #[test]
    fn what_has_no_period_is_refused_with_the_arrangement() {
        let refused =
            |places: &[[f64; 2]]| discs(places).mean_cavity_period(Form::Plane, &Unwatched).unwrap_err().to_string();
        assert!(refused(&[[100.0, 150.0]]).contains("expected at least two"));
        assert!(refused(&[[100.0, 100.0], [100.0, 200.0]]).contains("two along y"));
        let slanted: Vec<[f64; 2]> = (0..12)
            .map(|n| [40.0 + 50.0 * f64::from(n / 4), 40.0 + 60.0 * f64::from(n % 4) + 20.0 * f64::from(n / 4)])
            .collect();
        let said = refused(&slanted);
        assert!(said.starts_with("the 12 whole cavities have no mean period"), "{said}");
        let flat = HeightMap::new(20, 20, 1e-6, 1e-6, vec![0.0; 400]).unwrap();
        assert!(
            flat.mean_cavity_period(Form::Plane, &Unwatched).unwrap_err().to_string().contains("no cavities found")
        );
    }
}
