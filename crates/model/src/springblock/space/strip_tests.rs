//! Strips with two ends in space.

use super::tests::load;
use super::*;
use crate::springblock::tests::samples::{E_PA, groove, persson_law};
use crate::springblock::{Lattice, Status, SteadyLoad, SteadyModel, columns};

/// A strip of grooves one column wide equals the strip in the vertical plane: plane strain at nu = 1/4 is plane stress
/// at 1/3.
#[test]
fn a_strip_of_grooves_is_that_of_the_vertical_plane() {
    let law = persson_law();
    for (rows, length, gap) in [(6, 47, 1), (10, 60, 4)] {
        let pattern = groove(60.0, 90.0, 20.0);
        let plane = columns::sample(&pattern, 10e-6, length);
        let cell = SpaceLattice::cell(&pattern, 10e-6, rows).transposed();
        let strip = cell.strip_along_y(length, gap, |n| {
            (plane[n].coverage > 0.0).then(|| (0..15).find(|j| cell.contact_share(0, *j) == 0.0).unwrap())
        });
        let space = SpaceSteadyModel::new(strip, 10e-6, E_PA, false);
        let plane = SteadyModel::new(Lattice::new(plane, rows, false), 10e-6, E_PA, false);
        for pressure_mpa in [0.65, 2.6] {
            let found = space.solve(&SpaceLoad { direction: [0.0, 1.0], ..load(pressure_mpa, Some(&law)) });
            let dynamic_mu = vec![0.27; length];
            let load = SteadyLoad { pressure_pa: pressure_mpa * 1e6, dynamic_mu: &dynamic_mu, area_law: Some(&law) };
            let expected = plane.solve(&load);
            assert_eq!((found.status, expected.status), (Status::Converged, Status::Converged));
            assert!((found.mu_dynamic.unwrap() - expected.mu_dynamic.unwrap()).abs() < 1e-9);
            for (own, expected) in found.interface.iter().zip(&expected.interface) {
                assert!((own.y_m - expected.x_m).abs() < 1e-9);
                assert!(
                    (own.pressure_pa - expected.pressure_pa).abs() < 1e-7 * load.pressure_pa,
                    "{own:?} {expected:?}"
                );
            }
        }
    }
}
