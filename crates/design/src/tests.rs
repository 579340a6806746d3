//! Tests of the whole job: `optimize` and `next` give consistent predictions and searches.

use crate::optimize::{Demand, DesignSpace, Goal, Quantity, Target, TargetPoint, Tolerances, Wanted as Accepted};
use slipgrid_base::monitor::{CachingMonitor, Monitor, Unwatched};
use slipgrid_base::statistics::{NORMAL_95, Normals, normal_probability};
use slipgrid_infer::calibrate::uncertainty::{CoefficientEstimate, MaterialUncertainty};
use slipgrid_infer::discrepancy::{
    Conditions, Discrepancy, Features, Hyperparameters, Load as At, Measured, Sensitivity, Trial,
};
use slipgrid_laser::export::{Laser, Outline, Specimen};
use slipgrid_laser::specimen::simulate_on;
use slipgrid_model::material::{AreaLaw, Elastic, Friction, LocalFriction, Material, Provenance};
use slipgrid_model::pattern::{ManufacturingLimits, Pattern, Planform};
use slipgrid_model::springblock::{Correction, Effect, Extent, Layer, LoadOutcome, RunOptions, Scene, even_speed_m_s};
use std::sync::atomic::AtomicBool;
use std::sync::{LazyLock, Mutex};

mod beside;
mod brute_force;
mod learning;
mod limits;
mod several_samples;
mod small_specimens;

use crate::explorer::Explorer;
use crate::next_trial::laser_warnings;
use crate::prepared_task::PreparedTask;
use crate::search::{Search, is_same};
use crate::session::with_table;
use crate::steady_model::SteadyModel;
use crate::time_budget::TimeBudget;
use crate::timings::Timings;
use crate::{
    ConstraintQuantity, DesignError, DesignTask, KnownMaterial, LimitedBy, NextOptions, NoCache, next_trials, run,
};

/// Caches the tables and runs of all tests, since most tests search equal grooves.
/// `every_stage_comes_to_its_whole_and_...` and `several_samples_are_apart_and_...` compute their own.
static KNOWN: LazyLock<CachingMonitor<'static>> = LazyLock::new(|| CachingMonitor::new(&Unwatched));

pub fn task(planform: Planform) -> DesignTask {
    let material = Material {
        elastic: Elastic::new(0.38e9, 900.0).unwrap(),
        friction: Friction::Single(LocalFriction::new(0.30, 0.27, 0.05).unwrap()),
        area_law: Some(AreaLaw::new(vec![0.7e6, 10e6], vec![1.0, 0.6]).unwrap()),
        provenance: Provenance::default(),
    };
    let space = DesignSpace::new(planform, [60e-6, 300e-6], [100e-6, 700e-6], [5e-6, 30e-6]).unwrap();
    let specimen = Specimen { outline: Outline::Disc { diameter_m: 10e-3 }, is_clipped: false };
    let layer = Layer { length_m: 10e-3, height_m: 100e-6, block_m: 20e-6, thickness_m: None, holder: None };
    DesignTask::new(material, near(0.9, 0.02), space, specimen, layer)
}

/// Target of ratios within `tolerance` of `value` at both pressures.
fn near(value: f64, tolerance: f64) -> Target {
    let points = [0.65e6, 2.6e6].map(|pressure_pa| TargetPoint { pressure_pa, value });
    Target::new(Quantity::Ratio, points.to_vec(), tolerance).unwrap()
}

/// Random texture of `task`, uniform in the logarithms of the lengths.
fn random(task: &DesignTask, normals: &mut Normals) -> Pattern {
    let mut at = |[low, high]: [f64; 2]| low * (high / low).powf(normal_probability(normals.draw()));
    task.space.pattern(task.space.lengths_m().map(&mut at)).unwrap()
}

