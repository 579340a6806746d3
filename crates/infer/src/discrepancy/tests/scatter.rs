//! Scatter of samples of one texture.

use super::*;

/// Width, spacing and depth of the grooves that contradict each other, in um.
const LENGTHS_UM: [f64; 3] = [150.0, 300.0, 12.0];

fn groove([width_um, spacing_um, depth_um]: [f64; 3]) -> Features {
    super::groove(width_um, spacing_um, depth_um)
}

/// Trial with `rows` of pressure in MPa, speed in mm/s, measured and modelled ratio.
fn trial(name: &str, features: Features, rows: &[[f64; 4]]) -> Trial {
    let measured = |[pressure_mpa, speed_mm_s, measured, modelled]: &[f64; 4]| Measured {
        load: load(*pressure_mpa, *speed_mm_s, 45.0),
        measured: *measured,
        modelled: *modelled,
        patterned_std: 0.0105,
        flat_std: 0.008,
        sensitivity: Sensitivity::of_modulus(0.05),
    };
    cut(name, features, rows.iter().map(measured).collect())
}

/// Two grooves, the second of `other`, and squares between them; the grooves' ratios differ by a tenth.
fn contradicting(other: [f64; 3]) -> Vec<Trial> {
    let squares = Features::from(&Pattern::new(Planform::Square, 110e-6, 120e-6, 13e-6).unwrap());
    let first = trial("cut-1", groove(LENGTHS_UM), &[[1.592, 5.0, 0.868, 0.953], [4.775, 5.0, 0.819, 0.886]]);
    vec![
        Trial { dimensions_std_m: [3e-6, 3e-6, 0.7e-6], ..first },
        trial("cut-2", squares, &[[1.592, 20.0, 0.923, 0.899]]),
        trial("cut-3", groove(other), &[[1.592, 5.0, 0.953, 0.953], [4.775, 5.0, 0.911, 0.885]]),
    ]
}

/// Prior with a stated scatter of half a per cent, and possible scatters of many times that.
fn half_a_per_cent() -> Hyperparameters {
    let scatters = vec![(1.0, 0.9), (3.0, 0.06), (10.0, 0.03), (30.0, 0.01)];
    Hyperparameters { sample_std: 0.005, scatters, ..Hyperparameters::default() }
}

fn learned(trials: Vec<Trial>) -> Discrepancy {
    let conditions =
        Conditions { reference_pressure_pa: 3.18e6, lowest_pressure_pa: 1.592e6, reference_speed_m_s: 0.01 };
    Discrepancy::new(half_a_per_cent(), conditions, 0.1, trials).unwrap()
}

/// Standard deviation of the change by an increase of speed by the factor e.
fn of_speed(known: &Discrepancy) -> f64 {
    let loads = [5.0 * std::f64::consts::E, 5.0].map(|speed_mm_s| load(4.775, speed_mm_s, 45.0));
    let (_, covariance) = known.at(&loads).predict(&groove(LENGTHS_UM), &[Sensitivity::default(); 2]).mixed();
    (covariance[0] - 2.0 * covariance[1] + covariance[3]).sqrt()
}

