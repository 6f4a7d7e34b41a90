//! Plates in a binary tree of boxes, so that the judge can ask scenes of many facets.
//!
//! A node is split where the surface area heuristic over sixteen bins is least (Wald 2007); a node that no bin divides, or that lies
//! deep, is halved at the median. The test of a plate is Cramer's rule: with s = o − origin, N = e₁ × e₂, q = s × d, D = −d·N
//!
//! ```text
//! t = s·N/D      u D = q·e₂      v D = −q·e₁
//! ```
//!
//! Edges are widened by a few roundings of the scene's size, so that no line slips between two plates that share one. Everything
//! is in double precision; the walk over every facet in [`crate::world`] must give the same answers.

use std::ops::Range;
use zonal_math::Vec3;
use zonal_scene::{Plate, PlateKind};

/// Bins of the heuristic along an axis.
const BINS: usize = 16;
/// A leaf holds at most this many plates.
const LEAF: usize = 4;
/// Below this depth nodes are halved, so that the stack of a walk has room.
const DEEP: usize = 64;
/// The deepest walk: DEEP levels, then halves of at most 2³² plates.
const STACK: usize = DEEP + 33;
/// Rounding of a coordinate, relative to the scene's size: boxes and edges are widened by this much.
const ROUNDING: f64 = 1e-14;
/// Stands for 1/0, so that no product with it is NaN.
const STEEP: f64 = 1e300;
/// A line whose cosine with a plate's normal is smaller runs along it.
const ALONG: f64 = 1e-13;

/// Where a ray meets a plate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Met {
    /// Distance, m.
    pub t: f64,
    /// Index of the plate.
    pub id: u32,
    /// Plate parameters.
    pub uv: [f64; 2],
    /// True when the front is met.
    pub front: bool,
}

#[derive(Clone, Copy, Debug)]
struct Shape {
    origin: Vec3,
    e1: Vec3,
    e2: Vec3,
    cross: Vec3,
    /// By how much u D and v D may miss.
    slack: f64,
    /// |N| times [`ALONG`].
    least: f64,
    triangle: bool,
    id: u32,
}

impl Shape {
    fn new(id: u32, p: &Plate, size: f64) -> Shape {
        let cross = p.e1.cross(p.e2);
        let reach = p.e1.length().max(p.e2.length());
        Shape {
            origin: p.origin,
            e1: p.e1,
            e2: p.e2,
            cross,
            slack: ROUNDING * size * reach,
            least: ALONG * cross.length(),
            triangle: p.kind == PlateKind::Triangle,
            id,
        }
    }

    #[inline]
    fn meet(&self, o: Vec3, d: Vec3, range: &Range<f64>) -> Option<Met> {
        let along = -d.dot(self.cross);
        if along.abs() <= self.least {
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
        (u >= -slack && v >= -slack && far).then_some(Met { t, id: self.id, uv: [u, v], front: along > 0.0 })
    }
}

#[derive(Clone, Copy, Debug)]
struct Box3 {
    lo: Vec3,
    hi: Vec3,
}

impl Box3 {
    const NONE: Box3 = Box3 { lo: Vec3::splat(f64::INFINITY), hi: Vec3::splat(f64::NEG_INFINITY) };

    fn with(self, o: Box3) -> Box3 {
        Box3 { lo: self.lo.min(o.lo), hi: self.hi.max(o.hi) }
    }
    fn half_area(self) -> f64 {
        let e = self.hi - self.lo;
        if e.x < 0.0 { 0.0 } else { e.x * e.y + e.y * e.z + e.z * e.x }
    }
    /// Where a ray enters, if it meets the box within `range`.
    #[inline]
    fn entry(&self, o: Vec3, inverse: Vec3, range: &Range<f64>) -> Option<f64> {
        let (a, b) = ((self.lo - o).scale(inverse), (self.hi - o).scale(inverse));
        let near = larger(larger(lesser(a.x, b.x), lesser(a.y, b.y)), larger(lesser(a.z, b.z), range.start));
        let far = lesser(lesser(larger(a.x, b.x), larger(a.y, b.y)), lesser(larger(a.z, b.z), range.end));
        (near <= far).then_some(near)
    }
}

/// The lesser of two numbers that are none of them NaN, in one instruction.
#[inline]
fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The larger of two numbers that are none of them NaN.
#[inline]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Box3,
    /// The first of two children, or of a leaf's shapes.
    first: u32,
    /// Shapes of a leaf; none for an inner node.
    count: u32,
}

/// The tree.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    nodes: Vec<Node>,
    shapes: Vec<Shape>,
}

