use super::measure::{measure, scene_of, stability_limit_s};
use super::plan::{Change, Family, Method, methods};
use super::scene::{base, paper_scene, reduced};
use super::*;
use slipgrid_model::pattern::{Pattern, Planform};
use slipgrid_model::springblock::{Extent, Fidelity, Layer};

fn named<'a>(methods: &'a [Method], name: &str) -> &'a Method {
    methods.iter().find(|method| method.name == name).unwrap_or_else(|| panic!("no method {name}"))
}

#[test]
fn the_full_plan_has_every_method() {
    let base = base(&paper_scene().unwrap());
    let methods = methods(Size::Full, &base);
    let unique: std::collections::BTreeSet<&str> = methods.iter().map(|method| method.name.as_str()).collect();
    assert_eq!(unique.len(), methods.len());
    // The reference is the unchanged base scene: the published scheme on the whole sample.
    assert!(methods[0].name == "reference" && methods[0].changes.is_empty());
    assert_eq!((base.run.fidelity, base.run.extent), (Fidelity::Reference, Extent::Sample));
    for (family, steps_ns) in [(Family::Leapfrog, &[1.0, 2.0, 4.0, 8.0][..]), (Family::RungeKutta, &[2.0, 4.0, 8.0])] {
        let of_family = || methods.iter().filter(|method| method.family == family).flat_map(|method| &method.changes);
        assert!(steps_ns.iter().all(|step_ns| of_family().any(|change| *change == Change::StepNs(*step_ns))));
        assert!(of_family().any(|change| matches!(change, Change::StepOverLimit(_))));
    }
    for name in ["dynamic, sample, blocks of 2.5 um", "dynamic, cell", "dynamic, sample, warm start", "steady, sample"]
    {
        named(&methods, name);
    }
    assert_eq!(methods.iter().filter(|method| method.default_of.is_some()).count(), 4);
}

#[test]
fn every_method_of_both_plans_is_a_valid_scene_within_its_limits() {
    let full = base(&paper_scene().unwrap());
    let quick = reduced(&full);
    for (size, base) in [(Size::Quick, &quick), (Size::Full, &full)] {
        for method in methods(size, base) {
            // A whole sample and a shorter one have equal limits; the limit is computed for the shorter one.
            let mut scene = base.clone();
            for change in &method.changes {
                change.apply(&mut scene, |scene| stability_limit_s(&reduced(scene)));
            }
            scene.validate().unwrap_or_else(|error| panic!("{}: {error}", method.name));
            if scene.run.fidelity == Fidelity::Steady {
                continue;
            }
            let step_s = scene.run.step_s.unwrap_or(1e-9);
            let mut small = reduced(&scene);
            small.layer.length_m = small.layer.length_m.min(500e-6);
            let limit_s = stability_limit_s(&small).unwrap();
            assert!(step_s < limit_s, "{}: {step_s} above {limit_s}", method.name);
        }
    }
}

#[test]
fn methods_differ_from_the_base_in_what_they_name_alone() {
    let base = reduced(&base(&paper_scene().unwrap()));
    let methods = methods(Size::Quick, &base);
    assert_eq!(scene_of(&methods[0], &base, 0), base);
    assert_eq!(scene_of(&methods[0], &base, 1).run.seed, base.run.seed + 1);
    let limit = scene_of(named(&methods, "leapfrog, linear springs, near limit"), &base, 0);
    // 3.022 sqrt(k/m) bounds omega: 2 / omega_max = 11.76 ns, times 0.97
    assert!((limit.run.step_s.unwrap() - 0.97 * 11.76e-9).abs() < 0.02e-9);
    let blocks = scene_of(named(&methods, "steady, cell, blocks of 2.5 um"), &base, 0);
    assert_eq!((blocks.layer.rows(), blocks.run.extent), (24, Extent::Cell));
}

/// Specimen that even the reference integrates in a fraction of a second.
fn tiny() -> Scene {
    let mut scene = base(&paper_scene().unwrap());
    scene.pattern = Some(Pattern::new(Planform::Groove, 40e-6, 60e-6, 10e-6).unwrap());
    scene.layer = Layer { length_m: 100e-6, height_m: 20e-6, block_m: 10e-6, thickness_m: None, holder: None };
    scene.loads[0].pressure_pa = 2.0e6;
    scene.speed_m_s = 20e-3;
    scene.run.sliding_m = 0.4e-6;
    scene
}

#[test]
fn a_refused_method_has_its_reason() {
    let mut scene = tiny();
    scene.run.step_s = Some(20e-9);
    let run = measure(&scene, &Unwatched);
    assert!(run.status.starts_with("refused: step_s is 2e-8") && !run.has_converged(), "{}", run.status);
    assert_eq!((run.values, run.site_updates), ([None; 3], 0));
}

/// Monitor that provides the time only.
struct Clock(std::time::Instant);

impl Monitor for Clock {
    fn seconds(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}

#[test]
fn a_tiny_comparison_from_end_to_end() {
    let of = compare(Size::Quick, &tiny(), "tiny", 2, ["any", "any"], &Clock(std::time::Instant::now())).unwrap();
    let reference = &of.methods[0];
    assert_eq!((reference.method.name.as_str(), reference.status.as_str()), ("reference", "converged"));
    // 4 evaluations, 1 ns, 12 us of preparation and 20 us of travel, 10 x 2 blocks, both surfaces
    assert_eq!(reference.site_updates, Some(2 * 20 * 4 * 32_000));
    assert!(reference.values.iter().all(|value| value.as_ref().unwrap().difference_pct.is_none()));
    let method = |name: &str| of.methods.iter().find(|of| of.method.name == name).unwrap();
    let dynamic = method("dynamic as it comes, sample");
    assert!(dynamic.values[0].as_ref().unwrap().difference_stderr_pct.unwrap() > 0.0);
    assert_eq!(method("leapfrog, linear springs, 4 ns").step_ns, Some(4.0));
    let steady = method("steady, sample");
    assert!(steady.site_updates.is_none() && steady.values[1].is_none());
    // Each front has a method; of a method with other blocks a difference is no error.
    for observable in [0, 2] {
        let on_front = |method: &&Compared| method.values[observable].as_ref().is_some_and(|value| value.is_on_front);
        let best: Vec<&Compared> = of.methods.iter().filter(on_front).collect();
        assert!(!best.is_empty() && best.iter().all(|of| of.method.family != Family::BlockSize));
    }
    assert!(picture(&of).unwrap().unwrap().starts_with("<svg"));
    assert_eq!(csv(&of).lines().count(), 1 + of.methods.len());
    let columns: Vec<usize> =
        csv(&of).lines().filter(|line| !line.contains(", ")).map(|line| line.split(',').count()).collect();
    assert!(columns.len() > 1 && columns.iter().all(|count| *count == columns[0]), "{columns:?}");
    let text = markdown(&of);
    let widths: Vec<usize> =
        text.lines().filter(|line| line.contains("leapfrog, exact")).map(|line| line.matches('|').count()).collect();
    assert!(!widths.is_empty() && widths.iter().all(|bars| *bars == 10), "{widths:?}");
    assert_eq!(text.matches("the default of ").count(), 8, "{text}");
    assert!(text.contains("Front of wall time against error in ratio, fastest first: "));
}
