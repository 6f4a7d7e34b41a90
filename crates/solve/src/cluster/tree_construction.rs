//! Construction of the cluster tree.
//!
//! **Whole voxels**: an octree by the Morton codes of the cells; levels with a single child are left out. **Cut cells** form a subtree of
//! their own, as their incident radiation differs from that of the cells around them. They are split as patches are, each with the
//! direction from the centre of its cell to its centroid as a normal, so that the two sides of a wall separate early. **Patches**: a
//! binary tree; a cluster is split at the mean of the coordinate of largest variance among position, normal times the extent of the
//! cluster, and brightness. Opposite walls therefore separate near the root, and flat clusters are split by position alone.

use super::node_moments::{leaf_node, merge_children};
use super::tree::{ClusterNode, ClusterTree};
use zonal_math::Vec3;
use zonal_scene::{Plate, Scene, VoxelGrid, VoxelZone, Zones};

/// How brightness and position of a zone enter the splits of plates.
struct SplitParams {
    /// Weight of the brightness, beside position and normal.
    brightness_weight: f64,
    /// Brightness over the mean that counts as 0 and as 1 on the logarithmic scale.
    brightness_range: [f64; 2],
    /// Brightness on that scale below which whole cells form an octree of their own.
    dark_octree_brightness: f64,
    /// Distance of the centroid of a cut cell from the centre of the cell, in edges of the cell, below which it has no direction.
    min_centroid_offset: f64,
    /// Share of a cluster that either side of a split at the mean has at least; otherwise it is split in the middle.
    min_share_of_split: usize,
}

const SPLIT_PARAMS: SplitParams = SplitParams {
    brightness_weight: 1.5,
    brightness_range: [0.003, 0.3],
    dark_octree_brightness: 0.25,
    min_centroid_offset: 0.02,
    min_share_of_split: 8,
};

/// Bit that marks the number of an inner node under construction; without it a number is that of a leaf.
const INNER_FLAG: u32 = 1 << 31;
/// Level of the root of an octree: 21 bits a coordinate.
const ROOT_LEVEL: u32 = 20;

/// The tree under construction.
struct TreeBuilder<'a> {
    scene: &'a Scene,
    zones: &'a Zones,
    /// Brightness of every zone on the logarithmic scale, 0 … 1.
    brightness: Vec<f64>,
    /// The zones in the order of the leaves.
    order: Vec<u32>,
    /// Children of the inner nodes.
    inner: Vec<Vec<u32>>,
}

/// A plate, or a cut cell with a direction, to be split by position, normal and brightness.
#[derive(Clone, Copy)]
struct SplitItem {
    zone: u32,
    centre: Vec3,
    normal: Vec3,
    brightness: f64,
}

/// Brightness over the mean on a logarithmic scale from 0 to 1.
fn log_brightness(bright: f32) -> f64 {
    let [dark, lit] = SPLIT_PARAMS.brightness_range.map(f64::ln);
    (((bright as f64).max(1e-30).ln() - dark) / (lit - dark)).clamp(0.0, 1.0)
}

