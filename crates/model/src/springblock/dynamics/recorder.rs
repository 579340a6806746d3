//! History of a dynamic run: friction coefficient against time, the mean over the stationary part of sliding with a
//! standard error from batch means, the static peak, and the mean forces on the contact blocks.

use super::contact::{ContactForce, ContactSums};
use super::engine::Engine;
use super::stationary::stationary_from;
use crate::springblock::TracePoint;

/// Number of batches in the averaging window. Fewer batches make the error estimate noisy; with more, batches are short
/// compared with the correlation time of the friction force (two microseconds, the period of the layer's shear mode).
const BATCHES: usize = 20;
/// Number of steps between two samples of the contact forces for the mean interface.
const INTERFACE_EVERY: u64 = 64;

/// Mean friction coefficient over the averaging window of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindowMean {
    /// Mean friction coefficient.
    pub mu: f64,
    /// Standard error of `mu`.
    pub stderr: f64,
    /// Mean friction force perpendicular to the drive, divided by the mean normal force.
    pub mu_across: f64,
    /// Friction force over the friction force if every block slides at these normal forces, minus one; `None` if
    /// sliding has no friction.
    pub excess: Option<f64>,
    /// Time from the start of the drive to the first batch, in units of sqrt(m/k), with block mass m and spring
    /// stiffness k.
    pub from: f64,
    /// Whether the record becomes stationary, and at most half of the record since the start of the drive was left out.
    pub is_stationary: bool,
}

/// Records a run from the moment the bulk starts to move.
#[derive(Clone, Debug)]
pub struct Recorder {
    steps_per_bin: u64,
    time_step: f64,
    /// Contact forces, added over the steps of each recording interval.
    bins: Vec<ContactSums>,
    current_bin: ContactSums,
    steps: u64,
    /// Minimum averaging time, in units of sqrt(m/k), with block mass m and spring stiffness k.
    min_time: f64,
    /// Index of the bin in which the last contact block slipped for the first time; `None` before that.
    onset_bin: Option<usize>,
    peak_mu: f64,
    interface: Vec<ContactForce>,
    interface_samples: u64,
    interface_from_bin: usize,
}

impl Recorder {
    /// Creates an empty record with bins of `steps_per_bin` steps of the length `time_step`. Averages cover at least
    /// the time `min_time`; both times are in units of sqrt(m/k), with block mass m and spring stiffness k. Contact
    /// forces are sampled from bin `interface_from_bin` on.
    pub fn new(steps_per_bin: u64, time_step: f64, min_time: f64, interface_from_bin: usize) -> Self {
        Self {
            steps_per_bin,
            time_step,
            bins: Vec::new(),
            current_bin: ContactSums::default(),
            steps: 0,
            min_time,
            onset_bin: None,
            peak_mu: f64::NEG_INFINITY,
            interface: Vec::new(),
            interface_samples: 0,
            interface_from_bin,
        }
    }

    /// Records the contact sums `sums` of one step, and queries `engine` where needed.
    pub fn record(&mut self, sums: ContactSums, engine: &mut impl Engine) {
        self.current_bin.add(sums);
        self.steps += 1;
        if self.onset_bin.is_none() {
            self.peak_mu = sums.mu().map_or(self.peak_mu, |mu| self.peak_mu.max(mu));
            if engine.all_have_slipped() {
                self.onset_bin = Some(self.bins.len());
                self.interface_from_bin = self.interface_from_bin.max(self.bins.len() + 1);
            }
        }
        if self.steps.is_multiple_of(INTERFACE_EVERY) {
            self.sample_interface(engine);
        }
        if self.steps.is_multiple_of(self.steps_per_bin) {
            self.bins.push(std::mem::take(&mut self.current_bin));
        }
    }

    /// Number of steps until [`Self::record`] next queries the engine, including the step with the query.
    pub fn steps_to_next_query(&self) -> u64 {
        if self.has_onset() { INTERFACE_EVERY - self.steps % INTERFACE_EVERY } else { 1 }
    }

    fn sample_interface(&mut self, engine: &mut impl Engine) {
        if self.has_onset() && self.bins.len() >= self.interface_from_bin {
            self.interface_samples += 1;
            let forces = engine.contact_forces();
            self.interface.resize(forces.len(), ContactForce::default());
            for (mean, force) in self.interface.iter_mut().zip(forces) {
                mean.normal += force.normal;
                mean.friction += force.friction;
            }
        }
    }

    /// Restarts the averaging of contact forces, because the samples so far were not stationary.
    pub fn restart_interface(&mut self) {
        self.interface.clear();
        self.interface_samples = 0;
        self.interface_from_bin = self.bins.len();
    }

    /// Whether every contact block has slipped since the drive began.
    pub fn has_onset(&self) -> bool {
        self.onset_bin.is_some()
    }

    /// Largest friction coefficient until every contact block has slipped; `None` before that.
    pub fn peak_mu(&self) -> Option<f64> {
        (self.has_onset() && self.peak_mu.is_finite()).then_some(self.peak_mu)
    }

