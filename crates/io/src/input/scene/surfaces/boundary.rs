//! `[boundary]`: periodic axes, symmetry planes, and the boundary box of a scene without a medium.

use crate::input::reading::error::InputError;
use crate::input::toml::key_tables::{BOUNDARY, Boundary};
use crate::input::toml::keys::Key;
use crate::input::toml::node::TomlNode;
use zonal_scene::SceneParts;

/// The keys of each axis: both ends, the low end, the high end.
const KEYS: [[Key<usize>; 3]; 3] = {
    let b = BOUNDARY;
    [[b.x, b.x0, b.x1], [b.y, b.y0, b.y1], [b.z, b.z0, b.z1]]
};
/// Places in the words of these keys.
const SYMMETRY: usize = 0;
const PERIODIC: usize = 1;

/// Reads `[boundary]` into the parts of a scene. The key of one end overrides that of its axis.
pub(crate) fn read_boundary(node: &TomlNode<'_>, parts: &mut SceneParts) -> Result<(), InputError> {
    let t = node.table(Boundary::TABLE)?;
    for (axis, [both, low, high]) in KEYS.iter().enumerate() {
        let kind = t.value(both)?;
        parts.periodic[axis] = kind == Some(PERIODIC);
        for (end, key) in [low, high].into_iter().enumerate() {
            parts.symmetry_planes[axis][end] = t.value(key)?.or(kind) == Some(SYMMETRY);
        }
    }
    parts.boundary_box = match (t.value(&BOUNDARY.min)?, t.value(&BOUNDARY.max)?) {
        (Some(min), Some(max)) => Some((min, max)),
        (None, None) => None,
        _ => return Err(t.error("give both corners of the boundary, min and max, or none")),
    };
    Ok(())
}
