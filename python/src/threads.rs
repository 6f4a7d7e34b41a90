//! The pool of threads of long calls.
//!
//! One pool is kept between calls of the same number of threads. A fork copies the process without its threads: the child abandons the pool of its parent,
//! which has no threads there, and starts one of its own.

use crate::errors::refused;
use pyo3::PyResult;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::{Arc, Mutex, PoisonError};

/// Largest number of threads, as on the command line.
const MAX_THREADS: i64 = 1024;

struct KeptPool {
    process: u32,
    /// The number that was asked for; 0 for all cores.
    threads: usize,
    pool: Arc<ThreadPool>,
}

static KEPT: Mutex<Option<KeptPool>> = Mutex::new(None);

/// A pool of a number of threads, of all cores without one.
pub(crate) fn pool(threads: Option<i64>) -> PyResult<Arc<ThreadPool>> {
    if let Some(n) = threads.filter(|n| !(1..=MAX_THREADS).contains(n)) {
        return Err(refused(format!("threads: {n} is out of range; give 1 to {MAX_THREADS}")));
    }
    let threads = threads.and_then(|n| usize::try_from(n).ok()).unwrap_or(0);
    let process = std::process::id();
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    match kept.take() {
        Some(old) if old.process != process => std::mem::forget(old),
        Some(old) if old.threads == threads => {
            let pool = old.pool.clone();
            *kept = Some(old);
            return Ok(pool);
        }
        _ => {}
    }
    let built = ThreadPoolBuilder::new().num_threads(threads).thread_name(|i| format!("zonal-{i}")).build();
    let pool = Arc::new(built.map_err(|e| {
        refused(format!("no threads can be started ({e}); allow more memory or give fewer threads"))
    })?);
    *kept = Some(KeptPool { process, threads, pool: pool.clone() });
    Ok(pool)
}

/// Leaves the kept pool to a call that was abandoned; the next call starts another.
pub(crate) fn abandon() {
    KEPT.lock().unwrap_or_else(PoisonError::into_inner).take();
}
