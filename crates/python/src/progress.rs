//! Work in the pool, while the calling thread reports progress and checks for Ctrl-C.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use slipgrid::disk::KeptResults;
use slipgrid::monitor::{InMemory, Key, Memory, Monitor};

use crate::threads::{Busy, pool};
use crate::warnings::{Category, warn};

/// Interval of checks for signals and of progress reports.
const TICK: Duration = Duration::from_millis(50);

/// Cache in memory, of at most 256 MiB, for the results that the command line keeps in a folder. A calibration and a
/// design take about a megabyte.
static MEMORY: InMemory = InMemory::new(256 << 20);
/// Cache that new calls use; `None` for no cache.
static CACHE: Mutex<Option<Cache>> = Mutex::new(None);

/// Cache with two levels: in memory, and in a folder that outlives the process. Cached results are identical to the
/// last bit.
#[derive(Clone, Debug)]
struct Cache {
    folder: Option<Arc<KeptResults>>,
}

impl Memory for Cache {
    fn recall(&self, key: &Key) -> Option<Vec<u8>> {
        MEMORY.recall(key).or_else(|| {
            let value = self.folder.as_ref()?.recall(key)?;
            MEMORY.keep(key, &value);
            Some(value)
        })
    }

    fn keep(&self, key: &Key, value: &[u8]) {
        MEMORY.keep(key, value);
        self.folder.iter().for_each(|folder| folder.keep(key, value));
    }
}

/// Keeps results of the library in the file `library` from now on: in the process, and in `folder` or where the environment says;
/// not at all unless `is_on`.
#[pyfunction]
pub fn set_cache(library: PathBuf, is_on: bool, folder: Option<PathBuf>) {
    let folder = || KeptResults::for_program(&library, folder).map(Arc::new);
    *CACHE.lock().unwrap_or_else(PoisonError::into_inner) = is_on.then(|| Cache { folder: folder() });
}

/// State of the work: stage, completed share of the stage, warnings not yet given, and whether the work has ended.
#[derive(Clone, Debug, Default, PartialEq)]
struct Standing {
    stage: String,
    done: f64,
    warnings: Vec<(Category, String)>,
    ended: bool,
}

/// Monitor of work that Python waits for.
pub struct Watch {
    started: Instant,
    cancelled: AtomicBool,
    standing: Mutex<Standing>,
    changed: Condvar,
    cache: Option<Cache>,
}

impl Watch {
    fn new() -> Self {
        let (standing, changed) = (Mutex::default(), Condvar::new());
        let cache = CACHE.lock().unwrap_or_else(PoisonError::into_inner).clone();
        Self { started: Instant::now(), cancelled: AtomicBool::new(false), standing, changed, cache }
    }

    fn standing(&self) -> MutexGuard<'_, Standing> {
        self.standing.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Queues a warning for each of `doubts`.
    pub fn warn(&self, doubts: impl IntoIterator<Item = String>) {
        self.standing().warnings.extend(doubts.into_iter().map(|doubt| (Category::Doubt, doubt)));
    }

    /// Waits for [`TICK`], or for the end of the work; returns its state and clears the queued warnings.
    fn wait(&self) -> Standing {
        let standing = self.standing();
        let waited = self.changed.wait_timeout_while(standing, TICK, |standing| !standing.ended);
        let (mut standing, _) = waited.unwrap_or_else(PoisonError::into_inner);
        let told = standing.clone();
        standing.warnings.clear();
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
        self.standing().warnings.push((Category::Cost, text.to_owned()));
    }

    fn memory(&self) -> Option<&dyn Memory> {
        self.cache.as_ref().map(|cache| cache as &dyn Memory)
    }
}

/// Guard that, when dropped, marks the work as ended and wakes the waiting thread, even after a panic.
struct End<'a>(&'a Watch);

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.0.standing().ended = true;
        self.0.changed.notify_all();
    }
}

/// Runs `work` in the pool with the interpreter lock released. `progress(stage, share)` is called several times per second; its
/// exceptions and Ctrl-C end the work.
pub fn watched<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Watch) -> T + Send,
) -> PyResult<T> {
    let busy = Busy::new(py)?;
    let pool = pool(&busy)?;
    let watch = Watch::new();
    let mut found = None;
    let raised = pool.in_place_scope(|scope| {
        scope.spawn(|_| {
            let _end = End(&watch);
            found = Some(catch_unwind(AssertUnwindSafe(|| work(&watch))));
        });
        wait_and_report(py, progress, &watch)
    });
    match (raised, found) {
        (Err(error), _) => Err(error),
        (Ok(()), Some(Ok(found))) => Ok(found),
        (Ok(()), _) => Err(PyRuntimeError::new_err("slipgrid failed within: this is a bug")),
    }
}

/// Waits for the end of the work and reports to `progress`; an exception cancels the work.
fn wait_and_report(py: Python<'_>, progress: Option<&Bound<'_, PyAny>>, watch: &Watch) -> PyResult<()> {
    let mut raised = Ok(());
    let mut told = Standing::default();
    loop {
        let standing = py.detach(|| watch.wait());
        if raised.is_ok() {
            raised = report(py, progress, &standing, &told);
            watch.cancelled.fetch_or(raised.is_err(), Ordering::Relaxed);
        }
        if standing.ended {
            return raised;
        }
        told = standing;
    }
}

/// Checks for signals, gives warnings, and calls `progress` if `standing` differs from the last report `told`.
fn report(py: Python<'_>, progress: Option<&Bound<'_, PyAny>>, standing: &Standing, told: &Standing) -> PyResult<()> {
    py.check_signals()?;
    standing.warnings.iter().try_for_each(|(category, text)| warn(py, *category, text))?;
    let has_moved = (&standing.stage, standing.done, standing.ended) != (&told.stage, told.done, told.ended);
    match progress {
        Some(call) if has_moved && !standing.stage.is_empty() => {
            call.call1((standing.stage.as_str(), standing.done.clamp(0.0, 1.0))).map(|_| ())
        }
        _ => Ok(()),
    }
}
