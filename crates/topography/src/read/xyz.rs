//! Heights as points x y z, in any order, on a regular grid of which points may be missing.

use super::ReadOptions;
use super::header::Header;
use super::lines::{Delimiter, excerpt, height, number};
use super::matrix::HOW_TO_GIVE_HEIGHT_UNIT;
use crate::map::MOST_POINTS;
use crate::{HeightMap, MapError, ReadError};

/// Coordinates closer than this share of their range count as equal: well below the pixel of the largest
/// map, well above rounding.
const SAME_COORDINATE: f64 = 1e-7;
/// Largest distance of a point from its grid line, in steps: files round their coordinates.
const OFF_GRID: f64 = 0.2;
/// Most grid nodes for each point present. Sparser grids come from coordinates that are on no grid.
const MOST_NODES_PER_POINT: usize = 20;

#[derive(Clone, Copy, Debug)]
struct Point {
    x: f64,
    y: f64,
    z: f64,
    line: usize,
}

/// Points read so far, in the text's units.
#[derive(Debug, Default)]
pub(crate) struct XyzReader {
    delimiter: Option<Delimiter>,
    points: Vec<Point>,
}

impl XyzReader {
    pub(crate) fn push(&mut self, text: &str, line: usize) -> Result<(), ReadError> {
        let delimiter = *self.delimiter.get_or_insert_with(|| Delimiter::of(text));
        let mut fields = delimiter.fields(text);
        let (Some(x), Some(y), Some(z), None) = (fields.next(), fields.next(), fields.next(), fields.next()) else {
            return Err(ReadError::RowLength { line, found: delimiter.fields(text).count(), expected: 3 });
        };
        let refused = |column, field, expected| ReadError::NotANumber { line, column, value: excerpt(field), expected };
        let coordinate =
            |column, field| number(field).ok_or_else(|| refused(column, field, "a coordinate with a decimal point"));
        let z = height(z)
            .ok_or_else(|| refused(3, z, "a height with a decimal point, or NaN, BAD, --- where it is missing"))?;
        if self.points.len() == MOST_POINTS {
            let points = self.points.len() as f64 + 1.0;
            return Err(MapError::TooManyPoints { points, most: MOST_POINTS }.into());
        }
        self.points.push(Point { x: coordinate(1, x)?, y: coordinate(2, y)?, z: z.unwrap_or(f64::NAN), line });
        Ok(())
    }

    pub(crate) fn finish(self, header: &Header, options: &ReadOptions) -> Result<HeightMap, ReadError> {
        let height_unit = options
            .height_unit
            .or(header.value_unit)
            .ok_or(ReadError::NotGiven { what: "unit of the heights", expected: HOW_TO_GIVE_HEIGHT_UNIT })?;
        let lateral_unit = options.lateral_unit.or(header.lateral_unit).ok_or(ReadError::NotGiven {
            what: "unit of x and y",
            expected: "a header line such as \"# XY units: um\", titles such as x_um,y_um,z_um, or a unit by option",
        })?;
        let along_x = GridLines::find("x", &self.points, |point| point.x)?;
        let along_y = GridLines::find("y", &self.points, |point| point.y)?;
        let nodes = along_x.count * along_y.count;
        if nodes > (MOST_NODES_PER_POINT * self.points.len()) as f64 {
            return Err(ReadError::Sparse {
                points: self.points.len(),
                rows: along_x.count,
                cols: along_y.count,
                most_nodes_per_point: MOST_NODES_PER_POINT,
            });
        }
        if nodes > MOST_POINTS as f64 {
            return Err(MapError::TooManyPoints { points: nodes, most: MOST_POINTS }.into());
        }
        let (rows, cols) = (along_x.count as usize, along_y.count as usize);
        let mut height_m = vec![f64::NAN; rows * cols];
        // Where each node was given; lines count from 1.
        let mut given_on = vec![0_usize; rows * cols];
        for point in &self.points {
            let node = along_x.index("x", point.x, point.line)? * cols + along_y.index("y", point.y, point.line)?;
            if given_on[node] != 0 {
                let (line, earlier) = (point.line, given_on[node]);
                return Err(ReadError::Duplicate { line, earlier, x: point.x, y: point.y });
            }
            given_on[node] = point.line;
            height_m[node] = height_unit.to_metres(point.z);
        }
        let (dx_m, dy_m) = (lateral_unit.to_metres(along_x.step), lateral_unit.to_metres(along_y.step));
        Ok(HeightMap::new(rows, cols, dx_m, dy_m, height_m)?)
    }
}

/// Equally spaced coordinates: first, first + step, ..., `count` of them (whole, as a float).
#[derive(Clone, Copy, Debug)]
struct GridLines {
    first: f64,
    step: f64,
    count: f64,
}

impl GridLines {
    /// The grid that `coordinate` of the points lies on.
    fn find(axis: &'static str, points: &[Point], coordinate: impl Fn(&Point) -> f64) -> Result<Self, ReadError> {
        let mut sorted: Vec<f64> = points.iter().map(coordinate).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let (first, last) = (sorted[0], sorted[sorted.len() - 1]);
        // Halves, so that the range of the largest numbers stays finite.
        let same = 2.0 * SAME_COORDINATE * (0.5 * last - 0.5 * first);
        let gaps = || sorted.windows(2).map(|pair| pair[1] - pair[0]).filter(move |gap| *gap > same);
        let smallest = gaps().fold(f64::INFINITY, f64::min);
        if !(smallest.is_finite() && smallest > 0.0) {
            return Err(ReadError::OneLine { axis, value: first });
        }
        // Rounded coordinates make the smallest gap a poor step, but the number of steps in each gap is
        // certain; the whole range over their sum is the step.
        let steps: f64 = gaps().map(|gap| (gap / smallest).round()).sum();
        Ok(Self { first, step: last / steps - first / steps, count: steps + 1.0 })
    }

    /// The grid line that `value` lies on.
    fn index(&self, axis: &'static str, value: f64, line: usize) -> Result<usize, ReadError> {
        let steps = (value - self.first) / self.step;
        let nearest = steps.round();
        if (steps - nearest).abs() > OFF_GRID || !(0.0..self.count).contains(&nearest) {
            return Err(ReadError::OffGrid { line, axis, value, step: self.step });
        }
        Ok(nearest as usize)
    }
}
