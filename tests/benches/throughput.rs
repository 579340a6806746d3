//! Measures site updates per second of the dynamic solver: blocks times force evaluations over the time of additional
//! travel, so that the setup does not count. Pin it to one core (`taskset -c 1`) for the rate of one thread; unpinned
//! it also compares two threads on one sample with two simultaneous samples. Then it measures designs per second of the
//! steady cell, by the forces near the cavity and by all blocks, and the time of a table of designs.

#![allow(clippy::print_stdout)]

mod rates;

use std::time::Instant;

use rayon::prelude::*;
use slipgrid_model::pattern::{Pattern, Planform, Rim, RimProfile};
use slipgrid_model::springblock::{Extent, Fidelity, Scene, SteadyCell};
use slipgrid_tests::{polymer_scene, published, published_groove};

use rates::{median, site_updates_per_second};

/// `count` distinct grooves of no whole blocks on cells of 50 columns: 60 to 310 um wide, 2 to 30 um deep, on pitches of
/// 496 to 504 um, spread evenly by multiples of irrational numbers.
fn designs(count: usize) -> Vec<Pattern> {
    let spread = |number: usize, step: f64| (number as f64 * step).fract();
    (1..=count)
        .map(|number| {
            let width_m = (60.0 + 250.0 * spread(number, 0.819_172_513)) * 1e-6;
            let pitch_m = (496.0 + 8.0 * spread(number, 0.671_043_607)) * 1e-6;
            let depth_m = (2.0 + 28.0 * spread(number, 0.549_700_478)) * 1e-6;
            Pattern::new(Planform::Groove, width_m, pitch_m - width_m, depth_m).expect("valid lengths")
        })
        .collect()
}

/// Median of the designs solved per second.
fn designs_per_second(patterns: &[Pattern], solve: impl Fn(&[Pattern])) -> f64 {
    median(|| {
        let start = Instant::now();
        solve(patterns);
        patterns.len() as f64 / start.elapsed().as_secs_f64()
    })
}

/// Designs per second of the steady cell with four loads, and the time of a table.
fn designs_table(cores: usize, wanted: impl Fn(&str) -> bool) {
    let scene = polymer_scene(None, &[0.65, 1.3, 1.95, 2.6], Fidelity::Steady, Extent::Cell).expect("a valid scene");
    let model = SteadyCell::new(&scene);
    let pool = |count: usize| rayon::ThreadPoolBuilder::new().num_threads(count).build().expect("threads");
    println!("\n| steady cells, four loads | threads | designs per second |\n|---|---|---|");
    let (what, judge) = ("distinct designs of 50 columns, no whole blocks", "the same by all blocks");
    for threads in (1..=cores.min(2)).filter(|_| wanted(what)) {
        let (many, few) = (designs(4000), designs(200));
        let found = pool(threads).install(|| {
            let all_blocks = |patterns: &[Pattern]| {
                let solved: usize = patterns.par_iter().map(|pattern| model.solve_all_blocks(pattern).len()).sum();
                std::hint::black_box(solved);
            };
            let condensed = |patterns: &[Pattern]| {
                std::hint::black_box(model.ratios_of(patterns));
            };
            [designs_per_second(&many, condensed), designs_per_second(&few, all_blocks)]
        });
        println!("| {what} | {threads} | {:.0} |\n| {judge} | {threads} | {:.0} |", found[0], found[1]);
        let rim = Rim::new(0.3e-6, 20e-6, RimProfile::Round).expect("a rim");
        let rimmed: Vec<Pattern> = many.iter().map(|pattern| pattern.with_rim(rim)).collect();
        let with_rims = pool(threads).install(|| {
            designs_per_second(&rimmed, |patterns| {
                std::hint::black_box(model.ratios_of(patterns));
            })
        });
        println!("| the same with round rims 0.3 um high and 20 um wide | {threads} | {with_rims:.0} |");
    }
    for height_um in [0.0, 0.1, 0.3, 1.0].into_iter().filter(|_| wanted("squares in space")) {
        let rim = Rim::new(height_um * 1e-6, 20e-6, RimProfile::Flat).expect("a rim");
        let squares =
            published(Planform::Square).expect("valid lengths").with_rim(Some(rim).filter(|_| height_um > 0.0));
        let cell = SteadyCell::of_texture(&scene, squares.texture());
        let found = pool(1).install(|| {
            designs_per_second(&[squares], |patterns| {
                std::hint::black_box(cell.ratios(&patterns[0]));
            })
        });
        println!("| squares in space, 50 x 50 x 20 blocks, rims {height_um} um high and 20 um wide | 1 | {found:.1} |");
    }
    if wanted("fine squares in space") {
        let mut fine = scene.clone();
        fine.layer.block_m = 2.5e-6;
        let squares = published(Planform::Square).expect("valid lengths");
        let cell = SteadyCell::of_texture(&fine, squares.texture());
        let found = pool(1).install(|| {
            designs_per_second(&[squares], |patterns| {
                std::hint::black_box(cell.ratios(&patterns[0]));
            })
        });
        println!("| fine squares in space, 200 x 200 x 80 blocks | 1 | {found:.2} |");
    }
    if wanted("table") {
        let start = Instant::now();
        // Grooves of whole blocks: widths, spacings and depths in 10 um.
        let sizes = (4..=40)
            .flat_map(|width| (4..=100).flat_map(move |spacing| (1..=5).map(move |depth| [width, spacing, depth])));
        let groove = |size: [u32; 3]| {
            let [width_m, spacing_m, depth_m] = size.map(|blocks| f64::from(blocks) * 10e-6);
            Pattern::new(Planform::Groove, width_m, spacing_m, depth_m).expect("valid lengths")
        };
        let designs: Vec<Pattern> = sizes.map(groove).collect();
        let table = pool(cores).install(|| model.ratios_of(&designs));
        let seconds = start.elapsed().as_secs_f64();
        println!(
            "| table of {} designs: {seconds:.1} s | {cores} | {:.0} |",
            table.len(),
            table.len() as f64 / seconds
        );
    }
}

