//! Outlines offset outwards: all points within a given distance of a polygon.

use std::f64::consts::TAU;

use crate::pattern::Polygon;
use crate::pattern::geometry::{contains, edges, point_to_segment};

/// All points within a given distance of an outline: its edges shifted outwards, joined by arcs about its convex
/// corners.
///
/// Parts of the shifted boundary that come closer than the distance to another part of the outline are removed, so that
/// concave outlines are handled correctly, including closing gaps and remaining holes. Arcs are replaced by chords that
/// deviate by at most 1e-4 of the distance; everything else is exact.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Grown {
    /// Directed pieces of the boundary, with the inside on their left, divided by the outline's extent along x.
    pieces: Vec<[[f64; 2]; 2]>,
    distance: f64,
    length: f64,
}

/// Maximum deviation of a chord from its arc, divided by the radius.
const MAX_SAGITTA: f64 = 1e-4;
/// Tolerance for rounding, as a fraction of the offset distance, in the test whether a point of the shifted boundary is
/// that far from the outline.
const ROUNDING: f64 = 1e-9;

/// A piece of the shifted boundary, before parts too close to the outline are removed.
struct ShiftedPiece {
    ends: [[f64; 2]; 2],
    /// Centre of the arc, if the piece belongs to one.
    arc_centre: Option<[f64; 2]>,
}

impl Polygon {
    /// Computes the region of all points within `distance` of the polygon; `distance` is divided by the extent along x.
    /// Time is proportional to the square of the number of corners: two milliseconds for a hundred corners. A distance
    /// that is not positive and finite returns the outline itself.
    pub(crate) fn grown(&self, distance: f64) -> Grown {
        let vertices = self.vertices();
        if !(distance > 0.0 && distance.is_finite()) {
            let pieces = edges(vertices).map(|(a, b)| [a, b]).collect();
            return Grown { pieces, distance: 0.0, length: self.length() };
        }
        let moved = shifted_boundary(vertices, distance);
        let is_boundary = |at: [f64; 2]| {
            let away = edges(vertices).map(|(a, b)| point_to_segment(at, a, b)).fold(f64::INFINITY, f64::min);
            away >= distance * (1.0 - ROUNDING) && !contains(vertices, at)
        };
        let mut pieces = Vec::new();
        for (place, piece) in moved.iter().enumerate() {
            let others = moved.iter().enumerate().filter(|(other, _)| *other != place).map(|(_, other)| other.ends);
            let mut shares: Vec<f64> =
                others.filter_map(|other| crossing(piece.ends, other)).chain([0.0, 1.0]).collect();
            shares.sort_by(f64::total_cmp);
            let at = |share: f64| {
                [0, 1].map(|axis| piece.ends[0][axis] + share * (piece.ends[1][axis] - piece.ends[0][axis]))
            };
            for ends in shares.windows(2).filter(|ends| ends[1] > ends[0]) {
                let middle = at(f64::midpoint(ends[0], ends[1]));
                if is_boundary(piece.arc_centre.map_or(middle, |arc_centre| onto_circle(arc_centre, distance, middle)))
                {
                    pieces.push([at(ends[0]), at(ends[1])]);
                }
            }
        }
        Grown { pieces, distance, length: self.length() }
    }
}

impl Grown {
    /// Area, divided by the square of the outline's extent along x.
    #[cfg(test)]
    pub(crate) fn area(&self) -> f64 {
        // A = 1/2 sum (x_a y_b - x_b y_a)
        self.pieces.iter().map(|[[xa, ya], [xb, yb]]| (xa * yb - xb * ya) / 2.0).sum()
    }

    /// Directed pieces of the boundary, with the inside on their left.
    pub(crate) fn pieces(&self) -> &[[[f64; 2]; 2]] {
        &self.pieces
    }

    /// Extents of the bounding box along x and y, divided by the outline's extent along x.
    pub(crate) fn extents(&self) -> [f64; 2] {
        [1.0 + 2.0 * self.distance, self.length + 2.0 * self.distance]
    }
}

