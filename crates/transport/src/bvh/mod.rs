//! An eight-wide tree of boxes over plates.
//!
//! A segment a + t d meets the box [lo, hi] where max_k min((lo−a)/d, (hi−a)/d)_k ≤ min_k max(…)_k on 0 ≤ t ≤ 1, eight boxes at a
//! time in single precision. Coordinates are taken about the scene's centre in units of its half size R, and boxes are padded by
//! 10⁻⁶ R: rounding of a, d, 1/d and of the products moves a box's face by at most 5·10⁻⁷ R, so no box that
//! holds a hit is missed. A zero component of d becomes 10⁻²⁰, so nothing is ever 0·∞. A leaf holds up to eight plates; `block` says in single
//! precision which of them the segment cannot cross. Whether a plate is hit is decided in double precision by
//! [`crate::meet`] alone.

mod block;
mod build;
mod node;

use crate::meet::{Line, Prepared, Tolerance};
use crate::shaft::Shaft;
use block::{Block, Plane, Segment};
use build::Item;
use node::{LANES, Node, Ray, leaf};
use zonal_math::Vec3;
use zonal_math::wide::{Machine, Task, Wide};
use zonal_scene::Plate;

const PAD: f64 = 1e-6;

/// Up to this depth the stack is small.
const SHALLOW: usize = 12;
/// So many plates in doubt wait until nothing else blocks: most segments that end on a plate are blocked elsewhere.
const LATE: usize = 16;
/// No tree is deeper than this.
const DEEPEST: usize = 96;

/// More than rounding in single precision moves a box against a plane, in units of R.
const PLANE_SLACK: f64 = 1e-5;

/// Plates in leaf order under their tree.
#[derive(Clone, Debug)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    blocks: Vec<Block>,
    /// Of each block.
    planes: Vec<Plane>,
    plates: Vec<Prepared>,
    ids: Vec<u32>,
    depth: usize,
    machine: Machine,
    centre: Vec3,
    scale: f64,
    lo: Vec3,
    hi: Vec3,
}

