use std::sync::Mutex;

use slipgrid_discrepancy::{Conditions, Hyperparameters};
use slipgrid_material::{Elastic, Friction, LocalFriction, Material, Provenance};
use slipgrid_monitor::{Stage, Unwatched};
use slipgrid_optimize::{DesignSpace, Target, TargetPoint, Tolerances, Wanted as Accepted};
use slipgrid_pattern::{ManufacturingLimits, Planform};
use slipgrid_results::beyond_measured_range;
use slipgrid_specimen::simulate_on;
use slipgrid_springblock::{Extent, Layer, LoadOutcome, Scene, even_speed_m_s};

use super::*;

pub fn task(planform: Planform) -> DesignTask {
    let material = Material {
        elastic: Elastic::new(0.38e9, 900.0).unwrap(),
        friction: Friction::Single(LocalFriction::new(0.30, 0.27, 0.05).unwrap()),
        area_law: Some(AreaLaw::new(vec![0.7e6, 10e6], vec![1.0, 0.6]).unwrap()),
        provenance: Provenance::default(),
    };
    let points = [0.65e6, 2.6e6].map(|pressure_pa| TargetPoint { pressure_pa, value: 0.9 });
    let target = Target::new(Quantity::Ratio, points.to_vec(), 0.02).unwrap();
    let space = DesignSpace::new(planform, [60e-6, 300e-6], [100e-6, 700e-6], [5e-6, 30e-6]).unwrap();
    let specimen =
        slipgrid_export::Specimen { outline: slipgrid_export::Outline::Disc { diameter_m: 10e-3 }, is_clipped: false };
    let layer = Layer { length_m: 10e-3, height_m: 100e-6, block_m: 20e-6, thickness_m: None };
    DesignTask::new(material, target, space, specimen, layer)
}

fn known() -> MaterialUncertainty {
    MaterialUncertainty { modulus_relative_std: Some(0.2), ..MaterialUncertainty::default() }
}

fn model(task: &DesignTask) -> SteadyModel<'static> {
    let known = task.material.clone().unwrap();
    let loads = task.loads(&known.material).unwrap().0;
    let scene = task.flat_scene(&known.material, loads, RunOptions::default());
    SteadyModel::new(&scene, &[], &[], &task.space, None)
}

/// Samples of endless patterns.
fn endless<'a>(task: &DesignTask, model: &'a SteadyModel<'a>) -> BeyondCells<'a> {
    BeyondCells { model, face: None, count: task.target.points().len(), seed: 1 }
}

/// What the interpolated model is off by: the finalists are solved exactly, so it need only rank.
#[test]
fn between_its_nodes_the_model_is_off_by_less_than_a_tolerance() {
    let task = task(Planform::Groove);
    let model = model(&task);
    let models = Models::new(&model, &known()).unwrap();
    let stage = Stage::new(&Unwatched, "model", None);
    let scope = Scope { blocks: [2; 3], face: [2; 3], ..Scope::PLANE };
    let found = Interpolation::new(&task, &models, &endless(&task, &model), &scope, &stage).unwrap();
    let mut worst = [0.0_f64; 2];
    for width in [60.0, 85.0, 140.0, 222.0, 300.0] {
        for spacing in [100.0, 133.0, 270.0, 510.0, 700.0] {
            for depth in [5.0, 9.0, 17.0, 30.0] {
                let lengths_m = [width, spacing, depth].map(|length: f64| length * 1e-6);
                let design = Pattern::new(Planform::Groove, lengths_m[0], lengths_m[1], lengths_m[2]).unwrap();
                let Ok(exact) = models.at(&design) else { continue };
                let near = found.at(lengths_m).unwrap();
                for load in 0..2 {
                    worst[0] = worst[0].max((near.log_ratio[load] - exact.log_ratio[load]).abs());
                    worst[1] = worst[1].max((near.sensitivity[load] - exact.sensitivity[load]).abs());
                }
            }
        }
    }
    assert!(worst[0] < 0.01 && worst[1] < 0.02, "{worst:?}");
    // Corners are nodes.
    let corner = [60e-6, 700e-6, 5e-6];
    let exact = models.at(&Pattern::new(Planform::Groove, corner[0], corner[1], corner[2]).unwrap()).unwrap();
    let near = found.at(corner).unwrap();
    assert!((near.log_ratio[1] - exact.log_ratio[1]).abs() < 1e-6);
    // Samples whose widths scatter: the variance is the slope's square, and loads move together.
    let covariance = |std_um: [f64; 3], width_spacing_correlation: f64| {
        let std_m = std_um.map(|um| um * 1e-6);
        let tolerances = Tolerances { std_m, width_spacing_correlation, ..Tolerances::default() };
        let design = Pattern::new(Planform::Groove, 120e-6, 300e-6, 15e-6).unwrap();
        let shifts = found.dimension_shifts(&design, &tolerances).unwrap();
        let entry = |l: usize, m: usize| shifts.iter().map(|of| of.log_ratio[l] * of.log_ratio[m]).sum::<f64>();
        [entry(0, 0), entry(0, 1), entry(1, 0), entry(1, 1)]
    };
    let of_width = covariance([5.0, 0.0, 0.0], 0.0);
    assert!(of_width[3] > 0.0 && (of_width[1].powi(2) / (of_width[0] * of_width[3]) - 1.0).abs() < 1e-9);
    // Wider cavities that are nearer each lower friction: where the pitch is exact both do, and deviations add up.
    let of_spacing = covariance([0.0, 5.0, 0.0], 0.0);
    let both = covariance([5.0, 5.0, 0.0], -1.0);
    // Both at once differ from each alone by the curvature of the interpolated model.
    let sum = of_width[3].sqrt() + of_spacing[3].sqrt();
    assert!((both[3].sqrt() / sum - 1.0).abs() < 0.02, "{both:?} {sum}");
    let apart = covariance([5.0, 5.0, 0.0], 0.0);
    assert!((apart[3] - of_width[3] - of_spacing[3]).abs() < 1e-12, "{apart:?}");
}

