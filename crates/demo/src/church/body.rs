//! Bodies of convex cells, cut by planes and closed again.
//!
//! A plane n·x = level divides a convex cell; the part with n·x ≥ level gets the section as a new face. Points where an edge is cut are computed
//! from its ends in one order, so that the faces on both sides of the edge, and the sections of neighbouring cells, share them to the bit.

use zonal_math::Vec3;

/// A convex cell by its faces, each with a point in front of it; `None` where the next cell touches it.
pub(super) type ConvexCell = Vec<(Vec<Vec3>, Option<Vec3>)>;

/// Points closer to a plane than this, m, are on it.
const PLANE_TOLERANCE: f64 = 1e-9;

/// The part of a cell with n·x ≥ level, closed; `None` where nothing is left.
pub(super) fn cut_by_plane(cell: ConvexCell, n: Vec3, level: f64) -> Option<ConvexCell> {
    let height = |p: Vec3| {
        let h = n.dot(p) - level;
        if h.abs() < PLANE_TOLERANCE { 0.0 } else { h }
    };
    let all = |f: &dyn Fn(f64) -> bool| cell.iter().all(|(face, _)| face.iter().all(|p| f(height(*p))));
    if all(&|h| h >= 0.0) {
        return Some(cell);
    }
    if all(&|h| h <= 0.0) {
        return None;
    }
    let mut section: Vec<Vec3> = Vec::new();
    let mut out = ConvexCell::new();
    for (face, front) in cell {
        let mut kept = Vec::with_capacity(face.len() + 1);
        for (i, &p) in face.iter().enumerate() {
            let q = face[(i + 1) % face.len()];
            let (hp, hq) = (height(p), height(q));
            if hp >= 0.0 {
                kept.push(p);
            }
            if hp == 0.0 {
                section.push(p);
            }
            if hp * hq < 0.0 {
                let (a, b, ha, hb) = if p.array() < q.array() { (p, q, hp, hq) } else { (q, p, hq, hp) };
                let x = a + (b - a) * (ha / (ha - hb));
                kept.push(x);
                section.push(x);
            }
        }
        if kept.len() > 2 {
            out.push((kept, front));
        }
    }
    let section = in_order(section, n);
    if section.len() > 2 {
        let front = section[0] - n;
        out.push((section, Some(front)));
    }
    Some(out)
}

/// The corners of a convex polygon in order about its middle, each once.
fn in_order(mut points: Vec<Vec3>, n: Vec3) -> Vec<Vec3> {
    let middle = points.iter().fold(Vec3::ZERO, |s, &p| s + p) / points.len().max(1) as f64;
    let Some(first) = points.iter().copied().find(|p| (*p - middle).length() > PLANE_TOLERANCE) else {
        return Vec::new();
    };
    let x = (first - middle).normalized();
    let y = n.cross(x);
    let angle = |p: &Vec3| (*p - middle).dot(y).atan2((*p - middle).dot(x));
    points.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    points.dedup_by(|a, b| (*a - *b).length() < PLANE_TOLERANCE);
    while points.len() > 1 && (points[0] - points[points.len() - 1]).length() < PLANE_TOLERANCE {
        points.pop();
    }
    points
}
