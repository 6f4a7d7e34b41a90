//! Plates in a binary tree of boxes, for ray queries in scenes of many facets.
//!
//! A node is split where the surface area heuristic over sixteen bins is least (Wald 2007); a node that no bin divides, or beyond a
//! depth, is halved at the median. The plate test is Cramer's rule: with s = o − origin, N = e₁ × e₂, q = s × d, D = −d·N
//!
//! ```text
//! t = s·N/D      u D = q·e₂      v D = −q·e₁
//! ```
//!
//! Edges are widened by a few roundings of the scene's size, so that no line passes between two plates that share one. All
//! arithmetic is in double precision; the search over every facet in [`crate::brute_force`] must agree.

use std::ops::Range;
use zonal_math::Vec3;
use zonal_scene::{Plate, PlateKind};

/// Bins of the heuristic along an axis.
const SAH_BINS: usize = 16;
/// Most plates of a leaf.
const MAX_LEAF_PLATES: usize = 4;
/// Depth from which nodes are halved, which bounds the stack.
const MEDIAN_SPLIT_DEPTH: usize = 64;
/// Stack of a traversal: MEDIAN_SPLIT_DEPTH levels, then halves of at most 2³² plates.
const MAX_STACK: usize = MEDIAN_SPLIT_DEPTH + 33;
/// Rounding of a coordinate, relative to the scene's size, by which boxes and edges are widened.
const RELATIVE_ROUNDING: f64 = 1e-14;
/// Replaces 1/0, so that products with it are not NaN.
const LARGE_INVERSE: f64 = 1e300;
/// A line whose cosine with a plate's normal is smaller is parallel to the plate.
const MIN_COSINE: f64 = 1e-13;

/// Intersection of a ray with a plate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// Distance, m.
    pub t: f64,
    /// Index of the plate.
    pub id: u32,
    /// Plate parameters.
    pub uv: [f64; 2],
    /// True when the front is hit.
    pub front: bool,
}

/// A plate with the derived quantities of the intersection test.
#[derive(Clone, Copy, Debug)]
struct TreePlate {
    origin: Vec3,
    e1: Vec3,
    e2: Vec3,
    cross: Vec3,
    /// Tolerance of u D and v D.
    slack: f64,
    /// |N| times [`MIN_COSINE`].
    min_along: f64,
    triangle: bool,
    id: u32,
}

impl TreePlate {
    fn new(id: u32, p: &Plate, size: f64) -> TreePlate {
        let cross = p.e1.cross(p.e2);
        let reach = p.e1.length().max(p.e2.length());
        TreePlate {
            origin: p.origin,
            e1: p.e1,
            e2: p.e2,
            cross,
            slack: RELATIVE_ROUNDING * size * reach,
            min_along: MIN_COSINE * cross.length(),
            triangle: p.kind == PlateKind::Triangle,
            id,
        }
    }

    #[inline]
    fn intersect(&self, o: Vec3, d: Vec3, range: &Range<f64>) -> Option<RayHit> {
        let along = -d.dot(self.cross);
        if along.abs() <= self.min_along {
            return None;
        }
        let s = o - self.origin;
        let t = s.dot(self.cross) / along;
        if !(t > range.start && t < range.end) {
            return None;
        }
        let q = s.cross(d);
        let (u, v) = (q.dot(self.e2) / along, -q.dot(self.e1) / along);
        let slack = self.slack / along.abs();
        let top = 1.0 + slack;
        let far = if self.triangle { u + v <= top } else { u <= top && v <= top };
        (u >= -slack && v >= -slack && far).then_some(RayHit {
            t,
            id: self.id,
            uv: [u, v],
            front: along > 0.0,
        })
    }
}

#[derive(Clone, Copy, Debug)]
struct Bounds3 {
    lo: Vec3,
    hi: Vec3,
}

impl Bounds3 {
    const EMPTY_BOX: Bounds3 = Bounds3 { lo: Vec3::splat(f64::INFINITY), hi: Vec3::splat(f64::NEG_INFINITY) };

