//! Area of a rectangle that is covered by a periodic array of shapes, in closed form.
//!
//! Whole periods are counted; the remainder is the sum over the few shapes that reach into it. All terms of a sum are
//! non-negative, so that nothing cancels for small rectangles.

use crate::pattern::geometry::edges;

/// A cavity seen from above, with its centre at the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Shape<'a> {
    /// A strip that is infinite along y.
    Strip { width_m: f64 },
    /// A rectangle, `width_m` along x and `length_m` along y, with corners rounded to quarter discs of radius
    /// `corner_m`.
    Rectangle { width_m: f64, length_m: f64, corner_m: f64 },
    /// A disc.
    Disc { diameter_m: f64 },
    /// A simple anticlockwise polygon: `scale_m` times its vertices, within `extents_m` about the origin.
    Polygon { vertices: &'a [[f64; 2]], scale_m: f64, extents_m: [f64; 2] },
    /// A region given by the pieces of its boundary, in any order, with the inside on their left, and scaled like a
    /// polygon.
    Pieces { pieces: &'a [[[f64; 2]; 2]], scale_m: f64, extents_m: [f64; 2] },
}

/// Positions of equal shapes: `centre_m` plus integer multiples of `cell_m` along x and y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sublattice {
    pub(crate) centre_m: [f64; 2],
    pub(crate) cell_m: [f64; 2],
}

/// Area, in square metres, of the rectangle `x_m` by `y_m` that is covered by copies of `shape` at the positions of
/// `sublattice`; the copies do not overlap.
pub(crate) fn covered_area(shape: Shape<'_>, sublattice: &Sublattice, x_m: [f64; 2], y_m: [f64; 2]) -> f64 {
    let [cell_x_m, cell_y_m] = sublattice.cell_m;
    let [centre_x_m, centre_y_m] = sublattice.centre_m;
    if let Shape::Strip { width_m } = shape {
        let covered_m: f64 = pieces(x_m, cell_x_m)
            .map(|(count, piece_m)| {
                count * near(piece_m, centre_x_m, cell_x_m, width_m).map(|x_m| overlap(x_m, width_m)).sum::<f64>()
            })
            .sum();
        return covered_m * (y_m[1] - y_m[0]);
    }
    let (width_m, length_m) = match shape {
        Shape::Rectangle { width_m, length_m, .. }
        | Shape::Polygon { extents_m: [width_m, length_m], .. }
        | Shape::Pieces { extents_m: [width_m, length_m], .. } => (width_m, length_m),
        Shape::Strip { width_m: side_m } | Shape::Disc { diameter_m: side_m } => (side_m, side_m),
    };
    let mut area_m2 = 0.0;
    for (count_x, piece_x_m) in pieces(x_m, cell_x_m) {
        for (count_y, piece_y_m) in pieces(y_m, cell_y_m) {
            let mut piece_m2 = 0.0;
            for x_m in near(piece_x_m, centre_x_m, cell_x_m, width_m) {
                for y_m in near(piece_y_m, centre_y_m, cell_y_m, length_m) {
                    piece_m2 += match shape {
                        Shape::Disc { diameter_m } => disc_area(diameter_m / 2.0, x_m, y_m),
                        Shape::Polygon { vertices, scale_m, .. } => area_within(edges(vertices), scale_m, x_m, y_m),
                        Shape::Pieces { pieces, scale_m, .. } => {
                            area_within(pieces.iter().map(|[a, b]| (*a, *b)), scale_m, x_m, y_m)
                        }
                        Shape::Rectangle { corner_m, .. } if corner_m > 0.0 => {
                            round_rectangle_area([width_m, length_m], corner_m, x_m, y_m)
                        }
                        _ => overlap(x_m, width_m) * overlap(y_m, length_m),
                    };
                }
            }
            area_m2 += count_x * count_y * piece_m2;
        }
    }
    area_m2
}

/// Splits `interval_m` into whole periods and a remainder: returns the number of periods with the first period, if
/// there is one, and the number 1 with the remainder.
fn pieces(interval_m: [f64; 2], period_m: f64) -> impl Iterator<Item = (f64, [f64; 2])> {
    let [low_m, high_m] = interval_m;
    let periods = ((high_m - low_m) / period_m).floor();
    let rest = (1.0, [(low_m + periods * period_m).min(high_m), high_m]);
    (periods > 0.0).then_some((periods, [low_m, low_m + period_m])).into_iter().chain([rest])
}

