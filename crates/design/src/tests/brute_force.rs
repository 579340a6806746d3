//! Brute-force checks of predicted chances against samples drawn and solved one by one.

use crate::optimize::DesignSpace;
use slipgrid_base::statistics::cholesky::covariance_factor;
use slipgrid_base::statistics::{Normals, normal_probability};
use slipgrid_infer::discrepancy::{Candidate, Features, Scenarios, Sensitivity};
use slipgrid_model::pattern::{Pattern, Planform};
use slipgrid_model::springblock::Layer;

use super::{contradicted, near, random, searched, steady, taught, three_tasks, trial};
use crate::prediction::Prediction;
use crate::search::Search;
use crate::slopes::slopes;

/// Share of `count` samples of a texture on target, each drawn and solved separately, and the predicted chance.
fn drawn(search: &Search<'_>, lengths_m: [f64; 3], count: u32) -> (f64, f64) {
    let pattern = search.task.space.pattern(lengths_m).unwrap();
    let found = search.solved(&pattern).unwrap();
    let (model, n) = (search.models.own, search.asked.loads.len());
    let laid = model.lay(&pattern).unwrap();
    let designed = model.steady(&pattern).unwrap().ratio;
    let std_m = search.task.tolerances.unwrap_or_default().std_m();
    let factor = covariance_factor(&found.texture.covariance, n);
    let mut normals = Normals::new(3);
    let mut hits = 0;
    for _ in 0..count {
        let [w, s, d] = pattern.lengths_m();
        let [width, spacing, depth] = std_m.map(|std_m| std_m * normals.draw());
        let made = Pattern::new(*pattern.texture(), w + width, s + spacing, d + depth).unwrap();
        // Model of the sample as made, with the discrepancy and the local law of the texture as made.
        let ratio = model.ratios_made(&made, &laid).unwrap();
        let designed_for = found.texture.sensitivity.iter();
        let own = search.models.at(&made).unwrap().0.sensitivity.into_iter().zip(designed_for);
        let own: Vec<Sensitivity> =
            own.map(|(made, designed)| Sensitivity { modulus: designed.modulus, ..made }).collect();
        let features = Features::on_face(&made, laid.share(&made));
        let lacking = search.predictor.predict(&features, &own);
        let which = normals.draw();
        let mut deviates = || -> Vec<f64> { (0..n).map(|_| normals.draw()).collect() };
        let (z, shared) = (deviates(), deviates());
        let lacks = lacking.draw(which, &z);
        let value = |load: usize| {
            let off: f64 = factor[load * n..=load * n + load].iter().zip(&shared).map(|(l, z)| l * z).sum();
            found.texture.ratio[load] * ratio[load] / designed[load] * (lacks[load] + off).exp()
        };
        hits += u32::from(search.asked.accepts(&(0..n).map(value).collect::<Vec<f64>>()));
    }
    (f64::from(hits) / f64::from(count), found.chance())
}

/// Tests samples that follow the area law, and samples that follow either law: lambda is drawn with all other inputs, and
/// each sample follows it by the change of its own texture.
#[test]
fn a_chance_is_the_share_of_samples_that_are_drawn_and_solved_one_by_one() {
    let task = &three_tasks()[1];
    for task in [task.clone(), contradicted(task)] {
        let (share, chance) = searched(&task, |search| drawn(search, [100e-6, 300e-6, 12e-6], 500));
        let stderr = (chance * (1.0 - chance) / 500.0).sqrt();
        assert!((share - chance).abs() < 2.5 * stderr, "{share} {chance} +- {stderr}");
    }
}