/// Ratios of a texture by the model at the loads of `task`.
fn steady(task: &DesignTask, lengths_m: [f64; 3]) -> Vec<f64> {
    let known = task.material.clone().unwrap();
    let scene = task.flat_scene(&known.material, task.loads(&known.material).unwrap().0, RunOptions::default());
    let pattern = task.space.pattern(lengths_m).unwrap();
    SteadyModel::new(&scene, &[], &[], &task.space).on(task.specimen).steady(&pattern).unwrap().ratio
}

/// Sets a target that grooves of these lengths reach if the model is exact.
fn reached_by(task: &mut DesignTask, lengths_m: [f64; 3], tolerance: f64) {
    let points = [0.65e6, 2.6e6].into_iter().zip(steady(task, lengths_m));
    let points = points.map(|(pressure_pa, value)| TargetPoint { pressure_pa, value }).collect();
    task.target = Target::new(Quantity::Ratio, points, tolerance).unwrap();
}

/// Trial of grooves of these lengths with the measured `ratios` at the loads of `task`.
fn trial(task: &DesignTask, lengths_m: [f64; 3], ratios: [f64; 2]) -> Trial {
    let measured = |((pressure_pa, modelled), measured): ((f64, f64), f64)| Measured {
        load: At { pressure_pa, speed_m_s: task.speed_m_s, humidity: 0.4 },
        measured,
        modelled,
        patterned_std: 0.005,
        flat_std: 0.005,
        sensitivity: Sensitivity::default(),
    };
    let modelled = task.pressures_pa().into_iter().zip(steady(task, lengths_m));
    Trial {
        name: "cut".to_owned(),
        features: Features::from(&task.space.pattern(lengths_m).unwrap()),
        sample_std: None,
        disc: None,
        measured: modelled.zip(ratios).map(measured).collect(),
        dimensions_std_m: [0.0; 3],
        dimension_shifts: Vec::new(),
    }
}

/// Adds trials to `task`.
fn taught(task: &DesignTask, trials: Vec<Trial>) -> DesignTask {
    let learned = Discrepancy::new(Hyperparameters::default(), Conditions::default(), 0.0, trials).unwrap();
    let uncertainty = MaterialUncertainty {
        learned: Some(learned),
        modulus_relative_std: Some(0.1),
        ..MaterialUncertainty::default()
    };
    let material = task.material.clone().unwrap().material;
    DesignTask { material: Some(KnownMaterial { material, uncertainty }), ..task.clone() }
}

/// Returns `task` with a material whose flat friction rises with load, contrary to its area law.
fn contradicted(task: &DesignTask) -> DesignTask {
    let mut task = task.clone();
    let known = task.material.as_mut().unwrap();
    known.uncertainty.flat_friction = [(0.65e6, 0.25), (2.6e6, 0.30)]
        .map(|(pressure_pa, value)| CoefficientEstimate {
            pressure_pa: Some(pressure_pa),
            condition: None,
            value,
            std_error: 0.0,
        })
        .to_vec();
    task
}

