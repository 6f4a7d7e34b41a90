//! Traversal of the leaves on a segment.
//!
//! Segments end on surfaces, and the plates there are not crossed. So a lane is left out where its plates have a common plane and an end
//! lies in it ([`super::common_plane`]), and an any-hit query tests the other leaves that hold an end last: most segments are occluded
//! elsewhere.

use super::leaf_block::BlockSegment;
use super::node::{BoxRay, Child, FLAT_FLAG, NODE_WIDTH};
use super::tree::{Bvh, LargeStack, MAX_TREE_DEPTH, SMALL_STACK_DEPTH};
use crate::intersect::PreparedLine;
use zonal_math::simd::f32x8::{F32x8Kernel, F32x8Ops};

/// Leaves of an any-hit query that wait until the others are tested.
const MAX_DEFERRED_LEAVES: usize = 16;
/// Undecided plates of an any-hit query that wait until all leaves are tested.
const MAX_DEFERRED_PLATES: usize = 16;

/// Traversal of all leaves on a segment; with `ANY_HIT` it ends at a plate that is crossed for certain.
pub(super) struct SegmentTraversal<'a, V, const ANY_HIT: bool> {
    pub bvh: &'a Bvh,
    pub line: &'a PreparedLine,
    /// True when both ends lie within the scene's bounds.
    pub unclipped: bool,
    pub ray: BoxRay,
    pub segment: BlockSegment,
    pub visit: V,
}

/// Numbers that wait, at most N.
struct Deferred<const N: usize> {
    items: [u32; N],
    count: usize,
}

impl<const N: usize> Deferred<N> {
    #[inline(always)]
    fn new() -> Self {
        Deferred { items: [0; N], count: 0 }
    }
    /// Appends an item; false when the list is full.
    #[inline(always)]
    fn push(&mut self, item: u32) -> bool {
        let space = self.count < N;
        if space {
            self.items[self.count] = item;
            self.count += 1;
        }
        space
    }
}

impl<V: FnMut(usize) -> bool, const ANY_HIT: bool> F32x8Kernel for SegmentTraversal<'_, V, ANY_HIT> {
    type Output = bool;
    #[inline(always)]
    fn evaluate<W: F32x8Ops>(self, w: W) -> bool {
        self.traverse::<W, SMALL_STACK_DEPTH>(w)
    }
}

impl<V: FnMut(usize) -> bool, const ANY_HIT: bool> F32x8Kernel
    for LargeStack<SegmentTraversal<'_, V, ANY_HIT>>
{
    type Output = bool;
    #[inline(always)]
    fn evaluate<W: F32x8Ops>(self, w: W) -> bool {
        self.0.traverse::<W, MAX_TREE_DEPTH>(w)
    }
}

