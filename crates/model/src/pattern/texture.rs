use crate::pattern::error::length;
use crate::pattern::{Arrangement, PatternError, Planform, Polygon, Rim};

/// All properties of a pattern except width, spacing and depth: shape, extent across, arrangement, directions and rims.
///
/// A texture lies on a specimen with axes X and Y. The texture's axes x and y are turned against them by
/// `orientation_deg`, anticlockwise. Grooves may have any orientation; cavities of other planforms have their sides
/// along X and Y. The axes of crossing grooves lie halfway between the families, or along them if they cross at right
/// angles, so that the cell is rectangular. The specimen slides along a direction `sliding_angle_deg` from X.
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

/// Minimum angle between crossing grooves; at smaller angles their cell is longer than eleven pitches.
const MIN_CROSSING_ANGLE_DEG: f64 = 10.0;
const RIGHT_ANGLE_DEG: f64 = 90.0;
/// Maximum groove angle; grooves at 90 and -90 degrees are equal.
const MAX_GROOVE_ANGLE_DEG: f64 = 90.0;
const MAX_SLIDING_ANGLE_DEG: f64 = 180.0;

/// A component of the sliding direction's unit vector below this value counts as zero.
const MIN_COMPONENT: f64 = 1e-9;

impl Texture {
    /// Creates a texture of `planform` with length equal to width, equal spacing along x and y, a square arrangement,
    /// and sliding along x. A polygon is a square until an outline is set; grooves cross at right angles.
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

    /// Sets the length of rectangles along y, in metres.
    ///
    /// # Errors
    /// [`PatternError::NoSuchProperty`] for other planforms, [`PatternError::Refused`] unless positive.
    pub fn with_length_m(mut self, length_m: f64) -> Result<Self, PatternError> {
        if self.planform != Planform::Rectangle {
            return self.refuse("a length", "planform \"rectangle\", or no length");
        }
        self.length_m = Some(length("length", length_m)?);
        Ok(self)
    }

    /// Sets the outline of polygons, which is scaled by the width.
    ///
    /// # Errors
    /// [`PatternError::NoSuchProperty`] for other planforms.
    pub fn with_outline(mut self, outline: Polygon) -> Result<Self, PatternError> {
        if self.planform != Planform::Polygon {
            return self.refuse("an outline", "planform \"polygon\", or no outline");
        }
        self.outline = Some(outline);
        Ok(self)
    }

    /// Sets the angle of the second family of crossing grooves, anticlockwise from the first.
    ///
    /// # Errors
    /// [`PatternError::NoSuchProperty`] for other planforms, [`PatternError::Refused`] outside 10 to 90 degrees;
    /// any two directions are within this range if the families are numbered accordingly.
    pub fn with_crossing_angle_deg(mut self, angle_deg: f64) -> Result<Self, PatternError> {
        if self.planform != Planform::Crosshatch {
            return self.refuse("a crossing angle", "planform \"crosshatch\", or no crossing angle");
        }
        let (least_deg, most_deg) = (MIN_CROSSING_ANGLE_DEG, RIGHT_ANGLE_DEG);
        if !(least_deg..=most_deg).contains(&angle_deg) {
            let expected = format!("expected {least_deg} to {most_deg}");
            return Err(PatternError::Refused(format!("crossing angle of {angle_deg} degrees: {expected}")));
        }
        self.crossing_angle_deg = angle_deg;
        Ok(self)
    }

    /// Sets the gap between neighbouring rows along y, in metres.
    ///
    /// # Errors
    /// [`PatternError::NoSuchProperty`] for grooves, [`PatternError::Refused`] for a hexagonal arrangement or unless
    /// positive.
    pub fn with_spacing_across_m(mut self, spacing_across_m: f64) -> Result<Self, PatternError> {
        if self.planform.is_grooves() {
            return self.refuse("a spacing across", "another planform, or no spacing across");
        }
        if self.arrangement == Arrangement::Hexagonal {
            return Err(hexagonal_rows());
        }
        self.spacing_across_m = Some(length("spacing across", spacing_across_m)?);
        Ok(self)
    }

