//! The thread pool for computations. It belongs to one process: a forked child makes its own pool, because its parent's threads
//! do not exist in the child.
//!
//! All computations run in the pool ([`in_pool`], `progress`): rayon's global pool would not survive a fork, and would not have
//! the requested number of threads.

use std::sync::atomic::{AtomicBool, AtomicU32, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use slipgrid::disk::{MAX_THREADS, cores};

use crate::counts::{shown, to_count};

/// Requested number of threads, 0 for the number of cores, and the pool.
struct Pool {
    wanted: usize,
    made: Option<Arc<ThreadPool>>,
}

static POOL: Mutex<Pool> = Mutex::new(Pool { wanted: 0, made: None });
/// Id of the process of the last call; 0 before the first call.
static OWNER: AtomicU32 = AtomicU32::new(0);
/// Number of calls in progress in the process `OWNER`.
static BUSY: AtomicUsize = AtomicUsize::new(0);
/// Whether this process was forked while its parent was computing.
static FORKED_WHILE_BUSY: AtomicBool = AtomicBool::new(false);
/// Error message of a process that was forked while its parent was computing. It must not compute: a lock held by a
/// lost thread would never be released.
const WHILE_BUSY: &str = "this process was forked while slipgrid was computing in another thread: start it with \"spawn\" or \
                          \"forkserver\", or fork before";

/// Guard of a call in progress; dropping it ends the call.
pub struct Busy;

impl Busy {
    /// Begins a call. The interpreter lock, represented by `py`, admits one thread at a time.
    pub fn new(_py: Python<'_>) -> PyResult<Self> {
        let process = std::process::id();
        let owner = OWNER.swap(process, Ordering::Relaxed);
        if owner != 0 && owner != process {
            if BUSY.swap(0, Ordering::Relaxed) > 0 {
                FORKED_WHILE_BUSY.store(true, Ordering::Relaxed);
            } else {
                // The threads of a parent's pool do not exist here, so that nothing can join them.
                std::mem::forget(POOL.lock().unwrap_or_else(PoisonError::into_inner).made.take());
            }
        }
        if FORKED_WHILE_BUSY.load(Ordering::Relaxed) {
            return Err(PyRuntimeError::new_err(WHILE_BUSY));
        }
        BUSY.fetch_add(1, Ordering::Relaxed);
        Ok(Self)
    }
}

impl Drop for Busy {
    fn drop(&mut self) {
        // In a child that was forked within a call, the count is already 0.
        let _ = BUSY.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |count| count.checked_sub(1));
    }
}

/// Runs `work` on the calling thread with the interpreter lock released.
pub fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let _busy = Busy::new(py)?;
    Ok(py.detach(work))
}

/// Runs short `work` in the pool with the interpreter lock released.
pub fn in_pool<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let busy = Busy::new(py)?;
    let pool = pool(&busy)?;
    Ok(py.detach(|| pool.install(work)))
}

/// The thread pool of this process, started at the first call. A [`Busy`] is required so that no pool of a forked
/// parent is used.
pub fn pool(_busy: &Busy) -> PyResult<Arc<ThreadPool>> {
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(made) = &pool.made {
        return Ok(Arc::clone(made));
    }
    let named = |number| format!("slipgrid-{number}");
    let made = ThreadPoolBuilder::new().num_threads(pool.wanted).thread_name(named).build();
    let made = Arc::new(made.map_err(|error| PyRuntimeError::new_err(error.to_string()))?);
    pool.made = Some(Arc::clone(&made));
    Ok(made)
}

/// Sets the number of threads to `count`, of which no more than cores are started, or to the number of cores if `count`
/// is None. Results do not depend on it.
#[pyfunction]
#[pyo3(signature = (count=None))]
pub fn set_threads(py: Python<'_>, count: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
    let accepted = |given: &Bound<'_, PyAny>| {
        let count = to_count("count", given)?.filter(|count| (1..=MAX_THREADS).contains(count));
        let expected = format!("expected 1 to {MAX_THREADS}, or None for all cores");
        count.ok_or_else(|| PyValueError::new_err(format!("count is {}: {expected}", shown(given))))
    };
    let count = count.map(accepted).transpose()?;
    let _busy = Busy::new(py)?;
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    // Threads beyond the cores would only wait for each other.
    *pool = Pool { wanted: count.map_or(0, |count| count.min(cores())), made: None };
    Ok(())
}

/// Number of computing threads.
#[pyfunction]
pub fn threads(py: Python<'_>) -> PyResult<usize> {
    Ok(pool(&Busy::new(py)?)?.current_num_threads())
}
