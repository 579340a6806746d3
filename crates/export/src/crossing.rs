//! Grooves of one family where those of another cross them.
//!
//! What both families take is taken once: by the first. The second is what is left of its grooves between those of the first, so
//! that areas add up, contours do not overlap, and nothing is marked twice.

use crate::clip::{outside_sides, within_sides};
use crate::face::without;
use crate::{Cavity, Layout, Line};

/// The grooves of the first family as a groove of the second meets them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossing {
    /// The first family on the same specimen.
    pub(crate) grooves: Layout,
    /// By how much more than they are their walls are kept off, in metres; below zero by how much less.
    pub(crate) grown_m: f64,
}

impl Crossing {
    /// What is left of a convex polygon between the grooves, in convex parts.
    pub(crate) fn outside(&self, polygon: Vec<[f64; 2]>) -> Vec<Vec<[f64; 2]>> {
        let grooves = self.reaching(&polygon);
        let mut parts = vec![polygon];
        for groove in &grooves {
            let sides = self.sides(groove);
            let mut left = Vec::with_capacity(parts.len() + 1);
            for part in parts {
                // A part that lies wholly beyond one side is left as it is: nearly all are.
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

    /// What is left of a line between the grooves.
    pub(crate) fn parts_of(&self, line: Line) -> Vec<Line> {
        let [from, to] = line;
        let at = |share: f64| [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
        let grooves = self.reaching(&line);
        let shares = grooves.iter().fold(vec![[0.0, 1.0]], |shares, groove| {
            let Some(taken) = within_sides(line, &self.sides(groove)) else { return shares };
            shares.into_iter().flat_map(|share| without(share, taken)).collect()
        });
        shares.into_iter().map(|share: [f64; 2]| share.map(at)).collect()
    }

    /// The grooves that may reach the points.
    fn reaching(&self, points: &[[f64; 2]]) -> Vec<Cavity> {
        let pattern = self.grooves.pattern();
        let [cosine, sine] = pattern.texture().orientation();
        let offsets_m = points.iter().map(|[x_m, y_m]| x_m * cosine + y_m * sine);
        let (low_m, high_m) =
            offsets_m.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        let half_m = pattern.width_m() / 2.0 + self.grown_m;
        // Points lie on the specimen or a little beside it, whose places are bounded: the casts are exact.
        let first = ((low_m - half_m) / pattern.pitch_m()).ceil() as i64;
        let last = ((high_m + half_m) / pattern.pitch_m()).floor() as i64;
        (first..=last).flat_map(|column| self.grooves.uncut_grooves(column)).flatten().collect()
    }

    /// The sides of a groove with what is kept off it: unit normals and their distances from the origin.
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
