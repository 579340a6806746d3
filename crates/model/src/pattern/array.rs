use crate::pattern::coverage::{Shape, Sublattice, covered_area};
use crate::pattern::error::{length, um};
use crate::pattern::grown::Grown;
use crate::pattern::{Arrangement, Contour, PatternError, Planform, Polygon, Rim, Texture};
use libm::{cos, sin};

/// Distance between hexagonal rows over the pitch, sqrt(3)/2.
const HEXAGONAL_ROW_RATIO: f64 = 0.866_025_403_784_438_6;

/// A periodic array of equal cavities: a [`Texture`] with width, spacing and depth. Lengths are in metres and positive.
///
/// The origin of the pattern's axes is the centre of a cavity. Rows of cavities run along x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pattern {
    texture: Texture,
    width_m: f64,
    spacing_m: f64,
    depth_m: f64,
}

impl Pattern {
    /// Creates a pattern of cavities with the given width, spacing and depth. A [`Planform`] is converted to its
    /// default [`Texture`].
    ///
    /// # Errors
    /// [`PatternError::Refused`] if a length is not positive and finite, if hexagonal rows of squares or rectangles are
    /// closer together than a cavity is long, or if polygons in hexagonal rows overlap or extend over two rows.
    pub fn new(texture: impl Into<Texture>, width_m: f64, spacing_m: f64, depth_m: f64) -> Result<Self, PatternError> {
        let pattern = Self {
            texture: texture.into(),
            width_m: length("width", width_m)?,
            spacing_m: length("spacing", spacing_m)?,
            depth_m: length("depth", depth_m)?,
        };
        let across = pattern.length_m().zip(pattern.pitch_across_m());
        let across = across.filter(|_| pattern.texture.arrangement() == Arrangement::Hexagonal);
        let Some((length_m, pitch_across_m)) = across else { return Ok(pattern) };
        // Rows of discs and of polygons may interlock.
        let is_apart = match (pattern.texture.outline(), pattern.planform().contour()) {
            (Some(_), _) => length_m < 2.0 * pitch_across_m && pattern.least_land_m() > 0.0,
            (None, Contour::Circle) => true,
            (None, Contour::Rectangle) => pitch_across_m > length_m,
        };
        if is_apart { Ok(pattern) } else { Err(rows_overlap(pitch_across_m, length_m)) }
    }

    /// Texture: all properties except width, spacing and depth.
    pub const fn texture(&self) -> &Texture {
        &self.texture
    }

    /// Shape seen from above.
    pub const fn planform(&self) -> Planform {
        self.texture.planform()
    }

    /// Width of a cavity along x, in metres; the diameter of a disc.
    pub const fn width_m(&self) -> f64 {
        self.width_m
    }

    /// Gap between two neighbouring cavities of a row, along x, in metres.
    pub const fn spacing_m(&self) -> f64 {
        self.spacing_m
    }

    /// Depth of a cavity, in metres.
    pub const fn depth_m(&self) -> f64 {
        self.depth_m
    }

    /// Width, spacing and depth, in metres.
    pub const fn lengths_m(&self) -> [f64; 3] {
        [self.width_m, self.spacing_m, self.depth_m]
    }

    /// Period of a row along x, width + spacing, in metres.
    pub fn pitch_m(&self) -> f64 {
        self.width_m + self.spacing_m
    }

    /// Extent of a cavity along y, in metres; `None` for grooves, which are infinite.
    pub fn length_m(&self) -> Option<f64> {
        match self.planform() {
            Planform::Groove | Planform::Crosshatch => None,
            Planform::Polygon => Some(self.texture.outline().map_or(1.0, |outline| outline.length()) * self.width_m),
            Planform::Rectangle => Some(self.texture.length_m().unwrap_or(self.width_m)),
            Planform::Square | Planform::Disc => Some(self.width_m),
        }
    }

    /// Gap between two neighbouring rows, along y, in metres; `None` for grooves. Negative if hexagonal rows of discs
    /// or polygons interlock.
    pub fn spacing_across_m(&self) -> Option<f64> {
        if self.texture.arrangement() == Arrangement::Hexagonal {
            return Some(HEXAGONAL_ROW_RATIO * self.pitch_m() - self.length_m()?);
        }
        let spacing_across_m = self.texture.spacing_across_m().unwrap_or(self.spacing_m);
        (!self.planform().is_grooves()).then_some(spacing_across_m)
    }

