//! Engines that take one or two steps at a time get the same calls from the drive.

use super::*;
use crate::springblock::dynamics::contact::ContactSums;
use crate::springblock::tests::samples;
use crate::springblock::{RunOptions, Unwatched, simulate};

/// Test engine whose sums and forces encode the step number.
#[derive(Default)]
struct StepEncodingEngine {
    steps: u64,
    /// Number of steps after which every block has slipped.
    slipped: u64,
    /// Number of steps after which sums are not finite.
    finite: u64,
    two: bool,
    /// Number of steps before the drive began.
    begun: Option<u64>,
    pairs: u64,
}

impl Engine for StepEncodingEngine {
    fn begin_drive(&mut self) {
        self.begun = Some(self.steps);
    }
    fn step(&mut self) -> ContactSums {
        self.steps += 1;
        let friction = if self.steps > self.finite { f64::NAN } else { (self.steps as f64).sin() };
        ContactSums { friction: 0.3 + 0.01 * friction, normal: 1.0, ..ContactSums::default() }
    }
    fn one_or_two_steps(&mut self) -> (ContactSums, Option<ContactSums>) {
        let first = self.step();
        let second = (self.two && first.is_finite()).then(|| self.step());
        self.pairs += u64::from(second.is_some());
        (first, second)
    }
    fn all_have_slipped(&self) -> bool {
        self.steps >= self.slipped
    }
    fn contact_forces(&mut self) -> Vec<ContactForce> {
        vec![ContactForce { normal: self.steps as f64, friction: (self.steps as f64).cos() }]
    }
}

#[test]
fn steps_two_at_once_are_asked_the_same_as_steps_one_by_one() {
    for (warm_start, sliding_m) in [(true, 0.1e-6), (true, 0.0999e-6), (false, 0.0313e-6)] {
        let run = RunOptions { warm_start, sliding_m, ..RunOptions::default() };
        let scene = samples::scene(samples::groove(40.0, 60.0, 20.0), &[2.6], run);
        let drive = Drive {
            scene: &scene,
            pressure_pa: 2.6e6,
            step_s: 5e-9,
            time_step: 1.0,
            evaluations_per_step: 1,
            share: 1.0,
            stderr_share: Some(1e-5),
            blocks: 1,
            shear_period: 7.0,
            started_s: 0.0,
        };
        let preparation = Plan::new(&scene, drive.step_s).preparation;
        for (slipped, finite) in [(0, u64::MAX), (preparation + 333, u64::MAX), (0, 4000), (0, 4001), (u64::MAX, 5000)]
        {
            let [mut one, mut two] =
                [false, true].map(|two| StepEncodingEngine { slipped, finite, two, ..StepEncodingEngine::default() });
            let (single, paired) = (drive.run(&mut one, &Unwatched), drive.run(&mut two, &Unwatched));
            assert_eq!((one.steps, one.begun, one.pairs), (two.steps, two.begun, 0));
            assert!(two.pairs > 0 || (warm_start && slipped == u64::MAX), "{slipped} {finite}");
            assert_eq!(
                (single.status, single.mean, single.cost.steps),
                (paired.status, paired.mean, paired.cost.steps)
            );
            assert_eq!(single.recorder.trace(1.0), paired.recorder.trace(1.0));
            assert_eq!(single.last, paired.last);
            assert_eq!(single.recorder.interface(&single.last), paired.recorder.interface(&paired.last));
        }
    }
}

/// Far above the speed of even sliding a run's mean may by chance be near sliding friction or above it.
#[test]
fn nothing_stands_for_sliding_that_is_far_too_fast() {
    let mut scene = samples::scene(samples::groove(40.0, 60.0, 20.0), &[1.3], samples::in_time(2e-6));
    scene.pattern = None;
    scene.layer.length_m = 500e-6;
    let even_m_s = even_speed_m_s(&scene.elastic, 1.3e6);
    for (times, is_even) in [(0.5, true), (11.0, false), (40.0, false), (400.0, false)] {
        scene.speed_m_s = times * even_m_s;
        scene.run.sliding_m = warm_travel_m((&scene.elastic, None), &scene.layer, &scene.loads, scene.speed_m_s);
        let status = simulate(&scene, &Unwatched).unwrap().loads[0].surface.status;
        assert_eq!(status == Status::SlidingWaves, !is_even, "{times}: {status:?}");
    }
}
