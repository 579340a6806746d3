use std::sync::OnceLock;

use super::strips::{shortened, solve};
use super::timed_strip::{TIME_CHANGE_ERROR, drawn_ratios, timed_lattices};
use super::*;
use crate::material::{AreaLaw, LocalFriction};
use crate::springblock::simulate::run_all;
use crate::springblock::tests::samples::{self, face, in_time, says};
use crate::springblock::{Effect, Lattice, Layer, SteadyModel, Strip, Unwatched, columns, simulate};

fn scene(run: RunOptions) -> Scene {
    let run = RunOptions { extent: Extent::Sample, ..run };
    let scene = samples::scene(samples::groove(130.0, 370.0, 20.0), &[0.65, 2.6], run);
    let area_law = Some(AreaLaw::new(vec![0.7e6, 10e6], vec![1.0, 0.4]).unwrap());
    Scene { area_law, layer: Layer { length_m: 2e-3, ..scene.layer }, ..scene }
}

/// A strip with cavities of 130 um every 500 um, the first at `first_m`.
fn strip(band: usize, length_m: f64, first_m: f64) -> Strip {
    let starts = (0..1000).map(|number| first_m + 500e-6 * f64::from(number));
    let cavities_m = starts.map(|start_m| [start_m, start_m + 130e-6]).take_while(|ends_m| ends_m[1] <= length_m);
    Strip { band, width_m: 1e-3, length_m, cavities_m: cavities_m.collect() }
}

fn ratios(scene: &Scene, face: &Face) -> Vec<f64> {
    samples::ratios(&simulate_specimen(scene, face, &Unwatched).unwrap())
}

fn largest_distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn one_strip_laid_like_a_sample_is_the_sample() {
    // A sample begins with 18 columns of land; coefficients do not scatter.
    let mut scene = scene(RunOptions::default());
    for load in &mut scene.loads {
        load.friction = LocalFriction::new(0.30, 0.27, 0.0).unwrap();
    }
    let sample = samples::ratios(&simulate(&scene, &Unwatched).unwrap());
    let own = ratios(&scene, &face(vec![strip(0, 2e-3, 180e-6)]));
    assert!(largest_distance(&own, &sample) < 1e-9, "{own:?} {sample:?}");
}

#[test]
fn without_an_area_law_no_layout_changes_friction() {
    let scene = Scene { area_law: None, ..scene(RunOptions::default()) };
    let own = ratios(&scene, &face(vec![strip(0, 2e-3, 180e-6), strip(1, 1.3e-3, 90e-6), strip(2, 0.4e-3, 1.0)]));
    assert!(largest_distance(&own, &[1.0, 1.0]) < 1e-9, "{own:?}");
}

#[test]
fn strips_carry_the_load_as_one_rigid_bulk_presses_them() {
    let scene = scene(RunOptions::default());
    let pattern = scene.pattern.unwrap();
    // A textured and a flat strip of the same area: the mean of both at their own pressures.
    let strips = face(vec![strip(0, 2e-3, 180e-6), Strip { band: 1, cavities_m: Vec::new(), ..strip(1, 2e-3, 0.0) }]);
    let found = simulate_specimen(&scene, &strips, &Unwatched).unwrap();
    let model = |cavities: &[[f64; 2]]| {
        let lattice = Lattice::new(columns::strip(200.0, cavities, 2.0), 20, false);
        SteadyModel::new(lattice, 10e-6, 0.38e9, false)
    };
    let cavities: Vec<[f64; 2]> = strips.strips()[0].cavities_m.iter().map(|ends| ends.map(|at| at / 10e-6)).collect();
    let (cell_lines, flat) = (model(&cavities), model(&[]));
    let [k_t, k_f] = [cell_lines.stiffness_per_length(), flat.stiffness_per_length()];
    assert!(k_t < 0.98 * k_f, "cavities make a strip softer: {k_t} {k_f}");
    for (load, found) in scene.loads.iter().zip(&found.loads) {
        let one = Scene { loads: vec![*load], ..scene.clone() };
        let at = |model: &SteadyModel, k: f64| {
            let share = 2.0 * k / (k_t + k_f);
            load.pressure_pa * share * solve(&one, model, share)[0].mu_dynamic.unwrap()
        };
        let mu = (at(&cell_lines, k_t) + at(&flat, k_f)) / (2.0 * load.pressure_pa);
        assert!((found.surface.mu_dynamic.unwrap() / mu - 1.0).abs() < 1e-9);
    }
    assert!(found.loads[1].ratio().unwrap() > ratios(&scene, &face(vec![strip(0, 2e-3, 180e-6)]))[1]);
    assert!(says(&found, "13.00 % of its face"), "{:?} {pattern:?}", found.statements);
}

