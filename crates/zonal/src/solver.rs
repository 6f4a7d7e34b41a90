//! The solver with its settings.

use crate::Error;
use std::path::PathBuf;
use zonal_io::output::{self, CheckpointFolder, CheckpointKeys, CheckpointState};
use zonal_scene::{
    CheckpointStore, Engine, NoCheckpoints, NoProgress, Progress, Scene, Solution, SolveOptions,
};
use zonal_solve::settings::DEFAULT_MEMORY_LIMIT;
use zonal_solve::{SolveSettings, solve_with_settings};

/// An amount of memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Bytes(u64);

impl Bytes {
    /// An amount in gibibytes.
    #[must_use]
    pub const fn gib(gibibytes: u64) -> Bytes {
        Bytes(gibibytes << 30)
    }
}

/// Solves a scene.
///
/// ```
/// use zonal::prelude::*;
/// let scene = Scene::builder()
///     .surface(Mesh::room([0.0; 3], [1.0; 3]).name("walls").temperature(500.0).emissivity(0.8))
///     .patch_size(0.5)
///     .build()?;
/// let solution = Solver::new(&scene).tolerance(1e-3).discretization_error(false).solve()?;
/// // Nothing is exchanged where everything has one temperature.
/// assert!(solution.surface("walls").unwrap().net_power.abs() < 1e-6);
/// # Ok::<(), zonal::Error>(())
/// ```
#[derive(Clone)]
pub struct Solver<'a> {
    scene: &'a Scene,
    options: SolveOptions,
    memory_limit: u64,
    checkpoint: Option<PathBuf>,
    observer: &'a dyn Progress,
}

impl<'a> Solver<'a> {
    /// A solver with the options of the scene.
    #[must_use]
    pub fn new(scene: &'a Scene) -> Solver<'a> {
        Solver {
            scene,
            options: scene.options().clone(),
            memory_limit: DEFAULT_MEMORY_LIMIT,
            checkpoint: None,
            observer: &NoProgress,
        }
    }

    /// Sets the relative accuracy of the exchange, 0 < tolerance < 1.
    #[must_use]
    pub fn tolerance(mut self, tolerance: f64) -> Solver<'a> {
        self.options.tolerance = tolerance;
        self
    }

    /// Sets the engine.
    #[must_use]
    pub fn engine(mut self, engine: Engine) -> Solver<'a> {
        self.options.engine = engine;
        self
    }

    /// Sets whether a second solve estimates the error of the finite zones; by default it does for thermal scenes.
    #[must_use]
    pub fn discretization_error(mut self, estimated: bool) -> Solver<'a> {
        self.options.discretization_error = Some(estimated);
        self
    }

    /// Sets the memory limit, 12 GiB by default.
    #[must_use]
    pub fn memory_limit(mut self, limit: Bytes) -> Solver<'a> {
        self.memory_limit = limit.0;
        self
    }

    /// Keeps finished stages in a folder. A solve of the same scene that was interrupted continues from there and gives a bitwise identical
    /// result; the folder is removed when the solve is complete.
    #[must_use]
    pub fn checkpoint(mut self, folder: impl Into<PathBuf>) -> Solver<'a> {
        self.checkpoint = Some(folder.into());
        self
    }

    /// Sets the observer of progress.
    #[must_use]
    pub fn observer(mut self, observer: &'a dyn Progress) -> Solver<'a> {
        self.observer = observer;
        self
    }

    /// Solves the scene.
    ///
    /// # Errors
    /// If an option is out of range, the engine does not apply, the solve would exceed the memory limit, or the checkpoint cannot be written.
    pub fn solve(&self) -> Result<Solution, Error> {
        let scene = self.scene.clone().with_options(self.options.clone())?;
        let folder = self.checkpoint.as_ref().map(|path| {
            CheckpointFolder::new(path, CheckpointKeys::of_solve(&scene, CheckpointKeys::EXACT_METHOD))
        });
        if let Some(folder) = &folder {
            folder.claim()?;
            if folder.state() != CheckpointState::Matching {
                folder.clear();
            }
            folder.begin()?;
        }
        let settings = SolveSettings {
            checkpoints: folder.as_ref().map_or(&NoCheckpoints, |f| f as &dyn CheckpointStore),
            ..SolveSettings::new(self.memory_limit, self.observer)
        };
        let mut solution = solve_with_settings(scene, &settings)?;
        solution.scene_hash = output::scene_hash(&solution.scene);
        if let Some(folder) = folder {
            folder.remove();
        }
        Ok(solution)
    }
}
