//! Edges of cavities at half depth, and the nearest edge of every point of a map.

use slipgrid_base::monitor::{Cancelled, Monitor};

use super::components::Chord;
use super::period::line_through;

/// Number of pixel lines on either side over which a straight edge is fitted.
const LINES: usize = 3;
/// Maximum lateral offset of a point from the normal of its nearest edge point, relative to the distance from the edge;
/// [`ASIDE_PIXELS`] are added. Points with a greater offset are in front of a corner.
const ASIDE: f64 = 0.35;
/// Part of the maximum lateral offset that does not depend on the distance, in pixels.
const ASIDE_PIXELS: f64 = 0.75;

/// Point on the edge of a cavity where a line of the map crosses it.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgePoint {
    pub(super) region: u32,
    /// Axis along which the line runs, 0 for x and 1 for y.
    pub(super) axis: usize,
    /// Whether the line leaves the cavity here.
    pub(super) behind: bool,
    /// Index of the line: a column for lines along x, a row for lines along y.
    pub(super) line: usize,
    /// Position along x and y in metres, with the first pixel's centre at 0.
    place_m: [f64; 2],
    /// Unit normal out of the cavity.
    normal: [f64; 2],
    /// Length of edge between this line and the next, in metres.
    pub(super) length_m: f64,
}

/// Edges of all cavities, and the nearest edge point of each point of the map.
pub(super) struct Edges {
    pub(super) points: Vec<EdgePoint>,
    /// Index of the nearest edge point of each point of the map.
    nearest: Vec<u32>,
    cols: usize,
    pixel_m: [f64; 2],
}

impl Edges {
    /// Finds the edges at the ends of `chords`. Along an axis only edges mostly across it are used; positions are
    /// fitted by a straight line through the chord ends on neighbouring lines. `counts(axis, region)` tells whether a
    /// region has edges along an axis.
    pub(super) fn find(
        chords: &[Vec<Chord>; 2],
        counts: impl Fn(usize, u32) -> bool,
        [rows, cols]: [usize; 2],
        pixel_m: [f64; 2],
        monitor: &dyn Monitor,
    ) -> Result<Self, Cancelled> {
        let mut points = Vec::new();
        for axis in [0, 1] {
            let regions = chords[axis].iter().map(|chord| chord.region).max().map_or(0, |most| most as usize);
            // Lines and positions of each region's chord ends, line by line.
            let mut ends: [Vec<Vec<(usize, f64)>>; 2] = [vec![Vec::new(); regions + 1], vec![Vec::new(); regions + 1]];
            for chord in &chords[axis] {
                for (ends, place) in ends.iter_mut().zip([chord.from, chord.to]) {
                    ends[chord.region as usize].extend(place.map(|place| (chord.line, place)));
                }
            }
            for (behind, ends) in [false, true].into_iter().zip(&ends) {
                for (region, ends) in ends.iter().enumerate() {
                    // At most 2^28 regions: the cast is exact.
                    let region = region as u32;
                    if counts(axis, region) {
                        points.extend(
                            along(ends, axis, pixel_m).map(|edge| EdgePoint { region, behind, ..edge }.outward()),
                        );
                    }
                }
            }
        }
        let nearest = nearest(&points, [rows, cols], pixel_m, monitor)?;
        Ok(Self { points, nearest, cols, pixel_m })
    }

    /// Returns the index of the edge point in front of which point `n` of the map lies, and the distance of the point
    /// from the edge in metres, positive outside of the cavity; `None` in front of corners and without an edge.
    pub(super) fn distance_m(&self, n: usize) -> Option<(usize, f64)> {
        let number = self.nearest[n] as usize;
        let edge = self.points.get(number)?;
        let offset = offset_m(edge, [n / self.cols, n % self.cols], self.pixel_m);
        let distance_m = offset[0] * edge.normal[0] + offset[1] * edge.normal[1];
        let aside_m = (offset[0] * edge.normal[1] - offset[1] * edge.normal[0]).abs();
        let pixel_m = self.pixel_m[1 - edge.axis];
        (aside_m <= ASIDE * distance_m.abs() + ASIDE_PIXELS * pixel_m).then_some((number, distance_m))
    }
}

impl EdgePoint {
    /// Returns the edge point with its normal out of the cavity.
    fn outward(self) -> Self {
        if self.behind { self } else { Self { normal: self.normal.map(|part| -part), ..self } }
    }
}

/// Edge points of a sequence of chord ends (index of the line, position in pixels), with normals towards larger
/// positions; no point where the edge is more along the axis than across it.
fn along(ends: &[(usize, f64)], axis: usize, pixel_m: [f64; 2]) -> impl Iterator<Item = EdgePoint> {
    (0..ends.len()).filter_map(move |number| {
        let (line, place) = ends[number];
        let beside = &ends[number.saturating_sub(LINES)..ends.len().min(number + LINES + 1)];
        let beside = || {
            let near = beside.iter().filter(|(other, _)| other.abs_diff(line) <= LINES);
            near.map(|&(other, place)| (other as f64 - line as f64, place))
        };
        let [at_line, slope] = line_through(beside());
        let fitted = if beside().count() > 2 { at_line } else { place };
        // dx/dy of an edge across x, dy/dx of an edge across y
        let tangent = slope * pixel_m[axis] / pixel_m[1 - axis];
        let unit = tangent.hypot(1.0);
        let turned = |along: f64, across: f64| if axis == 0 { [along, across] } else { [across, along] };
        (tangent.abs() <= 1.0).then(|| EdgePoint {
            region: 0,
            axis,
            behind: true,
            line,
            place_m: turned(fitted * pixel_m[axis], line as f64 * pixel_m[1 - axis]),
            normal: turned(1.0 / unit, -tangent / unit),
            length_m: unit * pixel_m[1 - axis],
        })
    })
}

