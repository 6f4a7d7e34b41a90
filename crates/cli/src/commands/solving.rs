//! Solves of scenes with the identity that files keep: the hash of the scene, and the keys of checkpoints.

use std::path::{Path, PathBuf};
use zonal_exchange::pair::PairSettings;
use zonal_io::output::{self, CheckpointKeys};
use zonal_report::Failure;
use zonal_scene::{Scene, Solution};
use zonal_solve::SolveSettings;
use zonal_solve::distribution::Communicator;

/// Solves a scene and sets the hash of the scene in the solution.
///
/// # Errors
/// As [`zonal_solve::solve_with_settings`].
pub fn solve_and_hash(scene: Scene, settings: &SolveSettings) -> Result<Solution, Failure> {
    Ok(zonal_solve::solve_with_settings(scene, settings).map(with_hash)?)
}

/// The solution with the hash of its scene.
#[must_use]
pub fn with_hash(mut solution: Solution) -> Solution {
    solution.scene_hash = output::scene_hash(&solution.scene);
    solution
}

/// Identity of the stages of a scene in a checkpoint: version of the program, hash of the scene, formula of voxel pairs.
#[must_use]
pub fn checkpoint_keys(scene: &Scene, settings: PairSettings) -> CheckpointKeys {
    CheckpointKeys::of_solve(
        scene,
        settings.volume_factors.map_or(CheckpointKeys::EXACT_METHOD, |m| m.name()),
    )
}

/// The path `OUTPUT.extension` beside an output.
#[must_use]
pub fn path_beside(output: &Path, extension: &str) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(format!(".{extension}"));
    PathBuf::from(name)
}

/// The own result if all processes succeeded, else the failure of one.
///
/// # Errors
/// On all processes, where one failed.
pub fn if_all_succeeded<T>(own: Result<T, Failure>, communicator: &dyn Communicator) -> Result<T, Failure> {
    let message = own.as_ref().err().map(ToString::to_string).unwrap_or_default();
    let all = communicator.all_gather(message.into_bytes());
    let own = own?;
    match all.iter().find(|message| !message.is_empty()) {
        Some(message) => Err(Failure::new(String::from_utf8_lossy(message))),
        None => Ok(own),
    }
}
