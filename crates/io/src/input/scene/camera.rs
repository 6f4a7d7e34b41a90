//! `[[camera]]`: position, direction and lens.

use crate::input::reading::error::InputError;
use crate::input::toml::camera_keys::{Camera as CameraKeys, VIEW};
use crate::input::toml::node::{TomlNode, TomlTable};
use zonal_scene::{Camera, Lens};

/// Reads entry `index` of `[[camera]]`.
pub(crate) fn read_camera(node: &TomlNode<'_>, index: usize) -> Result<Camera, InputError> {
    let (name, mut t) = node.named_table("camera", index)?;
    t.check(CameraKeys::TABLE)?;
    t.key = format!("camera '{name}'");
    t.record_place();
    Ok(read_view(&t, None)?.name(name))
}

/// Reads position and lens of a camera, those of `base` where the table has none.
pub(crate) fn read_view(t: &TomlTable<'_>, base: Option<Camera>) -> Result<Camera, InputError> {
    let base = match base {
        Some(base) => base,
        None => Camera::look_at(t.required(&VIEW.origin)?.array(), t.required(&VIEW.target)?.array()),
    };
    Ok(Camera {
        origin: t.value(&VIEW.origin)?.unwrap_or(base.origin),
        target: t.value(&VIEW.target)?.unwrap_or(base.target),
        up: t.value(&VIEW.up)?.unwrap_or(base.up),
        fov: t.value(&VIEW.fov)?.unwrap_or(base.fov),
        lens: Lens {
            aperture: t.value(&VIEW.aperture)?.unwrap_or(base.lens.aperture),
            focus: t.value(&VIEW.focus)?.or(base.lens.focus),
        },
        ..base
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn documented_defaults_are_those_of_a_camera() {
        let camera = Camera::look_at([0.0; 3], [1.0; 3]);
        assert_eq!(VIEW.up.default().unwrap(), camera.up);
        assert_eq!(VIEW.fov.default().unwrap(), camera.fov);
        assert_eq!(VIEW.aperture.default().unwrap(), camera.lens.aperture);
    }
}
