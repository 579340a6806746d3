//! Outline of a cavity as a closed simple polygon.

use std::sync::{Mutex, PoisonError};

use crate::pattern::PatternError;
use crate::pattern::geometry::{contains, cross, doubled_area, edges, meet, point_to_segment};
use slipgrid_base::statistics::extremes;

/// Outline of a cavity seen from above: a closed simple polygon without holes, convex or concave.
///
/// An outline has a shape and no size. Its vertices run anticlockwise from the vertex with the smallest x (and among
/// these the smallest y). Its bounding box is centred at the origin and 1 wide along x, so that a pattern scales it by
/// its width. Coordinates are multiples of a fine grid (2^-44 of the larger extent), so that an outline written at any
/// scale and read again is bit-identical.
///
/// Outlines are interned for the lifetime of the program, because a search copies patterns by the thousand. A program
/// reads only a few outlines, each of some kilobytes at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polygon(&'static InternedOutline);

/// Vertices of an outline 1 wide along x, and quantities derived from them.
#[derive(Debug, PartialEq)]
struct InternedOutline {
    vertices: Vec<[f64; 2]>,
    length: f64,
    area: f64,
    least_extent: f64,
    symmetries: Symmetries,
}

/// Rotations and reflections about the centre of the bounding box that map an outline onto itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Symmetries {
    /// Rotation by 180 degrees.
    pub(crate) half_turn: bool,
    /// Reflection across the x axis: y becomes -y.
    pub(crate) across: bool,
    /// Reflection across the y axis: x becomes -x.
    pub(crate) along: bool,
    /// Rotation by 90 degrees.
    pub(crate) quarter_turn: bool,
    /// Reflections across the lines y = x and y = -x.
    pub(crate) diagonals: [bool; 2],
}

static INTERNED: Mutex<Vec<Polygon>> = Mutex::new(Vec::new());

impl Polygon {
    /// Maximum number of corners of an outline.
    pub const MAX_VERTICES: usize = 2000;

    /// Creates the outline through `vertices` as `[x, y]`, in any unit and orientation; the last vertex is joined to
    /// the first. Consecutive vertices that are equal, to 2^-44 of the larger extent, are merged.
    ///
    /// # Errors
    /// [`PatternError::Refused`] for fewer than three vertices or more than [`Self::MAX_VERTICES`], non-finite numbers, vertices
    /// that enclose no area, and edges that meet.
    pub fn new(vertices: &[[f64; 2]]) -> Result<Self, PatternError> {
        let refused = |reason: String| Err(PatternError::Refused(reason));
        let too_few = |count: usize| format!("an outline of {count} corners encloses nothing: expected at least 3");
        if vertices.len() > Self::MAX_VERTICES {
            let (count, most) = (vertices.len(), Self::MAX_VERTICES);
            return refused(format!("an outline of {count} corners: expected at most {most}"));
        }
        if let Some(corner) = vertices.iter().position(|at| !at.iter().all(|c| c.is_finite())) {
            let ([x, y], corner) = (vertices[corner], corner + 1);
            return refused(format!("corner {corner} of the outline is ({x}, {y}): expected finite numbers"));
        }
        if vertices.len() < 3 {
            return refused(too_few(vertices.len()));
        }
        let Some((mut normal, length)) = normalized(vertices) else { return refused(NO_AREA.to_owned()) };
        // Keep the original index of each vertex for messages.
        let mut corners: Vec<usize> = (0..normal.len()).collect();
        corners.retain(|&k| normal[k] != normal[(k + normal.len() - 1) % normal.len()]);
        normal = corners.iter().map(|&k| normal[k]).collect();
        if normal.len() < 3 {
            return refused(too_few(normal.len()));
        }
        let doubled = doubled_area(&normal);
        let has_area = doubled.abs() >= MIN_AREA * length;
        // If all vertices lie on one line, every edge meets its neighbour.
        if let Some(pair) = meeting_edges(&normal).filter(|_| has_area) {
            let [first, second] = pair.map(|edge| corners[edge]);
            let corner = |place: usize| format!("{} ({}, {})", place + 1, vertices[place][0], vertices[place][1]);
            return refused(format!(
                "the edges of the outline from corner {} and from corner {} meet: expected a closed outline that does not cross or touch itself",
                corner(first),
                corner(second)
            ));
        }
        if !has_area {
            return refused(NO_AREA.to_owned());
        }
        if doubled < 0.0 {
            normal.reverse();
        }
        // Normalize the start, so that the outline does not depend on the first corner given.
        let first = (0..normal.len())
            .min_by(|&a, &b| normal[a][0].total_cmp(&normal[b][0]).then(normal[a][1].total_cmp(&normal[b][1])));
        normal.rotate_left(first.unwrap_or(0));
        Ok(Self::interned(normal, length))
    }

