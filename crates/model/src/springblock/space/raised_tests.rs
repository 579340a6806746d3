//! Faces with height variations in space, compared with the plane, closed forms, and a slow reference solver.

use std::f64::consts::TAU;

use crate::pattern::{Pattern, Planform, RimProfile};

use super::tests::{largest_imbalance, load};
use super::*;
use crate::springblock::steady::{FaceHistory, RaisedModel};
use crate::springblock::tests::samples::{self, E_PA, elastic, persson_law};
use crate::springblock::{Lattice, Status, SteadyLoad, SurfaceOutcome, Unwatched, columns};

fn rimmed(planform: Planform, sizes: [f64; 3], height_um: f64, rim_um: f64) -> Pattern {
    samples::rimmed(planform, sizes, height_um, rim_um, RimProfile::Flat)
}

fn model(pattern: &Pattern) -> SpaceSteadyModel {
    SpaceSteadyModel::new(SpaceLattice::cell(pattern, 10e-6, 20), 10e-6, E_PA, false)
}

/// A flat layer of cubes whose face has the given heights in micrometres.
fn face(columns: [usize; 2], rows: usize, height_um: impl Fn(usize, usize) -> f64) -> SpaceSteadyModel {
    let heights = (0..columns[0] * columns[1]).map(|c| 0.1 * height_um(c % columns[0], c / columns[0]));
    let lattice = SpaceLattice::flat(columns, rows).with_relief(heights.collect());
    SpaceSteadyModel::new(lattice, 10e-6, E_PA, false)
}

pub(super) fn frictionless(model: &SpaceSteadyModel, pressure_mpa: f64) -> SurfaceOutcome {
    let outcome = model.solve(&SpaceLoad { dynamic_mu: 0.0, ..load(pressure_mpa, None) });
    assert_eq!(outcome.status, Status::NoFriction, "{:?} {}", outcome.residual, outcome.iterations);
    outcome
}

/// Columns of the plane have the heights of plane strain at nu = 1/4.
#[test]
fn grooves_with_rims_elastic_or_yielding_are_those_of_the_vertical_plane() {
    let law = persson_law();
    let loads = [0.65, 2.6, 0.65].map(|pressure_mpa| load(pressure_mpa, Some(&law)));
    for (sizes, height, rim, yields_pa) in [
        ([130.0, 370.0, 20.0], 0.1, 15.0, None),
        ([133.3, 372.9, 17.0], 0.5, 15.0, None),
        ([58.0, 47.1, 4.0], 1.0, 15.0, None),
        ([100.0, 100.0, 30.0], 50.0, 15.0, None),
        ([133.3, 372.9, 17.0], 1.0, 25.0, Some(9e6)),
    ] {
        let pattern = rimmed(Planform::Groove, sizes, height, rim);
        let plane = Lattice::new(columns::cell(&pattern, 10e-6), 20, true);
        let dynamic_mu = vec![0.27; plane.nx()];
        let solid = elastic().with_yield_pressure_pa(yields_pa).unwrap();
        let plane = RaisedModel::new(&plane, 10e-6, solid).unwrap();
        let in_space = model(&pattern).yielding_at(yields_pa).solve_all(&loads, &Unwatched);
        let mut history = FaceHistory::default();
        for (load, in_space) in loads.iter().zip(&in_space) {
            let SpaceLoad { pressure_pa, area_law, .. } = *load;
            let in_plane = plane.solve(&SteadyLoad { pressure_pa, dynamic_mu: &dynamic_mu, area_law }, &mut history);
            let what = format!("{sizes:?} {pressure_pa}");
            assert_eq!((in_plane.status, in_space.status), (Status::Converged, Status::Converged), "{what}");
            let (tolerance, peak_pa) = yields_pa.map_or((1e-9, f64::INFINITY), |yields_pa| (1e-8, yields_pa));
            assert!((in_plane.mu_dynamic.unwrap() - in_space.mu_dynamic.unwrap()).abs() < tolerance, "{what}");
            assert!(in_space.peak_pressure_pa <= peak_pa * (1.0 + 1e-6));
            for (a, b) in in_plane.interface.iter().zip(&in_space.interface).filter(|_| yields_pa.is_none()) {
                assert!((a.pressure_pa - b.pressure_pa).abs() < 1e-7 * in_plane.peak_pressure_pa, "{what}");
            }
        }
        let [first, .., last] = [0, 1, 2].map(|number: usize| in_space[number].mu_dynamic.unwrap());
        assert!(yields_pa.is_none() || last > first + 0.005, "{first} {last}");
    }
}

