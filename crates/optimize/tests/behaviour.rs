//! Budgets, failures, cancelling, and outcomes that depend on nothing but input and seed.

#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod surface;

use slipgrid_monitor::Unwatched;
use slipgrid_optimize::{
    Constraints, DesignSpace, ModelFailure, Response, SearchError, SearchOptions, Status, Violation, least_evaluations,
    search,
};
use slipgrid_pattern::{ManufacturingLimits, Pattern, Planform};
use std::collections::BTreeSet;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use surface::{StopAfter, bursts, design, peak, respond, run, seeded, space, target, target_of, unlimited};

#[test]
fn the_outcome_is_the_same_at_any_number_of_threads() {
    let both = Constraints { limits: bursts(2.6).limits, ..peak(4.5) };
    for wanted in [target_of(&design(130.0, 370.0, 20.0)), target([0.5; 4])] {
        for constraints in [unlimited(), bursts(2.6), peak(4.5), both.clone()] {
            for max_evaluations in [150, 2000] {
                let options = SearchOptions { seed: 3, max_evaluations };
                let outcomes = [1, 2, 4].map(|threads| {
                    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                    pool.install(|| run(&wanted, &constraints, &options))
                });
                assert_eq!(outcomes[0], outcomes[1]);
                assert_eq!(outcomes[0], outcomes[2]);
            }
        }
    }
}

#[test]
fn every_design_is_evaluated_once_and_the_count_is_true() {
    for constraints in [unlimited(), bursts(2.6)] {
        for wanted in [target_of(&design(130.0, 370.0, 20.0)), target([0.5; 4])] {
            let calls = AtomicUsize::new(0);
            let seen = Mutex::new(BTreeSet::new());
            let model = |design: &Pattern| {
                calls.fetch_add(1, Ordering::Relaxed);
                let lengths = design.lengths_m();
                seen.lock().unwrap().insert(lengths.map(f64::to_bits));
                respond(design)
            };
            let outcome = search(&wanted, &space(), &constraints, &seeded(1), &model, &Unwatched).unwrap();
            let distinct = seen.lock().unwrap().len();
            assert_eq!(outcome.evaluations, distinct);
            // Two threads can come to one design at the same time.
            let calls = calls.load(Ordering::Relaxed);
            assert!(calls >= distinct && calls * 10 <= distinct * 11, "{calls} calls for {distinct} designs");
            let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
            let counted = AtomicUsize::new(0);
            let model = |design: &Pattern| {
                counted.fetch_add(1, Ordering::Relaxed);
                respond(design)
            };
            pool.install(|| search(&wanted, &space(), &constraints, &seeded(1), &model, &Unwatched).unwrap());
            assert_eq!(counted.load(Ordering::Relaxed), distinct);
        }
    }
}

#[test]
fn history_ends_at_the_best_design_and_alternatives_are_others() {
    let wanted = target_of(&design(130.0, 370.0, 20.0));
    let outcome = run(&wanted, &unlimited(), &seeded(1));
    let last = outcome.history.last().unwrap();
    assert_eq!(last.misfit, outcome.best.misfit);
    assert!(last.evaluation <= outcome.evaluations && last.feasible);
    assert!(outcome.history.windows(2).all(|pair| pair[0].evaluation < pair[1].evaluation));
    assert!(outcome.history.windows(2).all(|pair| pair[0].misfit.max > pair[1].misfit.max));
    assert!(!outcome.alternatives.is_empty());
    for alternative in &outcome.alternatives {
        assert!(alternative.meets_target());
        assert_eq!(alternative.response, respond(&alternative.design).unwrap());
        assert_ne!(alternative.design, outcome.best.design);
    }
    for range in &outcome.reachable {
        assert!(range.lowest < range.highest);
    }
}

#[test]
fn a_budget_too_small_is_a_status() {
    let wanted = target([0.5; 4]);
    for max_evaluations in [1, 2, 7, 30, 100, 200] {
        let outcome = run(&wanted, &unlimited(), &SearchOptions { seed: 1, max_evaluations });
        assert_eq!(outcome.status, Status::Budget);
        assert!(outcome.evaluations <= max_evaluations);
        assert!(outcome.evaluations * 20 >= max_evaluations * 19, "{} of {max_evaluations}", outcome.evaluations);
    }
    let none = SearchOptions { seed: 1, max_evaluations: 0 };
    let refused = search(&wanted, &space(), &unlimited(), &none, &respond, &Unwatched);
    assert!(matches!(refused, Err(SearchError::OutOfRange { .. })));
}

#[test]
fn a_small_budget_suffices_for_an_easy_target() {
    let wanted = target_of(&design(130.0, 370.0, 20.0));
    let options = |seed| SearchOptions { seed, max_evaluations: 60 };
    let met = (0..20).filter(|&seed| run(&wanted, &unlimited(), &options(seed)).status == Status::Met);
    assert_eq!(met.count(), 20);
}

#[test]
fn fixed_dimensions_stay_and_a_fixed_design_is_only_judged() {
    let wanted = target_of(&design(130.0, 370.0, 20.0));
    let fixed = |spacing_m| DesignSpace::new(Planform::Groove, [130e-6; 2], spacing_m, [20e-6; 2]).unwrap();
    let none = unlimited();
    let line = search(&wanted, &fixed([40e-6, 1000e-6]), &none, &seeded(1), &respond, &Unwatched).unwrap();
    assert_eq!(line.status, Status::Met);
    assert_eq!((line.best.design.width_m(), line.best.design.depth_m()), (130e-6, 20e-6));
    assert!((line.best.design.spacing_m() - 370e-6).abs() < 1e-6);
    assert!(line.evaluations < 60, "{}", line.evaluations);
    for (spacing_m, status) in [(370e-6, Status::Met), (200e-6, Status::Unreachable)] {
        let point = search(&wanted, &fixed([spacing_m; 2]), &none, &seeded(1), &respond, &Unwatched).unwrap();
        assert_eq!((point.status, point.evaluations), (status, 1));
    }
}

