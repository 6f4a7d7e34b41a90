//! Progress and checkpoints of the second solve.

use zonal_scene::checkpoint_store::STATE_STAGE_PREFIX;
use zonal_scene::{CheckpointStore, Progress};

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

/// Store that separates the stages of the second solve from those of the first; they depend on the whole scene.
pub(super) struct SecondSolveCheckpoints<'a> {
    pub store: &'a dyn CheckpointStore,
    /// `larger` or `smaller`.
    pub kind: &'static str,
}

impl SecondSolveCheckpoints<'_> {
    fn name(&self, stage: &str) -> String {
        format!("{STATE_STAGE_PREFIX}{}-zones-{stage}", self.kind)
    }
}

impl CheckpointStore for SecondSolveCheckpoints<'_> {
    fn load(&self, stage: &str) -> Option<Vec<u8>> {
        self.store.load(&self.name(stage))
    }
    fn save(&self, stage: &str, bytes: &[u8]) {
        self.store.save(&self.name(stage), bytes);
    }
    fn keeps(&self) -> bool {
        self.store.keeps()
    }
}
