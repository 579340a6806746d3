use std::f64::consts::PI;

use crate::material::AreaLaw;
use crate::pattern::{Pattern, Planform, RimProfile};

use super::super::{CondensedModel, SteadyModel};
use super::*;
use crate::springblock::tests::samples::{self, E_PA, elastic, persson_law, uniform};
use crate::springblock::{Column, columns};

/// Grooves with rims of the given sizes in micrometres.
fn rimmed(sizes: [f64; 3], height_um: f64, rim_um: f64, profile: RimProfile) -> Pattern {
    samples::rimmed(Planform::Groove, sizes, height_um, rim_um, profile)
}

fn lattice(pattern: &Pattern) -> Lattice {
    Lattice::new(columns::cell(pattern, 10e-6), 20, true)
}

/// A face of land with the given heights in micrometres, in blocks of 10 um.
fn face(rows: usize, heights_um: impl Iterator<Item = f64>) -> Lattice {
    Lattice::new(heights_um.map(|height| Column { relief: 0.1 * height, ..Column::land(1.0) }).collect(), rows, true)
}

fn raised(lattice: &Lattice, pressure_mpa: f64, mu: f64, law: Option<&AreaLaw>) -> SurfaceOutcome {
    let dynamic_mu = vec![mu; lattice.nx()];
    let load = SteadyLoad { pressure_pa: pressure_mpa * 1e6, dynamic_mu: &dynamic_mu, area_law: law };
    RaisedModel::new(lattice, 10e-6, elastic()).unwrap().solve(&load, &mut FaceHistory::default())
}

fn all_blocks(lattice: &Lattice, pressure_mpa: f64, mu: f64, law: Option<&AreaLaw>) -> SurfaceOutcome {
    let dynamic_mu = vec![mu; lattice.nx()];
    let load = SteadyLoad { pressure_pa: pressure_mpa * 1e6, dynamic_mu: &dynamic_mu, area_law: law };
    SteadyModel::new(lattice.clone(), 10e-6, E_PA, false).solve(&load)
}

fn assert_same(found: &SurfaceOutcome, expected: &SurfaceOutcome, what: &str) {
    assert_eq!((found.status, expected.status), (Status::Converged, Status::Converged), "{what}");
    let close = |a: f64, b: f64, scale: f64| assert!((a - b).abs() <= 1e-9 * scale, "{what}: {a} {b}");
    close(found.mu_dynamic.unwrap(), expected.mu_dynamic.unwrap(), 1.0);
    close(found.clearance_m.unwrap_or(0.0), expected.clearance_m.unwrap_or(0.0), 1e-3);
    for (a, b) in found.interface.iter().zip(&expected.interface) {
        close(a.pressure_pa, b.pressure_pa, expected.peak_pressure_pa);
    }
}

#[test]
fn rims_are_solved_as_all_blocks_say() {
    let law = persson_law();
    for (number, (sizes, height, rim)) in [
        ([130.0, 370.0, 20.0], 0.1, 10.0),
        ([130.0, 370.0, 5.2], 0.3, 10.0),
        ([133.3, 371.9, 14.0], 1.0, 17.0),
        ([61.0, 52.0, 118.0], 0.5, 20.0),
        ([17.0, 18.0, 13.0], 0.05, 6.0),
        ([100.0, 60.0, 40.0], 0.001, 10.0),
        ([100.0, 60.0, 40.0], 100.0, 10.0),
        // Lands that tilt under strong friction.
        ([100.0, 40.0, 120.0], 0.2, 10.0),
    ]
    .into_iter()
    .enumerate()
    {
        let lattice = lattice(&rimmed(sizes, height, rim, RimProfile::IN_FILES[number % 3]));
        for (pressure, mu) in [(0.1, 0.27), (0.65, 0.27), (2.6, 0.6), (10.0, 0.1)] {
            let [found, expected] = [raised, all_blocks].map(|solve| solve(&lattice, pressure, mu, Some(&law)));
            assert_same(&found, &expected, &format!("{sizes:?} {height} {pressure}"));
        }
    }
}