/// Tests grooves and squares, without and with trials, near and far from the trials. The remaining difference arises
/// because errors of dimensions move the discrepancy to first order only.
#[test]
#[expect(clippy::print_stdout, reason = "a table for people")]
#[ignore = "some minutes: twelve textures, 4000 samples of each solved one by one"]
fn chances_of_many_textures_are_the_shares_of_samples() {
    let mut squares = three_tasks()[1].clone();
    squares.space = DesignSpace::new(Planform::Square, [60e-6, 300e-6], [100e-6, 700e-6], [5e-6, 30e-6]).unwrap();
    squares.layer = Layer { height_m: 40e-6, ..squares.layer };
    let mut worst: f64 = 0.0;
    for (task, count) in three_tasks().into_iter().map(|task| (task, 4000)).chain([(squares, 800)]) {
        searched(&task, |search| {
            for lengths_m in [[100e-6, 300e-6, 12e-6], [80e-6, 500e-6, 8e-6], [200e-6, 650e-6, 20e-6]] {
                let (share, chance) = drawn(search, lengths_m, count);
                let stderr = (chance * (1.0 - chance) / f64::from(count)).sqrt().max(1e-3);
                println!(
                    "{:?} {lengths_m:?}: {chance:.3} said, {share:.3} drawn",
                    search.task.space.texture().planform()
                );
                worst = worst.max((share - chance).abs() - 2.0 * stderr);
            }
        });
    }
    assert!(worst < 0.01, "{worst}");
}

/// Draws truths from the prior, cuts one trial of each, designs by it, and counts how often the sample of the texture
/// that was found is truly on target: as often as was said, in every bin of the chance.
#[test]
#[expect(clippy::print_stdout, reason = "a table for people")]
#[ignore = "some minutes: 600 truths, each with a search of its own"]
fn chances_come_true_of_truths_that_are_drawn_from_the_prior() {
    const TRUTHS: usize = 600;
    let mut base = three_tasks()[0].clone();
    let targets = [0.80, 0.87, 0.93].map(|value| near(value, 0.1));
    let prior = base.material.as_ref().unwrap().uncertainty.learned.clone().unwrap();
    let truths = Scenarios::new(&prior, TRUTHS, 5);
    let cut_m = [100e-6, 300e-6, 10e-6];
    let of_trial = searched(&base, |search| {
        let found = search.solved(&search.task.space.pattern(cut_m).unwrap()).unwrap();
        // The trial's dimensions are those that were measured, and its scatter is that of samples.
        let exact = Candidate { covariance: &[], dimension_shifts: &[], ..found.texture.candidate() };
        truths.log_excesses(&exact, &search.asked.loads, 0)
    });
    let modelled = steady(&base, cut_m);
    let mut normals = Normals::new(8);
    // Sum of chances, samples on target, and truths, in each bin.
    let mut bins = [(0.0, 0_u32, 0_u32); 5];
    for (number, excess) in of_trial.iter().enumerate() {
        base.target = targets[number % targets.len()].clone();
        let noise_std = 0.005_f64.hypot(0.005);
        let measured = [0, 1].map(|load| modelled[load] * (excess[load] + noise_std * normals.draw()).exp());
        let task = taught(&base, vec![trial(&base, cut_m, measured)]);
        let (chance, is_on) = searched(&task, |search| {
            let best = search.best(&|_| true, 1).solved.remove(0);
            let on = truths.on_target(&best.texture.candidate(), &search.asked.loads, &search.asked.wanted, 1);
            (best.chance(), on[number])
        });
        let bin = &mut bins[((5.0 * chance) as usize).min(4)];
        *bin = (bin.0 + chance, bin.1 + u32::from(is_on), bin.2 + 1);
    }
    for (place, (sum, on, count)) in bins.into_iter().enumerate().filter(|(_, bin)| bin.2 > 0) {
        let [said, share] = [sum, f64::from(on)].map(|sum| sum / f64::from(count));
        let stderr = (said * (1.0 - said) / f64::from(count)).sqrt();
        println!("bin {place}: {count} truths, {said:.3} said, {share:.3} on target +- {stderr:.3}");
        assert!((share - said).abs() < 0.05_f64.max(2.5 * stderr), "{said} {share} +- {stderr}");
    }
}

