//! The seconds that a job may take in all: each stage has what those before it left.

use std::time::{Duration, Instant};

/// Share of what is left that a search may take, so that its best design can be confirmed.
pub(super) const SEARCH_SHARE: f64 = 0.6;

/// Until when a job may go on.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Allowance {
    until: Option<Instant>,
}

impl Allowance {
    /// `most_s` seconds from `started` on; no limit when absent.
    pub(super) fn new(started: Instant, most_s: Option<f64>) -> Self {
        // What no clock counts is no limit.
        let until = |most_s: f64| started.checked_add(Duration::try_from_secs_f64(most_s).ok()?);
        Self { until: most_s.and_then(until) }
    }

    /// When the job has to end.
    pub(super) const fn until(&self) -> Option<Instant> {
        self.until
    }

    /// When a stage that may take `share` of what is left has to end.
    pub(super) fn share(&self, share: f64) -> Option<Instant> {
        let now = Instant::now();
        self.until.map(|until| now + until.saturating_duration_since(now).mul_f64(share))
    }

    /// Nothing is left.
    pub(super) fn is_spent(&self) -> bool {
        self.until.is_some_and(|until| Instant::now() >= until)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_is_shared_and_no_limit_is_never_spent() {
        let now = Instant::now();
        let hour = Allowance::new(now, Some(3600.0));
        assert!(!hour.is_spent() && Allowance::new(now, Some(0.0)).is_spent());
        let half = hour.share(0.5).unwrap().duration_since(now);
        assert!(half > Duration::from_secs(1700) && half < Duration::from_secs(1900), "{half:?}");
        for unlimited in [None, Some(1e300)] {
            let all = Allowance::new(now, unlimited);
            assert!(!all.is_spent() && all.until().is_none() && all.share(0.1).is_none());
        }
    }
}
