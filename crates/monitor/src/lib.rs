//! How a long computation reports to whoever started it, and is stopped.
//!
//! No library of slipgrid reads a clock, prints, or knows of signals: a [`Monitor`] does all of it, and the same one
//! goes from the command line, a page or a Python package through every stage of a job. A [`Stage`] is one part of the
//! job that may have a time limit of its own. A caller that lends a [`Memory`] has nothing computed twice.
//!
//! ```
//! use slipgrid_monitor::{Monitor, Stage};
//! use std::sync::atomic::{AtomicBool, Ordering};
//!
//! struct Button(AtomicBool);
//! impl Monitor for Button {
//!     fn cancelled(&self) -> bool {
//!         self.0.load(Ordering::Relaxed)
//!     }
//! }
//!
//! let button = Button(AtomicBool::new(false));
//! let stage = Stage::new(&button, "search", None);
//! assert!(!stage.cancelled());
//! button.0.store(true, Ordering::Relaxed);
//! assert!(stage.cancelled() && !stage.is_out_of_time());
//! ```

mod heeding;
pub mod memory;

use std::path::Path;

pub use heeding::Heeding;
pub use memory::{InMemory, Key, Memory, recalled};

/// Progress, cancelling and time. Every method has a default: a monitor answers what it cares for.
pub trait Monitor: Sync {
    /// A stage called `name` begins; shares of [`Monitor::advance`] count from 0 again.
    fn stage(&self, _name: &str) {}

    /// What is being done within the stage.
    fn detail(&self, _text: &str) {}

    /// The stage that began last is over.
    fn stage_ended(&self) {}

    /// `share` of the stage's work, 0 to 1, has been done since the last call.
    fn advance(&self, _share: f64) {}

    /// Whether to stop: polled many times a second, by any thread.
    fn cancelled(&self) -> bool {
        false
    }

    /// Ends work between two stages, and after one that ended early.
    ///
    /// # Errors
    /// [`Cancelled`] once the monitor has cancelled.
    fn heed(&self) -> Result<(), Cancelled> {
        if self.cancelled() { Err(Cancelled) } else { Ok(()) }
    }

    /// Seconds from an arbitrary start; only differences count. Where it stands still no time limit is ever reached.
    fn seconds(&self) -> f64 {
        0.0
    }

    /// Something worth a line to a person while the work goes on.
    fn note(&self, _text: &str) {}

    /// So many results stand at a place, whole, whatever happens to the work.
    fn kept(&self, _place: &Path, _results: usize) {}

    /// What the caller remembers of earlier computations; the results are the same without.
    fn memory(&self) -> Option<&dyn Memory> {
        None
    }
}

/// The monitor has cancelled the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cancelled;

/// A monitor that watches nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unwatched;

impl Monitor for Unwatched {}

/// One stage of a job: it is cancelled with the job, or when its own time is over.
pub struct Stage<'a> {
    job: &'a dyn Monitor,
    started_s: f64,
    until_s: Option<f64>,
}

impl<'a> Stage<'a> {
    /// Begins the stage `name` of `job`, to end at `until_s` on the job's clock.
    #[must_use]
    pub fn new(job: &'a dyn Monitor, name: &str, until_s: Option<f64>) -> Self {
        job.stage(name);
        Self { job, started_s: job.seconds(), until_s }
    }

    /// Whether the stage has no time left.
    #[must_use]
    pub fn is_out_of_time(&self) -> bool {
        self.until_s.is_some_and(|until_s| self.job.seconds() >= until_s)
    }

    /// Ends the stage and returns the seconds that it took.
    pub fn finish(self) -> f64 {
        self.job.stage_ended();
        self.job.seconds() - self.started_s
    }
}

/// What a part of the work passes on to the whole as it is.
macro_rules! passed_on {
    ($to:ident) => {
        fn stage(&self, name: &str) {
            self.$to.stage(name);
        }

        fn detail(&self, text: &str) {
            self.$to.detail(text);
        }

        fn stage_ended(&self) {
            self.$to.stage_ended();
        }

        fn seconds(&self) -> f64 {
            self.$to.seconds()
        }

        fn note(&self, text: &str) {
            self.$to.note(text);
        }

        fn kept(&self, place: &Path, results: usize) {
            self.$to.kept(place, results);
        }

        fn memory(&self) -> Option<&dyn Memory> {
            self.$to.memory()
        }
    };
}

impl Monitor for Stage<'_> {
    passed_on!(job);

    fn advance(&self, share: f64) {
        self.job.advance(share);
    }

    fn cancelled(&self) -> bool {
        self.job.cancelled() || self.is_out_of_time()
    }
}

/// A part of a stage: its whole is `share` of the stage's work. Everything else goes through as it is.
pub struct Part<'a> {
    stage: &'a dyn Monitor,
    share: f64,
}

impl<'a> Part<'a> {
    /// The part of `stage` that is `share` of its work, 0 to 1.
    #[must_use]
    pub const fn new(stage: &'a dyn Monitor, share: f64) -> Self {
        Self { stage, share }
    }
}

impl Monitor for Part<'_> {
    passed_on!(stage);

    fn advance(&self, share: f64) {
        self.stage.advance(share * self.share);
    }

    fn cancelled(&self) -> bool {
        self.stage.cancelled()
    }
}

/// A monitor that remembers what the one behind it does not, for as long as it lives.
pub struct Remembering<'a> {
    behind: &'a dyn Monitor,
    own: InMemory,
}

impl<'a> Remembering<'a> {
    /// `behind` with a memory of its own, where that has none.
    #[must_use]
    pub fn new(behind: &'a dyn Monitor) -> Self {
        Self { behind, own: InMemory::default() }
    }
}

impl Monitor for Remembering<'_> {
    fn stage(&self, name: &str) {
        self.behind.stage(name);
    }

    fn detail(&self, text: &str) {
        self.behind.detail(text);
    }

    fn stage_ended(&self) {
        self.behind.stage_ended();
    }

    fn advance(&self, share: f64) {
        self.behind.advance(share);
    }

    fn cancelled(&self) -> bool {
        self.behind.cancelled()
    }

    fn seconds(&self) -> f64 {
        self.behind.seconds()
    }

    fn note(&self, text: &str) {
        self.behind.note(text);
    }

    fn kept(&self, place: &Path, results: usize) {
        self.behind.kept(place, results);
    }

    fn memory(&self) -> Option<&dyn Memory> {
        Some(self.behind.memory().unwrap_or(&self.own))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicU64, Ordering};

    /// A clock that is turned by hand, and what it was told.
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
