//! Scenes in: one TOML file, and the meshes, pictures and densities that it refers to.
//!
//! The format is described for its users in `docs/scene-format.md`. Lengths in metres, z up, extinction in 1/m, emission in
//! W/m², radiance in W/(m² sr), sources in W/m³; a number stands for all three bands, `[r, g, b]` for one each.
//!
//! | module | what |
//! |---|---|
//! | `source`, `node` | the text and its places; typed reading of TOML, every value with its key, line and column |
//! | `build` | settings, lights, cameras, and the order of reading |
//! | `surface`, `shapes` | surfaces and panes; inline geometry |
//! | `medium`, `region`, `density` | the voxmap and its regions |
//! | `npy`, `vol`, `vdb` | arrays and sparse grids |
//! | `texture` | pictures |
//! | `flight` | key frames of a camera's path, a file of its own |
//! | `mesh` | surfaces from OBJ and glTF |
//! | `error` | refusals that name the place and the mend |
//!
//! Nothing here panics on any input: indices from a file are looked up, sizes are checked before memory is taken.

mod arrays;
mod build;
mod density;
mod error;
pub(crate) mod files;
mod flight;
mod medium;
pub(crate) mod mesh;
mod node;
mod npy;
mod region;
mod shapes;
mod source;
mod surface;
mod texture;
mod thermal;
mod vdb;
mod vol;

pub use error::InputError;
pub use flight::{Flight, Key, MAX_FRAMES, parse_flight, read_flight};
pub use mesh::volume::{VolumeMaterial, volume_materials, volume_materials_from_bytes};

use files::Files;
pub use files::FilesInMemory;
use node::Table;
use source::Source;
use std::path::Path;
use zonal_scene::{Scene, voxmap::MAX_CELLS};

/// The largest scene text, bytes.
const MAX_TEXT: u64 = 64 << 20;

/// Reads a scene file, and the files that it refers to, relative to its folder.
pub fn read_scene(path: &Path) -> Result<Scene, InputError> {
    let file = path.display().to_string();
    let text = read_text(path, MAX_TEXT)?;
    let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned());
    parse_named(&text, on_disk(path.parent()), &file, stem.as_deref().unwrap_or("scene"))
}

/// A regular file, open for reading. Pipes, devices, sockets, folders and files of more than `most` bytes are refused at once.
pub fn open_file(path: &Path, most: u64) -> Result<std::fs::File, InputError> {
    let refused = |what: String| InputError::new(&path.display().to_string(), None, "", what);
    let (file, length) = files::open(path).map_err(refused)?;
    if length > most {
        let what = format!("this file is larger than the {} MiB that are read; make it smaller", most >> 20);
        return Err(refused(what));
    }
    Ok(file)
}

/// The text of a file of at most so many bytes.
fn read_text(path: &Path, most: u64) -> Result<String, InputError> {
    let file = path.display().to_string();
    let refused = |what: String| InputError::new(&file, None, "", what);
    utf8(&file, files::read(path, most).map_err(refused)?)
}

fn utf8(file: &str, bytes: Vec<u8>) -> Result<String, InputError> {
    String::from_utf8(bytes).map_err(|e| {
        let line = e.as_bytes()[..e.utf8_error().valid_up_to()].iter().filter(|b| **b == b'\n').count();
        let what = "this is not UTF-8 text; save the file as UTF-8";
        InputError::new(file, Some((line + 1, 1)), "", what)
    })
}

/// Reads a scene from its text. Referenced files are looked for in `base`; without one they are refused.
/// `name_for_messages` stands for the file in messages.
pub fn parse_scene(text: &str, base: Option<&Path>, name_for_messages: &str) -> Result<Scene, InputError> {
    parse_named(text, on_disk(base), name_for_messages, "scene")
}

/// As [`read_scene`], of bytes in memory: the scene's text, and the files that it refers to. Media of more than `most_cells` cells
/// are refused.
pub fn read_scene_from_bytes(
    text: &[u8],
    files: &FilesInMemory,
    name_for_messages: &str,
    most_cells: usize,
) -> Result<Scene, InputError> {
    let text = utf8(name_for_messages, text.to_vec())?;
    let place = build::Place { base: Some(Path::new("")), files: Files::Memory(files), most_cells };
    parse_named(&text, place, name_for_messages, "scene")
}

fn on_disk(base: Option<&Path>) -> build::Place<'_> {
    build::Place { base, files: Files::Disk, most_cells: MAX_CELLS }
}

fn parse_named(text: &str, place: build::Place<'_>, file: &str, name: &str) -> Result<Scene, InputError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let source = Source::new(file, text);
    let document = source.parse()?;
    build::scene(&Table::root(&source, document.get_ref()), place, name)
}