    /// Sets the arrangement of rows.
    ///
    /// # Errors
    /// [`PatternError::NoSuchProperty`] for grooves, which have no rows; [`PatternError::Refused`] for hexagonal rows
    /// if a spacing across was set.
    pub fn with_arrangement(mut self, arrangement: Arrangement) -> Result<Self, PatternError> {
        if self.planform.is_grooves() && arrangement != Arrangement::Square {
            let property = if arrangement == Arrangement::Staggered {
                "a staggered arrangement"
            } else {
                "a hexagonal arrangement"
            };
            return self.refuse(property, "another planform, or arrangement \"square\"");
        }
        if arrangement == Arrangement::Hexagonal && self.spacing_across_m.is_some() {
            return Err(hexagonal_rows());
        }
        self.arrangement = arrangement;
        Ok(self)
    }

    /// Sets the angle of grooves (of the first family for crossing grooves), anticlockwise from the direction across X:
    /// for sliding along X, grooves are transversal at 0 and longitudinal at 90 degrees.
    ///
    /// # Errors
    /// [`PatternError::NoSuchProperty`] for other planforms, [`PatternError::Refused`] outside -90 to 90
    /// degrees.
    pub fn with_groove_angle_deg(mut self, angle_deg: f64) -> Result<Self, PatternError> {
        if !self.planform.is_grooves() {
            return self.refuse("a groove angle", "planform \"groove\" or \"crosshatch\", or a sliding angle instead");
        }
        self.groove_angle_deg = angle("groove angle", angle_deg, MAX_GROOVE_ANGLE_DEG)?;
        Ok(self)
    }

    /// Sets the sliding direction, anticlockwise from the specimen's X axis.
    ///
    /// # Errors
    /// [`PatternError::Refused`] outside -180 to 180 degrees.
    pub fn with_sliding_angle_deg(mut self, angle_deg: f64) -> Result<Self, PatternError> {
        self.sliding_angle_deg = angle("sliding angle", angle_deg, MAX_SLIDING_ANGLE_DEG)?;
        Ok(self)
    }

    /// Sets the rim of every cavity, or removes rims.
    #[must_use]
    pub fn with_rim(mut self, rim: impl Into<Option<Rim>>) -> Self {
        self.rim = rim.into();
        self
    }

    /// Rim of every cavity; `None` without rims.
    pub const fn rim(&self) -> Option<&Rim> {
        self.rim.as_ref()
    }

    fn refuse(self, property: &'static str, expected: &'static str) -> Result<Self, PatternError> {
        Err(PatternError::NoSuchProperty { property, planform: self.planform, expected })
    }

    /// Shape seen from above.
    pub const fn planform(&self) -> Planform {
        self.planform
    }

    /// Length of a rectangle along y, in metres; `None` if it is not set and equals the width.
    pub const fn length_m(&self) -> Option<f64> {
        self.length_m
    }

    /// Outline of polygons; `None` for other planforms, and for polygons without a set outline, which are squares.
    pub const fn outline(&self) -> Option<Polygon> {
        self.outline
    }

    /// Gap between neighbouring rows along y, in metres; `None` if it is not set: then it equals the spacing along x or
    /// follows from a hexagonal arrangement.
    pub const fn spacing_across_m(&self) -> Option<f64> {
        self.spacing_across_m
    }

    /// Arrangement of rows.
    pub const fn arrangement(&self) -> Arrangement {
        self.arrangement
    }

    /// Angle of the grooves (of the first family for crossing grooves), anticlockwise from the direction across the
    /// specimen's X axis, in degrees; 0 for other planforms.
    pub const fn groove_angle_deg(&self) -> f64 {
        self.groove_angle_deg
    }

