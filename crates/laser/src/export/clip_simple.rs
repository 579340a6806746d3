//! Clipping of polygons, also concave ones, to the specimen's outline.
//!
//! The parts of the polygon's boundary inside the outline (runs) are joined along the outline anticlockwise, from the
//! end of each run to the next start of a run, as in [`crate::export::clip`].

use std::f64::consts::TAU;

use slipgrid_model::pattern::geometry::{contains, edges};

use crate::export::Outline;
use crate::export::clip::{at, chord_in_disc, join_runs, outside_disc, push_arc, rims, without_slivers};

type Polygon = Vec<[f64; 2]>;

/// Parts of a simple anticlockwise polygon that lie on the specimen.
pub(crate) fn clip_simple(polygon: &[[f64; 2]], outline: &Outline) -> Vec<Polygon> {
    let parts = within(polygon, outline);
    without_slivers(match *outline {
        Outline::Ring { inner_diameter_m, .. } => {
            parts.iter().flat_map(|part| outside_disc(part, inner_diameter_m / 2.0)).collect()
        }
        _ => parts,
    })
}

/// Part of the edge from `a` to `b` inside the outer border, as fractions of the edge; `None` if no part is inside.
fn chord(outline: &Outline, a: [f64; 2], b: [f64; 2]) -> Option<[f64; 2]> {
    let half_m = match *outline {
        Outline::Disc { diameter_m } | Outline::Ring { outer_diameter_m: diameter_m, .. } => {
            return chord_in_disc(a, b, diameter_m / 2.0);
        }
        Outline::Rectangle { length_m, width_m } => [length_m / 2.0, width_m / 2.0],
    };
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let along = b[axis] - a[axis];
        if along == 0.0 {
            if a[axis].abs() > half_m[axis] {
                return None;
            }
            continue;
        }
        let ends = [(-half_m[axis] - a[axis]) / along, (half_m[axis] - a[axis]) / along];
        from = from.max(ends[0].min(ends[1]));
        to = to.min(ends[0].max(ends[1]));
    }
    (from < to).then_some([from, to])
}

/// Appends the corners of the outer border between its points `from` and `to`, anticlockwise, without these points.
fn push_between(outline: &Outline, out: &mut Polygon, from: [f64; 2], to: [f64; 2]) {
    match *outline {
        Outline::Disc { diameter_m } | Outline::Ring { outer_diameter_m: diameter_m, .. } => {
            push_arc(out, from, to, diameter_m / 2.0, true);
        }
        Outline::Rectangle { .. } => {
            let way = anticlockwise(from, to);
            let mut corners = rims(outline).concat();
            corners.retain(|corner| anticlockwise(from, *corner) < way);
            corners.sort_by(|a, b| anticlockwise(from, *a).total_cmp(&anticlockwise(from, *b)));
            out.extend(corners);
        }
    }
}

/// Angle about the origin from one point to another, anticlockwise in radians, from 0 to 2 pi; a full turn within
/// rounding is zero.
fn anticlockwise(from: [f64; 2], to: [f64; 2]) -> f64 {
    let turn = (libm::atan2(to[1], to[0]) - libm::atan2(from[1], from[0])).rem_euclid(TAU);
    if turn > TAU - 1e-12 { 0.0 } else { turn }
}

