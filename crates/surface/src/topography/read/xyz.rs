//! Heights as points x y z in any order, on a regular grid whose points may be missing.

use super::ReadOptions;
use super::header::Header;
use super::lines::{Delimiter, Greatest, expected_coordinate, expected_height, height, not_a_number, number};
use super::matrix::NO_HEIGHT_UNIT;
use super::scale::Scale;
use super::scan::Scan;
use crate::topography::error::plain;
use crate::topography::map::MAX_POINTS;
use crate::topography::{HeightMap, LengthUnit, MapError, MapOption, NotGiven, ReadError};

/// Coordinates that differ by less than this fraction of their range count as equal: well below the pixel of the
/// largest map, well above rounding errors.
const SAME_COORDINATE: f64 = 1e-7;
/// Largest distance of a point from its grid line, in steps, because files round their coordinates.
const OFF_GRID: f64 = 0.2;
/// Largest number of grid nodes per point present. A sparser grid means that the coordinates are not on a grid, and the
/// map would be refused for its missing points (`limits::MAX_MISSING_SHARE`).
const MAX_NODES_PER_POINT: usize = 10;

/// A point in the file's units, and its line number.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) z: f64,
    pub(super) line: usize,
}

/// Whether `text` has three values; the height of a missing point may be an empty field at the end of the line.
pub(super) fn is_point(text: &str) -> bool {
    let row = text.trim();
    let delimiter = Delimiter::of(row);
    // A point does not end with several empty fields.
    if delimiter == Delimiter::Tab && text.len() > text.trim_end_matches('\t').len() + 1 {
        return false;
    }
    // A point has both coordinates.
    if delimiter.fields(row).take(2).any(str::is_empty) {
        return false;
    }
    match delimiter.fields(row).take(4).count() {
        2 => delimiter.ends(delimiter.row(text)),
        fields => fields == 3,
    }
}

/// Reads points line by line.
#[derive(Debug, Default)]
pub(super) struct XyzReader {
    delimiter: Option<Delimiter>,
    /// Number of points read so far.
    count: usize,
    /// The points, as long as they are in scan order.
    scan: Scan,
    /// The points in any order; `None` as long as they are in scan order.
    any: Option<Vec<Point>>,
    greatest: Greatest,
}

impl XyzReader {
    pub(super) fn push(&mut self, text: &str, line: usize) -> Result<(), ReadError> {
        let row = text.trim();
        let delimiter = *self.delimiter.get_or_insert_with(|| Delimiter::of(row));
        let mut fields = delimiter.fields(row);
        let (x, y, z) = (fields.next(), fields.next(), fields.next());
        // The height of a missing point may be an empty field at the end of a line.
        let z = z.or_else(|| delimiter.ends(delimiter.row(text)).then_some(""));
        let (Some(x), Some(y), Some(z), None) = (x, y, z, fields.next()) else {
            return Err(ReadError::RowLength { line, found: delimiter.fields(row).count(), expected: 3 });
        };
        let coordinate =
            |place, field| number(field).ok_or_else(|| not_a_number(line, place, field, expected_coordinate(field)));
        let (written, z) = (z, height(z).ok_or_else(|| not_a_number(line, 2, z, expected_height(z)))?);
        if self.count == MAX_POINTS {
            let points = self.count as f64 + 1.0;
            return Err(MapError::TooManyPoints { points, most: MAX_POINTS }.into());
        }
        let point = Point { x: coordinate(0, x)?, y: coordinate(1, y)?, z: z.unwrap_or(f64::NAN), line };
        self.greatest.take(point.z, line, 2, written);
        self.count += 1;
        match &mut self.any {
            Some(points) => points.push(point),
            None if self.scan.push(point) => {}
            None => self.any = Some(std::mem::take(&mut self.scan).points().chain([point]).collect()),
        }
        Ok(())
    }

    /// Quantities given neither by the header nor by the caller.
    pub(super) fn missing(header: &Header, options: &ReadOptions) -> Vec<NotGiven> {
        let height = options.height_unit.is_none() && header.value().is_none();
        let lateral = options.lateral_unit.is_none() && header.lateral.is_none();
        let way = NotGiven {
            what: "unit of x and y",
            expected: "a header line such as \"# XY units: um\", titles such as x_um,y_um,z_um, or a unit by option",
            option: MapOption::LateralUnit,
        };
        height.then_some(NO_HEIGHT_UNIT).into_iter().chain(lateral.then_some(way)).collect()
    }