#[test]
fn of_a_long_strip_whole_periods_are_left_out() {
    let long = strip(0, 31.8e-3, 90e-6);
    let (short, out_m) = shortened(&long, &scene(RunOptions::default()).layer);
    assert!((out_m / 500e-6 - 60.0).abs() < 1e-9 && short.cavities_m.len() + 60 == long.cavities_m.len());
    let end = |strip: &Strip| strip.length_m - strip.cavities_m.last().unwrap()[1];
    assert!((end(&long) - end(&short)).abs() < 1e-12);
}

/// Half a disc of `diameter_um` in `bands`, centred on a cavity of `pattern`.
fn half_disc(pattern: &Pattern, diameter_um: f64, bands: usize) -> Face {
    let (width_m, pitch_m) = (pattern.width_m(), pattern.pitch_m());
    let of_disc = |band: usize| {
        let length_m = (diameter_um * (1.0 - ((band as f64 + 0.5) / bands as f64).powi(2)).sqrt()).round() * 1e-6;
        let first_m = (0.5 * (length_m - width_m)).rem_euclid(pitch_m);
        let starts = (0..1000).map(|number| first_m + pitch_m * f64::from(number));
        let ends = starts.map(|start_m| [start_m, start_m + width_m]).take_while(|ends_m| ends_m[1] <= length_m);
        Strip { band, width_m: 0.8e-3, length_m, cavities_m: ends.collect() }
    };
    face((0..bands).map(of_disc).collect())
}

/// Ratio at each load of `strips`, each solved whole on one lattice in the blocks of `scene`.
fn whole_strips(scene: &Scene, strips: &Face) -> Vec<f64> {
    let (block_m, rows, depth_m) = (scene.layer.block_m, scene.layer.rows(), scene.pattern.unwrap().depth_m());
    let model = |strip: &Strip| {
        let strip = without_slivers(strip.clone(), depth_m, block_m);
        let cavities: Vec<[f64; 2]> = strip.cavities_m.iter().map(|ends_m| ends_m.map(|at_m| at_m / block_m)).collect();
        let columns = columns::strip(strip.length_m / block_m, &cavities, depth_m / block_m);
        SteadyModel::for_scene(scene, Lattice::new(columns, rows, false))
    };
    // mu = sum k_s A_s mu_s / sum k_s A_s
    let friction = |models: &[SteadyModel]| -> Vec<f64> {
        let of = |model: &SteadyModel, strip: &Strip| model.stiffness_per_length() * strip.area_m2();
        let both = || models.iter().zip(strips.strips());
        let carried: f64 = both().map(|(model, strip)| of(model, strip)).sum();
        let area_m2: f64 = strips.strips().iter().map(Strip::area_m2).sum();
        let mut sums = vec![0.0; scene.loads.len()];
        for (model, strip) in both() {
            let solved = solve(scene, model, model.stiffness_per_length() * area_m2 / carried);
            let share = of(model, strip) / carried;
            sums.iter_mut().zip(solved).for_each(|(sum, surface)| *sum += share * surface.mu_dynamic.unwrap());
        }
        sums
    };
    let own: Vec<SteadyModel> = strips.strips().iter().map(model).collect();
    let bare = |strip: &Strip| model(&Strip { cavities_m: Vec::new(), ..strip.clone() });
    let flat: Vec<SteadyModel> = strips.strips().iter().map(bare).collect();
    friction(&own).iter().zip(friction(&flat)).map(|(own, flat)| own / flat).collect()
}

fn of_groove([width_um, spacing_um, depth_um, height_um]: [f64; 4]) -> Scene {
    let mut scene = scene(RunOptions::default());
    scene.pattern = Some(samples::groove(width_um, spacing_um, depth_um));
    scene.layer.height_m = height_um * 1e-6;
    scene
}