impl Bvh {
    /// The tree over (id, plate) pairs; `bounds` are the scene's.
    pub(crate) fn new(plates: &[(u32, Plate)], bounds: (Vec3, Vec3)) -> Bvh {
        let centre = (bounds.0 + bounds.1) * 0.5;
        let half = (bounds.1 - bounds.0).max_abs() * 0.5;
        // Far from the origin the plates' own coordinates are coarser than the padding would be.
        let half = half.max(1e-7 * bounds.0.max_abs().max(bounds.1.max_abs()));
        let scale = if half > 0.0 { 1.0 / half } else { 1.0 };
        let mut items: Vec<Item> = plates
            .iter()
            .enumerate()
            .map(|(k, (_, p))| {
                let (lo, hi) = p.bounds();
                let (lo, hi) = ((lo - centre) * scale, (hi - centre) * scale);
                Item {
                    lo: lo.array().map(|x| ((x - PAD) as f32).next_down()),
                    hi: hi.array().map(|x| ((x + PAD) as f32).next_up()),
                    id: k as u32,
                }
            })
            .collect();
        let built = build::build(&mut items);
        let ordered: Vec<Plate> = items.iter().map(|i| plates[i.id as usize].1).collect();
        let run = |first: u32, count: u32| &ordered[first as usize..(first + count) as usize];
        let block = |&(first, count): &(u32, u32)| {
            Block::new(run(first, count), first, |x| (x - centre) * scale, scale)
        };
        let plane = |&(first, count): &(u32, u32)| Plane::new(run(first, count), scale);
        let pad = Vec3::splat(2.0 * PAD / scale);
        Bvh {
            blocks: built.leaves.iter().map(block).collect(),
            planes: built.leaves.iter().map(plane).collect(),
            nodes: built.nodes,
            plates: ordered.iter().map(Prepared::new).collect(),
            ids: items.iter().map(|i| plates[i.id as usize].0).collect(),
            depth: built.depth,
            machine: Machine::detect(),
            centre,
            scale,
            lo: bounds.0 - pad,
            hi: bounds.1 + pad,
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.plates.len()
    }

    /// The part [t0, t1] of the segment a + t d, 0 ≤ t ≤ 1, within the scene's bounds.
    #[inline]
    fn clip(&self, a: Vec3, d: Vec3) -> Option<(f64, f64)> {
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
        crate::walk::clip(a, d, self.lo, self.hi, 0.0, 1.0)
    }

    /// The segment from `t0` to `t1` of a + t d as boxes and blocks see it.
    #[inline(always)]
    fn ray(&self, a: Vec3, d: Vec3, t0: f64, t1: f64) -> (Ray, Segment) {
        let (a, d) = ((a + d * t0 - self.centre) * self.scale, d * ((t1 - t0) * self.scale));
        (Ray::new(a, d), Segment::new(a, d))
    }

    /// Shows `visit` every plate that the segment a + t d, 0 ≤ t ≤ 1, may cross, until it says stop; with `ANY` plates that are
    /// surely crossed are not shown: they are a stop.
    #[inline(always)]
    fn visit<const ANY: bool>(&self, line: &Line, visit: impl FnMut(usize) -> bool) -> bool {
        if self.nodes.is_empty() {
            return false;
        }
        let Some((t0, t1)) = self.clip(line.a, line.d) else {
            return false;
        };
        let whole = t0 == 0.0 && t1 == 1.0;
        let (ray, segment) = self.ray(line.a, line.d, t0, t1);
        let descent: Descent<'_, _, ANY> = Descent { bvh: self, line, whole, ray, segment, visit };
        if self.depth <= SHALLOW { self.machine.run(descent) } else { self.machine.run(Deep(descent)) }
    }

    /// True when any plate crosses the segment a → b.
    #[inline]
    pub(crate) fn any(&self, a: Vec3, b: Vec3, tol: &Tolerance) -> bool {
        let line = Line::new(a, b - a, tol);
        self.visit::<true>(&line, |slot| self.plates[slot].crosses(&line))
    }

    /// Every plate that crosses the segment a → b, in no order: its id, the share t of the segment, (u, v), and d·n̂.
    pub(crate) fn all(&self, a: Vec3, b: Vec3, tol: &Tolerance, mut each: impl FnMut(u32, [f64; 3], f64)) {
        let line = Line::new(a, b - a, tol);
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
        range: (f64, f64),
        tol: &Tolerance,
    ) -> Option<(u32, [f64; 3], bool)> {
        if self.nodes.is_empty() {
            return None;
        }
        let (t0, t1) = crate::walk::clip(a, d, self.lo, self.hi, range.0.max(0.0), range.1)?;
        let closest = Closest { bvh: self, a, d, part: (t0, t1), range, tol };
        if self.depth <= SHALLOW { self.machine.run(closest) } else { self.machine.run(Deep(closest)) }
    }

    /// Shows every plate whose padded box overlaps [lo, hi]: the id alone, in no order.
    pub(crate) fn overlapping(&self, lo: Vec3, hi: Vec3, mut each: impl FnMut(u32)) {
        let low = ((lo - self.centre) * self.scale).array().map(|x| x as f32);
        let high = ((hi - self.centre) * self.scale).array().map(|x| x as f32);
        self.sift(
            |b, lane| (0..3).all(|k| b[k][lane] <= high[k] && b[k + 3][lane] >= low[k]),
            |slot| {
                each(self.ids[slot]);
                false
            },
        );
    }

    /// True when a corner lies above the plane n·x = c by more than `slack`.
    pub(crate) fn reaches_above(&self, n: Vec3, c: f64, slack: f64) -> bool {
        let level = (c - n.dot(self.centre)) * self.scale;
        let n32 = n.array().map(|x| x as f32);
        let level = (level - PLANE_SLACK) as f32;
        let above = |b: &[[f32; LANES]; 6], lane: usize| {
            let top: f32 = (0..3).map(|k| (n32[k] * b[k][lane]).max(n32[k] * b[k + 3][lane])).sum();
            b[0][lane] <= b[3][lane] && top >= level
        };
        self.sift(above, |slot| {
            let (x, count) = self.plates[slot].corners();
            x[..count].iter().any(|x| n.dot(*x) - c > slack)
        })
    }

    /// True when some plate may meet a segment of the shaft.
    pub(crate) fn any_in(&self, shaft: &Shaft, tol: &Tolerance) -> bool {
        let planes = shaft.planes().iter().map(|&(n, c)| {
            let level = (c - n.dot(self.centre)) * self.scale + PLANE_SLACK;
            (n.array().map(|x| x as f32), level as f32)
        });
        let planes: Vec<([f32; 3], f32)> = planes.collect();
        let reaches_in = |b: &[[f32; LANES]; 6], lane: usize| {
            b[0][lane] <= b[3][lane]
                && planes.iter().all(|(n, level)| {
                    let lowest = |k: usize| n[k] * b[if n[k] < 0.0 { k + 3 } else { k }][lane];
                    lowest(0) + lowest(1) + lowest(2) <= *level
                })
        };
        self.sift(reaches_in, |slot| shaft.may_meet(&self.plates[slot], tol))
    }

    /// Visits the leaves under all boxes that `keep` keeps, until `visit` says stop.
    fn sift(
        &self,
        keep: impl Fn(&[[f32; LANES]; 6], usize) -> bool,
        mut visit: impl FnMut(usize) -> bool,
    ) -> bool {
        let mut stack: Vec<u32> = Vec::with_capacity(64);
        if !self.nodes.is_empty() {
            stack.push(0);
        }
        while let Some(here) = stack.pop() {
            let node = &self.nodes[here as usize];
            for lane in 0..LANES {
                if !keep(&node.bounds, lane) {
                    continue;
                }
                match leaf(node.child[lane]) {
                    Some(block) => {
                        if self.blocks[block].run().any(&mut visit) {
                            return true;
                        }
                    }
                    None => stack.push(node.child[lane]),
                }
            }
        }
        false
    }
}

/// A way down to all leaves on a segment; with `ANY` it ends at a plate that is surely crossed, which is not shown.
struct Descent<'a, V, const ANY: bool> {
    bvh: &'a Bvh,
    line: &'a Line,
    /// True when both ends lie within the scene's bounds.
    whole: bool,
    ray: Ray,
    segment: Segment,
    visit: V,
}

