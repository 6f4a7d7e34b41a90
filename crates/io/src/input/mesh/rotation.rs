//! Rotations of placed meshes and grids.

use crate::input::reading::error::InputError;
use crate::input::toml::node::TomlTable;
use zonal_math::{Vec3, vec3};

/// Images of vectors of one length along x, y, z under `rotate_degrees`: rotations about x, then y, then z.
pub(crate) fn rotated_axes(t: &TomlTable<'_>, length: f64) -> Result<[Vec3; 3], InputError> {
    let turn = t.read("rotate_degrees", |n| n.vector())?.unwrap_or_default();
    let [(sx, cx), (sy, cy), (sz, cz)] = turn.array().map(|a| a.to_radians().sin_cos());
    let rotate = |v: Vec3| {
        let v = vec3(v.x, cx * v.y - sx * v.z, sx * v.y + cx * v.z);
        let v = vec3(cy * v.x + sy * v.z, v.y, cy * v.z - sy * v.x);
        vec3(cz * v.x - sz * v.y, sz * v.x + cz * v.y, v.z)
    };
    Ok([vec3(length, 0.0, 0.0), vec3(0.0, length, 0.0), vec3(0.0, 0.0, length)].map(rotate))
}
