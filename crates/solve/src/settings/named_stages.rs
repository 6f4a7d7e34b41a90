//! Checkpoints of one part of a solve within those of the whole.

use zonal_scene::CheckpointStore;
use zonal_scene::checkpoint_store::STATE_STAGE_PREFIX;

/// Store that gives the stages of a part of a solve names of their own.
pub(crate) struct NamedStages<'a> {
    pub store: &'a dyn CheckpointStore,
    pub part: SolvePart,
}

/// A part of a solve.
pub(crate) enum SolvePart {
    /// A block of bands by its number; the first has the names of a solve of three bands.
    Block(usize),
    /// The second solve on zones of this kind; its stages depend on the whole scene.
    SecondSolve(&'static str),
}

impl NamedStages<'_> {
    fn name(&self, stage: &str) -> String {
        match (&self.part, stage.strip_prefix(STATE_STAGE_PREFIX)) {
            (SolvePart::SecondSolve(kind), _) => format!("{STATE_STAGE_PREFIX}{kind}-zones-{stage}"),
            (SolvePart::Block(0), _) => stage.to_string(),
            (SolvePart::Block(block), Some(rest)) => format!("{STATE_STAGE_PREFIX}block-{block}-{rest}"),
            (SolvePart::Block(block), None) => format!("block-{block}-{stage}"),
        }
    }
}

impl CheckpointStore for NamedStages<'_> {
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
