use crate::coverage::{Shape, Sublattice, covered_area};
use crate::error::length;
use crate::{Arrangement, PatternError, Planform, Rim, Texture};

/// Distance of hexagonal rows over the pitch, sqrt(3)/2.
const HEXAGONAL: f64 = 0.866_025_403_784_438_6;

/// A periodic array of equal cavities: a [`Texture`] with its width, spacing and depth. Lengths in
/// metres, all positive.
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
    /// A pattern of cavities `width_m` wide, `spacing_m` apart and `depth_m` deep. A [`Planform`]
    /// alone stands for its plainest [`Texture`].
    ///
    /// # Errors
    /// [`PatternError::NotALength`] if one of the lengths is not positive and finite, [`PatternError::RowsOverlap`] where
    /// hexagonal rows of squares or rectangles are nearer than these are long.
    pub fn new(texture: impl Into<Texture>, width_m: f64, spacing_m: f64, depth_m: f64) -> Result<Self, PatternError> {
        let pattern = Self {
            texture: texture.into(),
            width_m: length("width", width_m)?,
            spacing_m: length("spacing", spacing_m)?,
            depth_m: length("depth", depth_m)?,
        };
        let across = pattern.length_m().zip(pattern.pitch_across_m());
        match (pattern.texture.arrangement(), pattern.planform(), across) {
            // Rows of discs reach between each other.
            (_, Planform::Disc, _) | (Arrangement::Square | Arrangement::Staggered, ..) => Ok(pattern),
            (_, _, Some((length_m, pitch_across_m))) if pitch_across_m <= length_m => {
                Err(PatternError::RowsOverlap { pitch_across_m, length_m })
            }
            _ => Ok(pattern),
        }
    }

    /// Everything but width, spacing and depth.
    #[must_use]
    pub const fn texture(&self) -> &Texture {
        &self.texture
    }

    /// The shape seen from above.
    #[must_use]
    pub const fn planform(&self) -> Planform {
        self.texture.planform()
    }

    /// Width of a cavity along x, in metres; of a disc its diameter.
    #[must_use]
    pub const fn width_m(&self) -> f64 {
        self.width_m
    }

    /// Gap between two neighbouring cavities of a row, along x, in metres.
    #[must_use]
    pub const fn spacing_m(&self) -> f64 {
        self.spacing_m
    }

    /// Depth of a cavity, in metres.
    #[must_use]
    pub const fn depth_m(&self) -> f64 {
        self.depth_m
    }

    /// Period of a row along x, width + spacing, in metres.
    #[must_use]
    pub fn pitch_m(&self) -> f64 {
        self.width_m + self.spacing_m
    }

    /// Extent of a cavity along y, in metres; `None` for grooves, which do not end.
    #[must_use]
    pub fn length_m(&self) -> Option<f64> {
        match self.planform() {
            Planform::Groove => None,
            Planform::Rectangle => Some(self.texture.length_m().unwrap_or(self.width_m)),
            Planform::Square | Planform::Disc => Some(self.width_m),
        }
    }

    /// Gap between two neighbouring rows, along y, in metres; `None` for grooves. Below zero where hexagonal rows of discs
    /// reach between each other.
    #[must_use]
    pub fn spacing_across_m(&self) -> Option<f64> {
        if self.texture.arrangement() == Arrangement::Hexagonal {
            return Some(HEXAGONAL * self.pitch_m() - self.length_m()?);
        }
        let spacing_across_m = self.texture.spacing_across_m().unwrap_or(self.spacing_m);
        (self.planform() != Planform::Groove).then_some(spacing_across_m)
    }

    /// Distance of neighbouring rows along y, length + spacing across, in metres; `None` for grooves.
    #[must_use]
    pub fn pitch_across_m(&self) -> Option<f64> {
        if self.texture.arrangement() == Arrangement::Hexagonal {
            return self.length_m().map(|_| HEXAGONAL * self.pitch_m());
        }
        Some(self.length_m()? + self.spacing_across_m()?)
    }

    /// Sides along x and y of the smallest rectangular periodic cell, in metres. A staggered or hexagonal cell
    /// holds two rows. Grooves are the same everywhere along y: their cell is given as a square, and
    /// any other length along y would do.
    #[must_use]
    pub fn cell_m(&self) -> [f64; 2] {
        let pitch_m = self.pitch_m();
        let rows = match self.texture.arrangement() {
            Arrangement::Square => 1.0,
            Arrangement::Staggered | Arrangement::Hexagonal => 2.0,
        };
        [pitch_m, self.pitch_across_m().map_or(pitch_m, |pitch_across_m| rows * pitch_across_m)]
    }

    /// Centres of the cavities of one cell, in metres from the centre of the first, the origin.
    pub fn centres_m(&self) -> impl Iterator<Item = [f64; 2]> + use<> {
        let second = match (self.texture.arrangement(), self.pitch_across_m()) {
            (arrangement, Some(pitch_across_m)) if arrangement.shifts_rows() => {
                Some([self.pitch_m() / 2.0, pitch_across_m])
            }
            _ => None,
        };
        std::iter::once([0.0, 0.0]).chain(second)
    }

    /// The same pattern, sliding at `angle_deg` from the specimen's X axis.
    ///
    /// # Errors
    /// [`PatternError::AngleOutOfRange`] beyond 180 degrees either way.
    pub fn with_sliding_angle_deg(mut self, angle_deg: f64) -> Result<Self, PatternError> {
        self.texture = self.texture.with_sliding_angle_deg(angle_deg)?;
        Ok(self)
    }

    /// The same pattern with `rim` about every cavity, or with none.
    #[must_use]
    pub fn with_rim(mut self, rim: impl Into<Option<Rim>>) -> Self {
        self.texture = self.texture.with_rim(rim);
        self
    }

    /// Unit vector of the sliding direction in the pattern's own axes.
    #[must_use]
    pub fn sliding_direction(&self) -> [f64; 2] {
        self.texture.sliding_direction()
    }

    /// Dimensions that a model of this pattern needs, as [`Texture::dimensions`].
    #[must_use]
    pub fn dimensions(&self) -> u8 {
        self.texture.dimensions()
    }

    /// Share, from 0 to 1, of the rectangle `[x0_m, x1_m] x [y0_m, y1_m]` that is cavity.
    ///
    /// The rectangle lies anywhere in the pattern's axes, whose origin is the centre of a cavity, and
    /// may be of any size. A cell whose first cavity is centred at (a, b) asks for its rectangles less
    /// (a, b); so a model decides itself how its blocks lie about a cavity. The share is closed form and
    /// continuous in the rectangle and in every dimension of the pattern. Within 1e-12 of 0 or 1 it is 0
    /// or 1: blocks that the edges of cavities do not cut are whole to the last bit. An empty rectangle,
    /// or one that is not finite, has no cavity: 0.
    #[must_use]
    pub fn coverage(&self, x0_m: f64, x1_m: f64, y0_m: f64, y1_m: f64) -> f64 {
        const ROUNDING: f64 = 1e-12;
        let share = self.coverage_within(0.0, [x0_m, x1_m], [y0_m, y1_m]);
        if share < ROUNDING {
            0.0
        } else if share > 1.0 - ROUNDING {
            1.0
        } else {
            share
        }
    }

    /// Share of a rectangle that lies in a cavity or within `distance_m` of one, at most half of the narrowest land; beside
    /// squares and rectangles within as much along x and along y.
    pub(crate) fn coverage_within(&self, distance_m: f64, x_m: [f64; 2], y_m: [f64; 2]) -> f64 {
        // Products and quotients of lengths below 1e-150 m would underflow: none is meant.
        let area_m2 = (x_m[1] - x_m[0]) * (y_m[1] - y_m[0]);
        let proper = x_m[1] > x_m[0] && y_m[1] > y_m[0] && area_m2.is_finite() && area_m2 > 0.0;
        if !proper {
            return 0.0;
        }
        let cell_m = self.cell_m();
        let width_m = self.width_m + 2.0 * distance_m;
        let shape = match (self.planform(), self.length_m()) {
            (Planform::Disc, _) => Shape::Disc { diameter_m: width_m },
            (_, Some(length_m)) => Shape::Rectangle { width_m, length_m: length_m + 2.0 * distance_m },
            (_, None) => Shape::Strip { width_m },
        };
        let covered_m2: f64 =
            self.centres_m().map(|centre_m| covered_area(shape, &Sublattice { centre_m, cell_m }, x_m, y_m)).sum();
        covered_m2 / area_m2
    }

    /// Share of a vertical section along x through the cavities' centres that is cavity, width / pitch.
    #[must_use]
    pub fn section_density(&self) -> f64 {
        self.width_m / self.pitch_m()
    }

    /// Share of the surface that is cavity.
    #[must_use]
    pub fn areal_density(&self) -> f64 {
        // (w / p) times the share of the rows across, weighed by a disc's mean chord
        self.section_density() * self.share_across()
    }

    /// The strip estimate of the friction ratio of a pattern whose vertical section along x, taken
    /// as a transversal groove, has the ratio `ratio_groove`: strips between the rows of cavities
    /// count as flat, a disc as a rectangle of its diameter and its area.
    #[must_use]
    pub fn strip_estimate(&self, ratio_groove: f64) -> f64 {
        match self.planform() {
            Planform::Groove => ratio_groove,
            // ratio = 1 - (length/pitch across) (1 - ratio_groove)
            _ => 1.0 - self.share_across() * (1.0 - ratio_groove),
        }
    }

    /// Mean length of a cavity along y over the distance of its rows; 1 for grooves.
    fn share_across(&self) -> f64 {
        let Some((length_m, pitch_across_m)) = self.length_m().zip(self.pitch_across_m()) else { return 1.0 };
        let mean = if self.planform() == Planform::Disc { std::f64::consts::FRAC_PI_4 } else { 1.0 };
        mean * (length_m / pitch_across_m)
    }

    /// Smallest distance between two cavities, in metres: the narrowest land.
    #[must_use]
    pub fn least_land_m(&self) -> f64 {
        let (Some(length_m), Some(spacing_across_m)) = (self.length_m(), self.spacing_across_m()) else {
            return self.spacing_m;
        };
        match self.texture.arrangement() {
            Arrangement::Square => self.spacing_m.min(spacing_across_m),
            // All six neighbours are as near as those of the row.
            Arrangement::Hexagonal if self.planform() == Planform::Disc => self.spacing_m,
            Arrangement::Staggered | Arrangement::Hexagonal => {
                // The next row lies half a pitch aside, the next but one straight ahead.
                let half_pitch_m = self.pitch_m() / 2.0;
                let aside_m = match self.planform() {
                    Planform::Disc => half_pitch_m.hypot(length_m + spacing_across_m) - self.width_m,
                    _ => (half_pitch_m - self.width_m).max(0.0).hypot(spacing_across_m),
                };
                self.spacing_m.min(aside_m).min(length_m + 2.0 * spacing_across_m)
            }
        }
    }

    /// Smallest extent of a cavity seen from above, in metres.
    #[must_use]
    pub fn least_extent_m(&self) -> f64 {
        self.length_m().map_or(self.width_m, |length_m| length_m.min(self.width_m))
    }

    /// The same section, rims included, as grooves across the sliding direction.
    #[must_use]
    pub fn as_groove(mut self) -> Self {
        self.texture = Texture::new(Planform::Groove).with_rim(self.texture.rim().copied());
        self
    }
}