    /// Angle between the two families of crossing grooves, in degrees; `None` for other planforms.
    pub const fn crossing_angle_deg(&self) -> Option<f64> {
        match self.planform {
            Planform::Crosshatch => Some(self.crossing_angle_deg),
            _ => None,
        }
    }

    /// Angles from the specimen's X axis to the width directions of the families of grooves, in degrees: one for
    /// grooves, two for crossing grooves, none for other planforms.
    pub fn families_deg(&self) -> impl Iterator<Item = f64> + use<> {
        let first = self.planform.is_grooves().then_some(self.groove_angle_deg);
        first.into_iter().chain(self.crossing_angle_deg().map(|crossing_deg| self.groove_angle_deg + crossing_deg))
    }

    /// A single family of grooves with the width direction at `angle_deg` from X, -90 to 180, and the sliding direction
    /// of this texture.
    pub(crate) fn family(&self, angle_deg: f64) -> Self {
        // Grooves are equal after a rotation by 180 degrees.
        let groove_angle_deg = if angle_deg > MAX_GROOVE_ANGLE_DEG { angle_deg - 180.0 } else { angle_deg };
        Self { groove_angle_deg, sliding_angle_deg: self.sliding_angle_deg, ..Self::new(Planform::Groove) }
    }

    /// Half the angle between the families of obliquely crossing grooves, whose axes lie halfway between them, in
    /// degrees; `None` for other textures.
    pub(crate) fn oblique_half_angle_deg(&self) -> Option<f64> {
        self.crossing_angle_deg()
            .filter(|&crossing_deg| crossing_deg != RIGHT_ANGLE_DEG)
            .map(|crossing_deg| crossing_deg / 2.0)
    }

    /// Angle from the specimen's X axis to the texture's x axis, in degrees: the groove angle, the angle halfway
    /// between the families for obliquely crossing grooves, and 0 for other planforms.
    pub fn orientation_deg(&self) -> f64 {
        self.groove_angle_deg + self.oblique_half_angle_deg().unwrap_or(0.0)
    }

    /// Angle from the specimen's X axis to the sliding direction, in degrees.
    pub const fn sliding_angle_deg(&self) -> f64 {
        self.sliding_angle_deg
    }

    /// Unit vector of the texture's x axis in the specimen's axes.
    pub fn orientation(&self) -> [f64; 2] {
        unit_vector(self.orientation_deg())
    }

    /// Unit vector of the sliding direction in the texture's axes x and y.
    pub fn sliding_direction(&self) -> [f64; 2] {
        unit_vector(self.sliding_angle_deg - self.orientation_deg())
    }

    /// Whether the sliding direction is closer to the texture's x axis than to its y axis.
    pub fn slides_along_rows(&self) -> bool {
        let [along_x, along_y] = self.sliding_direction();
        along_x.abs() > along_y.abs()
    }

    /// Whether the sliding direction is neither along rows nor across them, so that the pattern is not periodic across
    /// the sliding direction.
    pub fn slides_aslant(&self) -> bool {
        self.sliding_direction().iter().all(|part| part.abs() > MIN_COMPONENT)
    }

    /// Unit vector of the sliding direction in the specimen's axes X and Y.
    pub fn sliding_direction_on_specimen(&self) -> [f64; 2] {
        unit_vector(self.sliding_angle_deg)
    }

