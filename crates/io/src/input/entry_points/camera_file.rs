//! A file of cameras: `[[camera]]` tables as in a scene.

use crate::input::reading::error::InputError;
use crate::input::reading::text::read_text;
use crate::input::scene::camera::read_camera;
use crate::input::toml::camera_keys::{CAMERA_FILE, CameraFile};
use crate::input::toml::node::TomlTable;
use crate::input::toml::source::SourceText;
use std::path::Path;
use zonal_scene::Camera;

/// Largest text, bytes.
const MAX_CAMERA_TEXT_BYTES: u64 = 1 << 20;

/// Reads a file of cameras.
///
/// # Errors
/// The file cannot be read, is not TOML, has unknown keys or values out of range, or no camera.
///
/// ```
/// let path = std::env::temp_dir().join(format!("zonal-doc-cameras-{}.toml", std::process::id()));
/// std::fs::write(&path, "[[camera]]\nname = 'door'\norigin = [0, 0, 1]\ntarget = [1, 0, 1]").unwrap();
/// assert_eq!(zonal_io::input::read_cameras(&path)?[0].name, "door");
/// # std::fs::remove_file(&path).unwrap();
/// # Ok::<(), zonal_io::input::InputError>(())
/// ```
pub fn read_cameras(path: &Path) -> Result<Vec<Camera>, InputError> {
    let (file, text) = (path.display().to_string(), read_text(path, MAX_CAMERA_TEXT_BYTES)?);
    let source = SourceText::new(&file, &text);
    let document = source.parse()?;
    let root = TomlTable::root(&source, document.get_ref());
    root.check(CameraFile::TABLE)?;
    let nodes = root.list(&CAMERA_FILE.camera)?;
    let cameras: Vec<Camera> =
        nodes.iter().enumerate().map(|(i, node)| read_camera(node, i)).collect::<Result<_, _>>()?;
    if cameras.is_empty() {
        return Err(root.error("there is no camera; write [[camera]] with origin and target"));
    }
    Ok(cameras)
}