    fn union(self, o: Bounds3) -> Bounds3 {
        Bounds3 { lo: self.lo.min(o.lo), hi: self.hi.max(o.hi) }
    }
    fn half_area(self) -> f64 {
        let e = self.hi - self.lo;
        if e.x < 0.0 { 0.0 } else { e.x * e.y + e.y * e.z + e.z * e.x }
    }
    /// Distance at which a ray enters the box; `None` when it misses the box within `range`.
    #[inline]
    fn entry(&self, o: Vec3, inverse: Vec3, range: &Range<f64>) -> Option<f64> {
        let (a, b) = ((self.lo - o).scale(inverse), (self.hi - o).scale(inverse));
        let near = max_of(max_of(min_of(a.x, b.x), min_of(a.y, b.y)), max_of(min_of(a.z, b.z), range.start));
        let far = min_of(min_of(max_of(a.x, b.x), max_of(a.y, b.y)), min_of(max_of(a.z, b.z), range.end));
        (near <= far).then_some(near)
    }
}

/// The smaller of two numbers, neither of them NaN, in one instruction.
#[inline]
fn min_of(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The larger of two numbers, neither of them NaN.
#[inline]
fn max_of(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[derive(Clone, Copy, Debug)]
struct BvhNode {
    bounds: Bounds3,
    /// Index of the first of two children, or of a leaf's plates.
    first: u32,
    /// Number of plates of a leaf; 0 for an inner node.
    count: u32,
}

/// A binary tree of boxes over plates.
#[derive(Clone, Debug, Default)]
pub struct BinaryBvh {
    nodes: Vec<BvhNode>,
    plates: Vec<TreePlate>,
}

impl BinaryBvh {
    /// Builds the tree of plates with their indices, in a scene whose coordinates and edges are at most `size`, m.
    pub fn new(plates: impl Iterator<Item = (u32, Plate)>, size: f64) -> BinaryBvh {
        let pad = Vec3::splat(4.0 * RELATIVE_ROUNDING * size);
        let mut items: Vec<(Bounds3, TreePlate)> = plates
            .map(|(id, p)| {
                let (lo, hi) = p.bounds();
                (Bounds3 { lo: lo - pad, hi: hi + pad }, TreePlate::new(id, &p, size))
            })
            .collect();
        if items.is_empty() {
            return BinaryBvh::default();
        }
        let mut nodes = vec![BvhNode { bounds: Bounds3::EMPTY_BOX, first: 0, count: 0 }];
        let mut open = vec![(0, 0..items.len(), 0)];
        while let Some((node, range, depth)) = open.pop() {
            let part = &mut items[range.clone()];
            let bounds = part.iter().fold(Bounds3::EMPTY_BOX, |b, x| b.union(x.0));
            let (first, count) = (range.start as u32, part.len() as u32);
            nodes[node] = BvhNode { bounds, first, count };
            if part.len() <= MAX_LEAF_PLATES {
                continue;
            }
            let middle = range.start + partition(part, depth);
            let child = nodes.len();
            nodes[node] = BvhNode { bounds, first: child as u32, count: 0 };
            nodes.extend([nodes[node]; 2]);
            open.push((child, range.start..middle, depth + 1));
            open.push((child + 1, middle..range.end, depth + 1));
        }
        BinaryBvh { nodes, plates: items.into_iter().map(|x| x.1).collect() }
    }

    /// True without plates.
    pub fn is_empty(&self) -> bool {
        self.plates.is_empty()
    }

    /// Calls `each` with every plate hit within `range`; its return value is the new end of the range.
    #[inline]
    fn visit(&self, o: Vec3, d: Vec3, mut range: Range<f64>, mut each: impl FnMut(RayHit) -> f64) {
        let inverse = Vec3::from_array(d.array().map(|x| if x == 0.0 { LARGE_INVERSE } else { 1.0 / x }));
        let mut stack = [(0u32, 0.0f64); MAX_STACK];
        let mut top = 0;
        if let Some(root) = self.nodes.first()
            && let Some(t) = root.bounds.entry(o, inverse, &range)
        {
            stack[0] = (0, t);
            top = 1;
        }
        while top > 0 {
            top -= 1;
            let (node, near) = stack[top];
            if near > range.end {
                continue;
            }
            let n = &self.nodes[node as usize];
            if n.count > 0 {
                for s in &self.plates[n.first as usize..(n.first + n.count) as usize] {
                    if let Some(met) = s.intersect(o, d, &range) {
                        range.end = each(met);
                    }
                }
                continue;
            }
            let enter = |k: u32| {
                let t = self.nodes[(n.first + k) as usize].bounds.entry(o, inverse, &range);
                t.map(|t| (n.first + k, t))
            };
            let (a, b) = (enter(0), enter(1));
            // Push the nearer child last, so that it is visited first.
            let pair = if a.map_or(0.0, |x| x.1) < b.map_or(0.0, |x| x.1) { [b, a] } else { [a, b] };
            for child in pair.into_iter().flatten() {
                stack[top] = child;
                top += 1;
            }
        }
    }

    /// The nearest plate within `range`, except `skip`.
    pub fn nearest(&self, o: Vec3, d: Vec3, range: Range<f64>, skip: Option<u32>) -> Option<RayHit> {
        let mut best: Option<RayHit> = None;
        let mut end = range.end;
        self.visit(o, d, range, |met| {
            if Some(met.id) != skip {
                (end, best) = (met.t, Some(met));
            }
            end
        });
        best
    }

    /// True when a plate is hit within `range`, except those in `skip`.
    pub fn any(&self, o: Vec3, d: Vec3, range: Range<f64>, skip: [Option<u32>; 2]) -> bool {
        let (mut found, end) = (false, range.end);
        self.visit(o, d, range, |met| {
            found |= !skip.contains(&Some(met.id));
            if found { f64::NEG_INFINITY } else { end }
        });
        found
    }

    /// Every plate hit within `range`, by ascending distance.
    pub fn all(&self, o: Vec3, d: Vec3, range: Range<f64>) -> Vec<RayHit> {
        let mut met = Vec::new();
        let end = range.end;
        self.visit(o, d, range, |m| {
            met.push(m);
            end
        });
        met.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.id.cmp(&b.id)));
        met
    }
}

