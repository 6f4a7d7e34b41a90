//! Long computations on the pool, while the calling thread waits without the interpreter's lock.
//!
//! The calling thread wakes at short intervals: it lets Python handle signals (Ctrl-C raises `KeyboardInterrupt`) and calls the progress function with the
//! stage, the steps done and their number. If either raises, the computation is told to stop: at its next report of progress its threads unwind, without a
//! panic message, and the exception is raised. A computation that does not report within [`GRACE`] is left to end by itself, and the exception is raised all
//! the same; its result is dropped.

use crate::threads;
use pyo3::prelude::*;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use zonal_app::timeline::{Phase, Timeline};
use zonal_scene::Progress;

/// Interval at which signals are handled and progress is reported.
const INTERVAL: Duration = Duration::from_millis(20);
/// Time that an interrupted computation has to end.
const GRACE: Duration = Duration::from_millis(1500);

/// What unwinds the threads of an interrupted computation.
struct Stopped;

/// The observer of a long computation.
#[derive(Default)]
pub(crate) struct Observer {
    is_interrupted: AtomicBool,
    stage: Mutex<Stage>,
    done: AtomicU64,
    timeline: Timeline,
}

#[derive(Clone, Default, PartialEq)]
struct Stage {
    name: String,
    total: u64,
}

impl Observer {
    fn unwind_if_interrupted(&self) {
        if self.is_interrupted.load(Relaxed) {
            resume_unwind(Box::new(Stopped));
        }
    }
    fn stage(&self) -> MutexGuard<'_, Stage> {
        self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Progress for Observer {
    fn begin(&self, stage: &str, total: u64) {
        self.unwind_if_interrupted();
        let mut current = self.stage();
        self.done.store(0, Relaxed);
        *current = Stage { name: stage.to_string(), total };
        self.timeline.begin(stage);
    }
    fn advance(&self, steps: u64) {
        self.unwind_if_interrupted();
        self.done.fetch_add(steps, Relaxed);
    }
    fn end(&self) {
        self.timeline.end();
    }
    fn is_interrupted(&self) -> bool {
        self.is_interrupted.load(Relaxed)
    }
}

type Outcome<T> = Result<T, Box<dyn Any + Send>>;

/// The result of a computation, for the thread that waits.
struct Slot<T> {
    outcome: Mutex<Option<Outcome<T>>>,
    ready: Condvar,
}

impl<T> Slot<T> {
    fn put(&self, outcome: Outcome<T>) {
        *self.outcome.lock().unwrap_or_else(PoisonError::into_inner) = Some(outcome);
        self.ready.notify_all();
    }
    /// The outcome, if there is one within an interval.
    fn wait(&self) -> Option<Outcome<T>> {
        let guard = self.outcome.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = self.ready.wait_timeout_while(guard, INTERVAL, |o| o.is_none());
        waited.unwrap_or_else(PoisonError::into_inner).0.take()
    }
}

/// Settings of a long call.
#[derive(Clone, Copy)]
pub(crate) struct CallSettings<'a, 'py> {
    /// Number of threads; all cores without one.
    pub(crate) threads: Option<i64>,
    /// A function of the stage, the steps done and their number.
    pub(crate) progress: Option<&'a Bound<'py, PyAny>>,
}

/// Runs a computation on the pool and waits for it.
pub(crate) fn run<T: Send + 'static>(
    py: Python<'_>,
    settings: CallSettings<'_, '_>,
    work: impl FnOnce(&Observer) -> T + Send + 'static,
) -> PyResult<T> {
    let pool = threads::pool(settings.threads)?;
    let observer = Arc::new(Observer::default());
    let slot = Arc::new(Slot { outcome: Mutex::new(None), ready: Condvar::new() });
    let (own_observer, own_slot) = (observer.clone(), slot.clone());
    pool.spawn(move || {
        let outcome = catch_unwind(AssertUnwindSafe(|| work(&own_observer)));
        own_slot.put(outcome);
    });
    let mut reported = (Stage::default(), 0);
    loop {
        if let Some(outcome) = py.detach(|| slot.wait()) {
            record(settings.progress, &observer.timeline)?;
            return outcome.or_else(|panic| resume_unwind(panic));
        }
        let raised = py.check_signals().and_then(|()| report(settings.progress, &observer, &mut reported));
        if let Err(exception) = raised {
            stop(py, &observer, &slot);
            return Err(exception);
        }
    }
}

/// Calls the progress function if the computation advanced.
fn report(
    function: Option<&Bound<'_, PyAny>>,
    observer: &Observer,
    reported: &mut (Stage, u64),
) -> PyResult<()> {
    let Some(function) = function else { return Ok(()) };
    let now = (observer.stage().clone(), observer.done.load(Relaxed));
    if now != *reported && !now.0.name.is_empty() {
        function.call1((&now.0.name, now.1.min(now.0.total), now.0.total))?;
        *reported = now;
    }
    Ok(())
}

/// Gives the phases of a call to a progress function that keeps them (`Timings` of the package).
fn record(function: Option<&Bound<'_, PyAny>>, timeline: &Timeline) -> PyResult<()> {
    const METHOD: &str = "_record";
    let Some(function) = function else { return Ok(()) };
    if function.hasattr(METHOD)? {
        let row = |p: &Phase| (p.name.clone(), p.count, p.wall.as_secs_f64(), p.processor_seconds());
        let rows: Vec<_> = timeline.phases().iter().map(row).collect();
        function.call_method1(METHOD, (rows,))?;
    }
    Ok(())
}

/// Tells a computation to stop, and waits for its end for a while.
fn stop<T: Send>(py: Python<'_>, observer: &Observer, slot: &Slot<T>) {
    observer.is_interrupted.store(true, Relaxed);
    let begin = Instant::now();
    let ended = py.detach(|| {
        while begin.elapsed() < GRACE {
            if slot.wait().is_some() {
                return true;
            }
        }
        false
    });
    if !ended {
        threads::abandon();
    }
}