/// Ends of `interval_m`, in metres, relative to the centre of each shape of extent `extent_m` that overlaps the
/// interval. Shapes are centred at `centre_m` + k `period_m` for all integers k; the interval is at most a period long.
fn near(interval_m: [f64; 2], centre_m: f64, period_m: f64, extent_m: f64) -> impl Iterator<Item = [f64; 2]> {
    let [low_m, high_m] = interval_m.map(|end_m| end_m - centre_m);
    let first = ((low_m - extent_m / 2.0) / period_m).ceil();
    // Shapes are shorter than two periods, so that at most four can reach into one.
    (0..4).map(move |k| (first + f64::from(k)) * period_m).filter_map(move |shift_m| {
        let seen_m = [low_m - shift_m, high_m - shift_m];
        (seen_m[0] < extent_m / 2.0 && seen_m[1] > -extent_m / 2.0).then_some(seen_m)
    })
}

/// Length of the intersection of the interval with [-extent/2, extent/2], in metres.
fn overlap([low_m, high_m]: [f64; 2], extent_m: f64) -> f64 {
    let half_m = extent_m / 2.0;
    (high_m.min(half_m) - low_m.max(-half_m)).max(0.0)
}

/// Area of the intersection of the rectangle `x` by `y` with the region enclosed by `scale` times `boundary`, whose
/// edges have the inside on their left: the sum over the edges of the area below each edge within the rectangle,
/// positive towards lower x. No term exceeds the area of the rectangle.
fn area_within(
    boundary: impl Iterator<Item = ([f64; 2], [f64; 2])>,
    scale: f64,
    [x0, x1]: [f64; 2],
    [y0, y1]: [f64; 2],
) -> f64 {
    let height = y1 - y0;
    let below = |([xa, ya], [xb, yb]): ([f64; 2], [f64; 2])| {
        let ([xa, xb], [ha, hb]) = ([xa * scale, xb * scale], [ya * scale - y0, yb * scale - y0]);
        let (from, to) = (xa.clamp(x0, x1), xb.clamp(x0, x1));
        if from == to {
            return 0.0;
        }
        let at = |x: f64| if x == xb { hb } else { ha + (x - xa) / (xb - xa) * (hb - ha) };
        (from - to) * mean_clamped([at(from), at(to)], height)
    };
    boundary.map(below).sum::<f64>().max(0.0)
}

/// Mean of a height that varies linearly from `one` to `other` and is clamped to [0, max].
fn mean_clamped([one, other]: [f64; 2], max: f64) -> f64 {
    let (low, high) = (one.min(other), one.max(other));
    if high <= 0.0 {
        return 0.0;
    }
    if low >= max {
        return max;
    }
    let (from, to) = (low.max(0.0), high.min(max));
    if high == low {
        return from;
    }
    // 1/(high - low) times the integral of h from `from` to `to`, and of `max` from there to high.
    ((to - from) * (to + from) / 2.0 + max * (high - to)) / (high - low)
}

/// Area of the intersection of the rectangle `x` by `y` with a rectangle about the origin whose corners are quarter
/// discs of `radius`: two rectangles without the corners, plus the quarter discs.
fn round_rectangle_area([width, length]: [f64; 2], radius: f64, x: [f64; 2], y: [f64; 2]) -> f64 {
    let (straight_x, straight_y) = (width - 2.0 * radius, length - 2.0 * radius);
    let ends = (overlap(y, length) - overlap(y, straight_y)).max(0.0);
    let mut area = overlap(x, width) * overlap(y, straight_y) + overlap(x, straight_x) * ends;
    for x in quadrant_sides(x) {
        for y in quadrant_sides(y) {
            let from_corner = |side: [f64; 2], half: f64| side.map(|end| (end - half).max(0.0));
            area += quarter_disc_area(radius, from_corner(x, straight_x / 2.0), from_corner(y, straight_y / 2.0));
        }
    }
    area
}

/// Area of the intersection of the rectangle `x` by `y` with a disc about the origin.
fn disc_area(radius: f64, x: [f64; 2], y: [f64; 2]) -> f64 {
    let mut area = 0.0;
    for x in quadrant_sides(x) {
        for y in quadrant_sides(y) {
            area += quarter_disc_area(radius, x, y);
        }
    }
    area
}

/// Splits an interval at zero; both parts are mirrored to the positive side.
fn quadrant_sides([low, high]: [f64; 2]) -> [[f64; 2]; 2] {
    [[low.max(0.0), high.max(0.0)], [(-high).max(0.0), (-low).max(0.0)]]
}