    /// Distance between neighbouring rows along y, length + spacing across, in metres; `None` for grooves.
    pub fn pitch_across_m(&self) -> Option<f64> {
        if self.texture.arrangement() == Arrangement::Hexagonal {
            return self.length_m().map(|_| HEXAGONAL_ROW_RATIO * self.pitch_m());
        }
        Some(self.length_m()? + self.spacing_across_m()?)
    }

    /// Whether the pattern does not vary along y: true only for grooves of one family.
    pub fn is_uniform_along_y(&self) -> bool {
        self.planform() == Planform::Groove
    }

    /// Sides along x and y of the smallest rectangular periodic cell, in metres. A staggered or hexagonal cell holds
    /// two rows. Grooves do not vary along y: their cell is given as a square, although any length along y is valid.
    /// Grooves of pitch p that cross at an angle c have the cell p / cos(c/2) by p / sin(c/2), in which they cross
    /// twice, or p by p for a right angle.
    pub fn cell_m(&self) -> [f64; 2] {
        let pitch_m = self.pitch_m();
        if let Some(half) = self.oblique_half_angle() {
            return [pitch_m / cos(half), pitch_m / sin(half)];
        }
        let rows = match self.texture.arrangement() {
            Arrangement::Square => 1.0,
            Arrangement::Staggered | Arrangement::Hexagonal => 2.0,
        };
        [pitch_m, self.pitch_across_m().map_or(pitch_m, |pitch_across_m| rows * pitch_across_m)]
    }

    /// Half of [`Texture::crossing_angle_deg`] for obliquely crossing grooves, in radians; `None` for other patterns.
    fn oblique_half_angle(&self) -> Option<f64> {
        self.texture.oblique_half_angle_deg().map(f64::to_radians)
    }

    /// Centres of the cavities (or crossings of grooves) in one cell, in metres from the first, the origin.
    pub fn centres_m(&self) -> impl Iterator<Item = [f64; 2]> + use<> {
        let second = match (self.texture.arrangement(), self.pitch_across_m()) {
            (arrangement, Some(pitch_across_m)) if arrangement.shifts_rows() => {
                Some([self.pitch_m() / 2.0, pitch_across_m])
            }
            _ if self.oblique_half_angle().is_some() => Some(self.cell_m().map(|side_m| side_m / 2.0)),
            _ => None,
        };
        std::iter::once([0.0, 0.0]).chain(second)
    }

    /// Sets the sliding direction, `angle_deg` from the specimen's X axis.
    ///
    /// # Errors
    /// [`PatternError::Refused`] outside -180 to 180 degrees.
    pub fn with_sliding_angle_deg(mut self, angle_deg: f64) -> Result<Self, PatternError> {
        self.texture = self.texture.with_sliding_angle_deg(angle_deg)?;
        Ok(self)
    }

    /// Sets the rim of every cavity, or removes rims.
    #[must_use]
    pub fn with_rim(mut self, rim: impl Into<Option<Rim>>) -> Self {
        self.texture = self.texture.with_rim(rim);
        self
    }

    /// Unit vector of the sliding direction in the pattern's axes.
    pub fn sliding_direction(&self) -> [f64; 2] {
        self.texture.sliding_direction()
    }

    /// Fraction, from 0 to 1, of the rectangle `[x0_m, x1_m] x [y0_m, y1_m]` that is covered by cavities.
    ///
    /// The rectangle is given in the pattern's axes, whose origin is the centre of a cavity, and may have any position
    /// and size. A solver whose first cavity is centred at (a, b) passes its rectangles shifted by (-a, -b), and can
    /// therefore place its blocks anywhere. The fraction is computed in closed form and is continuous in the sides of
    /// the rectangle and in every dimension of the pattern. Values within 1e-12 of 0 or 1 are rounded, so that blocks
    /// without an edge are exactly 0 or 1. An empty or non-finite rectangle has the fraction 0.
    pub fn coverage(&self, x0_m: f64, x1_m: f64, y0_m: f64, y1_m: f64) -> f64 {
        // Values within this distance of 0 or 1 are rounding errors.
        const ROUNDING: f64 = 1e-12;
        snap_fraction(self.coverage_within(0.0, [x0_m, x1_m], [y0_m, y1_m]), ROUNDING)
    }

