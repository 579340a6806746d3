//! Invariance of the model under a change of the units of length, stiffness and time.

use slipgrid_model::material::{Elastic, LocalFriction};
use slipgrid_model::pattern::{Pattern, Planform};
use slipgrid_model::springblock::{Extent, Fidelity, Layer, Load, RunOptions, Scene, Simulation, Unwatched, simulate};

/// Scene with stiffness and pressure times 2^`stiffness`, lengths times 2^`length`, and unchanged times: density scales
/// as stiffness over length squared.
fn scaled(fidelity: Fidelity, stiffness: i32, length: i32) -> Scene {
    let (e, l) = (2_f64.powi(stiffness), 2_f64.powi(length));
    // Powers of two as base, so that scaling leaves every digit.
    let block_m = l / 131_072.0; // 7.6 um
    Scene {
        elastic: Elastic::new(0.4e9 * e, 900.0 * e / (l * l)).unwrap(),
        area_law: None,
        pattern: Some(Pattern::new(Planform::Groove, 4.0 * block_m, 12.0 * block_m, 2.0 * block_m).unwrap()),
        relief: None,
        layer: Layer { length_m: 64.0 * block_m, height_m: 8.0 * block_m, block_m, thickness_m: None, holder: None },
        loads: vec![Load { pressure_pa: 1.3e6 * e, friction: LocalFriction::new(0.30, 0.27, 0.05).unwrap() }],
        speed_m_s: 2e-3 * l,
        run: RunOptions { fidelity, extent: Extent::Cell, sliding_m: 0.5e-6 * l, ..RunOptions::default() },
    }
}

fn solved(scene: &Scene) -> Simulation {
    simulate(scene, &Unwatched).unwrap()
}

#[test]
fn stiffness_and_length_scale_out_to_the_last_bit() {
    for fidelity in [Fidelity::Steady, Fidelity::Dynamic] {
        let own = solved(&scaled(fidelity, 0, 0)).loads.remove(0);
        assert!(own.ratio().is_some());
        // 0.4 GPa to 1.5 kPa and 1.6 TPa, 7.6 um to 7.5 nm and 0.98 mm
        for (stiffness, length) in [(-18, 0), (12, 0), (0, -10), (0, 7), (-18, 7), (12, -10)] {
            let other = solved(&scaled(fidelity, stiffness, length)).loads.remove(0);
            let numbers = |load: &slipgrid_model::springblock::LoadOutcome| {
                (load.surface.status, load.surface.mu_dynamic, load.surface.mu_static, load.ratio(), load.ratio_stderr)
            };
            assert_eq!(numbers(&own), numbers(&other), "{fidelity:?} {stiffness} {length}");
            for (a, b) in own.surface.interface.iter().zip(&other.surface.interface) {
                let e = 2_f64.powi(stiffness);
                assert_eq!((a.pressure_pa * e, a.friction_pa * e), (b.pressure_pa, b.friction_pa));
            }
        }
    }
}
