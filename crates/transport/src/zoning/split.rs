//! Patches cut along the walls that stand on them.
//!
//! A facet g divides a patch p when it reaches to the front of p's plane and the segment g ∩ plane(p) runs through the inside of
//! p. Every piece that the segment runs through is then halved along the segment's line, so no piece has a wall in its middle.
//! A facet that lies close in front of p (a lamp under a ceiling, a carpet on a floor) divides it along its outline; what lies under
//! its black back is no zone. Small parts are not cut off, but where they, or what is left of them, are hidden: what can be seen of a patch
//! behind a column is a zone of its own, however narrow.

use crate::Transport;
use crate::meet::Prepared;
use zonal_math::Vec3;
use zonal_scene::{Plate, PlateKind, Sides};

/// Pieces below this share of the patch are not cut off.
const LEAST_AREA: f64 = 2e-3;
/// The same for the outline of what lies on it, which need not be cut as sharply.
const LEAST_LYING: f64 = 0.04;
/// The same where one of the parts is hidden for the most part and the other is not: shares of points hidden that differ by so much.
const LEAST_SEEN: f64 = 1e-3;
const APART: f64 = 0.6;
/// A wall shorter than this share of the piece's diameter does not divide it.
const LEAST_LENGTH: f64 = 0.02;
/// A facet within this share of a patch's diameter in front of it lies on it.
const CONTACT: f64 = 0.02;
/// Corners nearer to a plane than this many times [`Transport::epsilon`] lie in it: meshes come in single precision.
const IN_PLANE: f64 = 100.0;
/// Planes of an angle whose cosine is nearer to one look the same way.
const PARALLEL: f64 = 1e-6;
/// No patch is cut into more pieces than this.
const MOST_PIECES: usize = 32;

type Polygon = Vec<Vec3>;

/// A wall's foot in the patch's plane.
struct Foot {
    ends: [Vec3; 2],
    /// Square to the foot, in the patch's plane.
    across: Vec3,
    /// Smallest share of the patch that it may cut off.
    least: f64,
    id: u32,
}

/// The pieces of `plate`, a part of facet `own`, none cut off with less than `smallest` m²; the plate itself when nothing stands on
/// it.
pub(super) fn split(transport: &Transport, own: usize, plate: &Plate, smallest: f64) -> Vec<Plate> {
    let mut feet = feet(transport, own, plate);
    if feet.is_empty() {
        return vec![*plate];
    }
    let length = |f: &Foot| (f.ends[1] - f.ends[0]).length();
    feet.sort_by(|a, b| length(b).total_cmp(&length(a)).then(a.id.cmp(&b.id)));
    let (corners, n) = plate.corners();
    let (normal, area) = (plate.normal(), plate.area());
    let mut pieces: Vec<Polygon> = vec![corners[..n].to_vec()];
    let apart = |a: &Polygon, b: &Polygon| {
        let hidden = |p: &Polygon| {
            let parts = plates(p, normal);
            let sum: f64 = parts.iter().map(|x| x.area() * hidden(transport, own, x)).sum();
            sum / polygon_area(p, normal)
        };
        (hidden(a) - hidden(b)).abs() > APART
    };
    for (foot, again) in feet.iter().map(|f| (f, false)).chain(feet.iter().map(|f| (f, true))) {
        for k in 0..pieces.len() {
            if pieces.len() >= MOST_PIECES || !runs_through(foot, &pieces[k], normal) {
                continue;
            }
            let level = foot.across.dot(foot.ends[0]);
            let (a, b) = (clip(&pieces[k], foot.across, level), clip(&pieces[k], -foot.across, -level));
            let least = polygon_area(&a, normal).min(polygon_area(&b, normal));
            let fair = least > (foot.least * area).max(smallest);
            // Only when all fair cuts are made it shows what is hidden.
            if fair || again && least > LEAST_SEEN * area && apart(&a, &b) {
                pieces[k] = a;
                pieces.push(b);
            }
        }
    }
    if pieces.len() == 1 {
        return vec![*plate];
    }
    pieces.iter().flat_map(|p| plates(p, normal)).collect()
}

