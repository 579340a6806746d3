use super::super::SteadyModel;
use super::*;
use crate::material::AreaLaw;
use crate::springblock::columns;
use crate::springblock::tests::samples::{E_PA, groove, persson_law, uniform};

fn lattice(width_um: f64, spacing_um: f64, depth_um: f64, rows: usize) -> Lattice {
    Lattice::new(columns::cell(&groove(width_um, spacing_um, depth_um), 10e-6), rows, true)
}

/// Largest difference of the normal forces from both methods under uneven friction, and relative difference of the
/// stiffness without friction.
fn differences(lattice: &Lattice) -> Option<[f64; 2]> {
    let plain = super::super::System::new(lattice, &[]);
    let model = CondensedModel::new(lattice, 10e-6, E_PA, false)?;
    let stiffer = model.stiffness_per_length() * plain.load() / plain.bulk_stiffness();
    let condensed = model.response();
    let m = condensed.contacts.len();
    assert_eq!(m, plain.contacts().len());
    let friction: Vec<f64> = (0..m).map(|c| 0.3 + 0.1 * (c as f64).sin()).collect();
    let (mut displacement, mut expected, mut found) = (vec![0.0; plain.order()], vec![0.0; m], vec![0.0; m]);
    plain.respond(&friction, &mut displacement, &mut expected);
    condensed.respond(&friction, &mut [], &mut found);
    let most = expected.iter().zip(&found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    Some([most, (stiffer - 1.0).abs()])
}

#[test]
fn normal_forces_and_stiffness_are_those_of_all_blocks_of_thin_and_thick_layers() {
    for (width, spacing, depth, rows) in [
        (130.0, 370.0, 20.0, 20),
        (130.0, 370.0, 14.0, 20),
        (130.0, 370.0, 4.0, 20),
        (133.0, 367.0, 20.0, 20),
        (133.3, 371.9, 14.0, 20),
        (133.3, 371.9, 3.0, 20),
        (60.0, 50.0, 120.0, 20),
        (61.0, 52.0, 118.0, 20),
        (20.0, 10.0, 10.0, 20),
        (30.0, 10.0, 2.0, 20),
        (10.0, 10.0, 5.0, 20),
        (17.0, 18.0, 13.0, 20),
        (100.0, 140.0, 20.0, 90),
        (133.3, 171.9, 14.0, 61),
        (60.0, 50.0, 120.0, 80),
        (20.0, 10.0, 10.0, 150),
        (17.0, 18.0, 13.0, 100),
    ] {
        let found = differences(&lattice(width, spacing, depth, rows)).unwrap();
        assert!(found.iter().all(|own| *own < 1e-9), "{width} {spacing} {depth} {rows}: {found:?}");
    }
}

/// Maps `uniform` to a number between `low` and `high`, uniform in its logarithm.
fn between(low: f64, high: f64, uniform: f64) -> f64 {
    low * (high / low).powf(uniform)
}

/// Outcomes from both methods; `None` if the condensed model refuses.
fn both(lattice: &Lattice, load: &SteadyLoad, e_pa: f64, liftoff: bool) -> Option<[SurfaceOutcome; 2]> {
    let condensed = CondensedModel::new(lattice, 10e-6, e_pa, liftoff)?.solve(load)?;
    Some([condensed, SteadyModel::new(lattice.clone(), 10e-6, e_pa, liftoff).solve(load)])
}

fn assert_same([found, expected]: &[SurfaceOutcome; 2], what: &str) {
    let statuses = |outcome: &SurfaceOutcome| {
        (outcome.status, outcome.tension_blocks, outcome.cavity_closed, outcome.area_law_extrapolated)
    };
    assert_eq!(statuses(found), statuses(expected), "{what}");
    let close = |a: f64, b: f64, scale: f64| assert!((a - b).abs() <= 1e-9 * scale, "{what}: {a} {b}");
    close(found.mu_dynamic.unwrap(), expected.mu_dynamic.unwrap(), 1.0);
    close(found.peak_pressure_pa, expected.peak_pressure_pa, expected.peak_pressure_pa);
    // The tolerance is relative to the layer, because displacements of that order cancel.
    close(found.clearance_m.unwrap_or(0.0), expected.clearance_m.unwrap_or(0.0), 1e-3);
    assert_eq!(found.clearance_m.is_some(), expected.clearance_m.is_some(), "{what}");
    assert_eq!(found.interface.len(), expected.interface.len());
    for (a, b) in found.interface.iter().zip(&expected.interface) {
        assert_eq!(a.x_m, b.x_m);
        close(a.pressure_pa, b.pressure_pa, expected.peak_pressure_pa);
        close(a.friction_pa, b.friction_pa, expected.peak_pressure_pa);
    }
}

#[test]
fn random_designs_under_random_loads_slide_as_all_blocks_say() {
    let law = persson_law();
    let mut uniform = uniform(1);
    let mut left = 0;
    for number in 0..200 {
        let width = between(10.0, 500.0, uniform());
        let spacing = between(15.0, 900.0, uniform());
        let depth = between(0.5, 60.0, uniform());
        // Every third design has whole blocks.
        let whole = |value: f64| if number % 3 == 0 { (value / 10.0).round().max(1.0) * 10.0 } else { value };
        let lattice = lattice(whole(width), whole(spacing), whole(depth), 20);
        let dynamic_mu = vec![between(0.05, 0.8, uniform()); lattice.nx()];
        let pressure_pa = between(0.1e6, 8e6, uniform());
        let area_law = (number % 4 != 0).then_some(&law);
        let load = SteadyLoad { pressure_pa, dynamic_mu: &dynamic_mu, area_law };
        // Soft materials close their cavities.
        let e_pa = if number % 5 == 0 { 5e6 } else { E_PA };
        match both(&lattice, &load, e_pa, number % 2 == 0) {
            Some(outcomes) => assert_same(&outcomes, &format!("{width} {spacing} {depth}")),
            None => left += 1,
        }
    }
    // Refused are lands that lift off and cavities that leave little land.
    assert!(left < 30, "{left}");
}

#[test]
fn laws_that_fall_steeply_and_large_pitches_too() {
    let law = AreaLaw::new(vec![1.0e6, 1.01e6, 2.5e6], vec![1.0, 0.5, 0.1]).unwrap();
    for (width, spacing, depth) in [(60.0, 60.0, 50.0), (403.7, 996.0, 48.0), (41.0, 57.3, 1.2), (300.4, 91.0, 17.7)] {
        let lattice = lattice(width, spacing, depth, 20);
        let dynamic_mu = vec![0.4; lattice.nx()];
        for pressure_pa in [0.8e6, 1.5e6, 4e6] {
            let load = SteadyLoad { pressure_pa, dynamic_mu: &dynamic_mu, area_law: Some(&law) };
            assert_same(&both(&lattice, &load, E_PA, false).unwrap(), &format!("{width} {pressure_pa}"));
        }
    }
}

#[test]
fn what_it_cannot_do_is_left_to_all_blocks() {
    let model = |lattice: &Lattice| CondensedModel::new(lattice, 10e-6, E_PA, true);
    // A cavity up to the top row; a sample; more forces around the cavity than the band has columns.
    assert!(model(&lattice(130.0, 370.0, 191.0, 20)).is_none());
    let sample = columns::sample(&groove(130.0, 370.0, 20.0), 10e-6, 200);
    assert!(model(&Lattice::new(sample, 20, false)).is_none());
    assert!(model(&lattice(2003.0, 104.0, 17.0, 20)).is_none());
    // A land that tilts and may lift off the counterface.
    let tipping = lattice(100.0, 40.0, 120.0, 20);
    let load = SteadyLoad { pressure_pa: 1e6, dynamic_mu: &[0.6; 14], area_law: None };
    assert!(model(&tipping).unwrap().solve(&load).is_none());
    // In bilateral contact it has no equilibrium, which the solver of all blocks must report.
    assert!(CondensedModel::new(&tipping, 10e-6, E_PA, false).unwrap().solve(&load).is_none());
    let held = SteadyModel::new(tipping.clone(), 10e-6, E_PA, false).solve(&load);
    assert_eq!(held.status, Status::NotConverged);
    let unloaded = SteadyLoad { pressure_pa: 0.0, ..load };
    assert_eq!(model(&tipping).unwrap().solve(&unloaded).unwrap().status, Status::NoLoad);
}

/// Normal forces under uniform friction from the condensed model of a layer of `rows` rows.
fn normal_forces(width_um: f64, spacing_um: f64, depth_um: f64, rows: usize) -> Vec<f64> {
    let lattice = lattice(width_um, spacing_um, depth_um, rows);
    let condensed = CondensedModel::new(&lattice, 10e-6, E_PA, false).unwrap().response().clone();
    let mut normal = vec![0.0; condensed.contacts.len()];
    condensed.respond(&vec![0.27; normal.len()], &mut [], &mut normal);
    normal
}

#[test]
fn what_a_layer_adds_decays_with_its_thickness_to_a_half_space() {
    let distance = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    for (width, spacing, depth) in [(400.0, 824.5, 49.4), (130.0, 370.0, 20.0)] {
        let pitch_rows = ((width + spacing) / 10.0) as usize;
        let of = |rows: usize| normal_forces(width, spacing, depth, rows);
        let half_space = of(1000 * pitch_rows);
        let off: Vec<f64> = [1, 2, 3].iter().map(|pitches| distance(&of(pitches * pitch_rows), &half_space)).collect();
        // A wave as long as the period decays by exp(-4 pi) to the bulk and back, up to a power of the thickness.
        assert!(off[0] < 1e-2 && off[1] < 1e-4 * off[0] && off[2] < 1e-9, "{off:?}");
        assert!(distance(&of(100 * pitch_rows), &half_space) < 1e-9);
    }
}
