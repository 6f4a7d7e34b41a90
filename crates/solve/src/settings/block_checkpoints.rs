//! Checkpoints of a block of bands within those of a solve.

use zonal_scene::CheckpointStore;
use zonal_scene::checkpoint_store::STATE_STAGE_PREFIX;

/// Store that separates the stages of one block of bands from those of the others; the first block has the names of a solve of three bands.
pub(crate) struct BlockCheckpoints<'a> {
    pub store: &'a dyn CheckpointStore,
    /// Number of the block.
    pub block: usize,
}

impl BlockCheckpoints<'_> {
    fn name(&self, stage: &str) -> String {
        let block = self.block;
        match stage.strip_prefix(STATE_STAGE_PREFIX) {
            _ if block == 0 => stage.to_string(),
            Some(rest) => format!("{STATE_STAGE_PREFIX}block-{block}-{rest}"),
            None => format!("block-{block}-{stage}"),
        }
    }
}

impl CheckpointStore for BlockCheckpoints<'_> {
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