impl<V: FnMut(usize) -> bool, const ANY_HIT: bool> SegmentTraversal<'_, V, ANY_HIT> {
    #[inline(always)]
    fn traverse<W: F32x8Ops, const DEPTH: usize>(mut self, w: W) -> bool {
        let bvh = self.bvh;
        let mut stack = [(0u32, 0u32); DEPTH];
        let (mut here, mut top) = (0, 0);
        let mut leaves = Deferred::<MAX_DEFERRED_LEAVES>::new();
        let mut plates = Deferred::<MAX_DEFERRED_PLATES>::new();
        let mut node = &bvh.nodes[0];
        // Copy the children so that they are loaded together with the boxes.
        let mut children = node.child;
        let mut mask = self.ray.enter_segment(w, node);
        loop {
            while mask != 0 {
                let lane = mask.trailing_zeros() as usize & (NODE_WIDTH - 1);
                let holds_end = mask as u8 == 0;
                mask &= mask - 1;
                let child = children[lane];
                // Load what the next lane holds while this one is tested.
                let next = if mask == 0 { lane } else { mask.trailing_zeros() as usize & (NODE_WIDTH - 1) };
                bvh.prefetch(w, children[next]);
                if child & FLAT_FLAG != 0 && self.never_crosses(node.plane[lane]) {
                    continue;
                }
                match Child::of(child) {
                    Child::Leaf(leaf) => {
                        let waits = ANY_HIT && holds_end && leaves.push(leaf as u32);
                        if !waits && self.visit_block(w, leaf, &mut plates) {
                            return true;
                        }
                    }
                    // Descend into an inner node; its siblings wait on the stack.
                    Child::Node(below) => {
                        stack[top] = (here, mask);
                        top += usize::from(mask != 0);
                        here = below as u32;
                        node = &bvh.nodes[below];
                        children = node.child;
                        mask = self.ray.enter_segment(w, node);
                    }
                }
            }
            if top == 0 {
                break;
            }
            top -= 1;
            (here, mask) = stack[top];
            node = &bvh.nodes[here as usize];
            children = node.child;
        }
        self.test_deferred(w, &leaves, &mut plates)
    }

    /// Tests the leaves that wait, and then the plates; returns true when the traversal ends.
    #[inline(always)]
    fn test_deferred<W: F32x8Ops>(
        &mut self,
        w: W,
        leaves: &Deferred<MAX_DEFERRED_LEAVES>,
        plates: &mut Deferred<MAX_DEFERRED_PLATES>,
    ) -> bool {
        for &leaf in &leaves.items[..leaves.count] {
            if self.visit_block(w, leaf as usize, plates) {
                return true;
            }
        }
        plates.items[..plates.count].iter().any(|slot| (self.visit)(*slot as usize))
    }

    /// True when the segment certainly crosses no plate of a flat lane.
    #[inline(always)]
    fn never_crosses(&self, plane: u32) -> bool {
        self.unclipped && self.bvh.planes[plane as usize].never_crossed(self.line)
    }

    /// Tests the plates of a leaf; returns true when the traversal ends.
    #[inline(always)]
    fn visit_block<W: F32x8Ops>(
        &mut self,
        w: W,
        leaf: usize,
        plates: &mut Deferred<MAX_DEFERRED_PLATES>,
    ) -> bool {
        let block = &self.bvh.blocks[leaf];
        let first = block.slots().start;
        let (mut possible, certain) = block.classify(w, &self.segment);
        if ANY_HIT && certain != 0 {
            return true;
        }
        while possible != 0 {
            let slot = first + possible.trailing_zeros() as usize;
            possible &= possible - 1;
            if ANY_HIT && plates.push(slot as u32) {
                continue;
            }
            if (self.visit)(slot) {
                return true;
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intersect::{PreparedPlate, Tolerance};
    use zonal_math::low_discrepancy::hash_to_unit;
    use zonal_math::{Vec3, vec3};
    use zonal_scene::Plate;

    /// A rectangle as 2 n² triangles.
    fn mesh(o: Vec3, u: Vec3, v: Vec3, n: usize, plates: &mut Vec<Plate>) {
        let (u, v) = (u / n as f64, v / n as f64);
        for k in 0..n * n {
            let q = o + u * (k / n) as f64 + v * (k % n) as f64;
            plates.push(Plate::triangle(q, q + u, q + u + v));
            plates.push(Plate::triangle(q, q + u + v, q + v));
        }
    }

    /// Segments from, to, along and closely beside the walls of a room with a sloping roof and a screen.
    #[test]
    fn walls_occlude_as_their_plates_do() {
        let tolerance = Tolerance { plane: 3e-9, rounding: 3e-12, edge: 3e-13 };
        let (x, y, z) = (vec3(2.0, 0.0, 0.0), vec3(0.0, 2.0, 0.0), vec3(0.0, 0.0, 1.0));
        let mut plates = Vec::new();
        mesh(Vec3::ZERO, x, y, 24, &mut plates);
        mesh(Vec3::ZERO, y, z, 16, &mut plates);
        mesh(z, x + z * 0.3, y + z * 0.7, 20, &mut plates);
        mesh(x * 0.5 + y * 0.25, y * 0.5, z * 0.5, 9, &mut plates);
        let numbered: Vec<(u32, Plate)> = (0..).zip(plates.iter().copied()).collect();
        let bvh = Bvh::new(&numbered, Vec3::ZERO, vec3(2.0, 2.0, 2.0));
        assert!(!bvh.planes.is_empty() && 4 * bvh.planes.len() < bvh.blocks.len(), "{}", bvh.planes.len());
        let prepared: Vec<PreparedPlate> = plates.iter().map(PreparedPlate::new).collect();
        let mut number = 0;
        let mut random = || {
            number += 1;
            hash_to_unit(number)
        };
        let mut counts = [0; 2];
        for turn in 0..6000 {
            // An end on a plate, in its plane outside it, or off the plane by up to some ε.
            let mut end = |turn: usize| {
                let p = &plates[(random() * plates.len() as f64) as usize];
                let reach = if turn.is_multiple_of(3) { 10.0 } else { 1.0 };
                let off = if turn.is_multiple_of(2) { 0.0 } else { 4.0 * (random() - 0.5) };
                let at = p.at(reach * random(), random() * 0.5) + p.normal() * (off * tolerance.plane);
                if turn.is_multiple_of(5) { vec3(2.0 * random(), 2.0 * random(), 2.0 * random()) } else { at }
            };
            let (a, b) = (end(turn), end(turn / 2));
            let line = PreparedLine::new(a, b - a, &tolerance);
            let expected = prepared.iter().any(|p| p.crosses(&line));
            assert_eq!(bvh.any(a, b, &tolerance), expected, "{a:?} {b:?}");
            counts[usize::from(expected)] += 1;
        }
        assert!(counts[0] > 1000 && counts[1] > 1000, "{counts:?}");
    }
}
