//! Approximates curves of drawings by chords.

use std::f64::consts::{PI, TAU};

use super::{Corners, FLATTENING};
use slipgrid_base::statistics::extremes;

/// Maximum number of chords of one curve; the tolerance `FLATTENING` requires some hundreds.
const MAX_CHORDS: f64 = 1000.0;

fn extent(points: &[[f64; 2]]) -> f64 {
    let along = |axis: usize| {
        let [low, high] = extremes(points.iter().map(|point| point[axis]));
        high - low
    };
    along(0).max(along(1))
}

/// Appends chords of the Bezier curve with the control points `points`, 3 or 4; the first point of the curve is not
/// appended.
pub(super) fn push_bezier(out: &mut Corners, points: &[[f64; 2]]) {
    // A chord of 1/n departs by at most |B''|/(8 n^2), |B''| <= d (d - 1) max |p_i - 2 p_i+1 + p_i+2|.
    let bend = |three: &[[f64; 2]]| {
        (0..2).map(|axis| three[0][axis] - 2.0 * three[1][axis] + three[2][axis]).fold(0.0, |sum: f64, b| sum.hypot(b))
    };
    let degree = points.len() as f64 - 1.0;
    let most = points.windows(3).map(bend).fold(0.0, f64::max);
    let count = (degree * (degree - 1.0) * most / (8.0 * FLATTENING * extent(points))).sqrt().ceil();
    // At most MAX_CHORDS, so the cast is exact. If all points coincide the count is NaN, which clamps to itself and
    // casts to 0.
    let count = count.clamp(1.0, MAX_CHORDS) as u32;
    for step in 1..=count.max(1) {
        let t = f64::from(step) / f64::from(count.max(1));
        let mut left = points.to_vec();
        // De Casteljau's algorithm.
        while left.len() > 1 {
            left = left
                .windows(2)
                .map(|two| [0, 1].map(|axis| two[0][axis] + t * (two[1][axis] - two[0][axis])))
                .collect();
        }
        out.extend(left);
    }
    if let (Some(end), Some(last)) = (points.last(), out.last_mut()) {
        *last = *end;
    }
}

/// Number of chords for an arc of `angle`, in radians; at least one.
fn chords(angle: f64) -> u32 {
    // s = r (1 - cos(a/2)) = FLATTENING 2 r, a the angle of one chord.
    let one = 2.0 * libm::acos(1.0 - 2.0 * FLATTENING);
    // At most MAX_CHORDS, so the cast is exact.
    (angle.abs() / one).ceil().clamp(1.0, MAX_CHORDS) as u32
}

/// Corners on the ellipse with the centre (x, y) and the radii rx and ry, by increasing angle from the largest x.
pub(super) fn ellipse([x, y]: [f64; 2], [rx, ry]: [f64; 2]) -> Corners {
    let count = chords(TAU);
    let angle = |step: u32| TAU * f64::from(step) / f64::from(count);
    (0..count).map(|step| [x + rx * libm::cos(angle(step)), y + ry * libm::sin(angle(step))]).collect()
}

/// Appends chords of the arc from `from` to `to` of an ellipse with these radii, turned by `turned_deg`, by the rules
/// of SVG: `large` selects an arc of more than half a turn, `sweeps` an arc in the direction of increasing angles. The
/// point `from` is not appended. Radii that are too small for the two points are enlarged.
///
/// W3C, "Scalable Vector Graphics (SVG) 1.1", F.6.
pub(super) fn push_arc(
    out: &mut Corners,
    from: [f64; 2],
    to: [f64; 2],
    (radii, turned_deg): ([f64; 2], f64),
    [large, sweeps]: [bool; 2],
) {
    let [mut rx, mut ry] = radii.map(f64::abs);
    if rx == 0.0 || ry == 0.0 || from == to {
        out.push(to);
        return;
    }
    let (sine, cosine) = (libm::sin(turned_deg.to_radians()), libm::cos(turned_deg.to_radians()));
    let half = [(from[0] - to[0]) / 2.0, (from[1] - to[1]) / 2.0];
    let [x, y] = [cosine * half[0] + sine * half[1], cosine * half[1] - sine * half[0]];
    let reach = (x / rx).hypot(y / ry);
    if reach > 1.0 {
        (rx, ry) = (rx * reach, ry * reach);
    }
    // c' = +- sqrt(1/|q|^2 - 1) (rx q_y, -ry q_x), q = (x/rx, y/ry)
    let q = [x / rx, y / ry];
    let square = q[0] * q[0] + q[1] * q[1];
    let side = if large == sweeps { -1.0 } else { 1.0 };
    let away = side * (1.0 / square - 1.0).max(0.0).sqrt();
    let (cx, cy) = (away * rx * q[1], -away * ry * q[0]);
    let centre = [
        cosine * cx - sine * cy + f64::midpoint(from[0], to[0]),
        sine * cx + cosine * cy + f64::midpoint(from[1], to[1]),
    ];
    let start = libm::atan2((y - cy) / ry, (x - cx) / rx);
    let end = libm::atan2((-y - cy) / ry, (-x - cx) / rx);
    let turn = (end - start).rem_euclid(TAU);
    let turn = if sweeps { turn } else { turn - TAU };
    let count = chords(turn);
    for step in 1..count {
        let angle = start + turn * f64::from(step) / f64::from(count);
        let (along, across) = (rx * libm::cos(angle), ry * libm::sin(angle));
        out.push([centre[0] + cosine * along - sine * across, centre[1] + sine * along + cosine * across]);
    }
    out.push(to);
}

/// Appends chords of the arc from `from` to `to` with the DXF `bulge`, the tangent of a quarter of the arc's angle,
/// positive anticlockwise. The point `from` is not appended.
pub(super) fn push_bulge(out: &mut Corners, from: [f64; 2], to: [f64; 2], bulge: f64) {
    let chord = (to[0] - from[0]).hypot(to[1] - from[1]);
    if bulge == 0.0 || chord == 0.0 {
        out.push(to);
        return;
    }
    let angle = 4.0 * libm::atan(bulge);
    // r = chord / (2 sin(angle/2))
    let radius = chord / (2.0 * libm::sin(angle.abs() / 2.0));
    push_arc(out, from, to, ([radius; 2], 0.0), [angle.abs() > PI, bulge > 0.0]);
}
