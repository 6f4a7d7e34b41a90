//! Scenes from a template file whose numbers are replaced.

use super::scene_text::{MAX_SCENE_TEXT_BYTES, on_disk, parse_named};
use crate::input::reading::error::InputError;
use crate::input::reading::text::read_text;
use crate::input::toml::template::TextTemplate;
use std::path::{Path, PathBuf};
use zonal_scene::Scene;

/// A scene file with numbers to replace, each named by its path in the file: `medium.heat_source`, `surface.NAME.temperature`,
/// `surface.0.emissivity`, `medium.max.2`, `surface.*.emissivity`.
#[derive(Clone, Debug)]
pub struct SceneTemplate {
    path: PathBuf,
    template: TextTemplate,
}

impl SceneTemplate {
    /// Reads the text of a scene and finds the numbers at `paths`.
    ///
    /// # Errors
    ///
    /// The file cannot be read or is not TOML, a path leads to no number, or two lead to the same.
    ///
    /// ```
    /// use zonal_io::input::SceneTemplate;
    ///
    /// let path = std::env::temp_dir().join(format!("zonal-doc-template-{}.toml", std::process::id()));
    /// std::fs::write(&path, "[medium]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\ncells = [2, 2, 2]\nextinction = 0.5")?;
    /// let template = SceneTemplate::read(&path, &["medium.extinction".into()])?;
    /// let scene = template.scene(&[2.0])?;
    /// assert_eq!(scene.voxel_grid().unwrap().extinction(0).to_rgb(), [2.0; 3]);
    /// # std::fs::remove_file(&path)?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn read(path: &Path, paths: &[String]) -> Result<SceneTemplate, InputError> {
        let text = read_text(path, MAX_SCENE_TEXT_BYTES)?;
        let template = TextTemplate::new(&path.display().to_string(), &text, paths)?;
        Ok(SceneTemplate { path: path.into(), template })
    }
    /// The scene with other numbers, one for each path.
    ///
    /// # Errors
    ///
    /// As [`crate::input::read_scene`].
    pub fn scene(&self, values: &[f64]) -> Result<Scene, InputError> {
        let stem = self.path.file_stem().map(|s| s.to_string_lossy().into_owned());
        let text = self.template.text_with(values);
        let name = self.path.display().to_string();
        parse_named(&text, on_disk(self.path.parent()), &name, stem.as_deref().unwrap_or("scene"))
    }
}
