use super::*;
use slipgrid_monitor::Unwatched;

/// A few laboratories: the same tables at every run, the mixture sooner on target than the physics alone, and never sooner than
/// who knows the truth.
#[test]
fn a_few_laboratories_reach_their_targets() {
    let options = Options { laboratories: 9, most_trials: 5, steps: 4, seed: 3 };
    let policies = [Policy::Mixture, Policy::Physics, Policy::Truth];
    let found = run(&options, &policies, &Unwatched).unwrap();
    assert_eq!(found, run(&options, &policies, &Unwatched).unwrap());
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
    let all: serde_json::Value = serde_json::from_str(&serde_json::to_string(&found).unwrap()).unwrap();
    assert_eq!(serde_json::from_value::<LaboratoriesReport>(all).unwrap(), found);
}

#[test]
fn laboratories_end_when_they_are_cancelled() {
    struct Pressed;
    impl Monitor for Pressed {
        fn cancelled(&self) -> bool {
            true
        }
    }
    let found = run(&Options::default(), &Policy::ALL, &Pressed);
    assert!(matches!(found, Err(StudyError::Cancelled)), "{found:?}");
}