    /// Whether friction for sliding at `other_deg` from X equals that for this texture's direction by symmetry.
    /// Cavities are symmetric under rotation by 180 degrees, so that both directions along a line are equivalent.
    /// Directions reflected at the texture's axes are equivalent as well, and so are directions reflected at the
    /// diagonal for squares and discs with equal spacings. For a polygon only the symmetries of its outline count.
    pub fn slides_alike(&self, other_deg: f64) -> bool {
        const SAME_DEG: f64 = 1e-9;
        let is_square_lattice = self.arrangement == Arrangement::Square && self.spacing_across_m.is_none();
        if let Some(outline) = self.outline {
            // The axes of polygons are those of the specimen.
            let is_square_lattice = is_square_lattice && outline.length() == 1.0;
            return outline.symmetries().maps_direction(self.sliding_angle_deg, other_deg, is_square_lattice, SAME_DEG);
        }
        let is_square =
            matches!(self.planform, Planform::Square | Planform::Disc | Planform::Polygon) && is_square_lattice;
        let has_square_symmetry = is_square || self.crossing_angle_deg() == Some(RIGHT_ANGLE_DEG);
        let folded_deg = |angle_deg: f64| folded_deg(angle_deg - self.orientation_deg(), has_square_symmetry);
        (folded_deg(self.sliding_angle_deg) - folded_deg(other_deg)).abs() < SAME_DEG
    }

    /// Whether all vertical sections along the sliding direction are equal: true only for grooves across the sliding
    /// direction.
    pub fn is_one_section(&self) -> bool {
        self.planform == Planform::Groove && self.sliding_direction()[1] == 0.0
    }
}

impl From<Planform> for Texture {
    fn from(planform: Planform) -> Self {
        Self::new(planform)
    }
}

/// Error for a stated `spacing_across` in a hexagonal arrangement, where it follows from the pitch.
fn hexagonal_rows() -> PatternError {
    let refused = "rows of a hexagonal arrangement are sqrt(3)/2 of a pitch apart: expected no spacing across";
    PatternError::Refused(refused.to_owned())
}

/// Checks that `value_deg` is within -`most_deg` to `most_deg`.
fn angle(quantity: &str, value_deg: f64, most_deg: f64) -> Result<f64, PatternError> {
    // Adding zero removes the sign of a negative zero, which would be printed.
    let value_deg = value_deg + 0.0;
    if value_deg.abs() <= most_deg {
        Ok(value_deg)
    } else {
        let expected = format!("expected -{most_deg} to {most_deg}");
        Err(PatternError::Refused(format!("{quantity} of {value_deg} degrees: {expected}")))
    }
}

/// Angle between a direction and the x axis, from 0 to 90 degrees; or, if x and y are equivalent, to the nearest axis,
/// from 0 to 45 degrees.
pub fn folded_deg(angle_deg: f64, has_square_symmetry: bool) -> f64 {
    let turned_deg = angle_deg.rem_euclid(180.0);
    let acute_deg = turned_deg.min(180.0 - turned_deg);
    if has_square_symmetry { acute_deg.min(90.0 - acute_deg) } else { acute_deg }
}

/// (cos a, sin a) for the angle a = `angle_deg`, exact at multiples of a right angle and equal on all platforms.
fn unit_vector(angle_deg: f64) -> [f64; 2] {
    let quarters = (angle_deg / 90.0).round();
    let rest = (angle_deg - 90.0 * quarters).to_radians();
    let (sine, cosine) = (libm::sin(rest), libm::cos(rest));
    // Angles are within -270 to 270 degrees, so that the cast is exact. Adding zero removes the sign of zero.
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
    use crate::pattern::Pattern;

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
            assert!(matches!(groove.with_groove_angle_deg(bad), Err(PatternError::Refused(_))));
            assert!(matches!(groove.with_sliding_angle_deg(2.0 * bad), Err(PatternError::Refused(_))));
        }
        for bad in [0.0, -1e-6, f64::NAN, f64::INFINITY] {
            let rectangle = Texture::new(Planform::Rectangle);
            assert!(matches!(rectangle.with_length_m(bad), Err(PatternError::Refused(_))));
            assert!(matches!(rectangle.with_spacing_across_m(bad), Err(PatternError::Refused(_))));
            assert!(Pattern::new(groove, 1e-4, bad, 1e-5).unwrap_err().to_string().contains("spacing"));
        }
    }
}