    /// Mean friction coefficient over the stationary part of the record after every contact block has slipped, with a
    /// standard error from batch means.
    ///
    /// `None` until the record has two bins per batch after all blocks have slipped, or if the mean is not finite. A
    /// record that becomes stationary too late is averaged over the last two bins per batch.
    pub fn window_mean(&self) -> Option<WindowMean> {
        let sliding = self.bins.get(self.onset_bin? + 1..)?;
        if sliding.len() < 2 * BATCHES {
            return None;
        }
        let mu: Vec<f64> = sliding.iter().map(|bin| bin.mu().unwrap_or(0.0)).collect();
        let least = (self.min_time / self.bin_time()).ceil() as usize;
        let left_out = stationary_from(&mu, least);
        let start = left_out.unwrap_or(0).min(sliding.len() - 2 * BATCHES);
        let before = self.bins.len() - sliding.len() + start;
        let is_stationary = left_out == Some(start) && 2 * before <= self.bins.len();
        let per_batch = (sliding.len() - start) / BATCHES;
        // Bins that do not fill a batch are left out at the beginning.
        let first = self.bins.len() - per_batch * BATCHES;
        let batch_mu: Vec<f64> = self.bins[first..]
            .chunks_exact(per_batch)
            .map(|batch| {
                let (friction, normal) =
                    batch.iter().fold((0.0, 0.0), |(f, n), bin| (f + bin.friction, n + bin.normal));
                friction / normal
            })
            .collect();
        let n = BATCHES as f64;
        let mu = batch_mu.iter().sum::<f64>() / n;
        let variance = batch_mu.iter().map(|b| (b - mu).powi(2)).sum::<f64>() / (n - 1.0);
        let from = first as f64 * self.bin_time();
        let sum = |of: fn(&ContactSums) -> f64| self.bins[first..].iter().map(of).sum::<f64>();
        let (mu_across, sliding) = (sum(|bin| bin.across) / sum(|bin| bin.normal), sum(|bin| bin.sliding));
        let excess = (sliding > 0.0).then(|| sum(|bin| bin.friction) / sliding - 1.0);
        let stderr = (variance / n).sqrt();
        mu.is_finite().then_some(WindowMean { mu, stderr, mu_across, excess, from, is_stationary })
    }

    /// Mean forces on every contact block over the samples since the last restart; returns `last` if there are no
    /// samples.
    pub fn interface(&self, last: &[ContactForce]) -> Vec<ContactForce> {
        let samples = self.interface_samples as f64;
        if self.interface_samples == 0 {
            return last.to_vec();
        }
        self.interface
            .iter()
            .map(|sum| ContactForce { normal: sum.normal / samples, friction: sum.friction / samples })
            .collect()
    }

    /// Duration of a bin, in units of sqrt(m/k), with block mass m and spring stiffness k.
    fn bin_time(&self) -> f64 {
        self.steps_per_bin as f64 * self.time_step
    }

    /// Friction coefficient against time, one point per bin; `unit_time_s` is the unit of the recorded times, in
    /// seconds.
    pub fn trace(&self, unit_time_s: f64) -> Vec<TracePoint> {
        let per_bin = self.bin_time() * unit_time_s;
        self.bins
            .iter()
            .enumerate()
            .filter_map(|(number, bin)| bin.mu().map(|mu| TracePoint { time_s: (number + 1) as f64 * per_bin, mu }))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::springblock::tests::samples::uniform;

    /// An engine with one block that has slipped or not.
    struct OneBlock(bool);

    impl Engine for OneBlock {
        fn begin_drive(&mut self) {}
        fn step(&mut self) -> ContactSums {
            ContactSums::default()
        }
        fn all_have_slipped(&self) -> bool {
            self.0
        }
        fn contact_forces(&mut self) -> Vec<ContactForce> {
            vec![ContactForce::default()]
        }
    }

    #[test]
    fn standard_error_of_independent_samples_is_that_of_their_mean() {
        let mut contact = OneBlock(true);
        let mut recorder = Recorder::new(1, 1.0, 0.0, 0);
        let mut uniform = uniform(1);
        let n = 20_000;
        for _ in 0..n {
            let sums = ContactSums { friction: uniform() - 0.2, normal: 1.0, ..ContactSums::default() };
            recorder.record(sums, &mut contact);
        }
        let mean = recorder.window_mean().unwrap();
        assert!(mean.is_stationary);
        let expected = (1.0_f64 / 12.0 / f64::from(n)).sqrt();
        assert!((mean.stderr / expected - 1.0).abs() < 0.4, "{} {expected}", mean.stderr);
        assert!((mean.mu - 0.3).abs() < 4.0 * expected);
    }

    #[test]
    fn a_straight_line_is_not_stationary_and_its_mean_is_that_of_its_end() {
        let mut contact = OneBlock(true);
        let (steps_per_bin, time_step) = (3, 0.5);
        let mut recorder = Recorder::new(steps_per_bin, time_step, 0.0, 50);
        // mu = t over 107 intervals of 1.5: the last 40 make 20 batches of 2.
        for step in 0..107 * steps_per_bin {
            let mu = (step as f64 + 0.5) * time_step;
            recorder.record(ContactSums { friction: mu, normal: 1.0, ..ContactSums::default() }, &mut contact);
        }
        let mean = recorder.window_mean().unwrap();
        assert!(!mean.is_stationary);
        let end = 107.0 * 1.5;
        assert_eq!(mean.from, (107.0 - 40.0) * 1.5);
        assert!((mean.mu - (mean.from + end) / 2.0).abs() < 1e-9, "{mean:?}");
        let trace = recorder.trace(1.0);
        assert!(trace.iter().any(|point| point.time_s == mean.from) && trace[trace.len() - 1].time_s == end);
    }

    #[test]
    fn no_mean_before_every_block_has_slipped() {
        let mut contact = OneBlock(false);
        let mut recorder = Recorder::new(1, 1.0, 0.0, 10);
        for _ in 0..1000 {
            recorder.record(ContactSums { friction: 0.3, normal: 1.0, ..ContactSums::default() }, &mut contact);
        }
        assert_eq!((recorder.window_mean(), recorder.peak_mu()), (None, None));
    }
}