#[test]
fn rough_faces_are_solved_as_all_blocks_say_and_touch_only_where_they_reach() {
    let mut uniform = uniform(7);
    let law = persson_law();
    let mut off = 0;
    for round in 0..60 {
        let columns = 4 + (60.0 * uniform()) as usize;
        let amplitude = 10.0_f64.powf(-3.0 + 5.0 * uniform());
        // Relief everywhere, below and above the mean.
        let lattice = face(3 + round % 20, (0..columns).map(|_| amplitude * (uniform() - 0.5)));
        let (pressure, mu) = (10.0 * uniform() + 0.05, 0.6 * uniform());
        let [found, expected] = [raised, all_blocks].map(|solve| solve(&lattice, pressure, mu, Some(&law)));
        assert_same(&found, &expected, &format!("round {round}"));
        let load: f64 = found.interface.iter().map(|point| point.pressure_pa).sum::<f64>() / columns as f64;
        assert!((load / (pressure * 1e6) - 1.0).abs() < 1e-9, "round {round}: {load}");
        assert!(found.interface.iter().all(|point| point.pressure_pa >= 0.0));
        off += found.interface.iter().filter(|point| point.pressure_pa == 0.0).count();
    }
    assert!(off > 100, "{off}");
}

#[test]
fn what_is_off_stands_above_the_face_and_what_is_on_at_it() {
    let law = persson_law();
    for (height, pressure) in [(0.3, 0.65), (1.0, 0.65), (1.0, 2.6), (100.0, 2.6)] {
        let lattice = lattice(&rimmed([130.0, 370.0, 20.0], height, 10.0, RimProfile::Flat));
        let dynamic_mu = vec![0.27; lattice.nx()];
        let load = SteadyLoad { pressure_pa: pressure * 1e6, dynamic_mu: &dynamic_mu, area_law: Some(&law) };
        let model = SteadyModel::new(lattice.clone(), 10e-6, E_PA, false);
        let heights = model.displacements(&load);
        let outcome = raised(&lattice, pressure, 0.27, Some(&law));
        for point in &outcome.interface {
            let column = (point.x_m / 10e-6 - 0.5).round() as usize;
            let gap = heights[column][1] - lattice.columns()[column].relief;
            // Complementarity to 1e-9 of P; gaps relative to the compression of one block under P.
            let yields = pressure * 1e6 / (0.75 * E_PA);
            assert!(gap >= -1e-9 * yields && (gap * point.pressure_pa).abs() < 1e-9 * yields * pressure * 1e6, "{gap}");
        }
    }
}

#[test]
fn a_face_without_heights_or_of_one_height_is_the_plain_one() {
    let law = persson_law();
    for sizes in [[130.0, 370.0, 20.0], [133.3, 371.9, 14.0], [61.0, 52.0, 48.0]] {
        let plain = lattice(&rimmed(sizes, 0.0, 10.0, RimProfile::Flat));
        assert!(!plain.is_raised());
        let mut columns = plain.columns().to_vec();
        columns.iter_mut().for_each(|column| column.relief = 0.37);
        let even = Lattice::new(columns, 20, true);
        let dynamic_mu = vec![0.27; plain.nx()];
        let load = SteadyLoad { pressure_pa: 1e6, dynamic_mu: &dynamic_mu, area_law: Some(&law) };
        let expected = CondensedModel::new(&plain, 10e-6, E_PA, true).unwrap().solve(&load).unwrap();
        for lattice in [&plain, &even] {
            let found = raised(lattice, 1.0, 0.27, Some(&law));
            assert!((found.mu_dynamic.unwrap() - expected.mu_dynamic.unwrap()).abs() < 1e-12, "{sizes:?}");
        }
    }
}

#[test]
fn friction_is_continuous_in_the_height_and_the_width_of_a_rim() {
    let law = persson_law();
    let mu = |height: f64, rim: f64| {
        raised(&lattice(&rimmed([130.0, 370.0, 20.0], height, rim, RimProfile::Round)), 0.65, 0.27, Some(&law))
            .mu_dynamic
            .unwrap()
    };
    let none = mu(0.0, 10.0);
    assert!((mu(1e-3, 10.0) - none).abs() < 1e-3 * none && (mu(1e-6, 10.0) - none).abs() < 1e-6 * none);
    let largest_step = |values: Vec<f64>| values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
    // Steps of 0.01 um in height and 0.5 um in width.
    let (by_height, by_width) = (
        largest_step((0..100).map(|n| mu(0.01 * f64::from(n), 12.0)).collect()),
        largest_step((2..80).map(|n| mu(0.3, 0.5 * f64::from(n))).collect()),
    );
    assert!(by_height < 0.012 * none && by_width < 0.03 * none, "{by_height} {by_width} {none}");
}

