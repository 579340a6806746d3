//! Descriptions of a texture for drawings and process sheets.

use slipgrid_base::units::counted;
use slipgrid_model::pattern::{Arrangement, Pattern, Planform, Texture};

use crate::export::number::decimal;
use crate::export::{Laser, Layout, Removal};

/// Decimals of an angle in degrees: a millionth of a degree turns a specimen of 10 mm by less than a nanometre.
pub(crate) const ANGLE_DECIMALS: usize = 6;

/// Formats an angle in degrees, without a unit.
pub(crate) fn degrees(angle_deg: f64) -> String {
    decimal(angle_deg, ANGLE_DECIMALS)
}

/// Describes the bursts or passes that cut the cavities of `layout`, after a comma, for example `, 3 bursts`; empty if
/// `laser` does not state the depth of a burst.
pub(crate) fn steps(layout: &Layout, laser: &Laser) -> String {
    let bursts = laser.bursts(layout.pattern().depth_m()).map(|bursts| (bursts, "burst"));
    let passes = Removal::new(layout, laser).map(|removal| (removal.passes, "pass"));
    bursts.into_iter().chain(passes).map(|(count, noun)| format!(", {}", counted(count as usize, noun))).collect()
}

/// Describes the sliding direction on the specimen; "x" without a sliding angle.
pub(crate) fn sliding_direction(texture: &Texture) -> String {
    match texture.sliding_angle_deg() {
        0.0 => "x".to_owned(),
        angle_deg => format!("{} degrees from x, anticlockwise", degrees(angle_deg)),
    }
}

/// Describes the direction of grooves on the specimen.
pub(crate) fn groove_direction(texture: &Texture) -> String {
    if let Some(crossing_deg) = texture.crossing_angle_deg() {
        let (first_deg, second_deg) = (texture.groove_angle_deg(), texture.groove_angle_deg() + crossing_deg);
        return format!(
            "two families of grooves turned by {} and by {} degrees from lying across x",
            degrees(first_deg),
            degrees(second_deg)
        );
    }
    match (texture.groove_angle_deg(), texture.sliding_angle_deg()) {
        (0.0, 0.0) => "across the sliding direction".to_owned(),
        (0.0, _) => "across x".to_owned(),
        (angle_deg, _) => format!("turned by {} degrees from lying across x", degrees(angle_deg)),
    }
}

/// Plural name of the cavities of a planform.
pub(crate) const fn cavities(planform: Planform) -> &'static str {
    match planform {
        Planform::Groove => "grooves",
        Planform::Square => "square cavities",
        Planform::Rectangle => "rectangular cavities",
        Planform::Disc => "round cavities",
        Planform::Polygon => "polygonal cavities",
        Planform::Crosshatch => "crossing grooves",
    }
}

/// Describes the lattice of the cavities; not for grooves.
pub(crate) fn lattice(pattern: &Pattern) -> &'static str {
    let square = pattern.pitch_across_m() == Some(pattern.pitch_m());
    match (pattern.texture().arrangement(), square) {
        (Arrangement::Square, true) => "square lattice",
        (Arrangement::Square, false) => "rectangular lattice",
        (Arrangement::Staggered, _) => "staggered lattice, every second row half a pitch aside",
        (Arrangement::Hexagonal, _) => {
            "hexagonal lattice, every second row half a pitch aside, neighbours one pitch apart"
        }
    }
}
