//! The scenes of the benchmark: furnished rooms, haze and smoke, open fields, gas in meshes, and models of others.

mod files;
mod gas;
mod haze;
mod mesh;
mod open;
mod rooms;

use crate::harness::Error;
use gas::RadiationMode;
use mesh::MeshText;
use std::path::{Path, PathBuf};
use zonal_io::output;

/// Where the files of a scene go, and where shared data lies.
pub(crate) struct SceneFolder<'a> {
    /// The folder of scene files and meshes.
    pub path: &'a Path,
    /// The folder of data that are not part of the project.
    pub shared: &'a Path,
}

impl SceneFolder<'_> {
    /// Writes a mesh beside the scene; gives the beginning of its surface.
    fn mesh_surface(&self, scene: &str, name: &str, mesh: &MeshText) -> Result<String, Error> {
        let text = &mesh.text;
        let file = format!("{scene}-{}.obj", name.replace(' ', "-"));
        output::write_bytes(&self.path.join(&file), text.as_bytes())?;
        Ok(format!("[[surface]]\nname = \"{name}\"\nmesh = {{ file = \"{file}\" }}\n"))
    }
}

/// Writes the files of a scene and gives its text.
type SceneText = fn(&SceneFolder) -> Result<String, Error>;

/// A scene of the benchmark.
pub(crate) struct BenchmarkScene {
    /// Its name.
    pub name: &'static str,
    text: SceneText,
    /// The twin in light mode of a thermal scene.
    twin: Option<SceneText>,
    /// True if it is solved only where it is named.
    pub slow: bool,
    /// True if it needs data that are not part of the project.
    pub needs_shared: bool,
}

const fn generated(name: &'static str, text: SceneText) -> BenchmarkScene {
    BenchmarkScene { name, text, twin: None, slow: false, needs_shared: false }
}

/// The scenes: seventeen, then those that take long.
pub(crate) const SCENES: [BenchmarkScene; 20] = [
    BenchmarkScene { needs_shared: true, ..generated("gallery", files::gallery) },
    generated("chapel", files::chapel),
    generated("church-small", files::church_small),
    generated("furnished-room", rooms::furnished),
    BenchmarkScene {
        twin: Some(|f| gas::sphere(f, RadiationMode::Light)),
        ..generated("gas-sphere", |f| gas::sphere(f, RadiationMode::Thermal))
    },
    BenchmarkScene {
        twin: Some(|f| gas::obstacles(f, RadiationMode::Light)),
        ..generated("gas-obstacles", |f| gas::obstacles(f, RadiationMode::Thermal))
    },
    generated("glass-table", rooms::glass_table),
    BenchmarkScene { needs_shared: true, ..generated("varying-smoke", gas::varying_smoke) },
    generated("city", open::city),
    generated("contacts", rooms::contacts),
    generated("white-room", rooms::white),
    generated("lattice", rooms::lattice),
    generated("haze-coarse", |_| Ok(haze::lamp_in_haze("haze-coarse", 1.0))),
    generated("haze-fine", |_| Ok(haze::lamp_in_haze("haze-fine", 0.25))),
    generated("smoke-window", haze::smoke_by_window),
    generated("terrain", open::terrain),
    generated("ball", open::ball),
    BenchmarkScene { needs_shared: true, slow: true, ..generated("sponza", files::sponza) },
    BenchmarkScene { needs_shared: true, slow: true, ..generated("factory", files::factory) },
    BenchmarkScene { slow: true, ..generated("church", files::church_full) },
];

impl BenchmarkScene {
    /// The scene of a name.
    pub(crate) fn named(name: &str) -> Result<&'static BenchmarkScene, Error> {
        SCENES.iter().find(|s| s.name == name).ok_or_else(|| {
            let names: Vec<&str> = SCENES.iter().map(|s| s.name).collect();
            format!("there is no scene '{name}'; the scenes are {}", names.join(", ")).into()
        })
    }

    /// Writes the scene as `NAME.toml` with its meshes; gives the path, or `None` where shared data are absent.
    pub(crate) fn write(&self, folder: &SceneFolder) -> Result<Option<PathBuf>, Error> {
        self.write_text(folder, "", self.text)
    }

    /// Writes the scene that paths take, the twin of a thermal scene; `None` where shared data are absent.
    pub(crate) fn write_for_paths(&self, folder: &SceneFolder) -> Result<Option<PathBuf>, Error> {
        match self.twin {
            Some(twin) => self.write_text(folder, "-light", twin),
            None => self.write(folder),
        }
    }

    fn write_text(&self, folder: &SceneFolder, end: &str, text: SceneText) -> Result<Option<PathBuf>, Error> {
        if self.needs_shared && !folder.shared.join("data").is_dir() {
            return Ok(None);
        }
        std::fs::create_dir_all(folder.path)?;
        let path = folder.path.join(format!("{}{end}.toml", self.name));
        output::write_bytes(&path, text(folder)?.as_bytes())?;
        Ok(Some(path))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_io::input;

    #[test]
    fn generated_scenes_are_valid_and_always_the_same() {
        let path = std::env::temp_dir().join(format!("zonal-scenes-{}", std::process::id()));
        let folder = SceneFolder { path: &path, shared: Path::new("absent") };
        let facets = |name: &str| match name {
            "ball" => Some(2002),
            "terrain" => Some(6498),
            "gas-sphere" => Some(320),
            _ => None,
        };
        for scene in SCENES.iter().filter(|s| !s.slow) {
            let Some(file) = scene.write(&folder).unwrap() else {
                assert!(scene.needs_shared);
                continue;
            };
            let read = input::read_scene(&file).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(
                facets(scene.name).unwrap_or(read.facets().len()),
                read.facets().len(),
                "{}",
                scene.name
            );
            let twin = scene.write_for_paths(&folder).unwrap().unwrap();
            let twin = input::read_scene(&twin).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(twin.facets().len(), read.facets().len());
            assert!(twin.thermal().is_none());
            let text = std::fs::read_to_string(&file).unwrap();
            assert_eq!(text, (scene.text)(&folder).unwrap());
        }
        std::fs::remove_dir_all(&path).unwrap();
    }

    #[test]
    fn unknown_names_list_the_scenes() {
        let error = BenchmarkScene::named("cellar").map(|s| s.name).unwrap_err().to_string();
        assert!(error.contains("gallery") && error.contains("cellar"));
    }
}