    pub(super) fn finish(self, header: &Header, options: &ReadOptions) -> Result<HeightMap, ReadError> {
        let given = |unit: Option<LengthUnit>, own: Option<Scale>| unit.map(Scale::from).or(own);
        let units = given(options.height_unit, header.value()).zip(given(options.lateral_unit, header.lateral));
        let Some((height_unit, lateral_unit)) = units else {
            return Err(ReadError::NotGiven { missing: Self::missing(header, options) });
        };
        self.grid(height_unit, [lateral_unit; 2])
    }

    /// The map of the points, with the scales of heights and of x and y.
    pub(super) fn grid(self, height_unit: Scale, [scale_x, scale_y]: [Scale; 2]) -> Result<HeightMap, ReadError> {
        let Self { scan, any, greatest, .. } = self;
        let map = |[along_x, along_y]: [GridLines; 2], height_m| {
            let (dx_m, dy_m) = (scale_x.to_metres(along_x.step), scale_y.to_metres(along_y.step));
            let map = HeightMap::new(along_x.count as usize, along_y.count as usize, dx_m, dy_m, height_m);
            map.map_err(|error| greatest.named(error.into()))
        };
        if any.is_none()
            && let Some((grid, height_m)) = from_scan(&scan, height_unit)
        {
            drop(scan);
            return map(grid, height_m);
        }
        let points = any.unwrap_or_else(|| scan.points().collect());
        drop(scan);
        let (grid, height_m) = from_points(&points, height_unit)?;
        drop(points);
        map(grid, height_m)
    }
}

/// Grid lines along x and y of a scan without missing points, and its heights in metres, row by row; `None` if lines
/// are incomplete or not equally spaced.
fn from_scan(scan: &Scan, unit: Scale) -> Option<([GridLines; 2], Vec<f64>)> {
    let ([x, y], z) = scan.grid()?;
    let along_x = GridLines::find("x", x.iter().copied()).ok()?;
    let along_y = GridLines::find("y", y.iter().copied()).ok()?;
    let order_x = along_x.order(x)?;
    let order_y = along_y.order(y)?;
    let mut height_m = Vec::with_capacity(z.len());
    for &i in &order_x {
        height_m.extend(order_y.iter().map(|&j| unit.to_metres(z[scan.place(i, j)])));
    }
    Some(([along_x, along_y], height_m))
}

/// Grid lines along x and y on which the `points`, in any order, lie, and heights in metres, row by row, NaN where
/// there is no point.
fn from_points(points: &[Point], unit: Scale) -> Result<([GridLines; 2], Vec<f64>), ReadError> {
    let along_x = GridLines::find("x", points.iter().map(|point| point.x))?;
    let along_y = GridLines::find("y", points.iter().map(|point| point.y))?;
    let nodes = along_x.count * along_y.count;
    if nodes > (MAX_NODES_PER_POINT * points.len()) as f64 {
        return Err(ReadError::Refused(format!(
            "{} points on a grid of {} x {}: expected at least one point in {MAX_NODES_PER_POINT} grid nodes",
            points.len(),
            plain(along_x.count.round()),
            plain(along_y.count.round())
        )));
    }
    if nodes > MAX_POINTS as f64 {
        return Err(MapError::TooManyPoints { points: nodes, most: MAX_POINTS }.into());
    }
    let (rows, cols) = (along_x.count as usize, along_y.count as usize);
    let mut height_m = vec![f64::NAN; rows * cols];
    let mut given = vec![false; rows * cols];
    let node = |point: &Point| {
        Ok::<_, ReadError>(along_x.index("x", point.x, point.line)? * cols + along_y.index("y", point.y, point.line)?)
    };
    for (count, point) in points.iter().enumerate() {
        let at = node(point)?;
        if given[at] {
            let before = points[..count].iter().find(|before| node(before) == Ok(at));
            let (line, earlier) = (point.line, before.map_or(0, |before| before.line));
            let [x, y] = [point.x, point.y].map(plain);
            return Err(ReadError::Refused(format!(
                "line {line}: x = {x}, y = {y} was given on line {earlier} already: expected one height per point"
            )));
        }
        given[at] = true;
        height_m[at] = unit.to_metres(point.z);
    }
    Ok(([along_x, along_y], height_m))
}

