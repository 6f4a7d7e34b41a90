//! Solves with changed options, with checkpoints, and on several processes; solutions have the identity that files keep.
//!
//! | module | contents |
//! |---|---|
//! | `checkpoint` | the folder of the finished stages of a solve |
//! | `shared_solve` | one solve on one or several processes, and its file |
//! | `voxel_factors` | the formula of the exchange factor of two voxels |

mod checkpoint;
mod shared_solve;
mod voxel_factors;

pub use checkpoint::SolveCheckpoint;
pub use shared_solve::{SharedSolve, SolveInput, if_all_succeeded};
pub use voxel_factors::VoxelFactors;

use crate::timeline::HASH;
use std::path::{Path, PathBuf};
use zonal_exchange::pair::PairSettings;
use zonal_io::output::{self, CheckpointKeys};
use zonal_scene::{Progress, Scene, SceneError, Solution, in_stage};
use zonal_solve::SolveSettings;

/// Solves a scene and sets the hash of the scene in the solution.
///
/// # Errors
/// As [`zonal_solve::solve_with_settings`].
pub fn solve_and_hash(scene: Scene, settings: &SolveSettings) -> Result<Solution, SceneError> {
    zonal_solve::solve_with_settings(scene, settings).map(|s| with_hash(s, settings.progress))
}

/// The solution with the hash of its scene.
#[must_use]
pub(crate) fn with_hash(mut solution: Solution, progress: &dyn Progress) -> Solution {
    solution.scene_hash = in_stage(progress, HASH, || output::scene_hash(&solution.scene));
    solution
}

/// Identity of the stages of a scene in a checkpoint: version of the program, hash of the scene, formula of voxel pairs.
pub(crate) fn checkpoint_keys(scene: &Scene, settings: PairSettings) -> CheckpointKeys {
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