/// The same for a deep tree.
struct Deep<T>(T);

impl<V: FnMut(usize) -> bool, const ANY: bool> Task for Descent<'_, V, ANY> {
    type Output = bool;
    #[inline(always)]
    fn go<W: Wide>(self, wide: W) -> bool {
        self.descend::<W, SHALLOW>(wide)
    }
}

impl<V: FnMut(usize) -> bool, const ANY: bool> Task for Deep<Descent<'_, V, ANY>> {
    type Output = bool;
    #[inline(always)]
    fn go<W: Wide>(self, wide: W) -> bool {
        self.0.descend::<W, DEEPEST>(wide)
    }
}

impl<V: FnMut(usize) -> bool, const ANY: bool> Descent<'_, V, ANY> {
    #[inline(always)]
    fn descend<W: Wide, const DEPTH: usize>(mut self, w: W) -> bool {
        let (bvh, ray) = (self.bvh, &self.ray);
        let mut stack = [(0u32, 0u32); DEPTH];
        let mut top = 0;
        let (mut doubtful, mut late) = ([0u32; LATE], 0);
        let mut here = 0;
        let node = &bvh.nodes[0];
        // Copied, so that they come from memory together with the boxes.
        let mut children = node.child;
        let (mut mask, _) = ray.enter(w, node, 1.0);
        loop {
            while mask != 0 {
                let lane = mask.trailing_zeros() as usize & (LANES - 1);
                mask &= mask - 1;
                let child = children[lane];
                if let Some(block) = leaf(child) {
                    if self.whole && bvh.planes[block].apart(self.line) {
                        continue;
                    }
                    let block = &bvh.blocks[block];
                    let first = block.run().start;
                    let (mut left, sure) = block.sieve(w, &self.segment);
                    if ANY && sure != 0 {
                        return true;
                    }
                    while left != 0 {
                        let slot = first + left.trailing_zeros() as usize;
                        left &= left - 1;
                        if ANY && late < LATE {
                            doubtful[late] = slot as u32;
                            late += 1;
                        } else if (self.visit)(slot) {
                            return true;
                        }
                    }
                    continue;
                }
                if mask != 0 {
                    stack[top] = (here, mask);
                    top += 1;
                }
                here = child;
                let node = &bvh.nodes[here as usize];
                children = node.child;
                mask = ray.enter(w, node, 1.0).0;
            }
            if top == 0 {
                return doubtful[..late].iter().any(|slot| (self.visit)(*slot as usize));
            }
            top -= 1;
            (here, mask) = stack[top];
            children = bvh.nodes[here as usize].child;
        }
    }
}

