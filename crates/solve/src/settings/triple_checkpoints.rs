//! Checkpoints of a triple of bands within those of a solve.

use zonal_scene::CheckpointStore;
use zonal_scene::checkpoint_store::STATE_STAGE_PREFIX;

/// Store that separates the stages of one triple of bands from those of the others; the first triple has the names of a solve of three bands.
pub(crate) struct TripleCheckpoints<'a> {
    pub store: &'a dyn CheckpointStore,
    /// Number of the triple.
    pub triple: usize,
}

impl TripleCheckpoints<'_> {
    fn name(&self, stage: &str) -> String {
        let triple = self.triple;
        match stage.strip_prefix(STATE_STAGE_PREFIX) {
            _ if triple == 0 => stage.to_string(),
            Some(rest) => format!("{STATE_STAGE_PREFIX}triple-{triple}-{rest}"),
            None => format!("triple-{triple}-{stage}"),
        }
    }
}

impl CheckpointStore for TripleCheckpoints<'_> {
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
