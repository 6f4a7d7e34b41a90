//! The cluster tree: one tree over all zones, in flat arrays.
//!
//! Every zone is a **leaf**. A node represents its leaves by the moments of their measure W (area of a patch, volume of a volume zone):
//!
//! ```text
//! W = Σ W_k      c = Σ W_k x_k / W      C = Σ W_k ((x_k − c)(x_k − c)ᵀ + C_k) / W      n̄ = Σ W_k n_k / W
//! ```
//!
//! with C_k the covariance of a uniform distribution over leaf k. n̄ is the vector area over the area, shorter than one where normals
//! differ. A node also stores a bounding box, a cone that holds its normals and the range of its leaves.
//!
//! **Layout.** Inner nodes come first in breadth-first order, so the index of a parent is below those of its children. The leaves follow
//! in the order of the tree, so the leaves of a node are one range.

use zonal_math::Vec3;

/// Kind of the leaves of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ClusterKind {
    /// Surface zones.
    Patch,
    /// Voxel zones.
    Voxel,
    /// Pane zones.
    Pane,
    /// More than one kind; the root alone.
    Mixed,
}

/// A cluster of zones, or one zone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClusterNode {
    /// W-weighted centroid, m.
    pub centre: [f32; 3],
    /// Lower corner of the bounding box of the zones, m.
    pub lo: Vec3,
    /// Upper corner, m.
    pub hi: Vec3,
    /// Covariance xx, yy, zz, xy, xz, yz, m².
    pub covariance: [f32; 6],
    /// n̄; the unit normal of a pane; zero for voxels.
    pub normal: [f32; 3],
    /// Sine of the half angle of the cone about n̄ that holds all normals; above 1 where it is wider than a half space.
    pub cone_sine: f32,
    /// W, m² or m³.
    pub measure: f32,
    /// Extinction of the medium at its zones, mean over zones and bands, 1/m.
    pub extinction: f32,
    /// First leaf.
    pub first_leaf: u32,
    /// One past the last leaf.
    pub end_leaf: u32,
    /// First child in the tree's list.
    pub first_child: u32,
    /// Number of children; zero for a leaf.
    pub child_count: u8,
    /// Kind of the leaves.
    pub kind: ClusterKind,
    /// The zones fill the box, which then represents them: whole voxels, or axis-parallel rectangles in one plane.
    pub fills_box: bool,
}

impl ClusterNode {
    /// Centroid.
    pub(crate) fn centre(&self) -> Vec3 {
        Vec3::from_array(self.centre.map(f64::from))
    }
    /// Mean normal.
    pub(crate) fn normal(&self) -> Vec3 {
        Vec3::from_array(self.normal.map(f64::from))
    }
    /// Half the diagonal of the box, m.
    pub(crate) fn radius(&self) -> f64 {
        0.5 * (self.hi - self.lo).length()
    }
    /// Number of leaves.
    pub(crate) fn leaves(&self) -> usize {
        (self.end_leaf - self.first_leaf) as usize
    }
    /// True for a single zone.
    pub(crate) fn is_leaf(&self) -> bool {
        self.child_count == 0
    }
}

/// The tree.
pub(crate) struct ClusterTree {
    /// Inner nodes, then leaves.
    pub nodes: Vec<ClusterNode>,
    /// Number of inner nodes.
    pub inner_nodes: usize,
    /// Children of all inner nodes.
    pub children: Vec<u32>,
    /// The zone of each leaf.
    pub leaf_zones: Vec<u32>,
    /// Parent of each node; of the root the root itself.
    pub parent: Vec<u32>,
}

impl ClusterTree {
    /// The children of a node, by its index.
    pub(crate) fn children(&self, node: u32) -> &[u32] {
        self.children_of(&self.nodes[node as usize])
    }
    /// The children of a node.
    pub(crate) fn children_of(&self, n: &ClusterNode) -> &[u32] {
        &self.children[n.first_child as usize..n.first_child as usize + n.child_count as usize]
    }
    /// The zone of a leaf node.
    pub(crate) fn zone_of(&self, leaf: &ClusterNode) -> usize {
        self.leaf_zones[leaf.first_leaf as usize] as usize
    }
    /// Partitions the zones into the largest nodes of at most `max_leaves` leaves: the part of every zone, and the number of parts.
    pub(crate) fn partition(&self, max_leaves: usize) -> (Vec<u32>, usize) {
        let mut part = vec![0; self.leaves()];
        let (mut count, mut stack) = (0, vec![self.root()]);
        while let Some(n) = stack.pop() {
            let node = &self.nodes[n as usize];
            if node.is_leaf() || node.leaves() <= max_leaves {
                let slots = node.first_leaf as usize..node.end_leaf as usize;
                self.leaf_zones[slots].iter().for_each(|&zone| part[zone as usize] = count);
                count += 1;
            } else {
                stack.extend(self.children(n).iter().rev());
            }
        }
        (part, count as usize)
    }
    /// Index of the root.
    pub(crate) fn root(&self) -> u32 {
        0
    }
    /// Index of a leaf as a node.
    pub(crate) fn leaf_node(&self, leaf: usize) -> usize {
        self.inner_nodes + leaf
    }
    /// Number of leaves.
    pub(crate) fn leaves(&self) -> usize {
        self.leaf_zones.len()
    }
}
