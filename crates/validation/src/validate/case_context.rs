//! The context of a case: folders, progress, and the solution of scenes as texts that a user could run.

use std::path::{Path, PathBuf};
use zonal_io::{input, output};
use zonal_report::Failure;
use zonal_scene::{Progress, Scene, Solution};
use zonal_solve::SolveSettings;

/// The largest memory of a solve, bytes.
const MEMORY: u64 = 12 << 30;

/// The context of all cases.
pub(crate) struct CaseContext<'a> {
    /// The folder of reference files.
    pub reference: &'a Path,
    /// Where pictures for the page go; `None` where no page is written.
    pub pictures: Option<&'a Path>,
    /// Listener.
    pub progress: &'a dyn Progress,
    work: PathBuf,
    keep: bool,
}

impl<'a> CaseContext<'a> {
    /// A context; scenes and their arrays are written into `scenes` and stay there, or into a folder that is removed with the context.
    pub(crate) fn new(
        reference: &'a Path,
        pictures: Option<&'a Path>,
        scenes: Option<&Path>,
        progress: &'a dyn Progress,
    ) -> Result<CaseContext<'a>, Failure> {
        let own = || std::env::temp_dir().join(format!("zonal-validate-{}", std::process::id()));
        let work = scenes.map_or_else(own, Path::to_path_buf);
        std::fs::create_dir_all(&work).map_err(|e| {
            Failure::new(format!("{}: the folder cannot be made ({e}); choose another", work.display()))
        })?;
        Ok(CaseContext { reference, pictures, progress, work, keep: scenes.is_some() })
    }

    /// Solves a scene of this name.
    pub(crate) fn solve(&self, name: &str, text: &str) -> Result<Solution, Failure> {
        let file = self.work.join(format!("{name}.toml"));
        if self.keep {
            output::write_bytes(&file, text.as_bytes())?;
        }
        self.solve_scene(self.scene(name, text)?)
    }

    /// Reads a scene of this name.
    pub(crate) fn scene(&self, name: &str, text: &str) -> Result<Scene, Failure> {
        let file = self.work.join(format!("{name}.toml"));
        Ok(input::parse_scene(text, Some(&self.work), &file.display().to_string())?)
    }

    /// Solves a scene, without the estimate of the discretization error unless the scene requests it.
    pub(crate) fn solve_scene(&self, scene: Scene) -> Result<Solution, Failure> {
        let mut options = scene.options().clone();
        options.discretization_error.get_or_insert(false);
        let scene = scene.with_options(options)?;
        let mut solution =
            zonal_solve::solve_with_settings(scene, &SolveSettings::new(MEMORY, self.progress))?;
        solution.scene_hash = output::scene_hash(&solution.scene);
        Ok(solution)
    }

    /// Writes a text that scenes name by the file that comes back.
    pub(crate) fn text_file(&self, file: &str, text: &str) -> Result<String, Failure> {
        output::write_bytes(&self.work.join(file), text.as_bytes())?;
        Ok(file.to_string())
    }

    /// Writes an array that scenes name by the file that comes back.
    pub(crate) fn array(&self, name: &str, shape: &[usize], values: &[f64]) -> Result<String, Failure> {
        let file = format!("{name}.npy");
        output::write_array(&self.work.join(&file), shape, values)?;
        Ok(file)
    }
}

impl Drop for CaseContext<'_> {
    fn drop(&mut self) {
        if !self.keep {
            let _ = std::fs::remove_dir_all(&self.work);
        }
    }
}
