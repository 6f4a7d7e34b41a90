//! Scenes in: one TOML file, and the meshes, images and voxel grids that it refers to.
//!
//! Its users' manual is `docs/reference/scene-format.md`; [`scene_key_reference`] lists every key. Lengths in metres, z up, extinction in 1/m,
//! emission in W/m², radiance in W/(m² sr), sources in W/m³; a number stands for all three bands, `[r, g, b]` for one each.
//!
//! | folder | contents |
//! |---|---|
//! | `entry_points` | scenes, cameras and meshes as callers read them |
//! | `scene` | the sections of a scene: settings, surfaces, panes, medium, lights, cameras |
//! | `view3d` | input files of View3D: surfaces, obstructions and controls of view factors |
//! | `light_files`, `grids` | luminaires and skies; sparse grids and volumes |
//! | `mesh_files` | mesh formats |
//! | `mesh` | meshes independent of their format |
//! | `toml` | text and places, typed values, tables of keys |
//! | `tables` | columns of values by face, zone or name: CSV, npy, cell data of VTK; spectra |
//! | `vtk` | VTK's XML files |
//! | `images` | PNG and JPEG textures |
//! | `reading` | text, numbers, errors and notes |
//!
//! A folder uses the folders below it in this table alone.
//!
//! No input makes a reader panic: indices are checked, and sizes are compared with the length of the file before memory is allocated.

mod entry_points;
mod grids;
mod images;
mod light_files;
mod memory_arrays;
mod mesh;
mod mesh_files;
mod reading;
mod scene;
pub(crate) mod tables;
mod toml;
mod view3d;
mod vtk;

pub use crate::file_stamps::{FileRecord, FilesRead};
pub use crate::files::FilesInMemory;
pub use crate::memory_arrays::{ArraysInMemory, GridArray, GridOrder, GridValues, MemoryArray, MeshArrays};
pub use entry_points::camera_file::read_cameras;
pub use entry_points::camera_path::{CameraPath, KeyFrame, MAX_FRAMES, parse_camera_path, read_camera_path};
pub use entry_points::facets::{FacetFile, read_facets};
pub use entry_points::model_survey::{ModelSurvey, PartCounts, SurveyedMaterial, survey_model};
pub use entry_points::scene_template::SceneTemplate;
pub use entry_points::solve_settings::read_solve_settings;
pub use mesh_files::load::mesh_extensions;
pub use mesh_files::stl::{StlFacet, StlFile, read_stl};
pub use reading::error::InputError;
pub use reading::text::open_file;
pub use tables::{Quantity, RowKeys, ValueTable, read_values};
pub use toml::key_tables::{SceneKey, scene_key_reference};
pub use view3d::{
    View3dControls, View3dFile, View3dOutput, View3dSurface, View3dSurfaceKind, read_view3d,
    read_view3d_from_bytes,
};

#[cfg(test)]
pub(crate) use mesh_files::gltf::read_mesh_file as read_gltf;

use crate::files::FileSource;
use entry_points::scene_text::{MAX_SCENE_TEXT_BYTES, on_disk, parse_named};
use reading::text::{decode_utf8, read_text};
use scene::scene_reader::ReadContext;
use std::path::Path;
use zonal_scene::Scene;

/// Reads a scene file, and the files that it refers to, relative to its folder.
///
/// # Errors
///
/// The file cannot be read, is not TOML, has unknown keys or values out of range, or the scene is not valid; so for every file that it
/// refers to.
///
/// ```
/// let path = std::env::temp_dir().join(format!("zonal-doc-scene-{}.toml", std::process::id()));
/// std::fs::write(&path, "[medium]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\ncells = [2, 2, 2]\nextinction = 0.5")?;
/// let scene = zonal_io::input::read_scene(&path)?;
/// assert_eq!(scene.voxel_grid().unwrap().len(), 8);
/// # std::fs::remove_file(&path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_scene(path: impl AsRef<Path>) -> Result<Scene, InputError> {
    FileRecord::default().read_scene(path.as_ref())
}

impl FileRecord {
    /// As [`read_scene`].
    ///
    /// # Errors
    ///
    /// As [`read_scene`].
    pub fn read_scene(&self, path: &Path) -> Result<Scene, InputError> {
        let file = path.display().to_string();
        self.add_opening(path);
        let text = read_text(path, MAX_SCENE_TEXT_BYTES)?;
        let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned());
        let context = ReadContext { files: FileSource::recorded(self), ..on_disk(path.parent()) };
        parse_named(&text, context, &file, stem.as_deref().unwrap_or("scene"))
    }

    /// As [`parse_scene`].
    ///
    /// # Errors
    ///
    /// As [`read_scene`].
    pub fn parse_scene(
        &self,
        text: &str,
        base: Option<&Path>,
        name_for_messages: &str,
    ) -> Result<Scene, InputError> {
        let context = ReadContext { files: FileSource::recorded(self), ..on_disk(base) };
        parse_named(text, context, name_for_messages, "scene")
    }
}

/// Reads a scene from its text. Referenced files are looked for in `base`; without one they are refused.
/// `name_for_messages` stands for the file in messages.
///
/// # Errors
///
/// As [`read_scene`].
///
/// ```
/// use zonal_io::input::parse_scene;
///
/// let scene = parse_scene("[[surface]]\nname = 'cube'\nbox = { min = [0, 0, 0], max = [1, 1, 1] }", None, "cube.toml")?;
/// assert_eq!(scene.facets().len(), 6);
/// let error = parse_scene("[[surface]]\nboxx = 1", None, "cube.toml").unwrap_err();
/// assert_eq!(error.to_string(), "cube.toml:2:1: surface #1.boxx: unknown key; did you mean 'box'?");
/// # Ok::<(), zonal_io::input::InputError>(())
/// ```
pub fn parse_scene(text: &str, base: Option<&Path>, name_for_messages: &str) -> Result<Scene, InputError> {
    parse_named(text, on_disk(base), name_for_messages, "scene")
}

/// Reads a scene from its text, with arrays in memory in place of some of the files that it refers to. Other files are looked for in `base`, the working
/// folder if it is empty. `name_for_messages` stands for the file in messages, `default_name` is the name of a scene without one.
///
/// # Errors
///
/// As [`read_scene`].
pub fn parse_scene_with_arrays(
    text: &str,
    base: &Path,
    arrays: &ArraysInMemory<'_>,
    name_for_messages: &str,
    default_name: &str,
) -> Result<Scene, InputError> {
    let context = ReadContext { files: FileSource::arrays(arrays), ..on_disk(Some(base)) };
    parse_named(text, context, name_for_messages, default_name)
}

/// Reads a scene from bytes in memory: its text, and the files that it refers to. Media of more than `max_cells` voxels are refused.
///
/// # Errors
///
/// As [`read_scene`].
pub fn read_scene_from_bytes(
    text: &[u8],
    files: &FilesInMemory,
    name_for_messages: &str,
    max_cells: usize,
) -> Result<Scene, InputError> {
    let text = decode_utf8(name_for_messages, text.to_vec())?;
    let context = ReadContext { base: Some(Path::new("")), files: FileSource::memory(files), max_cells };
    parse_named(&text, context, name_for_messages, "scene")
}
