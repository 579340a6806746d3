use crate::error::length;
use crate::{Arrangement, PatternError, Planform, Polygon, Rim};

/// Everything about a pattern but its width, spacing and depth: shape, extent across, arrangement,
/// directions and rims.
///
/// A texture lies on a specimen with axes X and Y. Its own axes x and y are turned from them by
/// `orientation_deg`, anticlockwise: that of grooves is free, cavities of other planforms keep
/// their sides along X and Y. The own axes of crossing grooves lie halfway between the families, or, where these are at
/// right angles, along them: so they have a rectangular cell. The specimen slides along a direction `sliding_angle_deg` from X.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texture {
    planform: Planform,
    length_m: Option<f64>,
    outline: Option<Polygon>,
    spacing_across_m: Option<f64>,
    arrangement: Arrangement,
    groove_angle_deg: f64,
    crossing_angle_deg: f64,
    sliding_angle_deg: f64,
    rim: Option<Rim>,
}

/// Nearer to parallel, two families of grooves have a cell of more than eleven pitches.
const MIN_CROSSING_ANGLE_DEG: f64 = 10.0;
const RIGHT_ANGLE_DEG: f64 = 90.0;
/// Grooves at 90 degrees and at -90 are the same.
const MAX_GROOVE_ANGLE_DEG: f64 = 90.0;
const MAX_SLIDING_ANGLE_DEG: f64 = 180.0;

/// Component of a sliding direction below which it lies along the other axis.
const ALIGNED: f64 = 1e-9;

impl Texture {
    /// Cavities of `planform`, as long as wide and as far apart along y as along x, every row like
    /// the one before, sliding along x. A polygon is a square until it has an outline; grooves cross at right angles.
    #[must_use]
    pub const fn new(planform: Planform) -> Self {
        Self {
            planform,
            length_m: None,
            outline: None,
            spacing_across_m: None,
            arrangement: Arrangement::Square,
            groove_angle_deg: 0.0,
            crossing_angle_deg: RIGHT_ANGLE_DEG,
            sliding_angle_deg: 0.0,
            rim: None,
        }
    }

    /// Rectangles `length_m` long along y, in metres.
    ///
    /// # Errors
    /// [`PatternError::NoSuchProperty`] for other planforms, [`PatternError::NotALength`] unless positive.
    pub fn with_length_m(mut self, length_m: f64) -> Result<Self, PatternError> {
        if self.planform != Planform::Rectangle {
            return self.no("a length", "planform \"rectangle\", or no length");
        }
        self.length_m = Some(length("length", length_m)?);
        Ok(self)
    }

    /// Polygons of this outline, scaled by the width.
    ///
    /// # Errors
    /// [`PatternError::NoSuchProperty`] for other planforms.
    pub fn with_outline(mut self, outline: Polygon) -> Result<Self, PatternError> {
        if self.planform != Planform::Polygon {
            return self.no("an outline", "planform \"polygon\", or no outline");
        }
        self.outline = Some(outline);
        Ok(self)
    }

    /// A second family of grooves that crosses the first at `angle_deg`, its direction turned from the first's
    /// anticlockwise.
    ///
    /// # Errors
    /// [`PatternError::NoSuchProperty`] for other planforms than crossing grooves, [`PatternError::CrossingAngle`] outside 10
    /// to 90 degrees: any two directions are so if the right one is called the first.
    pub fn with_crossing_angle_deg(mut self, angle_deg: f64) -> Result<Self, PatternError> {
        if self.planform != Planform::Crosshatch {
            return self.no("a crossing angle", "planform \"crosshatch\", or no crossing angle");
        }
        let (least_deg, most_deg) = (MIN_CROSSING_ANGLE_DEG, RIGHT_ANGLE_DEG);
        if !(least_deg..=most_deg).contains(&angle_deg) {
            return Err(PatternError::CrossingAngle { value_deg: angle_deg, least_deg, most_deg });
        }
        self.crossing_angle_deg = angle_deg;
        Ok(self)
    }

