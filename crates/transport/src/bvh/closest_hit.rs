//! The first plate on a ray.

use super::node::{NODE_WIDTH, leaf_index};
use super::{Bvh, LargeStack, MAX_TREE_DEPTH, SMALL_STACK_DEPTH};
use crate::intersect::{PreparedLine, Tolerance};
use zonal_math::Vec3;
use zonal_math::simd::f32x8::{F32x8Kernel, F32x8Ops};

/// Search for the first plate on a ray.
pub(super) struct ClosestHitSearch<'a> {
    pub bvh: &'a Bvh,
    pub a: Vec3,
    pub d: Vec3,
    /// The part of the ray within the scene's bounds.
    pub clipped: (f64, f64),
    pub range: (f64, f64),
    pub tolerance: &'a Tolerance,
}

/// Id, (t, u, v), and whether the front is met.
pub(super) type ClosestPlate = Option<(u32, [f64; 3], bool)>;

impl F32x8Kernel for ClosestHitSearch<'_> {
    type Output = ClosestPlate;
    #[inline(always)]
    fn evaluate<W: F32x8Ops>(self, w: W) -> ClosestPlate {
        self.search::<W, { SMALL_STACK_DEPTH * NODE_WIDTH }>(w)
    }
}

impl F32x8Kernel for LargeStack<ClosestHitSearch<'_>> {
    type Output = ClosestPlate;
    #[inline(always)]
    fn evaluate<W: F32x8Ops>(self, w: W) -> ClosestPlate {
        self.0.search::<W, { MAX_TREE_DEPTH * NODE_WIDTH }>(w)
    }
}

impl ClosestHitSearch<'_> {
    #[inline(always)]
    fn search<W: F32x8Ops, const STACK: usize>(self, w: W) -> ClosestPlate {
        let ClosestHitSearch { bvh, a, d, clipped: (t0, t1), range: (t_min, mut t_max), tolerance } = self;
        let (ray, segment) = bvh.single_precision(a, d, t0, t1);
        let line = PreparedLine::new(a, d, tolerance);
        let mut stack = [(0.0f32, 0u32); STACK];
        let (mut top, mut limit) = (1, 1.0f32);
        let mut found = None;
        while top > 0 {
            top -= 1;
            let (entry, child) = stack[top];
            if entry > limit {
                continue;
            }
            // Push the children of an inner node, the nearest last.
            let Some(block) = leaf_index(child) else {
                let node = &bvh.nodes[child as usize];
                let (mut mask, entries) = ray.enter(w, node, limit);
                let entries = w.store(entries);
                let bottom = top;
                while mask != 0 {
                    let lane = mask.trailing_zeros() as usize & (NODE_WIDTH - 1);
                    mask &= mask - 1;
                    let mut k = top;
                    while k > bottom && stack[k - 1].0 < entries[lane] {
                        stack[k] = stack[k - 1];
                        k -= 1;
                    }
                    stack[k] = (entries[lane], node.child[lane]);
                    top += 1;
                }
                continue;
            };
            // Test the plates of a leaf and shorten the ray at each hit.
            let block = &bvh.blocks[block];
            let (mut possible, _) = block.classify(w, &segment);
            while possible != 0 {
                let slot = block.slots().start + possible.trailing_zeros() as usize;
                possible &= possible - 1;
                if let Some(at) = bvh.plates[slot].hit(&line, tolerance.rounding, t_min, t_max) {
                    t_max = at[0];
                    limit = (((t_max - t0) / (t1 - t0)) as f32 * 1.000_001 + 1e-6).min(1.0);
                    found = Some((bvh.ids[slot], at, d.dot(bvh.plates[slot].normal()) < 0.0));
                }
            }
        }
        found
    }
}
