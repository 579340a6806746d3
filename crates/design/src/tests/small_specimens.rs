//! Specimens of few periods: areal density and effects of the ends jump from one texture to the next.

use super::*;
use crate::inputs::{made, of_dimensions};
use crate::prediction::Prediction;
use crate::steps::Steps;

/// Task on a disc of 2 mm in blocks of 20 um, with whole bursts.
fn small(planform: Planform, target: Target) -> DesignTask {
    let mut task = task(planform);
    task.constraints.limits.depth_per_burst_m = Some(2.6e-6);
    task.specimen.outline = Outline::Disc { diameter_m: 2e-3 };
    let height_m = if planform == Planform::Groove { 100e-6 } else { 40e-6 };
    task.layer = Layer { length_m: 2e-3, height_m, ..task.layer };
    task.target = target;
    let trials = vec![trial(&task, [100e-6, 300e-6, 10.4e-6], [0.85, 0.83])];
    taught(&task, trials)
}

#[test]
fn the_table_has_the_areal_density_of_every_texture() {
    let mut task = small(Planform::Groove, near(0.87, 0.03));
    task.tolerances =
        Some(Tolerances { width_std_um: 4.0, spacing_std_um: 6.0, depth_std_um: 0.8, ..Tolerances::default() });
    searched(&task, |search| {
        let (mut normals, model) = (Normals::new(5), search.models.own);
        let (mut worst, mut off_slope): (f64, f64) = (0.0, 0.0);
        for _ in 0..40 {
            let pattern = random(&task, &mut normals);
            let laid = model.lay(&pattern).unwrap();
            let Some((table, _)) = search.table.at(&pattern, &laid) else { continue };
            let exact = model.steady(&pattern).unwrap().ratio;
            let each = table.log_ratio.iter().zip(&exact).map(|(log, exact)| (log - exact.ln()).abs());
            worst = each.fold(worst, f64::max);
            // A sample whose dimensions are off has as many cavities as the design.
            let shifts = search.table.dimension_shifts(&pattern, &laid, &task.tolerances.unwrap()).unwrap();
            for (shift, (_, by_m)) in shifts.iter().zip(of_dimensions(&task.tolerances.unwrap())) {
                let [above, below] =
                    [1.0, -1.0].map(|side| model.ratios_made(&made(&pattern, &by_m, side), &laid).unwrap());
                for (load, log) in shift.log_ratio.iter().enumerate() {
                    off_slope = off_slope.max((log - 0.5 * (above[load] / below[load]).ln()).abs());
                }
            }
        }
        assert!(worst < 0.01 && off_slope < 3e-3, "{worst} {off_slope}");
    });
}

