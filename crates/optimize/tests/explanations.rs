//! Why targets are out of reach, where closed forms say it.

#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod surface;

use slipgrid_monitor::Unwatched;
use slipgrid_optimize::{
    Constraints, DesignSpace, Dimension, Explanation, Restriction, SearchOutcome, Status, Target,
    explain_infeasibility, search, search_near,
};
use slipgrid_pattern::Planform;
use surface::{
    PRESSURES_PA, bursts, depth_share, design, peak, ratio, respond, seeded, space, target, target_of, unlimited,
};

fn widest() -> DesignSpace {
    DesignSpace::new(Planform::Groove, [10e-6, 800e-6], [10e-6, 2e-3], [1e-6, 190e-6]).unwrap()
}

fn explained(wanted: &Target, space: &DesignSpace, constraints: &Constraints) -> (SearchOutcome, Explanation, usize) {
    let mut searches = 0;
    let mut solve = |space: &DesignSpace, constraints: &Constraints| {
        searches += 1;
        search(wanted, space, constraints, &seeded(1), &respond, &Unwatched)
    };
    let outcome = solve(space, constraints).unwrap();
    let found = explain_infeasibility(space, constraints, &outcome.best, &widest(), 5, &mut solve).unwrap();
    (outcome, found, searches)
}

#[test]
fn the_limit_that_binds_is_named_with_the_least_that_suffices() {
    // Along s g = 0.2387, which the target determines within a tolerance, the peak pressure is least, 5.2 MPa, at 10 um.
    let wanted = target_of(&design(130.0, 370.0, 20.0));
    let (outcome, found, searches) = explained(&wanted, &space(), &peak(4.5));
    assert_eq!(outcome.status, Status::Unreachable);
    // The largest misfit is least at the lower bound of the width, which is relaxed too and does not suffice.
    let [relief, width] = &found.reliefs[..] else { panic!("{found:?}") };
    assert_eq!((width.restriction, width.suffices), (Restriction::LowerBound(Dimension::Width), false));
    assert_eq!((relief.restriction, relief.suffices, relief.limit), (Restriction::Quantity(0), true, 4.5e6));
    // The least by brute force over what meets the target.
    let mut least = f64::INFINITY;
    let share = |from: f64, to: f64, i: u32| from * (to / from).powf(f64::from(i) / 120.0);
    for (i, j) in (0..=120).flat_map(|i| (0..=120).map(move |j| (i, j))) {
        for k in 0..=120 {
            let tried = design(share(40.0, 400.0, i), share(40.0, 1000.0, j), share(2.0, 50.0, k));
            let response = respond(&tried).unwrap();
            if wanted.misfit(&response.value).is_met() {
                least = least.min(response.limited[0]);
            }
        }
    }
    assert!(relief.relaxed > 0.99 * least && relief.relaxed < 1.03 * least, "{} {least}", relief.relaxed);
    assert!(relief.best.meets_target() && relief.best.response.limited[0] == relief.relaxed);
    assert!(found.together.is_none() && searches <= 9, "{searches}");
}

#[test]
fn land_goes_with_the_bound_that_says_the_same() {
    // Land of 30 um would do: ratio at 130 / 30 / 50 um, with no land below 40 um.
    let wanted = target_of(&design(130.0, 30.0, 45.0));
    let mut constraints = unlimited();
    constraints.limits.min_land_m = Some(40e-6);
    let (outcome, found, _) = explained(&wanted, &space(), &constraints);
    assert_eq!(outcome.status, Status::Unreachable);
    let land = found.reliefs.iter().find(|relief| relief.restriction == Restriction::SmallestLand).unwrap();
    assert!(land.suffices && land.limit == 40e-6 && land.relaxed > 29e-6 && land.relaxed < 40e-6, "{land:?}");
    assert!(found.reliefs.iter().all(|relief| relief.restriction != Restriction::LowerBound(Dimension::Spacing)));
}

#[test]
fn bounds_on_which_the_design_rests_count_and_others_do_not() {
    // s g = 0.6 within 20 um: depth and spacing hold it back, width does not.
    let known = design(100.0, 50.0, 18.0);
    let narrow = DesignSpace::new(Planform::Groove, [40e-6, 400e-6], [40e-6, 1e-3], [2e-6, 8e-6]).unwrap();
    let (outcome, found, _) = explained(&target_of(&known), &narrow, &unlimited());
    assert_eq!(outcome.status, Status::Unreachable);
    let upper = Restriction::UpperBound(Dimension::Depth);
    let depth = found.reliefs.iter().find(|relief| relief.restriction == upper).unwrap();
    assert!(depth.suffices);
    // The target wants s g to a tolerance: with spacing at its bound.
    let least_um = depth.relaxed * 1e6;
    let product = |least_um: f64| 100.0 / 140.0 * depth_share(least_um);
    assert!(least_um > 8.0 && product(least_um) > 0.93 * 100.0 / 150.0 * depth_share(18.0), "{least_um}");
}