#[test]
fn without_trials_every_chance_is_small_and_no_texture_comes_twice() {
    let task = task(Planform::Groove);
    let options = NextOptions { count: 4, ..NextOptions::default() };
    let found = next_trials(&task, &options, &Unwatched).unwrap();
    assert_eq!((found.report.trials, found.report.advice.as_str()), (0, "trial"));
    assert_eq!(found.patterns.len(), 4);
    for (place, pattern) in found.patterns.iter().enumerate() {
        assert!(!found.patterns[..place].iter().any(|other| is_same(&Features::from(other), &Features::from(pattern))));
    }
    let first = &found.report.next[0];
    assert!(first.chance > 0.0 && first.chance < 0.3, "{}", first.chance);
    assert!(found.report.one_on_target >= first.chance - 0.03, "{}", found.report.one_on_target);
    assert!(
        first.predicted.iter().all(|at| at.of.interval_95[0] < at.of.modelled && at.of.modelled < at.of.interval_95[1])
    );
    let again = next_trials(&task, &options, &Unwatched).unwrap();
    assert_eq!(again.report, found.report);
    let text = found.report.text();
    assert!(text.contains("next 4") && text.contains("\ntells bits: how much measuring this sample"), "{text}");
    // What is doubtful of the material and of the loads stands below the advice, in the words of `optimize`.
    let mut doubtful = found.report.clone();
    doubtful.material.warnings = vec!["slope: odd".to_owned(), "contradicting samples: A and B".to_owned()];
    doubtful.material.synthetic_surface = true;
    doubtful.beyond_measured = beyond_measured_range(&[12.0], Some([0.65, 2.6]));
    let said = doubtful.text();
    let doubts = "on target\n! at 12 MPa outside the measured range: the nearest measurement's coefficients were taken (friction was measured \
                  from 0.65 to 2.6 MPa)\n! the material is doubtful: slope: odd\n! the material is doubtful: contradicting samples: A and B\n\
                  the area law rests on a synthetic surface, not on a measured one\n";
    assert!(said.contains(doubts), "{said}");
    // Why the first is recommended, from its own numbers.
    let said = format!(
        "why the first: of the {} designs compared none has a clearly greater chance than",
        found.report.designs
    );
    assert!(text.contains(&said) && text.contains("a first trial is cut to learn how far the model is off"), "{text}");
}

