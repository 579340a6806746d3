//! Limits of the peak pressure in the run of a specimen.

use super::*;
use crate::{TradeOffGoal, TradeOffsWanted};

/// The outer lands of a specimen carry a higher pressure than the cell: a limit between both is broken by the run.
#[test]
fn a_limit_that_only_the_run_of_the_best_breaks_is_kept_by_another_texture() {
    let mut task = three_tasks()[1].clone();
    let best = |search: &Search<'_>| {
        let best = search.best(&|_| true, 1).solved.remove(0);
        let cell_pa = search.models.own.steady(&best.texture.pattern).unwrap().peak_pressure_pa();
        (best.texture.excess, best.texture.pattern, cell_pa, best.texture.run.unwrap().peak_pressure_pa())
    };
    let (_, free, cell_pa, run_pa) = searched(&task, best);
    assert!(run_pa > 1.01 * cell_pa, "{run_pa} {cell_pa}");
    let limit_pa = (run_pa * cell_pa).sqrt();
    task.constraints.quantities.push(ConstraintQuantity::PeakPressure.limited_to(limit_pa));
    let (excess, kept, _, run_pa) = searched(&task, best);
    assert!(kept != free && excess == 0.0 && run_pa <= limit_pa, "{excess} {kept:?} {run_pa} {limit_pa}");
}

/// In space the confirming run is the steady cell: a limit below its peak pressure is kept by another texture, and
/// trade-offs state the same pressure.
#[test]
fn in_space_the_confirmed_cell_keeps_the_limit() {
    let mut task = task(Planform::Square);
    task.specimen.outline = Outline::Disc { diameter_m: 1.2e-3 };
    task.layer.height_m = 40e-6;
    task.target = near(0.92, 0.03);
    task.trade_offs =
        Some(TradeOffsWanted { goals: vec![TradeOffGoal::Chance, TradeOffGoal::PeakPressure], designs: 50 });
    let of = |task: &DesignTask| {
        let found = run(task, &mut NoCache, &*KNOWN).unwrap();
        assert_eq!(found.report.fidelity, "steady");
        let confirmed_pa = found.confirmed.peak_pressure_pa();
        let chosen_mpa = found.report.trade_offs.as_ref().map(|of| of.chosen[1]);
        (found.pattern, confirmed_pa, chosen_mpa, found.report.sample.violations)
    };
    let (free, confirmed_pa, chosen_mpa, _) = of(&task);
    assert!((1e6 * chosen_mpa.unwrap() / confirmed_pa - 1.0).abs() < 1e-3, "{chosen_mpa:?} {confirmed_pa}");
    let cell_pa = searched(&task, |search| search.models.own.steady(&free).unwrap().peak_pressure_pa());
    assert!((confirmed_pa / cell_pa - 1.0).abs() < 1e-6, "{confirmed_pa} {cell_pa}");
    let limit_pa = 0.99 * cell_pa;
    task.constraints.quantities.push(ConstraintQuantity::PeakPressure.limited_to(limit_pa));
    let (kept, confirmed_pa, _, violations) = of(&task);
    assert!(
        kept != free && confirmed_pa <= limit_pa && violations.is_empty(),
        "{kept:?} {confirmed_pa} {violations:?}"
    );
}

/// Runs exceed the peak pressure of their cells by factors that differ between textures: the search goes on from those
/// that break the limit, and a texture that keeps a lower limit keeps a higher one.
#[test]
fn a_higher_limit_of_the_peak_pressure_never_loses_the_textures_of_a_lower_one() {
    let mut task = task(Planform::Groove);
    task.space = DesignSpace::new(Planform::Groove, [40e-6, 120e-6], [40e-6, 400e-6], [2e-6, 10e-6]).unwrap();
    task.specimen.outline = Outline::Disc { diameter_m: 2e-3 };
    let demands = [1.3e6, 2.6e6].map(|pressure_pa| Demand {
        pressure_pa,
        wanted: Accepted::AtMost { highest: 0.8, margin: 0.01 },
        weight: 1.0,
    });
    task.target = Target::of(Quantity::Ratio, demands.to_vec(), None).unwrap();
    let found = [4.6e6, 5.0e6, 5.5e6, 6.0e6].map(|limit_pa| {
        task.constraints.quantities = vec![ConstraintQuantity::PeakPressure.limited_to(limit_pa)];
        searched(&task, |search| {
            let best = search.best(&|_| true, 1).solved.remove(0);
            (best.texture.excess, best.chance())
        })
    });
    assert!(found.iter().all(|(excess, _)| *excess == 0.0), "{found:?}");
    // To what the effects of the specimen on other textures leave open.
    assert!(found.windows(2).all(|pair| pair[1].1 > pair[0].1 - 0.03), "{found:?}");
}

/// Cells keep the limit, so that the target is within reach by the table, and the runs of all specimens break it.
#[test]
fn a_limit_that_only_the_runs_break_is_named_as_what_blocks_the_target() {
    let mut task = task(Planform::Groove);
    task.space = DesignSpace::new(Planform::Groove, [40e-6, 120e-6], [40e-6, 400e-6], [2e-6, 10e-6]).unwrap();
    task.specimen.outline = Outline::Disc { diameter_m: 2e-3 };
    task.target = near(0.9, 0.095);
    task.constraints.quantities =
        vec![ConstraintQuantity::PeakPressure.limited_to(4.4e6), ConstraintQuantity::ArealDensity.limited_to(0.9)];
    assert!(searched(&task, |search| search.best(&|_| true, 1).is_within_reach));
    let report = run(&task, &mut NoCache, &*KNOWN).unwrap().report;
    assert_eq!((&*report.advice, report.sample.violations.len()), ("cannot_be_met", 1));
    let named: Vec<&str> = report.blocked_by.iter().map(|lifted| &*lifted.what).collect();
    assert_eq!(named, ["the limit of peak pressure, 4.4 MPa"]);
    assert!(report.blocked_by[0].is_within_reach);
}

#[test]
fn limits_that_nothing_keeps_are_named_with_each_sample() {
    let mut task = task(Planform::Groove);
    let highest_pa = task.pressures_pa().into_iter().fold(0.0, f64::max);
    task.constraints.quantities.push(ConstraintQuantity::PeakPressure.limited_to(1.001 * highest_pa));
    let next = |options: NextOptions| next_trials(&task, &options, &*KNOWN);
    let found = next(NextOptions { count: 1, ..NextOptions::default() }).unwrap().report;
    assert_eq!((&*found.advice, found.samples[0].violations.len()), ("cannot_be_met", 1));
    assert!(found.text().contains(&format!("! next: {}", found.samples[0].violations[0])), "{}", found.text());
    for (count, one_disc, learn) in [(3, true, false), (2, false, true)] {
        let refused = next(NextOptions { count, one_disc, learn, ..NextOptions::default() }).unwrap_err().to_string();
        assert!(refused.contains("fits on a sector keeps all limits"), "{refused}");
    }
}