#[test]
fn what_nothing_brings_within_reach_is_said() {
    // Half the friction at the lightest load takes more than all cavities there are.
    let wanted = target([0.2; 4]);
    let mut constraints = bursts(2.6);
    constraints.quantities = peak(9.0).quantities;
    let (outcome, found, _) = explained(&wanted, &space(), &constraints);
    assert_eq!(outcome.status, Status::Unreachable);
    assert!(!found.reliefs.is_empty() && found.reliefs.iter().all(|relief| !relief.suffices));
    assert!(found.reliefs.iter().all(|relief| relief.best.misfit.max < outcome.best.misfit.max));
    let together = found.together.unwrap();
    assert!(!together.misfit.is_met());
    assert!(found.reliefs.iter().all(|relief| together.misfit.max <= relief.best.misfit.max + 0.1));
    assert!(ratio(&together.design, PRESSURES_PA[3]) < ratio(&outcome.best.design, PRESSURES_PA[3]));
}

#[test]
fn about_the_best_design_the_same_reasons_are_found_with_fewer_answers() {
    let mut many = bursts(2.6);
    many.quantities = peak(9.0).quantities;
    let narrow = DesignSpace::new(Planform::Groove, [40e-6, 400e-6], [40e-6, 1e-3], [2e-6, 8e-6]).unwrap();
    for (wanted, space, constraints) in [
        (target_of(&design(130.0, 370.0, 20.0)), space(), peak(4.5)),
        (target_of(&design(100.0, 50.0, 18.0)), narrow, unlimited()),
        (target([0.2; 4]), space(), many),
    ] {
        let outcome = search(&wanted, &space, &constraints, &seeded(1), &respond, &Unwatched).unwrap();
        let explained = |near: bool| {
            let mut answers = 0;
            let mut solve = |space: &DesignSpace, constraints: &Constraints| {
                let found = if near {
                    let known = [outcome.best.design];
                    search_near(&known, &wanted, space, constraints, &seeded(1), &respond, &Unwatched)?
                } else {
                    search(&wanted, space, constraints, &seeded(1), &respond, &Unwatched)?
                };
                answers += found.evaluations;
                Ok(found)
            };
            let found = explain_infeasibility(&space, &constraints, &outcome.best, &widest(), 0, &mut solve).unwrap();
            (found, answers)
        };
        let ((whole, whole_answers), (near, near_answers)) = (explained(false), explained(true));
        assert!(2 * near_answers < whole_answers || near_answers < 200, "{near_answers} {whole_answers}");
        let reasons = |found: &Explanation| {
            let mut of: Vec<String> =
                found.reliefs.iter().map(|relief| format!("{:?} {}", relief.restriction, relief.suffices)).collect();
            of.sort();
            of
        };
        assert_eq!(reasons(&near), reasons(&whole));
        for relief in near.reliefs.iter().filter(|relief| !relief.suffices) {
            let other = whole.reliefs.iter().find(|other| other.restriction == relief.restriction).unwrap();
            assert!(relief.best.misfit.rms < 1.02 * other.best.misfit.rms, "{relief:?} {other:?}");
        }
        if let Some((near, whole)) = near.together.zip(whole.together) {
            assert!(near.misfit.rms < 1.02 * whole.misfit.rms, "{near:?} {whole:?}");
        }
    }
}

#[test]
fn nothing_narrower_than_the_spot_is_tried() {
    // Half the friction at the lightest load takes more than all cavities there are, of any width.
    let wanted = target([0.2; 4]);
    for (lower_um, loosest_um) in [(30.0, None), (40.0, Some(30.0))] {
        let space = DesignSpace::new(Planform::Groove, [lower_um * 1e-6, 80e-6], [40e-6, 1e-3], [2e-6, 8e-6]).unwrap();
        let mut constraints = unlimited();
        constraints.limits.spot_m = Some(30e-6);
        let mut narrowest_m = f64::INFINITY;
        let mut solve = |space: &DesignSpace, constraints: &Constraints| {
            let outcome = search(&wanted, space, constraints, &seeded(1), &respond, &Unwatched)?;
            narrowest_m = narrowest_m.min(outcome.best.design.least_extent_m());
            Ok(outcome)
        };
        let mut best = solve(&space, &constraints).unwrap().best;
        // The nearest design rests on the lower bound of the width.
        best.design = design(lower_um, 40.0, 8.0);
        let found = explain_infeasibility(&space, &constraints, &best, &widest(), 0, &mut solve).unwrap();
        assert!(narrowest_m >= 30e-6, "{narrowest_m}");
        let lower = Restriction::LowerBound(Dimension::Width);
        let loosest_m = found.tried.iter().find(|(restriction, _)| *restriction == lower).map(|(_, loosest)| *loosest);
        assert_eq!(loosest_m.map(|m| (m * 1e6).round()), loosest_um);
    }
}
