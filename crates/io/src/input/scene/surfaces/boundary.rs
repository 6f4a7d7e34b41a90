//! `[boundary]`: periodic axes, symmetry planes, and the boundary box of a scene without a medium.

use crate::input::reading::error::InputError;
use crate::input::toml::key_tables::BOUNDARY;
use crate::input::toml::node::TomlNode;
use zonal_scene::SceneParts;

/// The keys of each axis: both ends, the low end, the high end.
const KEYS: [[&str; 3]; 3] = [["x", "x0", "x1"], ["y", "y0", "y1"], ["z", "z0", "z1"]];

/// Reads `[boundary]` into the parts of a scene. The key of one end overrides that of its axis.
pub(crate) fn read_boundary(node: &TomlNode<'_>, parts: &mut SceneParts) -> Result<(), InputError> {
    let t = node.table(BOUNDARY)?;
    for (axis, [both, low, high]) in KEYS.into_iter().enumerate() {
        let kind = t.read(both, |n| n.choice(&["scene", "periodic", "symmetry"]))?;
        parts.periodic[axis] = kind == Some(1);
        for (end, key) in [low, high].into_iter().enumerate() {
            let own = t.read(key, |n| n.choice(&["scene", "symmetry"]))?;
            parts.symmetry_planes[axis][end] = own.map_or(kind == Some(2), |own| own == 1);
        }
    }
    let min = t.read("min", |n| n.vector())?;
    let max = t.read("max", |n| n.vector())?;
    parts.boundary_box = match (min, max) {
        (Some(min), Some(max)) => Some((min, max)),
        (None, None) => None,
        _ => return Err(t.error("give both corners of the boundary, min and max, or none")),
    };
    Ok(())
}
