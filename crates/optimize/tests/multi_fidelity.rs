//! Searches with a dear model along a cheap one: they end where searches with the dear one alone do, at a
//! fraction of its answers.

#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod surface;

use slipgrid_monitor::Unwatched;
use slipgrid_optimize::{
    Constraints, LowFidelityCorrection, ModelFailure, Response, SearchError, SearchOptions, SearchOutcome, Status,
    Target, search_multi_fidelity,
};
use slipgrid_pattern::Pattern;
use std::sync::atomic::Ordering;
use surface::{
    PRESSURES_PA, StopAfter, TOLERANCE, bursts, design, peak, ratio, respond, run, seeded, space, target, target_of,
    unlimited,
};

/// The surface as seen by a guide: off by up to three tolerances, by 20 % in the peak pressure, and rough at a
/// tenth of a tolerance.
fn guide(design: &Pattern) -> Result<Response, ModelFailure> {
    let mut response = respond(design)?;
    let (width, depth) = (design.width_m() / 400e-6, design.depth_m() / 50e-6);
    for value in &mut response.value {
        *value += 0.03 * width * (1.0 - depth) - 0.01 + 0.001 * (design.width_m() * 1e6).sin();
    }
    response.limited[0] *= 0.8 + 0.1 * width;
    Ok(response)
}

fn guided(wanted: &Target, constraints: &Constraints, options: &SearchOptions) -> SearchOutcome {
    let mut correction = LowFidelityCorrection::new();
    search_multi_fidelity(wanted, &space(), constraints, options, &respond, &guide, &mut correction, &Unwatched)
        .unwrap()
}

#[test]
fn a_target_that_a_known_design_reaches_is_met_from_every_seed_by_few_answers() {
    for (width_um, spacing_um, depth_um) in [(130.0, 370.0, 20.0), (60.0, 60.0, 10.0), (350.0, 900.0, 4.0)] {
        let known = design(width_um, spacing_um, depth_um);
        for constraints in [unlimited(), bursts(2.6)] {
            let mut answers = 0;
            for seed in 0..20 {
                let outcome = guided(&target_of(&known), &constraints, &seeded(seed));
                assert_eq!(outcome.status, Status::Met);
                assert!(outcome.best.misfit.max <= 0.3, "{width_um} {seed}: {:?}", outcome.best.misfit);
                // What is reported is the model's own.
                for candidate in outcome.alternatives.iter().chain([&outcome.best]) {
                    assert_eq!(candidate.response, respond(&candidate.design).unwrap());
                }
                answers += outcome.evaluations;
                assert!(outcome.guide_evaluations < 400, "{}", outcome.guide_evaluations);
            }
            assert!(answers < 20 * 16, "{width_um}: {answers} answers from 20 seeds");
        }
    }
}

#[test]
fn what_is_out_of_reach_is_said_with_the_models_own_range() {
    for seed in 0..10 {
        let wanted = target([0.5; 4]);
        let (outcome, alone) =
            (guided(&wanted, &unlimited(), &seeded(seed)), run(&wanted, &unlimited(), &seeded(seed)));
        assert_eq!(outcome.status, Status::Unreachable);
        assert!(outcome.evaluations < 40, "{}", outcome.evaluations);
        assert!(
            outcome.best.misfit.max < alone.best.misfit.max + 0.1,
            "{} {}",
            outcome.best.misfit.max,
            alone.best.misfit.max
        );
        for (range, alone) in outcome.reachable.iter().zip(&alone.reachable) {
            assert!((range.lowest - alone.lowest).abs() < 0.5 * TOLERANCE, "{seed} {range:?} {alone:?}");
            assert!((range.highest - alone.highest).abs() < 0.5 * TOLERANCE, "{seed} {range:?} {alone:?}");
            let place = PRESSURES_PA.iter().position(|&pressure_pa| pressure_pa == range.pressure_pa).unwrap();
            assert_eq!(range.lowest, ratio(&range.lowest_design, PRESSURES_PA[place]));
        }
    }
}

#[test]
fn where_nothing_is_in_reach_shallow_cavities_at_the_bounds_are_judged_by_the_model_itself() {
    // To the guide depths beyond a few micrometres do little more; to the model those of two bursts do most.
    let flattened = |design: &Pattern| {
        let mut response = respond(design)?;
        let share = 1.0 - (-design.depth_m() / 0.8e-6).exp();
        for (value, does) in response.value.iter_mut().zip([0.1, 0.2, 0.3, 0.4]) {
            *value = 1.0 - does * share * design.section_density() - 1e-4 * design.depth_m() * 1e6;
        }
        Ok::<_, ModelFailure>(response)
    };
    let model = |design: &Pattern| {
        let mut response = flattened(design)?;
        let more = 0.01 * (-((design.depth_m() * 1e6 - 5.2) / 2.0).powi(2)).exp();
        response.value.iter_mut().for_each(|value| *value -= more);
        Ok::<_, ModelFailure>(response)
    };
    let (wanted, constraints) = (target([0.05; 4]), bursts(2.6));
    let mut correction = LowFidelityCorrection::new();
    let options = seeded(1);
    let outcome = search_multi_fidelity(
        &wanted,
        &space(),
        &constraints,
        &options,
        &model,
        &flattened,
        &mut correction,
        &Unwatched,
    )
    .unwrap();
    assert_eq!(outcome.status, Status::Unreachable);
    let shallow = design(400.0, 40.0, 5.2);
    let last = &outcome.reachable[3];
    let least = model(&shallow).unwrap().value[3];
    assert!(last.lowest <= least + 1e-9, "{} {least} {:?}", last.lowest, last.lowest_design);
}