/// Reorders the items of a node; returns the index of the first item of its second child.
fn partition(items: &mut [(Bounds3, TreePlate)], depth: usize) -> usize {
    let centre = |x: &(Bounds3, TreePlate)| (x.0.lo + x.0.hi) * 0.5;
    let (lo, hi) = items.iter().fold((Bounds3::EMPTY_BOX.lo, Bounds3::EMPTY_BOX.hi), |(lo, hi), x| {
        let c = centre(x);
        (lo.min(c), hi.max(c))
    });
    let extent = hi - lo;
    if depth < MEDIAN_SPLIT_DEPTH
        && let Some((axis, cut)) = cheapest_split(items, lo, extent)
    {
        let mut middle = 0;
        for i in 0..items.len() {
            if bin(centre(&items[i])[axis], lo[axis], extent[axis]) < cut {
                items.swap(i, middle);
                middle += 1;
            }
        }
        return middle;
    }
    let axis = (0..3).fold(0, |b, k| if extent[k] > extent[b] { k } else { b });
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| {
        centre(a)[axis].total_cmp(&centre(b)[axis]).then(a.1.id.cmp(&b.1.id))
    });
    middle
}

fn bin(x: f64, lo: f64, extent: f64) -> usize {
    (((x - lo) / extent * SAH_BINS as f64) as usize).min(SAH_BINS - 1)
}

/// The axis and the first bin of the second child of the cheapest split without an empty child.
fn cheapest_split(items: &[(Bounds3, TreePlate)], lo: Vec3, extent: Vec3) -> Option<(usize, usize)> {
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in (0..3).filter(|&k| extent[k] > 0.0) {
        let mut bins = [(Bounds3::EMPTY_BOX, 0usize); SAH_BINS];
        for x in items {
            let b = &mut bins[bin((x.0.lo[axis] + x.0.hi[axis]) * 0.5, lo[axis], extent[axis])];
            *b = (b.0.union(x.0), b.1 + 1);
        }
        let mut above = [(Bounds3::EMPTY_BOX, 0usize); SAH_BINS + 1];
        for k in (0..SAH_BINS).rev() {
            above[k] = (above[k + 1].0.union(bins[k].0), above[k + 1].1 + bins[k].1);
        }
        let mut below = (Bounds3::EMPTY_BOX, 0usize);
        for cut in 1..SAH_BINS {
            below = (below.0.union(bins[cut - 1].0), below.1 + bins[cut - 1].1);
            let cost = below.0.half_area() * below.1 as f64 + above[cut].0.half_area() * above[cut].1 as f64;
            if below.1 > 0 && above[cut].1 > 0 && best.is_none_or(|b| cost < b.0) {
                best = Some((cost, axis, cut));
            }
        }
    }
    best.map(|b| (b.1, b.2))
}