#[test]
fn squares_with_rims_touch_only_where_they_reach_and_balance_every_block() {
    let law = persson_law();
    for (sizes, height, pressure) in
        [([130.0, 170.0, 20.0], 0.1, 0.65), ([130.0, 170.0, 20.0], 1.0, 0.65), ([73.0, 91.0, 17.0], 0.5, 2.6)]
    {
        let pattern = rimmed(Planform::Square, sizes, height, 15.0);
        let model = model(&pattern);
        let load = load(pressure, Some(&law));
        let outcome = model.solve(&load);
        assert_eq!((outcome.status, outcome.tension_blocks), (Status::Converged, 0), "{sizes:?}");
        assert!(largest_imbalance(&model, &load) < 1e-7, "{sizes:?} {}", largest_imbalance(&model, &load));
        let displacement = model.displacements(&load);
        let (lattice, [a, b]) = (model.lattice(), model.lattice().spacing());
        let yields = load.pressure_pa / (0.4 * E_PA);
        let mut off = 0;
        for point in &outcome.interface {
            let column = |at_m: f64, spacing: f64| (at_m / (spacing * 10e-6) - 0.5).round() as usize;
            let [i, j] = [column(point.x_m, a), column(point.y_m, b)];
            // A block that touches in part is connected by a spring: its height differs from that of the face.
            if lattice.contact_share(i, j) == 1.0 {
                let gap = displacement[j * lattice.columns()[0] + i][2] - lattice.relief(i, j);
                assert!(gap >= -1e-9 * yields, "{sizes:?} {gap}");
                assert!(gap * point.pressure_pa < 1e-9 * yields * load.pressure_pa, "{sizes:?} {gap}");
            }
            off += usize::from(point.pressure_pa == 0.0);
        }
        assert!((off > 0) == (height > 0.2), "{sizes:?} {height}: {off}");
    }
}

#[test]
fn an_even_face_at_any_height_is_the_plain_one() {
    let law = persson_law();
    for sizes in [[130.0, 170.0, 20.0], [73.0, 91.0, 17.0]] {
        let pattern = rimmed(Planform::Square, sizes, 0.0, 15.0);
        let plain = model(&pattern);
        let [nx, ny] = plain.lattice().columns();
        let even = plain.lattice().clone().with_relief(vec![0.3; nx * ny]);
        let even = SpaceSteadyModel::new(even, 10e-6, E_PA, false);
        let [a, b] = [&plain, &even].map(|model| model.solve(&load(1.0, Some(&law))));
        assert!(!plain.lattice().is_raised() && even.lattice().is_raised());
        assert!((a.mu_dynamic.unwrap() - b.mu_dynamic.unwrap()).abs() < 1e-9, "{sizes:?}");
    }
}

/// In full contact heights add p_q = E / (1 - nu^2) |q| / 2 h_q to the pressure on a half-space.
#[test]
fn waves_along_and_across_superpose_in_full_contact() {
    let error = |columns: usize| {
        let wave = columns as f64;
        let height = |i: usize, j: usize| {
            let [x, y] = [i, j].map(|at| TAU * (at as f64 + 0.5) / wave);
            0.01 * x.cos() * y.cos() + 0.004 * (2.0 * y).sin()
        };
        let outcome = frictionless(&face([columns; 2], columns, height), 5.0);
        let unit_pa = E_PA * 16.0 / 15.0 / 2.0 * TAU / (10.0 * wave);
        let departures = outcome.interface.iter().map(|point| {
            let [x, y] = [point.x_m, point.y_m].map(|at_m| TAU * at_m / (wave * 10e-6));
            let closed = 2.0_f64.sqrt() * 0.01 * x.cos() * y.cos() + 2.0 * 0.004 * (2.0 * y).sin();
            ((point.pressure_pa - 5e6) / unit_pa - closed).abs()
        });
        departures.fold(0.0, f64::max) / 0.018
    };
    let errors = [12, 24, 48].map(error);
    assert!(errors[1] < errors[0] && errors[2] < 0.6 * errors[1] && errors[2] < 0.03, "{errors:?}");
}

/// Reference: the dense stiffness of the face from unit heights in full contact, and a projected solve for the
/// contacts.
#[test]
fn rough_faces_touch_as_a_dense_solver_says() {
    let (nx, ny) = (9, 8);
    let heights: Vec<f64> = (0..nx * ny).map(|c| ((c * c * 7 + 3 * c) as f64).sin()).collect();
    let pressure = |height: &dyn Fn(usize) -> f64, pressure_mpa: f64| -> Vec<f64> {
        let outcome = frictionless(&face([nx, ny], 6, |i, j| height(j * nx + i)), pressure_mpa);
        outcome.interface.iter().map(|point| point.pressure_pa).collect()
    };
    // By translation one column of K gives all: a height of 1 um under 1000 MPa, where everything touches.
    let unit = pressure(&|c| f64::from(u8::from(c == 0)), 1000.0);
    let stiffness = |a: usize, b: usize| {
        let (i, j) = ((a % nx + nx - b % nx) % nx, (a / nx + ny - b / nx) % ny);
        unit[j * nx + i] - 1000e6
    };
    for (amplitude, pressure_mpa) in [(0.05, 2.0), (0.5, 2.0), (5.0, 2.0)] {
        let r: Vec<f64> = heights.iter().map(|h| amplitude * h).collect();
        // p = P + K z, p >= 0, z >= r, p (z - r) = 0: projected Gauss-Seidel on z.
        let (mut z, n) = (r.clone(), nx * ny);
        let row = |z: &[f64], a: usize| (0..n).map(|b| stiffness(a, b) * z[b]).sum::<f64>() + pressure_mpa * 1e6;
        for _ in 0..20_000 {
            for a in 0..n {
                z[a] = (z[a] - row(&z, a) / stiffness(a, a)).max(r[a]);
            }
        }
        let expected: Vec<f64> = (0..n).map(|a| row(&z, a)).collect();
        let found = pressure(&|c| r[c], pressure_mpa);
        let most = expected.iter().copied().fold(0.0, f64::max);
        for (a, b) in found.iter().zip(&expected) {
            assert!((a - b).abs() < 1e-4 * most, "{amplitude}: {a} {b}");
        }
    }
}
