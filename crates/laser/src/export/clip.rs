//! Clipping of convex cavities to the specimen's outline, centred on the origin, in closed form.
//!
//! Polygons run anticlockwise. The part of a polygon inside a disc is bounded by its edges and by anticlockwise arcs;
//! the part outside by its edges and by clockwise arcs. Arcs are replaced by chords that deviate by at most
//! [`ARC_SAGITTA_M`].

use slipgrid_model::pattern::geometry::{contains, edges};

use crate::export::Outline;

/// Maximum deviation of a chord from its arc, in metres: a hundredth of the positioning accuracy of a laser.
pub(crate) const ARC_SAGITTA_M: f64 = 1e-8;

/// Minimum distance of two corners, in metres: files hold nanometres. A groove's corner on the border is also the point
/// where the border cuts its side.
const MIN_EDGE_M: f64 = 1e-9;
/// Minimum area of a part, in square metres, a square nanometre; smaller parts are rounding errors.
const MIN_AREA_M2: f64 = 1e-18;

type Polygon = Vec<[f64; 2]>;

/// Parts of a convex polygon that lie on the specimen.
pub(crate) fn clip(polygon: Polygon, outline: &Outline) -> Vec<Polygon> {
    let parts = match *outline {
        Outline::Disc { diameter_m } => vec![within_disc(&polygon, diameter_m / 2.0)],
        Outline::Rectangle { length_m, width_m } => {
            let sides =
                [([1.0, 0.0], length_m), ([-1.0, 0.0], length_m), ([0.0, 1.0], width_m), ([0.0, -1.0], width_m)];
            vec![sides.into_iter().fold(polygon, |left, (normal, extent_m)| within_side(&left, normal, extent_m / 2.0))]
        }
        Outline::Ring { outer_diameter_m, inner_diameter_m } => {
            outside_disc(&within_disc(&polygon, outer_diameter_m / 2.0), inner_diameter_m / 2.0)
        }
    };
    without_slivers(parts)
}

/// Removes corners and parts that are rounding errors.
pub(crate) fn without_slivers(mut parts: Vec<Polygon>) -> Vec<Polygon> {
    let are_one = |[xa, ya]: [f64; 2], [xb, yb]: [f64; 2]| (xa - xb).hypot(ya - yb) < MIN_EDGE_M;
    for part in &mut parts {
        part.dedup_by(|next, kept| are_one(*next, *kept));
        if part.len() > 1 && are_one(part[0], part[part.len() - 1]) {
            part.pop();
        }
    }
    parts.retain(|part| area_m2(part) > MIN_AREA_M2);
    parts
}

/// Parts of a convex polygon outside another convex polygon, which is given by `sides`: unit normals n and distances d
/// in metres, with n x <= d for all points x inside. The parts are convex and do not overlap.
pub(crate) fn outside_sides(polygon: Polygon, sides: &[([f64; 2], f64)]) -> Vec<Polygon> {
    let (mut parts, mut left) = (Vec::new(), polygon);
    for &([nx, ny], limit_m) in sides {
        parts.push(within_side(&left, [-nx, -ny], -limit_m));
        left = within_side(&left, [nx, ny], limit_m);
    }
    without_slivers(parts)
}

/// Area of a polygon, in square metres, positive if it runs anticlockwise.
pub(crate) fn area_m2(polygon: &[[f64; 2]]) -> f64 {
    // A = 1/2 sum (x_i y_i+1 - x_i+1 y_i), relative to the first corner, which preserves digits for small polygons far
    // from the origin.
    let Some(&[x0, y0]) = polygon.first() else { return 0.0 };
    let moved = |[x, y]: [f64; 2]| [x - x0, y - y0];
    edges(polygon)
        .map(|(a, b)| {
            let ([xa, ya], [xb, yb]) = (moved(a), moved(b));
            (xa * yb - xb * ya) / 2.0
        })
        .sum()
}

/// Approximates a circle by a polygon with its corners on the circle.
pub(crate) fn circle([x_m, y_m]: [f64; 2], radius_m: f64) -> Polygon {
    let count = chords(std::f64::consts::TAU, radius_m);
    (0..count)
        .map(|corner| {
            let angle = std::f64::consts::TAU * corner as f64 / count as f64;
            [x_m + radius_m * libm::cos(angle), y_m + radius_m * libm::sin(angle)]
        })
        .collect()
}

