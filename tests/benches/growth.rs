//! Growth of the cost of each part with its size, on one thread: seconds at doubling sizes, and the exponent of the
//! power law fitted to the last three by least squares.
//!
//! `cargo bench -p slipgrid-tests --bench growth` (two minutes). Medians of three.

#![allow(clippy::print_stdout)]

use std::hint::black_box;
use std::time::Instant;

use slipgrid_infer::discrepancy::{
    Conditions, Discrepancy, Features, Hyperparameters, Load, Measured, Sensitivity, Trial,
};
use slipgrid_laser::export::{Heading, Outline, Specimen, dxf};
use slipgrid_model::pattern::{Pattern, Planform};
use slipgrid_model::springblock::{Extent, Fidelity, Scene, SteadyCell, Unwatched, simulate};
use slipgrid_surface::contact::{SolveOptions, area_curve};
use slipgrid_surface::topography::SelfAffine;
use slipgrid_tests::polymer_scene;

/// Number of repetitions for the median.
const REPETITIONS: usize = 3;
/// Number of sizes for the fit of the exponent.
const FITTED: usize = 3;
/// Pressures of a cell or a run, in MPa.
const PRESSURES_MPA: [f64; 4] = [0.65, 1.3, 1.95, 2.6];

/// Median seconds of `work`.
fn seconds(work: &mut dyn FnMut()) -> f64 {
    let mut found: Vec<f64> = (0..REPETITIONS)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64()
        })
        .collect();
    found.sort_by(f64::total_cmp);
    found[REPETITIONS / 2]
}

/// Slope of ln t over ln n through the last sizes.
fn exponent(points: &[(f64, f64)]) -> f64 {
    let last = &points[points.len() - FITTED..];
    let mean = |of: fn(&(f64, f64)) -> f64| last.iter().map(|point| of(point).ln()).sum::<f64>() / FITTED as f64;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let sum = |of: &dyn Fn(f64, f64) -> f64| last.iter().map(|(n, t)| of(n.ln() - x, t.ln() - y)).sum::<f64>();
    sum(&|dx, dy| dx * dy) / sum(&|dx, _| dx * dx)
}

/// A row of the table: `work` at each of `sizes`.
fn row(what: &str, unit: &str, sizes: &[usize], mut work: impl FnMut(usize) -> Box<dyn FnMut()>) {
    let points: Vec<(f64, f64)> = sizes.iter().map(|size| (*size as f64, seconds(&mut *work(*size)))).collect();
    let (first, last) = (points[0], points[points.len() - 1]);
    println!(
        "| {what} | {} to {} {unit} | {:.2} to {:.0} ms | {:.2} |",
        first.0,
        last.0,
        1e3 * first.1,
        1e3 * last.1,
        exponent(&points)
    );
}

/// Groove or square on a third of a period of `columns` blocks, two rows deep.
fn pattern(planform: Planform, columns: usize) -> Pattern {
    let pitch_m = columns as f64 * 10e-6;
    let width_m = (columns as f64 / 3.0).round() * 10e-6;
    Pattern::new(planform, width_m, pitch_m - width_m, 20e-6).expect("valid lengths")
}

fn scene(extent: Extent, fidelity: Fidelity) -> Scene {
    polymer_scene(None, &PRESSURES_MPA, fidelity, extent).expect("a valid scene")
}

fn cells() {
    let model = SteadyCell::new(&scene(Extent::Cell, Fidelity::Steady));
    let grooves = |columns: usize| pattern(Planform::Groove, columns);
    row("steady cell in the plane, by the forces about the cavity", "columns", &[50, 100, 200, 400, 800], |columns| {
        let (model, design) = (model.clone(), grooves(columns));
        Box::new(move || drop(black_box(model.solve(&design))))
    });
    row("the same by all blocks, 20 rows", "columns", &[50, 100, 200, 400, 800], |columns| {
        let (model, design) = (model.clone(), grooves(columns));
        Box::new(move || drop(black_box(model.solve_all_blocks(&design))))
    });
    let square = pattern(Planform::Square, 25);
    let space = SteadyCell::of_texture(&scene(Extent::Cell, Fidelity::Steady), square.texture());
    row("steady cell in space, n x n columns, 20 rows", "n", &[12, 25, 50, 100, 200], |columns| {
        let (model, design) = (space.clone(), pattern(Planform::Square, columns));
        Box::new(move || drop(black_box(model.solve(&design))))
    });
    row("designs of a table", "designs", &[100, 200, 400, 800], |count| {
        let model = model.clone();
        let designs: Vec<Pattern> = (0..count).map(|number| grooves(40 + number % 20)).collect();
        Box::new(move || drop(black_box(model.ratios_of(&designs))))
    });
}