impl TreeBuilder<'_> {
    /// A node of these children; of a single child the child itself.
    fn join(&mut self, children: Vec<u32>) -> u32 {
        if children.len() == 1 {
            return children[0];
        }
        self.inner.push(children);
        INNER_FLAG | (self.inner.len() - 1) as u32
    }

    fn leaf(&mut self, zone: usize) -> u32 {
        self.order.push(zone as u32);
        (self.order.len() - 1) as u32
    }

    /// Adds the subtree of `items` to `subtrees`, if there are any.
    fn add_items(&mut self, mut items: Vec<SplitItem>, subtrees: &mut Vec<u32>) {
        if !items.is_empty() {
            subtrees.push(self.split_items(&mut items));
        }
    }

    /// A binary tree over `items`.
    fn split_items(&mut self, items: &mut [SplitItem]) -> u32 {
        if items.len() == 1 {
            return self.leaf(items[0].zone as usize);
        }
        let middle = split_position(items);
        let (a, b) = items.split_at_mut(middle);
        let children = vec![self.split_items(a), self.split_items(b)];
        self.join(children)
    }

    /// An octree over voxel zones (Morton code, index), split by the bits of `level`.
    fn octree(&mut self, list: &[(u64, u32)], level: u32) -> u32 {
        if list.len() == 1 {
            return self.leaf(self.zones.voxel_offset() + list[0].1 as usize);
        }
        let children = list
            .chunk_by(|a, b| a.0 >> (3 * level) == b.0 >> (3 * level))
            .map(|octant| self.octree(octant, level.saturating_sub(1)))
            .collect();
        self.join(children)
    }

    /// The octree of the whole cells that are dark, or of those that are not.
    fn add_whole_cells(&mut self, grid: &VoxelGrid, dark: bool, subtrees: &mut Vec<u32>) {
        let zones = self.zones;
        let is_dark =
            |k: u32| self.brightness[zones.voxel_offset() + k as usize] < SPLIT_PARAMS.dark_octree_brightness;
        let whole = (0..).zip(&zones.voxels).filter(|(k, z)| z.samples.is_empty() && is_dark(*k) == dark);
        let mut codes: Vec<(u64, u32)> =
            whole.map(|(k, z)| (morton_code(grid.coordinates(z.cell)), k)).collect();
        codes.sort_unstable();
        if !codes.is_empty() {
            subtrees.push(self.octree(&codes, ROOT_LEVEL));
        }
    }

    fn plate_item(&self, zone: usize, plate: &Plate, normal: Vec3) -> SplitItem {
        SplitItem { zone: zone as u32, centre: plate.centre(), normal, brightness: self.brightness[zone] }
    }

    /// A cut cell, with the direction away from the surface that cuts it.
    fn cut_cell_item(&self, zone: usize, z: &VoxelZone, grid: &VoxelGrid) -> SplitItem {
        let middle = grid.corner(grid.coordinates(z.cell)) + grid.cell() * 0.5;
        let offset = z.centre - middle;
        let has_direction = offset.length() > SPLIT_PARAMS.min_centroid_offset * grid.cell().max_abs();
        let normal = if has_direction { offset.normalized() } else { Vec3::ZERO };
        SplitItem { zone: zone as u32, centre: z.centre, normal, brightness: self.brightness[zone] }
    }

    /// Numbers the inner nodes breadth first and computes the moments from the leaves up.
    fn finish(self, root: u32) -> ClusterTree {
        let (order, drafts) = (self.order, self.inner);
        let inner = drafts.len();
        // Breadth-first order of the inner nodes, and the index of each.
        let mut ids = vec![0u32; inner];
        let mut queue: Vec<u32> = Vec::with_capacity(inner);
        if root & INNER_FLAG != 0 {
            queue.push(root & !INNER_FLAG);
        }
        let mut at = 0;
        while at < queue.len() {
            let d = queue[at] as usize;
            ids[d] = at as u32;
            queue.extend(drafts[d].iter().filter(|k| *k & INNER_FLAG != 0).map(|k| k & !INNER_FLAG));
            at += 1;
        }
        let id_of =
            |x: u32| if x & INNER_FLAG != 0 { ids[(x & !INNER_FLAG) as usize] } else { inner as u32 + x };
        // Leaves behind the inner nodes, whose moments follow.
        let (scene, zones) = (self.scene, self.zones);
        let leaf = |(&z, k): (&u32, u32)| leaf_node(scene, zones, z as usize, k);
        let leaves: Vec<ClusterNode> = order.iter().zip(0u32..).map(leaf).collect();
        let mut nodes = vec![leaves[0]; inner];
        nodes.extend(leaves);
        // Children and parents.
        let mut children = Vec::with_capacity(inner + order.len());
        let mut parent: Vec<u32> = (0..nodes.len() as u32).collect();
        let mut ranges = Vec::with_capacity(inner);
        for (n, &d) in queue.iter().enumerate() {
            let first = children.len() as u32;
            for &k in &drafts[d as usize] {
                let id = id_of(k);
                parent[id as usize] = n as u32;
                children.push(id);
            }
            ranges.push((first, (children.len() as u32 - first) as u8));
        }
        for n in (0..inner).rev() {
            let (first, count) = ranges[n];
            let own = &children[first as usize..first as usize + count as usize];
            nodes[n] = merge_children(own.iter().map(|&k| nodes[k as usize]), first, count);
        }
        ClusterTree { nodes, inner_nodes: inner, children, leaf_zones: order, parent }
    }
}