fn feet(transport: &Transport, own: usize, plate: &Plate) -> Vec<Foot> {
    let tol = IN_PLANE * transport.epsilon();
    let (lo, hi) = plate.bounds();
    let normal = plate.normal();
    let (corners, n) = plate.corners();
    let contact = CONTACT * plate.diameter();
    let pad = Vec3::splat(contact);
    let mut out = Vec::new();
    for id in transport.facets_near(lo - pad, hi + pad) {
        if id as usize == own {
            continue;
        }
        let wall = &transport.scene().facets()[id as usize].plate;
        let (x, k) = wall.corners();
        let h: Vec<f64> = x[..k].iter().map(|p| (*p - plate.origin).dot(normal)).collect();
        let top = h.iter().fold(f64::MIN, |m, y| m.max(*y));
        let bottom = h.iter().fold(f64::MAX, |m, y| m.min(*y));
        let mut add = |ends: [Vec3; 2], least: f64| {
            let along = (ends[1] - ends[0]).normalized();
            let foot = Foot { ends, across: normal.cross(along), least, id };
            if (ends[1] - ends[0]).length() > tol && runs_through(&foot, &corners[..n], normal) {
                out.push(foot);
            }
        };
        // What stands on the plane divides it where its sides do, not where its foot is made of facets.
        if is_solid(transport, id as usize)
            && top.max(-bottom) <= tol
            && wall.normal().dot(normal) < -1.0 + PARALLEL
        {
            continue;
        }
        if bottom > -tol && top <= contact {
            let down = |i: usize| x[i] - normal * h[i];
            (0..k).for_each(|i| add([down(i), down((i + 1) % k)], LEAST_LYING));
        } else if top > tol
            && bottom <= tol
            && let Some(ends) = crossing(&x[..k], &h, normal.cross(wall.normal()).normalized(), tol)
        {
            add(ends, LEAST_AREA);
        }
    }
    out
}

/// Where a wall with corners at heights `h` meets the plane of height zero: the ends of the segment `along` it.
fn crossing(x: &[Vec3], h: &[f64], along: Vec3, tol: f64) -> Option<[Vec3; 2]> {
    let mut ends: Option<[(f64, Vec3); 2]> = None;
    let mut offer = |p: Vec3| {
        let at = (along.dot(p), p);
        let [a, b] = ends.unwrap_or([at, at]);
        ends = Some([if at.0 < a.0 { at } else { a }, if at.0 > b.0 { at } else { b }]);
    };
    let k = x.len();
    for i in 0..k {
        let j = (i + 1) % k;
        if h[i].abs() <= tol {
            offer(x[i]);
        } else if h[i] * h[j] < 0.0 && h[j].abs() > tol {
            offer(x[i] + (x[j] - x[i]) * (h[i] / (h[i] - h[j])));
        }
    }
    ends.map(|[a, b]| [a.1, b.1])
}

/// True when the foot passes through the inside of the polygon for a fair length.
fn runs_through(foot: &Foot, polygon: &[Vec3], normal: Vec3) -> bool {
    let n = polygon.len();
    let [a, b] = foot.ends;
    let inward: Vec<(Vec3, f64)> = (0..n)
        .map(|i| {
            let m = normal.cross(polygon[(i + 1) % n] - polygon[i]).normalized();
            (m, m.dot(polygon[i]))
        })
        .collect();
    let (mut t0, mut t1) = (0.0f64, 1.0f64);
    for (m, c) in &inward {
        let (ha, hb) = (m.dot(a) - c, m.dot(b) - c);
        if ha < 0.0 && hb < 0.0 {
            return false;
        }
        if ha < 0.0 {
            t0 = t0.max(ha / (ha - hb));
        } else if hb < 0.0 {
            t1 = t1.min(ha / (ha - hb));
        }
    }
    let diameter = polygon.iter().map(|p| (*p - polygon[0]).length()).fold(0.0, f64::max);
    let middle = a + (b - a) * (0.5 * (t0 + t1));
    (t1 - t0) * (b - a).length() > LEAST_LENGTH * diameter
        && inward.iter().all(|(m, c)| m.dot(middle) - c > 1e-6 * diameter)
}

/// The part of the polygon with m·x ≥ level.
fn clip(polygon: &[Vec3], m: Vec3, level: f64) -> Polygon {
    let mut out = Polygon::new();
    for (i, &p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let (hp, hq) = (m.dot(p) - level, m.dot(q) - level);
        if hp >= 0.0 {
            out.push(p);
        }
        if hp * hq < 0.0 {
            out.push(p + (q - p) * (hp / (hp - hq)));
        }
    }
    out
}

fn polygon_area(p: &[Vec3], normal: Vec3) -> f64 {
    (1..p.len().max(1) - 1).map(|i| 0.5 * (p[i] - p[0]).cross(p[i + 1] - p[0]).dot(normal)).sum()
}

