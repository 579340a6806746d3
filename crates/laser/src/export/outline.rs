use crate::export::{ExportError, mm, positive};

/// Outline of the sliding face of a specimen, centred on the origin of its axes x and y. x is the sliding direction
/// unless the texture has a sliding angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outline {
    /// A round face.
    Disc {
        /// Diameter, in metres.
        diameter_m: f64,
    },
    /// A rectangular face with sides along x and y.
    Rectangle {
        /// Extent along x, in metres.
        length_m: f64,
        /// Extent along y, in metres.
        width_m: f64,
    },
    /// A round face with a round hole about its centre.
    Ring {
        /// Outer diameter, in metres.
        outer_diameter_m: f64,
        /// Diameter of the hole, in metres.
        inner_diameter_m: f64,
    },
}

impl Outline {
    /// Checks that lengths are positive and finite, and that the hole of a ring is smaller than the ring.
    pub(crate) fn validate(&self) -> Result<(), ExportError> {
        match *self {
            Self::Disc { diameter_m } => positive("diameter_m", diameter_m),
            Self::Rectangle { length_m, width_m } => {
                positive("length_m", length_m)?;
                positive("width_m", width_m)
            }
            Self::Ring { outer_diameter_m, inner_diameter_m } => {
                positive("outer_diameter_m", outer_diameter_m)?;
                positive("inner_diameter_m", inner_diameter_m)?;
                if inner_diameter_m < outer_diameter_m {
                    return Ok(());
                }
                let [outer_mm, inner_mm] = [outer_diameter_m, inner_diameter_m].map(mm);
                let ring = format!("a ring of {outer_mm} mm has a hole of {inner_mm} mm");
                Err(ExportError::Refused(format!("{ring}: expected a smaller hole")))
            }
        }
    }

    /// Area of the face, in square metres.
    pub fn area_m2(&self) -> f64 {
        match *self {
            Self::Disc { diameter_m } => std::f64::consts::PI * diameter_m * diameter_m / 4.0,
            Self::Rectangle { length_m, width_m } => length_m * width_m,
            // pi (D - d)(D + d) / 4
            Self::Ring { outer_diameter_m, inner_diameter_m } => {
                std::f64::consts::FRAC_PI_4
                    * (outer_diameter_m - inner_diameter_m)
                    * (outer_diameter_m + inner_diameter_m)
            }
        }
    }

    /// Extents along x and y, in metres.
    pub fn extents_m(&self) -> [f64; 2] {
        match *self {
            Self::Disc { diameter_m } | Self::Ring { outer_diameter_m: diameter_m, .. } => [diameter_m; 2],
            Self::Rectangle { length_m, width_m } => [length_m, width_m],
        }
    }

    /// Diameter of the hole, in metres; 0 without a hole.
    pub(crate) const fn hole_m(&self) -> f64 {
        match *self {
            Self::Ring { inner_diameter_m, .. } => inner_diameter_m,
            _ => 0.0,
        }
    }

    /// Distance from the centre to the outer border along the unit vector `direction`, in metres.
    pub(crate) fn rim_m(&self, direction: [f64; 2]) -> f64 {
        let [half_x_m, half_y_m] = self.extents_m().map(|extent_m| extent_m / 2.0);
        match self {
            Self::Rectangle { .. } => (half_x_m / direction[0].abs()).min(half_y_m / direction[1].abs()),
            _ => half_x_m,
        }
    }

    /// Shrinks the outline to the points at least `inset_m` from border and hole; `None` if there are none.
    pub(crate) fn inset(&self, inset_m: f64) -> Option<Self> {
        let less = |extent_m: f64| Some(extent_m - 2.0 * inset_m).filter(|&extent_m| extent_m > 0.0);
        match *self {
            Self::Disc { diameter_m } => Some(Self::Disc { diameter_m: less(diameter_m)? }),
            Self::Rectangle { length_m, width_m } => {
                Some(Self::Rectangle { length_m: less(length_m)?, width_m: less(width_m)? })
            }
            Self::Ring { outer_diameter_m, inner_diameter_m } => {
                let (outer_diameter_m, inner_diameter_m) = (less(outer_diameter_m)?, inner_diameter_m + 2.0 * inset_m);
                (inner_diameter_m < outer_diameter_m).then_some(Self::Ring { outer_diameter_m, inner_diameter_m })
            }
        }
    }

    /// Whether a point, in metres, lies on the face.
    pub(crate) fn contains(&self, [x_m, y_m]: [f64; 2]) -> bool {
        match *self {
            Self::Rectangle { length_m, width_m } => x_m.abs() <= length_m / 2.0 && y_m.abs() <= width_m / 2.0,
            Self::Disc { diameter_m } | Self::Ring { outer_diameter_m: diameter_m, .. } => {
                let distance_m = x_m.hypot(y_m);
                distance_m <= diameter_m / 2.0 && distance_m >= self.hole_m() / 2.0
            }
        }
    }