    /// A gap of `spacing_across_m` between neighbouring rows, along y, in metres.
    ///
    /// # Errors
    /// [`PatternError::NoSuchProperty`] for grooves, [`PatternError::HexagonalRows`] where rows have a distance of their
    /// own, [`PatternError::NotALength`] unless positive.
    pub fn with_spacing_across_m(mut self, spacing_across_m: f64) -> Result<Self, PatternError> {
        if self.planform.is_grooves() {
            return self.no("a spacing across", "another planform, or no spacing across");
        }
        if self.arrangement == Arrangement::Hexagonal {
            return Err(PatternError::HexagonalRows);
        }
        self.spacing_across_m = Some(length("spacing across", spacing_across_m)?);
        Ok(self)
    }

    /// The rows in `arrangement`.
    ///
    /// # Errors
    /// [`PatternError::NoSuchProperty`] for grooves, which have no rows; [`PatternError::HexagonalRows`] where a spacing
    /// across says how far apart they are.
    pub fn with_arrangement(mut self, arrangement: Arrangement) -> Result<Self, PatternError> {
        if self.planform.is_grooves() && arrangement != Arrangement::Square {
            let property = if arrangement == Arrangement::Staggered {
                "a staggered arrangement"
            } else {
                "a hexagonal arrangement"
            };
            return self.no(property, "another planform, or arrangement \"square\"");
        }
        if arrangement == Arrangement::Hexagonal && self.spacing_across_m.is_some() {
            return Err(PatternError::HexagonalRows);
        }
        self.arrangement = arrangement;
        Ok(self)
    }

    /// Grooves turned on the specimen by `angle_deg`, anticlockwise from lying across X: at 0 and
    /// sliding along X they are transversal, at 90 longitudinal. Of crossing grooves the first family.
    ///
    /// # Errors
    /// [`PatternError::NoSuchProperty`] for other planforms, [`PatternError::AngleOutOfRange`] beyond
    /// 90 degrees either way.
    pub fn with_groove_angle_deg(mut self, angle_deg: f64) -> Result<Self, PatternError> {
        if !self.planform.is_grooves() {
            return self.no("a groove angle", "planform \"groove\" or \"crosshatch\", or a sliding angle instead");
        }
        self.groove_angle_deg = angle("groove angle", angle_deg, MAX_GROOVE_ANGLE_DEG)?;
        Ok(self)
    }

    /// Sliding along a direction turned by `angle_deg` from the specimen's X axis, anticlockwise.
    ///
    /// # Errors
    /// [`PatternError::AngleOutOfRange`] beyond 180 degrees either way.
    pub fn with_sliding_angle_deg(mut self, angle_deg: f64) -> Result<Self, PatternError> {
        self.sliding_angle_deg = angle("sliding angle", angle_deg, MAX_SLIDING_ANGLE_DEG)?;
        Ok(self)
    }

    /// Cavities whose edges are raised by `rim`, or are not.
    #[must_use]
    pub fn with_rim(mut self, rim: impl Into<Option<Rim>>) -> Self {
        self.rim = rim.into();
        self
    }

    /// The rim of every cavity, where it has one.
    #[must_use]
    pub const fn rim(&self) -> Option<&Rim> {
        self.rim.as_ref()
    }

    fn no(self, property: &'static str, expected: &'static str) -> Result<Self, PatternError> {
        Err(PatternError::NoSuchProperty { property, planform: self.planform, expected })
    }

    /// The shape seen from above.
    #[must_use]
    pub const fn planform(&self) -> Planform {
        self.planform
    }

    /// Length of a rectangle along y, in metres, where it is not its width.
    #[must_use]
    pub const fn length_m(&self) -> Option<f64> {
        self.length_m
    }

    /// The outline of polygons; `None` for other planforms, and for polygons that are squares.
    #[must_use]
    pub const fn outline(&self) -> Option<Polygon> {
        self.outline
    }

    /// Gap between neighbouring rows along y, in metres, where it is not the spacing along x.
    #[must_use]
    pub const fn spacing_across_m(&self) -> Option<f64> {
        self.spacing_across_m
    }

    /// How rows follow each other.
    #[must_use]
    pub const fn arrangement(&self) -> Arrangement {
        self.arrangement
    }

