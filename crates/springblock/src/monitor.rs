//! How a long run reports to whoever started it. The library reads no clock of its own.

/// Clock, progress and cancellation.
pub trait Monitor: Sync {
    /// Seconds from an arbitrary start; only differences count.
    fn seconds(&self) -> f64 {
        0.0
    }

    /// `share` of all work, 0 to 1, has been done since the last call.
    fn advance(&self, _share: f64) {}

    /// Whether to stop: polled a few hundred times a second.
    fn cancelled(&self) -> bool {
        false
    }
}

/// A monitor that watches nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unwatched;

impl Monitor for Unwatched {}
