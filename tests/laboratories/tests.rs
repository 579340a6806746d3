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
/// physics alone, and not fewer than the known truth.
#[test]
fn a_few_laboratories_reach_their_targets() {
    let options = Options { laboratories: 9, most_trials: 5, steps: 4, seed: 3 };
    let policies = [Policy::Mixture, Policy::Physics, Policy::Truth];
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
        assert!(means[2] <= means[0] && means[0] < means[1], "{}: {means:?}", start.start);
    }
    assert_eq!(found.coverage.len(), 1 + Mechanism::ALL.len());
    assert!(found.lines().iter().any(|line| line.contains("physics alone")));
    // A target that nothing was asked of is met more rarely.
    let [reached, any] = [0, 1].map(|place| found.chances[place].all);
    assert!(any.cuts <= 3 * 27 && any.came_true < reached.came_true && any.said < reached.said, "{any:?} {reached:?}");
}