#[test]
#[expect(clippy::print_stdout, reason = "a table for people")]
#[ignore = "some minutes: ten targets, each beside 3000 random textures"]
fn no_texture_of_thousands_has_a_clearly_greater_chance() {
    let base = three_tasks();
    let mut normals = Normals::new(11);
    let mut better = Vec::new();
    for number in 0..10 {
        let mut task = base[number % 3].clone();
        let value = 0.75 + 0.2 * normal_probability(normals.draw());
        task.target = near(value, 0.02 + 0.01 * (number % 4) as f64);
        searched(&task, |search| {
            let best = search.best(&|_| true, 1).solved.remove(0);
            let mut greatest: f64 = 0.0;
            for _ in 0..3000 {
                let pattern = random(&task, &mut normals);
                if search.roughly(&pattern).is_some_and(|found| found.chance() > best.chance() - 0.01)
                    && let Ok(found) = search.solved(&pattern)
                {
                    // The found texture has its own ends and tilt; so must one that is said to be better.
                    let is_greater = found.chance() > best.chance() + 0.01;
                    let chance = if is_greater { search.as_cut(&found).chance() } else { found.chance() };
                    if is_greater {
                        println!("{:?}: {:.3}, {chance:.3} as cut", pattern.lengths_m(), found.chance());
                    }
                    greatest = greatest.max(chance);
                }
            }
            println!("{value:.3}: {:.3} found, {greatest:.3} the best of 3000", best.chance());
            if greatest > best.chance() + 0.01 {
                better.push((value, best.chance(), greatest));
            }
        });
    }
    assert!(better.is_empty(), "{better:?}");
}

/// Tests that a sample off its design has the discrepancy of the texture as made: trials change it more than the model
/// does.
#[test]
fn a_slope_follows_what_is_lacking_to_both_sides() {
    for task in &three_tasks()[1..] {
        searched(task, |search| {
            let lengths_m = [100e-6, 500e-6, 12e-6];
            let steps_m = [search.task.layer.block_m, search.task.layer.block_m, 0.2 * lengths_m[2]];
            let pattern = |lengths_m: [f64; 3]| search.task.space.pattern(lengths_m).unwrap();
            let found = search.solved(&pattern(lengths_m)).unwrap();
            let model = search.models.own;
            let laid = model.lay(&found.texture.pattern).unwrap();
            let designed = model.ratios_made(&found.texture.pattern, &laid).unwrap();
            for (axis, slope) in slopes(search, &found).iter().enumerate() {
                let beside = |side: f64| -> Vec<f64> {
                    let mut beside_m = lengths_m;
                    beside_m[axis] += side * steps_m[axis];
                    let made = pattern(beside_m);
                    // As many cavities as the design, whose share of the face those of a design beside it may miss.
                    let mut own = search.solved(&made).unwrap().texture;
                    let features = Features::on_face(&made, laid.share(&made));
                    let shifts = own.dimension_shifts.iter().map(|shift| shift.about(&own.features, &features));
                    (own.dimension_shifts, own.features) = (shifts.collect(), features);
                    let own = Prediction::new(own, &search.predictor, search.asked);
                    let ratios = model.ratios_made(&made, &laid).unwrap();
                    let lacking =
                        own.medians().into_iter().zip(&own.texture.ratio).map(|(median, ratio)| median / ratio);
                    let own = ratios.iter().zip(&designed).zip(&found.texture.ratio);
                    own.zip(lacking)
                        .map(|(((made, designed), ratio), lacking)| ratio * made / designed * lacking)
                        .collect()
                };
                let (above, below) = (beside(1.0), beside(-1.0));
                for (load, per_um) in slope.per_um.iter().enumerate() {
                    let expected = (above[load] - below[load]) / (2e6 * steps_m[axis]);
                    assert!((per_um - expected).abs() < 0.1 * expected.abs() + 2e-5, "{slope:?} {load} {expected}");
                }
            }
        });
    }
}