/// Edges shifted outwards by `distance`, and arcs about convex corners as chords.
fn shifted_boundary(vertices: &[[f64; 2]], distance: f64) -> Vec<ShiftedPiece> {
    let normals: Vec<[f64; 2]> = edges(vertices)
        .map(|(a, b)| {
            let size = (b[0] - a[0]).hypot(b[1] - a[1]);
            // Normals point to the right of an anticlockwise edge.
            [(b[1] - a[1]) / size, (a[0] - b[0]) / size]
        })
        .collect();
    let beside = |at: [f64; 2], normal: [f64; 2]| [at[0] + distance * normal[0], at[1] + distance * normal[1]];
    let chord = 2.0 * libm::acos(1.0 - MAX_SAGITTA);
    let mut found = Vec::new();
    for (k, (a, b)) in edges(vertices).enumerate() {
        let (own, next) = (normals[k], normals[(k + 1) % normals.len()]);
        found.push(ShiftedPiece { ends: [beside(a, own), beside(b, own)], arc_centre: None });
        let start = libm::atan2(own[1], own[0]);
        let turn = (libm::atan2(next[1], next[0]) - start).rem_euclid(TAU);
        if turn >= TAU / 2.0 {
            continue;
        }
        // There are at most some hundred chords, so that the cast is exact.
        let count = (turn / chord).ceil().max(1.0) as u32;
        let at = |step: u32| match step {
            0 => beside(b, own),
            step if step == count => beside(b, next),
            step => {
                let angle = start + turn * f64::from(step) / f64::from(count);
                beside(b, [libm::cos(angle), libm::sin(angle)])
            }
        };
        found.extend((0..count).map(|step| ShiftedPiece { ends: [at(step), at(step + 1)], arc_centre: Some(b) }));
    }
    found
}

