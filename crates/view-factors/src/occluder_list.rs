//! Lists of potential occluders along the recursion: nodes of the occluder tree, displaced by periods, that a shaft does not exclude.

use crate::bounds::Bounds;
use crate::geometry::Geometry;
use zonal_math::Vec3;

/// A node of the occluder tree, displaced.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OccluderNode {
    pub node: u32,
    /// Index of the displacement.
    pub shift: u32,
}

/// Displacements by periods; the first is zero.
pub(crate) type Shifts = [Vec3];

/// The entries of `list` that `excludes` keeps; nodes larger than `size` (m) are replaced by their children.
pub(crate) fn filter(
    geometry: &Geometry,
    shifts: &Shifts,
    list: &[OccluderNode],
    size: f64,
    excludes: impl Fn(&Bounds) -> bool,
    out: &mut Vec<OccluderNode>,
) {
    let mut stack: Vec<OccluderNode> = Vec::new();
    for entry in list {
        stack.push(*entry);
        while let Some(e) = stack.pop() {
            let node = &geometry.occluder_tree.nodes[e.node as usize];
            let bounds = node.bounds.shifted(shifts[e.shift as usize]);
            if excludes(&bounds) {
                continue;
            }
            match node.children {
                Some([left, right]) if bounds.radius() > size => {
                    stack.push(OccluderNode { node: right, ..e });
                    stack.push(OccluderNode { node: left, ..e });
                }
                _ => out.push(e),
            }
        }
    }
}

/// The occluder of a leaf of the occluder tree.
pub(crate) fn single(geometry: &Geometry, entry: OccluderNode) -> Option<usize> {
    let node = &geometry.occluder_tree.nodes[entry.node as usize];
    node.children.is_none().then(|| geometry.occluder_tree.order[node.first as usize] as usize)
}
