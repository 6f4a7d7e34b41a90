//! One tree over all zones: patches by orientation and place, voxel zones by an octree of the voxmap, panes by place.
//!
//! Every zone is a **leaf**. A node stands for its leaves by moments of their measure W (area of a patch, volume of a volume zone):
//!
//! ```text
//! W = Σ W_k      c = Σ W_k x_k / W      C = Σ W_k ((x_k − c)(x_k − c)ᵀ + C_k) / W      n̄ = Σ W_k n_k / W
//! ```
//!
//! with C_k the covariance of a uniform spread over leaf k; n̄ is the vector area over the area, shorter than one where normals
//! differ. Beside these a node keeps a box, a cone that holds its normals and the range of its leaves.
//!
//! **Layout.** Inner nodes come first, breadth first, so a parent's id is below those of its kids; the leaves follow in the order of
//! the tree, so the leaves of a node are one range. Everything lies in flat arrays.
//!
//! **Voxels**: the octree of Morton codes of the whole cells; levels with a single kid are left out. **Parts** of cells that surfaces cut
//! are kept apart: what they receive is unlike what the cells about them do. They are sorted as patches are, each turned the way its
//! centroid is off its cell's centre, so that both sides of a wall part early. **Patches**: a binary tree; a cluster is
//! split at the mean of that coordinate, among place and normal times the cluster's extent, whose variance is largest. So opposite sides
//! part at the top, and flat clusters are cut by place alone.

use zonal_math::{Vec3, vec3};
use zonal_scene::{Bands, Plate, PlateKind, Scene, VoxelZone, Voxmap, Zones};

/// What a node's leaves are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Surface zones.
    Patch,
    /// Voxel zones.
    Voxel,
    /// Pane zones.
    Pane,
    /// More than one kind: the root alone.
    Mixed,
}

/// A cluster of zones, or one zone.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// W-weighted centroid, m.
    pub centre: [f32; 3],
    /// Lower corner of the box that holds the zones, m.
    pub lo: Vec3,
    /// Upper corner.
    pub hi: Vec3,
    /// Covariance xx, yy, zz, xy, xz, yz, m².
    pub spread: [f32; 6],
    /// n̄; the unit normal of a pane; zero for voxels.
    pub normal: [f32; 3],
    /// Sine of the half angle of the cone about n̄ that holds all normals; above 1 where it is wider than a half space.
    pub cone: f32,
    /// W, m² or m³.
    pub weight: f32,
    /// Extinction of the medium about its zones, mean over zones and bands, 1/m.
    pub kappa: f32,
    /// First leaf.
    pub first: u32,
    /// One past the last leaf.
    pub last: u32,
    /// First kid in the tree's list.
    pub kids: u32,
    /// Number of kids; none for a leaf.
    pub count: u8,
    /// Kind of the leaves.
    pub kind: Kind,
    /// The zones fill the box, which so stands for them: whole voxels, or rectangles along the axes in one plane.
    pub full: bool,
}

impl Node {
    /// Centroid.
    pub fn centre(&self) -> Vec3 {
        wide(self.centre)
    }
    /// Mean normal.
    pub fn normal(&self) -> Vec3 {
        wide(self.normal)
    }
    /// Half the diagonal of the box, m.
    pub fn radius(&self) -> f64 {
        0.5 * (self.hi - self.lo).length()
    }
    /// Number of leaves.
    pub fn leaves(&self) -> usize {
        (self.last - self.first) as usize
    }
    /// True for a single zone.
    pub fn is_leaf(&self) -> bool {
        self.count == 0
    }
}

fn wide(v: [f32; 3]) -> Vec3 {
    vec3(v[0] as f64, v[1] as f64, v[2] as f64)
}
fn narrow(v: Vec3) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

/// The tree.
pub struct Tree {
    /// Inner nodes, then leaves.
    pub nodes: Vec<Node>,
    /// Number of inner nodes.
    pub inner: usize,
    /// Kids of all inner nodes.
    pub kids: Vec<u32>,
    /// The zone of each leaf.
    pub zone: Vec<u32>,
    /// Parent of each node; itself for the root.
    pub parent: Vec<u32>,
}

/// A cluster in the making.
struct Draft {
    kids: Vec<u32>,
}

/// A part of a cell whose centroid is off the cell's centre by less of an edge has no side.
const SIDED: f64 = 0.02;

/// An id in the making: leaves are their place in the order, drafts come with this bit.
const DRAFT: u32 = 1 << 31;

struct Maker<'a> {
    zones: &'a Zones,
    order: Vec<u32>,
    drafts: Vec<Draft>,
}