#[test]
fn samples_of_one_texture_that_contradict_each_other_raise_the_scatter() {
    for other in [LENGTHS_UM, [152.0, 298.0, 12.2]] {
        let known = learned(contradicting(other));
        let [pair] = known.contradictions()[..] else { panic!("{:?}", known.contradictions()) };
        assert_eq!((pair.trials, pair.is_own, pair.sample_std), ([0, 2], [false; 2], [0.005; 2]));
        assert!(pair.probability < 1e-8 && (pair.difference + 0.107).abs() < 0.002, "{pair:?}");
        assert!((pair.load.pressure_pa - 4.775e6).abs() < 1.0);
        // The trials refute a scatter of half a per cent.
        let [stated, ..] = known.scatter_weights()[..] else { panic!() };
        assert!(
            stated.weight < 1e-3 && (0.03..0.12).contains(&known.sample_std()),
            "{stated:?} {}",
            known.sample_std()
        );
        // Forms do not turn a scatter into a step, in particular not at depths without trials.
        let deep = Form::DepthDensity { scale_m: 20e-6 };
        let deep = known.forms().into_iter().find(|of| of.form == deep).unwrap();
        assert!(deep.weight < deep.prior, "{deep:?}");
        let loads = [1.592, 4.775].map(|pressure_mpa| load(pressure_mpa, 5.0, 45.0));
        let at =
            |lengths_um: [f64; 3]| known.at(&loads).predict(&groove(lengths_um), &[Sensitivity::of_modulus(0.05); 2]);
        let near = at([160.0, 290.0, 12.0]);
        // Both samples lie within the prediction of a third: the ratios over the modelled ones.
        for (load, measured) in [(0, [0.868 / 0.953, 1.0]), (1, [0.819 / 0.886, 0.911 / 0.885_f64])] {
            let [low, high] = [0.025, 0.975].map(|p| near.quantile(load, p));
            assert!(measured.iter().all(|ratio| (low..high).contains(&ratio.ln())), "{load}: {low} {high}");
            // A change of 0.01 mm has a small effect compared to a tenth.
            let moved = (at([150.0, 290.0, 12.0]).medians()[load] - near.medians()[load]).abs();
            assert!(moved < 0.01, "{moved}");
        }
        // Trials do not reduce the knowledge of the effect of speed.
        let before = of_speed(&learned(Vec::new()));
        assert!(of_speed(&known) < 0.5 * before, "{} {before}", of_speed(&known));
    }
}

#[test]
fn a_scatter_that_is_stated_of_the_samples_is_kept() {
    let with = |sample_std: f64| {
        let all = contradicting(LENGTHS_UM);
        learned(all.into_iter().map(|of| Trial { sample_std: Some(sample_std), ..of }).collect())
    };
    let (small, large) = (with(0.005), with(0.05));
    for known in [&small, &large] {
        assert!(matches!(known.scatter_weights()[..], [ScatterWeight { std: 0.005, prior: 1.0, .. }]));
    }
    assert!(large.contradictions().is_empty());
    let found = small.contradictions();
    assert!(found.len() == 1 && found[0].is_own == [true; 2] && found[0].sample_std == [0.005; 2], "{found:?}");
}

#[test]
fn samples_that_may_differ_contradict_nothing() {
    let all = contradicting(LENGTHS_UM);
    let others: [fn(Trial) -> Trial; 4] = [
        // One disc, another texture, other conditions, and similar samples.
        |of| Trial { disc: Some("disc".to_owned()), ..of },
        |of| Trial { features: Features { width_m: 1.2 * of.features.width_m, ..of.features }, ..of },
        |of| trial("", of.features, &[[1.6, 7.0, 0.953, 0.953]]),
        |of| trial("", of.features, &[[1.592, 5.0, 0.88, 0.953], [4.775, 5.0, 0.83, 0.886]]),
    ];
    for (place, other) in others.into_iter().enumerate() {
        let mut trials = all.clone();
        trials[0].disc = Some("disc".to_owned()).filter(|_| place == 0);
        trials[2] = other(trials[2].clone());
        let known = learned(trials);
        assert!(known.contradictions().is_empty(), "{place}: {:?}", known.contradictions());
        // Measurement errors explain a difference of a hundredth: the stated scatter keeps or gains weight.
        let stated = known.scatter_weights()[0];
        assert!(place != 3 || stated.weight >= stated.prior, "{stated:?}");
    }
}

