//! Crossing of two families of grooves.
//!
//! The intersection belongs to the first family. The second family consists of the parts of its grooves between the
//! grooves of the first family, so that areas add up, contours do not overlap, and nothing is marked twice.

use slipgrid_base::statistics::extremes;

use crate::export::clip::{outside_sides, within_sides};
use crate::export::face::interval_outside;
use crate::export::{Cavity, Layout, Line};

/// Grooves of the first of two crossing families, to subtract from a groove of the second so that nothing is marked
/// twice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossing {
    /// Layout of the first family on the specimen.
    pub(crate) grooves: Layout,
    /// Distance by which the grooves of the first family are widened on each side, in metres; negative if narrowed.
    pub(crate) grown_m: f64,
}

impl Crossing {
    /// Parts of a convex polygon outside the grooves of the first family, as convex polygons.
    pub(crate) fn outside(&self, polygon: Vec<[f64; 2]>) -> Vec<Vec<[f64; 2]>> {
        let grooves = self.reaching(&polygon);
        let mut parts = vec![polygon];
        for groove in &grooves {
            let sides = self.sides(groove);
            let mut left = Vec::with_capacity(parts.len() + 1);
            for part in parts {
                // Most parts lie completely beyond one side and are not cut.
                let is_beyond =
                    |&([nx, ny], limit_m): &([f64; 2], f64)| part.iter().all(|[x, y]| x * nx + y * ny >= limit_m);
                if sides[..2].iter().any(is_beyond) {
                    left.push(part);
                } else {
                    left.extend(outside_sides(part, &sides));
                }
            }
            parts = left;
        }
        parts
    }

    /// Parts of a line outside the grooves of the first family.
    pub(crate) fn parts_of(&self, line: Line) -> Vec<Line> {
        let [from, to] = line;
        let at = |share: f64| [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
        let grooves = self.reaching(&line);
        let shares = grooves.iter().fold(vec![[0.0, 1.0]], |shares, groove| {
            let Some(taken) = within_sides(line, &self.sides(groove)) else { return shares };
            shares.into_iter().flat_map(|share| interval_outside(share, taken)).collect()
        });
        shares.into_iter().map(|share: [f64; 2]| share.map(at)).collect()
    }

    /// Grooves of the first family that may contain some of the points.
    fn reaching(&self, points: &[[f64; 2]]) -> Vec<Cavity> {
        let pattern = self.grooves.pattern();
        let [cosine, sine] = pattern.texture().orientation();
        let offsets_m = points.iter().map(|[x_m, y_m]| x_m * cosine + y_m * sine);
        let [low_m, high_m] = extremes(offsets_m);
        let half_m = pattern.width_m() / 2.0 + self.grown_m;
        // Points lie on the specimen or close to it, which bounds the indices, so that the casts are exact.
        let first = ((low_m - half_m) / pattern.pitch_m()).ceil() as i64;
        let last = ((high_m + half_m) / pattern.pitch_m()).floor() as i64;
        (first..=last).flat_map(|column| self.grooves.rectangles(column)).flatten().collect()
    }

    /// Sides of a groove widened by `grown_m`: unit normals, and distances from the origin along them, in metres.
    fn sides(&self, groove: &Cavity) -> [([f64; 2], f64); 4] {
        let [cosine, sine] = groove.orientation;
        let side = |normal: [f64; 2], half_m: f64| {
            let middle_m = groove.centre_x_m * normal[0] + groove.centre_y_m * normal[1];
            (normal, middle_m + half_m + self.grown_m)
        };
        [
            side([cosine, sine], groove.width_m / 2.0),
            side([-cosine, -sine], groove.width_m / 2.0),
            side([-sine, cosine], groove.length_m / 2.0),
            side([sine, -cosine], groove.length_m / 2.0),
        ]
    }
}