    /// Fraction of a rectangle that lies in a cavity or within the Euclidean distance `distance_m` of one. `distance_m`
    /// must be at most half of the narrowest land.
    pub(crate) fn coverage_within(&self, distance_m: f64, x_m: [f64; 2], y_m: [f64; 2]) -> f64 {
        let Some(area_m2) = proper_area_m2(x_m, y_m) else { return 0.0 };
        let cell_m = self.cell_m();
        let covered_m2 =
            |shape: Shape<'_>, centre_m: [f64; 2]| covered_area(shape, &Sublattice { centre_m, cell_m }, x_m, y_m);
        let cavities_m2 = |shape: Shape<'_>| self.centres_m().map(|centre_m| covered_m2(shape, centre_m)).sum::<f64>();
        let width_m = self.width_m + 2.0 * distance_m;
        match (self.planform(), self.texture.outline(), self.length_m()) {
            (Planform::Crosshatch, ..) => {
                let spacing_m = self.spacing_m - 2.0 * distance_m;
                if spacing_m > 0.0 { 1.0 - self.land_m2(spacing_m, covered_m2) / area_m2 } else { 1.0 }
            }
            (_, Some(outline), Some(_)) if distance_m > 0.0 => {
                self.grown_fraction(&outline.grown(distance_m / self.width_m), area_m2, covered_m2)
            }
            (_, Some(outline), Some(length_m)) => {
                let (vertices, extents_m) = (outline.vertices(), [width_m, length_m]);
                cavities_m2(Shape::Polygon { vertices, scale_m: width_m, extents_m }) / area_m2
            }
            (planform, None, Some(length_m)) => {
                let (length_m, corner_m) = (length_m + 2.0 * distance_m, distance_m);
                cavities_m2(match planform.contour() {
                    Contour::Rectangle => Shape::Rectangle { width_m, length_m, corner_m },
                    Contour::Circle => Shape::Disc { diameter_m: width_m },
                }) / area_m2
            }
            (_, _, None) => cavities_m2(Shape::Strip { width_m }) / area_m2,
        }
    }