#[test]
fn strips_are_their_ends_and_cells_between_them() {
    for groove in [
        [130.0, 370.0, 20.0, 200.0],
        [60.0, 90.0, 10.0, 200.0],
        [200.0, 800.0, 50.0, 200.0],
        [130.0, 370.0, 20.0, 100.0],
    ] {
        let scene = of_groove(groove);
        let pattern = scene.pattern.unwrap();
        let strips = half_disc(&pattern, 1e4, 6);
        let found = steady_face_ratios(&scene, &pattern, &strips, &Unwatched).unwrap();
        for (found, whole) in found.iter().zip(whole_strips(&scene, &strips)) {
            assert!((found.unwrap() - whole).abs() < 2e-5, "{groove:?}: {found:?} {whole}");
        }
    }
}

/// Cavities that are not whole blocks: with the effect of quarter blocks on the cell, the ratio is closer to that of
/// whole strips in quarter blocks than that of whole strips in large blocks.
#[test]
#[ignore = "eighteen seconds: whole strips in quarter blocks"]
fn cells_between_ends_take_strips_to_smaller_blocks() {
    let (mut own, mut whole) = (0.0, 0.0);
    for groove in
        [[75.3, 167.1, 18.2, 100.0], [65.3, 73.0, 20.0, 60.0], [44.4, 51.7, 7.7, 100.0], [93.1, 108.9, 2.6, 100.0]]
    {
        let scene = of_groove(groove);
        let pattern = scene.pattern.unwrap();
        let mut fine = scene.clone();
        fine.layer.block_m *= 0.25;
        let strips = half_disc(&pattern, 5e3, 3);
        let cells = [&scene, &fine].map(|scene| SteadyCell::with_dimension(scene, Dimension::Plane).ratios(&pattern));
        let found = steady_face_ratios(&scene, &pattern, &strips, &Unwatched).unwrap();
        let (large, small) = (whole_strips(&scene, &strips), whole_strips(&fine, &strips));
        for load in 0..scene.loads.len() {
            let share = strips.cavity_share() / pattern.section_density();
            let shift = share * (cells[1][load].unwrap() - cells[0][load].unwrap());
            own += (found[load].unwrap() + shift - small[load]).powi(2);
            whole += (large[load] + shift - small[load]).powi(2);
        }
    }
    let [own, whole] = [own, whole].map(|sum: f64| (sum / 8.0).sqrt());
    assert!(own < 0.8 * whole && own < 2e-3, "{own} {whole}");
}

#[test]
fn strips_that_sample_a_face_are_corrected_to_its_share_of_cavities() {
    let scene = scene(RunOptions::default());
    let strips = vec![strip(0, 2e-3, 180e-6), strip(1, 1.8e-3, 80e-6)];
    let sampled = face(strips.clone());
    let more = Face::new(strips, 1.1 * sampled.cavity_share()).unwrap();
    let (own, found) = (ratios(&scene, &sampled), ratios(&scene, &more));
    for (own, found) in own.iter().zip(&found) {
        assert!(((1.0 - found) / (1.0 - own) - 1.1).abs() < 1e-9);
    }
    let statements = simulate_specimen(&scene, &sampled, &Unwatched).unwrap();
    let sampling = |load: &LoadOutcome| load.correction(Effect::Layout).unwrap().std.unwrap();
    assert!(statements.loads.iter().all(|load| sampling(load) > 0.0 && sampling(load) < 0.01));
}

#[test]
fn slender_walls_at_the_rim_bear_nothing() {
    let mut scene = scene(RunOptions::default());
    scene.pattern = Some(samples::groove(130.0, 370.0, 60.0));
    // 12 um of land, 60 um high, before the first cavity, and 8 um after the last.
    let slender =
        Strip { length_m: 2e-3, cavities_m: vec![[12e-6, 142e-6], [1.862e-3, 1.992e-3]], ..strip(0, 2e-3, 1.0) };
    let bare = Strip { cavities_m: vec![[0.0, 142e-6], [1.862e-3, 2e-3]], ..slender.clone() };
    assert_eq!(without_slivers(slender.clone(), 60e-6, 10e-6), bare);
    let share = 0.13;
    let ratios = |strip: Strip| ratios(&scene, &Face::new(vec![strip], share).unwrap());
    let (own, without) = (ratios(slender), ratios(bare));
    // Friction is unchanged; only the cavity fraction of the face differs.
    for (own, without) in own.iter().zip(&without) {
        assert!(((1.0 - own) * 260.0 / ((1.0 - without) * 280.0) - 1.0).abs() < 1e-9);
    }
    let wide = Strip { cavities_m: vec![[80e-6, 210e-6]], ..strip(0, 2e-3, 1.0) };
    assert_eq!(without_slivers(wide.clone(), 60e-6, 10e-6), wide);
}

