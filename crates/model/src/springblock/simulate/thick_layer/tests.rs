#![allow(clippy::print_stdout, reason = "what takes minutes tells what it measured")]

use crate::material::LocalFriction;
use crate::pattern::Planform;

use super::*;
use crate::springblock::tests::samples::{self, groove};
use crate::springblock::{Correction, RunOptions, Unwatched, simulate};

fn scene(pattern: Pattern, run: RunOptions) -> Scene {
    let scene = samples::scene(pattern, &[0.65, 2.6], run);
    Scene { layer: Layer { length_m: 6000e-6, ..scene.layer }, ..scene }
}

/// Ratios of `scene` with a layer of `height_m` and the thickness `thickness_m`.
fn ratios(scene: &Scene, height_m: f64, thickness_m: Option<f64>) -> Vec<LoadOutcome> {
    let layer = Layer { height_m, thickness_m, ..scene.layer };
    simulate(&Scene { layer, ..scene.clone() }, &Unwatched).unwrap().loads
}

const PATTERNS: [[f64; 3]; 10] = [
    [400.0, 824.5, 49.4],
    [400.0, 820.0, 50.0],
    [130.0, 370.0, 20.0],
    [200.0, 200.0, 20.0],
    [300.0, 600.0, 30.0],
    [100.0, 800.0, 50.0],
    [250.0, 250.0, 60.0],
    [60.0, 140.0, 10.0],
    [350.0, 150.0, 30.0],
    [180.0, 520.0, 100.0],
];
const THICK_M: f64 = 800e-6;

/// Root mean square and maximum of `off`.
fn sizes(off: &[f64]) -> [f64; 2] {
    let square = off.iter().map(|off| off * off).sum::<f64>() / off.len() as f64;
    [square.sqrt(), off.iter().map(|off| off.abs()).fold(0.0, f64::max)]
}

/// Error of a layer of 200 um plus the steady difference, compared with 800 um of blocks, by pattern and load.
fn off(run: RunOptions, length_m: f64, relative_std: f64) -> Vec<f64> {
    let mut off = Vec::new();
    for [width, spacing, depth] in PATTERNS {
        // With few contact blocks one draw does not represent the mean coefficients.
        let draws = if run.fidelity == Fidelity::Steady {
            1
        } else if width + spacing < 300.0 {
            64
        } else {
            4
        };
        let mut scene = scene(groove(width, spacing, depth), RunOptions { draws, ..run });
        scene.layer.length_m = length_m;
        for load in &mut scene.loads {
            load.friction = LocalFriction::new(0.30, 0.27, relative_std).unwrap();
        }
        let (thin, thick) = (ratios(&scene, 200e-6, Some(THICK_M)), ratios(&scene, THICK_M, None));
        for (thin, thick) in thin.iter().zip(&thick) {
            let (found, expected) = (thin.ratio().unwrap(), thick.ratio().unwrap());
            let Correction { change: added, std, .. } = *thin.correction(Effect::Behind).unwrap();
            let stated = std.unwrap();
            println!(
                "{width}/{spacing}/{depth} {:.2} MPa: {found:.4} {expected:.4} off {:+.4} added {added:+.4} +- {stated:.4} stderr {:.4} {:.4} peak {:.2} {:.2}",
                thin.pressure_pa / 1e6,
                found - expected,
                thin.ratio_stderr.unwrap_or(0.0),
                thick.ratio_stderr.unwrap_or(0.0),
                thin.surface.peak_pressure_pa / 1e6,
                thick.surface.peak_pressure_pa / 1e6,
            );
            off.push(found - expected);
        }
    }
    println!("root mean square and largest: {:?}", sizes(&off));
    off
}

#[test]
#[ignore = "forty runs in time, half of them of thick layers, take minutes"]
fn a_thick_layer_in_time_is_a_thin_one_and_the_steady_difference() {
    let [rms, largest] = sizes(&off(samples::in_time(RunOptions::default().sliding_m), 9960e-6, 0.05));
    assert!(rms < DYNAMIC_ERROR && largest < 0.003, "{rms} {largest}");
}

#[test]
#[ignore = "strips of thick layers take a minute"]
fn ends_hardly_change_what_is_behind_the_layer() {
    let run = RunOptions { extent: Extent::Sample, ..RunOptions::default() };
    for length_m in [9960e-6, 6000e-6] {
        let [rms, _] = sizes(&off(run, length_m, 0.0));
        let stated = END_ERROR * REFERENCE_LENGTH_M / length_m;
        assert!(rms < 1.1 * stated, "{length_m}: {rms} {stated}");
    }
}

