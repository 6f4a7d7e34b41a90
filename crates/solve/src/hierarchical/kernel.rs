//! The kernel between two clusters, to second order.
//!
//! With t = y − x from the centre of cluster i to that of j, r = |t|, the mean normals n_i, n_j and the extinction κ along t,
//!
//! ```text
//! K(t) = g_i g_j e^{−κr} / (π r²)          g = 1 for volumes, n_i·t/r at i and −n_j·t/r at j for patches
//! L = ∇ln K = −(p/r² + κ/r) t + n_i/(n_i·t) + n_j/(n_j·t)          p = 2 + number of patches
//! ∇L = −(p/r² + κ/r) 1 + (2p/r⁴ + κ/r³) t tᵀ − n_i n_iᵀ/(n_i·t)² − n_j n_jᵀ/(n_j·t)²
//! ```
//!
//! Moving the ends by δ_j − δ_i changes K by the share L·(δ_j − δ_i) to first order: the **gradient** that a link carries. The mean over
//! both clusters is K (1 + c) with c = ½ tr[(C_i + C_j)(L Lᵀ + ∇L)] to second order. What is left at i is of the size
//! q_i = Lᵀ C_i L, the squared relative variation of the kernel over i, or, where the gradient vanishes, p tr C_i/(2r²), what second
//! order varies by; the mean itself is left with an error of about c².
//!
//! All of it is symmetric: exchanging i and j turns t and L round and leaves the rest. A pair that is too close, or where a plane
//! of one cuts the other, has no such expansion; it is **flat**: one number, no gradient.

use super::tree::{Kind, Node};
use std::f64::consts::PI;
use zonal_math::Vec3;

/// Cosine of a mean normal below which the expansion is not used.
const GRAZING: f64 = 0.05;
/// A pair is near when the distance is below this times the sum of the radii.
const NEAR: f64 = 1.0;
/// Range of the second-order share c.
const CURVATURE: [f64; 2] = [-0.5, 1.0];

/// What a link needs of the place of two clusters.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// t, m.
    pub t: Vec3,
    /// r, m.
    pub r: f64,
    /// n_i·t and −n_j·t, m; 1 for volumes.
    pub along: [f64; 2],
    /// g_i g_j/(π r²), 1/m².
    pub geometry: f64,
    /// No expansion.
    pub flat: bool,
}

/// The height n·t of a patch or pane cluster over its distance; 1 for volumes.
#[inline]
fn along(kind: Kind, n: Vec3, t: Vec3) -> f64 {
    match kind {
        Kind::Patch => n.dot(t),
        Kind::Pane => n.dot(t).abs(),
        _ => 1.0,
    }
}

/// A cluster as the kernel sees it: 36 bytes, for the sweeps over all links.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    /// Centroid, m.
    pub centre: [f32; 3],
    /// Mean normal.
    pub normal: [f32; 3],
    /// Half diagonal of the box, m.
    pub radius: f32,
    /// Extinction, 1/m.
    pub kappa: f32,
    /// Kind.
    pub kind: Kind,
}

impl Spot {
    /// What the kernel needs of a node.
    pub fn of(n: &Node) -> Spot {
        Spot { centre: n.centre, normal: n.normal, radius: n.radius() as f32, kappa: n.kappa, kind: n.kind }
    }
    #[inline]
    fn place(&self) -> (Vec3, Vec3) {
        let v = |x: [f32; 3]| Vec3::from_array(x.map(|c| c as f64));
        (v(self.centre), v(self.normal))
    }
}

impl Place {
    /// Two clusters.
    #[inline]
    pub fn new(a: &Spot, b: &Spot) -> Place {
        let ((ca, na), (cb, nb)) = (a.place(), b.place());
        let t = cb - ca;
        let r2 = t.length2();
        let r = r2.sqrt();
        let along = [along(a.kind, na, t), along(b.kind, nb, -t)];
        let mut geometry = 1.0 / (PI * r2.max(1e-300));
        let mut flat = r < NEAR * (a.radius + b.radius) as f64;
        for (kind, h) in [(a.kind, along[0]), (b.kind, along[1])] {
            if matches!(kind, Kind::Patch | Kind::Pane) {
                geometry *= (h / r.max(1e-300)).max(0.0);
                flat |= h < GRAZING * r;
            }
        }
        flat |= a.kind == Kind::Mixed || b.kind == Kind::Mixed;
        Place { t, r, along, geometry, flat }
    }

    /// L for the extinction `kappa`; zero for a flat pair.
    #[inline]
    pub fn gradient(&self, a: &Spot, b: &Spot, kappa: f64) -> Vec3 {
        if self.flat {
            return Vec3::ZERO;
        }
        let (r2, mut p) = (self.r * self.r, 2.0);
        let mut l = Vec3::ZERO;
        let (na, nb) = (a.place().1, b.place().1);
        for (kind, n, h) in [(a.kind, na, self.along[0]), (b.kind, -nb, self.along[1])] {
            match kind {
                Kind::Patch => {
                    p += 1.0;
                    l += n / h;
                }
                // Seen from both sides: |n·t|.
                Kind::Pane => {
                    p += 1.0;
                    l += n * (n.dot(self.t).signum() / h);
                }
                _ => {}
            }
        }
        l - self.t * (p / r2 + kappa / self.r)
    }
}

#[inline]
fn form(c: &[f32; 6], v: Vec3) -> f64 {
    let c = c.map(|x| x as f64);
    v.x * (c[0] * v.x + 2.0 * (c[3] * v.y + c[4] * v.z))
        + v.y * (c[1] * v.y + 2.0 * c[5] * v.z)
        + v.z * c[2] * v.z
}