/// Outer border of `outline`, for a ring also that of its hole, as polygons of points `[x, y]` in metres.
pub(crate) fn rims(outline: &Outline) -> Vec<Vec<[f64; 2]>> {
    match *outline {
        Outline::Disc { diameter_m } => vec![circle([0.0; 2], diameter_m / 2.0)],
        Outline::Ring { outer_diameter_m, inner_diameter_m } => {
            [outer_diameter_m, inner_diameter_m].map(|diameter_m| circle([0.0; 2], diameter_m / 2.0)).to_vec()
        }
        Outline::Rectangle { length_m, width_m } => {
            let corner = |x: f64, y: f64| [x * length_m / 2.0, y * width_m / 2.0];
            vec![vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]]
        }
    }
}

/// Number of chords for an arc of `angle` radians, at least one.
fn chords(angle: f64, radius_m: f64) -> usize {
    // s = R (1 - cos(a/2)), a the angle of one chord.
    let one = 2.0 * libm::acos((1.0 - ARC_SAGITTA_M / radius_m).clamp(-0.5, 1.0));
    // At most some ten thousand on a specimen of metres.
    (angle / one).ceil().clamp(1.0, 1e6) as usize
}

pub(crate) fn at([xa, ya]: [f64; 2], [xb, yb]: [f64; 2], t: f64) -> [f64; 2] {
    [xa + t * (xb - xa), ya + t * (yb - ya)]
}