/// Equally spaced coordinates: first, first + step, ..., `count` of them (a whole number, stored as a float).
#[derive(Clone, Copy, Debug)]
struct GridLines {
    first: f64,
    step: f64,
    count: f64,
}

impl GridLines {
    /// The grid on which the `coordinates` lie; refused if all are equal. `axis` is their name for the message.
    fn find(axis: &'static str, coordinates: impl Iterator<Item = f64>) -> Result<Self, ReadError> {
        let mut sorted: Vec<f64> = coordinates.collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let first = sorted.first().copied().unwrap_or_default();
        let last = sorted.last().copied().unwrap_or_default();
        // Halved values, so that the range of the largest numbers stays finite.
        let same = 2.0 * SAME_COORDINATE * (0.5 * last - 0.5 * first);
        let gaps = || sorted.windows(2).map(|pair| pair[1] - pair[0]).filter(move |gap| *gap > same);
        let smallest = gaps().fold(f64::INFINITY, f64::min);
        if !(smallest.is_finite() && smallest > 0.0) {
            return Err(ReadError::Refused(format!(
                "all points have {axis} = {}, as of a profile: expected a map, on a grid of at least 2 x 2",
                plain(first)
            )));
        }
        // Rounding of the coordinates makes the smallest gap an inaccurate step, but the number of steps in each gap is
        // certain; the step is the whole range divided by the sum of these numbers.
        let steps: f64 = gaps().map(|gap| (gap / smallest).round()).sum();
        Ok(Self { first, step: last / steps - first / steps, count: steps + 1.0 })
    }

    /// Indices of the `values` that lie on the first, second, ... grid line; `None` unless each line has exactly one.
    fn order(&self, values: &[f64]) -> Option<Vec<usize>> {
        if self.count != values.len() as f64 {
            return None;
        }
        let mut order = vec![usize::MAX; values.len()];
        for (n, &value) in values.iter().enumerate() {
            *order.get_mut(self.index("", value, 0).ok()?)? = n;
        }
        order.iter().all(|&n| n != usize::MAX).then_some(order)
    }