impl Maker<'_> {
    fn join(&mut self, kids: Vec<u32>) -> u32 {
        if kids.len() == 1 {
            return kids[0];
        }
        self.drafts.push(Draft { kids });
        DRAFT | (self.drafts.len() - 1) as u32
    }
    fn leaf(&mut self, zone: usize) -> u32 {
        self.order.push(zone as u32);
        (self.order.len() - 1) as u32
    }

    /// Plates `list` (zones) by place and normal.
    fn plates(&mut self, list: &mut [Item]) -> u32 {
        if list.len() == 1 {
            return self.leaf(list[0].zone as usize);
        }
        let middle = divide(list);
        let (a, b) = list.split_at_mut(middle);
        let kids = vec![self.plates(a), self.plates(b)];
        self.join(kids)
    }

    /// Voxel zones `list` (Morton code, index), cut by the bits of `level`.
    fn cells(&mut self, list: &[(u64, u32)], level: u32) -> u32 {
        if list.len() == 1 {
            return self.leaf(self.zones.voxel_offset() + list[0].1 as usize);
        }
        let kids = list
            .chunk_by(|a, b| a.0 >> (3 * level) == b.0 >> (3 * level))
            .map(|octant| self.cells(octant, level.saturating_sub(1)))
            .collect();
        self.join(kids)
    }
}

/// A plate to be sorted.
#[derive(Clone, Copy)]
struct Item {
    zone: u32,
    centre: Vec3,
    normal: Vec3,
    /// Of its brightness, 0 … 1.
    shade: f64,
}

/// How much brightness counts beside place and normal where a cluster is split.
const SHADE: f64 = 1.5;
/// Brightness over the mean of what is dark, and of what is lit, in full.
const SHADES: [f64; 2] = [0.003, 0.3];

/// Whole cells below this shade have an octree of their own.
const DARK: f64 = 0.25;

/// Brightness on a scale from dark to lit.
fn shade(bright: f32) -> f64 {
    let [dark, lit] = SHADES.map(f64::ln);
    (((bright as f64).max(1e-30).ln() - dark) / (lit - dark)).clamp(0.0, 1.0)
}

/// A part of a cut cell, turned away from what cuts it.
fn part(zone: usize, z: &VoxelZone, map: &Voxmap, bright: f32) -> Item {
    let middle = map.corner(map.coordinates(z.cell)) + map.cell() * 0.5;
    let away = z.centre - middle;
    let normal = if away.length() > SIDED * map.cell().max_abs() { away.normalized() } else { Vec3::ZERO };
    Item { zone: zone as u32, centre: z.centre, normal, shade: shade(bright) }
}

/// Sorts the list about the mean of its widest coordinate and says where; both sides keep a share.
fn divide(list: &mut [Item]) -> usize {
    let n = list.len() as f64;
    let mut sums = [[0.0; 2]; 7];
    let (mut lo, mut hi) = (list[0].centre, list[0].centre);
    for x in list.iter() {
        (lo, hi) = (lo.min(x.centre), hi.max(x.centre));
    }
    let reach = 0.5 * (hi - lo).length();
    let coordinate = |x: &Item, k: usize| match k {
        0..3 => x.centre[k],
        3..6 => reach * x.normal[k - 3],
        _ => SHADE * reach * x.shade,
    };
    let origin = list[0];
    for x in list.iter() {
        for (k, s) in sums.iter_mut().enumerate() {
            let v = coordinate(x, k) - coordinate(&origin, k);
            *s = [s[0] + v, s[1] + v * v];
        }
    }
    let variance = sums.map(|s| s[1] / n - (s[0] / n) * (s[0] / n));
    let axis = (0..7).fold(0, |best, k| if variance[k] > variance[best] * 1.0001 { k } else { best });
    let mean = sums[axis][0] / n + coordinate(&origin, axis);
    list.sort_unstable_by(|a, b| {
        coordinate(a, axis).total_cmp(&coordinate(b, axis)).then(a.zone.cmp(&b.zone))
    });
    let at = list.partition_point(|x| coordinate(x, axis) < mean);
    let least = (list.len() / 8).max(1);
    if at < least || at > list.len() - least { list.len() / 2 } else { at }
}

