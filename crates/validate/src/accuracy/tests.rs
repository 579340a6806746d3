use super::difference::Quantity;
use super::measure::{Run, measure, scene_of, stability_limit_s};
use super::plan::{Change, Family, Role, Row, Size, rows};
use super::report::{AccuracyReport, Machine};
use super::scene::{base, paper_scene, reduced};
use super::*;
use slipgrid_model::springblock::{Extent, Fidelity, Layer};

const MACHINE: Machine = Machine { architecture: "any", system: "any", processors: Some(2), date: None };

fn row<'a>(rows: &'a [Row], name: &str) -> &'a Row {
    rows.iter().find(|row| row.name == name).unwrap_or_else(|| panic!("no row {name}"))
}

#[test]
fn the_full_plan_has_every_row_asked_for() {
    let base = base(&paper_scene().unwrap());
    let rows = rows(Size::Full, &base, 4);
    let unique: std::collections::BTreeSet<&str> = rows.iter().map(|row| row.name.as_str()).collect();
    assert_eq!(unique.len(), rows.len());
    let of = |role| rows.iter().filter(move |row| row.role == role);
    assert_eq!([Role::Judge, Role::Base, Role::Seeds].map(|role| of(role).count()), [1; 3]);
    // The reference is the unchanged base scene: the published scheme on the whole sample.
    assert!(rows[0].role == Role::Judge && rows[0].changes.is_empty());
    assert_eq!((base.run.fidelity, base.run.extent), (Fidelity::Reference, Extent::Sample));
    let steps = |family| -> Vec<Change> {
        let changes =
            of(Role::Method).filter(move |row: &&Row| row.family == family).flat_map(|row| row.changes.clone());
        changes.filter(|change| matches!(change, Change::StepNs(_) | Change::StepOverLimit(_))).collect()
    };
    for step_ns in [1.0, 2.0, 4.0, 8.0] {
        assert!(steps(Family::Leapfrog).contains(&Change::StepNs(step_ns)), "{step_ns}");
    }
    for step_ns in [2.0, 4.0, 8.0] {
        assert!(steps(Family::RungeKutta).contains(&Change::StepNs(step_ns)), "{step_ns}");
    }
    assert!(steps(Family::Leapfrog).iter().any(|step| matches!(step, Change::StepOverLimit(_))));
    let names: Vec<&str> = of(Role::Method).chain(of(Role::Choice)).map(|row| row.name.as_str()).collect();
    for name in [
        "dynamic, sample, blocks of 20 um",
        "dynamic, sample, blocks of 5 um",
        "dynamic, sample, blocks of 2.5 um",
        "layer of 100 um",
        "layer of 400 um",
        "damping of 0.003 sqrt(k/m)",
        "damping of 0.03 sqrt(k/m)",
        "damping of 0.1 sqrt(k/m)",
        "0.4 mm/s",
        "4 mm/s",
        "dynamic, cell",
        "dynamic, sample, warm start",
        "steady, sample",
    ] {
        assert!(names.contains(&name), "{name} in {names:?}");
    }
    assert_eq!(of(Role::Seeds).map(|row| row.seeds).collect::<Vec<_>>(), [10]);
    assert!(of(Role::Method).all(|row| row.seeds == 4 && Family::METHODS.contains(&row.family)));
    assert_eq!(of(Role::Method).filter(|row| row.default_of.is_some()).count(), 4);
}

#[test]
fn every_row_of_both_plans_is_a_valid_scene_within_its_limits() {
    let full = base(&paper_scene().unwrap());
    let quick = reduced(&full);
    for (size, base) in [(Size::Quick, &quick), (Size::Full, &full)] {
        for row in rows(size, base, 2) {
            // A whole sample and a shorter one have equal limits; the limit is computed for the shorter one.
            let mut scene = base.clone();
            for change in &row.changes {
                change.apply(&mut scene, |scene| stability_limit_s(&reduced(scene)));
            }
            scene.validate().unwrap_or_else(|error| panic!("{}: {error}", row.name));
            if scene.run.fidelity == Fidelity::Steady {
                continue;
            }
            let step_s = scene.run.step_s.unwrap_or(1e-9);
            let mut small = reduced(&scene);
            small.layer.length_m = small.layer.length_m.min(500e-6);
            let limit_s = stability_limit_s(&small).unwrap();
            assert!(step_s < limit_s, "{}: {step_s} above {limit_s}", row.name);
        }
    }
}