    /// Fraction of a rectangle of area `area_m2` that lies within `grown`, the offset outline of this pattern's
    /// polygons. `covered_m2` computes the area covered by shapes.
    fn grown_fraction(&self, grown: &Grown, area_m2: f64, covered_m2: impl Fn(Shape<'_>, [f64; 2]) -> f64) -> f64 {
        let scale_m = self.width_m;
        let extents_m = grown.extents().map(|extent| extent * scale_m);
        let shape = Shape::Pieces { pieces: grown.pieces(), scale_m, extents_m };
        self.centres_m().map(|centre_m| covered_m2(shape, centre_m)).sum::<f64>() / area_m2
    }

    /// Area, computed by `covered_m2`, of the land between crossing grooves `spacing_m` apart: disjoint rhombi, half a
    /// cell from the crossings.
    fn land_m2(&self, spacing_m: f64, covered_m2: impl Fn(Shape<'_>, [f64; 2]) -> f64) -> f64 {
        let [cell_x_m, cell_y_m] = self.cell_m();
        let Some(half) = self.oblique_half_angle() else {
            let square = Shape::Rectangle { width_m: spacing_m, length_m: spacing_m, corner_m: 0.0 };
            return covered_m2(square, [cell_x_m / 2.0, cell_y_m / 2.0]);
        };
        // |x cos(c/2) +- y sin(c/2)| <= s/2 about the centre of a land.
        let (x_m, y_m) = (spacing_m / (2.0 * cos(half)), spacing_m / (2.0 * sin(half)));
        let vertices = [[x_m, 0.0], [0.0, y_m], [-x_m, 0.0], [0.0, -y_m]];
        let rhombus = Shape::Polygon { vertices: &vertices, scale_m: 1.0, extents_m: [2.0 * x_m, 2.0 * y_m] };
        covered_m2(rhombus, [cell_x_m / 2.0, 0.0]) + covered_m2(rhombus, [0.0, cell_y_m / 2.0])
    }

    /// Fraction of the length of a vertical section along x, through the cavities' centres, that is cavity: width /
    /// pitch. For a polygon this is the section at its largest width, for crossing grooves a section across one family
    /// between two grooves of the other.
    pub fn section_density(&self) -> f64 {
        self.width_m / self.pitch_m()
    }

    /// Fraction of the surface that is cavity.
    pub fn areal_density(&self) -> f64 {
        // (w / p) times the fraction of the rows across, weighted by the mean chord; for crossing grooves 1 - (1 -
        // w/p)^2
        self.section_density() * self.share_across()
    }

    /// Length of the cavities' edges over the area of the face, in 1/m. Edges of crossing grooves end where the grooves
    /// cross.
    pub fn edge_per_area_1_m(&self) -> f64 {
        let width_m = self.width_m;
        // Perimeter over area of one cavity.
        let perimeter_over_area = match self.planform() {
            Planform::Groove => return 2.0 / self.pitch_m(),
            // Two families of edges 2 / p, of which the other family removes w / p.
            Planform::Crosshatch => return 4.0 / self.pitch_m() * (1.0 - width_m / self.pitch_m()),
            Planform::Square | Planform::Disc => 4.0 / width_m,
            Planform::Rectangle => {
                let length_m = self.length_m().unwrap_or(width_m);
                2.0 * (width_m + length_m) / (width_m * length_m)
            }
            Planform::Polygon => {
                self.texture.outline().map_or(4.0 / width_m, |outline| outline.perimeter() / (outline.area() * width_m))
            }
        };
        perimeter_over_area * self.areal_density()
    }

    /// Strip estimate of the friction ratio of a pattern, from the ratio `ratio_groove` of a transversal groove with
    /// the same vertical section along x. Strips between the rows count as flat; a disc or polygon counts as a
    /// rectangle of equal width and area. The reduction by crossing grooves is scaled with their larger area, and
    /// limited to 1.
    pub fn strip_estimate(&self, ratio_groove: f64) -> f64 {
        match self.planform() {
            Planform::Groove => ratio_groove,
            // ratio = 1 - (length/pitch across) (1 - ratio_groove)
            Planform::Crosshatch => (1.0 - self.share_across() * (1.0 - ratio_groove)).max(0.0),
            _ => 1.0 - self.share_across() * (1.0 - ratio_groove),
        }
    }

    /// Mean length of a cavity along y over the distance between rows; 1 for grooves, and (1 - (1 - w/p)^2) / (w/p) for
    /// crossing grooves of width w and pitch p.
    fn share_across(&self) -> f64 {
        if self.planform() == Planform::Crosshatch {
            return 2.0 - self.section_density();
        }
        let Some((length_m, pitch_across_m)) = self.length_m().zip(self.pitch_across_m()) else { return 1.0 };
        let mean = match self.texture.outline() {
            Some(outline) => outline.area() / outline.length(),
            None => self.planform().contour().fill(),
        };
        mean * (length_m / pitch_across_m)
    }

    /// Smallest distance between two cavities, in metres: the width of the narrowest land. It is exact for polygons,
    /// whichever neighbour is nearest, and equals the spacing for grooves.
    pub fn least_land_m(&self) -> f64 {
        let (Some(length_m), Some(spacing_across_m)) = (self.length_m(), self.spacing_across_m()) else {
            return self.spacing_m;
        };
        if let Some(outline) = self.texture.outline() {
            return self.least_distance_m(outline, length_m + spacing_across_m);
        }
        match (self.texture.arrangement(), self.planform().contour()) {
            (Arrangement::Square, _) => self.spacing_m.min(spacing_across_m),
            // All six neighbours have the distance of those in the row.
            (Arrangement::Hexagonal, Contour::Circle) => self.spacing_m,
            (Arrangement::Staggered | Arrangement::Hexagonal, contour) => {
                // The next row is shifted by half a pitch, the one after it is not.
                let half_pitch_m = self.pitch_m() / 2.0;
                let aside_m = match contour {
                    Contour::Circle => half_pitch_m.hypot(length_m + spacing_across_m) - self.width_m,
                    Contour::Rectangle => (half_pitch_m - self.width_m).max(0.0).hypot(spacing_across_m),
                };
                self.spacing_m.min(aside_m).min(length_m + 2.0 * spacing_across_m)
            }
        }
    }

    /// Smallest distance between two polygons of the pattern with rows `pitch_across_m` apart, in metres.
    fn least_distance_m(&self, outline: Polygon, pitch_across_m: f64) -> f64 {
        // Lengths are divided by the width, as in outlines; steps along x are half pitches.
        let [half_pitch, pitch_across] = [self.pitch_m() / 2.0, pitch_across_m].map(|pitch_m| pitch_m / self.width_m);
        let shifts_rows = self.texture.arrangement().shifts_rows();
        let mut neighbours: Vec<(f64, [f64; 2])> = Vec::new();
        for row in 0..=3_i32 {
            let is_shifted = shifts_rows && row % 2 == 1;
            for step in -6..=6_i32 {
                let is_neighbour = (step.rem_euclid(2) == 1) == is_shifted && (row, step) > (0, 0);
                let shift = [f64::from(step) * half_pitch, f64::from(row) * pitch_across];
                // Distance between the bounding boxes, a lower bound of that between the outlines.
                let apart = (shift[0].abs() - 1.0).max(0.0).hypot((shift[1] - outline.length()).max(0.0));
                if is_neighbour {
                    neighbours.push((apart, shift));
                }
            }
        }
        neighbours.sort_by(|a, b| a.0.total_cmp(&b.0));
        let nearest = neighbours.into_iter().fold(f64::INFINITY, |least, (apart, shift)| {
            if apart < least { least.min(outline.distance(shift)) } else { least }
        });
        nearest * self.width_m
    }

    /// Smallest extent of a cavity seen from above, in metres; for a polygon [`Polygon::least_extent`].
    pub fn least_extent_m(&self) -> f64 {
        if let Some(outline) = self.texture.outline() {
            return outline.least_extent() * self.width_m;
        }
        self.length_m().map_or(self.width_m, |length_m| length_m.min(self.width_m))
    }

    /// Families of grooves as separate patterns on the same specimen: one for grooves, two for crossing grooves, none
    /// for other planforms.
    pub fn families(&self) -> impl Iterator<Item = Self> + use<> {
        let pattern = *self;
        pattern
            .texture
            .families_deg()
            .map(move |angle_deg| Self { texture: pattern.texture.family(angle_deg), ..pattern })
    }

    /// Grooves across the sliding direction with the width, spacing, depth and rims of this pattern.
    #[must_use]
    pub fn as_groove(mut self) -> Self {
        self.texture = Texture::new(Planform::Groove).with_rim(self.texture.rim().copied());
        self
    }
}

/// Error for hexagonal rows `pitch_across_m` apart, closer than their cavities of `length_m`.
fn rows_overlap(pitch_across_m: f64, length_m: f64) -> PatternError {
    PatternError::Refused(format!(
        "hexagonal rows are {} um apart, cavities {} um long: they run into each other; expected a larger spacing",
        um(pitch_across_m),
        um(length_m)
    ))
}

/// Area of a rectangle, in square metres; `None` if it is zero, negative or not finite.
fn proper_area_m2([x0_m, x1_m]: [f64; 2], [y0_m, y1_m]: [f64; 2]) -> Option<f64> {
    // Products and quotients of lengths below 1e-150 m would underflow.
    let area_m2 = (x1_m - x0_m) * (y1_m - y0_m);
    (x1_m > x0_m && y1_m > y0_m && area_m2.is_finite() && area_m2 > 0.0).then_some(area_m2)
}

/// Rounds a fraction within `tolerance` of 0 or 1 to that value.
pub(crate) fn snap_fraction(share: f64, tolerance: f64) -> f64 {
    if share < tolerance {
        0.0
    } else if share > 1.0 - tolerance {
        1.0
    } else {
        share
    }
}
