//! Other light groups of a solution without a solve; other reflectances or another albedo by a solve with kept exchange factors.

use crate::Error;
use crate::solving::{VoxelFactors, checkpoint_keys, solve_and_hash, with_hash};
use std::path::Path;
use zonal_exchange::pair::PairSettings;
use zonal_io::output::{CheckpointFolder, CheckpointState};
use zonal_report::Failure;
use zonal_scene::{Bands, CheckpointStore, Progress, Solution};
use zonal_solve::SolveSettings;
use zonal_solve::relight::{relight, with_surface_colors};

/// Changes of a solution.
#[derive(Clone, Debug, Default)]
pub struct SolutionChanges {
    /// Light groups with their factors.
    pub lights: Vec<(String, Bands)>,
    /// Surfaces with their reflectances.
    pub reflectances: Vec<(String, Bands)>,
    /// Albedo of the medium.
    pub albedo: Option<Bands>,
}

/// Settings of the solve for other reflectances.
pub struct RelightSettings<'a> {
    /// Folder of the exchange factors of the solution, which is read and not written.
    pub kept_factors: &'a Path,
    /// How a user keeps factors, the end of a message.
    pub remedy: &'a str,
    /// Bytes.
    pub memory_limit: u64,
    /// Observer of the progress.
    pub progress: &'a dyn Progress,
}

impl SolutionChanges {
    /// True if the changes are not linear in the sources, so that the equations are solved again.
    #[must_use]
    pub fn needs_solve(&self) -> bool {
        !self.reflectances.is_empty() || self.albedo.is_some()
    }

    /// True if nothing changes.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.lights.is_empty() && !self.needs_solve()
    }

    /// The solution with these changes. A solve starts from the fields of the old solution.
    ///
    /// # Errors
    /// For unknown groups and surfaces, values out of range, missing factors, and as [`zonal_solve::solve_with_settings`].
    pub fn apply(&self, mut solution: Solution, settings: &RelightSettings<'_>) -> Result<Solution, Error> {
        // Reflectances and albedo first: they need a solve.
        if self.needs_solve() {
            let pair_settings = VoxelFactors::Exact.pair_settings();
            let factors = KeptFactors::open(settings, &solution, pair_settings)?;
            let scene = with_surface_colors(solution.scene, &self.reflectances, self.albedo)?;
            let run = SolveSettings {
                pair_settings,
                checkpoints: &factors,
                initial_groups: &solution.groups,
                ..SolveSettings::new(settings.memory_limit, settings.progress)
            };
            solution = solve_and_hash(scene, &run)?;
        }
        if !self.lights.is_empty() {
            solution = with_hash(relight(solution, &self.lights)?, settings.progress);
        }
        Ok(solution)
    }
}

/// The exchange factors of a solution in a folder, which are read and not written.
struct KeptFactors(CheckpointFolder);

impl KeptFactors {
    /// The factors of a solution; refuses a folder without factors, or with those of another scene.
    fn open(
        settings: &RelightSettings<'_>,
        solution: &Solution,
        pairs: PairSettings,
    ) -> Result<KeptFactors, Failure> {
        let folder = CheckpointFolder::new(settings.kept_factors, checkpoint_keys(&solution.scene, pairs));
        let (place, remedy) = (folder.path().display(), settings.remedy);
        match folder.factors_state() {
            CheckpointState::Matching => Ok(KeptFactors(folder)),
            CheckpointState::Empty => Err(Failure::new(format!("{place}: there are no factors; {remedy}"))),
            CheckpointState::Mismatched => Err(Failure::new(format!(
                "{place}: these factors belong to other lights, another scene or another version; {remedy}"
            ))),
        }
    }
}

impl CheckpointStore for KeptFactors {
    fn load(&self, stage: &str) -> Option<Vec<u8>> {
        self.0.load(stage)
    }
    fn save(&self, _: &str, _: &[u8]) {}
    fn keeps(&self) -> bool {
        false
    }
}
