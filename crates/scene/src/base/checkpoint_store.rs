//! Checkpoints of long computations: stages that are saved and loaded by name, so that an interrupted solve can resume.
//!
//! A computation is divided into named stages. A stage that can be loaded is not computed; a computed stage is saved. The bytes saved
//! must restore the computed values exactly, so that an interrupted and an uninterrupted run return the same bits.
//!
//! A stage whose name begins with [`STATE_STAGE_PREFIX`] depends on the whole scene; every other stage depends only on the inputs of
//! exchange factors and direct light.

/// Prefix of the names of stages that hold a state of an iteration, valid for a single scene.
pub const STATE_STAGE_PREFIX: &str = "state-";

/// A store of completed stages. Calls come from any thread.
///
/// ```
/// use std::{collections::HashMap, sync::Mutex};
/// use zonal_scene::CheckpointStore;
///
/// struct InMemory(Mutex<HashMap<String, Vec<u8>>>);
/// impl CheckpointStore for InMemory {
///     fn load(&self, stage: &str) -> Option<Vec<u8>> {
///         self.0.lock().unwrap().get(stage).cloned()
///     }
///     fn save(&self, stage: &str, bytes: &[u8]) {
///         self.0.lock().unwrap().insert(stage.into(), bytes.into());
///     }
/// }
/// let store = InMemory(Mutex::default());
/// store.save("factors", &[1, 2, 3]);
/// assert_eq!(store.load("factors"), Some(vec![1, 2, 3]));
/// assert!(store.keeps() && store.load("rays").is_none());
/// ```
pub trait CheckpointStore: Sync {
    /// The bytes saved under this name, if any.
    fn load(&self, stage: &str) -> Option<Vec<u8>>;
    /// Saves the bytes under this name and replaces earlier ones. A store that fails to save keeps nothing.
    fn save(&self, stage: &str, bytes: &[u8]);
    /// False if saving has no effect; callers then need not encode the stage.
    fn keeps(&self) -> bool {
        true
    }
}

/// A store that keeps nothing.
pub struct NoCheckpoints;

impl CheckpointStore for NoCheckpoints {
    fn load(&self, _: &str) -> Option<Vec<u8>> {
        None
    }
    fn save(&self, _: &str, _: &[u8]) {}
    fn keeps(&self) -> bool {
        false
    }
}