/// Second-order quantities of a pair.
#[derive(Clone, Copy, Debug)]
pub struct Curve {
    /// What varies of the kernel over i and over j beyond the gradient: max(q, p tr C/(2 r²)).
    pub q: [f64; 2],
    /// c, not limited.
    pub curvature: f64,
    /// 1 + c, the mean over both clusters relative to the centres.
    pub mean: f64,
}

impl Curve {
    /// Of two clusters that are not flat to each other.
    pub fn new(place: &Place, a: &Node, b: &Node, l: Vec3, kappa: f64) -> Curve {
        let (t, r) = (place.t, place.r);
        let r2 = r * r;
        let q = [form(&a.spread, l), form(&b.spread, l)];
        let p = 2.0 + [a, b].iter().filter(|n| n.kind != Kind::Voxel).count() as f64;
        let mut c = 0.0;
        for n in [a, b] {
            let trace = (n.spread[0] + n.spread[1] + n.spread[2]) as f64;
            c -= (p / r2 + kappa / r) * trace;
            c += (2.0 * p / (r2 * r2) + kappa / (r2 * r)) * form(&n.spread, t);
            for (m, h) in [(a, place.along[0]), (b, place.along[1])] {
                if m.kind != Kind::Voxel {
                    c -= form(&n.spread, m.normal()) / (h * h);
                }
            }
        }
        let c = 0.5 * (c + q[0] + q[1]);
        let even = |n: &Node| 0.5 * p / r2 * (n.spread[0] + n.spread[1] + n.spread[2]) as f64;
        let q = [q[0].max(even(a)), q[1].max(even(b))];
        Curve { q, curvature: c, mean: 1.0 + c.clamp(CURVATURE[0], CURVATURE[1]) }
    }
}

/// Heights below this share of the sizes of two clusters, and of their coordinates in single precision, are none.
const LEVEL: [f64; 2] = [1e-5, 3e-7];

/// True where `high`, the highest of [`heights`], is nothing: the other cluster lies in the plane of the one or behind it.
pub fn is_behind(i: &Node, j: &Node, high: f64) -> bool {
    high <= LEVEL[0] * (i.radius() + j.radius()) + LEVEL[1] * i.hi.max_abs().max(i.lo.max_abs())
}

/// Lowest and highest n·(y − x) over two boxes, relative to n's length; the cone of i's normals widens both.
pub fn heights(i: &Node, j: &Node) -> [f64; 2] {
    let n = i.normal().normalized();
    if i.cone > 1.0 || n == Vec3::ZERO {
        return [f64::NEG_INFINITY, f64::INFINITY];
    }
    // Of a flat cluster the box adds nothing along the normal.
    let flat = i.is_leaf() || i.cone < 1e-4;
    let (centre, mut far) = (i.centre(), 0.0f64);
    let thick = if flat && !i.is_leaf() { form(&i.spread, n).max(0.0).sqrt() * 4.0 } else { 0.0 };
    let (mut low, mut high) = (0.0, 0.0);
    for k in 0..3 {
        let (l, h) = (j.lo[k] - i.hi[k], j.hi[k] - i.lo[k]);
        far += l.abs().max(h.abs()).powi(2);
        let (l, h) = if flat { (j.lo[k] - centre[k], j.hi[k] - centre[k]) } else { (l, h) };
        let (x, y) = (n[k] * l, n[k] * h);
        low += x.min(y);
        high += x.max(y);
    }
    let tilt = i.cone as f64 * far.sqrt();
    [low - thick - tilt, high + thick + tilt]
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    fn spot(c: Vec3, n: Vec3, kind: Kind) -> Spot {
        let f = |v: Vec3| v.array().map(|x| x as f32);
        Spot { centre: f(c), normal: f(n), radius: 0.1, kappa: 0.0, kind }
    }

    /// ln K at the centres moved by d.
    fn log_kernel(a: &Spot, b: &Spot, d: Vec3, kappa: f64) -> f64 {
        let (na, nb) = (a.place().1, b.place().1);
        let t = b.place().0 - a.place().0 + d;
        let r = t.length();
        let g = |k: Kind, h: f64| if k == Kind::Voxel { 1.0 } else { h / r };
        (g(a.kind, along(a.kind, na, t)) * g(b.kind, along(b.kind, nb, -t)) / (r * r)).ln() - kappa * r
    }

    #[test]
    fn the_gradient_is_that_of_the_logarithm_and_turns_with_the_pair() {
        let kinds = [Kind::Voxel, Kind::Patch, Kind::Pane];
        for ka in kinds {
            for kb in kinds {
                let a = spot(Vec3::ZERO, vec3(0.6, 0.0, 0.8), ka);
                let b = spot(vec3(1.0, 2.0, 3.0), vec3(-0.6, -0.64, -0.48), kb);
                let kappa = 0.7;
                let p = Place::new(&a, &b);
                assert!(!p.flat, "{ka:?} {kb:?}");
                let l = p.gradient(&a, &b, kappa);
                let back = Place::new(&b, &a).gradient(&b, &a, kappa);
                assert!((l + back).length() < 1e-12);
                let h = 1e-5;
                for k in 0..3 {
                    let mut d = [0.0; 3];
                    d[k] = h;
                    let d = Vec3::from_array(d);
                    let slope = (log_kernel(&a, &b, d, kappa) - log_kernel(&a, &b, -d, kappa)) / (2.0 * h);
                    assert!((slope - l[k]).abs() < 1e-6, "{ka:?} {kb:?} {k}: {slope} {}", l[k]);
                }
            }
        }
    }
}
