//! Area of a polygonal cavity seen from above.

use slipgrid_model::pattern::Polygon;
use slipgrid_model::pattern::geometry::{contains, edges, point_to_segment};

/// Polygonal cavity seen from above: outline, size and position, restricted to points at a minimum distance from the
/// walls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Face {
    pub(crate) outline: Polygon,
    pub(crate) centre_m: [f64; 2],
    /// Extent of the complete outline along x, in metres.
    pub(crate) width_m: f64,
    /// Minimum distance from the walls, in metres.
    pub(crate) inset_m: f64,
}

/// Number of lines per interval of the midpoint rule for the area. Intervals end at the heights at which the length of
/// a line within the walls may jump.
const INTEGRATION_LINES: u32 = 24;
/// Rounding tolerance of an inset, as a fraction.
const ROUNDING: f64 = 1e-9;

impl Face {
    /// Corners of the complete outline, in metres.
    pub(crate) fn corners_m(&self) -> Vec<[f64; 2]> {
        let [x_m, y_m] = self.centre_m;
        self.outline.vertices().iter().map(|[x, y]| [x_m + x * self.width_m, y_m + y * self.width_m]).collect()
    }

    /// Corners of the cavity after each wall has moved inwards by `inset_m` as a plane, in metres, one for each corner
    /// of the outline; `None` if a wall vanishes or walls cross.
    pub(crate) fn inner_corners_m(&self) -> Option<Vec<[f64; 2]>> {
        let corners = self.corners_m();
        if self.inset_m == 0.0 {
            return Some(corners);
        }
        let count = corners.len();
        let normal = |k: usize| {
            let ([xa, ya], [xb, yb]) = (corners[k % count], corners[(k + 1) % count]);
            let size = (xb - xa).hypot(yb - ya);
            [(ya - yb) / size, (xb - xa) / size]
        };
        let moved: Vec<[f64; 2]> = (0..count)
            .map(|k| {
                let (before, after) = (normal(k + count - 1), normal(k));
                // c + d (n1 + n2) / (1 + n1 n2)
                let share = self.inset_m / (1.0 + before[0] * after[0] + before[1] * after[1]);
                [0, 1].map(|axis| corners[k][axis] + share * (before[axis] + after[axis]))
            })
            .collect();
        let keeps_direction = |k: usize| {
            let next = (k + 1) % count;
            (0..2)
                .map(|axis| (corners[next][axis] - corners[k][axis]) * (moved[next][axis] - moved[k][axis]))
                .sum::<f64>()
                > 0.0
        };
        ((0..count).all(keeps_direction) && Polygon::new(&moved).is_ok()).then_some(moved)
    }

    /// Area of the points at least `inset_m` from the walls, in square metres.
    pub(crate) fn area_m2(&self) -> f64 {
        if self.inset_m == 0.0 {
            return self.outline.area() * self.width_m * self.width_m;
        }
        // Midpoint rule over the lengths of lines, between the heights at which these lengths may jump.
        let around = |y_m: f64| [y_m - self.inset_m, y_m, y_m + self.inset_m];
        let mut heights_m: Vec<f64> = self.corners_m().iter().flat_map(|[_, y_m]| around(*y_m)).collect();
        heights_m.sort_by(f64::total_cmp);
        let length_m =
            |at_m: f64| self.spans_m([1.0, 0.0], at_m).iter().map(|[from_m, to_m]| to_m - from_m).sum::<f64>();
        let between = |ends: &[f64]| {
            let height_m = (ends[1] - ends[0]) / f64::from(INTEGRATION_LINES);
            if height_m <= ROUNDING * self.inset_m {
                return 0.0;
            }
            (0..INTEGRATION_LINES).map(|k| length_m(ends[0] + (f64::from(k) + 0.5) * height_m)).sum::<f64>() * height_m
        };
        heights_m.windows(2).map(between).sum()
    }

    /// Distance from a point to the nearest wall, minus `inset_m`, in metres; negative outside.
    pub(crate) fn wall_distance_m(&self, at_m: [f64; 2]) -> f64 {
        let corners = self.corners_m();
        let nearest_m = edges(&corners).map(|(a, b)| point_to_segment(at_m, a, b)).fold(f64::INFINITY, f64::min);
        (if contains(&corners, at_m) { nearest_m } else { -nearest_m }) - self.inset_m
    }

    /// Intervals of a line at least `inset_m` inside the walls, in metres along the line and ascending. The line runs
    /// along the unit vector `[dx, dy]`, `at_m` to the left of the origin.
    pub(crate) fn spans_m(&self, [dx, dy]: [f64; 2], at_m: f64) -> Vec<[f64; 2]> {
        let turned: Vec<[f64; 2]> =
            self.corners_m().iter().map(|[x, y]| [x * dx + y * dy, y * dx - x * dy - at_m]).collect();
        let mut ends_m: Vec<f64> = edges(&turned).filter_map(|(a, b)| crossing_m(a, b)).collect();
        ends_m.sort_by(f64::total_cmp);
        let mut spans_m: Vec<[f64; 2]> = ends_m.chunks_exact(2).map(|ends| [ends[0], ends[1]]).collect();
        let inset_m = self.inset_m * (1.0 - ROUNDING);
        if inset_m > 0.0 {
            for taken_m in edges(&turned).filter_map(|(a, b)| interval_near_m(a, b, inset_m)) {
                spans_m = spans_m.into_iter().flat_map(|span_m| interval_outside(span_m, taken_m)).collect();
            }
        }
        spans_m
    }
}