    /// Interns the outline of normalized `vertices` with the extent `length` along y, or returns the copy that is
    /// already interned.
    fn interned(vertices: Vec<[f64; 2]>, length: f64) -> Self {
        let mut known = INTERNED.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = known.iter().find(|known| known.0.vertices == vertices) {
            return *found;
        }
        let kept = InternedOutline {
            length,
            area: doubled_area(&vertices) / 2.0,
            least_extent: least_extent(&vertices),
            symmetries: symmetries(&vertices, length),
            vertices,
        };
        let outline = Self(Box::leak(Box::new(kept)));
        known.push(outline);
        outline
    }

    /// Corners as `[x, y]`, anticlockwise, divided by the extent along x; the bounding box is centred at the origin.
    pub fn vertices(&self) -> &'static [[f64; 2]] {
        &self.0.vertices
    }

    /// Extent along y over extent along x.
    pub fn length(&self) -> f64 {
        self.0.length
    }

    /// Area divided by the square of the extent along x.
    pub fn area(&self) -> f64 {
        self.0.area
    }

    /// Perimeter divided by the extent along x.
    pub fn perimeter(&self) -> f64 {
        edges(self.vertices()).map(|([xa, ya], [xb, yb])| (xb - xa).hypot(yb - ya)).sum()
    }

    /// Narrowest width divided by the extent along x: the smallest distance between two parallel supporting lines or,
    /// if smaller, the width of the narrowest neck of a concave outline. A neck is a straight line inside the outline
    /// from a concave corner to the opposite side that is shorter than all lines next to it. Tapering corners are not
    /// counted as narrow.
    pub fn least_extent(&self) -> f64 {
        self.0.least_extent
    }

    /// Whether the point `at`, in units of the extent along x, lies inside.
    pub fn contains(&self, at: [f64; 2]) -> bool {
        contains(self.vertices(), at)
    }

    pub(crate) fn symmetries(&self) -> Symmetries {
        self.0.symmetries
    }

    /// Smallest distance between the outline and its copy shifted by `shift`, divided by the extent along x; 0 if they
    /// overlap or touch.
    pub(crate) fn distance(&self, shift: [f64; 2]) -> f64 {
        let vertices = self.vertices();
        let moved: Vec<[f64; 2]> = vertices.iter().map(|[x, y]| [x + shift[0], y + shift[1]]).collect();
        let may_overlap = shift[0].abs() <= 1.0 && shift[1].abs() <= self.length();
        if may_overlap && edges(vertices).any(|(a, b)| edges(&moved).any(|(c, d)| meet([a, b], [c, d]))) {
            return 0.0;
        }
        let least = |points: &[[f64; 2]], sides: &[[f64; 2]]| {
            let from = |point: &[f64; 2]| {
                edges(sides).map(|(a, b)| point_to_segment(*point, a, b)).fold(f64::INFINITY, f64::min)
            };
            points.iter().map(from).fold(f64::INFINITY, f64::min)
        };
        least(vertices, &moved).min(least(&moved, vertices))
    }
}