#[test]
fn rows_differ_from_the_base_in_what_they_name_alone() {
    let base = reduced(&base(&paper_scene().unwrap()));
    let rows = rows(Size::Quick, &base, 2);
    assert_eq!(scene_of(&rows[0], &base, 0), base);
    let layer = scene_of(row(&rows, "layer of 120 um"), &base, 1);
    assert_eq!((layer.run.fidelity, layer.run.seed, layer.layer.rows()), (Fidelity::Dynamic, base.run.seed + 1, 12));
    // A layer twice as high slides after twice the travel.
    assert!((layer.run.sliding_m / base.run.sliding_m - 2.0).abs() < 1e-12);
    let limit = scene_of(row(&rows, "leapfrog, linear springs, near limit"), &base, 0);
    // 3.022 sqrt(k/m) bounds omega: 2 / omega_max = 11.76 ns, times 0.97
    assert!((limit.run.step_s.unwrap() - 0.97 * 11.76e-9).abs() < 0.02e-9);
    let blocks = scene_of(row(&rows, "steady, cell, blocks of 2.5 um"), &base, 0);
    assert_eq!((blocks.layer.rows(), blocks.run.extent), (24, Extent::Cell));
}

/// Specimen that even the reference integrates in a fraction of a second.
fn tiny() -> Scene {
    let mut scene = base(&paper_scene().unwrap());
    scene.pattern = Some(
        slipgrid_model::pattern::Pattern::new(slipgrid_model::pattern::Planform::Groove, 40e-6, 60e-6, 10e-6).unwrap(),
    );
    scene.layer = Layer { length_m: 100e-6, height_m: 20e-6, block_m: 10e-6, thickness_m: None, holder: None };
    scene.loads[0].pressure_pa = 2.0e6;
    scene.speed_m_s = 20e-3;
    scene.run.sliding_m = 0.4e-6;
    scene
}

#[test]
fn a_refused_row_is_a_row_with_its_reason() {
    let mut scene = tiny();
    scene.run.step_s = Some(20e-9);
    let run = measure(&scene, &Unwatched);
    assert!(run.status.starts_with("refused: step_s is 2e-8") && !run.converged, "{}", run.status);
    assert_eq!((run.mu_dynamic, run.site_updates), (None, 0));
}

/// Monitor that provides the time only.
struct Clock(std::time::Instant);

