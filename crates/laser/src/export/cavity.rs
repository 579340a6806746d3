use slipgrid_model::pattern::{Contour, Pattern, Planform};

use crate::export::clip::{area_m2, circle, clip};
use crate::export::clip_simple::clip_simple;
use crate::export::crossing::Crossing;
use crate::export::face::Face;
use crate::export::{Outline, left_of};

/// A cavity seen from above, in the specimen's axes x and y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cavity {
    /// Position of the centre along x, from the specimen's centre, in metres.
    pub centre_x_m: f64,
    /// Position of the centre along y, from the specimen's centre, in metres.
    pub centre_y_m: f64,
    /// Extent along the pattern's x axis, in metres; the diameter of a disc.
    pub width_m: f64,
    /// Extent at right angles to the width, in metres; equal to the width for squares and discs.
    pub length_m: f64,
    /// Unit vector of the pattern's x axis, along the width.
    pub orientation: [f64; 2],
    /// Disc, polygon or rectangle; a groove on a specimen counts as a rectangle.
    pub planform: Planform,
    /// Outline that cuts the cavity, if the cavity crosses the border of the specimen.
    pub cut_by: Option<Outline>,
    /// Outline of a polygonal cavity, whose bounding box has the extents `width_m` and `length_m`; `None` otherwise.
    pub(crate) face: Option<Face>,
    /// For a groove of the second family, the grooves of the first family that are cut out of it; `None` otherwise.
    pub(crate) crossed_by: Option<Crossing>,
}

/// Outline of a cavity, or of a part of it if the border of the specimen cuts it.
#[derive(Clone, Debug, PartialEq)]
pub enum Boundary {
    /// A circle.
    Circle {
        /// Centre as `[x, y]`, in metres.
        centre_m: [f64; 2],
        /// Radius, in metres.
        radius_m: f64,
    },
    /// A polygon: a cavity, or the remaining part of a cut cavity. Arcs are replaced by chords that deviate by at most
    /// 10 nm.
    Polygon {
        /// Corners as `[x, y]`, anticlockwise, in metres.
        corners_m: Vec<[f64; 2]>,
    },
}

impl Boundary {
    /// Corners as `[x, y]`, anticlockwise, in metres; a circle is approximated by a polygon.
    pub fn polygon_m(&self) -> Vec<[f64; 2]> {
        match self {
            Self::Circle { centre_m, radius_m } => circle(*centre_m, *radius_m),
            Self::Polygon { corners_m } => corners_m.clone(),
        }
    }

    /// Area, in square metres.
    pub fn area_m2(&self) -> f64 {
        match self {
            Self::Circle { radius_m, .. } => std::f64::consts::PI * radius_m * radius_m,
            other => area_m2(&other.polygon_m()),
        }
    }
}

impl Cavity {
    /// Whole cavity of `pattern` about a point, that no border cuts.
    pub(crate) fn new(pattern: &Pattern, centre_m: [f64; 2], length_m: f64) -> Self {
        let width_m = pattern.width_m();
        Self {
            centre_x_m: centre_m[0],
            centre_y_m: centre_m[1],
            width_m,
            length_m,
            orientation: pattern.texture().orientation(),
            planform: pattern.planform(),
            cut_by: None,
            face: pattern.texture().outline().map(|outline| Face { outline, centre_m, width_m, inset_m: 0.0 }),
            crossed_by: None,
        }
    }

    /// Outline of the cavity: one boundary, or one per part if the border or other grooves cut the cavity; none if
    /// nothing remains.
    pub fn boundaries(&self) -> Vec<Boundary> {
        let clipped = |polygon: Vec<[f64; 2]>| match &self.cut_by {
            None => vec![polygon],
            Some(outline) => clip(polygon, outline),
        };
        let parts = if let Some(face) = &self.face {
            let Some(corners_m) = face.inner_corners_m() else { return Vec::new() };
            match &self.cut_by {
                None => vec![corners_m],
                Some(outline) => clip_simple(&corners_m, outline),
            }
        } else if let Some(crossing) = &self.crossed_by {
            crossing.outside(self.corners_m().to_vec()).into_iter().flat_map(clipped).collect()
        } else {
            match self.planform.contour() {
                Contour::Circle => {
                    let (centre_m, radius_m) = ([self.centre_x_m, self.centre_y_m], self.width_m / 2.0);
                    let whole = Boundary::Circle { centre_m, radius_m };
                    if self.cut_by.is_none() {
                        return vec![whole];
                    }
                    clipped(whole.polygon_m())
                }
                Contour::Rectangle => clipped(self.corners_m().to_vec()),
            }
        };
        parts.into_iter().map(|corners_m| Boundary::Polygon { corners_m }).collect()
    }

    /// Whether the cavity is a complete rectangle, of any orientation.
    pub(crate) fn is_rectangle(&self) -> bool {
        self.is_plain() && self.crossed_by.is_none() && self.planform.contour() == Contour::Rectangle
    }

