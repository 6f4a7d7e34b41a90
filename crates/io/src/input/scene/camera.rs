//! `[[camera]]`: position, direction and lens.

use crate::input::reading::error::InputError;
use crate::input::toml::camera_keys::{Camera as CameraKeys, VIEW};
use crate::input::toml::node::TomlNode;
use zonal_scene::{Camera, Lens};

/// Reads entry `index` of `[[camera]]`.
pub(crate) fn read_camera(node: &TomlNode<'_>, index: usize) -> Result<Camera, InputError> {
    let (name, mut t) = node.named_table("camera", index)?;
    t.check(CameraKeys::TABLE)?;
    t.key = format!("camera '{name}'");
    t.record_place();
    Ok(Camera {
        origin: t.required(&VIEW.origin)?,
        target: t.required(&VIEW.target)?,
        up: t.or_default(&VIEW.up)?,
        fov: t.or_default(&VIEW.fov)?,
        lens: Lens { aperture: t.or_default(&VIEW.aperture)?, focus: t.value(&VIEW.focus)? },
        name,
    })
}
