//! Work on a thread of its own, while the calling thread tells of progress and heeds Ctrl-C.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use slipgrid::monitor::Monitor;

use crate::threads::pool;

/// How often signals are looked for and progress is told.
const TICK: Duration = Duration::from_millis(50);

/// Where the work stands.
#[derive(Clone, Debug, Default, PartialEq)]
struct Standing {
    stage: String,
    done: f64,
    notes: Vec<String>,
    ended: bool,
}

/// The monitor of work that Python waits for.
pub struct Watch {
    started: Instant,
    cancelled: AtomicBool,
    standing: Mutex<Standing>,
    changed: Condvar,
}

impl Watch {
    fn new() -> Self {
        let (standing, changed) = (Mutex::default(), Condvar::new());
        Self { started: Instant::now(), cancelled: AtomicBool::new(false), standing, changed }
    }

    fn standing(&self) -> MutexGuard<'_, Standing> {
        self.standing.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for a tick, or for the end.
    fn wait(&self) -> Standing {
        let standing = self.standing();
        let waited = self.changed.wait_timeout_while(standing, TICK, |standing| !standing.ended);
        let (mut standing, _) = waited.unwrap_or_else(PoisonError::into_inner);
        let told = standing.clone();
        standing.notes.clear();
        told
    }
}

impl Monitor for Watch {
    fn stage(&self, name: &str) {
        let mut standing = self.standing();
        (standing.stage, standing.done) = (name.to_owned(), 0.0);
    }

    fn advance(&self, share: f64) {
        self.standing().done += share;
    }

    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    fn seconds(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    fn note(&self, text: &str) {
        self.standing().notes.push(text.to_owned());
    }
}

/// Ends the wait however the work ends.
struct End<'a>(&'a Watch);

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.0.standing().ended = true;
        self.0.changed.notify_all();
    }
}

/// Does `work` in the pool, without holding on to the interpreter. `progress(stage, share)` is called some times a second; what it
/// raises, and Ctrl-C, ends the work.
pub fn watched<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Watch) -> T + Send,
) -> PyResult<T> {
    let pool = pool()?;
    let watch = Watch::new();
    thread::scope(|scope| {
        let worker = scope.spawn(|| {
            let _end = End(&watch);
            pool.install(|| work(&watch))
        });
        let mut raised = None;
        let mut told = Standing::default();
        loop {
            let standing = py.detach(|| watch.wait());
            if raised.is_none() {
                let tell = || {
                    py.check_signals()?;
                    match progress {
                        Some(call) if standing != told && !standing.stage.is_empty() => {
                            call.call1((standing.stage.as_str(), standing.done.clamp(0.0, 1.0))).map(|_| ())
                        }
                        _ => Ok(()),
                    }
                };
                if let Err(error) = tell() {
                    watch.cancelled.store(true, Ordering::Relaxed);
                    raised = Some(error);
                }
            }
            if standing.ended {
                break;
            }
            told = standing;
        }
        let found = py.detach(|| worker.join());
        match (raised, found) {
            (Some(error), _) => Err(error),
            (None, Ok(found)) => Ok(found),
            (None, Err(_)) => Err(PyRuntimeError::new_err("slipgrid failed within: this is a bug")),
        }
    })
}
