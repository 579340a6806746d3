use super::*;
use crate::material::{AreaLaw, LocalFriction};
use crate::springblock::tests::samples::{self, face};
use crate::springblock::{Extent, Layer, RunOptions, Unwatched, steady_face_ratios};

/// A strip `length_um` long with as many cavities of `width_um` and lands of `land_um` as fit between margins of at
/// least `margin_um`.
fn strip([width_um, land_um, margin_um, length_um]: [f64; 4]) -> Strip {
    let pitch_um = width_um + land_um;
    let count = ((length_um - 2.0 * margin_um + land_um) / pitch_um).floor();
    let first_um = 0.5 * (length_um - (count * pitch_um - land_um));
    let start_um = |number: u32| first_um + pitch_um * f64::from(number);
    let cavity = |number: u32| [start_um(number) * 1e-6, (start_um(number) + width_um) * 1e-6];
    let cavities_m = (0..count as u32).map(cavity).collect();
    Strip { band: 0, width_m: 1e-3, length_m: length_um * 1e-6, cavities_m }
}

/// Friction is low, since the tilt of the pressure by friction is not part of load sharing.
fn scene([width_um, land_um, depth_um]: [f64; 3], block_um: f64) -> Scene {
    let scene = samples::scene(
        samples::groove(width_um, land_um, depth_um),
        &[0.65, 1.3, 2.6],
        RunOptions { extent: Extent::Sample, ..RunOptions::default() },
    );
    let friction = LocalFriction::new(0.011, 0.01, 0.0).unwrap();
    let loads = scene.loads.iter().map(|load| Load { friction, ..*load });
    Scene {
        loads: loads.collect(),
        area_law: Some(AreaLaw::new(vec![0.7e6, 10e6], vec![1.0, 0.4]).unwrap()),
        layer: Layer { block_m: block_um * 1e-6, ..scene.layer },
        ..scene
    }
}

/// Textures with margins, in micrometres, of strips of 6 mm.
const CASES: [([f64; 3], f64); 6] = [
    ([400.0, 80.0, 20.0], 200.0),
    ([400.0, 80.0, 20.0], 500.0),
    ([400.0, 400.0, 20.0], 60.0),
    ([200.0, 80.0, 20.0], 200.0),
    ([200.0, 200.0, 20.0], 40.0),
    ([100.0, 40.0, 20.0], 300.0),
];

/// Ratios of the strip of `case`: of a layer of 200 um, of this layer with the correction for a specimen of 2 mm, and
/// of 2 mm of blocks.
fn solved(case: ([f64; 3], f64)) -> [Vec<f64>; 3] {
    let ([width, land, depth], margin) = case;
    let face = face(vec![strip([width, land, margin, 6000.0])]);
    let scene = scene([width, land, depth], 20.0);
    let pattern = scene.pattern.unwrap();
    let of = |height_m: f64, thickness_m: Option<f64>| Scene {
        layer: Layer { height_m, thickness_m, ..scene.layer },
        ..scene.clone()
    };
    let ratios = |scene: &Scene| -> Vec<f64> {
        steady_face_ratios(scene, &pattern, &face, &Unwatched).unwrap().into_iter().map(Option::unwrap).collect()
    };
    [of(200e-6, None), of(200e-6, Some(2e-3)), of(2e-3, None)].map(|scene| ratios(&scene))
}

/// The error is proportional to the change by load sharing.
#[test]
fn strips_share_the_load_as_all_blocks_of_the_specimen_say() {
    let mut sums = [0.0; 2];
    for case in CASES {
        let [layer, found, all] = solved(case);
        for ((layer, found), all) in layer.iter().zip(&found).zip(&all) {
            let stated = RELATIVE_ERROR * (found - layer).abs();
            assert!((found - all).abs() < 2.0 * stated.hypot(0.0005), "{case:?}: {layer} {found} {all}");
            sums[0] += (layer - all).powi(2);
            sums[1] += (found - all).powi(2);
        }
    }
    // A rigid bulk behind the layer has an error of 0.05, the elastic specimen of 0.006.
    let [layer, found] = sums.map(|sum: f64| (sum / 18.0).sqrt());
    assert!(found < 0.2 * layer && found < RELATIVE_ERROR * layer, "{layer} {found}");
}

