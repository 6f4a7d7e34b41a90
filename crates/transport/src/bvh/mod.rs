//! Bounding volume hierarchy over plates, eight boxes wide.
//!
//! A segment a + t d meets the box [lo, hi] where max_k min((lo−a)/d, (hi−a)/d)_k ≤ min_k max(…)_k on 0 ≤ t ≤ 1 (slab test), eight
//! boxes at a time in single precision. Coordinates are relative to the scene's centre in units of its half size R, and boxes are
//! padded by 10⁻⁶ R: rounding of a, d, 1/d and of the products moves a box's face by at most 5·10⁻⁷ R, so no box that holds a hit is
//! missed. A zero component of d becomes 10⁻²⁰, which excludes 0·∞. A leaf holds up to eight plates; `leaf_block` rejects in single
//! precision those that the segment cannot cross. `common_plane` leaves out whole walls that a segment ends on or runs along.
//! [`crate::intersect`] alone decides a hit, in double precision.

mod any_hit;
mod build;
mod closest_hit;
mod collapse;
mod common_plane;
mod leaf_block;
mod node;
mod tree;
mod wide_cuts;

use crate::grid_traversal;
use crate::intersect::{PreparedLine, Tolerance};
use crate::shaft_culling::Shaft;
use any_hit::SegmentTraversal;
use closest_hit::ClosestHitSearch;
use node::{Child, NODE_WIDTH};
pub(crate) use tree::Bvh;
use tree::{LargeStack, SMALL_STACK_DEPTH};
use zonal_math::Vec3;

/// Slack of tests of boxes against planes, in units of R: above the rounding of single precision.
const PLANE_TEST_SLACK: f64 = 1e-5;

impl Bvh {
    /// Number of plates.
    pub(crate) fn len(&self) -> usize {
        self.plates.len()
    }

    /// Calls `visit` with every plate that the segment a + t d, 0 ≤ t ≤ 1, may cross, until it returns true. With `ANY_HIT` a plate
    /// that is crossed for certain ends the traversal without a call. Returns whether the traversal was ended.
    #[inline(always)]
    fn visit<const ANY_HIT: bool>(&self, line: &PreparedLine, visit: impl FnMut(usize) -> bool) -> bool {
        if self.nodes.is_empty() {
            return false;
        }
        let Some((t0, t1)) = self.clip(line.a, line.d) else {
            return false;
        };
        let unclipped = t0 == 0.0 && t1 == 1.0;
        let (ray, segment) = self.single_precision(line.a, line.d, t0, t1);
        let traversal: SegmentTraversal<'_, _, ANY_HIT> =
            SegmentTraversal { bvh: self, line, unclipped, ray, segment, visit };
        if self.depth <= SMALL_STACK_DEPTH {
            self.dispatch.run(traversal)
        } else {
            self.dispatch.run(LargeStack(traversal))
        }
    }

    /// True when any plate crosses the segment a → b.
    #[inline]
    pub(crate) fn any(&self, a: Vec3, b: Vec3, tolerance: &Tolerance) -> bool {
        !self.nodes.is_empty() && self.crosses(a, b, tolerance)
    }

    /// [`Bvh::any`] for a tree with plates. The traversal is compiled here, once, and not in every caller.
    #[inline(never)]
    fn crosses(&self, a: Vec3, b: Vec3, tolerance: &Tolerance) -> bool {
        let line = PreparedLine::new(a, b - a, tolerance);
        self.visit::<true>(&line, |slot| self.plates[slot].crosses(&line))
    }

    /// Calls `each` with every plate that crosses the segment a → b, in no order: its id, (t, u, v) with the fraction t of the
    /// segment, and d·n̂.
    pub(crate) fn all(
        &self,
        a: Vec3,
        b: Vec3,
        tolerance: &Tolerance,
        each: &mut dyn FnMut(u32, [f64; 3], f64),
    ) {
        let line = PreparedLine::new(a, b - a, tolerance);
        self.visit::<false>(&line, |slot| {
            if let Some(at) = self.plates[slot].crossing(&line) {
                each(self.ids[slot], at, line.d.dot(self.plates[slot].normal()));
            }
            false
        });
    }

