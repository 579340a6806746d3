//! Pressures compared with closed forms, and contact that may open.

use std::f64::consts::PI;

use crate::pattern::Planform;

use super::raised_tests::frictionless;
use super::tests::{largest_imbalance, load};
use super::*;
use crate::springblock::tests::samples::{E_PA, pattern, persson_law, slope};
use crate::springblock::{Lattice, Status, SteadyLoad, SteadyModel, columns};

/// Frictionless contact of a layer of cubes that touches where `touches` is true; pressures by column over the nominal
/// pressure.
fn pressures(columns: [usize; 2], rows: usize, touches: impl Fn(usize, usize) -> bool) -> Vec<f64> {
    let coverage = (0..columns[0] * columns[1])
        .map(|column| if touches(column % columns[0], column / columns[0]) { 0.0 } else { 1.0 })
        .collect();
    let model = SpaceSteadyModel::new(SpaceLattice::of_cubes(columns, rows, coverage, 0.0), 10e-6, E_PA, false);
    let mut pressure = vec![0.0; columns[0] * columns[1]];
    for point in frictionless(&model, 2.6).interface {
        let column = |at_m: f64| (at_m / 10e-6 - 0.5).round() as usize;
        pressure[column(point.y_m) * columns[0] + column(point.x_m)] = point.pressure_pa / 2.6e6;
    }
    pressure
}

/// Collinear slits of width 2a at pitch W in a deep body:
/// p = P sin(pi x / W) / sqrt(sin^2(pi x / W) - sin^2(pi a / W)), x from the centre of a slit.
#[test]
fn pressure_between_slits_of_a_deep_body_converges_to_the_closed_form() {
    let error = |refine: usize| {
        let (pitch, width) = (24 * refine, 8 * refine);
        let w = pitch as f64;
        let pressure = pressures([pitch, 1], 36 * refine, |i, _| i >= width);
        // The middle half of the land is away from the singular edges.
        let middle = (0..pitch).map(|i| (i as f64 + 0.5 - 0.5 * width as f64, pressure[i]));
        let middle = middle.filter(|(x, _)| (x - w / 2.0).abs() < w / 6.0);
        middle.fold(0.0, |worst: f64, (x, p)| {
            let (s, edge) = ((PI * x / w).sin(), (PI * width as f64 / 2.0 / w).sin());
            worst.max((p / (s / (s * s - edge * edge).sqrt()) - 1.0).abs())
        })
    };
    let errors = [1, 2, 4].map(error);
    assert!(errors[0] < 0.03 && errors[1] < 0.6 * errors[0] && errors[2] < 0.6 * errors[1], "{errors:?}");
}

/// Slope of log p against log r (1 - r) along the diagonal of a square of `land` columns in a cell twice as wide, for r
/// from 0.03 to 0.12 of the diagonal; there is a corner at both ends.
fn corner_exponent(land: usize) -> f64 {
    let pitch = 2 * land;
    let pressure = pressures([pitch; 2], pitch, |i, j| i < land && j < land);
    let points: Vec<[f64; 2]> = (0..land)
        .map(|i| ((i as f64 + 0.5) / land as f64, pressure[i * pitch + i]))
        .filter(|(r, _)| (0.03..0.12).contains(r))
        .map(|(r, p)| [(r * (1.0 - r)).ln(), p.ln()])
        .collect();
    slope(&points)
}

/// The pressure of a frictionless punch on a half-space is analogous to the charge on a plate: p ~ r^(nu - 1), nu =
/// 0.2966 at the corner of a square (J. A. Morrison, J. A. Lewis, SIAM J. Appl. Math. 31, 233, 1976).
#[test]
fn pressure_at_the_corner_of_a_square_punch_has_the_exponent_of_a_charged_plate() {
    // Neighbouring punches and the finite block size leave an error of 0.018 at 64 columns per side, 0.006 at 96.
    let [coarse, fine] = [32, 64].map(corner_exponent);
    assert!((fine + 0.7034).abs() < 0.02 && (coarse - fine).abs() > (fine + 0.7034).abs(), "{coarse} {fine}");
}

#[test]
fn a_groove_lifts_off_as_in_the_vertical_plane() {
    let law = persson_law();
    let grooves = pattern(Planform::Groove, 100.0, 40.0, 120.0);
    let in_plane = SteadyModel::new(Lattice::new(columns::cell(&grooves, 10e-6), 20, true), 10e-6, E_PA, true);
    let in_space = SpaceSteadyModel::new(SpaceLattice::cell(&grooves, 10e-6, 20), 10e-6, E_PA, true);
    for (mu, area_law) in [(0.6, None), (0.6, Some(&law)), (0.27, Some(&law)), (0.05, Some(&law))] {
        let dynamic_mu = vec![mu; in_plane.lattice().nx()];
        let plane = in_plane.solve(&SteadyLoad { pressure_pa: 1e6, dynamic_mu: &dynamic_mu, area_law });
        let space = in_space.solve(&SpaceLoad { dynamic_mu: mu, ..load(1.0, area_law) });
        assert_eq!((plane.status, space.status), (Status::Converged, Status::Converged));
        assert_eq!((space.tension_blocks, space.interface.len()), (0, 4));
        for (plane, space) in plane.interface.iter().zip(&space.interface) {
            assert!((plane.pressure_pa - space.pressure_pa).abs() < 1e-3, "{mu} {plane:?} {space:?}");
        }
        let lifted = space.interface.iter().filter(|point| point.pressure_pa == 0.0).count();
        assert_eq!(lifted > 0, mu > 0.1, "{mu}");
    }
}

#[test]
fn posts_that_tip_neither_stick_nor_sink() {
    // Narrow walls between deep cavities: contact that cannot open is under tension at their rear.
    for (width, land, depth, direction) in [(100.0, 40.0, 120.0, [1.0, 0.0]), (103.0, 37.0, 117.0, [0.6, 0.8])] {
        let lattice = SpaceLattice::cell(&pattern(Planform::Square, width, land, depth), 10e-6, 20);
        let tipping = SpaceLoad { dynamic_mu: 0.9, direction, ..load(1.0, None) };
        let pinned = SpaceSteadyModel::new(lattice.clone(), 10e-6, E_PA, false).solve(&tipping);
        assert!(pinned.tension_blocks > 0, "{pinned:?}");
        let model = SpaceSteadyModel::new(lattice, 10e-6, E_PA, true);
        let outcome = model.solve(&tipping);
        assert_eq!((outcome.status, outcome.tension_blocks), (Status::Converged, 0));
        assert!((outcome.mu_dynamic.unwrap() - 0.9).abs() < 1e-9);
        let lifted = outcome.interface.iter().filter(|point| point.pressure_pa == 0.0).count();
        assert!(lifted > 0 && lifted < outcome.interface.len() / 2, "{lifted} of {}", outcome.interface.len());
        assert!(largest_imbalance(&model, &tipping) < 1e-8);
        let displacement = model.displacements(&tipping);
        let [nx, ny] = model.lattice().columns();
        let sinks = (0..nx * ny).filter(|c| model.lattice().presence(c % nx, c / nx, 0) > 0.0);
        assert!(sinks.into_iter().all(|column| displacement[column][2] > -1e-12), "a block below the counterface");
    }
}
