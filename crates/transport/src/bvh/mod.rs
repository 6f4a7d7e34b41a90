//! An eight-wide tree of boxes over plates.
//!
//! A segment a + t d meets the box [lo, hi] where max_k min((lo−a)/d, (hi−a)/d)_k ≤ min_k max(…)_k on 0 ≤ t ≤ 1, eight boxes at a
//! time in single precision. Coordinates are taken about the scene's centre in units of its half size R, and boxes are padded by
//! 10⁻⁶ R: rounding of a, d, 1/d and of the products moves a box's face by at most 5·10⁻⁷ R, so no box that holds a hit is
//! missed. A zero component of d becomes 10⁻²⁰, so nothing is ever 0·∞. Whether a plate is hit is decided in double precision
//! by [`crate::meet`] alone.

mod build;
mod node;

use crate::meet::{Line, Prepared, Tolerance};
use crate::shaft::Shaft;
use build::Item;
use node::{LANES, Node, Ray, leaf};
use zonal_math::Vec3;
use zonal_scene::Plate;

const PAD: f64 = 1e-6;

/// More than rounding in single precision moves a box against a plane, in units of R.
const PLANE_SLACK: f64 = 1e-5;

/// Plates in leaf order under their tree.
#[derive(Clone, Debug)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    plates: Vec<Prepared>,
    ids: Vec<u32>,
    depth: usize,
    centre: Vec3,
    scale: f64,
    lo: Vec3,
    hi: Vec3,
}

impl Bvh {
    /// The tree over (id, plate) pairs; `bounds` are the scene's.
    pub fn new(plates: &[(u32, Plate)], bounds: (Vec3, Vec3)) -> Bvh {
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
        let (nodes, depth) = build::build(&mut items);
        let pad = Vec3::splat(2.0 * PAD / scale);
        Bvh {
            nodes,
            plates: items.iter().map(|i| Prepared::new(&plates[i.id as usize].1)).collect(),
            ids: items.iter().map(|i| plates[i.id as usize].0).collect(),
            depth,
            centre,
            scale,
            lo: bounds.0 - pad,
            hi: bounds.1 + pad,
        }
    }

    pub fn len(&self) -> usize {
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

    /// The segment from `t0` to `t1` of a + t d as the boxes see it.
    #[inline(always)]
    fn ray(&self, a: Vec3, d: Vec3, t0: f64, t1: f64) -> Ray {
        Ray::new((a + d * t0 - self.centre) * self.scale, d * ((t1 - t0) * self.scale))
    }

    /// Shows `visit` every plate whose box the segment a + t d, 0 ≤ t ≤ 1, meets, until it says stop.
    #[inline(always)]
    fn visit(&self, a: Vec3, d: Vec3, visit: impl FnMut(usize) -> bool) -> bool {
        if self.nodes.is_empty() {
            return false;
        }
        let Some((t0, t1)) = self.clip(a, d) else {
            return false;
        };
        let ray = self.ray(a, d, t0, t1);
        if self.depth <= 12 { self.descend::<12>(&ray, visit) } else { self.descend::<96>(&ray, visit) }
    }

    #[inline(always)]
    fn descend<const DEPTH: usize>(&self, ray: &Ray, mut visit: impl FnMut(usize) -> bool) -> bool {
        let mut stack = [(0u32, 0u32); DEPTH];
        let mut top = 0;
        let mut node = &self.nodes[0];
        let mut here = 0;
        let mut entry = [0.0; LANES];
        let mut mask = ray.enter(node, 1.0, &mut entry);
        loop {
            while mask != 0 {
                let lane = mask.trailing_zeros() as usize & (LANES - 1);
                mask &= mask - 1;
                let child = node.child[lane];
                match leaf(child) {
                    Some(run) => {
                        for slot in run {
                            if visit(slot) {
                                return true;
                            }
                        }
                    }
                    None => {
                        if mask != 0 {
                            stack[top] = (here, mask);
                            top += 1;
                        }
                        here = child;
                        node = &self.nodes[here as usize];
                        mask = ray.enter(node, 1.0, &mut entry);
                    }
                }
            }
            if top == 0 {
                return false;
            }
            top -= 1;
            (here, mask) = stack[top];
            node = &self.nodes[here as usize];
        }
    }

    /// True when any plate crosses the segment a → b.
    #[inline]
    pub fn any(&self, a: Vec3, b: Vec3, tol: &Tolerance) -> bool {
        let line = Line::new(a, b - a, tol);
        self.visit(a, line.d, |slot| self.plates[slot].crosses(&line))
    }

    /// Every plate that crosses the segment a → b, in no order: its id, the share t of the segment, (u, v), and d·n̂.
    pub fn all(&self, a: Vec3, b: Vec3, tol: &Tolerance, mut each: impl FnMut(u32, [f64; 3], f64)) {
        let line = Line::new(a, b - a, tol);
        self.visit(a, line.d, |slot| {
            if let Some(at) = self.plates[slot].crossing(&line) {
                each(self.ids[slot], at, line.d.dot(self.plates[slot].normal()));
            }
            false
        });
    }

    /// The first plate that the ray meets with t_min < t < t_max: id, (t, u, v), and whether on its front.
    pub fn nearest(
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
        if self.depth <= 12 {
            self.closest::<96>(a, d, (t0, t1), range, tol)
        } else {
            self.closest::<768>(a, d, (t0, t1), range, tol)
        }
    }

    fn closest<const STACK: usize>(
        &self,
        a: Vec3,
        d: Vec3,
        (t0, t1): (f64, f64),
        (t_min, mut t_max): (f64, f64),
        tol: &Tolerance,
    ) -> Option<(u32, [f64; 3], bool)> {
        let ray = self.ray(a, d, t0, t1);
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
            let Some(run) = leaf(child) else {
                let node = &self.nodes[child as usize];
                let mut entries = [0.0; LANES];
                let mut mask = ray.enter(node, limit, &mut entries);
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
            for slot in run {
                if let Some(at) = self.plates[slot].meets(&line, tol.rounding, t_min, t_max) {
                    t_max = at[0];
                    limit = (((t_max - t0) / (t1 - t0)) as f32 * 1.000_001 + 1e-6).min(1.0);
                    found = Some((self.ids[slot], at, d.dot(self.plates[slot].normal()) < 0.0));
                }
            }
        }
        found
    }

    /// Shows every plate whose padded box overlaps [lo, hi]: the id alone, in no order.
    pub fn overlapping(&self, lo: Vec3, hi: Vec3, mut each: impl FnMut(u32)) {
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
    pub fn reaches_above(&self, n: Vec3, c: f64, slack: f64) -> bool {
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
    pub fn any_in(&self, shaft: &Shaft, tol: &Tolerance) -> bool {
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
                    Some(mut run) => {
                        if run.any(&mut visit) {
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