#[test]
fn a_strip_is_cut_in_the_middle_of_its_first_and_last_cavity() {
    let cut = |length_m: f64, cavities_m: &[[f64; 2]]| -> Vec<(f64, [f64; 2])> {
        let strip = Strip {
            band: 0,
            width_m: 1e-3,
            length_m: length_m * 1e-3,
            cavities_m: cavities_m.iter().map(|ends| ends.map(|at| at * 1e-3)).collect(),
        };
        let round = |length_m: f64| (length_m * 1e6).round() * 1e-3;
        let sizes = |widths: CellWidths| [widths.0, widths.1].map(|units| round(units as f64 * WIDTH_UNIT_M));
        pieces(&strip).iter().map(|piece| (round(piece.length_m), sizes(piece.widths))).collect()
    };
    let three = [[0.3, 0.5], [0.8, 1.0], [1.3, 1.5]];
    assert_eq!(cut(1.6, &three), [(0.4, [0.2, 0.6]), (1.0, [0.2, 0.3]), (0.2, [0.2, 0.2])]);
    // Cavities cut by the strip's ends.
    assert_eq!(
        cut(1.4, &[[0.0, 0.1], [0.4, 0.6], [0.9, 1.1]]),
        [(0.25, [0.2, 0.3]), (0.75, [0.2, 0.3]), (0.4, [0.2, 0.6])]
    );
    assert_eq!(cut(0.4, &[[0.0, 0.1], [0.3, 0.4]]), [(0.2, [0.2, 0.2]), (0.2, [0.2, 0.2])]);
    assert_eq!(cut(1.0, &[[0.2, 0.6]]), [(0.4, [0.4, 0.4]), (0.6, [0.4, 0.8])]);
    assert_eq!(cut(1.0, &[[0.0, 0.6]]), [(1.0, [1.2, 0.8])]);
    assert!(cut(1.0, &[]).is_empty());
}

#[test]
fn cavities_everywhere_are_the_cell_and_sides_change_little() {
    // Margins of half a land make every piece equal to the cell.
    let face = face(vec![strip([200.0, 200.0, 100.0, 8000.0])]);
    let mut scene = scene([200.0, 200.0, 20.0], 10.0);
    let pattern = scene.pattern.unwrap();
    let layer = SteadyCell::with_dimension(&scene, Dimension::Plane).ratios(&pattern);
    scene.layer.thickness_m = Some(7e-3);
    let thick = SteadyCell::with_dimension(&scene, Dimension::Plane).ratios(&pattern);
    let found = difference(&scene, &pattern, &face, &Unwatched).unwrap();
    for ((found, layer), thick) in found.iter().zip(layer).zip(thick) {
        assert!((found.unwrap() - (thick.unwrap() - layer.unwrap())).abs() < 3e-4, "{found:?}");
    }
}

/// Parts of a face, from hardly pressed to the edges of a tilted specimen, against cells solved under each pressure.
#[test]
fn parts_rub_like_cells_under_their_pressures() {
    let (mut squares, mut count) = (0.0, 0);
    for (planform, dimension) in [(Planform::Groove, Dimension::Plane), (Planform::Square, Dimension::Space)] {
        for [width, spacing, depth] in [[130.0, 370.0, 5.0], [60.0, 60.0, 20.0]] {
            let pattern = samples::pattern(planform, width, spacing, depth);
            let scene = samples::scene(pattern, &[0.65, 2.6, 1.3], RunOptions::default());
            let own = [0.25, 0.3, 0.35].map(|mu| LocalFriction::new(1.1 * mu, mu, 0.0).unwrap());
            let loads = scene.loads.iter().zip(own).map(|(load, friction)| Load { friction, ..*load }).collect();
            let area_law = Some(AreaLaw::new(vec![0.7e6, 1e6, 2e6, 10e6], vec![1.0, 0.95, 0.8, 0.4]).unwrap());
            let scene = Scene { loads, area_law, ..scene };
            let parts =
                [0.0, 0.1, 0.3, 0.6, 0.9, 1.0, 1.1, 1.5, 2.2, 3.0].map(|pressure| LoadShare::solid(1e-6, pressure));
            let found = CellFriction::new(&scene, Some((&pattern, dimension)), parts.iter(), &Unwatched);
            for (place, load) in scene.loads.iter().enumerate() {
                assert_eq!(found.force(place, parts[..1].iter()), Some(0.0));
                for part in &parts[1..] {
                    let under = Load { pressure_pa: part.pressure * load.pressure_pa, ..*load };
                    let cell = SteadyCell::with_dimension(&Scene { loads: vec![under], ..scene.clone() }, dimension);
                    let mu = cell.solve(&pattern)[0].surface.mu_dynamic.unwrap();
                    let off =
                        found.force(place, std::iter::once(part)).unwrap() / (1e-6 * under.pressure_pa * mu) - 1.0;
                    assert!(off.abs() < 2e-3, "{planform} {width} {place} {}: {off}", part.pressure);
                    squares += off * off;
                    count += 1;
                }
            }
        }
    }
    let rms = (squares / f64::from(count)).sqrt();
    assert!(rms < 5e-4, "{rms}");
}

#[test]
fn parts_under_one_pressure_rub_like_the_cell() {
    let pattern = samples::groove(130.0, 370.0, 5.0);
    let scene = samples::scene(pattern, &[1.3], RunOptions::default());
    let scene = Scene { area_law: Some(AreaLaw::new(vec![0.7e6, 10e6], vec![1.0, 0.4]).unwrap()), ..scene };
    let parts = [1.0, 1.0].map(|pressure| LoadShare::solid(1e-6, pressure));
    let found = CellFriction::new(&scene, Some((&pattern, Dimension::Plane)), parts.iter(), &Unwatched);
    let mu = SteadyCell::with_dimension(&scene, Dimension::Plane).solve(&pattern)[0].surface.mu_dynamic.unwrap();
    let off = found.force(0, parts.iter()).unwrap() / (2e-6 * scene.loads[0].pressure_pa * mu) - 1.0;
    assert!(off.abs() < 1e-6, "{off}");
}