fn spread_bits(x: u64) -> u64 {
    let mut x = x & 0x1f_ffff;
    x = (x | x << 32) & 0x1f_0000_0000_ffff;
    x = (x | x << 16) & 0x1f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

/// Interleaved bits of a cell's coordinates.
fn morton(c: [usize; 3]) -> u64 {
    spread_bits(c[0] as u64) << 2 | spread_bits(c[1] as u64) << 1 | spread_bits(c[2] as u64)
}

impl Tree {
    /// Builds the tree of the zones of a scene, which are so bright over their mean; `None` without zones.
    pub fn new(scene: &Scene, zones: &Zones, bright: &[f32]) -> Option<Tree> {
        if zones.is_empty() {
            return None;
        }
        let mut maker = Maker { zones, order: Vec::with_capacity(zones.len()), drafts: Vec::new() };
        let mut tops = Vec::new();
        let item = |zone: usize, plate: &Plate, normal: Vec3| Item {
            zone: zone as u32,
            centre: plate.centre(),
            normal,
            shade: shade(bright[zone]),
        };
        let mut list: Vec<Item> =
            (0..).zip(&zones.patches).map(|(k, p)| item(k, &p.plate, p.normal)).collect();
        if !list.is_empty() {
            tops.push(maker.plates(&mut list));
        }
        if let Some(map) = scene.voxmap() {
            for dark in [false, true] {
                let is_dark = |k: u32| shade(bright[zones.voxel_offset() + k as usize]) < DARK;
                let whole =
                    (0..).zip(&zones.voxels).filter(|(k, z)| z.part.is_empty() && is_dark(*k) == dark);
                let mut codes: Vec<(u64, u32)> =
                    whole.map(|(k, z)| (morton(map.coordinates(z.cell)), k)).collect();
                codes.sort_unstable();
                if !codes.is_empty() {
                    tops.push(maker.cells(&codes, 20));
                }
            }
            let cut = (zones.voxel_offset()..).zip(&zones.voxels).filter(|(_, z)| !z.part.is_empty());
            let mut list: Vec<Item> = cut.map(|(k, z)| part(k, z, map, bright[k])).collect();
            if !list.is_empty() {
                tops.push(maker.plates(&mut list));
            }
        }
        let mut list: Vec<Item> =
            (zones.pane_offset()..).zip(&zones.panes).map(|(k, p)| item(k, &p.plate, p.normal)).collect();
        if !list.is_empty() {
            tops.push(maker.plates(&mut list));
        }
        let root = maker.join(tops);
        Some(finish(scene, zones, maker, root))
    }

    /// The kids of a node.
    pub fn kids(&self, node: u32) -> &[u32] {
        self.kids_of(&self.nodes[node as usize])
    }
    /// Kids of a node that is at hand.
    pub fn kids_of(&self, n: &Node) -> &[u32] {
        &self.kids[n.kids as usize..n.kids as usize + n.count as usize]
    }
    /// The cluster of every zone, and their number: the largest nodes with no more leaves than `most`.
    pub fn clusters(&self, most: usize) -> (Vec<u32>, usize) {
        let mut of = vec![0; self.leaves()];
        let (mut count, mut stack) = (0, vec![self.root()]);
        while let Some(n) = stack.pop() {
            let node = &self.nodes[n as usize];
            if node.is_leaf() || node.leaves() <= most {
                (node.first..node.last).for_each(|slot| of[self.zone[slot as usize] as usize] = count);
                count += 1;
            } else {
                stack.extend(self.kids(n).iter().rev());
            }
        }
        (of, count as usize)
    }
    /// The root.
    pub fn root(&self) -> u32 {
        0
    }
    /// Id of a leaf as a node.
    pub fn leaf(&self, slot: usize) -> usize {
        self.inner + slot
    }
    /// Number of leaves.
    pub fn leaves(&self) -> usize {
        self.zone.len()
    }
}

/// Numbers the drafts breadth first and computes the moments from the leaves up.
fn finish(scene: &Scene, zones: &Zones, maker: Maker, root: u32) -> Tree {
    let (order, drafts) = (maker.order, maker.drafts);
    let inner = drafts.len();
    let id_of =
        |x: u32, ids: &[u32]| if x & DRAFT != 0 { ids[(x & !DRAFT) as usize] } else { inner as u32 + x };
    let mut ids = vec![0u32; inner];
    let mut queue: Vec<u32> = Vec::with_capacity(inner);
    if root & DRAFT != 0 {
        queue.push(root & !DRAFT);
    }
    let mut at = 0;
    while at < queue.len() {
        let d = queue[at] as usize;
        ids[d] = at as u32;
        queue.extend(drafts[d].kids.iter().filter(|k| *k & DRAFT != 0).map(|k| k & !DRAFT));
        at += 1;
    }
    let leaves: Vec<Node> =
        order.iter().zip(0u32..).map(|(&z, slot)| leaf(scene, zones, z as usize, slot)).collect();
    let blank = leaves[0];
    let mut nodes = vec![blank; inner];
    nodes.extend(leaves);
    let mut kids = Vec::with_capacity(inner + order.len());
    let mut parent: Vec<u32> = (0..nodes.len() as u32).collect();
    let mut ranges = Vec::with_capacity(inner);
    for (n, &d) in queue.iter().enumerate() {
        let first = kids.len() as u32;
        for &k in &drafts[d as usize].kids {
            let id = id_of(k, &ids);
            parent[id as usize] = n as u32;
            kids.push(id);
        }
        ranges.push((first, (kids.len() as u32 - first) as u8));
    }
    for n in (0..inner).rev() {
        let (first, count) = ranges[n];
        let own = &kids[first as usize..first as usize + count as usize];
        let node = merged(own.iter().map(|&k| nodes[k as usize]), first, count);
        nodes[n] = node;
    }
    Tree { nodes, inner, kids, zone: order, parent }
}

fn merged(kids: impl Iterator<Item = Node> + Clone, first: u32, count: u8) -> Node {
    let total: f64 = kids.clone().map(|k| k.weight as f64).sum();
    let share = |k: &Node| k.weight as f64 / total;
    let centre = kids.clone().fold(Vec3::ZERO, |s, k| s + k.centre() * share(&k));
    let normal = kids.clone().fold(Vec3::ZERO, |s, k| s + k.normal() * share(&k));
    let lo = kids.clone().fold(Vec3::splat(f64::INFINITY), |s, k| s.min(k.lo));
    let hi = kids.clone().fold(Vec3::splat(f64::NEG_INFINITY), |s, k| s.max(k.hi));
    let mut spread = [0.0; 6];
    for k in kids.clone() {
        let d = k.centre() - centre;
        let outer = [d.x * d.x, d.y * d.y, d.z * d.z, d.x * d.y, d.x * d.z, d.y * d.z];
        (0..6).for_each(|m| spread[m] += share(&k) * (outer[m] + k.spread[m] as f64));
    }
    let axis = normal.normalized();
    let cone = kids.clone().fold(0.0f64, |m, k| {
        if k.kind == Kind::Voxel {
            return 0.0;
        }
        let n = k.normal().normalized();
        let between = axis.cross(n).length().atan2(axis.dot(n));
        let own = if k.cone > 1.0 { 4.0 } else { (k.cone as f64).asin() };
        m.max(between + own)
    });
    let mut all = kids.clone();
    let kind = kids.clone().next().map_or(Kind::Mixed, |k| k.kind);
    let same = all.all(|k| k.kind == kind);
    let half = std::f64::consts::FRAC_PI_2;
    Node {
        centre: narrow(centre),
        lo,
        hi,
        spread: spread.map(|x| x as f32),
        normal: narrow(normal),
        cone: if cone < half { cone.sin() as f32 } else { 2.0 },
        weight: total as f32,
        kappa: kids.clone().map(|k| k.kappa as f64 * share(&k)).sum::<f64>() as f32,
        first: kids.clone().map(|k| k.first).min().unwrap_or(0),
        last: kids.clone().map(|k| k.last).max().unwrap_or(0),
        kids: first,
        count,
        kind: if same { kind } else { Kind::Mixed },
        full: same && kids.clone().all(|k| k.full) && fills(kind, lo, hi, axis, cone, total),
    }
}

/// True where zones of total measure `total` that do not overlap fill the box: a cluster of patches only in one plane along the axes.
fn fills(kind: Kind, lo: Vec3, hi: Vec3, normal: Vec3, cone: f64, total: f64) -> bool {
    let e = hi - lo;
    let room = match kind {
        Kind::Voxel => e.product(),
        Kind::Patch => {
            let Some(x) = (0..3).find(|&x| normal[x].abs() > 1.0 - 1e-9) else {
                return false;
            };
            if cone > 1e-5 || e[x] > 1e-9 * e.max_abs() {
                return false;
            }
            e[(x + 1) % 3] * e[(x + 2) % 3]
        }
        _ => return false,
    };
    (total / room - 1.0).abs() < 1e-4
}

fn leaf(scene: &Scene, zones: &Zones, zone: usize, slot: u32) -> Node {
    let base = Node {
        centre: [0.0; 3],
        lo: Vec3::ZERO,
        hi: Vec3::ZERO,
        spread: [0.0; 6],
        normal: [0.0; 3],
        cone: 0.0,
        weight: 0.0,
        kappa: 0.0,
        first: slot,
        last: slot + 1,
        kids: 0,
        count: 0,
        kind: Kind::Patch,
        full: false,
    };
    let flat = |plate: &Plate, normal: Vec3, weight: f64, kind: Kind| {
        let (lo, hi) = plate.bounds();
        Node {
            centre: narrow(plate.centre()),
            lo,
            hi,
            spread: plate_spread(plate).map(|x| x as f32),
            normal: narrow(normal),
            weight: weight as f32,
            kappa: around(scene, plate.centre()) as f32,
            full: fills(kind, lo, hi, normal, 0.0, weight),
            kind,
            ..base
        }
    };
    if zone < zones.voxel_offset() {
        let p = &zones.patches[zone];
        flat(&p.plate, p.normal, p.area, Kind::Patch)
    } else if zone < zones.pane_offset() {
        let z = &zones.voxels[zone - zones.voxel_offset()];
        let map = scene.voxmap().expect("voxel zones come from a voxmap");
        let lo = map.corner(map.coordinates(z.cell));
        Node {
            centre: narrow(z.centre),
            lo,
            hi: lo + map.cell(),
            spread: voxel_spread(z, map.cell()).map(|x| x as f32),
            weight: z.volume as f32,
            kappa: mean(z.extinction) as f32,
            kind: Kind::Voxel,
            full: z.part.is_empty(),
            ..base
        }
    } else {
        let p = &zones.panes[zone - zones.pane_offset()];
        flat(&p.plate, p.normal, p.area * p.thickness, Kind::Pane)
    }
}

fn mean(v: Bands) -> f64 {
    (v[0] + v[1] + v[2]) / 3.0
}

/// Extinction of the medium at a point, mean over the bands.
fn around(scene: &Scene, p: Vec3) -> f64 {
    let Some(map) = scene.voxmap() else {
        return 0.0;
    };
    map.cell_at(p).map_or(0.0, |c| mean(map.extinction(map.index(c))))
}

/// Covariance of a uniform spread over a plate: e₁e₁ᵀ/12 + e₂e₂ᵀ/12 of a parallelogram, (e₁e₁ᵀ + e₂e₂ᵀ − (e₁e₂ᵀ + e₂e₁ᵀ)/2)/18 of a triangle.
fn plate_spread(p: &Plate) -> [f64; 6] {
    let (a, b) = (p.e1, p.e2);
    let entry = |i: usize, j: usize| match p.kind {
        PlateKind::Parallelogram => (a[i] * a[j] + b[i] * b[j]) / 12.0,
        PlateKind::Triangle => (a[i] * a[j] + b[i] * b[j] - 0.5 * (a[i] * b[j] + b[i] * a[j])) / 18.0,
    };
    [entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)]
}