/// A design is chosen by what its trial will be modelled as, on the specimen that it is cut into.
#[test]
fn ratios_that_are_predicted_are_those_of_the_specimen() {
    let mut task = task(Planform::Groove);
    task.layer.thickness_m = Some(7e-3);
    // A surface whose friction falls faster, on which the rim tells.
    let law = AreaLaw::new(vec![0.7e6, 2.6e6, 10e6], vec![1.0, 0.6, 0.2]).unwrap();
    task.material.as_mut().unwrap().material.area_law = Some(law);
    let found = next_trials(&task, &NextOptions { count: 1, ..NextOptions::default() }, &Unwatched).unwrap();
    let material = &task.material.as_ref().unwrap().material;
    let pattern = Some(found.patterns[0]);
    let ratios = |extent, specimen: Option<&slipgrid_export::Specimen>| {
        let run = RunOptions { extent, refine: true, seed: task.seed, ..RunOptions::default() };
        let run = if specimen.is_some() { run.from_sliding() } else { run };
        let scene = Scene { pattern, ..task.flat_scene(material, task.loads(material).unwrap().0, run) };
        // What time adds is that of even sliding.
        let speed_m_s = even_speed_m_s(&scene.elastic, scene.loads[0].pressure_pa);
        let scene = if specimen.is_some() { Scene { speed_m_s, ..scene }.in_time() } else { scene };
        simulate_on(&scene, specimen, &Unwatched).unwrap().loads
    };
    let specimen = ratios(Extent::Sample, Some(&task.specimen));
    let by_time: Vec<f64> = specimen.iter().map(|load| load.ratio_time_change.unwrap()).collect();
    assert!(by_time[0] > 2e-3, "{by_time:?}");
    let ratio = |load: &LoadOutcome| load.ratio.unwrap();
    let off: Vec<[f64; 2]> = found.report.next[0]
        .predicted
        .iter()
        .zip(specimen.iter().zip(&ratios(Extent::Cell, None)))
        .map(|(at, (specimen, cell))| [at.of.modelled - ratio(specimen), ratio(cell) - ratio(specimen)])
        .collect();
    assert!(off.iter().all(|[own, _]| own.abs() < 1e-3) && off.iter().any(|[_, cell]| cell.abs() > 3e-3), "{off:?}");
}

#[test]
fn squares_are_chosen_in_space() {
    let mut task = task(Planform::Square);
    // A thin layer: cells in space take milliseconds.
    task.layer = Layer { height_m: 40e-6, block_m: 20e-6, ..task.layer };
    let found = next_trials(&task, &NextOptions::default(), &Unwatched).unwrap();
    assert_eq!(found.patterns.len(), 1);
    assert_eq!(found.report.next[0].design.planform, "square");
}

#[test]
fn sectors_of_one_disc_hold_what_is_chosen_for_them() {
    let task = task(Planform::Groove);
    let asked = |count, one_disc| {
        let options = NextOptions { count, one_disc, ..NextOptions::default() };
        next_trials(&task, &options, &Unwatched)
    };
    let (disc, apart) = (asked(7, true).unwrap(), asked(7, false).unwrap());
    assert_eq!((disc.patterns.len(), disc.sectors.len(), apart.sectors.len()), (7, 7, 0));
    let (of, report) = (disc.sectors[0].division(), disc.report.one_disc.as_ref().unwrap());
    assert!(apart.report.one_disc.is_none());
    // Seven sectors of a disc of 10 mm hold circles of 2.7 mm: periods of 0.68 mm at most, where bounds reach to 1 mm.
    assert!(of.least_circle_m() > 2.6e-3 && of.least_circle_m() < 2.8e-3);
    assert!(disc.patterns.iter().all(|pattern| 4.0 * pattern.pitch_m() <= of.least_circle_m()));
    assert!(disc.report.designs < apart.report.designs, "{} {}", disc.report.designs, apart.report.designs);
    for (sector, own) in disc.sectors.iter().zip(&report.sectors) {
        assert!((own.areal_density / sector.pattern().areal_density() - 1.0).abs() < 0.1, "{own:?}");
    }
    let text = disc.report.text();
    assert!(text.contains("disc 1: 7 sectors") && text.contains("a mean of all sectors"), "{text}");
    assert_eq!(asked(7, true).unwrap().report, disc.report);
    for (count, says) in [(1, "expected 2 to 12"), (13, "expected 2 to 12")] {
        assert!(asked(count, true).unwrap_err().to_string().contains(says));
    }
    let mut small = task.clone();
    small.specimen.outline = slipgrid_export::Outline::Disc { diameter_m: 1e-3 };
    let options = NextOptions { count: 4, one_disc: true, ..NextOptions::default() };
    let refused = next_trials(&small, &options, &Unwatched).unwrap_err().to_string();
    assert!(refused.contains("expected fewer sectors"), "{refused}");
    // Sectors of a rectangle are said to be such; the names of specimens that were cut are not given again.
    small.specimen.outline = slipgrid_export::Outline::Rectangle { length_m: 12e-3, width_m: 12e-3 };
    let options = NextOptions { discs: vec![format!("{}, rectangle 1", disc.report.name)], ..options };
    let rectangle = next_trials(&small, &options, &Unwatched).unwrap().report.text();
    assert!(
        rectangle.contains("rectangle 2: 4 sectors") && rectangle.contains("the specimen is a rectangle"),
        "{rectangle}"
    );
}

