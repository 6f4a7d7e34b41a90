//! Progress reports of long computations to an observer.

/// An observer of a long computation. Calls come from any thread; implementations must be cheap.
pub trait Progress: Sync {
    /// A stage of `total` steps begins; its number of steps is unknown if `total` is 0. Stages may contain others.
    fn begin(&self, stage: &str, total: u64);
    /// `steps` further steps are complete.
    fn advance(&self, steps: u64);
    /// The stage is complete.
    fn end(&self);
    /// Whether the computation is to stop. It is asked between stages, between iterations and between blocks of rays; it must stay true. A solve then ends with
    /// [`crate::SceneErrorKind::Interrupted`], and its finished stages stay in the checkpoint.
    fn is_interrupted(&self) -> bool {
        false
    }
}

/// Runs a part of a computation as a stage without steps: its time is measured, and its name is shown.
pub fn in_stage<T>(progress: &dyn Progress, stage: &str, run: impl FnOnce() -> T) -> T {
    progress.begin(stage, 0);
    let out = run();
    progress.end();
    out
}

/// An observer that ignores all reports.
pub struct NoProgress;

impl Progress for NoProgress {
    fn begin(&self, _: &str, _: u64) {}
    fn advance(&self, _: u64) {}
    fn end(&self) {}
}
