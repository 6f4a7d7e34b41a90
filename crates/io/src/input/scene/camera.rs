//! `[[camera]]`: position, direction and lens.

use crate::input::reading::error::InputError;
use crate::input::toml::camera_keys::CAMERA;
use crate::input::toml::node::TomlNode;
use zonal_math::vec3;
use zonal_scene::{Camera, Lens};

/// Angle of view across the picture's width, degrees.
pub(crate) fn read_fov(n: TomlNode<'_>) -> Result<f64, InputError> {
    match n.number()? {
        x if x > 0.0 && x < 180.0 => Ok(x),
        x => Err(n.error(format!("{x} is out of range; give degrees above 0 and below 180"))),
    }
}

/// Diameter of the lens, m, from 0.
pub(crate) fn read_aperture(n: TomlNode<'_>) -> Result<f64, InputError> {
    match n.number()? {
        x if x >= 0.0 => Ok(x),
        x => Err(n.error(format!("{x} is out of range; give the lens's diameter in metres, from 0"))),
    }
}

/// Reads entry `index` of `[[camera]]`.
pub(crate) fn read_camera(node: &TomlNode<'_>, index: usize) -> Result<Camera, InputError> {
    let (name, mut t) = node.named_table("camera", index)?;
    t.check(CAMERA)?;
    t.key = format!("camera '{name}'");
    t.record_place();
    Ok(Camera {
        origin: t.require("origin", "origin = [x, y, z]")?.vector()?,
        target: t.require("target", "target = [x, y, z]")?.vector()?,
        up: t.read("up", |n| n.vector())?.unwrap_or(vec3(0.0, 0.0, 1.0)),
        fov: t.read("fov", read_fov)?.unwrap_or(60.0),
        lens: Lens {
            aperture: t.read("aperture", read_aperture)?.unwrap_or(0.0),
            focus: t.read("focus", |n| n.positive())?,
        },
        name,
    })
}
