/// Progress and cancellation of a long computation. The library reads no clock of its own.
pub trait Monitor: Sync {
    /// `share` of all work, 0 to 1, has been done since the last call.
    fn advance(&self, _share: f64) {}

    /// Whether to stop: polled once an iteration.
    fn cancelled(&self) -> bool {
        false
    }
}

/// A monitor that watches nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unwatched;

impl Monitor for Unwatched {}