    /// How far grooves, of crossing ones the first family, are turned from lying across the specimen's X axis, in degrees;
    /// 0 for other planforms.
    #[must_use]
    pub const fn groove_angle_deg(&self) -> f64 {
        self.groove_angle_deg
    }

    /// Angle between the two families of crossing grooves, in degrees; `None` for other planforms.
    #[must_use]
    pub const fn crossing_angle_deg(&self) -> Option<f64> {
        match self.planform {
            Planform::Crosshatch => Some(self.crossing_angle_deg),
            _ => None,
        }
    }

    /// Angles from the specimen's X axis to the widths of the families of grooves, in degrees: one, of crossing grooves two;
    /// empty for other planforms.
    pub fn families_deg(&self) -> impl Iterator<Item = f64> + use<> {
        let first = self.planform.is_grooves().then_some(self.groove_angle_deg);
        first.into_iter().chain(self.crossing_angle_deg().map(|crossing_deg| self.groove_angle_deg + crossing_deg))
    }

    /// Grooves alone whose widths lie at `angle_deg` from X, from -90 to 180, sliding as this texture does.
    pub(crate) fn family(&self, angle_deg: f64) -> Self {
        // Turned by half a turn grooves are the same.
        let groove_angle_deg = if angle_deg > MAX_GROOVE_ANGLE_DEG { angle_deg - 180.0 } else { angle_deg };
        Self { groove_angle_deg, sliding_angle_deg: self.sliding_angle_deg, ..Self::new(Planform::Groove) }
    }

    /// Half the angle between the families of crossing grooves where the own axes lie halfway between them, in degrees.
    pub(crate) fn oblique_half_angle_deg(&self) -> Option<f64> {
        self.crossing_angle_deg()
            .filter(|&crossing_deg| crossing_deg != RIGHT_ANGLE_DEG)
            .map(|crossing_deg| crossing_deg / 2.0)
    }

    /// Angle from the specimen's X axis to the texture's x axis, in degrees: the groove angle, of crossing grooves that
    /// between the families unless they are at right angles, and 0 for other planforms.
    #[must_use]
    pub fn orientation_deg(&self) -> f64 {
        self.groove_angle_deg + self.oblique_half_angle_deg().unwrap_or(0.0)
    }

    /// Angle from the specimen's X axis to the sliding direction, in degrees.
    #[must_use]
    pub const fn sliding_angle_deg(&self) -> f64 {
        self.sliding_angle_deg
    }

    /// Unit vector of the texture's x axis in the specimen's axes.
    #[must_use]
    pub fn orientation(&self) -> [f64; 2] {
        unit_vector(self.orientation_deg())
    }

    /// Unit vector of the sliding direction in the texture's own axes x and y.
    #[must_use]
    pub fn sliding_direction(&self) -> [f64; 2] {
        unit_vector(self.sliding_angle_deg - self.orientation_deg())
    }

    /// Whether the sliding direction is along the texture's own x rather than across it.
    #[must_use]
    pub fn slides_along_rows(&self) -> bool {
        let [along_x, along_y] = self.sliding_direction();
        along_x.abs() > along_y.abs()
    }

    /// Whether the sliding direction is neither along rows nor across them, so that the pattern repeats at no distance across it.
    #[must_use]
    pub fn slides_aslant(&self) -> bool {
        self.sliding_direction().iter().all(|part| part.abs() > ALIGNED)
    }

    /// Unit vector of the sliding direction in the specimen's axes X and Y.
    #[must_use]
    pub fn sliding_direction_on_specimen(&self) -> [f64; 2] {
        unit_vector(self.sliding_angle_deg)
    }