/// Runs `then` with the search of `task`.
fn searched<T>(task: &DesignTask, then: impl FnOnce(&Search<'_>) -> T) -> T {
    let prepared = PreparedTask::new(task).unwrap();
    let budget = TimeBudget::new(&*KNOWN, None, 1.0);
    let timings = &mut Timings::default();
    with_table(&prepared, None, None, budget, timings, |search, _| Ok(then(search))).unwrap()
}

/// Tasks of grooves with no, one and three trials.
fn three_tasks() -> [DesignTask; 3] {
    let mut task = task(Planform::Groove);
    let scatter = Tolerances { width_std_um: 4.0, spacing_std_um: 6.0, depth_std_um: 0.8, ..Tolerances::default() };
    task.tolerances = Some(scatter);
    task.target = near(0.87, 0.03);
    let trials = vec![
        trial(&task, [100e-6, 300e-6, 10e-6], [0.85, 0.83]),
        trial(&task, [200e-6, 600e-6, 20e-6], [0.80, 0.77]),
        trial(&task, [80e-6, 600e-6, 10e-6], [0.91, 0.90]),
    ];
    [taught(&task, Vec::new()), taught(&task, trials[..1].to_vec()), taught(&task, trials)]
}

#[test]
fn optimize_and_next_find_one_texture_with_one_chance() {
    let [none, one, three] = three_tasks();
    for task in [none, contradicted(&one), three] {
        let next = next_trials(&task, &NextOptions::default(), &*KNOWN).unwrap();
        let found = run(&task, &mut NoCache, &*KNOWN).unwrap();
        assert_eq!(found.pattern, next.patterns[0]);
        assert_eq!(found.report.sample, next.report.samples[0]);
        assert_eq!((&*found.report.advice, &found.report.words), (&*next.report.advice, &next.report.words));
        // The texture found, requested as a sample of the user.
        let own = NextOptions { own: vec![found.pattern], ..NextOptions::default() };
        let own = next_trials(&task, &own, &*KNOWN).unwrap().report.own;
        assert_eq!((own[0].chance, &own[0].expected), (found.report.sample.chance, &found.report.sample.expected));
        assert!(found.report.sample.is_as_cut && found.report.sample.chance.is_some());
        // The confirming run gives the values of the model alone.
        for (confirmed, modelled) in found.report.confirmed.iter().zip(&found.report.sample.modelled) {
            assert!((confirmed.ratio.unwrap() - modelled.ratio).abs() < 1e-9, "{confirmed:?} {modelled:?}");
            // The error is that of each correction; the cells have their own of the size of blocks.
            let known = |of: &&Correction| of.effect != Effect::Blocks && of.std.is_some_and(|std| std > 0.0);
            let of_run: Vec<&Correction> = confirmed.corrections.iter().filter(known).collect();
            let square: f64 = of_run.iter().map(|of| of.std.unwrap().powi(2)).sum();
            assert!(!of_run.is_empty() && square.sqrt() < modelled.std, "{of_run:?} {modelled:?}");
            let limits = &found.report.sample.limited_by;
            assert!(of_run.iter().all(|of| limits.iter().any(|limit| limit.input == of.effect.name())), "{limits:?}");
        }
    }
}

#[test]
fn no_random_texture_has_a_clearly_greater_chance() {
    for task in three_tasks() {
        searched(&task, |search| {
            let best = search.best(&|_| true, 1).solved.remove(0);
            let mut normals = Normals::new(7);
            let mut greatest: f64 = 0.0;
            for _ in 0..60 {
                let pattern = random(&task, &mut normals);
                let rough = search.roughly(&pattern).map_or(0.0, |found| found.chance());
                if rough > 0.5 * best.chance() {
                    greatest = greatest.max(search.solved(&pattern).map_or(0.0, |found| found.chance()));
                }
            }
            assert!(greatest < best.chance() + 0.01, "{greatest} {}", best.chance());
        });
    }
}

#[test]
fn the_table_is_near_the_model_and_says_how_near() {
    searched(&three_tasks()[1], |search| {
        let report = &search.table.report;
        assert!(report.checked > 40 && report.median_error < 2e-3 && report.worst_error < 0.03, "{report:?}");
        assert!(report.holes == 0 && report.bytes > 8 * 4 * report.nodes);
        // Chances by the table are near those by the model.
        for lengths_um in [[80.0, 200.0, 8.0], [150.0, 420.0, 14.0], [240.0, 660.0, 26.0]] {
            let pattern = search.task.space.pattern(lengths_um.map(|um: f64| um * 1e-6)).unwrap();
            let (rough, exact) = (search.roughly(&pattern).unwrap(), search.solved(&pattern).unwrap());
            assert!((rough.chance() - exact.chance()).abs() < 0.03, "{} {}", rough.chance(), exact.chance());
        }
    });
}

#[test]
fn what_limits_a_chance_is_what_raises_it_where_it_is_known() {
    let report = run(&three_tasks()[2], &mut NoCache, &*KNOWN).unwrap().report;
    let (limits, chance) = (&report.sample.limited_by, report.sample.chance.unwrap());
    let names: Vec<&str> = limits.iter().map(|limit| &*limit.input).collect();
    for name in
        ["model error", "width", "spacing", "depth", "Young's modulus", "numerical error", "scatter between samples"]
    {
        assert!(names.contains(&name), "{names:?}");
    }
    assert!(limits.iter().all(|limit| limit.chance_if_known >= chance && limit.std.len() == 2));
    assert!(limits.windows(2).all(|pair| pair[0].chance_if_known > pair[1].chance_if_known - 0.01));
    // Three trials leave less of the model open than samples of one texture scatter by.
    let first = [0, 1].map(|place: usize| &*limits[place].input);
    assert_eq!(first, ["scatter between samples", "model error"]);
    let is_much = |limit: &LimitedBy| limit.std[0] > 0.003 && limit.chance_if_known > chance + 0.02;
    assert!(limits[..2].iter().all(is_much), "{limits:?} {chance}");
}

#[test]
fn the_local_law_moves_what_is_expected_and_not_what_is_modelled() {
    let task = three_tasks()[1].clone();
    let lengths_m = [100e-6, 300e-6, 12e-6];
    let of = |task: &DesignTask| {
        searched(task, |search| {
            let found = search.solved(&task.space.pattern(lengths_m).unwrap()).unwrap();
            let limits = found.limited_by(search.asked, &search.predictor, 0.1);
            assert!(limits.iter().any(|limit| limit.input == "scatter between samples"));
            // Inputs together explain the interval but for its shape, and none exceeds it.
            for (load, at) in found.expected(search.asked).iter().enumerate() {
                let combined = (at.high_95 - at.low_95) / (2.0 * NORMAL_95);
                let of_inputs = limits.iter().map(|limit| limit.std[load].powi(2)).sum::<f64>().sqrt();
                assert!((0.9..1.03).contains(&(of_inputs / combined)), "{of_inputs} {combined} {limits:?}");
                assert!(limits.iter().all(|limit| limit.std[load] < combined), "{combined} {limits:?}");
            }
            let rough = search.interpolated(&found.texture.pattern).unwrap().sensitivity;
            (found.texture.ratio.clone(), found.medians(), limits, found.texture.sensitivity.clone(), rough)
        })
    };
    let (ratio, medians, limits, without, _) = of(&task);
    assert!(without.iter().all(|of| of.local_law == 0.0) && limits.iter().all(|limit| limit.input != "local law"));
    let (same_ratio, moved, limits, sensitivity, rough) = of(&contradicted(&task));
    assert_eq!(ratio, same_ratio);
    let limit = limits.iter().find(|limit| limit.input == "local law").unwrap();
    assert_eq!(limit.known_to, "known from trials to 50 % of its effect");
    for load in 0..2 {
        let change = sensitivity[load].local_law;
        // The trial was modelled without the local law and hardly determines lambda: half of the change is expected.
        assert!(change > 0.01, "{sensitivity:?}");
        assert!(
            ((moved[load] / medians[load]).ln() - 0.5 * change).abs() < 0.1 * change,
            "{change} {moved:?} {medians:?}"
        );
        assert!((limit.std[load] - 0.5 * change * moved[load]).abs() < 0.1 * change, "{limit:?} {change}");
        assert!((rough[load].local_law - change).abs() < 0.1 * change, "{rough:?} {sensitivity:?}");
        assert_eq!(sensitivity[load].modulus, without[load].modulus);
    }
    let report = run(&contradicted(&task), &mut NoCache, &*KNOWN).unwrap().report;
    assert!(
        report.model.iter().any(|note| note.starts_with("local law: flat friction contradicts")),
        "{:?}",
        report.model
    );
    // Measured flat friction, and a law fitted to it, are used unchanged.
    for known in [
        |of: &mut MaterialUncertainty| of.law_is_measured = true,
        |of: &mut MaterialUncertainty| of.law_is_fitted = true,
    ] {
        let mut task = contradicted(&task);
        known(&mut task.material.as_mut().unwrap().uncertainty);
        assert!(of(&task).3.iter().all(|of| of.local_law == 0.0));
    }
}

#[test]
fn a_trial_on_target_is_said_and_its_texture_is_the_likeliest() {
    let task = three_tasks()[0].clone();
    let cut = trial(&task, [100e-6, 300e-6, 10e-6], [0.87, 0.87]);
    let task = taught(&task, vec![cut.clone()]);
    let report = run(&task, &mut NoCache, &*KNOWN).unwrap().report;
    assert_eq!(report.advice, "trial_meets_it");
    assert!(
        report
            .words
            .contains("trial \"cut\" (width/spacing/depth 100/300/10 um, 25.0 % of a period) already meets the target"),
        "{}",
        report.words
    );
    assert!(report.sample.chance.unwrap() > 0.6, "{:?}", report.sample.chance);
    let meets = |trial: Trial| {
        run(&taught(&task, vec![trial]), &mut NoCache, &*KNOWN).unwrap().report.advice == "trial_meets_it"
    };
    // A trial off target at one load is not on target.
    let mut off = cut.clone();
    off.measured[1].measured = 0.80;
    assert!(!meets(off));
    // A trial that was measured up to a load a little below the last one, and farther below.
    for (share, is_near) in [(0.96, true), (0.94, false)] {
        let mut short = cut.clone();
        short.measured[1].load.pressure_pa *= share;
        assert_eq!(meets(short), is_near, "{share}");
    }
}

#[test]
fn what_to_do_follows_from_the_chance_and_from_what_is_within_reach() {
    let base = task(Planform::Groove);
    let advised = |task: &DesignTask| run(task, &mut NoCache, &*KNOWN).unwrap().report;
    let wanting = |value: f64, tolerance: f64| DesignTask { target: near(value, tolerance), ..base.clone() };
    // Before any trial the advice is a trial, for wide and for unreachable bands.
    for (value, tolerance) in [(0.8, 0.15), (0.05, 0.02)] {
        let trial = advised(&wanting(value, tolerance));
        assert_eq!(trial.advice, "trial");
        assert!(trial.words.starts_with("cut a trial: "), "{}", trial.words);
    }
    let flat = advised(&wanting(0.97, 0.05));
    assert_eq!(flat.advice, "do_not_texture");
    // No texture lowers the peak pressure below the nominal one.
    let mut limited = wanting(0.85, 0.03);
    limited.constraints.quantities.push(ConstraintQuantity::PeakPressure.limited_to(1.0e6));
    let broken = advised(&limited);
    assert!(broken.advice == "cannot_be_met" && broken.words.contains("keeps all limits"), "{}", broken.words);
    // A target above the flat surface, and one below the expected ratio of any texture after a trial.
    let cut = trial(&base, [100e-6, 300e-6, 10e-6], [0.9, 0.88]);
    for value in [1.4, 0.05] {
        let report = advised(&taught(&wanting(value, 0.02), vec![cut.clone()]));
        assert_eq!(report.advice, "cannot_be_met", "{value} {}", report.words);
        assert!(report.sample.expected.iter().any(|at| !at.is_within()));
    }
    // Trials of one texture that contradict each other come before that, if the target may be met without one of them.
    let other = Trial { name: "again".to_owned(), ..trial(&base, [100e-6, 300e-6, 10e-6], [0.55, 0.53]) };
    let report = advised(&taught(&wanting(1.4, 0.02), vec![cut.clone(), other.clone()]));
    assert_eq!(report.advice, "cannot_be_met", "{}", report.words);
    let report = advised(&taught(&wanting(0.94, 0.02), vec![cut.clone(), other]));
    assert!(report.advice == "measure_again" && report.blocked_by.is_empty(), "{}", report.words);
    assert!(["\"again\"", "\"cut\""].iter().all(|name| report.words.contains(name)), "{}", report.words);
    // A limit that keeps the target out of reach is named.
    let mut limited = taught(&wanting(0.85, 0.03), vec![cut]);
    limited.constraints.quantities.push(ConstraintQuantity::PeakPressure.limited_to(3.0e6));
    let report = advised(&limited);
    assert_eq!(report.advice, "cannot_be_met", "{}", report.words);
    let lifted = &report.blocked_by[0];
    assert!(lifted.what.contains("peak pressure") && lifted.is_within_reach, "{lifted:?}");
    assert!(lifted.chance > report.sample.chance.unwrap() + 0.01, "{lifted:?}");
}

#[test]
fn a_goal_is_the_best_expected_value_that_keeps_the_demands() {
    let base = task(Planform::Groove);
    let demand = |pressure_pa, wanted| Demand { pressure_pa, wanted, weight: 1.0 };
    let aimed = |goal, wanted: Accepted| {
        let demands = [0.65e6, 2.6e6].map(|pressure_pa| demand(pressure_pa, wanted)).to_vec();
        let target = Target::of(Quantity::Ratio, demands, Some(goal)).unwrap();
        run(&DesignTask { target, ..base.clone() }, &mut NoCache, &*KNOWN).unwrap().report
    };
    let lowest = aimed(Goal::Lowest, Accepted::Anything);
    assert!(lowest.sample.chance.is_none() && lowest.advice == "trial");
    let goal = lowest.goal.as_ref().unwrap();
    let ends = goal.interval_95.unwrap();
    assert!(ends[0] < goal.expected && goal.expected < ends[1], "{goal:?}");
    // A lower limit besides the goal is met more likely than not.
    let kept = aimed(Goal::Lowest, Accepted::AtLeast { lowest: 0.8, margin: 0.01 });
    let value = kept.goal.as_ref().unwrap().expected;
    assert!(kept.sample.chance.unwrap() >= 0.5 && value > goal.expected && value < 0.95, "{value}");
    // The flat surface has the highest friction if the model and its expected error lower friction.
    assert_eq!(aimed(Goal::Highest, Accepted::Anything).advice, "do_not_texture");
    // Its ratios are even by nature, but it does not do what is demanded beside a goal.
    assert_eq!(aimed(Goal::Even, Accepted::Anything).advice, "do_not_texture");
    assert_eq!(aimed(Goal::Highest, Accepted::AtMost { highest: 0.93, margin: 0.01 }).advice, "trial");
}

/// Tests that the ratio of a design equals the modelled ratio of its trial, on the specimen that it is cut into.
#[test]
fn ratios_that_are_predicted_are_those_of_the_specimen() {
    let mut task = task(Planform::Groove);
    task.layer.thickness_m = Some(7e-3);
    // A surface with steeper friction, for which the outer rim matters.
    let law = AreaLaw::new(vec![0.7e6, 2.6e6, 10e6], vec![1.0, 0.6, 0.2]).unwrap();
    task.material.as_mut().unwrap().material.area_law = Some(law);
    let found = next_trials(&task, &NextOptions { count: 1, ..NextOptions::default() }, &*KNOWN).unwrap();
    let material = &task.material.as_ref().unwrap().material;
    let pattern = Some(found.patterns[0]);
    let ratios = |extent, specimen: Option<&Specimen>| {
        let run = RunOptions { extent, refine: true, seed: task.search.seed, ..RunOptions::default() };
        let run = if specimen.is_some() { run.from_sliding() } else { run };
        let scene = Scene { pattern, ..task.flat_scene(material, task.loads(material).unwrap().0, run) };
        // Time adds the effect of even sliding, at any speed.
        let speed_m_s = even_speed_m_s(&scene.elastic, scene.loads[0].pressure_pa);
        let mut scene = if specimen.is_some() { Scene { speed_m_s, ..scene }.in_time() } else { scene };
        // Twice the travel of a confirmation, for what time adds to a thousandth.
        scene.run.sliding_m *= 2.0;
        simulate_on(&scene, specimen, &Unwatched).unwrap().loads
    };
    let specimen = ratios(Extent::Sample, Some(&task.specimen));
    let by_time: Vec<f64> = specimen.iter().map(|load| load.correction(Effect::Time).unwrap().change).collect();
    assert!(by_time[0] > 2e-3, "{by_time:?}");
    let ratio = |load: &LoadOutcome| load.ratio().unwrap();
    let off: Vec<[f64; 2]> = found.report.samples[0]
        .modelled
        .iter()
        .zip(specimen.iter().zip(&ratios(Extent::Cell, None)))
        .map(|(at, (specimen, cell))| [at.ratio - ratio(specimen), ratio(cell) - ratio(specimen)])
        .collect();
    // Load sharing and time nearly cancel at the lighter load; at the heavier the cell alone is clearly off.
    let is_better = |[own, cell]: &[f64; 2]| cell.abs() > 1.5e-3 && own.abs() < 0.5 * cell.abs();
    assert!(off.iter().all(|[own, _]| own.abs() < 2e-3) && off.iter().any(is_better), "{off:?}");
}

#[test]
fn squares_are_chosen_in_space() {
    let mut task = task(Planform::Square);
    // A thin layer, for which cells in space take milliseconds.
    task.layer = Layer { height_m: 40e-6, block_m: 20e-6, ..task.layer };
    let found = next_trials(&task, &NextOptions::default(), &*KNOWN).unwrap();
    assert_eq!(found.patterns.len(), 1);
    let sample = &found.report.samples[0];
    assert_eq!(sample.design.planform(), "square");
    // Squares at the border differ from those of an infinite pattern.
    assert!(sample.limited_by.iter().any(|of| of.input == Effect::Layout.name()), "{:?}", sample.limited_by);
}

/// The explorer draws straight lines between the target's pressures.
#[test]
fn values_between_four_pressures_lie_on_straight_lines_to_three_thousandths() {
    let mut task = three_tasks()[1].clone();
    let pressures_pa = [0.65e6, 0.975e6, 1.3e6, 1.625e6, 1.95e6, 2.275e6, 2.6e6];
    let points = pressures_pa.map(|pressure_pa| TargetPoint { pressure_pa, value: 0.87 });
    task.target = Target::new(Quantity::Ratio, points.to_vec(), 0.05).unwrap();
    searched(&task, |search| {
        for lengths_m in [[100e-6, 300e-6, 12e-6], [60e-6, 600e-6, 5e-6], [200e-6, 200e-6, 30e-6]] {
            let medians = search.solved(&task.space.pattern(lengths_m).unwrap()).unwrap().medians();
            for between in [1, 3, 5] {
                let straight = 0.5 * (medians[between - 1] + medians[between + 1]);
                assert!((straight - medians[between]).abs() < 0.003, "{lengths_m:?} {medians:?}");
            }
        }
    });
}

/// Stages that began, with the completed shares of their work.
#[derive(Default)]
struct Shares(Mutex<Vec<(String, f64)>>);

impl Monitor for Shares {
    fn stage(&self, name: &str) {
        self.0.lock().unwrap().push((name.to_owned(), 0.0));
    }

    fn advance(&self, share: f64) {
        self.0.lock().unwrap().last_mut().unwrap().1 += share;
    }
}

#[test]
fn every_stage_comes_to_its_whole_and_a_search_that_is_over_asks_nothing() {
    let task = task(Planform::Groove);
    let shares = Shares::default();
    next_trials(&task, &NextOptions::default(), &shares).unwrap();
    let all = shares.0.into_inner().unwrap();
    assert_eq!(all.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["table", "search"]);
    assert!(all.iter().all(|(_, share)| (share - 1.0).abs() < 0.2), "{all:?}");
    let over = AtomicBool::new(true);
    assert!(matches!(next_trials(&task, &NextOptions::default(), &over), Err(DesignError::Cancelled)));
    assert!(matches!(run(&task, &mut NoCache, &over), Err(DesignError::Cancelled)));
}