/// Coordinates are multiples of 2^-`GRID_BITS` of the larger extent, which is rounded up to a power of two.
const GRID_BITS: i32 = 44;
/// Error message for corners that lie on one line, or nearly so.
const NO_AREA: &str = "the outline encloses no area: expected corners that do not lie on one line";
/// Minimum ratio of twice the area of an outline to the area of its bounding box.
const MIN_AREA: f64 = 1e-9;

/// Scales vertices to a bounding box about the origin that is 1 wide, and rounds them to the grid. Returns the vertices
/// and the extent along y; `None` if an extent is zero or not finite, or one is more than a million times the other.
fn normalized(vertices: &[[f64; 2]]) -> Option<(Vec<[f64; 2]>, f64)> {
    let range = |axis: usize| extremes(vertices.iter().map(|at| at[axis]));
    let [[left, right], [low, high]] = [range(0), range(1)];
    let (width, length) = (right - left, (high - low) / (right - left));
    // Aspect ratios beyond a million are refused.
    if !(width > 0.0 && width.is_finite() && (1e-6..=1e6).contains(&length)) {
        return None;
    }
    let grid = 2_f64.powi(libm::ceil(libm::log2(length.max(1.0))) as i32 - GRID_BITS);
    // Half the length is rounded to the grid, so that the box stays centred.
    let half = (length / 2.0 / grid).round() * grid;
    let snapped = |share: f64, half: f64| ((share / grid).round() * grid).clamp(-half, half);
    let normal = |[x, y]: &[f64; 2]| {
        [
            snapped(((x - left) - (right - x)) / (2.0 * width), 0.5) + 0.0,
            snapped(((y - low) - (high - y)) / (2.0 * width), half) + 0.0,
        ]
    };
    Some((vertices.iter().map(normal).collect(), 2.0 * half))
}

/// Indices of two edges that meet other than in a common corner; `None` if no edges do.
fn meeting_edges(vertices: &[[f64; 2]]) -> Option<[usize; 2]> {
    let count = vertices.len();
    let corner = |k: usize| vertices[k % count];
    for first in 0..count {
        let (a, b, c) = (corner(first), corner(first + 1), corner(first + 2));
        // The edge runs back along the previous one.
        let forth = (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]);
        if cross(a, b, c) == 0.0 && forth < 0.0 {
            return Some([first, (first + 1) % count]);
        }
        let apart = |second: usize| !(first == 0 && second == count - 1);
        let meets = |&second: &usize| apart(second) && meet([a, b], [corner(second), corner(second + 1)]);
        if let Some(second) = (first + 2..count).find(meets) {
            return Some([first, second]);
        }
    }
    None
}