#[test]
fn a_limit_that_the_guide_takes_too_lightly_binds_where_the_model_says() {
    let wanted = target_of(&design(130.0, 370.0, 20.0));
    let alone = run(&wanted, &peak(4.5), &seeded(1));
    for seed in 0..10 {
        let outcome = guided(&wanted, &peak(4.5), &seeded(seed));
        assert_eq!((outcome.status, alone.status), (Status::Unreachable, Status::Unreachable));
        assert!(outcome.best.violations.is_empty());
        assert!(outcome.best.response.limited[0] > 0.97 * 4.5e6, "it binds");
        let (own, alone) = (outcome.best.misfit.max, alone.best.misfit.max);
        assert!(own < 1.05 * alone + 0.1, "{seed}: {own} {alone}");
    }
}

#[test]
fn the_outcome_and_what_was_learnt_are_the_same_at_any_number_of_threads() {
    for wanted in [target_of(&design(130.0, 370.0, 20.0)), target([0.5; 4])] {
        for max_evaluations in [60, 2000] {
            let outcomes = [1, 2, 4].map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let mut correction = LowFidelityCorrection::new();
                let options = SearchOptions { seed: 3, max_evaluations };
                let outcome = pool.install(|| {
                    let constraints = bursts(2.6);
                    search_multi_fidelity(
                        &wanted,
                        &space(),
                        &constraints,
                        &options,
                        &respond,
                        &guide,
                        &mut correction,
                        &Unwatched,
                    )
                });
                (outcome, correction)
            });
            assert_eq!(outcomes[0], outcomes[1]);
            assert_eq!(outcomes[0], outcomes[2]);
        }
    }
}

#[test]
fn what_one_search_learnt_spares_the_next_its_answers() {
    let mut correction = LowFidelityCorrection::new();
    let none = unlimited();
    let mut answers = Vec::new();
    for shift in [0.0, 0.002] {
        let known = design(130.0, 370.0, 20.0);
        let wanted = target(PRESSURES_PA.map(|pressure_pa| ratio(&known, pressure_pa) + shift));
        let outcome =
            search_multi_fidelity(&wanted, &space(), &none, &seeded(1), &respond, &guide, &mut correction, &Unwatched)
                .unwrap();
        assert_eq!(outcome.status, Status::Met);
        answers.push(outcome.evaluations);
    }
    assert!(!correction.is_empty() && answers[1] <= answers[0], "{answers:?}");
}

#[test]
fn budgets_failures_and_cancelling() {
    let wanted = target_of(&design(190.0, 370.0, 20.0));
    let none = unlimited();
    // Each kind of answer is limited.
    for max_evaluations in [3, 50] {
        let outcome = guided(&target([0.5; 4]), &none, &SearchOptions { seed: 1, max_evaluations });
        assert_eq!(outcome.status, Status::Budget);
        assert!(outcome.evaluations <= max_evaluations && outcome.guide_evaluations <= max_evaluations);
    }
    // Where the model fails the guide is not followed.
    let fragile = |design: &Pattern| {
        if design.width_m() > 200e-6 {
            Err(ModelFailure::Trial { reason: "too wide".to_owned() })
        } else {
            respond(design)
        }
    };
    for seed in 0..5 {
        let mut correction = LowFidelityCorrection::new();
        let outcome = search_multi_fidelity(
            &wanted,
            &space(),
            &none,
            &seeded(seed),
            &fragile,
            &guide,
            &mut correction,
            &Unwatched,
        )
        .unwrap();
        assert_eq!(outcome.status, Status::Met, "{seed}");
    }
    let never = |_: &Pattern| Err(ModelFailure::Trial { reason: "never".to_owned() });
    let mut correction = LowFidelityCorrection::new();
    let refused =
        search_multi_fidelity(&wanted, &space(), &none, &seeded(1), &never, &guide, &mut correction, &Unwatched);
    assert!(matches!(refused, Err(SearchError::EveryTrialFailed { .. })), "{refused:?}");
    let refused =
        search_multi_fidelity(&wanted, &space(), &none, &seeded(1), &respond, &never, &mut correction, &Unwatched);
    assert!(matches!(refused, Err(SearchError::EveryTrialFailed { .. })), "{refused:?}");
    // Stopped while the guide is asked, the model is asked of the best that the guide knows.
    // Of each of the two 2000 answers are allowed.
    let stop = StopAfter::new(22, 0.5 / 2000.0);
    let stopped = search_multi_fidelity(&wanted, &space(), &none, &seeded(1), &respond, &guide, &mut correction, &stop);
    let stopped = stopped.unwrap();
    assert!(matches!(stopped.status, Status::Cancelled | Status::Met), "{:?}", stopped.status);
    assert_eq!(stopped.evaluations, 1);
    assert_eq!(stopped.best.response, respond(&stopped.best.design).unwrap());
    // Where that is stopped, too, there is nothing of the model.
    stop.evaluations.store(0, Ordering::Relaxed);
    let cancelled = |_: &Pattern| Err(ModelFailure::Cancelled);
    let stopped =
        search_multi_fidelity(&wanted, &space(), &none, &seeded(1), &cancelled, &guide, &mut correction, &stop);
    assert_eq!(stopped, Err(SearchError::CancelledAtStart));
}