impl Tree {
    /// Builds the tree of plates with their indices, in a scene whose coordinates and edges reach no farther than `size`, m.
    pub fn new(plates: impl Iterator<Item = (u32, Plate)>, size: f64) -> Tree {
        let pad = Vec3::splat(4.0 * ROUNDING * size);
        let mut items: Vec<(Box3, Shape)> = plates
            .map(|(id, p)| {
                let (lo, hi) = p.bounds();
                (Box3 { lo: lo - pad, hi: hi + pad }, Shape::new(id, &p, size))
            })
            .collect();
        if items.is_empty() {
            return Tree::default();
        }
        let mut nodes = vec![Node { bounds: Box3::NONE, first: 0, count: 0 }];
        let mut open = vec![(0, 0..items.len(), 0)];
        while let Some((node, range, depth)) = open.pop() {
            let part = &mut items[range.clone()];
            let bounds = part.iter().fold(Box3::NONE, |b, x| b.with(x.0));
            let (first, count) = (range.start as u32, part.len() as u32);
            nodes[node] = Node { bounds, first, count };
            if part.len() <= LEAF {
                continue;
            }
            let middle = range.start + divide(part, depth);
            let child = nodes.len();
            nodes[node] = Node { bounds, first: child as u32, count: 0 };
            nodes.extend([nodes[node]; 2]);
            open.push((child, range.start..middle, depth + 1));
            open.push((child + 1, middle..range.end, depth + 1));
        }
        Tree { nodes, shapes: items.into_iter().map(|x| x.1).collect() }
    }

    /// True without plates.
    pub fn is_empty(&self) -> bool {
        self.shapes.is_empty()
    }

    /// Calls `each` with every plate met within `range`; what it returns is the new end of the range.
    #[inline]
    fn visit(&self, o: Vec3, d: Vec3, mut range: Range<f64>, mut each: impl FnMut(Met) -> f64) {
        let inverse = Vec3::from_array(d.array().map(|x| if x == 0.0 { STEEP } else { 1.0 / x }));
        let mut stack = [(0u32, 0.0f64); STACK];
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
                for s in &self.shapes[n.first as usize..(n.first + n.count) as usize] {
                    if let Some(met) = s.meet(o, d, &range) {
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
            // The nearer child last: it is taken first.
            let pair = if a.map_or(0.0, |x| x.1) < b.map_or(0.0, |x| x.1) { [b, a] } else { [a, b] };
            for child in pair.into_iter().flatten() {
                stack[top] = child;
                top += 1;
            }
        }
    }

    /// The nearest plate within `range`, `skip` apart.
    pub fn nearest(&self, o: Vec3, d: Vec3, range: Range<f64>, skip: Option<u32>) -> Option<Met> {
        let mut best: Option<Met> = None;
        let mut end = range.end;
        self.visit(o, d, range, |met| {
            if Some(met.id) != skip {
                (end, best) = (met.t, Some(met));
            }
            end
        });
        best
    }

    /// True when a plate lies within `range`, those in `skip` apart.
    pub fn any(&self, o: Vec3, d: Vec3, range: Range<f64>, skip: [Option<u32>; 2]) -> bool {
        let (mut found, end) = (false, range.end);
        self.visit(o, d, range, |met| {
            found |= !skip.contains(&Some(met.id));
            if found { f64::NEG_INFINITY } else { end }
        });
        found
    }

    /// Every plate within `range`, by ascending distance.
    pub fn all(&self, o: Vec3, d: Vec3, range: Range<f64>) -> Vec<Met> {
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

/// Reorders the items of a node and says where its second child begins.
fn divide(items: &mut [(Box3, Shape)], depth: usize) -> usize {
    let centre = |x: &(Box3, Shape)| (x.0.lo + x.0.hi) * 0.5;
    let (lo, hi) = items.iter().fold((Box3::NONE.lo, Box3::NONE.hi), |(lo, hi), x| {
        let c = centre(x);
        (lo.min(c), hi.max(c))
    });
    let extent = hi - lo;
    if depth < DEEP
        && let Some((axis, cut)) = cheapest(items, lo, extent)
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
    (((x - lo) / extent * BINS as f64) as usize).min(BINS - 1)
}

/// The axis and first bin of the second child of the cheapest division that leaves no child empty.
fn cheapest(items: &[(Box3, Shape)], lo: Vec3, extent: Vec3) -> Option<(usize, usize)> {
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in (0..3).filter(|&k| extent[k] > 0.0) {
        let mut bins = [(Box3::NONE, 0usize); BINS];
        for x in items {
            let b = &mut bins[bin((x.0.lo[axis] + x.0.hi[axis]) * 0.5, lo[axis], extent[axis])];
            *b = (b.0.with(x.0), b.1 + 1);
        }
        let mut above = [(Box3::NONE, 0usize); BINS + 1];
        for k in (0..BINS).rev() {
            above[k] = (above[k + 1].0.with(bins[k].0), above[k + 1].1 + bins[k].1);
        }
        let mut below = (Box3::NONE, 0usize);
        for cut in 1..BINS {
            below = (below.0.with(bins[cut - 1].0), below.1 + bins[cut - 1].1);
            let cost = below.0.half_area() * below.1 as f64 + above[cut].0.half_area() * above[cut].1 as f64;
            if below.1 > 0 && above[cut].1 > 0 && best.is_none_or(|b| cost < b.0) {
                best = Some((cost, axis, cut));
            }
        }
    }
    best.map(|b| (b.1, b.2))
}
