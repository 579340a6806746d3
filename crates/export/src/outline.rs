use crate::ExportError;
use crate::error::positive;

/// The specimen's sliding face, centred on the origin. x is the sliding direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outline {
    /// A round face.
    Disc {
        /// Diameter, in metres.
        diameter_m: f64,
    },
    /// A rectangular face, sides along and across the sliding direction.
    Rectangle {
        /// Extent along the sliding direction x, in metres.
        length_m: f64,
        /// Extent across it, along y, in metres.
        width_m: f64,
    },
}

impl Outline {
    /// Checks that its lengths are positive and finite.
    pub(crate) fn validate(&self) -> Result<(), ExportError> {
        match *self {
            Self::Disc { diameter_m } => positive("diameter_m", diameter_m).map(|_| ()),
            Self::Rectangle { length_m, width_m } => {
                positive("length_m", length_m)?;
                positive("width_m", width_m).map(|_| ())
            }
        }
    }

    /// Area of the face, in square metres.
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        match *self {
            Self::Disc { diameter_m } => std::f64::consts::PI * diameter_m * diameter_m / 4.0,
            Self::Rectangle { length_m, width_m } => length_m * width_m,
        }
    }

    /// Extents along x and y, in metres.
    #[must_use]
    pub fn extents_m(&self) -> [f64; 2] {
        match *self {
            Self::Disc { diameter_m } => [diameter_m; 2],
            Self::Rectangle { length_m, width_m } => [length_m, width_m],
        }
    }

    /// Half the chord along one axis at the distance `offset_m` from the centre along the other,
    /// `along_x` saying which; `None` outside the face.
    pub(crate) fn half_chord_m(&self, along_x: bool, offset_m: f64) -> Option<f64> {
        match *self {
            Self::Disc { diameter_m } => {
                // c = sqrt((R - d)(R + d))
                let radius_m = diameter_m / 2.0;
                let square = (radius_m - offset_m) * (radius_m + offset_m);
                (square >= 0.0).then(|| square.sqrt())
            }
            Self::Rectangle { length_m, width_m } => {
                let (along_m, across_m) = if along_x { (length_m, width_m) } else { (width_m, length_m) };
                // An edge that lies on the outline but for rounding counts as inside.
                (offset_m <= across_m / 2.0 * (1.0 + 1e-12)).then_some(along_m / 2.0)
            }
        }
    }

    /// The name used in files.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Disc { .. } => "disc",
            Self::Rectangle { .. } => "rectangle",
        }
    }
}
