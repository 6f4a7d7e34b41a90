//! Exact lit intervals of a camera ray: the parts that a light sample reaches, without sampling.
//!
//! The ray o + t d and the light span the epipolar plane x = o + t d + s e + h m, with e the direction to the light (or q − o for a
//! light at the point q) and m = d × e. A plate meets that plane, h = 0, in a line segment. Seen from the light the segment shadows the
//! interval of t between its two ends, each projected onto the ray: t for a distant light, t/(1−s) for a point. The union of these
//! intervals is dark, so that the borders of shafts are as exact as the plates; panes give the intervals that they tint. A bounding
//! volume hierarchy skips plates off the plane, and the searched range shrinks as its ends fall dark. Cost: about log n boxes and
//! the plates that cut the plane.

use crate::view_ray::ViewRay;
use zonal_math::Vec3;
use zonal_scene::{Plate, Scene};
use zonal_transport::lights::EmissionSample;

/// The kind of a shadow caster.
#[derive(Clone, Copy, Debug, PartialEq)]
enum CasterKind {
    /// An opaque facet.
    Facet(u32),
    /// A plate of a pane: the pane and the plate's unit normal.
    Pane(u32, Vec3),
}

/// A plate that casts shadows, with its box.
#[derive(Clone, Debug)]
struct CasterPlate {
    plate: Plate,
    kind: CasterKind,
    centre: Vec3,
    half: Vec3,
}

/// A box of the hierarchy.
#[derive(Clone, Debug)]
struct CasterNode {
    centre: Vec3,
    half: Vec3,
    /// First plate and count of a leaf; index of the second child and 0 of an inner node (the first child follows).
    first: u32,
    count: u32,
}

/// All facets and panes in a bounding volume hierarchy.
pub(crate) struct ShadowCasters {
    plates: Vec<CasterPlate>,
    nodes: Vec<CasterNode>,
}

/// The lit parts of a ray, in order, and the parts behind panes.
#[derive(Default)]
pub(crate) struct LitIntervals {
    /// Lit intervals of t, m, ascending.
    pub intervals: Vec<(f64, f64)>,
    /// Intervals behind panes: pane and unit normal.
    pub tints: Vec<(f64, f64, u32, Vec3)>,
}

impl LitIntervals {
    /// True where the light reaches the ray.
    pub(crate) fn contains(&self, t: f64) -> bool {
        let k = self.intervals.partition_point(|i| i.1 <= t);
        self.intervals.get(k).is_some_and(|i| i.0 <= t)
    }

    /// The panes, with their unit normals, between the light and the ray at `t`.
    pub(crate) fn panes_at(&self, t: f64) -> Vec<(u32, Vec3)> {
        let between = self.tints.iter().filter(|i| i.0 <= t && t <= i.1);
        between.map(|i| (i.2, i.3)).collect()
    }
}

/// The plane of ray and light with the dual basis that gives t, s and h.
struct EpipolarPlane {
    origin: Vec3,
    alpha: Vec3,
    beta: Vec3,
    gamma: Vec3,
    /// 1 for a light at a point, 0 for a distant one.
    w: f64,
    /// The range of t that is left to search, m.
    lo: f64,
    hi: f64,
    /// The facet of the light, which casts no shadow.
    own: Option<u32>,
}

impl EpipolarPlane {
    fn new(ray: ViewRay, source: &EmissionSample, lo: f64, hi: f64) -> EpipolarPlane {
        let ViewRay { origin, dir } = ray;
        let (e, w, own) = match *source {
            EmissionSample::Distant { direction: towards, .. } => (towards, 0.0, None),
            EmissionSample::Point { position: at, facet, .. } => (at - origin, 1.0, facet.map(|f| f as u32)),
            EmissionSample::Intensity { position: at, .. } => (at - origin, 1.0, None),
        };
        let length = e.length();
        // A ray towards the light spans no plane with it: tilt the direction a little.
        let e = if dir.cross(e).length() < 1e-5 * length { e + dir.frame().0 * (1e-5 * length) } else { e };
        let m = dir.cross(e);
        let scale = 1.0 / m.length2();
        EpipolarPlane {
            origin,
            alpha: e.cross(m) * scale,
            beta: m.cross(dir) * scale,
            gamma: m.normalized(),
            w,
            lo,
            hi,
            own,
        }
    }