    /// Index of the grid line on which `value` lies; refused if it lies between lines.
    fn index(&self, axis: &'static str, value: f64, line: usize) -> Result<usize, ReadError> {
        let steps = (value - self.first) / self.step;
        let nearest = steps.round();
        if (steps - nearest).abs() > OFF_GRID || !(0.0..self.count).contains(&nearest) {
            let [value, step] = [value, self.step].map(plain);
            return Err(ReadError::Refused(format!(
                "line {line}: {axis} = {value} lies between grid lines {step} apart: expected a regular grid"
            )));
        }
        Ok(nearest as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topography::read_map;

    const UM: Option<LengthUnit> = Some(LengthUnit::Micrometre);
    const GIVEN: ReadOptions = ReadOptions { height_unit: UM, lateral_unit: UM, ..crate::topography::read::NONE };

    /// 4 x 3 points with x slow; each height identifies its position.
    fn scan() -> Vec<String> {
        (0..12).map(|n| format!("{} {} {n}\n", 0.5 * f64::from(n / 3), 0.25 * f64::from(n % 3))).collect()
    }

    fn read(lines: &[String]) -> Result<HeightMap, ReadError> {
        read_map(lines.concat().as_bytes(), &GIVEN).map(|read| read.map)
    }

    #[test]
    fn every_order_of_the_points_gives_the_same_map() {
        let whole = read(&scan()).unwrap();
        assert_eq!((whole.rows(), whole.cols(), whole.dx_m(), whole.dy_m()), (4, 3, 0.5e-6, 0.25e-6));
        assert!(whole.heights_m().iter().enumerate().all(|(n, h)| (h - 1e-6 * n as f64).abs() < 1e-20));
        let by = |order: &dyn Fn(usize) -> usize| (0..12).map(|n| scan()[order(n)].clone()).collect::<Vec<_>>();
        let y_slow = |n: usize| n % 4 * 3 + n / 4;
        // Backwards, y slow, y slow from the far side, back and forth, and in no order.
        let back_and_forth = |n: usize| if (n / 3).is_multiple_of(2) { n } else { n / 3 * 3 + 2 - n % 3 };
        let orders: [&dyn Fn(usize) -> usize; 5] =
            [&|n| 11 - n, &y_slow, &|n| y_slow(11 - n), &back_and_forth, &|n| n * 5 % 12];
        for order in orders {
            assert_eq!(read(&by(order)).unwrap(), whole);
        }
        // Empty lines between scan lines, or anywhere.
        let mut gaps = scan();
        gaps.insert(6, "\n".to_owned());
        assert_eq!(read(&gaps).unwrap(), whole);
        gaps.insert(2, "\n".to_owned());
        assert_eq!(read(&gaps).unwrap(), whole);
    }

    #[test]
    fn a_height_that_was_not_measured_may_be_an_empty_field_at_the_end_of_a_line() {
        let whole_lines = || scan().iter().map(|line| line.replace(' ', ";")).collect::<Vec<String>>();
        let mut holed = whole_lines();
        holed[4] = "0.5;0.25;\n".to_owned();
        let (whole, found) = (read(&whole_lines()).unwrap(), read(&holed).unwrap());
        assert_eq!((whole.missing(), found.missing(), found.rows(), found.cols()), (0, 1, 4, 3));
        let kept = whole.heights_m().iter().zip(found.heights_m()).filter(|(all, left)| all == left).count();
        assert_eq!(kept, 11);
        // Also if the first point is the missing one, without titles.
        holed = whole_lines();
        holed[0] = "0;0;\n".to_owned();
        assert_eq!(read(&holed).unwrap().missing(), 1);
        // Without a delimiter the field does not exist.
        let short: Vec<String> = ["0;0;1\n", "0;1\n"].map(str::to_owned).to_vec();
        assert_eq!(read(&short).unwrap_err().to_string(), "line 2: 2 values: expected 3");
    }

    #[test]
    fn commas_that_may_be_marks_of_thousands_are_told_how_they_are_read() {
        let lines: Vec<String> = ["0;0;1,500\n", "0;1;1,500\n"].map(str::to_owned).to_vec();
        assert!(read(&lines).unwrap_err().to_string().contains("--decimal-comma"));
        // Also between spaces, where commas seem to delimit the fields.
        for line in ["0 1,000 2,000\n", "1,500 1,000 2,000\n", "-1,500 -1,000 2,500\n"] {
            let said = read(&[line.to_owned()]).unwrap_err().to_string();
            assert!(said.contains("between two commas") && said.contains("--decimal-comma"), "{said}");
        }
    }

    #[test]
    fn a_scan_that_breaks_off_or_skips_points_has_holes() {
        for absent in [0, 1, 4, 7, 11] {
            let mut lines = scan();
            lines.remove(absent);
            let map = read(&lines).unwrap();
            assert_eq!((map.rows(), map.cols(), map.missing()), (4, 3, 1), "{absent}");
            assert!(map.heights_m()[absent].is_nan());
        }
        // A whole scan line is absent.
        let lines: Vec<String> =
            scan().into_iter().enumerate().filter(|(n, _)| n / 3 != 2).map(|(_, line)| line).collect();
        let map = read(&lines).unwrap();
        assert_eq!((map.rows(), map.cols(), map.missing()), (4, 3, 3));
    }

    #[test]
    fn a_point_given_twice_is_refused_with_both_lines() {
        for (copy, at) in [(0, 1), (2, 3), (3, 6), (1, 12)] {
            let mut lines = scan();
            lines.insert(at, lines[copy].clone());
            let message = read(&lines).unwrap_err().to_string();
            assert!(message.starts_with(&format!("line {}: ", at + 1)), "{message}");
            assert!(message.contains(&format!("on line {} already", copy + 1)), "{message}");
        }
    }
}
