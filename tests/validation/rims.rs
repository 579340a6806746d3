//! Faces with rims in time, compared with the steady equilibrium, and one integrator compared with another.

use slipgrid_model::pattern::{Pattern, Planform, Rim, RimProfile, Texture};
use slipgrid_model::springblock::{
    Extent, Fidelity, Layer, RunOptions, Scene, Simulation, Status, Unwatched, simulate,
};
use slipgrid_tests::polymer_scene;

/// Scene of grooves with flat rims two blocks wide.
fn scene(height_um: f64, pressures_mpa: &[f64], fidelity: Fidelity, extent: Extent) -> Scene {
    let rim = Rim::new(height_um * 1e-6, 20e-6, RimProfile::Flat).unwrap();
    let pattern = Pattern::new(Texture::new(Planform::Groove).with_rim(rim), 130e-6, 370e-6, 20e-6).unwrap();
    let scene = polymer_scene(Some(pattern), pressures_mpa, fidelity, extent).unwrap();
    Scene { layer: Layer { thickness_m: None, ..scene.layer }, ..scene }
}

fn run(scene: &Scene) -> Simulation {
    simulate(scene, &Unwatched).unwrap()
}

#[test]
fn ratios_with_rims_in_time_are_those_of_steady_sliding() {
    for (height_um, warm_start, pressure_mpa) in [(0.1, false, 2.6), (0.5, true, 0.65)] {
        let scene = scene(height_um, &[pressure_mpa], Fidelity::Dynamic, Extent::Cell);
        let steady = run(&Scene { run: RunOptions { fidelity: Fidelity::Steady, ..scene.run }, ..scene.clone() });
        let dynamic = run(&Scene { run: RunOptions { warm_start, draws: 4, ..scene.run }, ..scene.clone() });
        for (steady, dynamic) in steady.loads.iter().zip(&dynamic.loads) {
            let (a, b) = (steady.ratio().unwrap(), dynamic.ratio().unwrap());
            let error = dynamic.ratio_stderr.unwrap();
            println!("{height_um} um, {:.2e} Pa: steady {a:.4} dynamic {b:.4} +- {error:.4}", steady.pressure_pa);
            assert_eq!(dynamic.surface.status, Status::Converged);
            assert!((a - b).abs() < 0.006 + 3.0 * error, "{height_um} {}: {a} {b}", steady.pressure_pa);
            let peaks = [steady, dynamic].map(|load| load.surface.peak_pressure_pa);
            assert!((peaks[1] / peaks[0] - 1.0).abs() < 0.1, "{peaks:?}");
        }
    }
}

#[test]
fn a_short_sample_with_rims_slides_in_time_as_steadily() {
    let mut scene = scene(0.3, &[1.3], Fidelity::Dynamic, Extent::Sample);
    scene.layer.length_m = 2000e-6;
    let steady = run(&Scene { run: RunOptions { fidelity: Fidelity::Steady, ..scene.run }, ..scene.clone() });
    let dynamic = run(&scene);
    let (a, b) = (steady.loads[0].ratio().unwrap(), dynamic.loads[0].ratio().unwrap());
    println!("steady {a:.4} dynamic {b:.4} +- {:.4}", dynamic.loads[0].ratio_stderr.unwrap());
    assert!((a - b).abs() < 0.01, "{a} {b}");
    let off = steady.loads[0].surface.interface.iter().filter(|point| point.pressure_pa == 0.0).count();
    assert!(off > 5 && steady.loads[0].surface.status == Status::Converged, "{off}");
}

#[test]
fn squares_with_rims_in_time_are_those_of_steady_sliding() {
    let rim = Rim::new(0.3e-6, 20e-6, RimProfile::Flat).unwrap();
    let pattern = Pattern::new(Texture::new(Planform::Square).with_rim(rim), 80e-6, 120e-6, 20e-6).unwrap();
    let scene = polymer_scene(Some(pattern), &[1.3], Fidelity::Dynamic, Extent::Cell).unwrap();
    let scene = Scene { layer: Layer { thickness_m: None, height_m: 100e-6, ..scene.layer }, ..scene };
    let steady = run(&Scene { run: RunOptions { fidelity: Fidelity::Steady, ..scene.run }, ..scene.clone() });
    let dynamic = run(&Scene { run: RunOptions { warm_start: true, sliding_m: 1e-6, ..scene.run }, ..scene.clone() });
    let (a, b) = (steady.loads[0].ratio().unwrap(), dynamic.loads[0].ratio().unwrap());
    let error = dynamic.loads[0].ratio_stderr.unwrap();
    println!("steady {a:.4} dynamic {b:.4} +- {error:.4}");
    assert_eq!(dynamic.loads[0].surface.status, Status::Converged);
    assert!((a - b).abs() < 0.01 + 3.0 * error, "{a} {b}");
}