/// The change from steady to dynamic sliding over the cavity fraction is the same on strips of other lengths and cavity
/// fractions within [`TIME_CHANGE_ERROR`], so that one dynamic strip represents all.
#[test]
#[ignore = "seventeen seconds: three strips in time, of which TIME_CHANGE_ERROR was found"]
fn strips_follow_the_longest_in_time() {
    let mut scene = scene(RunOptions { mu_stderr: Some(0.00015), ..in_time(6e-6) });
    scene.loads.remove(0);
    let strips = vec![strip(0, 2e-3, 180e-6), strip(1, 1.6e-3, 150e-6), strip(2, 0.9e-3, 180e-6)];
    let whole = face(strips.clone());
    let found = &simulate_specimen(&scene, &whole, &Unwatched).unwrap().loads[0];
    let alone = |strip: &Strip| {
        let lattices = timed_lattices(&scene, &scene.pattern.unwrap(), strip);
        let models = [OnceLock::new(), OnceLock::new()];
        let loads = run_all(&scene, &lattices, &models, &[0.0], &Unwatched).unwrap().loads;
        let steady = drawn_ratios(&scene, &lattices, &models, &Unwatched);
        loads[0].ratio().unwrap() - steady[0].unwrap()
    };
    let added: Vec<f64> = strips.iter().map(alone).collect();
    let over_share: Vec<f64> =
        added.iter().zip(&strips).map(|(added, strip)| added * strip.length_m / strip.cavity_length_m()).collect();
    assert!(over_share.iter().all(|own| (own / over_share[0] - 1.0).abs() < TIME_CHANGE_ERROR), "{over_share:?}");
    let area_m2: f64 = strips.iter().map(Strip::area_m2).sum();
    let all = added.iter().zip(&strips).map(|(added, strip)| added * strip.area_m2()).sum::<f64>() / area_m2;
    let steady =
        ratios(&Scene { run: RunOptions { fidelity: Fidelity::Steady, ..scene.run }, ..scene.clone() }, &whole);
    let distance = (found.ratio().unwrap() - (steady[0] + all)).abs();
    let std = |effect| found.correction(effect).unwrap().std.unwrap();
    let stated = std(Effect::Layout).hypot(std(Effect::Time));
    assert!(distance <= stated, "{distance} {stated}");
}

#[test]
fn a_run_in_time_is_the_steady_specimen_and_what_it_says_that_time_adds() {
    let mut scene = scene(RunOptions { refine: true, ..in_time(1e-6) });
    scene.layer.thickness_m = Some(3e-3);
    let whole = face(vec![strip(0, 2e-3, 180e-6), strip(1, 0.9e-3, 180e-6)]);
    let in_time = simulate_specimen(&scene, &whole, &Unwatched).unwrap();
    let alone = Scene { run: RunOptions { fidelity: Fidelity::Steady, ..scene.run }, ..scene.clone() };
    let steady = simulate_specimen(&alone, &whole, &Unwatched).unwrap();
    for (in_time, steady) in in_time.loads.iter().zip(&steady.loads) {
        let added = in_time.correction(Effect::Time).unwrap().change;
        assert!((in_time.ratio().unwrap() - steady.ratio().unwrap() - added).abs() < 1e-12 && added != 0.0);
        assert_eq!(steady.correction(Effect::Time), None);
        assert_eq!(steady.correction(Effect::Tilt), in_time.correction(Effect::Tilt));
    }
}

#[test]
fn lands_that_the_border_cuts_are_said_to_be_pressed_harder() {
    let mut scene = scene(in_time(1e-6));
    scene.loads.truncate(1);
    let found = |strips: Vec<Strip>| simulate_specimen(&scene, &face(strips), &Unwatched).unwrap();
    let warns = |found: &Simulation| says(found, "times that pressure");
    // The land between the two cavities of the shorter strip is a fifth as wide.
    let longest = strip(0, 2e-3, 180e-6);
    let cavities_m = vec![[300e-6, 430e-6], [470e-6, 600e-6]];
    let narrow = Strip { band: 1, length_m: 1.2e-3, cavities_m, ..longest.clone() };
    let (both, alone) = (found(vec![longest.clone(), narrow]), found(vec![longest]));
    assert!(warns(&both) && !warns(&alone), "{:?}", both.statements.model);
    assert_eq!(both.loads[0].surface.peak_pressure_pa, alone.loads[0].surface.peak_pressure_pa);
}