/// Part of the edge from `a` to `b` inside the disc of `radius_m` about the origin, as fractions of the edge; `None` if
/// no part is inside.
pub(crate) fn chord_in_disc(a: [f64; 2], b: [f64; 2], radius_m: f64) -> Option<[f64; 2]> {
    // |a + t (b - a)|^2 = R^2
    let along = [b[0] - a[0], b[1] - a[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let half = a[0] * along[0] + a[1] * along[1];
    let excess = a[0].hypot(a[1]) - radius_m;
    let rest = excess * (a[0].hypot(a[1]) + radius_m);
    let discriminant = half * half - square * rest;
    if square == 0.0 || discriminant <= 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    // To avoid cancellation, one root is a quotient and the other a product.
    let (t0, t1) = if half > 0.0 {
        (-(half + root) / square, -rest / (half + root))
    } else {
        (rest / (root - half), (root - half) / square)
    };
    let (t0, t1) = (t0.max(0.0), t1.min(1.0));
    (t0 < t1).then_some([t0, t1])
}

fn contains_origin(polygon: &[[f64; 2]]) -> bool {
    !polygon.is_empty() && edges(polygon).all(|([xa, ya], [xb, yb])| xa * yb - xb * ya > 0.0)
}

/// Part of the segment from `a` to `b` inside a convex polygon, as fractions of the segment; `None` if no part is
/// inside. `sides` are the unit normals of the polygon and the distances of the sides from the origin, in metres.
pub(crate) fn within_sides([a, b]: [[f64; 2]; 2], sides: &[([f64; 2], f64)]) -> Option<[f64; 2]> {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for &([nx, ny], limit_m) in sides {
        let [of_a, of_b] = [a, b].map(|[x, y]| x * nx + y * ny - limit_m);
        if of_a > 0.0 && of_b > 0.0 {
            return None;
        }
        if (of_a > 0.0) != (of_b > 0.0) {
            let crossing = of_a / (of_a - of_b);
            (from, to) = if of_a > 0.0 { (from.max(crossing), to) } else { (from, to.min(crossing)) };
        }
    }
    (from < to).then_some([from, to])
}

/// Points of a circle closer than this fraction of its radius count as equal: the arc between them is empty, not a full
/// turn.
const EQUAL_POINT_TOLERANCE: f64 = 1e-9;

fn is_one_point(a: [f64; 2], b: [f64; 2], radius_m: f64) -> bool {
    (a[0] - b[0]).hypot(a[1] - b[1]) <= EQUAL_POINT_TOLERANCE * radius_m
}

/// Appends the points of the arc between `from` and `to` on the circle of `radius_m` about the origin, without these
/// two.
pub(crate) fn push_arc(out: &mut Polygon, from: [f64; 2], to: [f64; 2], radius_m: f64, anticlockwise: bool) {
    if is_one_point(from, to, radius_m) {
        return;
    }
    let (start, end) = (libm::atan2(from[1], from[0]), libm::atan2(to[1], to[0]));
    let turn = if anticlockwise { end - start } else { start - end }.rem_euclid(std::f64::consts::TAU);
    let count = chords(turn, radius_m);
    for step in 1..count {
        let turned = turn * step as f64 / count as f64;
        let angle = if anticlockwise { start + turned } else { start - turned };
        out.push([radius_m * libm::cos(angle), radius_m * libm::sin(angle)]);
    }
}

/// Part of a polygon on the side x nx + y ny <= `limit_m`, in metres; `[nx, ny]` is a unit vector.
pub(crate) fn within_side(polygon: &[[f64; 2]], [nx, ny]: [f64; 2], limit_m: f64) -> Polygon {
    let beyond = |[x, y]: [f64; 2]| x * nx + y * ny - limit_m;
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (a, b) in edges(polygon) {
        let (of_a, of_b) = (beyond(a), beyond(b));
        if of_a <= 0.0 {
            kept.push(a);
        }
        if (of_a < 0.0 && of_b > 0.0) || (of_a > 0.0 && of_b < 0.0) {
            kept.push(at(a, b, of_a / (of_a - of_b)));
        }
    }
    kept
}

/// Part of a convex polygon inside the disc of `radius_m` about the origin.
fn within_disc(polygon: &[[f64; 2]], radius_m: f64) -> Polygon {
    let mut kept: Polygon = Vec::with_capacity(polygon.len() + 8);
    // Point where the boundary left the disc, and the corner inside at which the previous edge ended. If this corner
    // lies on the circle, it may be the last point inside, which the next edge does not show.
    let (mut exit, mut corner): (Option<[f64; 2]>, Option<[f64; 2]>) = (None, None);
    for (a, b) in edges(polygon) {
        let chord = chord_in_disc(a, b, radius_m);
        if let Some(left) = corner.take().filter(|_| chord.is_none_or(|[t0, _]| t0 > 0.0)) {
            kept.push(left);
            exit = Some(left);
        }
        let Some([t0, t1]) = chord else { continue };
        let start = at(a, b, t0);
        if let Some(left) = exit.take() {
            push_arc(&mut kept, left, start, radius_m, true);
        }
        kept.push(start);
        if t1 < 1.0 {
            let end = at(a, b, t1);
            kept.push(end);
            exit = Some(end);
        } else {
            corner = Some(b);
        }
    }
    let Some(&first) = kept.first() else {
        return if contains_origin(polygon) { circle([0.0; 2], radius_m) } else { kept };
    };
    if let Some(left) = corner.filter(|corner| !is_one_point(*corner, first, radius_m)) {
        kept.push(left);
        exit = Some(left);
    }
    if let Some(left) = exit {
        push_arc(&mut kept, left, first, radius_m, true);
    }
    kept
}

/// Parts of a polygon outside the disc of `radius_m` about the origin.
pub(crate) fn outside_disc(polygon: &[[f64; 2]], radius_m: f64) -> Vec<Polygon> {
    // Runs of the boundary outside the disc: each starts where it leaves the disc and ends where it enters.
    let mut runs: Vec<Polygon> = Vec::new();
    let mut current: Polygon = Vec::new();
    let starts_outside = polygon.first().is_some_and(|[x, y]| x.hypot(*y) > radius_m);
    for (a, b) in edges(polygon) {
        let Some([t0, t1]) = chord_in_disc(a, b, radius_m) else {
            current.push(a);
            continue;
        };
        if t0 > 0.0 {
            current.push(a);
            current.push(at(a, b, t0));
            runs.push(std::mem::take(&mut current));
        }
        if t1 < 1.0 {
            current.push(at(a, b, t1));
        }
    }
    if runs.is_empty() {
        if starts_outside && (contains_origin(polygon) || contains(polygon, [0.0; 2])) {
            // The disc lies inside the polygon: two halves have no hole.
            let half = |side: f64| outside_disc(&within_side(polygon, [side, 0.0], 0.0), radius_m);
            return [half(1.0), half(-1.0)].concat();
        }
        return if starts_outside { vec![current] } else { Vec::new() };
    }
    if starts_outside {
        current.append(&mut runs[0]);
        runs[0] = current;
    } else if !current.is_empty() {
        runs.push(current);
    }
    let angle = |[x, y]: [f64; 2]| libm::atan2(y, x);
    let clockwise = |end, start| (angle(end) - angle(start)).rem_euclid(std::f64::consts::TAU);
    join_runs(&runs, clockwise, |part, from, to| push_arc(part, from, to, radius_m, false))
}

/// Joins runs, parts of a polygon's boundary, along a border into closed polygons: from the end of each run to the
/// start of a run with the smallest distance `away` along the border, which may be the start of this run.
/// `push_between` appends the border between end and start.
pub(crate) fn join_runs(
    runs: &[Polygon],
    away: impl Fn([f64; 2], [f64; 2]) -> f64,
    push_between: impl Fn(&mut Polygon, [f64; 2], [f64; 2]),
) -> Vec<Polygon> {
    let ends: Vec<[[f64; 2]; 2]> =
        runs.iter().filter_map(|run| run.first().copied().zip(run.last().copied())).map(|(s, e)| [s, e]).collect();
    let mut free = vec![true; ends.len()];
    let mut parts = Vec::new();
    for first in 0..ends.len() {
        if !free[first] {
            continue;
        }
        let (mut part, mut run) = (Vec::new(), first);
        loop {
            free[run] = false;
            part.extend_from_slice(&runs[run]);
            let [_, end] = ends[run];
            let far = |next: usize| away(end, ends[next][0]);
            let next =
                (0..ends.len()).filter(|&next| free[next] || next == first).min_by(|&a, &b| far(a).total_cmp(&far(b)));
            let Some(next) = next else { break };
            push_between(&mut part, end, ends[next][0]);
            if next == first {
                break;
            }
            run = next;
        }
        parts.push(part);
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn rectangle([x0, x1]: [f64; 2], [y0, y1]: [f64; 2]) -> Polygon {
        vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]
    }

    const DISC: Outline = Outline::Disc { diameter_m: 2.0 };
    const RING: Outline = Outline::Ring { outer_diameter_m: 2.0, inner_diameter_m: 1.0 };

    /// Areas of the parts of a rectangle on `outline`, compared with closed forms; chords cause a relative error of a
    /// few 1e-8.
    fn close(x: [f64; 2], y: [f64; 2], outline: Outline, expected: &[f64]) {
        let mut areas: Vec<f64> = clip(rectangle(x, y), &outline).iter().map(|part| area_m2(part)).collect();
        areas.sort_by(f64::total_cmp);
        assert_eq!(areas.len(), expected.len(), "{x:?} {y:?}: {areas:?}");
        for (area, expected) in areas.iter().zip(expected) {
            assert!((area - expected).abs() < 1e-7, "{x:?} {y:?}: {area} for {expected}");
        }
    }

    /// Segment of a disc of radius r beyond the distance d from its centre: r^2 acos(d/r) - d sqrt(r^2 - d^2).
    fn segment(r: f64, d: f64) -> f64 {
        r * r * (d / r).acos() - d * (r * r - d * d).sqrt()
    }

    #[test]
    fn parts_of_a_disc() {
        close([-2.0, 2.0], [-2.0, 2.0], DISC, &[PI]);
        close([0.5, 2.0], [-2.0, 2.0], DISC, &[segment(1.0, 0.5)]);
        close([-0.25, 0.25], [-2.0, 2.0], DISC, &[PI - 2.0 * segment(1.0, 0.25)]);
        close([0.0, 2.0], [0.0, 2.0], DISC, &[PI / 4.0]);
        // Completely inside, completely outside.
        close([0.1, 0.2], [0.1, 0.3], DISC, &[0.02]);
        close([0.9, 1.2], [0.9, 1.2], DISC, &[]);
    }

    #[test]
    fn parts_of_a_ring() {
        let disc = |d: f64| segment(1.0, d) - if d < 0.5 { segment(0.5, d) } else { 0.0 };
        close([-2.0, 2.0], [-2.0, 2.0], RING, &[3.0 * PI / 8.0, 3.0 * PI / 8.0]);
        close([0.6, 2.0], [-2.0, 2.0], RING, &[disc(0.6)]);
        close([0.25, 2.0], [-2.0, 2.0], RING, &[disc(0.25)]);
        // A strip through the hole leaves two parts, one along its edge leaves one.
        close([-0.1, 0.1], [-2.0, 2.0], RING, &[disc(-0.1) / 2.0 - disc(0.1) / 2.0; 2]);
        close([0.45, 0.55], [-2.0, 2.0], RING, &[disc(0.45) - disc(0.55)]);
        close([-0.2, 0.2], [-0.2, 0.2], RING, &[]);
        close([0.0, 2.0], [0.0, 2.0], RING, &[3.0 * PI / 16.0]);
        close([0.6, 0.65], [-0.1, 0.1], RING, &[0.01]);
    }

    #[test]
    fn parts_of_a_rectangle() {
        let outline = Outline::Rectangle { length_m: 2.0, width_m: 1.0 };
        close([0.5, 3.0], [-3.0, 0.25], outline, &[0.5 * 0.75]);
        close([2.0, 3.0], [-3.0, 0.25], outline, &[]);
        let quarter: f64 = clip(circle([1.0, 0.5], 0.3), &outline).iter().map(|part| area_m2(part)).sum();
        assert!((quarter - PI * 0.09 / 4.0).abs() < 1e-7, "{quarter}");
    }

    #[test]
    fn every_corner_of_a_part_lies_on_the_specimen() {
        for part in clip(rectangle([-0.3, 0.1], [-2.0, 2.0]), &RING) {
            for [x, y] in part {
                let distance = x.hypot(y);
                assert!((0.5 - 1e-12..=1.0 + 1e-12).contains(&distance) && (-0.3..=0.1).contains(&x));
            }
        }
    }
}
