//! The pool that work is done in. It belongs to one process: a child that was forked makes its own, as no thread of its parent's
//! lives in it.
//!
//! Everything that may compute runs in it ([`in_pool`], `watched`): rayon's global pool would not survive a fork, and its
//! threads are not those that were asked for.

use std::sync::atomic::{AtomicBool, AtomicU32, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use slipgrid_disk::MAX_THREADS;

use crate::given::{counted, shown};

/// Threads asked for, 0 for as many as there are cores, and the pool.
struct Pool {
    wanted: usize,
    made: Option<Arc<ThreadPool>>,
}

static POOL: Mutex<Pool> = Mutex::new(Pool { wanted: 0, made: None });
/// The process that entered last; 0 before the first.
static OWNER: AtomicU32 = AtomicU32::new(0);
/// Calls in progress in that process.
static BUSY: AtomicUsize = AtomicUsize::new(0);
/// Whether this process was forked while its parent was computing.
static FORKED_WHILE_BUSY: AtomicBool = AtomicBool::new(false);
/// Why such a process computes nothing: a lock that a lost thread held would never open.
const WHILE_BUSY: &str = "this process was forked while slipgrid was computing in another thread: start it with \"spawn\" or \
                          \"forkserver\", or fork before";

/// A call in progress.
pub struct Busy;

impl Busy {
    /// Begins a call. The interpreter's lock, which `py` stands for, lets one thread at a time come here.
    pub fn new(_py: Python<'_>) -> PyResult<Self> {
        let process = std::process::id();
        let owner = OWNER.swap(process, Ordering::Relaxed);
        if owner != 0 && owner != process {
            if BUSY.swap(0, Ordering::Relaxed) > 0 {
                FORKED_WHILE_BUSY.store(true, Ordering::Relaxed);
            } else {
                // The threads of a parent's pool are not here: nothing can join them.
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
        // In a child that was forked within a call the count is 0 already.
        let _ = BUSY.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |count| count.checked_sub(1));
    }
}

/// Does `work` without holding on to the interpreter: what uses no thread but the caller's.
pub fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let _busy = Busy::new(py)?;
    Ok(py.detach(work))
}

/// Does `work` in the pool without holding on to the interpreter: what is short, and may use threads.
pub fn in_pool<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let busy = Busy::new(py)?;
    let pool = pool(&busy)?;
    Ok(py.detach(|| pool.install(work)))
}

/// The pool of this process.
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

/// Computes with `count` threads from here on; as many as there are cores where `count` is None. Results do not depend on it.
#[pyfunction]
#[pyo3(signature = (count=None))]
pub fn set_threads(py: Python<'_>, count: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
    let accepted = |given: &Bound<'_, PyAny>| {
        let count = counted("count", given)?.filter(|count| (1..=MAX_THREADS).contains(count));
        let expected = format!("expected 1 to {MAX_THREADS}, or None for all cores");
        count.ok_or_else(|| PyValueError::new_err(format!("count is {}: {expected}", shown(given))))
    };
    let count = count.map(accepted).transpose()?;
    let _busy = Busy::new(py)?;
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    *pool = Pool { wanted: count.unwrap_or(0), made: None };
    Ok(())
}

/// Threads that are computed with.
#[pyfunction]
pub fn threads(py: Python<'_>) -> PyResult<usize> {
    Ok(pool(&Busy::new(py)?)?.current_num_threads())
}
