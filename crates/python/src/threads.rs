//! The pool that work is done in. It belongs to one process: a child that was forked makes its own, as no thread of its parent's
//! lives in it.

use std::sync::{Arc, Mutex, PoisonError};

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use slipgrid_disk::MOST_THREADS;

use crate::given::{counted, shown};

/// Threads asked for, 0 for as many as there are cores, and the pool with the process that made it.
struct Pool {
    wanted: usize,
    made: Option<(u32, Arc<ThreadPool>)>,
}

static POOL: Mutex<Pool> = Mutex::new(Pool { wanted: 0, made: None });

/// The pool of this process.
pub fn pool() -> PyResult<Arc<ThreadPool>> {
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    if let Some((owner, made)) = &pool.made
        && *owner == process
    {
        return Ok(Arc::clone(made));
    }
    // The threads of a parent's pool are not here: nothing can join them.
    if let Some(lost) = pool.made.take() {
        std::mem::forget(lost);
    }
    let made = ThreadPoolBuilder::new().num_threads(pool.wanted).build();
    let made = Arc::new(made.map_err(|error| PyRuntimeError::new_err(error.to_string()))?);
    pool.made = Some((process, Arc::clone(&made)));
    Ok(made)
}

/// Computes with `count` threads from here on; as many as there are cores where `count` is None. Results do not depend on it.
#[pyfunction]
#[pyo3(signature = (count=None))]
pub fn set_threads(count: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
    let accepted = |given: &Bound<'_, PyAny>| {
        let count = counted("count", given)?.filter(|count| (1..=MOST_THREADS).contains(count));
        let expected = format!("expected 1 to {MOST_THREADS}, or None for all cores");
        count.ok_or_else(|| PyValueError::new_err(format!("count is {}: {expected}", shown(given))))
    };
    let count = count.map(accepted).transpose()?;
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    pool.wanted = count.unwrap_or(0);
    if let Some((owner, made)) = pool.made.take()
        && owner != std::process::id()
    {
        std::mem::forget(made);
    }
    Ok(())
}

/// Threads that are computed with.
#[pyfunction]
pub fn threads() -> PyResult<usize> {
    Ok(pool()?.current_num_threads())
}
