//! Progress and cancellation of long computations.
//!
//! Libraries of slipgrid do not read clocks, print, or handle signals: a [`Monitor`] does all this, and the command
//! line, a page or a Python package passes it through every stage of a job. A [`Stage`] is a part of a job that may
//! have its own time limit. With a [`Memory`], results are not computed twice.
//!
//! ```
//! use slipgrid_base::monitor::{Monitor, Stage};
//! use std::sync::atomic::{AtomicBool, Ordering};
//!
//! let button = AtomicBool::new(false);
//! let stage = Stage::new(&button, "search", None);
//! assert!(!stage.cancelled());
//! button.store(true, Ordering::Relaxed);
//! assert!(stage.cancelled() && !stage.is_out_of_time());
//! ```

mod cancellable_reader;
pub mod memory;

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

pub use cancellable_reader::CancellableReader;
pub use memory::{InMemory, Key, Memory, cached};

/// Progress, cancellation and time. All methods have defaults, which forward to [`Monitor::outer`], so that a monitor
/// implements only the methods that it needs.
pub trait Monitor: Sync {
    /// Monitor to which calls are forwarded that this one does not handle itself; `None` if they have no effect.
    fn outer(&self) -> Option<&dyn Monitor> {
        None
    }

    /// Reports that the stage `name` begins; [`Monitor::advance`] counts from 0 again.
    fn stage(&self, name: &str) {
        if let Some(outer) = self.outer() {
            outer.stage(name);
        }
    }

    /// Describes the current work within the stage.
    fn detail(&self, text: &str) {
        if let Some(outer) = self.outer() {
            outer.detail(text);
        }
    }

    /// Reports that the current stage has ended.
    fn stage_ended(&self) {
        if let Some(outer) = self.outer() {
            outer.stage_ended();
        }
    }

    /// Reports that the fraction `share` of the stage's work, 0 to 1, was done since the last call.
    fn advance(&self, share: f64) {
        if let Some(outer) = self.outer() {
            outer.advance(share);
        }
    }

    /// Whether to stop; called many times per second by any thread.
    fn cancelled(&self) -> bool {
        self.outer().is_some_and(|outer| outer.cancelled())
    }

    /// Checks for cancellation between two stages, and after a stage that ended early.
    ///
    /// # Errors
    /// [`Cancelled`] if the monitor has cancelled.
    fn heed(&self) -> Result<(), Cancelled> {
        if self.cancelled() { Err(Cancelled) } else { Ok(()) }
    }

    /// Seconds from an arbitrary start; only differences matter. With a constant clock no time limit is reached.
    fn seconds(&self) -> f64 {
        self.outer().map_or(0.0, |outer| outer.seconds())
    }

    /// Shows a message to the user while the work continues.
    fn note(&self, text: &str) {
        if let Some(outer) = self.outer() {
            outer.note(text);
        }
    }

    /// Reports that `results` complete results are stored at `place` and will survive a later failure.
    fn kept(&self, place: &Path, results: usize) {
        if let Some(outer) = self.outer() {
            outer.kept(place, results);
        }
    }

    /// Cache of earlier results; results do not depend on it.
    fn memory(&self) -> Option<&dyn Memory> {
        self.outer()?.memory()
    }
}

/// The monitor has cancelled the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cancelled;

/// A monitor without any effect.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unwatched;

impl Monitor for Unwatched {}

/// A button: the work is cancelled once it is true.
impl Monitor for AtomicBool {
    fn cancelled(&self) -> bool {
        self.load(Ordering::Relaxed)
    }
}

/// One stage of a job; cancelled with the job, or when its time limit is reached.
pub struct Stage<'a> {
    job: &'a dyn Monitor,
    started_s: f64,
    until_s: Option<f64>,
}

impl<'a> Stage<'a> {
    /// Begins the stage `name` of `job`; it may last until the job's clock shows `until_s` seconds, `None` without a
    /// limit.
    pub fn new(job: &'a dyn Monitor, name: &str, until_s: Option<f64>) -> Self {
        job.stage(name);
        Self { job, started_s: job.seconds(), until_s }
    }

    /// Whether the time limit of the stage is reached; false without a limit.
    pub fn is_out_of_time(&self) -> bool {
        self.until_s.is_some_and(|until_s| self.job.seconds() >= until_s)
    }

    /// Ends the stage and returns its duration, in seconds.
    pub fn finish(self) -> f64 {
        self.job.stage_ended();
        self.job.seconds() - self.started_s
    }
}

impl Monitor for Stage<'_> {
    fn outer(&self) -> Option<&dyn Monitor> {
        Some(self.job)
    }

    fn cancelled(&self) -> bool {
        self.job.cancelled() || self.is_out_of_time()
    }
}

/// A part of a stage, with the fraction `share` of the stage's work. Other calls are forwarded unchanged.
pub struct Part<'a> {
    stage: &'a dyn Monitor,
    share: f64,
}

impl<'a> Part<'a> {
    /// Creates a part of `stage` with the fraction `share`, 0 to 1, of its work.
    pub const fn new(stage: &'a dyn Monitor, share: f64) -> Self {
        Self { stage, share }
    }
}

impl Monitor for Part<'_> {
    fn outer(&self) -> Option<&dyn Monitor> {
        Some(self.stage)
    }

    fn advance(&self, share: f64) {
        self.stage.advance(share * self.share);
    }
}

/// A monitor that forwards to another monitor, and adds a cache if that monitor has none.
pub struct CachingMonitor<'a> {
    inner: &'a dyn Monitor,
    own: InMemory,
}

impl<'a> CachingMonitor<'a> {
    /// Wraps `inner`, and adds a cache in memory if `inner` has none.
    pub fn new(inner: &'a dyn Monitor) -> Self {
        Self { inner, own: InMemory::default() }
    }
}

impl Monitor for CachingMonitor<'_> {
    fn outer(&self) -> Option<&dyn Monitor> {
        Some(self.inner)
    }

    fn memory(&self) -> Option<&dyn Memory> {
        Some(self.inner.memory().unwrap_or(&self.own))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;
    use std::sync::atomic::AtomicU64;

    /// A manual clock that records calls.
    #[derive(Default)]
    struct Watch {
        seconds: AtomicU64,
        done: Mutex<f64>,
    }

    impl Monitor for Watch {
        fn advance(&self, share: f64) {
            *self.done.lock().unwrap() += share;
        }

        fn seconds(&self) -> f64 {
            self.seconds.load(Ordering::Relaxed) as f64
        }
    }

    #[test]
    fn a_stage_ends_at_its_time_and_not_before() {
        let watch = Watch::default();
        let stage = Stage::new(&watch, "search", Some(10.0));
        assert!(!stage.cancelled());
        watch.seconds.store(9, Ordering::Relaxed);
        assert!(!stage.cancelled());
        watch.seconds.store(10, Ordering::Relaxed);
        assert!(stage.cancelled() && stage.is_out_of_time() && !watch.cancelled());
        assert_eq!(stage.finish(), 10.0);
        assert!(!Stage::new(&Unwatched, "search", Some(1.0)).cancelled(), "no clock, no limit");
    }

    #[test]
    fn shares_from_many_threads_add_up() {
        let watch = Watch::default();
        let stage = Stage::new(&watch, "solve", None);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| (0..1000).for_each(|_| stage.advance(1.0 / 4000.0)));
            }
        });
        assert!((*watch.done.lock().unwrap() - 1.0).abs() < 1e-9);
        Part::new(&stage, 0.5).advance(0.1);
        assert!((*watch.done.lock().unwrap() - 1.05).abs() < 1e-9, "a tenth of a half");
    }
}
