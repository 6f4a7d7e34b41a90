//! Critical segments: lines on the plane of the outer polygon across which the visible part of the inner polygon changes its topology.
//!
//! From x, a corner near to x and an edge behind it (or the other way round) coincide if x lies on the shadow of the edge cast by the
//! corner. Among the inner polygon b and the obstructions o the far one is either b or o, the near one always an obstruction:
//!
//! - far corner v, near edge pq: x = v + (p − v) h(v)/(h(v) − h(p)), h the height over the plane of x, and so for q; h(v) > h(p).
//! - far edge pq, near corner w: x = p + (w − p) h(p)/(h(p) − h(w)).
//!
//! Ends of edges that do not fulfil the inequality cast no shadow: the edge is cut short of them.

use super::convex_polygon::{ConvexPolygon, RELATIVE_CONTACT_DISTANCE};
use zonal_math::Vec3;

/// Relative difference of heights below which a shadow is too far away to matter.
const MIN_RELATIVE_HEIGHT_GAP: f64 = 1e-7;

/// A critical segment on the plane of the outer polygon.
#[derive(Clone, Copy, Debug)]
pub(super) struct CriticalSegment {
    from: Vec3,
    to: Vec3,
    /// Normal of the plane that contains it and stands on the outer polygon.
    across: Vec3,
    /// True for a shadow that one obstruction casts by itself.
    pub(super) first: bool,
}

/// All critical segments that cross `a`: of the view of `b` past `obstructions`.
pub(super) fn critical_segments(
    a: &ConvexPolygon,
    b: &ConvexPolygon,
    obstructions: &[ConvexPolygon],
) -> Vec<CriticalSegment> {
    let mut out = Vec::new();
    for (k, near) in obstructions.iter().enumerate() {
        add_shadows(a, b, near, true, &mut out);
        for (j, far) in obstructions.iter().enumerate() {
            if j != k {
                add_shadows(a, far, near, false, &mut out);
            }
        }
    }
    out.sort_by_key(|s| !s.first);
    out
}

fn add_shadows(
    a: &ConvexPolygon,
    far: &ConvexPolygon,
    near: &ConvexPolygon,
    first: bool,
    out: &mut Vec<CriticalSegment>,
) {
    let mut offer = |p: Option<(Vec3, Vec3)>| {
        if let Some((from, to)) = p
            && let Some(s) = CriticalSegment::new(a, from, to, first)
        {
            out.push(s);
        }
    };
    for v in &far.corners {
        edges(near).for_each(|(p, q)| offer(shadow_of_near_edge(a, *v, p, q)));
    }
    for w in &near.corners {
        edges(far).for_each(|(p, q)| offer(shadow_past_corner(a, *w, p, q)));
    }
}

fn edges(p: &ConvexPolygon) -> impl Iterator<Item = (Vec3, Vec3)> + '_ {
    let n = p.corners.len();
    (0..n).map(move |k| (p.corners[k], p.corners[(k + 1) % n]))
}

/// The point of the plane of `a` on the line from `far` through `near`.
fn project(a: &ConvexPolygon, far: Vec3, near: Vec3) -> Vec3 {
    let (h, g) = (a.height(far), a.height(near));
    far + (near - far) * (h / (h - g))
}

fn shadow_of_near_edge(a: &ConvexPolygon, far: Vec3, p: Vec3, q: Vec3) -> Option<(Vec3, Vec3)> {
    let most = a.height(far) * (1.0 - MIN_RELATIVE_HEIGHT_GAP);
    let (p, q) = shortened(p, q, most - a.height(p), most - a.height(q))?;
    Some((project(a, far, p), project(a, far, q)))
}

fn shadow_past_corner(a: &ConvexPolygon, near: Vec3, p: Vec3, q: Vec3) -> Option<(Vec3, Vec3)> {
    let least = a.height(near).max(0.0) * (1.0 + MIN_RELATIVE_HEIGHT_GAP);
    let (p, q) = shortened(p, q, a.height(p) - least, a.height(q) - least)?;
    Some((project(a, p, near), project(a, q, near)))
}

/// The part of pq on which a linear function with values f(p), f(q) is positive.
fn shortened(p: Vec3, q: Vec3, fp: f64, fq: f64) -> Option<(Vec3, Vec3)> {
    let (keeps_p, keeps_q) = (fp > 0.0, fq > 0.0);
    let zero = || p + (q - p) * (fp / (fp - fq));
    (keeps_p || keeps_q).then(|| (if keeps_p { p } else { zero() }, if keeps_q { q } else { zero() }))
}

impl CriticalSegment {
    /// None if it has no length or misses the inside of `a`.
    fn new(a: &ConvexPolygon, from: Vec3, to: Vec3, first: bool) -> Option<CriticalSegment> {
        let d = to - from;
        let across = a.normal.cross(d).normalized();
        let s = CriticalSegment { from, to, across, first };
        (d.is_finite() && across.length2() > 0.0 && s.crosses(&a.corners)).then_some(s)
    }

    /// True if a part of the segment of significant length lies inside a convex polygon.
    pub(super) fn crosses(&self, corners: &[Vec3]) -> bool {
        let n = corners.len();
        let d = self.to - self.from;
        let size = corners.iter().fold(0.0f64, |s, c| s.max((*c - corners[0]).length()));
        let h: Vec<f64> = corners.iter().map(|c| self.across.dot(*c - self.from)).collect();
        // A segment along an edge does not cross: some corner must lie clear of the line on each side.
        let clear = 1e-7 * size;
        if h.iter().all(|x| *x < clear) || h.iter().all(|x| *x > -clear) {
            return false;
        }
        // The stretch of the line inside: between its two crossings of the boundary.
        let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
        for i in 0..n {
            let j = (i + 1) % n;
            if (h[i] >= 0.0) != (h[j] >= 0.0) {
                let x = corners[i] + (corners[j] - corners[i]) * (h[i] / (h[i] - h[j]));
                let t = (x - self.from).dot(d) / d.length2();
                (lo, hi) = (lo.min(t), hi.max(t));
            }
        }
        (hi.min(1.0) - lo.max(0.0)) * d.length() > RELATIVE_CONTACT_DISTANCE.sqrt() * size
    }

    /// The triangles that the line of the segment makes of a triangle, if the segment crosses it.
    pub(super) fn cut(&self, t: &[Vec3; 3]) -> Option<Vec<[Vec3; 3]>> {
        if !self.crosses(t) {
            return None;
        }
        let h = t.map(|c| self.across.dot(c - self.from));
        let meet = |i: usize, j: usize| t[i] + (t[j] - t[i]) * (h[i] / (h[i] - h[j]));
        // A corner on the line to within rounding would leave a sliver: the line is moved through it.
        let size = (0..3).fold(0.0f64, |s, k| s.max((t[(k + 1) % 3] - t[k]).length()));
        if let Some(k) = (0..3).find(|k| h[*k].abs() < 1e-9 * size) {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let m = meet(i, j);
            return Some(vec![[t[k], t[i], m], [t[k], m, t[j]]]);
        }
        // The corner that is alone on its side.
        let k = (0..3)
            .find(|k| (h[*k] > 0.0) != (h[(k + 1) % 3] > 0.0) && (h[*k] > 0.0) != (h[(k + 2) % 3] > 0.0))?;
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let (m, n) = (meet(k, i), meet(k, j));
        Some(vec![[t[k], m, n], [m, t[i], t[j]], [m, t[j], n]])
    }
}