#[test]
fn further_conditions_do_not_hide_a_contradiction() {
    for conditions in [1, 2, 6, 12] {
        let sample = |shift: f64| {
            let at = |number: u32| [1.5 + 0.25 * f64::from(number), 5.0, 0.9 * shift.exp(), 0.95];
            trial("", groove(LENGTHS_UM), &(0..conditions).map(at).collect::<Vec<_>>())
        };
        let of = |shift: f64| {
            let samples = vec![sample(0.0), sample(shift)];
            Discrepancy::new(Hyperparameters::default(), Conditions::default(), 0.1, samples).unwrap().contradictions()
        };
        // 0.12 is four standard deviations of a difference, sqrt 2 times 2 %; 0.05 less than two.
        assert!(of(0.12).len() == 1 && of(0.05).is_empty(), "{conditions}: {:?} {:?}", of(0.12), of(0.05));
    }
}

/// Tests that one sample hardly changes the prior of the scatter.
#[test]
fn one_sample_leaves_the_scatter_as_it_is_believed_before_any() {
    let all = contradicting(LENGTHS_UM);
    let exact = Hyperparameters { scatters: vec![(1.0, 1.0)], ..Hyperparameters::default() };
    let of = |trials: &[Trial], hyper: &Hyperparameters| {
        Discrepancy::new(hyper.clone(), Conditions::default(), 0.1, trials.to_vec()).unwrap()
    };
    for count in [0, 1] {
        let known = of(&all[..count], &Hyperparameters::default());
        for scatter in known.scatter_weights() {
            assert!((scatter.weight - scatter.prior).abs() < 0.05, "{scatter:?}");
        }
        let at = [all[0].measured[0].load];
        let tail = |known: &Discrepancy| {
            let found = known.at(&at).predict(&all[0].features, &[Sensitivity::of_modulus(0.05)]);
            found.quantile(0, 0.995) - found.quantile(0, 0.005)
        };
        assert!(tail(&known) > if count == 0 { 1.0 } else { 1.5 } * tail(&of(&all[..count], &exact)));
    }
}

/// Tests samples with six times the stated scatter: posterior intervals contain the next one, intervals by the stated
/// scatter do not.
#[test]
fn intervals_hold_samples_that_scatter_more_than_is_stated() {
    let (samples, rounds) = (7, 120);
    let mut normals = Normals::new(5);
    let held = |std: f64, hyper: &Hyperparameters, normals: &mut Normals| {
        let within = (0..rounds).filter(|_| {
            let trials = (0..samples).map(|number| {
                let measured = 0.95 * (-0.1 + std * normals.draw()).exp();
                let texture = groove([150.0, 300.0 + 10.0 * f64::from(number), 12.0]);
                trial("", texture, &[[1.592, 5.0, measured, 0.95]])
            });
            let known = Discrepancy::new(hyper.clone(), Conditions::default(), 0.1, trials.collect()).unwrap();
            let left = leave_out(&known, LeftOut::TrialAndLater, &Unwatched).unwrap();
            let last = left.last().unwrap();
            (last.interval_95[0]..last.interval_95[1]).contains(&last.measured)
        });
        within.count() as f64 / f64::from(rounds)
    };
    let usual = half_a_per_cent();
    let exact = Hyperparameters { scatters: vec![(1.0, 1.0)], ..usual.clone() };
    // For samples with the stated scatter, intervals are wider than necessary; six times the stated scatter is far out in
    // the prior.
    let inferred = [0.005, 0.03].map(|std| held(std, &usual, &mut normals));
    let stated = held(0.03, &exact, &mut normals);
    assert!(inferred[0] > 0.9 && inferred[1] > 0.8 && stated < 0.7, "{inferred:?} {stated}");
}

/// Tests that samples that repeat better than usual lower the scatter.
#[test]
fn samples_that_agree_lower_the_scatter() {
    let texture = groove(LENGTHS_UM);
    let samples = |count: usize| {
        let one = |_| trial("", texture, &[[1.592, 5.0, 0.88, 0.953], [4.775, 5.0, 0.83, 0.886]]);
        Discrepancy::new(Hyperparameters::default(), Conditions::default(), 0.1, (0..count).map(one).collect()).unwrap()
    };
    let stds = [1, 3, 6].map(|count| samples(count).sample_std());
    assert!(stds.windows(2).all(|pair| pair[1] < 0.9 * pair[0]), "{stds:?}");
}
