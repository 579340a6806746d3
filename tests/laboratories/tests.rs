use super::*;

/// The page that the book quotes equals the results of all laboratories.
#[test]
#[ignore = "ten minutes of two cores"]
fn the_kept_page_is_what_laboratories_do() {
    let report = run(&Options::default(), &Policy::ALL).unwrap();
    let now = format!("# Simulated laboratories\n\n{}\n", report.lines().join("\n"));
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("accuracy/laboratories.md");
    if std::env::var_os("SLIPGRID_UPDATE_GUIDE").is_some() {
        std::fs::write(&path, now).unwrap();
    } else {
        assert_eq!(std::fs::read_to_string(&path).unwrap(), now);
    }
}

/// Results of a few laboratories do not depend on the number of threads. The mixture needs fewer trials than the
/// physics alone and not fewer than the generator, which needs not fewer than the known truth.
#[test]
fn a_few_laboratories_reach_their_targets() {
    let options = Options { laboratories: 9, most_trials: 5, steps: 4, seed: 3 };
    let policies = [Policy::Mixture, Policy::Physics, Policy::Generator, Policy::Truth];
    let found = run(&options, &policies).unwrap();
    let few = Options { laboratories: 1, ..options };
    let on_threads = |count: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap();
        pool.install(|| run(&few, &policies)).unwrap()
    };
    assert_eq!(on_threads(1), on_threads(3));
    for start in &found.starts {
        let mean = |policy: Policy| start.policies.iter().find(|of| of.policy == policy.name()).unwrap().mean;
        let means = policies.map(mean);
        assert!(means[3] <= means[2] && means[2] <= means[0] && means[0] < means[1], "{}: {means:?}", start.start);
    }
    assert_eq!(found.coverage.len(), 1 + Mechanism::ALL.len() + 1);
    assert!(found.lines().iter().any(|line| line.contains("physics alone")));
    // A target that nothing was asked of is met more rarely.
    let [reached, any] = [0, 2].map(|place| found.chances[place].all);
    assert!(any.cuts <= 3 * 27 && any.came_true < reached.came_true && any.said < reached.said, "{any:?} {reached:?}");
}

#[test]
fn who_knows_how_laboratories_are_made_says_nothing_of_what_none_of_them_reaches() {
    let bench = Bench::new(&Options { steps: 2, ..Options::default() }).unwrap();
    let known = Known {
        textures: &bench.textures,
        dimension_shifts: &bench.dimension_shifts,
        cut: &[],
        trials: &[],
        target: &[5.0; LOADS],
        form: None,
        truths: &[],
        noise: 0.01,
        judged_from: 0,
    };
    let found = Informed::new(&bench.generator, true, &known).err();
    assert!(matches!(&found, Some(Failure::Failed(why)) if why.contains("none that was drawn")), "{found:?}");
}

/// The share of targets that textures reach agrees with the share among random targets.
#[test]
fn the_share_of_reached_targets_is_that_of_drawn_ones() {
    let truths =
        [[0.9, 0.89, 0.88, 0.87], [0.91, 0.9, 0.88, 0.86], [0.99, 0.98, 0.97, 0.96], [0.7; LOADS], [0.3; LOADS]];
    let mut normals = Normals::new(3);
    let count = 40_000;
    let reached = (0..count).filter(|_| {
        let target = target(&[], TargetOf::Any, &mut normals);
        let near = around(&target, REACHED * truth::TOLERANCE);
        truths.iter().any(|truth| is_within(truth, &near))
    });
    let (drawn, said) = (reached.count() as f64 / f64::from(count), draws::share_reached(truths.into_iter()));
    assert!((drawn - said).abs() < 0.01, "{drawn} {said}");
}

/// Chances and intervals of the generator are as reliable as they state, for reached and for arbitrary targets.
#[test]
#[ignore = "half a minute: the reference policy of laboratories; the chances of the product's own are tested in crates/design and crates/infer/src/discrepancy"]
fn who_knows_how_laboratories_are_made_says_chances_that_come_true() {
    let options = Options { laboratories: 45, most_trials: 6, steps: 4, seed: 2 };
    let bench = Bench::new(&options).unwrap();
    for target in TargetOf::ALL {
        let jobs = Job::of_reached_targets(&options, &[Policy::Generator]);
        let ways: Vec<Way> = jobs.par_iter().map(|job| bench.way(Job { target, ..*job }).unwrap()).collect();
        let said: Vec<(f64, bool)> = ways.iter().flat_map(|way| way.chances.iter().copied()).collect();
        // Those about one half, and all.
        for least in [0.0, 0.2, 0.5] {
            let own = || said.iter().filter(|(said, _)| *said >= least);
            let expected: f64 = own().map(|(said, _)| said).sum();
            let error = own().map(|(said, _)| said * (1.0 - said)).sum::<f64>().sqrt();
            let found = own().filter(|(_, came_true)| *came_true).count() as f64;
            assert!(expected > 5.0 && (found - expected).abs() < 3.0 * error, "{target:?}: {found} {expected} {error}");
        }
        let below: Vec<f64> = ways.iter().flat_map(|way| way.below.iter().copied()).collect();
        for (half, share) in [(0.34, 0.68), (0.475, 0.95_f64)] {
            let inside = below.iter().filter(|below| (**below - 0.5).abs() <= half).count() as f64 / below.len() as f64;
            // The loads of a sample move together: a sample counts once.
            let error = (share * (1.0 - share) / (below.len() / LOADS) as f64).sqrt();
            assert!((inside - share).abs() < 3.0 * error, "{target:?}: {inside} of {share}, {error}");
        }
    }
}