    /// True where a box may shadow the range.
    fn intersects(&self, centre: Vec3, half: Vec3) -> bool {
        let c = centre - self.origin;
        let reach = |v: Vec3| v.x.abs() * half.x + v.y.abs() * half.y + v.z.abs() * half.z;
        if self.gamma.dot(c).abs() > reach(self.gamma) {
            return false;
        }
        let s = self.beta.dot(c);
        let span = reach(self.beta);
        if s + span < 0.0 || self.w * (s - span) > 1.0 {
            return false;
        }
        let low = self.alpha + self.beta * (self.w * self.lo);
        let high = self.alpha + self.beta * (self.w * self.hi);
        low.dot(c) + reach(low) >= self.lo && high.dot(c) - reach(high) <= self.hi
    }

    /// The interval of t that a plate shadows.
    fn shadow_interval(&self, plate: &Plate) -> Option<(f64, f64)> {
        let (corners, n) = plate.corners();
        let mut h = [0.0; 4];
        for k in 0..n {
            h[k] = self.gamma.dot(corners[k] - self.origin);
        }
        let mut ends = [[0.0; 2]; 2];
        let mut found = 0;
        for i in 0..n {
            let j = (i + 1) % n;
            if (h[i] > 0.0) != (h[j] > 0.0) && found < 2 {
                let p = corners[i] + (corners[j] - corners[i]) * (h[i] / (h[i] - h[j])) - self.origin;
                ends[found] = [self.alpha.dot(p), self.beta.dot(p)];
                found += 1;
            }
        }
        if found < 2 {
            return None;
        }
        let [a, b] = self.clip(ends[0], ends[1])?;
        let project = |p: [f64; 2]| p[0] / (1.0 - self.w * p[1]);
        let (x, y) = (project(a), project(b));
        let (x, y) = (x.min(y).max(self.lo), x.max(y).min(self.hi));
        (x < y).then_some((x, y))
    }

    /// The part of a segment between the ray (s = 0) and the light (s = 1 for a point).
    fn clip(&self, a: [f64; 2], b: [f64; 2]) -> Option<[[f64; 2]; 2]> {
        let top = if self.w > 0.0 { 1.0 - 1e-9 } else { f64::INFINITY };
        if a[1].max(b[1]) <= 0.0 || a[1].min(b[1]) >= top {
            return None;
        }
        let cut = |p: [f64; 2], q: [f64; 2]| {
            let s = p[1].clamp(0.0, top);
            if s == p[1] { p } else { [p[0] + (q[0] - p[0]) * (s - p[1]) / (q[1] - p[1]), s] }
        };
        Some([cut(a, b), cut(b, a)])
    }
}

impl ShadowCasters {
    /// Builds the hierarchy over all facets and panes.
    pub(crate) fn new(scene: &Scene) -> ShadowCasters {
        let facets = scene.facets().iter().enumerate().map(|(i, f)| (f.plate, CasterKind::Facet(i as u32)));
        let panes = scene.panes().iter().enumerate();
        let panes = panes
            .flat_map(|(i, p)| p.plates.iter().map(move |q| (*q, CasterKind::Pane(i as u32, q.normal()))));
        let mut plates: Vec<CasterPlate> = facets
            .chain(panes)
            .map(|(plate, kind)| {
                let (lo, hi) = plate.bounds();
                CasterPlate { plate, kind, centre: (lo + hi) * 0.5, half: (hi - lo) * 0.5 }
            })
            .collect();
        let mut nodes = Vec::new();
        let pad = Vec3::splat(1e-9 * scene.diagonal());
        if !plates.is_empty() {
            build(&mut plates, 0, pad, &mut nodes);
        }
        ShadowCasters { plates, nodes }
    }

