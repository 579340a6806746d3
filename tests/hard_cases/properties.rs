//! Properties that hold for any pattern, tested on a fixed sequence of random ones.

use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use slipgrid_model::material::{AreaLaw, LocalFriction};
use slipgrid_model::pattern::{Pattern, Planform};
use slipgrid_model::springblock::{Extent, Fidelity, Layer, Scene, Status, Unwatched, simulate};
use slipgrid_tests::polymer_scene;

/// Test runner with the same cases in every run.
fn runner(cases: u32) -> TestRunner {
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]))
}

/// Random width, spacing and depth, in micrometres, for blocks of 10 um in a layer of 100 um.
fn dimensions() -> impl Strategy<Value = (f64, f64, f64)> {
    (5.0..150.0, 5.0..250.0, 1.0..99.0)
}

fn scene((width_um, spacing_um, depth_um): (f64, f64, f64), fidelity: Fidelity, extent: Extent) -> Scene {
    let pattern = Pattern::new(Planform::Groove, width_um * 1e-6, spacing_um * 1e-6, depth_um * 1e-6).unwrap();
    let mut scene = polymer_scene(Some(pattern), &[0.65, 2.6], fidelity, extent).unwrap();
    scene.layer = Layer { length_m: 500e-6, height_m: 100e-6, block_m: 10e-6, thickness_m: None, holder: None };
    scene.run.sliding_m = 0.1e-6;
    scene
}

#[test]
fn steady_sliding_has_an_answer_or_a_name_for_why_not() {
    let law = (0.1e6..5e6, 1e-5_f64..1.0, 0.0..1.5_f64);
    let strategy = (dimensions(), law, 0.01..1.2_f64, 0..2);
    let answers = std::cell::Cell::new(0);
    runner(150)
        .run(&strategy, |(dimensions, (at_pa, width, after), mu, extent)| {
            let mut scene = scene(dimensions, Fidelity::Steady, Extent::ALL[extent as usize]);
            scene.area_law = Some(AreaLaw::new(vec![at_pa, at_pa * (1.0 + width)], vec![1.0, after]).unwrap());
            for load in &mut scene.loads {
                load.friction = LocalFriction::new(1.1 * mu, mu, 0.05).unwrap();
            }
            let simulation = match simulate(&scene, &Unwatched) {
                Ok(simulation) => simulation,
                // Cavity and land of less than half a block each: refused, with smaller blocks as the remedy.
                Err(refused) => {
                    prop_assert!(dimensions.0 + dimensions.1 < 12.0, "{}", refused);
                    return Ok(());
                }
            };
            for load in simulation.loads {
                let surface = &load.surface;
                prop_assert!(
                    matches!(surface.status, Status::Converged | Status::NotConverged | Status::NoFriction),
                    "{:?}",
                    surface.status
                );
                prop_assert!(surface.mu_dynamic.is_none_or(f64::is_finite));
                prop_assert!(surface.interface.iter().all(|p| p.pressure_pa.is_finite() && p.friction_pa.is_finite()));
                answers.set(answers.get() + u32::from(surface.status != Status::NotConverged));
                if surface.status == Status::Converged {
                    let most = 1.3 * mu * after.max(1.0);
                    prop_assert!(surface.mu_dynamic.is_some_and(|found| found >= 0.0 && found <= most));
                }
            }
            Ok(())
        })
        .unwrap();
    println!("{} of 300 have an answer", answers.get());
    assert!(answers.get() >= 250);
}

#[test]
fn time_integration_of_any_pattern_stays_finite() {
    runner(12)
        .run(&(dimensions(), 0..2, any::<bool>(), 0.0..2.0_f64), |(dimensions, extent, liftoff, damping)| {
            let mut scene = scene(dimensions, Fidelity::Dynamic, Extent::ALL[extent as usize]);
            (scene.run.liftoff, scene.run.damping) = (liftoff, damping);
            for load in simulate(&scene, &Unwatched).unwrap().loads {
                prop_assert_ne!(load.surface.status, Status::Diverged);
                prop_assert!(load.surface.mu_dynamic.is_none_or(|mu| mu.is_finite() && mu.abs() < 0.5));
                prop_assert!(load.surface.interface.iter().all(|point| point.pressure_pa.is_finite()));
            }
            Ok(())
        })
        .unwrap();
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let pools = [1, 2, 3].map(|threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap());
    runner(6)
        .run(&(dimensions(), 0..2, 0..2), |(dimensions, fidelity, extent)| {
            let scene = scene(dimensions, Fidelity::ALL[fidelity as usize], Extent::ALL[extent as usize]);
            let [one, two, three] = pools.each_ref().map(|pool| pool.install(|| simulate(&scene, &Unwatched)));
            prop_assert!(one.is_ok() && one == two && two == three);
            Ok(())
        })
        .unwrap();
}
