//! One solve on one or several processes. Each process reads the scene; the first one writes the solution.

use super::checkpoint::{RankCheckpoints, SolveCheckpoint};
use super::with_hash;
use crate::Error;
use crate::timeline::{HASH, WRITING};
use std::borrow::Cow;
use std::cell::Cell;
use std::fmt::Display;
use std::path::Path;
use zonal_exchange::pair::PairSettings;
use zonal_io::output::{self, CheckpointFolder};
use zonal_report::Failure;
use zonal_scene::{CheckpointStore, NoCheckpoints, Progress, Scene, SceneErrorKind, Solution, in_stage};
use zonal_solve::SolveSettings;
use zonal_solve::distribution::Communicator;
use zonal_solve::pipeline::zone_division;

/// The input of a solve on each process.
pub struct SolveInput {
    /// The scene.
    pub scene: Scene,
    /// Memory limit, bytes.
    pub memory_limit: u64,
}

/// Settings of a solve that are no options of the scene.
pub struct SharedSolve<'a> {
    /// Formula of the exchange factors of voxel pairs.
    pub pair_settings: PairSettings,
    /// Where finished stages go.
    pub checkpoint: Option<&'a SolveCheckpoint>,
    /// Observer of the progress.
    pub progress: &'a dyn Progress,
    /// The processes.
    pub communicator: &'a dyn Communicator,
    /// Is called with each note on the checkpoint.
    pub note: &'a dyn Fn(&str),
}

impl SharedSolve<'_> {
    /// Solves a scene that all processes have.
    ///
    /// # Errors
    /// For a checkpoint that cannot be written, and as [`zonal_solve::solve_with_settings`]; on all processes alike.
    pub fn solve(&self, input: SolveInput) -> Result<Solution, Error> {
        let (solution, folder) = self.solve_in_folder(input)?;
        self.close(folder)?;
        Ok(with_hash(solution, self.progress))
    }

    /// Solves a scene that every process has read, and writes the solution. The first process returns it.
    ///
    /// # Errors
    /// As [`SharedSolve::solve`], where a process could not read, where the processes have different scenes or versions, and if the file cannot be written.
    pub fn solve_and_write(
        &self,
        input: Result<SolveInput, Failure>,
        path: &Path,
    ) -> Result<Option<Solution>, Error> {
        let AgreedInput { input, hash } = self.agreed(input)?;
        let (solved, folder) = self.solve_in_folder(input)?;
        let solution = Solution { scene_hash: hash, ..solved };
        // Write the solution, then remove the checkpoint. The first process collects the fields of the others.
        let collected = Cell::new(0);
        let collect: &output::CollectZones = &|own| {
            collected.set(collected.get() + 1);
            zone_division::collect(&solution, self.communicator, own)
        };
        if !self.is_first() {
            output::collect_solution(&solution, collect);
            return Ok(None);
        }
        let written =
            in_stage(self.progress, WRITING, || output::write_divided_solution(path, &solution, collect));
        if written.is_err() {
            // The other processes send what is left.
            let left = Cell::new(collected.get());
            output::collect_solution(&solution, &|own| match left.get() {
                0 => zone_division::collect(&solution, self.communicator, own),
                n => {
                    left.set(n - 1);
                    Cow::Borrowed(own)
                }
            });
        }
        written?;
        self.close(folder)?;
        Ok(Some(solution))
    }

    fn is_first(&self) -> bool {
        self.communicator.rank() == 0
    }

    /// Input as every process read it, if all could read the same scene with the same version.
    fn agreed(&self, read: Result<SolveInput, Failure>) -> Result<AgreedInput, Failure> {
        let communicator = self.communicator;
        let hash = |input: &SolveInput| in_stage(self.progress, HASH, || output::scene_hash(&input.scene));
        let read = read.map(|input| AgreedInput { hash: hash(&input), input });
        if communicator.size() == 1 {
            return read;
        }
        let own = match &read {
            Ok(read) => format!("{} {} {}", env!("CARGO_PKG_VERSION"), read.hash, read.input.memory_limit),
            Err(e) => format!("{FAILED}{e}"),
        };
        let all = communicator.all_gather(own.into_bytes());
        let read = read?;
        let failure = |(rank, text): (usize, &Vec<u8>)| {
            let message = text.strip_prefix(FAILED.as_bytes())?;
            Some(Failure::new(format!("rank {rank}: {}", String::from_utf8_lossy(message))))
        };
        if let Some(failure) = all.iter().enumerate().find_map(failure) {
            return Err(failure);
        }
        match all.iter().position(|other| *other != all[0]) {
            None => Ok(read),
            Some(rank) => Err(Failure::new(format!(
                "rank {rank} has another scene, another memory limit or another version than rank 0; give all ranks the same files and the same program"
            ))),
        }
    }

    /// The solution, and the folder of its stages.
    fn solve_in_folder(&self, input: SolveInput) -> Result<(Solution, Option<CheckpointFolder>), Error> {
        let SolveInput { scene, memory_limit } = input;
        let folder = self.checkpoint.map(|c| self.shared_folder(c, &scene)).transpose()?;
        let stages = folder.as_ref().map(|folder| RankCheckpoints { folder, is_first: self.is_first() });
        let settings = SolveSettings {
            pair_settings: self.pair_settings,
            checkpoints: stages.as_ref().map_or(&NoCheckpoints, |f| f as &dyn CheckpointStore),
            communicator: self.communicator,
            ..SolveSettings::new(memory_limit, self.progress)
        };
        let solved = zonal_solve::solve_with_settings(scene, &settings);
        // An interrupted solve resumes; a refused one leaves nothing to resume.
        if solved.as_ref().is_err_and(|e| e.kind() != SceneErrorKind::Interrupted) && self.is_first() {
            folder.iter().for_each(CheckpointFolder::remove);
        }
        Ok((solved?, folder))
    }

    /// The folder of the checkpoint, which the first process prepares before the others use it.
    fn shared_folder(&self, checkpoint: &SolveCheckpoint, scene: &Scene) -> Result<CheckpointFolder, Error> {
        let folder = if self.is_first() {
            checkpoint.begin(scene, self.pair_settings, self.note).map_err(Error::from)
        } else {
            Ok(checkpoint.open(scene, self.pair_settings))
        };
        if_all_succeeded(folder, self.communicator)
    }

    fn close(&self, folder: Option<CheckpointFolder>) -> Result<(), Error> {
        if let (Some(folder), Some(checkpoint)) = (folder, self.checkpoint) {
            checkpoint.close(folder, self.note)?;
        }
        Ok(())
    }
}

/// Input as every process read it.
struct AgreedInput {
    input: SolveInput,
    /// Hash of the scene.
    hash: String,
}

/// Mark of a process that failed to read its scene.
const FAILED: &str = "failed ";

/// The own result if all processes succeeded, else the failure of one.
///
/// # Errors
/// On all processes, where one failed.
pub fn if_all_succeeded<T, E: Display + From<Failure>>(
    own: Result<T, E>,
    communicator: &dyn Communicator,
) -> Result<T, E> {
    let message = own.as_ref().err().map(ToString::to_string).unwrap_or_default();
    let all = communicator.all_gather(message.into_bytes());
    let own = own?;
    match all.iter().find(|message| !message.is_empty()) {
        Some(message) => Err(Failure::new(String::from_utf8_lossy(message)).into()),
        None => Ok(own),
    }
}
