//! Monitor of the command line: progress bar on a terminal, clock of long runs, Ctrl-C.

use std::io::{IsTerminal, Write};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use slipgrid_base::monitor::{Memory, Monitor};
use slipgrid_io::disk::KeptResults;
use slipgrid_io::formats::diagnostic::printable_lines;

use crate::{Console, interruption};

/// Number of steps of a stage's progress bar.
const PARTS: f64 = 1e6;

/// Monitor of a command with several stages; shows the current stage on stderr if it is a terminal.
pub struct Job<'a> {
    bar: ProgressBar,
    start: Instant,
    /// Completed share of the stage, as the bits of an f64.
    done: AtomicU64,
    notes: Option<Mutex<&'a mut (dyn Write + Send)>>,
    kept: Option<&'a KeptResults>,
    watcher: Option<&'a dyn Monitor>,
}

impl<'a> Job<'a> {
    /// Starts the clock of a job that reports to `console`.
    pub fn new(console: &'a mut Console<'_>) -> Self {
        let hidden = console.quiet || console.watcher.is_some() || !std::io::stderr().is_terminal();
        let target = if hidden { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(PARTS as u64), target);
        if let Ok(style) = ProgressStyle::with_template("{msg:14} [{bar:40}] {percent:>3} % {elapsed} (left {eta})") {
            bar.set_style(style.progress_chars("=> "));
        }
        let err: &'a mut (dyn Write + Send) = console.err;
        let notes = (!console.quiet).then(|| Mutex::new(err));
        let (kept, watcher) = (console.kept.as_ref(), console.watcher);
        Self { bar, start: Instant::now(), done: AtomicU64::new(0.0_f64.to_bits()), notes, kept, watcher }
    }
}

impl Job<'_> {
    fn tell(&self, event: impl FnOnce(&dyn Monitor)) {
        if let Some(watcher) = self.watcher {
            event(watcher);
        }
    }
}

impl Monitor for Job<'_> {
    fn stage(&self, name: &str) {
        interruption::enter(name);
        self.done.store(0.0_f64.to_bits(), Ordering::Relaxed);
        self.bar.reset();
        self.bar.set_message(name.to_owned());
        self.tell(|watcher| watcher.stage(name));
    }

    fn detail(&self, text: &str) {
        self.bar.set_message(text.to_owned());
        self.tell(|watcher| watcher.detail(text));
    }

    fn stage_ended(&self) {
        self.bar.finish_and_clear();
    }

    fn advance(&self, share: f64) {
        let add = |bits| Some((f64::from_bits(bits) + share).to_bits());
        let before = self.done.fetch_update(Ordering::Relaxed, Ordering::Relaxed, add);
        let (Ok(bits) | Err(bits)) = before;
        self.bar.set_position(((f64::from_bits(bits) + share).clamp(0.0, 1.0) * PARTS) as u64);
        self.tell(|watcher| watcher.advance(share));
    }

    fn cancelled(&self) -> bool {
        interruption::asked() || self.watcher.is_some_and(Monitor::cancelled)
    }

    fn kept(&self, place: &Path, results: usize) {
        interruption::kept(place, results, interruption::RESULTS);
    }

    fn seconds(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    fn note(&self, text: &str) {
        if let Some(notes) = &self.notes {
            let mut to = notes.lock().unwrap_or_else(PoisonError::into_inner);
            // Notes are optional: a closed stderr stops nothing.
            let _ = writeln!(to, "{}", printable_lines(text));
        }
    }

    fn memory(&self) -> Option<&dyn Memory> {
        self.kept.map(|kept| kept as &dyn Memory)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_from_many_threads_add_up() {
        let (mut out, mut err) = (Vec::new(), Vec::new());
        let mut console = Console {
            out: &mut out,
            err: &mut err,
            quiet: true,
            threads: 1,
            kept: None,
            no_cache: false,
            watcher: None,
        };
        let job = Job::new(&mut console);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| (0..1000).for_each(|_| job.advance(1.0 / 4000.0)));
            }
        });
        assert!((f64::from_bits(job.done.load(Ordering::Relaxed)) - 1.0).abs() < 1e-9);
    }
}