fn main() {
    let scene = |patterned: bool, extent: Extent, law: bool| {
        let pattern = patterned.then(|| published_groove().expect("valid lengths"));
        let mut scene = polymer_scene(pattern, &[2.6], Fidelity::Dynamic, extent).expect("a valid scene");
        scene.run.warm_start = true;
        if !law {
            scene.area_law = None;
        }
        scene
    };
    let threads = |count: usize| rayon::ThreadPoolBuilder::new().num_threads(count).build().expect("threads");
    let cell = |mut scene: Scene| {
        scene.layer.length_m = 500e-6;
        scene
    };
    println!("| scene | threads | site updates per second |\n|---|---|---|");
    // Arguments choose the rows that hold one of them; cargo adds `--bench`.
    let wanted: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let wanted = |what: &str| wanted.is_empty() || wanted.iter().any(|part| what.contains(part));
    let row = |what: &str, count: usize, scene: &Scene, travel_m: f64| {
        if !wanted(what) {
            return;
        }
        let found = threads(count).install(|| site_updates_per_second(scene, travel_m));
        println!("| {what} | {count} | {found:.2e} |");
    };
    row("flat sample, 996 x 20", 1, &scene(false, Extent::Sample, true), 0.05e-6);
    row("the same without area law", 1, &scene(false, Extent::Sample, false), 0.05e-6);
    row("sample of grooves 130/370/20 um with its flat one", 1, &scene(true, Extent::Sample, true), 0.03e-6);
    row("flat cell, 50 x 20", 1, &cell(scene(false, Extent::Cell, true)), 1e-6);
    row("cell of grooves 130/370/20 um with its flat one", 1, &cell(scene(true, Extent::Cell, true)), 0.5e-6);
    let mut squares = scene(true, Extent::Cell, true);
    squares.pattern = Some(published(Planform::Square).expect("valid lengths"));
    row("cell of squares 130/370/20 um in space, 50 x 50 x 20, with its flat one", 1, &squares, 0.02e-6);
    let mut reference = scene(false, Extent::Sample, true);
    reference.run.fidelity = Fidelity::Reference;
    row("flat sample by the reference integration", 1, &reference, 0.002e-6);
    if std::thread::available_parallelism().is_ok_and(|cores| cores.get() > 1) {
        row("flat sample, 996 x 20", 2, &scene(false, Extent::Sample, true), 0.05e-6);
        let mut two = scene(false, Extent::Sample, true);
        two.loads.push(two.loads[0]);
        row("two flat samples at once", 2, &two, 0.05e-6);
    }
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    designs_table(cores, wanted);
}