/// On one disc all are off together: the more a disc is off by, the less a further sector helps.
#[test]
fn the_chance_of_one_of_several_counts_what_one_disc_is_off_by() {
    let mut task = task(Planform::Groove);
    // What the model says of some grooves is reached by them.
    let model = model(&task);
    let grooves = Pattern::new(Planform::Groove, 120e-6, 300e-6, 15e-6).unwrap();
    let reached = Models::new(&model, &MaterialUncertainty::default()).unwrap().at(&grooves).unwrap().log_ratio;
    let points = [0.65e6, 2.6e6].into_iter().zip(reached);
    let points = points.map(|(pressure_pa, log)| TargetPoint { pressure_pa, value: log.exp() }).collect();
    task.target = Target::new(Quantity::Ratio, points, 0.02).unwrap();
    let together = |task: &DesignTask, one_disc| {
        let options = NextOptions { count: 3, one_disc, ..NextOptions::default() };
        next_trials(task, &options, &Unwatched).unwrap().report.one_on_target
    };
    // Without the model's shortcomings a texture on target is found, and the disc alone may miss it.
    let prior = Hyperparameters {
        amplitude_std: 0.0,
        pressure_std: 0.0,
        inverse_pressure_std: 0.0,
        ..Hyperparameters::default()
    };
    let with = |sample_std: f64| {
        let prior = Hyperparameters { speed_std: 0.0, humidity_std: 0.0, sample_std, ..prior.clone() };
        Discrepancy::new(prior, Conditions::default(), 0.0, Vec::new()).unwrap()
    };
    let mut chance = |sample_std: f64, one_disc| {
        let known = MaterialUncertainty { learned: Some(with(sample_std)), ..MaterialUncertainty::default() };
        task.material = Some(crate::task::KnownMaterial { uncertainty: known, ..task.material.clone().unwrap() });
        together(&task, one_disc)
    };
    assert_eq!(chance(0.0, true).to_bits(), chance(0.0, false).to_bits());
    let (little, much) = (chance(0.002, true), chance(0.04, true));
    assert!(little > 0.9 && much < 0.8, "{little} {much}");
}

/// A target that narrow grooves alone reach.
fn reached_by(task: &mut DesignTask, lengths_m: [f64; 3]) {
    let model = model(task);
    let grooves = Pattern::new(Planform::Groove, lengths_m[0], lengths_m[1], lengths_m[2]).unwrap();
    let reached = Models::new(&model, &MaterialUncertainty::default()).unwrap().at(&grooves).unwrap().log_ratio;
    let points = [0.65e6, 2.6e6].into_iter().zip(reached);
    let points = points.map(|(pressure_pa, log)| TargetPoint { pressure_pa, value: log.exp() }).collect();
    task.target = Target::new(Quantity::Ratio, points, 0.01).unwrap();
}

#[test]
fn no_narrower_bounds_and_no_neighbour_have_a_clearly_greater_chance() {
    let mut task = task(Planform::Groove);
    reached_by(&mut task, [80e-6, 120e-6, 28e-6]);
    let chances = |task: &DesignTask, own: Vec<Pattern>| {
        let found = next_trials(task, &NextOptions { own, ..NextOptions::default() }, &Unwatched).unwrap();
        let own: Vec<f64> = found.report.own.iter().map(|own| own.chance).collect();
        (found.report.next[0].chance, found.patterns[0], own)
    };
    let (chance, best, _) = chances(&task, Vec::new());
    let block_m = task.layer.block_m;
    let steps = [[block_m, 0.0, 0.0], [0.0, block_m, 0.0], [0.0, 0.0, 2e-6], [block_m, block_m, 0.0]];
    let lengths_m = best.lengths_m();
    let moved = |by: [f64; 3], side: f64| {
        let [width_m, spacing_m, depth_m] = std::array::from_fn(|axis| lengths_m[axis] + side * by[axis]);
        let is_within = |[low, high]: [f64; 2], length_m: f64| (low..=high).contains(&length_m);
        let space = &task.space;
        let within = is_within(space.width_m(), width_m) && is_within(space.spacing_m(), spacing_m);
        let within = within && is_within(space.depth_m(), depth_m);
        within.then(|| Pattern::new(Planform::Groove, width_m, spacing_m, depth_m).unwrap())
    };
    let neighbours = steps.into_iter().flat_map(|by| [moved(by, 1.0), moved(by, -1.0)]).flatten().collect();
    let (again, _, own) = chances(&task, neighbours);
    assert_eq!(again.to_bits(), chance.to_bits());
    assert!(own.len() > 3 && own.iter().all(|own| *own < chance + 0.005), "{chance} {own:?}");
    let narrower = DesignSpace::new(Planform::Groove, [60e-6, 120e-6], [100e-6, 200e-6], [20e-6, 30e-6]).unwrap();
    let inside = chances(&DesignTask { space: narrower, ..task.clone() }, Vec::new()).0;
    assert!(inside < chance + 0.005, "{inside} {chance}");
}