/// Parts of a simple anticlockwise polygon inside the outer border, which is convex.
fn within(polygon: &[[f64; 2]], outline: &Outline) -> Vec<Polygon> {
    // Runs of the boundary inside the border: each starts where it enters and ends where it leaves.
    let mut runs: Vec<Polygon> = Vec::new();
    let mut current: Polygon = Vec::new();
    let mut starts_within = None;
    for (a, b) in edges(polygon) {
        let chord = chord(outline, a, b);
        starts_within.get_or_insert(chord.is_some_and(|[from, _]| from <= 0.0));
        if chord.is_none_or(|[from, _]| from > 0.0) && !current.is_empty() {
            // The previous edge ended on the border.
            current.push(a);
            runs.push(std::mem::take(&mut current));
        }
        let Some([from, to]) = chord else { continue };
        current.push(if from > 0.0 { at(a, b, from) } else { a });
        if to < 1.0 {
            current.push(at(a, b, to));
            runs.push(std::mem::take(&mut current));
        }
    }
    if runs.is_empty() {
        if !current.is_empty() {
            return vec![current];
        }
        return if contains(polygon, [0.0; 2]) { rims(outline)[..1].to_vec() } else { Vec::new() };
    }
    if !current.is_empty() {
        if starts_within == Some(true) {
            current.append(&mut runs[0]);
            runs[0] = current;
        } else {
            runs.push(current);
        }
    }
    join_runs(&runs, anticlockwise, |part, from, to| push_between(outline, part, from, to))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::clip::{area_m2, clip};

    fn areas(parts: &[Polygon]) -> Vec<f64> {
        let mut areas: Vec<f64> = parts.iter().map(|part| area_m2(part)).collect();
        areas.sort_by(f64::total_cmp);
        areas
    }

    const DISC: Outline = Outline::Disc { diameter_m: 2.0 };
    const PLATE: Outline = Outline::Rectangle { length_m: 2.0, width_m: 1.0 };
    const RING: Outline = Outline::Ring { outer_diameter_m: 2.0, inner_diameter_m: 0.6 };

    #[test]
    fn convex_polygons_are_clipped_as_those_are() {
        let triangle = [[0.0, -0.1], [0.4, 0.0], [0.1, 0.5]];
        for (dx, dy) in (-6..=6).flat_map(|i| (-6..=6).map(move |j| (f64::from(i) * 0.17, f64::from(j) * 0.19))) {
            let moved: Polygon = triangle.iter().map(|[x, y]| [x + dx, y + dy]).collect();
            for outline in [DISC, PLATE, RING] {
                let (simple, convex) = (areas(&clip_simple(&moved, &outline)), areas(&clip(moved.clone(), &outline)));
                assert_eq!(simple.len(), convex.len(), "{dx} {dy} {outline:?} {simple:?} {convex:?}");
                assert!(simple.iter().zip(&convex).all(|(a, b)| (a - b).abs() < 1e-12), "{dx} {dy} {outline:?}");
            }
        }
        // A polygon that covers the whole specimen gives the specimen.
        let all = vec![[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]];
        assert_eq!(areas(&clip_simple(&all, &PLATE)), [2.0]);
        assert!(
            (areas(&clip_simple(&all, &RING)).iter().sum::<f64>() / (std::f64::consts::PI * 0.91) - 1.0).abs() < 1e-6
        );
    }

    #[test]
    fn what_is_left_of_a_comb_is_its_teeth() {
        // A comb whose back lies outside: three teeth 0.2 wide that reach to x = 0.5.
        let comb = vec![
            [3.0, 0.5],
            [0.5, 0.5],
            [0.5, 0.3],
            [2.5, 0.3],
            [2.5, 0.1],
            [0.5, 0.1],
            [0.5, -0.1],
            [2.5, -0.1],
            [2.5, -0.3],
            [0.5, -0.3],
            [0.5, -0.5],
            [3.0, -0.5],
        ];
        let teeth = areas(&clip_simple(&comb, &PLATE));
        assert!(teeth.len() == 3 && teeth.iter().all(|area| (area - 0.1).abs() < 1e-12), "{teeth:?}");
        let round = clip_simple(&comb, &DISC);
        // A tooth from x = 0.5 to the circle between y0 and y1: integral of sqrt(1 - y^2) - 0.5.
        let under = |y: f64| (y * (1.0 - y * y).sqrt() + y.asin()) / 2.0 - 0.5 * y;
        let expected = [under(0.5) - under(0.3), under(0.5) - under(0.3), 2.0 * under(0.1)];
        assert!(areas(&round).iter().zip(expected).all(|(area, expected)| (area - expected).abs() < 1e-7), "{round:?}");
        assert!(round.iter().flatten().all(|[x, y]| x.hypot(*y) < 1.0 + 1e-12));
        // Reversed: a comb whose back lies inside is one part.
        let inner: Polygon = comb.iter().rev().map(|[x, y]| [2.9 - x, *y]).collect();
        assert_eq!(clip_simple(&inner, &DISC).len(), 1);
    }
}