fn offset_m(edge: &EdgePoint, [i, j]: [usize; 2], pixel_m: [f64; 2]) -> [f64; 2] {
    [i as f64 * pixel_m[0] - edge.place_m[0], j as f64 * pixel_m[1] - edge.place_m[1]]
}

/// Index of the nearest edge point of every point of the map, propagated from neighbours in two sweeps from corner to
/// corner and back (P.-E. Danielsson, Comput. Graph. Image Process. 14, 227).
fn nearest(
    points: &[EdgePoint],
    [rows, cols]: [usize; 2],
    pixel_m: [f64; 2],
    monitor: &dyn Monitor,
) -> Result<Vec<u32>, Cancelled> {
    const NONE: u32 = u32::MAX;
    let mut nearest = vec![NONE; rows * cols];
    let square_m2 = |number: u32, i: usize, j: usize| match points.get(number as usize) {
        Some(edge) => offset_m(edge, [i, j], pixel_m).iter().map(|part| part * part).sum(),
        None => f64::INFINITY,
    };
    let offer = |nearest: &mut [u32], number: u32, i: usize, j: usize| {
        let at = &mut nearest[i * cols + j];
        if square_m2(number, i, j) < square_m2(*at, i, j) {
            *at = number;
        }
    };
    for (number, edge) in points.iter().enumerate() {
        let place = edge.place_m[edge.axis] / pixel_m[edge.axis];
        let last = [rows, cols][edge.axis] - 1;
        for index in [place.floor(), place.ceil()] {
            // Fitted edges may end outside the map: the cast saturates at the first line.
            let index = (index as usize).min(last);
            let [i, j] = if edge.axis == 0 { [index, edge.line] } else { [edge.line, index] };
            offer(&mut nearest, number as u32, i, j);
        }
    }
    let sweep = |nearest: &mut Vec<u32>, forward: bool| {
        for turn in 0..rows {
            monitor.heed()?;
            let i = if forward { turn } else { rows - 1 - turn };
            let before = if forward { i.checked_sub(1) } else { Some(i + 1).filter(|&i| i < rows) };
            for j in 0..cols {
                if let Some(before) = before {
                    for other in j.saturating_sub(1)..=(j + 1).min(cols - 1) {
                        let number = nearest[before * cols + other];
                        offer(nearest, number, i, j);
                    }
                }
                if j > 0 {
                    let number = nearest[i * cols + j - 1];
                    offer(nearest, number, i, j);
                }
            }
            for j in (0..cols - 1).rev() {
                let number = nearest[i * cols + j + 1];
                offer(nearest, number, i, j);
            }
        }
        Ok(())
    };
    for forward in [true, false] {
        sweep(&mut nearest, forward)?;
    }
    Ok(nearest)
}

#[cfg(test)]
mod tests {
    use slipgrid_base::monitor::Unwatched;

    use super::*;
    use crate::topography::cavities::components::Regions;

    fn edges(height: impl Fn(f64, f64) -> f64, rows: usize, cols: usize, pixel_m: [f64; 2]) -> Edges {
        let heights: Vec<f64> =
            (0..rows * cols).map(|n| height((n / cols) as f64 * pixel_m[0], (n % cols) as f64 * pixel_m[1])).collect();
        let regions = Regions::find(&heights, cols, 0.0, 0.0, &Unwatched).unwrap();
        let chords = [0, 1].map(|axis| regions.chords(&heights, |_| 0.0, axis, &Unwatched).unwrap());
        Edges::find(&chords, |_, _| true, [rows, cols], pixel_m, &Unwatched).unwrap()
    }

    #[test]
    fn distances_from_a_disc_are_radial_whatever_the_pixels() {
        for pixel_m in [[1.0, 1.0], [1.0, 2.0]] {
            let radius = |x: f64, y: f64| (x - 100.3).hypot(y - 99.6);
            let edges = edges(|x, y| radius(x, y) - 60.0, 201, (201.0 / pixel_m[1]) as usize, pixel_m);
            let length: f64 = edges.points.iter().map(|point| point.length_m).sum();
            assert!((length / (std::f64::consts::TAU * 60.0) - 1.0).abs() < 0.08, "{length}");
            let (mut found, mut all) = (0, 0);
            for n in 0..edges.nearest.len() {
                let exact = radius((n / edges.cols) as f64, (n % edges.cols) as f64 * pixel_m[1]) - 60.0;
                if exact.abs() > 15.0 {
                    continue;
                }
                all += 1;
                if let Some((_, distance)) = edges.distance_m(n) {
                    found += 1;
                    // Straight lines through seven points of a circle, up to 6 from the middle one.
                    assert!((distance - exact).abs() < 0.3, "{pixel_m:?} {n}: {distance} {exact}");
                }
            }
            assert!(10 * found > 9 * all, "{found} of {all}");
        }
    }

    #[test]
    fn what_lies_before_a_corner_has_no_distance() {
        let square = |x: f64, y: f64| (x - 30.0).abs().max((y - 30.0).abs()) - 10.25;
        let edges = edges(square, 61, 61, [1.0, 1.0]);
        let at = |i: usize, j: usize| {
            edges.distance_m(i * 61 + j).map(|(number, distance)| {
                let edge = &edges.points[number];
                (edge.axis, edge.behind, (distance * 1e6).round() / 1e6)
            })
        };
        assert_eq!(at(50, 30), Some((0, true, 9.75)));
        assert_eq!(at(12, 25), Some((0, false, 7.75)));
        assert_eq!(at(33, 55), Some((1, true, 14.75)));
        assert_eq!(at(22, 30), Some((0, false, -2.25)));
        assert_eq!((at(50, 50), at(8, 52)), (None, None));
    }
}
