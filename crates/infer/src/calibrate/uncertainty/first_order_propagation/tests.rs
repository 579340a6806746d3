use super::*;
use crate::calibrate::uncertainty::DiscrepancyAt;
use crate::calibrate::uncertainty::covariances::tests::exponential_law;
use crate::calibrate::uncertainty::{ScaleError, with_scale};
use slipgrid_base::statistics::Normals;
use slipgrid_model::material::Elastic;
use slipgrid_model::pattern::{Planform, Rim, RimProfile};
use slipgrid_model::springblock::{Layer, Load, Unwatched, simulate};

/// A(P) = 1 - exp(-P / 4 MPa), from `threshold_pa` on.
fn law(threshold_pa: f64) -> AreaLaw {
    exponential_law(4e6, threshold_pa)
}

fn scene(planform: Planform, area_law: Option<AreaLaw>) -> Scene {
    let friction = LocalFriction::new(0.30, 0.27, 0.05).unwrap();
    Scene {
        elastic: Elastic::new(0.38e9, 900.0).unwrap(),
        area_law,
        pattern: Some(Pattern::new(planform, 160e-6, 240e-6, 20e-6).unwrap()),
        relief: None,
        layer: Layer { length_m: 1200e-6, height_m: 120e-6, block_m: 10e-6, thickness_m: None, holder: None },
        loads: [0.65e6, 1.3e6, 2.6e6].map(|pressure_pa| Load { pressure_pa, friction }).to_vec(),
        speed_m_s: 2e-3,
        run: RunOptions::default(),
    }
}

/// Ratio and flat friction at each load, from the steady cell itself.
fn solved(scene: &Scene) -> Vec<[f64; 2]> {
    let found = simulate(scene, &Unwatched).unwrap();
    found.loads.iter().map(|load| [load.ratio().unwrap(), load.flat.as_ref().unwrap().mu_dynamic.unwrap()]).collect()
}

fn modulus(std: f64) -> Option<ScaleError> {
    Some(ScaleError { is_fitted: false, variance: std * std, with_friction: vec![0.0; 3] })
}

#[test]
fn a_stiffer_surface_is_a_lighter_load() {
    // With the threshold below all local pressures, mu_d f(p) = mu_flat g(p / E) / g(P / E) depends on p / P and P / E
    // only: dr / d ln E = -dr / d ln P for a given mu_flat. Rims, which are compressed in proportion to P / E, follow
    // the same rule.
    let area_law = law(0.02e6);
    let rim = |um: f64| Some(Rim::new(um * 1e-6, 20e-6, RimProfile::Round).unwrap());
    for rim in [None, rim(0.1), rim(0.5)] {
        let mut scene = scene(Planform::Groove, Some(area_law.clone()));
        scene.pattern = scene.pattern.map(|pattern| pattern.with_rim(rim));
        assert_stiffer_is_lighter(&scene, &area_law);
    }
}

fn assert_stiffer_is_lighter(scene: &Scene, area_law: &AreaLaw) {
    let std = 0.01;
    let slopes = Slopes::new(scene, &InputUncertainty { scale: modulus(std), ..InputUncertainty::default() });
    const STEP: f64 = 0.01;
    let heavier = |log: f64| {
        let mut moved = scene.clone();
        for load in &mut moved.loads {
            let pressure_pa = load.pressure_pa * f64::exp(log);
            let times = area_law.factor(load.pressure_pa) / area_law.factor(pressure_pa);
            let friction = LocalFriction::new(0.3 * times, 0.27 * times, 0.05).unwrap();
            *load = Load { pressure_pa, friction };
        }
        solved(&moved)
    };
    let (more, less) = (heavier(STEP), heavier(-STEP));
    for load in 0..3 {
        let expected = -(more[load][0] - less[load][0]) / (2.0 * STEP);
        let [_, found, _] = slopes.by_load[load].unwrap();
        assert!(expected.abs() > 0.002 && (found - expected).abs() < 1e-9, "{load}: {found} {expected}");
    }
}

#[test]
fn what_is_drawn_of_the_modulus_is_the_modulus_itself() {
    for x in [-0.4999, -0.2, 0.0, 0.21, 3.0] {
        assert!((ScaleShift::off_by(x, false).log.exp() - (1.0 + x)).abs() < 1e-12);
        assert_eq!(ScaleShift::off_by(x, true).log, x);
    }
    // Smooth at the transition to the tangent, and never negative.
    let [below, at, above] = [-0.501, -0.5, -0.499].map(|x| ScaleShift::off_by(x, false).log);
    assert!(((above - at) - (at - below)).abs() < 3e-6 && at == 0.5_f64.ln());
    assert!(ScaleShift::off_by(-3.0, false).log.exp() > 0.0);
}

#[test]
fn without_an_area_law_only_flat_friction_moves_friction() {
    let scene = scene(Planform::Groove, None);
    let knowledge =
        InputUncertainty { flat_friction: Some(vec![4e-4; 3]), scale: modulus(0.2), ..InputUncertainty::default() };
    let slopes = Slopes::new(&scene, &knowledge);
    for (load, [ratio, flat]) in solved(&scene).into_iter().enumerate() {
        let found = slopes.deviations(load, ratio, flat, &knowledge).unwrap();
        assert!(found.ratio.std < 1e-8, "{found:?}");
        assert!((found.mu.std - 0.02 * 0.27).abs() < 1e-8 && (found.flat.std - 0.02 * 0.27).abs() < 1e-12);
    }
}