/// Area of the intersection of a disc about the origin with the rectangle `x` by `y`, whose coordinates are not
/// negative.
fn quarter_disc_area(radius: f64, [x0, x1]: [f64; 2], [y0, y1]: [f64; 2]) -> f64 {
    if y0 >= radius || x0 >= radius || x1 <= x0 || y1 <= y0 {
        return 0.0;
    }
    // h(x) = sqrt((R - x)(R + x)): the arc; 0 outside.
    let edge = |x: f64| if x < radius { ((radius - x) * (radius + x)).sqrt() } else { 0.0 };
    // The arc is above y1 up to x = h(y1) and above y0 up to x = h(y0).
    let full = edge(y1).max(x0).min(x1);
    let end = edge(y0).max(full).min(x1);
    let under_top = (full - x0) * (y1 - y0);
    // Below the arc from x = full to x = end: a trapezoid and the segment between chord and arc,
    // R^2 (theta - sin theta) / 2 with chord = 2 R sin(theta / 2).
    let heights = [full, end].map(|x| (edge(x).min(y1) - y0).max(0.0));
    let trapezoid = (end - full) * (heights[0] + heights[1]) / 2.0;
    let chord = (end - full).hypot(heights[0] - heights[1]);
    let theta = 2.0 * libm::asin((chord / (2.0 * radius)).min(1.0));
    let segment = radius * radius * angle_less_sine(theta) / 2.0;
    under_top + trapezoid + segment
}

/// theta - sin(theta), accurate to a few units in the last place for small angles as well.
fn angle_less_sine(theta: f64) -> f64 {
    if theta > 0.5 {
        return theta - libm::sin(theta);
    }
    // theta^3/3! - theta^5/5! + ...: after eight terms the remainder is below rounding.
    let square = theta * theta;
    let mut term = theta * square / 6.0;
    let mut sum = term;
    for k in 2..=8 {
        let n = f64::from(2 * k);
        term *= -square / (n * (n + 1.0));
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_4, PI};

    #[test]
    fn parts_of_a_disc_of_radius_one() {
        let close = |x, y, expected: f64| {
            let area = disc_area(1.0, x, y);
            assert!((area - expected).abs() < 1e-15 * expected.max(1.0), "{x:?} {y:?}: {area} for {expected}");
        };
        close([-1.0, 1.0], [-1.0, 1.0], PI);
        close([-9.0, 9.0], [-9.0, 9.0], PI);
        close([0.0, 1.0], [0.0, 1.0], FRAC_PI_4);
        close([-0.5, 0.5], [-0.5, 0.5], 1.0);
        // Half the disc beyond x = 1/2: segment of 120 degrees, (2 pi / 3 - sin 120) / 2.
        close([0.5, 2.0], [-2.0, 2.0], (2.0 * PI / 3.0 - 0.75_f64.sqrt()) / 2.0);
        // Part of the quadrant beyond x = y = 1/2: pi/12 - (sqrt 3 - 1)/4.
        close([0.5, 1.0], [0.5, 1.0], PI / 12.0 - (3_f64.sqrt() - 1.0) / 4.0);
        close([0.8, 1.0], [0.8, 1.0], 0.0);
        close([1.0, 2.0], [0.0, 1.0], 0.0);
    }

    #[test]
    fn a_disc_in_thin_slices_keeps_its_area() {
        // Finest blocks in use: a disc of a thousand by a thousand.
        let side = 2e-3;
        let rows = |x: [f64; 2]| -> f64 {
            (-500..500).map(|j| disc_area(1.0, x, [f64::from(j) * side, f64::from(j + 1) * side])).sum()
        };
        let area: f64 = (-500..500).map(|i| rows([f64::from(i) * side, f64::from(i + 1) * side])).sum();
        assert!((area - PI).abs() < 1e-12, "{}", area - PI);
        // A block on the edge, compared with the midpoint rule, to a billionth of the block.
        let (x, y) = ([0.6, 0.6 + side], [0.799, 0.799 + side]);
        let steps = 20_000;
        let midpoints = (0..steps).map(|i| x[0] + side * (f64::from(i) + 0.5) / f64::from(steps));
        let numeric: f64 =
            midpoints.map(|x| ((1.0 - x * x).sqrt() - y[0]).clamp(0.0, side)).sum::<f64>() * side / f64::from(steps);
        assert!((disc_area(1.0, x, y) - numeric).abs() < 1e-9 * side * side);
    }

    #[test]
    fn a_small_angle_less_its_sine_keeps_its_digits() {
        for theta in [0.49_f64, 0.5, 0.51] {
            assert!((angle_less_sine(theta) / (theta - theta.sin()) - 1.0).abs() < 1e-14);
        }
        let theta: f64 = 1e-6;
        assert!((angle_less_sine(theta) / (theta.powi(3) / 6.0) - 1.0).abs() < 1e-12);
    }
}
