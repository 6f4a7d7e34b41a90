//! The folder of the finished stages of a solve: begun or resumed before the solve, removed after it, or kept as exchange factors.

use super::checkpoint_keys;
use std::path::PathBuf;
use zonal_exchange::pair::PairSettings;
use zonal_io::output::{CheckpointFolder, CheckpointState, FileError};
use zonal_scene::{CheckpointStore, Scene};

/// Where the finished stages of a solve go.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SolveCheckpoint {
    /// Folder during the solve.
    pub folder: PathBuf,
    /// Continues with the stages of the folder, if they belong to the scene.
    pub resume: bool,
    /// Folder for the exchange factors after the solve.
    pub keep_factors: Option<PathBuf>,
}

impl SolveCheckpoint {
    /// The folder for a scene, as it is.
    pub(super) fn open(&self, scene: &Scene, settings: PairSettings) -> CheckpointFolder {
        CheckpointFolder::new(&self.folder, checkpoint_keys(scene, settings))
    }

    /// The folder for a scene: with its stages if the solve resumes and they belong to the scene, otherwise empty.
    pub(super) fn begin(
        &self,
        scene: &Scene,
        settings: PairSettings,
        note: &dyn Fn(&str),
    ) -> Result<CheckpointFolder, FileError> {
        let folder = self.open(scene, settings);
        folder.claim()?;
        match folder.state() {
            CheckpointState::Matching if self.resume => {}
            CheckpointState::Mismatched if self.resume => {
                note(&format!(
                    "{}: this checkpoint belongs to another scene, other options or another version; starting from the beginning",
                    self.folder.display()
                ));
                folder.clear();
            }
            _ => folder.clear(),
        }
        folder.begin()?;
        Ok(folder)
    }

    /// Removes the folder after the solve, or keeps its factors.
    pub(super) fn close(&self, folder: CheckpointFolder, note: &dyn Fn(&str)) -> Result<(), FileError> {
        if let Some(e) = folder.failure() {
            note(&format!("the checkpoint could not be written: {e}"));
        }
        match &self.keep_factors {
            Some(path) => folder.keep_factors(path),
            None => {
                folder.remove();
                Ok(())
            }
        }
    }
}

/// The stages of a checkpoint for one process: it saves the rows that it owns, the first process also what all have.
pub(super) struct RankCheckpoints<'a> {
    pub(super) folder: &'a CheckpointFolder,
    pub(super) is_first: bool,
}

impl CheckpointStore for RankCheckpoints<'_> {
    fn keeps(&self) -> bool {
        self.folder.keeps()
    }
    fn load(&self, stage: &str) -> Option<Vec<u8>> {
        self.folder.load(stage)
    }
    fn save(&self, stage: &str, bytes: &[u8]) {
        if self.is_first || zonal_solve::distribution::is_stage_of_one_rank(stage) {
            self.folder.save(stage, bytes);
        }
    }
}