    /// Extent along the unit vector `along`, in metres.
    pub(crate) fn extent_along_m(&self, along: [f64; 2]) -> f64 {
        match *self {
            Self::Disc { diameter_m } | Self::Ring { outer_diameter_m: diameter_m, .. } => diameter_m,
            Self::Rectangle { length_m, width_m } => along[0].abs() * length_m + along[1].abs() * width_m,
        }
    }

    /// Chord that the outer border cuts from a line: positions of its ends along the line, in metres; `None` outside
    /// the face. The line has the unit normal `[cosine, sine]` and the distance `offset_m` from the centre along the
    /// normal; it runs along the normal turned by 90 degrees anticlockwise.
    pub(crate) fn chord_m(&self, [cosine, sine]: [f64; 2], offset_m: f64) -> Option<[f64; 2]> {
        match *self {
            Self::Disc { diameter_m } | Self::Ring { outer_diameter_m: diameter_m, .. } => {
                // c = sqrt((R - d)(R + d))
                let radius_m = diameter_m / 2.0;
                let square = (radius_m - offset_m) * (radius_m + offset_m);
                (square >= 0.0).then(|| [-square.sqrt(), square.sqrt()])
            }
            Self::Rectangle { length_m, width_m } => {
                // Points (u c - t s, u s + t c) of the line, with the offset u, within both pairs of sides.
                let [low_m, high_m] = between_sides(length_m / 2.0, offset_m * cosine, -sine)?;
                let [low_y_m, high_y_m] = between_sides(width_m / 2.0, offset_m * sine, cosine)?;
                let chord_m = [low_m.max(low_y_m), high_m.min(high_y_m)];
                (chord_m[0] <= chord_m[1]).then_some(chord_m)
            }
        }
    }

    /// Intervals of a line on the face, in metres along the line and ascending: one, two next to a hole, or none. The
    /// line runs along the unit vector `along`, `at_m` to the left of the centre.
    pub(crate) fn chords_along_m(&self, along: [f64; 2], at_m: f64) -> Vec<[f64; 2]> {
        // The normal turned anticlockwise points backwards.
        let Some([low_m, high_m]) = self.chord_m(left_of(along), at_m) else { return Vec::new() };
        let (from_m, to_m) = (-high_m, -low_m);
        let hole_m = self.hole_m() / 2.0;
        if at_m.abs() >= hole_m {
            return vec![[from_m, to_m]];
        }
        let half_m = ((hole_m - at_m) * (hole_m + at_m)).sqrt();
        vec![[from_m, -half_m], [half_m, to_m]]
    }

    /// Length of the line through the centre along the unit vector `along`, from border to border, in metres, including
    /// a hole.
    pub fn length_along_m(&self, along: [f64; 2]) -> f64 {
        2.0 * self.rim_m(along)
    }

    /// Name of the shape in files.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Disc { .. } => "disc",
            Self::Rectangle { .. } => "rectangle",
            Self::Ring { .. } => "ring",
        }
    }
}

/// Unit vector `[dx, dy]` turned by 90 degrees anticlockwise.
pub(crate) fn left_of([dx, dy]: [f64; 2]) -> [f64; 2] {
    // Avoids a negative zero.
    [0.0 - dy, dx]
}

/// Range of t for which `at_m + t slope` lies within +-`half_m`; `None` if it is empty.
fn between_sides(half_m: f64, at_m: f64, slope: f64) -> Option<[f64; 2]> {
    if slope == 0.0 {
        // An edge on the outline, within rounding, counts as inside.
        return (at_m.abs() <= half_m * (1.0 + 1e-12)).then_some([f64::NEG_INFINITY, f64::INFINITY]);
    }
    let (from, to) = ((-half_m - at_m) / slope, (half_m - at_m) / slope);
    Some([from.min(to), from.max(to)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chords_of_a_rectangle_end_on_its_sides() {
        let rectangle = Outline::Rectangle { length_m: 4.0, width_m: 2.0 };
        assert_eq!(rectangle.chord_m([1.0, 0.0], 1.5), Some([-1.0, 1.0]));
        assert_eq!(rectangle.chord_m([0.0, 1.0], 0.5), Some([-2.0, 2.0]));
        assert_eq!(rectangle.chord_m([0.0, 1.0], 1.5), None);
        let diagonal = [std::f64::consts::FRAC_1_SQRT_2; 2];
        let [low, high] = rectangle.chord_m(diagonal, 0.0).unwrap();
        assert!((high - 2_f64.sqrt()).abs() < 1e-15 && low == -high);
        // Along the normal the corner lies at 3/sqrt 2.
        assert!(rectangle.chord_m(diagonal, 3.0 / 2_f64.sqrt() - 1e-9).is_some_and(|[low, high]| high - low < 1e-8));
        assert_eq!(rectangle.chord_m(diagonal, 3.0 / 2_f64.sqrt() + 1e-9), None);
        assert!((rectangle.extent_along_m(diagonal) - 6.0 / 2_f64.sqrt()).abs() < 1e-15);
    }
}