fn voxel_spread(z: &VoxelZone, cell: Vec3) -> [f64; 6] {
    let box_spread = [cell.x * cell.x / 12.0, cell.y * cell.y / 12.0, cell.z * cell.z / 12.0, 0.0, 0.0, 0.0];
    if z.part.is_empty() {
        return box_spread;
    }
    // A part fills a share of the cell: its own sub-cells are not resolved here.
    let share = (z.volume / cell.product()).min(1.0).powf(2.0 / 3.0);
    box_spread.map(|x| x * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn morton_codes_interleave() {
        assert_eq!(morton([1, 0, 0]), 4);
        assert_eq!(morton([0, 1, 0]), 2);
        assert_eq!(morton([0, 0, 1]), 1);
        assert_eq!(morton([3, 1, 2]), 0b101_110);
        assert_eq!(morton([2, 2, 2]), 0b111_000);
    }

    #[test]
    fn the_spread_of_a_plate_is_that_of_its_quarters() {
        for kind in [PlateKind::Triangle, PlateKind::Parallelogram] {
            let p = Plate { origin: Vec3::ONE, e1: vec3(2.0, 0.1, 0.0), e2: vec3(0.3, 1.0, 0.7), kind };
            let whole = plate_spread(&p);
            let c = p.centre();
            let mut sum = [0.0; 6];
            for q in p.quarters() {
                let (d, own) = (q.centre() - c, plate_spread(&q));
                let outer = [d.x * d.x, d.y * d.y, d.z * d.z, d.x * d.y, d.x * d.z, d.y * d.z];
                (0..6).for_each(|m| sum[m] += 0.25 * (outer[m] + own[m]));
            }
            (0..6).for_each(|m| assert!((sum[m] - whole[m]).abs() < 1e-13, "{kind:?} {m}"));
        }
    }
}
