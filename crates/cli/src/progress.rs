//! A bar on a terminal, and the clock of long runs.

use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError, RwLock};
use std::time::Instant;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use slipgrid_monitor::Monitor;

use crate::diagnostic::printable_lines;
use crate::{Console, interruption};

/// Parts into which the work is counted.
const PARTS: f64 = 1e6;

/// Progress of one stage of work, shown on stderr where that is a terminal.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    start: Instant,
    /// Share done, as the bits of an f64.
    done: AtomicU64,
    /// When the stage has to end.
    until: Option<Instant>,
}

impl Progress {
    /// Starts a stage called `what`; hidden if `quiet` or where stderr is no terminal.
    #[must_use]
    pub fn start(what: &str, quiet: bool) -> Self {
        Self::until(what, quiet, None)
    }

    /// The same of a stage that has to end at `until`.
    #[must_use]
    pub fn until(what: &str, quiet: bool, until: Option<Instant>) -> Self {
        if !what.is_empty() {
            interruption::enter(what);
        }
        let hidden = quiet || !std::io::stderr().is_terminal();
        let target = if hidden { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(PARTS as u64), target);
        if let Ok(style) = ProgressStyle::with_template("{msg:14} [{bar:40}] {percent:>3} % {elapsed} (left {eta})") {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_message(what.to_owned());
        Self { bar, start: Instant::now(), done: AtomicU64::new(0.0_f64.to_bits()), until }
    }

    /// Whether the stage has no time left.
    #[must_use]
    pub fn is_out_of_time(&self) -> bool {
        self.until.is_some_and(|until| Instant::now() >= until)
    }

    /// Whether the stage is to stop: Ctrl-C was pressed, or its time is over.
    #[must_use]
    pub fn is_over(&self) -> bool {
        interruption::asked() || self.is_out_of_time()
    }

    /// Seconds since the start.
    #[must_use]
    pub fn elapsed_s(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// Names what is being done.
    pub fn say(&self, what: &str) {
        self.bar.set_message(what.to_owned());
    }

    /// Sets the share done, 0 to 1.
    pub fn set(&self, share: f64) {
        self.bar.set_position((share.clamp(0.0, 1.0) * PARTS) as u64);
    }

    /// Removes the bar and returns the seconds the stage took.
    pub fn finish(self) -> f64 {
        self.bar.finish_and_clear();
        self.elapsed_s()
    }
}

impl Monitor for Progress {
    fn seconds(&self) -> f64 {
        self.elapsed_s()
    }

    fn advance(&self, share: f64) {
        let add = |bits| Some((f64::from_bits(bits) + share).to_bits());
        let before = self.done.fetch_update(Ordering::Relaxed, Ordering::Relaxed, add);
        let (Ok(bits) | Err(bits)) = before;
        self.set(f64::from_bits(bits) + share);
    }

    fn cancelled(&self) -> bool {
        self.is_over()
    }
}

/// The monitor of a job of several stages: each has its bar, and what is worth a line goes to the console.
pub struct JobProgress<'a> {
    start: Instant,
    quiet: bool,
    notes: Mutex<&'a mut (dyn Write + Send)>,
    stage: RwLock<Option<Progress>>,
}

impl<'a> JobProgress<'a> {
    /// The monitor of a job that `console` asked for.
    #[must_use]
    pub fn new(console: &'a mut Console<'_>) -> Self {
        let notes: &'a mut (dyn Write + Send) = &mut *console.err;
        Self { start: Instant::now(), quiet: console.quiet, notes: Mutex::new(notes), stage: RwLock::new(None) }
    }
}

impl Monitor for JobProgress<'_> {
    fn stage(&self, name: &str) {
        *self.stage.write().unwrap_or_else(PoisonError::into_inner) = Some(Progress::start(name, self.quiet));
    }

    fn stage_ended(&self) {
        if let Some(stage) = self.stage.write().unwrap_or_else(PoisonError::into_inner).take() {
            stage.finish();
        }
    }

    fn advance(&self, share: f64) {
        if let Some(stage) = &*self.stage.read().unwrap_or_else(PoisonError::into_inner) {
            stage.advance(share);
        }
    }

    fn cancelled(&self) -> bool {
        interruption::asked()
    }

    fn seconds(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    fn note(&self, text: &str) {
        if !self.quiet {
            // Notes are a courtesy: a closed stderr stops nothing.
            let mut notes = self.notes.lock().unwrap_or_else(PoisonError::into_inner);
            let _ = writeln!(notes, "{}", printable_lines(text));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_from_many_threads_add_up() {
        let progress = Progress::start("test", true);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| (0..1000).for_each(|_| progress.advance(1.0 / 4000.0)));
            }
        });
        assert!((f64::from_bits(progress.done.load(Ordering::Relaxed)) - 1.0).abs() < 1e-9);
        assert!(progress.finish() >= 0.0);
    }
}