#[test]
fn steady_cells_are_solved_over_the_whole_thickness_and_say_what_that_changes() {
    for pattern in [groove(400.0, 824.5, 49.4), squares()] {
        let scene = scene(pattern, RunOptions::default());
        let at = |thickness_m: Option<f64>| {
            let layer = Layer { height_m: 200e-6, thickness_m, ..scene.layer };
            let stated = ThickLayerCorrection::new(&Scene { layer, ..scene.clone() }, &pattern, &Unwatched).each;
            ratios(&scene, 200e-6, thickness_m).into_iter().zip(stated).collect::<Vec<_>>()
        };
        for ((thin, of_thin), (thick, of_thick)) in at(None).into_iter().zip(at(Some(7e-3))) {
            let change = thick.ratio().unwrap() - thin.ratio().unwrap();
            // Cells in space are compared in blocks of twice the size; 7 mm is equivalent to a half-space for both.
            let close = |a: f64, tolerance: f64| assert!((a - change).abs() < tolerance, "{a} {change}");
            let tolerance = if !pattern.texture().is_one_section() { 0.2 * change.abs() } else { 1e-9 };
            close(of_thick.unwrap().ratio, tolerance);
            close(of_thin.unwrap().ratio, tolerance.max(1e-6));
            assert_eq!((thin.correction(Effect::Behind), thick.correction(Effect::Behind)), (None, None));
        }
        let statements = |thickness_m: Option<f64>| {
            let layer = Layer { thickness_m, ..scene.layer };
            simulate(&Scene { layer, ..scene.clone() }, &Unwatched).unwrap().statements.model.join("\n")
        };
        assert!(statements(None).contains("layer of 200 um under a rigid bulk, as asked for"));
        assert!(statements(Some(7e-3)).contains("specimen 7 mm thick"), "{}", statements(Some(7e-3)));
    }
}

fn squares() -> Pattern {
    samples::pattern(Planform::Square, 200.0, 200.0, 20.0)
}

#[test]
fn time_and_ends_get_the_steady_difference_added() {
    let in_time = samples::in_time(0.1e-6);
    let with_ends = RunOptions { extent: Extent::Sample, ..RunOptions::default() };
    for (pattern, run, open) in [
        (groove(300.0, 600.0, 30.0), in_time, DYNAMIC_ERROR),
        (groove(133.3, 371.9, 14.4), in_time, DYNAMIC_ERROR),
        (groove(300.0, 600.0, 30.0), with_ends, END_ERROR / 0.6),
        (squares(), in_time, DYNAMIC_ERROR),
    ] {
        let mut scene = scene(pattern, run);
        scene.loads.remove(0);
        if !pattern.texture().is_one_section() {
            (scene.layer.height_m, scene.layer.block_m) = (120e-6, 20e-6);
        }
        let height_m = scene.layer.height_m;
        let (thin, thick) = (&ratios(&scene, height_m, None)[0], &ratios(&scene, height_m, Some(7e-3))[0]);
        let cell = Scene { run: RunOptions::default(), ..scene.clone() };
        let [alone, all] = [None, Some(7e-3)].map(|of| ratios(&cell, height_m, of)[0].clone());
        let change = all.ratio().unwrap() - alone.ratio().unwrap();
        // Strips with ends have a tilt correction.
        let tilt = thick.correction(Effect::Tilt);
        assert_eq!(tilt.is_some(), scene.run.extent == Extent::Sample);
        let tilt = tilt.map_or(0.0, |tilt| tilt.change);
        assert!(change.abs() > 1e-4 && (thick.ratio().unwrap() - thin.ratio().unwrap() - change - tilt).abs() < 1e-9);
        let behind = thick.correction(Effect::Behind).unwrap();
        assert!((behind.change - change).abs() < 1e-9 && (behind.std.unwrap() - open).abs() < 1e-12, "{behind:?}");
        let mu = thick.flat.as_ref().unwrap().mu_dynamic.unwrap() * thick.ratio().unwrap();
        assert!((thick.surface.mu_dynamic.unwrap() - mu).abs() < 1e-12);
        let peak = all.surface.peak_pressure_pa / alone.surface.peak_pressure_pa;
        assert!((thick.surface.peak_pressure_pa / thin.surface.peak_pressure_pa - peak).abs() < 1e-9);
    }
}

#[test]
fn a_flat_surface_does_not_know_how_thick_it_is() {
    let mut scene = scene(squares(), RunOptions { extent: Extent::Sample, ..RunOptions::default() });
    scene.pattern = None;
    let thin = simulate(&scene, &Unwatched).unwrap();
    scene.layer.thickness_m = Some(7e-3);
    assert_eq!(simulate(&scene, &Unwatched).unwrap(), thin);
    assert!(thin.loads[0].corrections().is_empty());
}

#[test]
fn a_specimen_thinner_than_its_layer_is_refused() {
    let mut scene = scene(squares(), RunOptions::default());
    for thickness_m in [100e-6, 0.0, f64::NAN, 100.0] {
        scene.layer.thickness_m = Some(thickness_m);
        assert!(scene.validate().is_err(), "{thickness_m}");
    }
}
