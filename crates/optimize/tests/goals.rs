//! Bands, weights and goals: what the search finds, judged by brute force over many seeds.

#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod surface;

use slipgrid_monitor::Unwatched;
use slipgrid_optimize::{
    Bound, Constraints, Demand, Goal, Limit, LowFidelityCorrection, Quantity, Response, SearchError, SearchOptions,
    Status, Target, Wanted, search, search_multi_fidelity,
};
use slipgrid_pattern::Pattern;
use surface::{PRESSURES_PA, bursts, design, peak, respond, run, seeded, space, unlimited};

const SEEDS: u64 = 20;

fn aim(wanted: Wanted, goal: Option<Goal>) -> Target {
    let demand = |pressure_pa| Demand { pressure_pa, wanted, weight: 1.0 };
    Target::of(Quantity::Ratio, PRESSURES_PA.map(demand).to_vec(), goal).unwrap()
}

/// Least cost over a dense grid of designs that are feasible and accepted.
fn brute_force(target: &Target, constraints: &Constraints) -> f64 {
    let share = |from: f64, to: f64, i: u32| from * (to / from).powf(f64::from(i) / 100.0);
    let mut least = f64::INFINITY;
    for (i, j) in (0..=100).flat_map(|i| (0..=100).map(move |j| (i, j))) {
        for k in 0..=100 {
            let tried = design(share(40.0, 400.0, i), share(40.0, 1000.0, j), share(2.0, 50.0, k));
            let response = respond(&tried).unwrap();
            let misfit = target.misfit(&response.value);
            if misfit.is_met() && constraints.violations(&tried, &response).is_empty() {
                least = least.min(misfit.cost);
            }
        }
    }
    least
}

#[test]
fn goals_end_where_brute_force_does() {
    let between = |lowest, highest| Wanted::Between { lowest, highest };
    for (wanted, goal, constraints) in [
        (Wanted::Anything, Goal::Lowest, unlimited()),
        (Wanted::Anything, Goal::Lowest, peak(5.0)),
        (Wanted::Anything, Goal::Highest, unlimited()),
        (Wanted::Anything, Goal::Even, unlimited()),
        (between(0.7, 0.9), Goal::Even, unlimited()),
        (between(0.6, 0.95), Goal::Lowest, unlimited()),
        (Wanted::AtLeast { lowest: 0.7, margin: 0.01 }, Goal::Lowest, bursts(2.6)),
        (Wanted::AtMost { highest: 0.8, margin: 0.01 }, Goal::Highest, unlimited()),
    ] {
        let target = aim(wanted, Some(goal));
        let least = brute_force(&target, &constraints);
        let mut evaluations = 0;
        for seed in 0..SEEDS {
            let outcome = run(&target, &constraints, &seeded(seed));
            assert_eq!(outcome.status, Status::Met, "{wanted:?} {goal:?} {seed}");
            assert!(outcome.best.meets_target());
            // Per cent of the mean, or of standard deviation over mean.
            let cost = outcome.best.misfit.cost;
            assert!(cost < least + 0.1, "{wanted:?} {goal:?} {seed}: {cost} {least}");
            evaluations += outcome.evaluations;
        }
        assert!(evaluations < 700 * SEEDS as usize, "{wanted:?} {goal:?}: {evaluations}");
    }
}

#[test]
fn bands_are_met_in_their_middle_and_one_sided_ones_with_a_margin() {
    for seed in 0..SEEDS {
        let outcome = run(&aim(Wanted::Between { lowest: 0.7, highest: 0.9 }, None), &unlimited(), &seeded(seed));
        assert_eq!(outcome.status, Status::Met);
        assert!(outcome.best.misfit.max < 0.9, "{:?}", outcome.best);
        let wanted = Wanted::AtMost { highest: 0.75, margin: 0.01 };
        let outcome = run(&aim(wanted, None), &unlimited(), &seeded(seed));
        assert_eq!(outcome.status, Status::Met);
        assert!(outcome.best.response.value.iter().all(|&value| value < 0.7405), "{:?}", outcome.best);
        // 0.5 at 0.65 MPa is out of reach.
        let wanted = Wanted::AtMost { highest: 0.5, margin: 0.01 };
        for goal in [None, Some(Goal::Highest)] {
            assert_eq!(run(&aim(wanted, goal), &unlimited(), &seeded(seed)).status, Status::Unreachable);
        }
    }
}