/// Narrowest width of the outline with these vertices, as in [`Polygon::least_extent`].
fn least_extent(vertices: &[[f64; 2]]) -> f64 {
    // The narrowest supporting strip has an edge of the convex hull on one side. Other vertex pairs with all vertices
    // on one side are harmless.
    let mut least = f64::INFINITY;
    for (k, a) in vertices.iter().enumerate() {
        for b in &vertices[k + 1..] {
            let size = (b[0] - a[0]).hypot(b[1] - a[1]);
            let (low, high) = vertices.iter().fold((0.0_f64, 0.0_f64), |(low, high), at| {
                let away = cross(*a, *b, *at) / size;
                (low.min(away), high.max(away))
            });
            if low >= -1e-12 || high <= 1e-12 {
                least = least.min(high - low);
            }
        }
    }
    let count = vertices.len();
    let corner = |k: usize| vertices[k % count];
    let is_concave = |k: usize| cross(corner(k + count - 1), corner(k), corner(k + 1)) < 0.0;
    // Whether a line from corner k in the direction `way` leaves both edges of the corner behind.
    let leaves = |k: usize, way: [f64; 2]| {
        [k + count - 1, k + 1].into_iter().all(|next| {
            let ([x, y], [nx, ny]) = (corner(k), corner(next));
            (nx - x) * way[0] + (ny - y) * way[1] <= 0.0
        })
    };
    for k in (0..count).filter(|&k| is_concave(k)) {
        let from = corner(k);
        for edge in (0..count).filter(|&edge| edge != k && (edge + 1) % count != k) {
            let (a, b) = (corner(edge), corner(edge + 1));
            let along = [b[0] - a[0], b[1] - a[1]];
            let share = ((from[0] - a[0]) * along[0] + (from[1] - a[1]) * along[1])
                / (along[0] * along[0] + along[1] * along[1]);
            let share = share.clamp(0.0, 1.0);
            let to = [a[0] + share * along[0], a[1] + share * along[1]];
            let way = [to[0] - from[0], to[1] - from[1]];
            let size = way[0].hypot(way[1]);
            if size >= least || !leaves(k, way) {
                continue;
            }
            let back = [-way[0], -way[1]];
            let end = if share == 0.0 {
                Some(edge)
            } else if share == 1.0 {
                Some((edge + 1) % count)
            } else {
                None
            };
            let is_neck = end.is_none_or(|end| is_concave(end) && leaves(end, back));
            let middle = [f64::midpoint(from[0], to[0]), f64::midpoint(from[1], to[1])];
            let shorter = [0.001, 0.999].map(|share| [from[0] + share * way[0], from[1] + share * way[1]]);
            let is_free = || !edges(vertices).any(|(a, b)| meet(shorter, [a, b]));
            if is_neck && contains(vertices, middle) && is_free() {
                least = size;
            }
        }
    }
    least
}

fn symmetries(vertices: &[[f64; 2]], length: f64) -> Symmetries {
    let tolerance = 4.0 * 2_f64.powi(-GRID_BITS) * length.max(1.0);
    let maps = |image: fn([f64; 2]) -> [f64; 2]| {
        let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs() <= tolerance && (a[1] - b[1]).abs() <= tolerance;
        let count = vertices.len();
        let images: Vec<[f64; 2]> = vertices.iter().copied().map(image).collect();
        // The images may follow the corners in either orientation, starting at any corner.
        (0..count).any(|start| {
            (0..count).all(|k| near(images[k], vertices[(start + k) % count]))
                || (0..count).all(|k| near(images[k], vertices[(start + count - k) % count]))
        })
    };
    Symmetries {
        half_turn: maps(|[x, y]| [-x, -y]),
        across: maps(|[x, y]| [x, -y]),
        along: maps(|[x, y]| [-x, y]),
        quarter_turn: maps(|[x, y]| [-y, x]),
        diagonals: [maps(|[x, y]| [y, x]), maps(|[x, y]| [-y, -x])],
    }
}

impl Symmetries {
    /// Whether one of these symmetries maps sliding at `angle_deg` from x to sliding at `other_deg`, within
    /// `tolerance_deg`. The arrangement of cavities has reflections across x and y, and rotations by 90 degrees if
    /// `is_square_lattice`.
    pub(crate) fn maps_direction(
        &self,
        angle_deg: f64,
        other_deg: f64,
        is_square_lattice: bool,
        tolerance_deg: f64,
    ) -> bool {
        let images = [
            (true, angle_deg),
            (self.half_turn, angle_deg + 180.0),
            (self.across, -angle_deg),
            (self.along, 180.0 - angle_deg),
            (is_square_lattice && self.quarter_turn, angle_deg + 90.0),
            (is_square_lattice && self.quarter_turn, angle_deg - 90.0),
            (is_square_lattice && self.diagonals[0], 90.0 - angle_deg),
            (is_square_lattice && self.diagonals[1], -90.0 - angle_deg),
        ];
        images.into_iter().any(|(holds, image_deg)| {
            let apart_deg = (image_deg - other_deg).rem_euclid(360.0);
            holds && apart_deg.min(360.0 - apart_deg) < tolerance_deg
        })
    }
}

#[cfg(test)]
pub(super) mod tests;