    /// The first plate that the ray meets with t_min < t < t_max: id, (t, u, v), and whether on its front.
    pub(crate) fn nearest(
        &self,
        a: Vec3,
        d: Vec3,
        t_min: f64,
        t_max: f64,
        tolerance: &Tolerance,
    ) -> Option<(u32, [f64; 3], bool)> {
        if self.nodes.is_empty() {
            return None;
        }
        let clipped = grid_traversal::clip(a, d, self.lo, self.hi, t_min.max(0.0), t_max)?;
        let search = ClosestHitSearch { bvh: self, a, d, clipped, range: (t_min, t_max), tolerance };
        if self.depth <= SMALL_STACK_DEPTH {
            self.dispatch.run(search)
        } else {
            self.dispatch.run(LargeStack(search))
        }
    }

    /// Calls `each` with the id of every plate whose padded box overlaps [lo, hi], in no order.
    pub(crate) fn overlapping(&self, lo: Vec3, hi: Vec3, mut each: impl FnMut(u32)) {
        let low = ((lo - self.centre) * self.scale).array().map(|x| x as f32);
        let high = ((hi - self.centre) * self.scale).array().map(|x| x as f32);
        self.visit_leaves(
            |b, lane| (0..3).all(|k| b[k][lane] <= high[k] && b[k + 3][lane] >= low[k]),
            |slot| {
                each(self.ids[slot]);
                false
            },
        );
    }

    /// True when a corner lies above the plane n·x = c by more than `slack`.
    pub(crate) fn has_points_above(&self, n: Vec3, c: f64, slack: f64) -> bool {
        let level = (c - n.dot(self.centre)) * self.scale;
        let n32 = n.array().map(|x| x as f32);
        let level = (level - PLANE_TEST_SLACK) as f32;
        let above = |b: &[[f32; NODE_WIDTH]; 6], lane: usize| {
            let top: f32 = (0..3).map(|k| (n32[k] * b[k][lane]).max(n32[k] * b[k + 3][lane])).sum();
            b[0][lane] <= b[3][lane] && top >= level
        };
        self.visit_leaves(above, |slot| {
            let (x, count) = self.plates[slot].corners();
            x[..count].iter().any(|x| n.dot(*x) - c > slack)
        })
    }

    /// True when some plate may meet a segment of the shaft.
    pub(crate) fn any_in(&self, shaft: &Shaft, tolerance: &Tolerance) -> bool {
        let planes = shaft.planes().iter().map(|&(n, c)| {
            let level = (c - n.dot(self.centre)) * self.scale + PLANE_TEST_SLACK;
            (n.array().map(|x| x as f32), level as f32)
        });
        let planes: Vec<([f32; 3], f32)> = planes.collect();
        let reaches_in = |b: &[[f32; NODE_WIDTH]; 6], lane: usize| {
            b[0][lane] <= b[3][lane]
                && planes.iter().all(|(n, level)| {
                    let lowest = |k: usize| n[k] * b[if n[k] < 0.0 { k + 3 } else { k }][lane];
                    lowest(0) + lowest(1) + lowest(2) <= *level
                })
        };
        self.visit_leaves(reaches_in, |slot| shaft.may_meet(&self.plates[slot], tolerance))
    }

    /// Calls `visit` with the plates of all leaves whose boxes, and the boxes above them, satisfy `keep`, until it returns true.
    fn visit_leaves(
        &self,
        keep: impl Fn(&[[f32; NODE_WIDTH]; 6], usize) -> bool,
        mut visit: impl FnMut(usize) -> bool,
    ) -> bool {
        let mut stack: Vec<usize> = Vec::with_capacity(64);
        if !self.nodes.is_empty() {
            stack.push(0);
        }
        while let Some(here) = stack.pop() {
            let node = &self.nodes[here];
            for lane in 0..NODE_WIDTH {
                if !keep(&node.bounds, lane) {
                    continue;
                }
                match Child::of(node.child[lane]) {
                    Child::Leaf(block) => {
                        if self.blocks[block].slots().any(&mut visit) {
                            return true;
                        }
                    }
                    Child::Node(node) => stack.push(node),
                }
            }
        }
        false
    }
}