#[test]
fn manufacturing_limits_are_never_crossed() {
    let limits = ManufacturingLimits {
        min_land_m: Some(200e-6),
        spot_m: Some(150e-6),
        depth_per_burst_m: Some(2.6e-6),
        wall_slope: Some(2.0),
    };
    let constraints = Constraints { limits, ..unlimited() };
    let model = |design: &Pattern| {
        assert!(limits.violations(design).is_empty());
        respond(design)
    };
    let outcome = search(&target([0.5; 4]), &space(), &constraints, &seeded(1), &model, &Unwatched).unwrap();
    assert_eq!(outcome.status, Status::Unreachable);
    let impossible =
        Constraints { limits: ManufacturingLimits { depth_per_burst_m: Some(60e-6), ..limits }, ..constraints };
    let refused = search(&target([0.5; 4]), &space(), &impossible, &seeded(1), &respond, &Unwatched).unwrap_err();
    assert!(matches!(refused, SearchError::NoWholeBurst { nearest_m, .. } if nearest_m == 60e-6));
}

#[test]
fn a_constraint_that_no_design_respects_is_reported() {
    let outcome = run(&target([0.9; 4]), &peak(1.0), &seeded(1));
    assert_eq!(outcome.status, Status::Unreachable);
    assert!(matches!(outcome.best.violations[..], [Violation::Quantity { .. }]));
    assert!(outcome.reachable.is_empty());
    // The least peak pressure: narrowest, farthest, shallowest.
    let least = respond(&design(40.0, 1000.0, 2.0)).unwrap().limited[0];
    assert!((outcome.best.response.limited[0] / least - 1.0).abs() < 1e-9);
}

#[test]
fn failed_trials_are_counted_and_passed_by() {
    let fragile = |design: &Pattern| {
        if design.width_m() > 200e-6 {
            return Err(ModelFailure::Trial { reason: "too wide for the model".to_owned() });
        }
        let mut response = respond(design)?;
        if design.depth_m() > 30e-6 {
            response.value[2] = f64::NAN;
        }
        Ok(response)
    };
    for seed in 0..20 {
        let wanted = target_of(&design(190.0, 370.0, 20.0));
        let outcome = search(&wanted, &space(), &unlimited(), &seeded(seed), &fragile, &Unwatched).unwrap();
        assert_eq!(outcome.status, Status::Met);
        assert!(outcome.failed_trials.iter().any(|trial| trial.reason.contains("too wide")));
        assert!(outcome.failed_trials.iter().any(|trial| trial.reason.contains("not finite")));
        assert!(outcome.failed_trials.len() < outcome.evaluations);
    }
}

#[test]
fn a_broken_model_is_an_error() {
    let with = |answer: fn() -> Result<Response, ModelFailure>| {
        let model = move |_: &Pattern| answer();
        search(&target([0.9; 4]), &space(), &unlimited(), &seeded(1), &model, &Unwatched).unwrap_err()
    };
    let trial = with(|| Err(ModelFailure::Trial { reason: "never".to_owned() }));
    assert_eq!(trial, SearchError::EveryTrialFailed { trials: 40, reason: "never".to_owned() });
    let broken = with(|| Err(ModelFailure::Broken { reason: "no material".to_owned() }));
    assert_eq!(broken, SearchError::BrokenModel { reason: "no material".to_owned() });
    let short = with(|| Ok(Response { value: vec![0.9], limited: vec![1e6] }));
    assert_eq!(short, SearchError::WrongResponse { expected: 4, got: 1 });
    assert_eq!(with(|| Err(ModelFailure::Cancelled)), SearchError::CancelledAtStart);
}

#[test]
fn cancelling_keeps_the_best_design() {
    for stop_at in [1, 30, 80, 300] {
        // Of the 2000 evaluations allowed.
        let stop = StopAfter::new(stop_at, 1.0 / 2000.0);
        let none = unlimited();
        let outcome = search(&target([0.5; 4]), &space(), &none, &seeded(1), &respond, &stop).unwrap();
        assert_eq!(outcome.status, Status::Cancelled);
        assert!(outcome.evaluations >= stop_at && outcome.evaluations < stop_at + 64);
        assert_eq!(outcome.best.response, respond(&outcome.best.design).unwrap());
    }
}

#[test]
fn what_limits_fix_takes_no_part_of_the_sample() {
    let space = DesignSpace::new(Planform::Groove, [30e-6, 90e-6], [40e-6, 300e-6], [5e-6, 6e-6]).unwrap();
    let least = |limits| least_evaluations(&space, &Constraints { limits, ..Constraints::default() });
    // Twice the corners and the sample of as many free dimensions, less one.
    assert_eq!(least(ManufacturingLimits::default()), Ok(2 * (8 + 32) - 1));
    // Two bursts alone lie within the bounds, and spot and land leave one width and one spacing.
    let burst = ManufacturingLimits { depth_per_burst_m: Some(2.6e-6), ..ManufacturingLimits::default() };
    assert_eq!(least(burst), Ok(2 * (4 + 16) - 1));
    let fixed = ManufacturingLimits { spot_m: Some(90e-6), min_land_m: Some(300e-6), ..burst };
    assert_eq!(least(fixed), Ok(3));
    assert!(least(ManufacturingLimits { spot_m: Some(1e-3), ..burst }).is_err());
}