#[test]
fn first_order_is_what_samples_scatter() {
    let factor_std: Vec<f64> = law(0.7e6).factors().iter().map(|f| 0.02 * (1.0 - f)).collect();
    let area_law = law(0.7e6).with_factor_std(factor_std).unwrap();
    let scene = scene(Planform::Groove, Some(area_law.clone()));
    // Coefficient and scale shifted together, with the correlation of a fit.
    let known = [[4e-4, 9e-4], [9e-4, 4e-3]];
    let joint = with_scale(&known, &area_law, &scene.loads).unwrap();
    let discrepancy = DiscrepancyAt { factor: 0.9, log_std: 0.01, log_reach_68: [0.01; 2], log_reach_95: [0.0196; 2] };
    let knowledge = InputUncertainty {
        flat_friction: Some((0..3).map(|load| joint[load][load]).collect()),
        scale: Some(ScaleError {
            is_fitted: true,
            variance: joint[3][3],
            with_friction: (0..3).map(|load| joint[load][3]).collect(),
        }),
        discrepancy: Some(vec![discrepancy; 3]),
        ..InputUncertainty::default()
    };
    let slopes = Slopes::new(&scene, &knowledge);
    let cell = steady_cell(&scene, &scene.pattern.unwrap());
    let mut normals = Normals::new(1);
    let nominal = solved(&scene);
    const DRAWS: usize = 400;
    let mut drawn = vec![Vec::new(); 3];
    for _ in 0..DRAWS {
        // Cholesky factor of the covariance of mu_d and ln s.
        let (z, w) = (normals.draw(), normals.draw());
        let coefficient = known[0][0].sqrt() * z;
        let share = known[0][1] / known[0][0].sqrt();
        let log_scale = share * z + (known[1][1] - share * share).sqrt() * w;
        let [law_off, own] = [normals.draw(), discrepancy.log_std * normals.draw()];
        let moved = area_law.at_modulus(log_scale.exp()).unwrap();
        // Flat friction depends on both.
        let friction: Vec<f64> = scene
            .loads
            .iter()
            .map(|load| (1.0 + coefficient) * moved.factor(load.pressure_pa) / area_law.factor(load.pressure_pa) - 1.0)
            .collect();
        let found =
            ratios(&cell, &scene.pattern.unwrap(), &friction, ScaleShift { log: log_scale, is_fitted: false }, law_off)
                .unwrap();
        for load in 0..3 {
            let ratio = found[load].unwrap() * discrepancy.factor * own.exp();
            drawn[load].push([ratio, ratio * nominal[load][1] * (1.0 + friction[load])]);
        }
    }
    for (load, [ratio, flat]) in nominal.into_iter().enumerate() {
        let found = slopes.deviations(load, ratio, flat, &knowledge).unwrap();
        for (column, deviation) in [&found.ratio, &found.mu].into_iter().enumerate() {
            let mean = drawn[load].iter().map(|row| row[column]).sum::<f64>() / DRAWS as f64;
            let square: f64 = drawn[load].iter().map(|row| (row[column] - mean).powi(2)).sum();
            let share = (square / (DRAWS - 1) as f64).sqrt() / deviation.std;
            // A standard deviation of 400 values is known to 3.5 %.
            assert!((0.88..1.12).contains(&share), "{load} {column}: {share} {deviation:?}");
            // The smallest contribution is that of flat friction, on which the ratio hardly depends.
            assert_eq!(deviation.parts.len(), 4);
        }
        assert!((found.flat.std / flat - joint[load][load].sqrt()).abs() < 1e-12);
    }
}

#[test]
fn slopes_in_space_do_not_see_the_size_of_blocks() {
    let scene = scene(Planform::Square, Some(law(0.7e6)));
    let knowledge =
        InputUncertainty { flat_friction: Some(vec![1e-4; 3]), scale: modulus(0.1), ..InputUncertainty::default() };
    let coarse = Slopes::new(&scene, &knowledge);
    assert_eq!(steady_cell(&scene, &scene.pattern.unwrap()).layer.block_m, 20e-6);
    // 13 rows cannot be halved.
    let layer = Layer { height_m: 130e-6, ..scene.layer };
    let fine = Slopes::new(&Scene { layer, ..scene.clone() }, &knowledge);
    for (coarse, fine) in coarse.by_load.iter().zip(&fine.by_load) {
        let ([friction, scale, _], [fine_friction, fine_scale, _]) = (coarse.unwrap(), fine.unwrap());
        assert!((scale / fine_scale - 1.0).abs() < 0.1, "{coarse:?} {fine:?}");
        assert!((friction - fine_friction).abs() < 0.1 * fine_scale.abs(), "{coarse:?} {fine:?}");
    }
}

#[test]
fn a_neighbour_without_an_answer_leaves_the_error_open() {
    let mut scene = scene(Planform::Groove, Some(law(0.7e6)));
    scene.loads[1].pressure_pa = 0.0;
    let knowledge = InputUncertainty { flat_friction: Some(vec![1e-4; 3]), ..InputUncertainty::default() };
    let slopes = Slopes::new(&scene, &knowledge);
    assert_eq!(slopes.deviations(1, 1.0, 0.3, &knowledge), None);
    assert!(
        slopes.deviations(2, 0.9, 0.3, &knowledge).is_some() && slopes.deviations(9, 0.9, 0.3, &knowledge).is_none()
    );
    let flat = Slopes::new(&Scene { pattern: None, ..scene }, &knowledge);
    let found = flat.deviations(0, 1.0, 0.3, &knowledge).unwrap();
    assert!(found.ratio.std == 0.0 && (found.mu.std - 0.003).abs() < 1e-12);
}
