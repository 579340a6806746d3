//! Areas of cavities that the spot does not reach.
//!
//! The spot stays inside the border of the specimen. A cavity that the border cuts to less than the spot has no line; in
//! a corner, most of the spot is outside, and the depth is less than half:
//!
//! ```text
//! made share = area(points at least half as deep as the middle) / area(cavity)
//! ```

use crate::export::{Cavity, Layout, decimal};

/// Number of sample points along each extent of a cavity.
const POINTS: u32 = 60;
/// Minimum fraction of a cavity that is made without a warning. A spot half as wide as the cavity makes 93 % of a square
/// and all of a disc.
const MIN_MADE: f64 = 0.9;

/// Warnings about cavity areas of `layout` that a spot of radius `half_spot_m` does not reach. `bare` is the number and
/// total area, in square metres, of cavities without a hatch line; `made` is the fraction of another cavity that is at
/// least half as deep as its middle.
pub(crate) fn warnings(layout: &Layout, half_spot_m: f64, bare: (u32, f64), made: f64) -> Vec<String> {
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    let spot = decimal(2e6 * half_spot_m, 1);
    let mut warnings = Vec::new();
    if let (cavities @ 1.., area_m2) = bare {
        let share = percent(area_m2 / layout.cavity_area_m2());
        warnings.push(format!(
            "{cavities} of {} cavities, {share} of their area, are cut by the rim to less than the spot, {spot} um, and get no line; friction was \
             computed with them: a smaller spot makes them, and cavities = \"whole\" leaves them out of both",
            layout.cavities(),
        ));
    }
    if made < MIN_MADE {
        warnings.push(format!(
            "lines make {} of the area of a cavity half as deep as its middle, whose corners the spot, {spot} um, does not get into; friction \
             was computed with all of it: a smaller spot or wider cavities come nearer",
            percent(made)
        ));
    }
    warnings
}

/// Fraction of `cavity` whose points satisfy `is_made`.
pub(crate) fn share(cavity: &Cavity, is_made: impl Fn([f64; 2]) -> bool) -> f64 {
    let [cosine, sine] = cavity.orientation;
    let place = |k: u32| (f64::from(k) + 0.5) / f64::from(POINTS) - 0.5;
    let at = |(i, j): (u32, u32)| {
        let (along_m, across_m) = (place(i) * cavity.width_m, place(j) * cavity.length_m);
        [cavity.centre_x_m + along_m * cosine - across_m * sine, cavity.centre_y_m + along_m * sine + across_m * cosine]
    };
    let all = (0..POINTS).flat_map(|i| (0..POINTS).map(move |j| (i, j))).map(at);
    let inside: Vec<[f64; 2]> = all.filter(|at_m| cavity.wall_distance_m(*at_m) >= 0.0).collect();
    inside.iter().filter(|at_m| is_made(**at_m)).count() as f64 / inside.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::removal::CavityHatch;
    use crate::export::{Laser, Outline, laser_warnings};
    use slipgrid_model::pattern::{Pattern, Planform, Polygon, Texture};

    const DISC: Outline = Outline::Disc { diameter_m: 2e-3 };

    fn triangle() -> Texture {
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.5, 0.75_f64.sqrt()]];
        Texture::new(Planform::Polygon).with_outline(Polygon::new(&corners).unwrap()).unwrap()
    }

    fn made(texture: Texture, width_um: f64, spot_um: f64) -> f64 {
        let pattern = Pattern::new(texture, width_um * 1e-6, 100e-6, 10e-6).unwrap();
        let laser = Laser { spot_um: Some(spot_um), hatch_um: Some(spot_um / 20.0), ..Laser::default() };
        CavityHatch::of_pattern(&pattern, &laser).unwrap().made_share()
    }

    #[test]
    fn a_spot_makes_what_lies_more_than_half_inside() {
        // The share of a square by counting points of the spot, lengths in radii of it.
        let counted = |width: f64| {
            let at = |k: u32, n: u32, extent: f64| (f64::from(k) + 0.5) / f64::from(n) * extent - extent / 2.0;
            let inside = |x: f64, y: f64| x.abs() < width / 2.0 && y.abs() < width / 2.0;
            let share = |x: f64, y: f64| {
                let places = (0..60).flat_map(|i| (0..60).map(move |j| [at(i, 60, 2.0), at(j, 60, 2.0)]));
                let of_spot: Vec<[f64; 2]> = places.filter(|[u, v]| u.hypot(*v) < 1.0).collect();
                of_spot.iter().filter(|[u, v]| inside(x + u, y + v)).count() as f64 / of_spot.len() as f64
            };
            let all = (0..60).flat_map(|i| (0..60).map(move |j| [at(i, 60, width), at(j, 60, width)]));
            all.filter(|[x, y]| share(*x, *y) > 0.5).count() as f64 / 3600.0
        };
        let (square, expected) = (made(Texture::new(Planform::Square), 60.0, 30.0), counted(4.0));
        assert!((square - expected).abs() < 0.01, "{square} {expected}");
        assert!(made(Texture::new(Planform::Groove), 75.0, 23.0) > 0.98);
        assert!(made(Texture::new(Planform::Disc), 60.0, 30.0) > 0.98);
        let narrow = [made(triangle(), 80.0, 15.0), made(triangle(), 60.0, 30.0)];
        assert!(narrow[0] > 0.9 && narrow[1] < 0.9, "{narrow:?}");
    }

    #[test]
    fn cavities_that_get_no_line_and_corners_that_are_not_swept_are_warned_of() {
        let laser =
            Laser { spot_um: Some(30.0), hatch_um: Some(7.5), depth_per_burst_um: Some(2.0), ..Laser::default() };
        let pattern = |texture: Texture, width_um: f64| Pattern::new(texture, width_um * 1e-6, 100e-6, 10e-6).unwrap();
        let layout = Layout::new(pattern(triangle(), 60.0), DISC).unwrap();
        let said = laser_warnings(&layout, &laser);
        assert!(said.iter().any(|said| said.starts_with("lines make ") && said.contains("30 um")), "{said:?}");
        // Grooves 160 um wide every 260 um on a plate 900 um long, whose outer grooves are cut to 10 um.
        let plate = Outline::Rectangle { length_m: 900e-6, width_m: 1e-3 };
        let clipped = Layout::clipped(pattern(Texture::new(Planform::Groove), 160.0), plate).unwrap();
        let said = laser_warnings(&clipped, &laser);
        assert!(said.iter().any(|said| said.starts_with("2 of ") && said.contains("get no line")), "{said:?}");
    }
}
