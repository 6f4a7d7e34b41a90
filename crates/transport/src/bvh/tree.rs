//! The hierarchy's data: nodes, leaf blocks and plates, in the coordinates of the tree.

use super::build::BuildItem;
use super::collapse;
use super::common_plane::CommonPlane;
use super::leaf_block::{BlockSegment, LeafBlock};
use super::node::{BoxRay, Child, FLAT_FLAG, WideNode};
use crate::grid_traversal;
use crate::intersect::PreparedPlate;
use std::ops::Range;
use zonal_math::Vec3;
use zonal_math::simd::f32x8::{F32x8Dispatch, F32x8Ops};
use zonal_scene::Plate;

/// Padding of boxes, in units of R.
const BOX_PADDING: f64 = 1e-6;
/// Trees up to this depth are traversed with a small stack.
pub(super) const SMALL_STACK_DEPTH: usize = 12;
/// Depth limit of all trees, which sizes the large stack.
pub(super) const MAX_TREE_DEPTH: usize = 96;
/// Plates in leaf order and the tree over them.
#[derive(Clone, Debug)]
pub(crate) struct Bvh {
    pub(super) nodes: Vec<WideNode>,
    pub(super) planes: Vec<CommonPlane>,
    pub(super) blocks: Vec<LeafBlock>,
    pub(super) plates: Vec<PreparedPlate>,
    pub(super) ids: Vec<u32>,
    pub(super) depth: usize,
    pub(super) dispatch: F32x8Dispatch,
    pub(super) centre: Vec3,
    pub(super) scale: f64,
    pub(super) lo: Vec3,
    pub(super) hi: Vec3,
}

impl Bvh {
    /// Builds the tree over (id, plate) pairs; `lo` and `hi` are the bounds of the scene.
    pub(crate) fn new(plates: &[(u32, Plate)], lo: Vec3, hi: Vec3) -> Bvh {
        let centre = (lo + hi) * 0.5;
        let half = (hi - lo).max_abs() * 0.5;
        // Far from the origin the rounding of the plates' coordinates exceeds the padding.
        let half = half.max(1e-7 * lo.max_abs().max(hi.max_abs()));
        let scale = if half > 0.0 { 1.0 / half } else { 1.0 };
        let mut items: Vec<BuildItem> = plates
            .iter()
            .enumerate()
            .map(|(k, (_, p))| {
                let (lo, hi) = p.bounds();
                let (lo, hi) = ((lo - centre) * scale, (hi - centre) * scale);
                BuildItem {
                    lo: lo.array().map(|x| ((x - BOX_PADDING) as f32).next_down()),
                    hi: hi.array().map(|x| ((x + BOX_PADDING) as f32).next_up()),
                    area: (p.area() * scale * scale) as f32,
                    id: k as u32,
                }
            })
            .collect();
        let built = collapse::build(&mut items);
        let ordered: Vec<Plate> = items.iter().map(|i| plates[i.id as usize].1).collect();
        let block = |of: &Range<u32>| {
            let plates = &ordered[of.start as usize..of.end as usize];
            LeafBlock::new(plates, of.start, |x| (x - centre) * scale, scale)
        };
        let blocks: Vec<LeafBlock> = built.leaves.iter().map(block).collect();
        let mut nodes = built.nodes;
        let mut planes = Vec::new();
        if !nodes.is_empty() {
            let plates = |of: Range<u32>| &ordered[of.start as usize..of.end as usize];
            let plane = |of: Range<u32>| CommonPlane::of(plates(of), scale);
            mark_flat_lanes(&mut nodes, &built.leaves, 0, &plane, &mut planes);
        }
        let pad = Vec3::splat(2.0 * BOX_PADDING / scale);
        Bvh {
            nodes,
            planes,
            blocks,
            plates: ordered.iter().map(PreparedPlate::new).collect(),
            ids: items.iter().map(|i| plates[i.id as usize].0).collect(),
            depth: built.depth,
            dispatch: F32x8Dispatch::detect(),
            centre,
            scale,
            lo: lo - pad,
            hi: hi + pad,
        }
    }

    /// Starts to load a child.
    #[inline(always)]
    pub(super) fn prefetch<W: F32x8Ops>(&self, w: W, child: u32) {
        match Child::of(child) {
            Child::Leaf(leaf) => self.blocks[leaf].prefetch(w),
            Child::Node(node) => self.nodes[node].prefetch(w),
        }
    }

    /// The part [t0, t1] of the segment a + t d, 0 ≤ t ≤ 1, within the scene's bounds.
    #[inline(always)]
    pub(super) fn clip(&self, a: Vec3, d: Vec3) -> Option<(f64, f64)> {
        let b = a + d;
        let (lo, hi) = (&self.lo, &self.hi);
        let within = |p: Vec3| {
            let x = (p.x >= lo.x) & (p.x <= hi.x);
            let y = (p.y >= lo.y) & (p.y <= hi.y);
            let z = (p.z >= lo.z) & (p.z <= hi.z);
            x & y & z
        };
        if within(a) & within(b) {
            return Some((0.0, 1.0));
        }
        grid_traversal::clip(a, d, self.lo, self.hi, 0.0, 1.0)
    }

    /// The part t0 ≤ t ≤ t1 of a + t d in the tree's coordinates and in single precision.
    #[inline(always)]
    pub(super) fn single_precision(&self, a: Vec3, d: Vec3, t0: f64, t1: f64) -> (BoxRay, BlockSegment) {
        let (a, d) = ((a + d * t0 - self.centre) * self.scale, d * ((t1 - t0) * self.scale));
        (BoxRay::new(a, d), BlockSegment::new(a, d))
    }
}

/// A query with a stack for trees of any depth.
pub(super) struct LargeStack<T>(pub(super) T);

/// Gives the lanes below node `here` whose plates have a common plane that plane, the topmost alone: the plates of a lane below a
/// flat one are not tested against the same plane again.
fn mark_flat_lanes(
    nodes: &mut [WideNode],
    leaves: &[Range<u32>],
    here: usize,
    plane: &impl Fn(Range<u32>) -> Option<CommonPlane>,
    planes: &mut Vec<CommonPlane>,
) {
    for lane in 0..nodes[here].lane_count() {
        let child = nodes[here].child[lane];
        if let Some(plane) = plane(plates_below(nodes, leaves, child)) {
            nodes[here].child[lane] |= FLAT_FLAG;
            nodes[here].plane[lane] = planes.len() as u32;
            planes.push(plane);
        } else if let Child::Node(below) = Child::of(child) {
            mark_flat_lanes(nodes, leaves, below, plane, planes);
        }
    }
}

/// The plates below a child: neighbours in the list.
fn plates_below(nodes: &[WideNode], leaves: &[Range<u32>], child: u32) -> Range<u32> {
    match Child::of(child) {
        Child::Leaf(leaf) => leaves[leaf].clone(),
        Child::Node(node) => {
            let node = &nodes[node];
            let lanes = node.child[..node.lane_count()].iter();
            let ranges = lanes.map(|child| plates_below(nodes, leaves, *child));
            ranges.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end)).unwrap_or(0..0)
        }
    }
}