    /// Shrinks the cavity to the points at least `wall_m` from its walls, in metres; `None` if there are none. A cavity as
    /// wide as twice `wall_m` becomes a line.
    pub fn inset(&self, wall_m: f64) -> Option<Self> {
        let less = |extent_m: f64| {
            // Within rounding, a cavity as wide as the inset keeps its middle line.
            let left_m = extent_m - 2.0 * wall_m;
            (left_m >= -1e-9 * extent_m).then_some(left_m.max(0.0))
        };
        let face = self.face.map(|face| Face { inset_m: face.inset_m + wall_m, ..face });
        // The walls of all families move by the same amount.
        let crossed_by = self.crossed_by.map(|crossing| Crossing { grown_m: crossing.grown_m - wall_m, ..crossing });
        Some(Self { width_m: less(self.width_m)?, length_m: less(self.length_m)?, face, crossed_by, ..*self })
    }

    /// Distance from a point to the nearest wall, in metres; negative outside the walls. The border of the specimen is
    /// not a wall, but the distance is minus infinity beyond a border that cuts the cavity.
    pub fn wall_distance_m(&self, [x_m, y_m]: [f64; 2]) -> f64 {
        let at_m = [x_m, y_m];
        let (x_m, y_m) = (x_m - self.centre_x_m, y_m - self.centre_y_m);
        if self.cut_by.is_some_and(|outline| !outline.contains([x_m + self.centre_x_m, y_m + self.centre_y_m])) {
            return f64::NEG_INFINITY;
        }
        if let Some(face) = &self.face {
            return face.wall_distance_m(at_m);
        }
        let [cosine, sine] = self.orientation;
        match self.planform.contour() {
            Contour::Circle => self.width_m / 2.0 - x_m.hypot(y_m),
            Contour::Rectangle => {
                let (along_m, across_m) = (x_m * cosine + y_m * sine, y_m * cosine - x_m * sine);
                (self.width_m / 2.0 - along_m.abs()).min(self.length_m / 2.0 - across_m.abs())
            }
        }
    }

    /// Intervals of a line within the walls of the cavity, in metres along the line and ascending. The line runs along the
    /// unit vector `along`, `at_m` to the left of the specimen's centre; neither the border of the specimen nor other
    /// grooves are walls.
    pub(crate) fn spans_m(&self, along: [f64; 2], at_m: f64) -> Vec<[f64; 2]> {
        if let Some(face) = &self.face {
            return face.spans_m(along, at_m);
        }
        let [x_m, y_m] = [self.centre_x_m, self.centre_y_m];
        let face = match self.planform.contour() {
            Contour::Circle => Outline::Disc { diameter_m: self.width_m },
            Contour::Rectangle => Outline::Rectangle { length_m: self.width_m, width_m: self.length_m },
        };
        // The line's normal in the cavity's axes; turned anticlockwise it points backwards.
        let ([nx, ny], [cosine, sine]) = (left_of(along), self.orientation);
        let normal = [nx * cosine + ny * sine, ny * cosine - nx * sine];
        let of_centre = |[x, y]: [f64; 2]| x_m * x + y_m * y;
        let chord_m = face.chord_m(normal, at_m - of_centre([nx, ny]));
        chord_m.into_iter().map(|[low_m, high_m]| [of_centre(along) - high_m, of_centre(along) - low_m]).collect()
    }

    /// Corners of the rectangle, or of the square around a disc, as `[x, y]` in metres, anticlockwise; the first is the
    /// lower left corner in the cavity's axes.
    pub fn corners_m(&self) -> [[f64; 2]; 4] {
        let (half_width_m, half_length_m) = (self.width_m / 2.0, self.length_m / 2.0);
        let [cosine, sine] = self.orientation;
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[along, across]| {
            let (along_m, across_m) = (along * half_width_m, across * half_length_m);
            [
                self.centre_x_m + (along_m * cosine - across_m * sine),
                self.centre_y_m + (along_m * sine + across_m * cosine),
            ]
        })
    }

    /// Smallest and largest distance of a polygon's points from the specimen's centre, in metres; `None` for other
    /// planforms.
    pub(crate) fn polygon_reach_m(&self) -> Option<[f64; 2]> {
        let corners = self.face?.corners_m();
        let far_m = corners.iter().map(|[x_m, y_m]| x_m.hypot(*y_m)).fold(0.0, f64::max);
        let near_m = -self.face?.wall_distance_m([0.0; 2]);
        Some([near_m.max(0.0), far_m])
    }

    /// Whether the cavity is neither a polygon nor cut by the border: every line along x then crosses it at most once,
    /// with floor everywhere between the walls.
    pub(crate) fn is_plain(&self) -> bool {
        self.cut_by.is_none() && self.face.is_none()
    }

    /// Area seen from above, in square metres. For a polygon that `inset` shrinks and the border cuts, walls are
    /// shifted as planes.
    pub fn area_m2(&self) -> f64 {
        if let (Some(face), None) = (&self.face, &self.cut_by) {
            return face.area_m2();
        }
        if self.cut_by.is_some() || self.crossed_by.is_some() {
            return self.boundaries().iter().map(Boundary::area_m2).sum();
        }
        self.planform.contour().fill() * self.width_m * self.length_m
    }

    /// Whether the sides of the cavity lie along x and y.
    pub fn is_aligned(&self) -> bool {
        self.orientation == [1.0, 0.0]
    }
}
