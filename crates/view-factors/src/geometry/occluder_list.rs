//! Lists of potential occluders along the recursion: nodes of the occluder trees with blocks of images, that a shaft does not exclude.

use crate::bounds::Bounds;
use crate::geometry::Geometry;
use crate::periods::{ImageBlock, PeriodicImages};

/// A node of an occluder tree in the images of a block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OccluderNode {
    pub node: u32,
    /// The tree: occluders that are endless along the same axes.
    pub tree: u8,
    pub block: ImageBlock,
}

/// All occluders in all images.
pub(crate) fn all(geometry: &Geometry, images: &PeriodicImages) -> Vec<OccluderNode> {
    let trees = geometry.occluder_trees.iter().enumerate().filter(|(_, t)| !t.nodes.is_empty());
    trees
        .map(|(k, _)| OccluderNode { node: 0, tree: k as u8, block: images.all(endless_axes(k as u8)) })
        .collect()
}

/// The axes along which the occluders of a tree are endless.
pub(crate) fn endless_axes(tree: u8) -> [bool; 2] {
    [tree & 1 != 0, tree & 2 != 0]
}

/// The entries of `list` that `excludes` keeps; nodes and blocks larger than `size` (m) are replaced by their parts.
pub(crate) fn filter(
    geometry: &Geometry,
    images: &PeriodicImages,
    list: &[OccluderNode],
    size: f64,
    excludes: impl Fn(&Bounds) -> bool,
    out: &mut Vec<OccluderNode>,
) {
    let mut stack: Vec<OccluderNode> = Vec::new();
    for entry in list {
        stack.push(*entry);
        while let Some(e) = stack.pop() {
            let node = &geometry.occluder_trees[e.tree as usize].nodes[e.node as usize];
            let bounds = images.bounds(&node.bounds, &e.block);
            if excludes(&bounds) {
                continue;
            }
            let is_large = bounds.radius() > size;
            if is_large && !e.block.is_single() {
                let [near, far] = e.block.divided(images.longer_axis(&e.block));
                stack.push(OccluderNode { block: far, ..e });
                stack.push(OccluderNode { block: near, ..e });
                continue;
            }
            match node.children {
                Some([left, right]) if is_large => {
                    stack.push(OccluderNode { node: right, ..e });
                    stack.push(OccluderNode { node: left, ..e });
                }
                _ => out.push(e),
            }
        }
    }
}

/// The occluder of a leaf of an occluder tree in a single image.
pub(crate) fn single(geometry: &Geometry, entry: OccluderNode) -> Option<usize> {
    let tree = &geometry.occluder_trees[entry.tree as usize];
    let node = &tree.nodes[entry.node as usize];
    (node.children.is_none() && entry.block.is_single()).then(|| tree.order[node.first as usize] as usize)
}