/// Westergaard (1939): a half-space of plane-strain modulus E' pressed by P on waves z = h cos(2 pi x / W) is in
/// contact over 2a of each period, P = (pi E' h / W) sin^2(pi a / W), with p = 2 P cos(s) sqrt(sin^2(pi a / W) - sin^2
/// s) / sin^2(pi a / W), s = pi x / W. In plane stress E' = E.
#[test]
fn waves_in_partial_contact_approach_the_closed_form_as_blocks_shrink() {
    let error = |columns: usize, share: f64| {
        let wave = columns as f64;
        let height = 0.01;
        let lattice = face(columns, (0..columns).map(|i| 10.0 * height * (2.0 * PI * (i as f64 + 0.5) / wave).cos()));
        let full = PI * E_PA * height / wave;
        let outcome = raised(&lattice, share * full * 1e-6, 0.0, None);
        let edge = share.sqrt();
        let rms = outcome.interface.iter().enumerate().map(|(i, point)| {
            let s = (PI * (i as f64 + 0.5) / wave).sin();
            let cosine = (1.0 - s * s).sqrt();
            let expected = 2.0 * share * full * cosine * (edge * edge - s * s).max(0.0).sqrt() / (edge * edge);
            (point.pressure_pa - expected).powi(2)
        });
        (rms.sum::<f64>() / wave).sqrt() / (share * full)
    };
    // The edge of contact lies anywhere between two blocks, hence a mean over contact shares around each value.
    for share in [0.1, 0.5, 0.9] {
        let mean =
            |columns: usize| (-2..=2).map(|n| error(columns, share * (1.0 + 0.04 * f64::from(n)))).sum::<f64>() / 5.0;
        let errors = [16, 32, 64, 128].map(mean);
        let falls = errors.windows(2).all(|pair| pair[1] < pair[0]);
        assert!(falls && errors[3] < 0.3 * errors[0] && errors[3] < 0.03, "{share}: {errors:?}");
    }
}

/// In full contact heights add p_q = (E |q| / 2) h_q of a half-space to the mean pressure.
#[test]
fn waves_in_full_contact_superpose() {
    let pressures = |columns: usize, a: f64, b: f64| -> Vec<f64> {
        let height = |i: usize| {
            let x = 2.0 * PI * (i as f64 + 0.5) / columns as f64;
            a * x.cos() + b * (3.0 * x + 0.4).sin()
        };
        let outcome = raised(&face(columns, (0..columns).map(height)), 5.0, 0.0, None);
        outcome.interface.iter().map(|point| point.pressure_pa - 5e6).collect()
    };
    let error = |columns: usize| {
        let (one, other, both) =
            (pressures(columns, 0.02, 0.0), pressures(columns, 0.0, 0.01), pressures(columns, 0.02, 0.01));
        let unit_pa = E_PA * PI / (10.0 * columns as f64);
        let departures = both.iter().enumerate().map(|(i, both)| {
            assert!((one[i] + other[i] - both).abs() < 1e-9 * 5e6);
            let x = 2.0 * PI * (i as f64 + 0.5) / columns as f64;
            (both / unit_pa - (0.02 * x.cos() + 3.0 * 0.01 * (3.0 * x + 0.4).sin())).abs()
        });
        departures.fold(0.0, f64::max) / 0.05
    };
    let errors = [24, 48, 96].map(error);
    assert!(errors[1] < 0.75 * errors[0] && errors[2] < 0.6 * errors[1] && errors[2] < 0.015, "{errors:?}");
}

/// Collinear frictionless punches of width a at pitch W on a deep body: p = P cos(s) / sqrt(sin^2(pi a / 2 W) - sin^2
/// s) under them, s = pi x / W from the centre of a punch.
#[test]
fn flat_punches_press_as_the_closed_form_says() {
    let error = |refine: usize| {
        let (pitch, width) = (24 * refine, 16 * refine);
        let heights = (0..pitch).map(|i| if i < width { 100.0 } else { 0.0 });
        let outcome = raised(&face(36 * refine, heights), 2.6, 0.0, None);
        let w = pitch as f64;
        let middle = outcome
            .interface
            .iter()
            .enumerate()
            .map(|(i, point)| (i as f64 + 0.5 - 0.5 * width as f64, point.pressure_pa / 2.6e6));
        let edge = (PI * width as f64 / 2.0 / w).sin();
        middle.filter(|(x, _)| x.abs() < 0.25 * width as f64).fold(0.0, |worst: f64, (x, p)| {
            let s = (PI * x / w).sin();
            worst.max((p * (edge * edge - s * s).sqrt() / (1.0 - s * s).sqrt() - 1.0).abs())
        })
    };
    let errors = [1, 2, 4].map(error);
    assert!(errors[0] < 0.03 && errors[1] < 0.6 * errors[0] && errors[2] < 0.6 * errors[1], "{errors:?}");
}

#[test]
fn a_face_without_load_bears_none_and_says_so() {
    let outcome = raised(&lattice(&rimmed([130.0, 370.0, 20.0], 0.3, 10.0, RimProfile::Ramp)), 0.0, 0.27, None);
    assert_eq!((outcome.status, outcome.mu_dynamic), (Status::NoLoad, None));
}