fn runs() {
    let run = |columns: usize, rows: usize, planform: Planform| {
        let extent = if planform == Planform::Groove { Extent::Sample } else { Extent::Cell };
        let mut scene = scene(extent, Fidelity::Dynamic);
        scene.loads.truncate(1);
        let period = if planform == Planform::Groove { 50 } else { columns };
        scene.pattern = Some(pattern(planform, period));
        scene.layer.length_m = columns as f64 * scene.layer.block_m;
        scene.layer.height_m = rows as f64 * scene.layer.block_m;
        scene.layer.thickness_m = None;
        scene.run.warm_start = true;
        scene.run.sliding_m = 5e-9;
        scene
    };
    let work = |scene: Scene| -> Box<dyn FnMut()> { Box::new(move || drop(black_box(simulate(&scene, &Unwatched)))) };
    row("run in time in the plane, 20 rows, 5 nm", "columns", &[500, 1000, 2000, 4000], |columns| {
        work(run(columns, 20, Planform::Groove))
    });
    row("run in time in space, n x n columns, 20 rows, 5 nm", "n", &[12, 24, 48], |columns| {
        work(run(columns, 20, Planform::Square))
    });
}

fn contact() {
    row(
        "contact area at one pressure, n x n pixels",
        "n",
        &[32, 64, 128, 256, 512, 1024, 2048, 4096, 8192],
        |pixels| {
            let max_wave = SelfAffine::STAND_IN.max_wave.min(pixels as u32 / 2 - 1);
            let map = SelfAffine { pixels, max_wave, ..SelfAffine::STAND_IN }.map().expect("a map");
            let options = SolveOptions { tolerance: 1e-6, ..SolveOptions::default() };
            Box::new(move || drop(black_box(area_curve(&map, 0.43e9, &[1.3e6], &options, &Unwatched))))
        },
    );
}

fn cavities() {
    row("drawing of squares", "thousand cavities", &[10, 20, 40, 80], |thousands| {
        let side_m = 1e-2;
        let pitch_m = side_m / (1e3 * thousands as f64).sqrt();
        let design = Pattern::new(Planform::Square, 0.4 * pitch_m, 0.6 * pitch_m, 5e-6).expect("valid lengths");
        let outline = Outline::Rectangle { length_m: side_m, width_m: side_m };
        let layout = Specimen { outline, is_clipped: false }.layout(design).expect("a layout");
        let heading = Heading { name: "growth", version: "0", notes: &[] };
        Box::new(move || dxf(&layout, &heading, &mut std::io::sink()).expect("written"))
    });
}

fn trials() {
    let loads = PRESSURES_MPA.map(|mpa| Load { pressure_pa: mpa * 1e6, speed_m_s: 2e-3, humidity: 0.15 });
    let sample = |number: usize| {
        let design = pattern(Planform::Groove, 20 + 3 * number);
        let measured = loads.iter().enumerate().map(|(place, load)| Measured {
            load: *load,
            measured: 0.8 - 0.02 * place as f64,
            modelled: 0.9 - 0.03 * place as f64,
            patterned_std: 0.01,
            flat_std: 0.01,
            sensitivity: Sensitivity::of_modulus(0.1 + 0.02 * place as f64),
        });
        Trial {
            name: number.to_string(),
            features: Features::from(&design),
            sample_std: None,
            disc: None,
            measured: measured.collect(),
            dimensions_std_m: [0.0; 3],
            dimension_shifts: Vec::new(),
        }
    };
    row("learning from trials of four loads", "trials", &[4, 8, 16, 32], |count| {
        let all: Vec<Trial> = (0..count).map(sample).collect();
        Box::new(move || {
            let known = Discrepancy::new(Hyperparameters::default(), Conditions::default(), 0.2, all.clone());
            let predictor = known.expect("valid trials").at(&loads);
            black_box(
                predictor.predict(&Features::from(&pattern(Planform::Groove, 33)), &[Sensitivity::of_modulus(0.1); 4]),
            );
        })
    });
}

fn main() {
    println!("| what | sizes | time | exponent |\n|---|---|---|---|");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    pool.install(|| {
        cells();
        runs();
        contact();
        cavities();
        trials();
    });
}
