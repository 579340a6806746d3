//! Time limit of a job: each stage may use the time that earlier stages left.

use slipgrid_base::monitor::{Monitor, Stage};

/// Share of the remaining time that the table may use, and the search thereafter, so that the best design can be
/// confirmed.
pub const SEARCH_SHARE: f64 = 0.6;
/// Like [`SEARCH_SHARE`], where nothing is confirmed: without a table there is no answer at all.
pub const UNCONFIRMED_SHARE: f64 = 0.9;

/// Deadline of a job, by the clock of its monitor.
#[derive(Clone, Copy)]
pub struct TimeBudget<'a> {
    /// Monitor of the job.
    pub monitor: &'a dyn Monitor,
    until_s: Option<f64>,
    /// Share of the remaining time that the table may use, and the search thereafter.
    pub share: f64,
}

impl<'a> TimeBudget<'a> {
    /// Sets the deadline `most_s` seconds from now; no deadline if `None`. The table, and then the search, may use
    /// `share` of the remaining time.
    pub fn new(monitor: &'a dyn Monitor, most_s: Option<f64>, share: f64) -> Self {
        Self { monitor, until_s: most_s.map(|most_s| monitor.seconds() + most_s), share }
    }

    /// Starts a stage that may use all remaining time.
    pub fn stage(&self, name: &str) -> Stage<'a> {
        Stage::new(self.monitor, name, self.until_s)
    }

    /// Starts a stage that may use the share of the remaining time.
    pub fn stage_of_share(&self, name: &str) -> Stage<'a> {
        let now_s = self.monitor.seconds();
        let until_s = self.until_s.map(|until_s| now_s + (until_s - now_s).max(0.0) * self.share);
        Stage::new(self.monitor, name, until_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU64, Ordering};

    #[derive(Default)]
    struct Clock(AtomicU64);

    impl Monitor for Clock {
        fn seconds(&self) -> f64 {
            self.0.load(Ordering::Relaxed) as f64
        }
    }

    #[test]
    fn what_is_left_is_shared_and_no_limit_is_never_spent() {
        let clock = Clock::default();
        let hour = TimeBudget::new(&clock, Some(3600.0), 0.5);
        clock.0.store(1600, Ordering::Relaxed);
        let half = hour.stage_of_share("search");
        clock.0.store(2599, Ordering::Relaxed);
        assert!(!half.is_out_of_time() && TimeBudget::new(&clock, Some(0.0), 0.5).stage("search").is_out_of_time());
        clock.0.store(2600, Ordering::Relaxed);
        assert!(half.is_out_of_time() && !hour.stage("confirmation").is_out_of_time());
        for unlimited in [None, Some(1e300)] {
            let all = TimeBudget::new(&clock, unlimited, 0.5);
            assert!(!all.stage("search").is_out_of_time());
        }
    }
}