impl Monitor for Clock {
    fn seconds(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}

#[test]
fn a_tiny_page_from_end_to_end() {
    let base = tiny();
    let machine = Machine { architecture: "a", system: "s", processors: None, date: None };
    let report = compare(Size::Quick, &base, "tiny", 2, machine, &Clock(std::time::Instant::now())).unwrap();
    assert_eq!(report.reference.status, "converged");
    // 4 evaluations, 1 ns, 12 us of preparation and 20 us of travel, 10 x 2 blocks, both surfaces
    assert_eq!(report.reference.site_updates, Some(2 * 20 * 4 * 32_000));
    let method = |name: &str| report.methods.iter().find(|row| row.name == name).unwrap();
    let dynamic = method("dynamic as it comes, sample");
    let four = method("leapfrog, linear springs, 4 ns");
    assert_eq!(dynamic.status, "converged");
    assert!(dynamic.mu_dynamic.unwrap().difference_stderr_pct.unwrap() > 0.0);
    assert_eq!((four.step_ns, four.seeds), (Some(4.0), 2));
    assert!(method("steady, sample").site_updates.is_none());
    // The layer at half height is a single row, which a cavity of one row cuts through.
    let thin = report.choices.iter().find(|row| row.name == "layer of 10 um").unwrap();
    assert!(thin.status.starts_with("refused: the cavity is"), "{}", thin.status);
    let blocks: Vec<Option<f64>> =
        report.discretization.iter().map(|row| row.ratio.and_then(|ratio| ratio.difference_pct)).collect();
    assert!(
        blocks.len() == 4 && blocks[1].is_some_and(|percent| percent != 0.0) && blocks[3] == Some(0.0),
        "{blocks:?}"
    );
    assert_eq!(report.scatter.seeds, 10);
    // Each front has a method, and all defaults are judged.
    assert!(report.fronts.iter().all(|front| !front.methods.is_empty() && front.defaults.len() == 4));
    assert!(text::picture(&report).unwrap().unwrap().starts_with("<svg"));
    assert_eq!(text::csv(&report).lines().count(), 1 + 4 - 1 + report.methods.len() + report.choices.len());
    let page = text::markdown(&report);
    let widths: Vec<usize> =
        page.lines().filter(|line| line.contains("leapfrog, exact")).map(|line| line.matches('|').count()).collect();
    assert!(!widths.is_empty() && widths.iter().all(|bars| *bars == 10), "{widths:?}");
}

/// Page of synthetic runs with a known text.
fn fixed_report() -> AccuracyReport {
    let make = |name: &str, family, role, default_of| Row {
        name: name.to_owned(),
        label: name.to_owned(),
        family,
        role,
        changes: vec![],
        seeds: 2,
        default_of,
    };
    let rows = [
        make("reference", Family::RungeKutta, Role::Judge, None),
        make("quick and wrong", Family::Steady, Role::Method, Some("simulate")),
        make("good", Family::Leapfrog, Role::Method, None),
        make("slow", Family::Shortcut, Role::Method, Some("optimize")),
        make("as in the scene", Family::Damping, Role::Base, None),
        make("twice the speed", Family::Speed, Role::Choice, None),
        make("draws", Family::Damping, Role::Seeds, None),
    ];
    let run = |seed: u64, wall_s: f64, mu: f64, stderr: f64, updates: u64| Run {
        seed,
        status: "converged".to_owned(),
        converged: true,
        wall_s,
        site_updates: updates,
        site_updates_per_s: (updates > 0).then(|| updates as f64 / wall_s),
        dt_s: (updates > 0).then_some(4e-9),
        mu_dynamic: Some(mu),
        mu_dynamic_stderr: Some(stderr),
        mu_static: (updates > 0).then_some(1.25 * mu),
        ratio: None,
        ratio_stderr: None,
    };
    let runs =
        |wall_s, mu, stderr, updates| vec![run(1, wall_s, mu, stderr, updates), run(2, wall_s, mu, stderr, updates)];
    let stderr = 0.25e-3 * 2.0_f64.sqrt();
    let all = [
        runs(64.0, 0.25, stderr, 1 << 30),
        runs(0.25, 0.24, 0.0, 0),
        runs(1.0, 0.2501, stderr, 1 << 20),
        runs(4.0, 0.2500, stderr, 1 << 22),
        runs(1.0, 0.25, stderr, 1 << 20),
        runs(1.0, 0.255, stderr, 1 << 20),
        vec![run(1, 1.0, 0.25, stderr, 1), run(2, 1.0, 0.26, stderr, 1)],
    ];
    AccuracyReport::new("quick", vec!["made up".to_owned()], &rows, &all, MACHINE, 70.0, 2)
}

#[test]
fn a_fixed_page_reads_as_it_should() {
    let report = fixed_report();
    let page = text::markdown(&report);
    for line in [
        "# Speed against error (quick)",
        "- made up",
        "| dynamic mu | 0.25000 | 0.00025 | 0.00000 |",
        "| static mu | 0.31250 | - | 0.00000 |",
        "| **quick and wrong** | - | - | -4.00 +- 0.10 | - | - | converged | 0.250 | - |",
        "| good | 4.00 | 1.05e6 | +0.04 +- 0.14 n.s. | +0.04 +- 0.00 | - | converged | 1.00 | 1.05e6 |",
        "| twice the speed | +2.00 +- 0.14 | +2.00 +- 0.00 | - | converged |",
        "| dynamic mu | 0.25500 | 0.00707 | 2.77 |",
        "- on the front: quick and wrong, the default of simulate",
        "- not on the front: slow, the default of optimize; good is faster and no less accurate",
        "slipgrid 0.1.0, any, any, 2 processors; 70 s on 2 threads in all.",
    ] {
        assert!(page.lines().any(|found| found == line), "{line}\nin\n{page}");
    }
    assert!(page.contains("fastest first: quick and wrong; good. Errors below 0.35 % cannot be told apart"));
    assert!(
        text::csv(&report)
            .lines()
            .any(|line| line.starts_with("method,leapfrog,\"good\",\"\",\"converged\",2,4,1048576,0.2501,"))
    );
}

#[test]
fn the_front_is_of_resolved_errors() {
    let report = fixed_report();
    assert_eq!(report.fronts.len(), 1);
    assert_eq!(report.fronts[0].quantity, Quantity::MuDynamic.name());
    // 1.25 x 2 sqrt 2 x 0.00025 / 0.25
    assert!((report.fronts[0].resolution_pct - 0.25 * 2.0_f64.sqrt()).abs() < 1e-12);
}

#[test]
fn a_default_is_also_judged_among_methods_that_answer_as_much() {
    let mut report = fixed_report();
    // The better method no longer gives static friction: the default is the best of the methods that do.
    report.methods[1].mu_static = None;
    let front = report::FrontReport::new(Quantity::MuDynamic, &report.methods, &report.reference).unwrap();
    let slow = &front.defaults[1];
    assert_eq!((slow.on_front, slow.better.as_deref()), (false, Some("good")));
    assert_eq!(slow.among_static, Some(report::AmongStatic { on_front: true, better: None }));
    report.fronts = vec![front];
    let page = text::markdown(&report);
    assert!(page.contains("gives no static mu, and among the methods that do this one is on the front"), "{page}");
}