/// The explorer interpolates between nodes, with the cavity fraction of every texture.
#[test]
fn an_explorer_says_what_the_search_does_of_every_texture() {
    let grooves = task(Planform::Groove);
    let cut = trial(&grooves, [100e-6, 300e-6, 10.4e-6], [0.85, 0.83]);
    let large = taught(&DesignTask { target: near(0.87, 0.03), ..grooves }, vec![cut]);
    // A chance that falls by half within a node's distance of the trial.
    let mut squares = task(Planform::Square);
    squares.space = DesignSpace::new(Planform::Square, [40e-6, 200e-6], [100e-6, 600e-6], [2e-6, 50e-6]).unwrap();
    squares.layer.height_m = 40e-6;
    let cut = trial(&squares, [130e-6, 420e-6, 5.2e-6], [0.87, 0.85]);
    let squares = taught(&DesignTask { target: near(0.85, 0.04), ..squares }, vec![cut]);
    for task in [small(Planform::Groove, near(0.87, 0.03)), large, small(Planform::Square, near(0.92, 0.03)), squares] {
        searched(&task, |search| {
            let best = search.greatest(&|_| true).0.unwrap();
            let explorer = Explorer::new(search, &best, None).unwrap();
            let (mut normals, off) = (Normals::new(11), search.off_at(&best));
            let (mut of_median, mut of_chance) = (Vec::new(), Vec::new());
            for place in 0..120 {
                let beside = |normals: &mut Normals| {
                    let lengths = task.space.lengths_m().into_iter().zip(best.texture.pattern.lengths_m());
                    let moved =
                        |([low, high], own): ([f64; 2], f64)| (own * (0.2 * normals.draw()).exp()).clamp(low, high);
                    let moved: Vec<f64> = lengths.map(moved).collect();
                    task.space.pattern(moved.try_into().unwrap()).unwrap()
                };
                let pattern = if place % 2 == 0 { random(&task, &mut normals) } else { beside(&mut normals) };
                let laid = search.table.lay(&pattern).unwrap();
                let found = search.roughly_with((&pattern, &laid), &off, &best.texture.covariance, 1.0);
                let Some(found) = found else { continue };
                let (expected, chance) = explorer.sample(&task.specimen.layout(pattern).unwrap());
                let each = found.medians().into_iter().zip(&expected).map(|(exact, own)| (exact - own).abs());
                of_median.push(each.fold(0.0, f64::max));
                of_chance.push((chance - found.chance()).abs());
            }
            let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
            let worst = |of: &[f64]| of.iter().copied().fold(0.0, f64::max);
            let numbers = [mean(&of_median), worst(&of_median), mean(&of_chance), worst(&of_chance)];
            let is_near = numbers.iter().zip([5e-4, 3e-3, 0.016, 0.1]).all(|(own, most)| *own < most);
            assert!(is_near && of_median.len() > 80, "{numbers:?} {:?}", explorer.shares);
        });
    }
}

/// Solves those textures of the grid as cut that are nearly the likeliest by the table.
#[test]
#[expect(clippy::print_stdout, reason = "a table for people")]
#[ignore = "some minutes: eight targets, hundreds of textures solved as cut for each"]
fn no_texture_of_the_grid_is_clearly_likelier() {
    let at_most = |highest: f64| {
        let wanted = Accepted::AtMost { highest, margin: 0.01 };
        let demands = [1.3e6, 2.6e6].map(|pressure_pa| Demand { pressure_pa, wanted, weight: 1.0 });
        Target::of(Quantity::Ratio, demands.to_vec(), None).unwrap()
    };
    let mut tasks: Vec<DesignTask> =
        [0.8, 0.87, 0.92, 0.95].map(|value| small(Planform::Groove, near(value, 0.03))).into();
    for highest in [0.7, 0.75, 0.8] {
        let mut free = task(Planform::Groove);
        free.space = DesignSpace::new(Planform::Groove, [40e-6, 120e-6], [40e-6, 400e-6], [2e-6, 10e-6]).unwrap();
        free.specimen.outline = Outline::Disc { diameter_m: 2e-3 };
        free.target = at_most(highest);
        tasks.push(free);
    }
    tasks.push(small(Planform::Square, near(0.92, 0.03)));
    let mut worst: f64 = 0.0;
    for task in tasks {
        searched(&task, |search| {
            let found = search.best(&|_| true, 1).solved;
            let best = &found[0];
            let all = Steps::new(&task).spread(usize::MAX);
            let mut all: Vec<Prediction> = all.iter().filter_map(|pattern| search.roughly(pattern)).collect();
            all.sort_by(|a, b| b.value().total_cmp(&a.value()));
            let solved = all.iter().take(200).filter_map(|of| search.solved(&of.texture.pattern).ok());
            let cut: Vec<Prediction> = solved.map(|of| search.as_cut(&of)).collect();
            let likeliest = cut.iter().reduce(|a, b| if b.value() > a.value() { b } else { a }).unwrap();
            let runs = found.iter().filter(|of| of.texture.known == crate::as_cut::Known::AsCut).count();
            let um = |of: &Prediction| of.texture.pattern.lengths_m().map(|m| (1e7 * m).round() / 10.0);
            println!(
                "{:.4} found at {:?} by {runs} runs, {:.4} at {:?}",
                best.value(),
                um(best),
                likeliest.value(),
                um(likeliest)
            );
            worst = worst.max(likeliest.value() - best.value());
        });
    }
    assert!(worst < 0.01, "{worst}");
}