/// Parts of the interval from `from` to `to` outside the interval from `low` to `high`.
pub(crate) fn interval_outside([from, to]: [f64; 2], [low, high]: [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
    let parts = if high <= from || low >= to { [[from, to], [0.0, 0.0]] } else { [[from, low], [high, to]] };
    parts.into_iter().filter(|[from, to]| to > from)
}

/// Position u at which the edge between two points (u, v) crosses the axis v = 0, in metres; `None` if it does not.
fn crossing_m([ua, va]: [f64; 2], [ub, vb]: [f64; 2]) -> Option<f64> {
    ((va <= 0.0) != (vb <= 0.0)).then(|| ua - va / (vb - va) * (ub - ua))
}

/// Interval of the axis v = 0 that is closer than `reach` to the edge from `a` to `b`, points (u, v) in metres: inside
/// the discs about its ends or the rectangle along it. `None` if there is none.
fn interval_near_m(a: [f64; 2], b: [f64; 2], reach: f64) -> Option<[f64; 2]> {
    if a[1].min(b[1]) >= reach || a[1].max(b[1]) <= -reach {
        return None;
    }
    let mut span = [f64::INFINITY, f64::NEG_INFINITY];
    let mut reaches = |at: f64| span = [span[0].min(at), span[1].max(at)];
    for [u, v] in [a, b] {
        if v.abs() < reach {
            let half = ((reach - v) * (reach + v)).sqrt();
            reaches(u - half);
            reaches(u + half);
        }
    }
    let size = (b[0] - a[0]).hypot(b[1] - a[1]);
    let side = [(a[1] - b[1]) / size * reach, (b[0] - a[0]) / size * reach];
    let corners = [
        [a[0] + side[0], a[1] + side[1]],
        [a[0] - side[0], a[1] - side[1]],
        [b[0] - side[0], b[1] - side[1]],
        [b[0] + side[0], b[1] + side[1]],
    ];
    edges(&corners).filter_map(|(a, b)| crossing_m(a, b)).for_each(reaches);
    (span[0] < span[1]).then_some(span)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::clip::area_m2;

    const L: [[f64; 2]; 6] = [[0.0, 0.0], [10.0, 0.0], [10.0, 4.0], [4.0, 4.0], [4.0, 10.0], [0.0, 10.0]];

    fn face(inset_m: f64) -> Face {
        Face { outline: Polygon::new(&L).unwrap(), centre_m: [105.0, -45.0], width_m: 10.0, inset_m }
    }

    #[test]
    fn what_is_left_within_walls() {
        assert!((face(0.0).area_m2() - 64.0).abs() < 1e-9);
        // By planes: 8 x 8 minus 6 x 6. By distance, a quarter disc of radius 1 is excluded at the concave corner
        // instead of a square.
        let planes = face(1.0).inner_corners_m().unwrap();
        assert!((area_m2(&planes) - 28.0).abs() < 1e-9, "{planes:?}");
        let kept = 28.0 + 1.0 - std::f64::consts::FRAC_PI_4;
        assert!((face(1.0).area_m2() - kept).abs() < 2e-3, "{}", face(1.0).area_m2());
        // Planes meet at 2; a disc of radius r fits into the corner up to (4 - r) sqrt 2 = r.
        assert_eq!(face(2.1).inner_corners_m(), None);
        assert!(face(2.3).area_m2() > 0.0 && face(2.4).area_m2() == 0.0);
        // The middle of the corner, the concave corner, a point outside.
        for (at_m, expected) in [([102.0, -48.0], 2.0), ([103.0, -47.0], 2_f64.sqrt()), ([106.0, -44.0], -2.0)] {
            assert!((face(0.0).wall_distance_m(at_m) - expected).abs() < 1e-9);
            assert!((face(0.5).wall_distance_m(at_m) - expected + 0.5).abs() < 1e-9);
        }
    }

    #[test]
    fn lines_end_where_the_walls_are_near() {
        let close = |spans: Vec<[f64; 2]>, expected: &[[f64; 2]]| {
            let near = |(a, b): (&[f64; 2], &[f64; 2])| (a[0] - b[0]).abs() < 1e-6 && (a[1] - b[1]).abs() < 1e-6;
            assert!(spans.len() == expected.len() && spans.iter().zip(expected).all(near), "{spans:?} {expected:?}");
        };
        // y = -48 is 2 above the lower side; the arm ends at 110.
        close(face(0.0).spans_m([1.0, 0.0], -48.0), &[[100.0, 110.0]]);
        close(face(1.0).spans_m([1.0, 0.0], -48.0), &[[101.0, 109.0]]);
        // At y = -46.5, within 1 of the upper side of the arm: up to where the concave corner at (104, -46) is 1 away.
        close(face(1.0).spans_m([1.0, 0.0], -46.5), &[[101.0, 104.0 - 0.75_f64.sqrt()]]);
        // Along y at x = 102: the offset to the left is -102.
        close(face(1.0).spans_m([0.0, 1.0], -102.0), &[[-49.0, -41.0]]);
        close(face(1.0).spans_m([0.0, 1.0], -120.0), &[]);
    }
}