    /// The lit parts of lo < t < hi on the ray.
    pub(crate) fn lit_intervals(
        &self,
        ray: ViewRay,
        source: &EmissionSample,
        lo: f64,
        hi: f64,
    ) -> LitIntervals {
        let mut plane = EpipolarPlane::new(ray, source, lo, hi);
        let mut dark: Vec<(f64, f64)> = Vec::new();
        let mut tints = Vec::new();
        let mut stack = [0u32; 64];
        let mut top = usize::from(!self.nodes.is_empty());
        while top > 0 && plane.lo < plane.hi {
            top -= 1;
            let at = stack[top] as usize;
            let node = &self.nodes[at];
            if !plane.intersects(node.centre, node.half) {
                continue;
            }
            if node.count == 0 {
                (stack[top], stack[top + 1]) = (node.first, at as u32 + 1);
                top += 2;
                continue;
            }
            for caster in &self.plates[node.first as usize..(node.first + node.count) as usize] {
                if matches!(caster.kind, CasterKind::Facet(id) if plane.own == Some(id)) {
                    continue;
                }
                let Some((a, b)) = plane.shadow_interval(&caster.plate) else {
                    continue;
                };
                match caster.kind {
                    CasterKind::Pane(pane, normal) => tints.push((a, b, pane, normal)),
                    CasterKind::Facet(_) if a <= plane.lo => plane.lo = b,
                    CasterKind::Facet(_) if b >= plane.hi => plane.hi = a,
                    CasterKind::Facet(_) => dark.push((a, b)),
                }
            }
        }
        tints.sort_by(|x, y| (x.0, x.2).partial_cmp(&(y.0, y.2)).unwrap_or(std::cmp::Ordering::Equal));
        LitIntervals { intervals: complement(dark, plane.lo, plane.hi), tints }
    }
}

/// The complement of the dark intervals in lo..hi.
fn complement(mut dark: Vec<(f64, f64)>, lo: f64, hi: f64) -> Vec<(f64, f64)> {
    dark.sort_by(|x, y| x.0.total_cmp(&y.0));
    let sliver = 1e-9 * (hi - lo).abs();
    let mut at = lo;
    let mut lit = Vec::new();
    for (a, b) in dark {
        if a > at + sliver {
            lit.push((at, a.min(hi)));
        }
        at = at.max(b);
    }
    if hi > at + sliver {
        lit.push((at, hi));
    }
    lit.retain(|i| i.0 < i.1);
    lit
}

/// Plates of a leaf at most.
const MAX_LEAF_PLATES: usize = 4;

/// Builds the hierarchy by median splits along the axis in which the centres spread most; `first` is the index of the first plate.
fn build(plates: &mut [CasterPlate], first: usize, pad: Vec3, nodes: &mut Vec<CasterNode>) {
    let count = plates.len();
    let inf = Vec3::splat(f64::INFINITY);
    let (mut lo, mut hi, mut clo, mut chi) = (inf, -inf, inf, -inf);
    for i in plates.iter() {
        (lo, hi) = (lo.min(i.centre - i.half), hi.max(i.centre + i.half));
        (clo, chi) = (clo.min(i.centre), chi.max(i.centre));
    }
    let here = nodes.len();
    nodes.push(CasterNode {
        centre: (lo + hi) * 0.5,
        half: (hi - lo) * 0.5 + pad,
        first: first as u32,
        count: count as u32,
    });
    if count <= MAX_LEAF_PLATES {
        return;
    }
    let axis = (chi - clo).largest_axis();
    let middle = count / 2;
    plates.select_nth_unstable_by(middle, |a, b| a.centre[axis].total_cmp(&b.centre[axis]));
    let (left, right) = plates.split_at_mut(middle);
    build(left, first, pad, nodes);
    let second = nodes.len() as u32;
    build(right, first + middle, pad, nodes);
    (nodes[here].first, nodes[here].count) = (second, 0);
}
