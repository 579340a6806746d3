//! Grooves across the sliding direction by both lattices: the vertical plane, and space with one row of blocks.

use std::time::Instant;

use rayon::prelude::*;
use slipgrid_base::statistics::median;
use slipgrid_model::pattern::{Pattern, Planform};
use slipgrid_model::springblock::{Extent, Fidelity, SteadyCell};
use slipgrid_tests::polymer_scene;

/// Cell of the published polymer under four loads, solved in so many `dimensions`.
fn cell(dimensions: u8) -> SteadyCell {
    let mut scene = polymer_scene(None, &[0.65, 1.3, 1.95, 2.6], Fidelity::Steady, Extent::Cell).unwrap();
    scene.run.dimensions = Some(dimensions);
    SteadyCell::new(&scene)
}

/// Grooves whose lengths cover the bounds of a design, by a sequence of low discrepancy.
fn grooves(count: u32) -> Vec<Pattern> {
    let groove = |n: u32| {
        let [width, spacing, depth] =
            [0.754_877_666, 0.569_840_291, 0.430_159_709].map(|step| f64::from(n) * step % 1.0);
        let of = |[from, to]: [f64; 2], share: f64| from * (to / from).powf(share) * 1e-6;
        let lengths_m = [of([40.0, 400.0], width), of([40.0, 1000.0], spacing), of([2.0, 50.0], depth)];
        Pattern::new(Planform::Groove, lengths_m[0], lengths_m[1], lengths_m[2]).unwrap()
    };
    (1..=count).map(groove).collect()
}

/// Greatest difference of the ratios of `patterns` by both lattices.
fn greatest_difference(patterns: &[Pattern]) -> f64 {
    let [plane, space] = [2, 3].map(cell);
    let of = |pattern: &Pattern| {
        let [plane, space] = [&plane, &space].map(|cell| cell.ratios(pattern));
        let off = plane.into_iter().zip(space).map(|(plane, space)| (plane.unwrap() - space.unwrap()).abs());
        off.fold(0.0, f64::max)
    };
    patterns.par_iter().map(of).reduce(|| 0.0, f64::max)
}

#[test]
fn both_lattices_give_one_ratio() {
    let most = greatest_difference(&grooves(40));
    assert!(most < 1e-8, "{most}");
}

#[test]
#[ignore = "half a minute: what a groove costs by either lattice"]
fn both_lattices_take_their_time() {
    let patterns = grooves(400);
    println!("greatest difference of 400 ratios: {:.1e}", greatest_difference(&patterns));
    for (name, dimensions) in [("plane", 2), ("space, one row", 3)] {
        let cell = cell(dimensions);
        let time = |pattern: &Pattern| {
            let begun = Instant::now();
            assert!(cell.ratios(pattern).iter().all(Option::is_some));
            1e3 * begun.elapsed().as_secs_f64()
        };
        let mut each_ms: Vec<f64> = patterns.iter().map(time).collect();
        println!("{name}: {:.2} ms a groove and four loads, median of 400", median(&mut each_ms).unwrap());
    }
}
