use slipgrid_material::AreaLaw;
use slipgrid_pattern::{Pattern, Planform};

use super::super::SteadyModel;
use super::*;
use crate::columns;

const E_PA: f64 = 0.38e9;

/// Persson's law for E* h'rms = 4 MPa, A(P) = erf(sqrt(2) P / (E* h'rms)), tabulated finely.
fn law() -> AreaLaw {
    let pressure_pa: Vec<f64> = (1..=200).map(|step| 0.1e6 * f64::from(step)).collect();
    let area: Vec<f64> = pressure_pa.iter().map(|p| libm::erf(2.0_f64.sqrt() * p / 4e6)).collect();
    AreaLaw::from_area_curve(&pressure_pa, &area, 0.7e6).unwrap()
}

fn lattice(width_um: f64, spacing_um: f64, depth_um: f64, rows: usize) -> Lattice {
    let pattern = Pattern::new(Planform::Groove, width_um * 1e-6, spacing_um * 1e-6, depth_um * 1e-6).unwrap();
    Lattice::new(columns::cell(&pattern, 10e-6), rows, true)
}

/// Normal forces by both ways under uneven friction, the largest difference.
fn largest_difference(lattice: &Lattice) -> Option<f64> {
    let plain = super::super::System::new(lattice, &[]);
    let condensed = CondensedModel::new(lattice, 10e-6, E_PA, false)?.response;
    let m = condensed.contacts.len();
    assert_eq!(m, plain.contacts().len());
    let friction: Vec<f64> = (0..m).map(|c| 0.3 + 0.1 * (c as f64).sin()).collect();
    let (mut displacement, mut expected, mut found) = (vec![0.0; plain.order()], vec![0.0; m], vec![0.0; m]);
    plain.respond(&friction, &mut displacement, &mut expected);
    condensed.respond(&friction, &mut [], &mut found);
    Some(expected.iter().zip(&found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max))
}

#[test]
fn normal_forces_are_those_of_all_blocks() {
    for (width, spacing, depth) in [
        (130.0, 370.0, 20.0),
        (130.0, 370.0, 14.0),
        (130.0, 370.0, 4.0),
        (133.0, 367.0, 20.0),
        (133.3, 371.9, 14.0),
        (133.3, 371.9, 3.0),
        (60.0, 50.0, 120.0),
        (61.0, 52.0, 118.0),
        (20.0, 10.0, 10.0),
        (30.0, 10.0, 2.0),
        (10.0, 10.0, 5.0),
        (17.0, 18.0, 13.0),
    ] {
        let difference = largest_difference(&lattice(width, spacing, depth, 20)).unwrap();
        assert!(difference < 1e-9, "{width} {spacing} {depth}: {difference:e}");
    }
}