    /// Whether friction when sliding at `other_deg` from X is that of sliding as this texture does, by symmetry: back and
    /// forth are alike, as cavities are their own image when turned by 180 degrees; so are directions that are mirrored
    /// at a texture's axes, and at the diagonal of squares and discs that lie as far apart across as along. A polygon has
    /// what symmetry its outline has, and of a turn by 180 degrees, too, only then one.
    #[must_use]
    pub fn slides_alike(&self, other_deg: f64) -> bool {
        const SAME_DEG: f64 = 1e-9;
        let is_square_lattice = self.arrangement == Arrangement::Square && self.spacing_across_m.is_none();
        if let Some(outline) = self.outline {
            // A texture's own axes are the specimen's.
            let is_square_lattice = is_square_lattice && outline.length() == 1.0;
            return outline.symmetries().alike(self.sliding_angle_deg, other_deg, is_square_lattice, SAME_DEG);
        }
        let is_square =
            matches!(self.planform, Planform::Square | Planform::Disc | Planform::Polygon) && is_square_lattice;
        let has_square_symmetry = is_square || self.crossing_angle_deg() == Some(RIGHT_ANGLE_DEG);
        let folded_deg = |angle_deg: f64| folded_deg(angle_deg - self.orientation_deg(), has_square_symmetry);
        (folded_deg(self.sliding_angle_deg) - folded_deg(other_deg)).abs() < SAME_DEG
    }

    /// Whether every vertical section along the sliding direction is the same, which is so for grooves across it alone.
    #[must_use]
    pub fn is_one_section(&self) -> bool {
        self.planform == Planform::Groove && self.sliding_direction()[1] == 0.0
    }
}

impl From<Planform> for Texture {
    fn from(planform: Planform) -> Self {
        Self::new(planform)
    }
}

/// `value_deg` if it is finite and at most `most_deg` either way.
fn angle(quantity: &'static str, value_deg: f64, most_deg: f64) -> Result<f64, PatternError> {
    // A negative zero would print as one.
    let value_deg = value_deg + 0.0;
    if value_deg.abs() <= most_deg {
        Ok(value_deg)
    } else {
        Err(PatternError::AngleOutOfRange { quantity, value_deg, most_deg })
    }
}

/// The angle between a direction and the nearest x or -x, of 0 to 90 degrees; or where x and y are alike, the nearest of both, of 0 to 45.
#[must_use]
pub fn folded_deg(angle_deg: f64, has_square_symmetry: bool) -> f64 {
    let turned_deg = angle_deg.rem_euclid(180.0);
    let acute_deg = turned_deg.min(180.0 - turned_deg);
    if has_square_symmetry { acute_deg.min(90.0 - acute_deg) } else { acute_deg }
}

