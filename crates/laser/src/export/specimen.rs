//! A specimen: its face, and the treatment of cavities at its border.

use slipgrid_model::pattern::{Pattern, Texture, folded_deg};

use crate::export::{ExportError, Layout, Outline};

/// Face of the specimen, and treatment of cavities that cross its border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Specimen {
    /// The face.
    pub outline: Outline,
    /// Whether cavities that cross the border are cut there instead of left out.
    pub is_clipped: bool,
}

impl Specimen {
    /// Lays out `pattern` on the specimen. Computing time is proportional to the number of lattice points.
    ///
    /// # Errors
    /// [`ExportError::Refused`] if the outline has no extent or too large a hole, [`ExportError::NoCavityFits`] if no
    /// cavity fits on it, [`ExportError::TooManyCavities`] for more than [`crate::export::MAX_CAVITIES`].
    pub fn layout(&self, pattern: Pattern) -> Result<Layout, ExportError> {
        Layout::on(*self, pattern)
    }

    /// Length of the face through the middle along the unit vector `sliding`, in metres, rounded to an integer number
    /// of blocks of `block_m`, at least one.
    pub fn whole_length_m(&self, sliding: [f64; 2], block_m: f64) -> f64 {
        (self.outline.length_along_m(sliding) / block_m).round().max(1.0) * block_m
    }

    /// Whether sliding at `other_deg` from x, anticlockwise in degrees, is equivalent to the sliding direction of
    /// `texture` by the symmetry of specimen and texture.
    pub fn slides_alike(&self, texture: &Texture, other_deg: f64) -> bool {
        let Outline::Rectangle { length_m, width_m } = self.outline else { return texture.slides_alike(other_deg) };
        let own_deg = texture.sliding_angle_deg();
        let is_back_or_forth = (own_deg - other_deg).rem_euclid(180.0) == 0.0;
        // Common symmetries of a rectangle and a texture along its sides: reflections at the axes, and at the diagonals
        // of a square.
        let shares_axes = texture.outline().is_none() && texture.orientation_deg().rem_euclid(90.0) == 0.0;
        let folded_deg = |angle_deg: f64| folded_deg(angle_deg, length_m == width_m);
        let is_alike = is_back_or_forth || shares_axes && (folded_deg(own_deg) - folded_deg(other_deg)).abs() < 1e-9;
        is_alike && texture.slides_alike(other_deg)
    }

    /// Checks whether `pattern` fits on the specimen with a period of it, without computing the complete layout. Designs
    /// and trials follow this rule.
    ///
    /// # Errors
    /// See [`Specimen::layout`] and [`Specimen::check_period`].
    pub fn check(&self, pattern: Pattern) -> Result<(), ExportError> {
        Layout::check(*self, pattern)?;
        self.check_period(&pattern)
    }

    /// Checks whether the specimen is at least as long as a period of `pattern`, in either direction.
    ///
    /// # Errors
    /// [`ExportError::NoPeriodFits`].
    pub fn check_period(&self, pattern: &Pattern) -> Result<(), ExportError> {
        let [x_m, y_m] = self.outline.extents_m();
        let (pitch_m, extent_m) = (pattern.pitch_m(), x_m.max(y_m));
        if pitch_m <= extent_m { Ok(()) } else { Err(ExportError::NoPeriodFits { pitch_m, extent_m }) }
    }
}

/// Names of the treatments of cavities that cross the border: left out, or cut.
pub const AT_THE_RIM: [&str; 2] = ["whole", "clipped"];

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_model::pattern::Planform;

    #[test]
    fn a_specimen_takes_what_repeats_on_it() {
        let plate = Outline::Rectangle { length_m: 1e-3, width_m: 2e-3 };
        for (outline, most_um) in [(Outline::Disc { diameter_m: 1e-3 }, 1000.0), (plate, 2000.0)] {
            let specimen = Specimen { outline, is_clipped: true };
            let of = |pitch_um: f64| {
                let pattern = Pattern::new(Planform::Groove, 1e-4, (pitch_um - 100.0) * 1e-6, 1e-5).unwrap();
                specimen.check(pattern)
            };
            assert_eq!(of(most_um - 0.1), Ok(()));
            let refused = of(most_um + 1.0).unwrap_err();
            assert!(matches!(refused, ExportError::NoPeriodFits { .. }), "{refused}");
            assert!(refused.to_string().ends_with(&format!("mm, more than the specimen's {} mm", most_um / 1e3)));
        }
    }

    #[test]
    fn directions_are_alike_where_face_and_texture_are() {
        let plate = |width_m: f64| Outline::Rectangle { length_m: 20e-3, width_m };
        let [disc, long, square] = [Outline::Disc { diameter_m: 10e-3 }, plate(5e-3), plate(20e-3)]
            .map(|outline| Specimen { outline, is_clipped: false });
        let squares = Texture::new(Planform::Square);
        let grooves = Texture::new(Planform::Groove).with_groove_angle_deg(30.0).unwrap();
        let grooves = grooves.with_sliding_angle_deg(30.0).unwrap();
        for (texture, other_deg, alike) in [
            (squares, 90.0, [true, false, true]),
            (squares, 180.0, [true, true, true]),
            (squares, 45.0, [false, false, false]),
            (squares.with_sliding_angle_deg(20.0).unwrap(), -20.0, [true, true, true]),
            (squares.with_sliding_angle_deg(20.0).unwrap(), 70.0, [true, false, true]),
            (grooves, -150.0, [true, true, true]),
            // Reflected at the grooves, which is no symmetry of a plate.
            (grooves.with_sliding_angle_deg(50.0).unwrap(), 10.0, [true, false, false]),
            (grooves.with_sliding_angle_deg(50.0).unwrap(), -50.0, [false, false, false]),
        ] {
            assert_eq!([disc, long, square].map(|on| on.slides_alike(&texture, other_deg)), alike, "{texture:?}");
        }
    }

    #[test]
    fn lengths_are_those_through_the_middle_along_the_sliding_direction() {
        let plate = Specimen { outline: Outline::Rectangle { length_m: 20e-3, width_m: 5e-3 }, is_clipped: false };
        let along = |angle_deg: f64| {
            let texture = Texture::new(Planform::Groove).with_sliding_angle_deg(angle_deg).unwrap();
            plate.whole_length_m(texture.sliding_direction_on_specimen(), 10e-6)
        };
        assert!((along(0.0) - 20e-3).abs() < 1e-12 && (along(90.0) - 5e-3).abs() < 1e-12);
        // 5 mm / sin 45
        assert!((along(45.0) - 7.07e-3).abs() < 1e-12, "{}", along(45.0));
    }
}