/// The search for the first plate on a ray.
struct Closest<'a> {
    bvh: &'a Bvh,
    a: Vec3,
    d: Vec3,
    /// The part of the ray within the scene's bounds.
    part: (f64, f64),
    range: (f64, f64),
    tol: &'a Tolerance,
}

/// Id, (t, u, v), and whether on the front.
type Found = Option<(u32, [f64; 3], bool)>;

impl Task for Closest<'_> {
    type Output = Found;
    #[inline(always)]
    fn go<W: Wide>(self, wide: W) -> Found {
        self.search::<W, { SHALLOW * LANES }>(wide)
    }
}

impl Task for Deep<Closest<'_>> {
    type Output = Found;
    #[inline(always)]
    fn go<W: Wide>(self, wide: W) -> Found {
        self.0.search::<W, { DEEPEST * LANES }>(wide)
    }
}

impl Closest<'_> {
    #[inline(always)]
    fn search<W: Wide, const STACK: usize>(self, w: W) -> Found {
        let Closest { bvh, a, d, part: (t0, t1), range: (t_min, mut t_max), tol } = self;
        let (ray, segment) = bvh.ray(a, d, t0, t1);
        let line = Line::new(a, d, tol);
        let mut stack = [(0.0f32, 0u32); STACK];
        let (mut top, mut limit) = (1, 1.0f32);
        let mut found = None;
        while top > 0 {
            top -= 1;
            let (entry, child) = stack[top];
            if entry > limit {
                continue;
            }
            let Some(block) = leaf(child) else {
                let node = &bvh.nodes[child as usize];
                let (mut mask, entries) = ray.enter(w, node, limit);
                let entries = w.store(entries);
                let bottom = top;
                while mask != 0 {
                    let lane = mask.trailing_zeros() as usize & (LANES - 1);
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
            let block = &bvh.blocks[block];
            let (mut left, _) = block.sieve(w, &segment);
            while left != 0 {
                let slot = block.run().start + left.trailing_zeros() as usize;
                left &= left - 1;
                if let Some(at) = bvh.plates[slot].meets(&line, tol.rounding, t_min, t_max) {
                    t_max = at[0];
                    limit = (((t_max - t0) / (t1 - t0)) as f32 * 1.000_001 + 1e-6).min(1.0);
                    found = Some((bvh.ids[slot], at, d.dot(bvh.plates[slot].normal()) < 0.0));
                }
            }
        }
        found
    }
}
