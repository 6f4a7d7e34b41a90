//! The first plate on a ray: the one of least (t, id). Of plates that the ray meets at one and the same t, as coincident ones, it is
//! the one of the smallest id, whatever the order of the plates in the tree.

use super::node::{BoxRay, Child, NODE_WIDTH, WideNode};
use super::tree::{Bvh, LargeStack, MAX_TREE_DEPTH, SMALL_STACK_DEPTH};
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
        let mut found: ClosestPlate = None;
        while top > 0 {
            top -= 1;
            let (entry, child) = stack[top];
            if entry > limit {
                continue;
            }
            let block = match Child::of(child) {
                Child::Leaf(block) => &bvh.blocks[block],
                Child::Node(node) => {
                    push_children(w, &ray, &bvh.nodes[node], limit, &mut stack, &mut top);
                    continue;
                }
            };
            // Test the plates of a leaf and shorten the ray at each hit.
            let (mut possible, _) = block.classify(w, &segment);
            while possible != 0 {
                let slot = block.slots().start + possible.trailing_zeros() as usize;
                possible &= possible - 1;
                let Some(at) = bvh.plates[slot].hit(&line, tolerance.rounding, t_min, t_max) else {
                    continue;
                };
                let id = bvh.ids[slot];
                if found.is_some_and(|(best, [t, ..], _)| at[0] == t && id > best) {
                    continue;
                }
                // The next plate may lie as far.
                t_max = at[0].next_up();
                limit = (((t_max - t0) / (t1 - t0)) as f32 * 1.000_001 + 1e-6).min(1.0);
                found = Some((id, at, d.dot(bvh.plates[slot].normal()) < 0.0));
            }
        }
        found
    }
}

/// Pushes the children of a node that the ray meets before `limit` on the stack of `top` entries, the nearest last.
#[inline(always)]
fn push_children<W: F32x8Ops>(
    w: W,
    ray: &BoxRay,
    node: &WideNode,
    limit: f32,
    stack: &mut [(f32, u32)],
    top: &mut usize,
) {
    let (mut mask, entries) = ray.enter(w, node, limit);
    let entries = w.store(entries);
    let bottom = *top;
    while mask != 0 {
        let lane = mask.trailing_zeros() as usize & (NODE_WIDTH - 1);
        mask &= mask - 1;
        let mut k = *top;
        while k > bottom && stack[k - 1].0 < entries[lane] {
            stack[k] = stack[k - 1];
            k -= 1;
        }
        stack[k] = (entries[lane], node.child[lane]);
        *top += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::super::Bvh;
    use crate::intersect::Tolerance;
    use zonal_math::low_discrepancy::hash_to_unit;
    use zonal_math::{Vec3, vec3};
    use zonal_scene::Plate;

    /// Two layers of triangles, each triangle five times and in an order that differs from that of the ids.
    #[test]
    fn smallest_id_of_coincident_plates_is_hit() {
        let tolerance = Tolerance { plane: 1e-9, rounding: 1e-12, edge: 1e-13 };
        let (sites, copies) = (40, 5);
        let triangle = |site: usize, z: f64| {
            let x = site as f64;
            Plate::triangle(vec3(x, 0.0, z), vec3(x + 1.0, 0.0, z), vec3(x, 1.0, z))
        };
        let mut plates: Vec<(u32, Plate)> = Vec::new();
        for copy in 0..copies {
            for site in 0..sites {
                plates.push(((copy * sites + site) as u32, triangle(site, 0.0)));
                plates.push(((10_000 + copy * sites + site) as u32, triangle(site, 1.0)));
            }
        }
        let (lo, hi) = (vec3(0.0, 0.0, -1.0), vec3(sites as f64, 1.0, 2.0));
        for turn in 0..20u64 {
            let key = |id: u32| hash_to_unit(u64::from(id) * 64 + turn);
            plates.sort_by(|a, b| key(a.0).total_cmp(&key(b.0)));
            let bvh = Bvh::new(&plates, lo, hi);
            for site in 0..sites {
                let above = vec3(site as f64 + 0.3, 0.3, 2.0);
                let hit = |a: Vec3, d: Vec3, t_max: f64| bvh.nearest(a, d, 0.0, t_max, &tolerance);
                let down = hit(above, vec3(0.0, 0.0, -1.0), f64::INFINITY).map(|h| h.0);
                assert_eq!(down, Some(10_000 + site as u32));
                let up = hit(above - vec3(0.0, 0.0, 2.5), vec3(0.0, 0.0, 1.0), f64::INFINITY).map(|h| h.0);
                assert_eq!(up, Some(site as u32));
                // A hit at t_max is none.
                assert!(hit(above, vec3(0.0, 0.0, -1.0), 1.0).is_none());
            }
        }
    }
}