/// Position along the first segment, between 0 and 1, at which the second segment crosses it; `None` if it does not.
fn crossing([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> Option<f64> {
    let (along, across) = ([b[0] - a[0], b[1] - a[1]], [d[0] - c[0], d[1] - c[1]]);
    let from = [c[0] - a[0], c[1] - a[1]];
    let cross = along[0] * across[1] - along[1] * across[0];
    let share = (from[0] * across[1] - from[1] * across[0]) / cross;
    let other = (from[0] * along[1] - from[1] * along[0]) / cross;
    (share > 0.0 && share < 1.0 && (0.0..=1.0).contains(&other)).then_some(share)
}

fn onto_circle([x, y]: [f64; 2], radius: f64, at: [f64; 2]) -> [f64; 2] {
    let away = [at[0] - x, at[1] - y];
    let size = away[0].hypot(away[1]);
    [x + radius * away[0] / size, y + radius * away[1] / size]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::{Arrangement, Pattern, Planform, Texture};
    use std::f64::consts::PI;

    #[test]
    fn a_convex_outline_grows_by_its_perimeter_and_a_disc() {
        let square = Polygon::new(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]).unwrap();
        let triangle = Polygon::new(&[[0.0, 0.0], [4.0, 0.0], [0.0, 3.0]]).unwrap();
        for (outline, perimeter, area) in [(square, 4.0, 1.0), (triangle, 3.0, 6.0 / 16.0)] {
            for distance in [1e-3, 0.1, 2.0] {
                // Chords reduce the disc's radius by 2/3 of the sagitta on average.
                let expected = area + perimeter * distance + PI * distance * distance;
                let short = expected - outline.grown(distance).area();
                assert!((-1e-12..2.0 * MAX_SAGITTA * PI * distance * distance).contains(&short), "{distance}: {short}");
            }
            assert!((outline.grown(0.0).area() - area).abs() < 1e-12);
        }
    }

    #[test]
    fn hollows_close_and_leave_holes() {
        // A U: a 10 by 10 square with a slot 2 wide from y = 3 up; then a slot that widens to 4 by 4 at its bottom.
        let slot =
            [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [6.0, 10.0], [6.0, 3.0], [4.0, 3.0], [4.0, 10.0], [0.0, 10.0]];
        let outline = Polygon::new(&slot).unwrap();
        let grown = |distance: f64| outline.grown(distance / 10.0).area() * 100.0;
        // Narrower by 2 d; at d = 1 it is closed except for the gap between the arcs at its mouth, 2 x 1 minus half a
        // disc.
        let around = |d: f64| 100.0 + 40.0 * d + PI * d * d;
        let mouth = |d: f64| (2.0 - 2.0 * d) * (7.0 - d) + (2.0 - PI / 2.0) * d * d + (2.0 - 2.0 * d) * d;
        for d in [0.3, 0.9] {
            assert!((grown(d) - (around(d) - mouth(d))).abs() < 2e-3, "{d}: {}", grown(d));
        }
        assert!((grown(1.5) - around(1.5)).abs() < 1.0 && grown(1.5) < around(1.5));
        let bottle = [
            [0.0, 0.0],
            [10.0, 0.0],
            [10.0, 10.0],
            [5.5, 10.0],
            [5.5, 7.0],
            [7.0, 7.0],
            [7.0, 3.0],
            [3.0, 3.0],
            [3.0, 7.0],
            [4.5, 7.0],
            [4.5, 10.0],
            [0.0, 10.0],
        ];
        let bottle = Polygon::new(&bottle).unwrap().grown(0.08);
        // The neck, 1 wide, closes at 0.5; a square of 4 - 1.6 remains of the 4 x 4 chamber, minus the part covered by
        // the neck's arcs.
        let hole = 2.4 * 2.4;
        let around = 100.0 + 40.0 * 0.8 + PI * 0.64;
        let open = around - bottle.area() * 100.0 - hole;
        assert!((0.0..0.5).contains(&open), "{open}");
    }

    #[test]
    fn coverage_of_the_grown_outline_is_the_share_of_points_that_near() {
        let bent = [[0.0, 0.0], [100.0, 10.0], [90.0, 40.0], [45.0, 35.0], [40.0, 70.0], [5.0, 65.0]];
        let outline = Polygon::new(&bent).unwrap();
        for arrangement in [Arrangement::Square, Arrangement::Staggered] {
            let texture = Texture::new(Planform::Polygon).with_outline(outline).unwrap();
            let pattern = Pattern::new(texture.with_arrangement(arrangement).unwrap(), 100e-6, 40e-6, 5e-6).unwrap();
            let grown = outline.grown(0.12);
            let [x_m, y_m] = pattern.cell_m();
            let whole = pattern.coverage_within(12e-6, [0.0, x_m], [0.0, y_m]);
            let cavities = pattern.centres_m().count() as f64;
            assert!((whole - cavities * grown.area() * 1e-8 / (x_m * y_m)).abs() < 1e-12);
            let rectangle = [-30e-6, 41e-6, 5e-6, 77e-6];
            let inside = |[x, y]: [f64; 2]| {
                let near = |[dx, dy]: [f64; 2]| {
                    let at = [(x - dx) / 100e-6, (y - dy) / 100e-6];
                    let away = edges(outline.vertices())
                        .map(|(a, b)| point_to_segment(at, a, b))
                        .fold(f64::INFINITY, f64::min);
                    outline.contains(at) || away < 0.12
                };
                (-1..=1)
                    .flat_map(|i| (-1..=1).map(move |j| [f64::from(i) * x_m, f64::from(j) * y_m]))
                    .any(|shift| pattern.centres_m().any(|centre| near([centre[0] + shift[0], centre[1] + shift[1]])))
            };
            let point = |i: u32, low: f64, high: f64| low + (f64::from(i) + 0.5) / 300.0 * (high - low);
            let counted = (0..300)
                .flat_map(|i| (0..300).map(move |j| (i, j)))
                .filter(|&(i, j)| inside([point(i, rectangle[0], rectangle[1]), point(j, rectangle[2], rectangle[3])]))
                .count() as f64
                / 9e4;
            let share = pattern.coverage_within(12e-6, [rectangle[0], rectangle[1]], [rectangle[2], rectangle[3]]);
            assert!((share - counted).abs() < 2e-3, "{share} {counted}");
        }
    }
}