/// Sorts the items by the coordinate of largest variance and returns the position of its mean, or the middle where one side would be small.
fn split_position(items: &mut [SplitItem]) -> usize {
    let n = items.len() as f64;
    let mut sums = [[0.0; 2]; 7];
    let (mut lo, mut hi) = (items[0].centre, items[0].centre);
    for x in items.iter() {
        (lo, hi) = (lo.min(x.centre), hi.max(x.centre));
    }
    let radius = 0.5 * (hi - lo).length();
    let coordinate = |x: &SplitItem, k: usize| match k {
        0..3 => x.centre[k],
        3..6 => radius * x.normal[k - 3],
        _ => SPLIT_PARAMS.brightness_weight * radius * x.brightness,
    };
    let origin = items[0];
    for x in items.iter() {
        for (k, s) in sums.iter_mut().enumerate() {
            let v = coordinate(x, k) - coordinate(&origin, k);
            *s = [s[0] + v, s[1] + v * v];
        }
    }
    let variance = sums.map(|s| s[1] / n - (s[0] / n) * (s[0] / n));
    let axis = (0..7).fold(0, |best, k| if variance[k] > variance[best] * 1.0001 { k } else { best });
    let mean = sums[axis][0] / n + coordinate(&origin, axis);
    items.sort_unstable_by(|a, b| {
        coordinate(a, axis).total_cmp(&coordinate(b, axis)).then(a.zone.cmp(&b.zone))
    });
    let at = items.partition_point(|x| coordinate(x, axis) < mean);
    let least = (items.len() / SPLIT_PARAMS.min_share_of_split).max(1);
    if at < least || at > items.len() - least { items.len() / 2 } else { at }
}

/// Every third bit of the result is one of the lowest 21 bits of `x`.
fn spread_bits(x: u64) -> u64 {
    let mut x = x & 0x1f_ffff;
    x = (x | x << 32) & 0x1f_0000_0000_ffff;
    x = (x | x << 16) & 0x1f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

/// Interleaved bits of the coordinates of a cell.
fn morton_code(c: [usize; 3]) -> u64 {
    spread_bits(c[0] as u64) << 2 | spread_bits(c[1] as u64) << 1 | spread_bits(c[2] as u64)
}

impl ClusterTree {
    /// Builds the tree of the zones of a scene; `bright` is the brightness of every zone over the mean. `None` without zones.
    pub(crate) fn new(scene: &Scene, zones: &Zones, bright: &[f32]) -> Option<ClusterTree> {
        if zones.is_empty() {
            return None;
        }
        let brightness = bright.iter().map(|b| log_brightness(*b)).collect();
        let order = Vec::with_capacity(zones.len());
        let mut builder = TreeBuilder { scene, zones, brightness, order, inner: Vec::new() };
        let mut subtrees = Vec::new();
        let patches = (0..).zip(&zones.patches);
        let items = patches.map(|(k, p)| builder.plate_item(k, &p.plate, p.normal)).collect();
        builder.add_items(items, &mut subtrees);
        if let Some(grid) = scene.voxel_grid() {
            for dark in [false, true] {
                builder.add_whole_cells(grid, dark, &mut subtrees);
            }
            let cut = (zones.voxel_offset()..).zip(&zones.voxels).filter(|(_, z)| !z.samples.is_empty());
            let items = cut.map(|(k, z)| builder.cut_cell_item(k, z, grid)).collect();
            builder.add_items(items, &mut subtrees);
        }
        let panes = (zones.pane_offset()..).zip(&zones.panes);
        let items = panes.map(|(k, p)| builder.plate_item(k, &p.plate, p.normal)).collect();
        builder.add_items(items, &mut subtrees);
        let root = builder.join(subtrees);
        Some(builder.finish(root))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn morton_codes_interleave_coordinates() {
        assert_eq!(morton_code([1, 0, 0]), 4);
        assert_eq!(morton_code([0, 1, 0]), 2);
        assert_eq!(morton_code([0, 0, 1]), 1);
        assert_eq!(morton_code([3, 1, 2]), 0b101_110);
        assert_eq!(morton_code([2, 2, 2]), 0b111_000);
    }
}