/// Ratios from an independent dense prototype in plane stress, E* h'rms = 4 MPa, flat rims 10 um wide. Its block size
/// leaves an error of some thousandths, more for high rims.
#[test]
fn the_prototype_s_ratios_are_found() {
    let pressures_pa: Vec<f64> = (1..=400).map(|n| 0.05e6 * f64::from(n)).collect();
    let area: Vec<f64> = pressures_pa.iter().map(|p| libm::erf(2.0_f64.sqrt() * p / 4e6)).collect();
    let law = AreaLaw::from_area_curve(&pressures_pa, &area, 0.05e6).unwrap();
    for (height, expected, exact) in [
        (0.1, [0.879, 0.853, 0.829, 0.803], 0.003),
        (0.3, [0.696, 0.752, 0.767, 0.765], 0.005),
        (1.0, [0.223, 0.473, 0.581, 0.637], 0.01),
    ] {
        let pattern =
            rimmed([130.0, 370.0, 5.2], height / crate::springblock::rims::PLANE_STRAIN, 10.0, RimProfile::Flat);
        let lattice = Lattice::new(columns::cell(&pattern, 2.5e-6), 80, true);
        let model = RaisedModel::new(&lattice, 2.5e-6, elastic()).unwrap();
        let dynamic_mu = vec![0.27; lattice.nx()];
        for (pressure_mpa, expected) in [0.65, 1.3, 1.95, 2.6].into_iter().zip(expected) {
            let load = SteadyLoad { pressure_pa: pressure_mpa * 1e6, dynamic_mu: &dynamic_mu, area_law: Some(&law) };
            let outcome = model.solve(&load, &mut FaceHistory::default());
            let ratio = outcome.mu_dynamic.unwrap() / (0.27 * law.factor(pressure_mpa * 1e6));
            assert!((ratio - expected).abs() < exact, "{height} {pressure_mpa}: {ratio} {expected}");
        }
    }
}

#[test]
fn what_yields_bears_the_yield_pressure_and_stays_flat() {
    let law = persson_law();
    let lattice = lattice(&rimmed([130.0, 370.0, 20.0], 1.0, 20.0, RimProfile::Flat));
    let dynamic_mu = vec![0.27; lattice.nx()];
    let load = |pressure_mpa: f64| SteadyLoad {
        pressure_pa: pressure_mpa * 1e6,
        dynamic_mu: &dynamic_mu,
        area_law: Some(&law),
    };
    let model = |yield_mpa: Option<f64>| {
        let solid = elastic().with_yield_pressure_pa(yield_mpa.map(|mpa| mpa * 1e6)).unwrap();
        RaisedModel::new(&lattice, 10e-6, solid).unwrap()
    };
    let elastic_peak = model(None).solve(&load(2.6), &mut FaceHistory::default()).peak_pressure_pa;
    assert!(elastic_peak > 15e6, "{elastic_peak}");
    // A yield pressure that is never reached changes no bit.
    let same = [Some(1e3), None].map(|yields| model(yields).solve(&load(2.6), &mut FaceHistory::default()));
    assert_eq!(same[0], same[1]);

    let plastic = model(Some(9.0));
    let mut history = FaceHistory::default();
    let light = plastic.solve(&load(0.65), &mut history);
    let heavy = plastic.solve(&load(2.6), &mut history);
    let again = plastic.solve(&load(0.65), &mut history);
    for outcome in [&light, &heavy, &again] {
        assert_eq!(outcome.status, Status::Converged);
        assert!(outcome.peak_pressure_pa <= 9e6 * (1.0 + 1e-9), "{}", outcome.peak_pressure_pa);
        let mean = outcome.interface.iter().map(|p| p.pressure_pa).sum::<f64>() / 50.0;
        assert!((mean / if std::ptr::eq(outcome, &heavy) { 2.6e6 } else { 0.65e6 } - 1.0).abs() < 1e-9);
    }
    assert!(heavy.interface.iter().any(|point| (point.pressure_pa / 9e6 - 1.0).abs() < 1e-9));
    // The heavy load has flattened the rims: under the light load they carry less than before, and friction is higher.
    let mu = |outcome: &SurfaceOutcome| outcome.mu_dynamic.unwrap();
    assert!(mu(&again) > mu(&light) + 0.005, "{} {}", mu(&again), mu(&light));
    // Under a second heavy load nothing yields.
    let repeated = plastic.solve(&load(2.6), &mut history);
    assert!((mu(&repeated) - mu(&heavy)).abs() < 1e-9, "{} {}", mu(&repeated), mu(&heavy));
}