/// A convex polygon as triangles, or as the one parallelogram that it is.
fn plates(polygon: &[Vec3], normal: Vec3) -> Vec<Plate> {
    let size = polygon.iter().map(|p| (*p - polygon[0]).length()).fold(0.0, f64::max);
    let mut p = polygon.to_vec();
    p.dedup_by(|a, b| (*a - *b).length() < 1e-9 * size);
    // Corners on a straight edge go.
    let n = p.len();
    let bends = |i: usize| {
        let (a, b, c) = (p[(i + n - 1) % n], p[i], p[(i + 1) % n]);
        (b - a).cross(c - b).dot(normal) > 1e-12 * size * size
    };
    let p: Polygon = (0..n).filter(|&i| bends(i)).map(|i| p[i]).collect();
    let n = p.len();
    if n < 3 {
        return Vec::new();
    }
    if n == 4 && (p[0] - p[1] + p[2] - p[3]).length() < 1e-9 * size {
        return vec![Plate::parallelogram(p[0], p[1] - p[0], p[3] - p[0])];
    }
    // Fan from the corner that makes the smallest triangle largest.
    let fan = |start: usize| {
        (1..n - 1).map({
            let p = &p;
            move |i| Plate::triangle(p[start], p[(start + i) % n], p[(start + i + 1) % n])
        })
    };
    let least = |s: usize| fan(s).map(|t| t.area()).fold(f64::MAX, f64::min);
    let start = (1..n).fold(0, |b, s| if least(s) > least(b) * (1.0 + 1e-9) { s } else { b });
    fan(start).collect()
}

/// True when nothing can see the front of `plate`, a part of facet `own`.
pub(super) fn covered(transport: &Transport, own: usize, plate: &Plate) -> bool {
    hidden(transport, own, plate) == 1.0
}

/// The share of points of `plate`, a part of facet `own`, whose front nothing can see.
fn hidden(transport: &Transport, own: usize, plate: &Plate) -> f64 {
    let at: [[f64; 2]; 4] = match plate.kind {
        PlateKind::Triangle => [[0.33, 0.34], [0.6, 0.2], [0.2, 0.6], [0.2, 0.2]],
        PlateKind::Parallelogram => [[0.51, 0.49], [0.2, 0.25], [0.75, 0.2], [0.3, 0.8]],
    };
    let scene = transport.scene();
    let normal = plate.normal();
    let lift = normal * (1e3 * transport.epsilon());
    let contact = CONTACT * plate.diameter();
    let solid = is_solid(transport, own);
    let behind = |[u, v]: [f64; 2]| {
        let p = plate.at(u, v);
        // The black back of something that lies on it; a thin gap between two zones is a gap.
        let black = |h: crate::Hit| {
            let s = &scene.surfaces()[scene.facets()[h.facet].surface];
            !h.front && s.sides == Sides::Front
        };
        let under = transport.nearest(p, normal, transport.epsilon(), contact).is_some_and(black);
        under
            || transport.inside_solid(p + lift)
            || (solid && against_another(transport, own, plate, p) && transport.inside_solid(p - lift))
    };
    at.into_iter().filter(|uv| behind(*uv)).count() as f64 / at.len() as f64
}

/// True where the facet belongs to a closed body.
fn is_solid(transport: &Transport, facet: usize) -> bool {
    let scene = transport.scene();
    scene.surfaces()[scene.facets()[facet].surface].solid
}

/// True when a facet that looks the other way lies at `p` of the plate: a box that stands on a floor.
fn against_another(transport: &Transport, own: usize, plate: &Plate, p: Vec3) -> bool {
    let tol = IN_PLANE * transport.epsilon();
    let pad = Vec3::splat(tol);
    let near = transport.facets_near(p - pad, p + pad);
    near.into_iter().filter(|&id| id as usize != own).any(|id| {
        let other = &transport.scene().facets()[id as usize].plate;
        let flat = Prepared::new(other).height(p).abs() <= tol;
        let opposite = other.normal().dot(plate.normal()) < -1.0 + PARALLEL;
        let [u, v] = other.parameters(p);
        let within = match other.kind {
            PlateKind::Triangle => u >= 0.0 && v >= 0.0 && u + v <= 1.0,
            PlateKind::Parallelogram => (0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v),
        };
        flat && opposite && within
    })
}
