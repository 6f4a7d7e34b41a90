//! Progress of the second solve.

use zonal_scene::Progress;

/// Observer of a solve beside another one: it sees no phases, and may interrupt.
pub(crate) struct InterruptionOnly<'a>(pub &'a dyn Progress);

impl Progress for InterruptionOnly<'_> {
    fn begin(&self, _stage: &str, _total: u64) {}
    fn advance(&self, _steps: u64) {}
    fn end(&self) {}
    fn is_interrupted(&self) -> bool {
        self.0.is_interrupted()
    }
}

/// Observer that prefixes the phases of the second solve with the kind of its zones.
pub(super) struct SecondSolveProgress<'a> {
    pub observer: &'a dyn Progress,
    /// `larger` or `smaller`.
    pub kind: &'static str,
}

impl Progress for SecondSolveProgress<'_> {
    fn begin(&self, stage: &str, total: u64) {
        self.observer.begin(&format!("{} zones: {stage}", self.kind), total);
    }
    fn advance(&self, steps: u64) {
        self.observer.advance(steps);
    }
    fn end(&self) {
        self.observer.end();
    }
    fn is_interrupted(&self) -> bool {
        self.observer.is_interrupted()
    }
}
