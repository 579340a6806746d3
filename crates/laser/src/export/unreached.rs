//! Areas of cavities that the spot does not reach.
//!
//! The spot stays inside the walls of cavities and the border of the specimen. A cavity that the border cuts to less
//! than the spot has no line; in a corner, the area beyond the edge of the spot is not reached. With the diameter s of
//! the spot:
//!
//! ```text
//! swept share = area(points within s/2 of a line) / area(cavity)
//! ```

use slipgrid_model::pattern::geometry::point_to_segment;

use crate::export::{Cavity, Layout, Line, decimal};

/// Number of sample points along each extent of a cavity.
const POINTS: u32 = 60;
/// Minimum swept fraction of a cavity without a warning. A spot a third as wide as the cavity sweeps 97 % of a square
/// and all of a disc.
const MIN_SWEPT: f64 = 0.9;

/// Warnings about cavity areas of `layout` that a spot of radius `half_spot_m` does not reach. `bare` is the number and
/// total area, in square metres, of cavities without a hatch line; `one`, with its hatch `lines`, represents the other
/// cavities.
pub(crate) fn warnings(
    layout: &Layout,
    half_spot_m: f64,
    bare: (u32, f64),
    one: &Cavity,
    lines: &[Line],
) -> Vec<String> {
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
    let swept = swept_share(one, lines, half_spot_m);
    if swept < MIN_SWEPT {
        warnings.push(format!(
            "lines sweep {} of the area of a cavity, whose corners the spot, {spot} um, does not get into; friction was computed with all of \
             it: a smaller spot or wider cavities come nearer",
            percent(swept)
        ));
    }
    warnings
}

/// Fraction of `cavity` within `half_spot_m` of one of `lines`.
fn swept_share(cavity: &Cavity, lines: &[Line], half_spot_m: f64) -> f64 {
    let [cosine, sine] = cavity.orientation;
    let place = |k: u32| (f64::from(k) + 0.5) / f64::from(POINTS) - 0.5;
    let at = |(i, j): (u32, u32)| {
        let (along_m, across_m) = (place(i) * cavity.width_m, place(j) * cavity.length_m);
        [cavity.centre_x_m + along_m * cosine - across_m * sine, cavity.centre_y_m + along_m * sine + across_m * cosine]
    };
    let all = (0..POINTS).flat_map(|i| (0..POINTS).map(move |j| (i, j))).map(at);
    let inside: Vec<[f64; 2]> = all.filter(|at_m| cavity.wall_distance_m(*at_m) >= 0.0).collect();
    let is_swept =
        |at_m: &&[f64; 2]| lines.iter().any(|[from, to]| point_to_segment(**at_m, *from, *to) <= half_spot_m);
    inside.iter().filter(is_swept).count() as f64 / inside.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::{Laser, Marking, Outline, laser_warnings};
    use slipgrid_model::pattern::{Pattern, Planform, Polygon, Texture};

    const DISC: Outline = Outline::Disc { diameter_m: 2e-3 };

    fn triangle() -> Texture {
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.5, 0.75_f64.sqrt()]];
        Texture::new(Planform::Polygon).with_outline(Polygon::new(&corners).unwrap()).unwrap()
    }

    fn swept(texture: Texture, width_um: f64, spot_um: f64) -> f64 {
        let pattern = Pattern::new(texture, width_um * 1e-6, 100e-6, 10e-6).unwrap();
        let cavity = Layout::new(pattern, DISC).unwrap().iter().next().unwrap();
        let laser = Laser { spot_um: Some(spot_um), ..Laser::default() };
        let marking = Marking::new(&laser).unwrap();
        swept_share(&cavity, &marking.lines(&cavity), marking.spot_compensation_m())
    }

    #[test]
    fn a_spot_sweeps_what_its_edge_reaches() {
        // Two lines side by side in a square miss its corners, and as much between their ends: 1 - 2 (4 - pi) (s/2w)^2.
        let square = swept(Texture::new(Planform::Square), 60.0, 30.0);
        assert!((square - (1.0 - 2.0 * (4.0 - std::f64::consts::PI) * 0.0625)).abs() < 6e-3, "{square}");
        assert!(swept(Texture::new(Planform::Groove), 75.0, 23.0) > 0.98);
        // For an equilateral triangle at most the part swept by a disc: 1 - (3 sqrt(3) - pi) r^2 / A, with the spot's
        // radius r.
        let (found, area_um2) = (swept(triangle(), 80.0, 15.0), 0.25 * 3_f64.sqrt() * 6400.0);
        let closed = 1.0 - (3.0 * 3_f64.sqrt() - std::f64::consts::PI) * 56.25 / area_um2;
        assert!(found < closed && found > closed - 0.1, "{found} {closed}");
    }

    #[test]
    fn cavities_that_get_no_line_and_corners_that_are_not_swept_are_warned_of() {
        let laser = Laser { spot_um: Some(30.0), depth_per_burst_um: Some(2.0), ..Laser::default() };
        let pattern = |texture: Texture, width_um: f64| Pattern::new(texture, width_um * 1e-6, 100e-6, 10e-6).unwrap();
        let layout = Layout::new(pattern(triangle(), 60.0), DISC).unwrap();
        let said = laser_warnings(&layout, &laser);
        assert!(said.iter().any(|said| said.starts_with("lines sweep ") && said.contains("30 um")), "{said:?}");
        // Grooves 160 um wide every 260 um on a plate 920 um long, whose outer grooves are cut to 20 um.
        let plate = Outline::Rectangle { length_m: 920e-6, width_m: 1e-3 };
        let clipped = Layout::clipped(pattern(Texture::new(Planform::Groove), 160.0), plate).unwrap();
        let said = laser_warnings(&clipped, &laser);
        assert!(said.iter().any(|said| said.starts_with("2 of ") && said.contains("get no line")), "{said:?}");
    }
}
