//! Points, segments and polygons in the plane.

/// Edges of a closed polygon, in order, each as its start and end.
pub fn edges(vertices: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
    let next = vertices.iter().skip(1).chain(vertices.first());
    vertices.iter().copied().zip(next.copied())
}

/// Twice the area of a closed polygon, positive if its vertices run anticlockwise.
pub(crate) fn doubled_area(vertices: &[[f64; 2]]) -> f64 {
    edges(vertices).map(|([xa, ya], [xb, yb])| xa * yb - xb * ya).sum()
}

/// Twice the signed area of the triangle a, b, c: positive if c lies left of the line from a to b.
pub(crate) fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether two closed segments have a common point.
pub(crate) fn meet([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> bool {
    let sides = [cross(a, b, c), cross(a, b, d), cross(c, d, a), cross(c, d, b)];
    let parts = |one: f64, other: f64| (one > 0.0 && other < 0.0) || (one < 0.0 && other > 0.0);
    if parts(sides[0], sides[1]) && parts(sides[2], sides[3]) {
        return true;
    }
    // An endpoint lies on the other segment.
    let within = |at: [f64; 2], [from, to]: [[f64; 2]; 2]| {
        (0..2).all(|axis| at[axis] >= from[axis].min(to[axis]) && at[axis] <= from[axis].max(to[axis]))
    };
    (sides[0] == 0.0 && within(c, [a, b]))
        || (sides[1] == 0.0 && within(d, [a, b]))
        || (sides[2] == 0.0 && within(a, [c, d]))
        || (sides[3] == 0.0 && within(b, [c, d]))
}

/// Distance of the point `at` from the segment from `a` to `b`; `a` and `b` may coincide.
pub fn point_to_segment(at: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let from = [at[0] - a[0], at[1] - a[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let share = if square > 0.0 { ((from[0] * along[0] + from[1] * along[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
    (from[0] - share * along[0]).hypot(from[1] - share * along[1])
}

/// Whether a point lies inside a closed polygon; the result is arbitrary for points on an edge.
pub fn contains(vertices: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    edges(vertices)
        .filter(|([xa, ya], [xb, yb])| (*ya <= y) != (*yb <= y) && xa + (y - ya) / (yb - ya) * (xb - xa) > x)
        .count()
        % 2
        == 1
}