#[test]
fn weights_shift_what_is_missed() {
    // A level ratio of 0.7 is out of reach: the weighted pressure is missed by less.
    let weighted = |weights: [f64; 4]| {
        let demand = |(pressure_pa, weight)| Demand {
            pressure_pa,
            wanted: Wanted::Near { value: 0.7, tolerance: 0.01 },
            weight,
        };
        let demands = PRESSURES_PA.into_iter().zip(weights).map(demand).collect();
        run(&Target::of(Quantity::Ratio, demands, None).unwrap(), &unlimited(), &seeded(1)).best.response.value
    };
    let (light, heavy) = (weighted([9.0, 1.0, 1.0, 1.0]), weighted([1.0, 1.0, 1.0, 9.0]));
    assert!((light[0] - 0.7).abs() < (heavy[0] - 0.7).abs() && (heavy[3] - 0.7).abs() < (light[3] - 0.7).abs());
}

#[test]
fn a_goal_that_runs_out_of_evaluations_says_so_with_its_best() {
    let target = aim(Wanted::Anything, Some(Goal::Lowest));
    for max_evaluations in [1, 10, 60] {
        let outcome = run(&target, &unlimited(), &SearchOptions { seed: 1, max_evaluations });
        assert_eq!(outcome.status, Status::Budget);
        assert!(outcome.best.meets_target() && outcome.evaluations <= max_evaluations);
    }
}

#[test]
fn a_goal_along_a_guide_ends_where_it_does_without() {
    let guide = |design: &Pattern| {
        let mut response = respond(design)?;
        let (width, depth) = (design.width_m() / 400e-6, design.depth_m() / 50e-6);
        response.value.iter_mut().for_each(|value| *value += 0.03 * width * (1.0 - depth) - 0.01);
        Ok(response)
    };
    for goal in [Goal::Lowest, Goal::Highest, Goal::Even] {
        let target = aim(Wanted::Between { lowest: 0.55, highest: 0.97 }, Some(goal));
        let alone = run(&target, &unlimited(), &seeded(1));
        for seed in 0..5 {
            let mut correction = LowFidelityCorrection::new();
            let options = seeded(seed);
            let outcome = search_multi_fidelity(
                &target,
                &space(),
                &unlimited(),
                &options,
                &respond,
                &guide,
                &mut correction,
                &Unwatched,
            )
            .unwrap();
            assert_eq!(outcome.status, Status::Met, "{goal:?} {seed}");
            let (own, alone) = (outcome.best.misfit.cost, alone.best.misfit.cost);
            assert!(own < alone + 0.2, "{goal:?} {seed}: {own} {alone}");
            assert!(outcome.evaluations < 30, "{goal:?} {seed}: {}", outcome.evaluations);
        }
    }
}

#[test]
fn several_limits_bind_together() {
    // The lowest ratio under a peak pressure and a share of land: least land where depth is at its limit.
    let mut constraints = peak(5.0);
    let bound = Bound::AtLeast(0.8);
    constraints.quantities.push(Limit {
        name: "bearing area",
        unit: "",
        unit_si: 1.0,
        bound,
        scale: 0.8,
        loosest: 0.0,
    });
    let model = |design: &Pattern| {
        let mut response = respond(design)?;
        response.limited.push(1.0 - design.areal_density());
        Ok(response)
    };
    let wanted = Wanted::Near { value: 0.5, tolerance: 0.01 };
    for (target, status) in
        [(aim(wanted, None), Status::Unreachable), (aim(Wanted::Anything, Some(Goal::Lowest)), Status::Met)]
    {
        for seed in 0..SEEDS {
            let outcome = search(&target, &space(), &constraints, &seeded(seed), &model, &Unwatched).unwrap();
            assert_eq!(outcome.status, status);
            assert!(outcome.best.violations.is_empty());
            let [peak_pressure_pa, land] = outcome.best.response.limited[..] else { panic!() };
            assert!(peak_pressure_pa > 4.95e6 && land < 0.801, "{seed} {peak_pressure_pa} {land}");
        }
    }
    let missing = search(&aim(wanted, None), &space(), &constraints, &seeded(1), &respond, &Unwatched);
    assert_eq!(missing, Err(SearchError::WrongLimited { expected: 2, got: 1 }));
    let broken = |_: &Pattern| Ok(Response { value: vec![0.9; 4], limited: vec![1e6, f64::NAN] });
    let failed = search(&aim(wanted, None), &space(), &constraints, &seeded(1), &broken, &Unwatched);
    assert!(matches!(failed, Err(SearchError::EveryTrialFailed { .. })));
}