/// The stages that began, with the shares of their work that were done.
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

/// Where nothing may be asked any more.
struct Over;

impl Monitor for Over {
    fn cancelled(&self) -> bool {
        true
    }
}

#[test]
fn every_stage_comes_to_its_whole_and_a_search_that_is_over_asks_nothing() {
    let task = task(Planform::Groove);
    let shares = Shares::default();
    next_trials(&task, &NextOptions { count: 1, ..NextOptions::default() }, &shares).unwrap();
    let all = shares.0.into_inner().unwrap();
    assert_eq!(all.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["model", "trials"]);
    assert!(all.iter().all(|(_, share)| (share - 1.0).abs() < 1e-6), "{all:?}");

    let model = model(&task);
    let asked = asked(&task, &known(), &[], &model).unwrap();
    let (models, chances) =
        (Models::new(&model, &known()).unwrap(), Chances::new(&task, &known(), &model, &[]).unwrap());
    let scope = Scope::BESIDE;
    let beyond = endless(&task, &model);
    let nodes = Interpolation::new(&task, &models, &beyond, &scope, &Unwatched).unwrap();
    let search = Search::new(&task, &asked, (&models, &beyond), &chances, (&nodes, &scope), &Over);
    let (pool, compared) = search.best(&|_, _| true, 0.0, 1);
    assert_eq!((pool.len(), compared), (0, 0));
}

#[test]
fn what_the_laser_cannot_cut_is_said_with_the_number_of_the_sample() {
    let mut task = task(Planform::Groove);
    task.constraints.limits = ManufacturingLimits { spot_m: Some(20e-6), ..ManufacturingLimits::default() };
    // 20 um spots every 2 um on lines 10 um apart: one pass removes 3.1416 um.
    task.laser = slipgrid_export::Laser {
        spot_um: Some(20.0),
        repetition_hz: Some(50e3),
        speed_mm_s: Some(100.0),
        hatch_um: Some(10.0),
        depth_per_burst_um: Some(0.2),
        ..slipgrid_export::Laser::default()
    };
    let said = |width_um: f64, depth_um: f64| -> Vec<String> {
        let whole = Pattern::new(Planform::Groove, 120e-6, 300e-6, 4e-6 * std::f64::consts::PI).unwrap();
        let own = Pattern::new(Planform::Groove, width_um * 1e-6, 300e-6, depth_um * 1e-6).unwrap();
        let all = laser_warnings(&task, [whole, own].iter());
        all.into_iter().filter(|said| !said.contains("mean depth")).collect()
    };
    // Written to a hundredth of a micrometre, four passes remove 12.57 um.
    assert_eq!(said(120.0, 12.57), Vec::<String>::new());
    let off = said(120.0, 12.6);
    assert!(
        off.len() == 1 && off[0].starts_with("sample 2: the depth of 12.6 um is no whole number of passes"),
        "{off:?}"
    );
    let narrow = said(15.0, 12.57);
    assert!(narrow[0].contains("laser spot") && narrow.iter().all(|said| said.starts_with("sample 2: ")), "{narrow:?}");
}

#[test]
fn a_median_is_near_what_is_accepted_within_the_tolerance_on_either_side() {
    let mut task = task(Planform::Groove);
    let model = model(&task);
    let mut near = |wanted: Accepted, ratio: f64| {
        let demand = slipgrid_optimize::Demand { pressure_pa: 2.6e6, wanted, weight: 1.0 };
        task.target = Target::of(Quantity::Ratio, vec![demand], None).unwrap();
        let tolerance = asked(&task, &known(), &[], &model).unwrap().tolerances[0];
        let [lowest, highest] = wanted.band();
        let of = RatioPrediction {
            pressure_mpa: 2.6,
            speed_mm_s: 2.0,
            humidity_pct: 40.0,
            modelled: ratio,
            ratio,
            interval_95: [ratio; 2],
        };
        PredictedRatio { of, lowest, highest }.is_near(tolerance)
    };
    let at_most = Accepted::AtMost { highest: 0.8, margin: 0.02 };
    assert!(near(at_most, 0.1) && near(at_most, 0.815) && !near(at_most, 0.83));
    let between = Accepted::Between { lowest: 0.8, highest: 0.9 };
    assert!(near(between, 0.76) && near(between, 0.94) && !near(between, 0.74) && !near(between, 0.96));
}
