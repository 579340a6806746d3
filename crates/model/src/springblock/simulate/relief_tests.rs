use std::sync::Arc;

use crate::pattern::{Pattern, Planform, ReliefMap, Rim, RimProfile, Texture};

use super::simulate;
use crate::springblock::tests::samples;
use crate::springblock::{Extent, RunOptions, Scene, SceneError, Strip, Unwatched, simulate_specimen};

/// A scene of cavities with rims, and a scene without rims whose relief map in pixels of 1 um contains the rims.
fn both(planform: Planform) -> [Scene; 2] {
    let rim = Rim::new(0.4e-6, 20e-6, RimProfile::Ramp).unwrap();
    let with = |texture: Texture| Pattern::new(texture, 80e-6, 120e-6, 20e-6).unwrap();
    let rimmed = with(Texture::new(planform).with_rim(rim));
    let side = |n: usize| [n as f64 * 1e-6 - 100e-6, (n + 1) as f64 * 1e-6 - 100e-6];
    let heights = (0..40_000).map(|n| {
        let ([x0, x1], [y0, y1]) = (side(n % 200), side(n / 200));
        // The map includes the floors of the cavities.
        if rimmed.coverage(x0, x1, y0, y1) > 0.5 { -20e-6 } else { 0.4e-6 * rimmed.rim_share(x0, x1, y0, y1) }
    });
    let map = ReliefMap::new([200e-6; 2], [200; 2], heights.collect()).unwrap();
    let scene = samples::scene(rimmed, &[0.65, 2.6], RunOptions::default());
    let measured = Scene { pattern: Some(with(Texture::new(planform))), relief: Some(Arc::new(map)), ..scene.clone() };
    [scene, measured]
}

#[test]
fn a_measured_relief_of_rims_gives_the_ratios_of_the_rims() {
    for (planform, extent) in
        [(Planform::Groove, Extent::Cell), (Planform::Groove, Extent::Sample), (Planform::Square, Extent::Cell)]
    {
        let ratios = both(planform).map(|mut scene| {
            scene.run.extent = extent;
            scene.layer.length_m = 1500e-6;
            samples::ratios(&simulate(&scene, &Unwatched).unwrap())
        });
        for (a, b) in ratios[0].iter().zip(&ratios[1]) {
            assert!((a - b).abs() < 1e-5 && *a < 0.9, "{planform} {a} {b}");
        }
    }
}

#[test]
fn a_specimen_takes_a_measured_relief_as_it_takes_rims() {
    let cavities_m = (0..10).map(|m| [60e-6, 140e-6].map(|at_m| at_m + 200e-6 * f64::from(m))).collect();
    let strip = Strip { width_m: 1e-3, length_m: 2000e-6, cavities_m, band: 0 };
    let face = samples::face(vec![strip]);
    let ratios =
        both(Planform::Groove).map(|scene| samples::ratios(&simulate_specimen(&scene, &face, &Unwatched).unwrap()));
    for (a, b) in ratios[0].iter().zip(&ratios[1]) {
        assert!((a - b).abs() < 1e-5 && *a < 0.9, "{a} {b}");
    }
}

#[test]
fn a_relief_of_another_period_beside_rims_or_without_a_pattern_is_refused() {
    let [rimmed, measured] = both(Planform::Square);
    let refused = |scene: &Scene| simulate(scene, &Unwatched).unwrap_err();
    let other = Scene { pattern: Some(samples::pattern(Planform::Square, 80.0, 150.0, 20.0)), ..measured.clone() };
    assert!(matches!(refused(&other), SceneError::Relief(_)));
    let twice = Scene { relief: measured.relief.clone(), ..rimmed };
    assert!(matches!(refused(&twice), SceneError::Unsupported { .. }));
    assert!(matches!(refused(&Scene { pattern: None, ..measured }), SceneError::Unsupported { .. }));
}
