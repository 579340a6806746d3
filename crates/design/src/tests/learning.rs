//! The disc of two sectors that teaches most.

use super::*;

fn learn(task: &DesignTask, threads: usize) -> Result<crate::NextTrials, DesignError> {
    let options = NextOptions { learn: true, ..NextOptions::default() };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| next_trials(task, &options, &*KNOWN))
}

fn within(planform: Planform, lengths_m: [[f64; 2]; 3]) -> DesignTask {
    let mut task = task(planform);
    let [width_m, spacing_m, depth_m] = lengths_m;
    task.space = DesignSpace::new(planform, width_m, spacing_m, depth_m).unwrap();
    task
}

#[test]
fn grooves_are_cut_across_and_along_and_every_mechanism_has_its_prediction() {
    // Fixed lengths leave the direction.
    let task = within(Planform::Groove, [[120e-6; 2], [320e-6; 2], [10e-6; 2]]);
    let found = learn(&task, 2).unwrap();
    let (report, learning) = (&found.report, found.report.learning.as_ref().unwrap());
    assert_eq!((&*report.advice, found.patterns.len(), found.sectors.len()), ("learn", 2, 2));
    let [across, along] = [0, 1].map(|sector: usize| found.patterns[sector].texture().sliding_direction());
    assert!(across == [1.0, 0.0] && along[0] == 0.0, "{across:?} {along:?}");
    assert!(learning.textures[0].contains("across") && learning.textures[1].contains("along"));
    assert!(learning.bits >= 0.0 && learning.bits < learning.open_bits, "{learning:?}");
    let weights: f64 = learning.mechanisms.iter().map(|of| of.weight).sum();
    assert!((weights - 1.0).abs() < 1e-5 && learning.mechanisms.is_sorted_by(|a, b| a.weight >= b.weight));
    // The modelled ratios are those of the textures, and the density predicts one model error for both sectors: the
    // quotient is that of the model, known better than either ratio.
    let density = learning.mechanisms.iter().find(|of| of.mechanism == "areal density").unwrap();
    for (at, pressure_pa) in density.loads.iter().zip(task.pressures_pa()) {
        assert!((at.quotient.pressure_mpa - 1e-6 * pressure_pa).abs() < 1e-9);
        let log_width = |of: &crate::RatioPrediction| (of.interval_95[1] / of.interval_95[0]).ln();
        let modelled = at.ratios[1].modelled / at.ratios[0].modelled;
        assert!((at.quotient.modelled - modelled).abs() < 1e-5);
        assert!((at.quotient.ratio / modelled - 1.0).abs() < 0.01);
        assert!(log_width(&at.quotient) < 0.5 * log_width(&at.ratios[0]), "{at:?}");
    }
    assert_eq!(learn(&task, 1).unwrap().report, *report);
    let text = report.text();
    assert!(text.contains("sector 2 / 1") && text.contains("second disc") && text.contains("disc 1: 2 sectors"));
    // The table is as wide as the names of the mechanisms, and the specimen is described as for any disc.
    let own = text.lines().take_while(|line| !line.contains("disc 1"));
    let mut sentences = own.filter(|line| !line.contains(" %  ") && !line.starts_with("   "));
    assert!(sentences.all(|line| line.chars().count() <= 100), "{text}");
}

#[test]
fn a_pair_that_teaches_clearly_more_replaces_equal_dimensions_and_lies_within_the_bounds() {
    let bounds = [[100e-6, 140e-6], [300e-6, 340e-6], [10e-6, 10e-6]];
    let task = within(Planform::Groove, bounds);
    let found = learn(&task, 2).unwrap();
    let learning = found.report.learning.as_ref().unwrap();
    for (pattern, words) in found.patterns.iter().zip(&learning.textures) {
        let lengths = pattern.lengths_m().into_iter().zip(bounds);
        assert!(lengths.into_iter().all(|(own, [low, high])| (low - 1e-9..=high + 1e-9).contains(&own)), "{pattern:?}");
        let is_across = pattern.texture().sliding_direction()[1] == 0.0;
        assert!(words.contains(if is_across { "across" } else { "along" }), "{words}");
    }
    let is_equal = found.patterns[0].lengths_m() == found.patterns[1].lengths_m();
    assert_eq!(is_equal, learning.why.starts_with("equal dimensions"), "{}", learning.why);
}

#[test]
fn squares_have_no_direction_and_one_texture_teaches_nothing_new() {
    let mut task = within(Planform::Square, [[100e-6, 200e-6], [200e-6, 200e-6], [10e-6, 20e-6]]);
    // A thin layer, for which cells in space take milliseconds.
    task.layer = Layer { height_m: 40e-6, ..task.layer };
    let found = learn(&task, 2).unwrap();
    assert!(found.report.text().contains("squares have no direction across or along"), "{}", found.report.text());
    assert!(!is_same(&Features::from(&found.patterns[0]), &Features::from(&found.patterns[1])));
    let one = within(Planform::Square, [[100e-6; 2], [200e-6; 2], [10e-6; 2]]);
    let refused = learn(&one, 2).unwrap_err().to_string();
    assert!(refused.contains("bounds leave a single texture"), "{refused}");
}