/// (cos a, sin a), exact at multiples of a right angle and the same on every platform.
fn unit_vector(angle_deg: f64) -> [f64; 2] {
    let quarters = (angle_deg / 90.0).round();
    let rest = (angle_deg - 90.0 * quarters).to_radians();
    let (sine, cosine) = (libm::sin(rest), libm::cos(rest));
    // Angles are at most 270 degrees either way: the cast is exact. Adding zero drops its sign.
    match (quarters as i32).rem_euclid(4) {
        0 => [cosine, sine + 0.0],
        1 => [-sine + 0.0, cosine],
        2 => [-cosine, -sine + 0.0],
        _ => [sine + 0.0, -cosine],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_angles_are_exact_and_others_are_the_cosine_and_sine() {
        for (angle_deg, expected) in
            [(0.0, [1.0, 0.0]), (90.0, [0.0, 1.0]), (180.0, [-1.0, 0.0]), (-90.0, [0.0, -1.0]), (270.0, [0.0, -1.0])]
        {
            assert_eq!(unit_vector(angle_deg), expected, "{angle_deg}");
        }
        for angle_deg in -270..=270 {
            let [cosine, sine] = unit_vector(f64::from(angle_deg));
            let radians = f64::from(angle_deg).to_radians();
            assert!((cosine - radians.cos()).abs() < 1e-15 && (sine - radians.sin()).abs() < 1e-15);
        }
        assert!((unit_vector(30.0)[1] - 0.5).abs() < 1e-16);
    }

    #[test]
    fn transversal_grooves_alone_are_one_section() {
        let groove = Texture::new(Planform::Groove);
        assert!(groove.is_one_section());
        assert!(groove.with_sliding_angle_deg(180.0).unwrap().is_one_section());
        // Grooves turned with the sliding direction stay across it.
        let turned = groove.with_groove_angle_deg(33.3).unwrap().with_sliding_angle_deg(33.3).unwrap();
        assert_eq!((turned.is_one_section(), turned.sliding_direction()), (true, [1.0, 0.0]));
        assert!(!groove.with_groove_angle_deg(1e-3).unwrap().is_one_section());
        assert!(!groove.with_sliding_angle_deg(90.0).unwrap().is_one_section());
        for planform in [Planform::Square, Planform::Rectangle, Planform::Disc] {
            assert!(!Texture::new(planform).is_one_section());
        }
    }

    #[test]
    fn a_longitudinal_groove_is_one_turned_or_one_slid_along() {
        let turned = Texture::new(Planform::Groove).with_groove_angle_deg(-90.0).unwrap();
        let slid = Texture::new(Planform::Groove).with_sliding_angle_deg(90.0).unwrap();
        assert_eq!(turned.sliding_direction(), [0.0, 1.0]);
        assert_eq!(turned.sliding_direction(), slid.sliding_direction());
        assert_eq!((turned.orientation(), slid.orientation()), ([0.0, -1.0], [1.0, 0.0]));
    }

    #[test]
    fn directions_alike_by_symmetry() {
        let at = |texture: Texture, angle_deg: f64| texture.with_sliding_angle_deg(angle_deg).unwrap();
        let groove = Texture::new(Planform::Groove);
        for (texture, alike, others) in [
            (groove, &[180.0, -180.0][..], &[90.0, 1.0][..]),
            (at(groove, 30.0), &[-30.0, 150.0, -150.0], &[60.0, 0.0]),
            (at(groove.with_groove_angle_deg(45.0).unwrap(), 90.0), &[0.0, 180.0], &[45.0]),
            (Texture::new(Planform::Square), &[90.0, -90.0, 180.0], &[45.0]),
            (at(Texture::new(Planform::Disc), 20.0), &[70.0, 110.0, -160.0], &[45.0]),
            (Texture::new(Planform::Square).with_spacing_across_m(1e-4).unwrap(), &[180.0], &[90.0]),
            (Texture::new(Planform::Square).with_arrangement(Arrangement::Staggered).unwrap(), &[180.0], &[90.0]),
            (Texture::new(Planform::Rectangle).with_length_m(1e-4).unwrap(), &[180.0], &[90.0]),
        ] {
            assert!(alike.iter().all(|angle_deg| texture.slides_alike(*angle_deg)), "{texture:?}");
            assert!(!others.iter().any(|angle_deg| texture.slides_alike(*angle_deg)), "{texture:?}");
        }
    }

    #[test]
    fn what_a_planform_does_not_have_is_refused_with_what_would_do() {
        let refused = |texture: Result<Texture, PatternError>| texture.unwrap_err().to_string();
        for planform in [Planform::Groove, Planform::Square, Planform::Disc] {
            assert!(refused(Texture::new(planform).with_length_m(1e-4)).contains("\"rectangle\""));
        }
        let groove = Texture::new(Planform::Groove);
        assert!(refused(groove.with_spacing_across_m(1e-4)).contains("\"groove\""));
        assert!(refused(groove.with_arrangement(Arrangement::Staggered)).contains("arrangement \"square\""));
        assert_eq!(groove.with_arrangement(Arrangement::Square).unwrap(), groove);
        for planform in [Planform::Square, Planform::Rectangle, Planform::Disc] {
            assert!(refused(Texture::new(planform).with_groove_angle_deg(10.0)).contains("a sliding angle instead"));
        }
    }

    #[test]
    fn numbers_that_mean_nothing_are_refused() {
        let groove = Texture::new(Planform::Groove);
        for bad in [90.1, -91.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(groove.with_groove_angle_deg(bad), Err(PatternError::AngleOutOfRange { .. })));
            assert!(matches!(groove.with_sliding_angle_deg(2.0 * bad), Err(PatternError::AngleOutOfRange { .. })));
        }
        for bad in [0.0, -1e-6, f64::NAN, f64::INFINITY] {
            let rectangle = Texture::new(Planform::Rectangle);
            assert!(matches!(rectangle.with_length_m(bad), Err(PatternError::NotALength { .. })));
            assert!(matches!(rectangle.with_spacing_across_m(bad), Err(PatternError::NotALength { .. })));
        }
    }
}
