use std::time::Instant;

use slipgrid_material::AreaLaw;
use slipgrid_pattern::{Pattern, Planform};

use super::*;
use crate::outcome::Status;

const E_PA: f64 = 0.38e9;

/// Persson's law for E* h'rms = 4 MPa, A(P) = erf(sqrt(2) P / (E* h'rms)), tabulated finely.
fn law() -> AreaLaw {
    let pressure_pa: Vec<f64> = (1..=200).map(|step| 0.1e6 * f64::from(step)).collect();
    let area: Vec<f64> = pressure_pa.iter().map(|p| libm::erf(2.0_f64.sqrt() * p / 4e6)).collect();
    AreaLaw::from_area_curve(&pressure_pa, &area, 0.7e6).unwrap()
}

fn pattern(planform: Planform, width_um: f64, spacing_um: f64, depth_um: f64) -> Pattern {
    Pattern::new(planform, width_um * 1e-6, spacing_um * 1e-6, depth_um * 1e-6).unwrap()
}

fn model(pattern: &Pattern, block_um: f64, layer_um: f64) -> SolidSteadyModel {
    let rows = (layer_um / block_um).round() as usize;
    SolidSteadyModel::new(SolidLattice::cell(pattern, block_um * 1e-6, rows), block_um * 1e-6, E_PA)
}

fn load<'a>(pressure_mpa: f64, law: Option<&'a AreaLaw>) -> SolidLoad<'a> {
    SolidLoad { pressure_pa: pressure_mpa * 1e6, dynamic_mu: 0.27, area_law: law, direction: [1.0, 0.0] }
}

fn ratio(pattern: &Pattern, block_um: f64) -> f64 {
    let law = law();
    let outcome = model(pattern, block_um, 200.0).solve(&load(2.6, Some(&law)));
    assert_eq!(outcome.status, Status::Converged, "{} {}", outcome.residual, outcome.iterations);
    outcome.mu_dynamic.unwrap() / (0.27 * law.factor(2.6e6))
}

#[test]
fn probe() {
    let law = law();
    for planform in [Planform::Square, Planform::Groove] {
        for depth in [20.0, 14.0, 5.0] {
            let pattern = pattern(planform, 130.0, 370.0, depth);
            let started = Instant::now();
            let model = model(&pattern, 10.0, 200.0);
            let built = started.elapsed();
            let loads = [0.65, 1.3, 1.95, 2.6].map(|p| load(p, Some(&law)));
            let outcomes = model.solve_all(&loads);
            println!("{planform} {depth} built {built:?} all {:?}", started.elapsed());
            for o in outcomes {
                println!("{:?} {:?} {} {} {} peak {}", o.status, o.mu_dynamic, o.residual, o.iterations, o.tension_blocks, o.peak_pressure_pa);
            }
            println!("ratio {}", ratio(&pattern, 10.0));
        }
    }
}
