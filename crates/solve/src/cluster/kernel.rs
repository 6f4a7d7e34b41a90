//! The kernel between two clusters to second order (Taylor expansion about the centroids, as in clustering methods of radiosity).
//!
//! With t = y − x from the centroid of cluster i to that of j, r = |t|, the mean normals n_i, n_j and the extinction κ along t,
//!
//! ```text
//! K(t) = g_i g_j e^{−κr} / (π r²)          g = 1 for volumes, n_i·t/r at i and −n_j·t/r at j for patches
//! L = ∇ln K = −(p/r² + κ/r) t + n_i/(n_i·t) + n_j/(n_j·t)          p = 2 + number of patches
//! ∇L = −(p/r² + κ/r) 1 + (2p/r⁴ + κ/r³) t tᵀ − n_i n_iᵀ/(n_i·t)² − n_j n_jᵀ/(n_j·t)²
//! ```
//!
//! Displacing the ends by δ_i and δ_j changes K by the fraction L·(δ_j − δ_i) to first order: the **gradient** that a link carries. The
//! mean over both clusters is K (1 + c) with c = ½ tr[(C_i + C_j)(L Lᵀ + ∇L)] to second order. The remainder at i is of the size
//! q_i = Lᵀ C_i L, the squared relative variation of the kernel over i, or, where the gradient vanishes, p tr C_i/(2r²); the error of the
//! mean is about c².
//!
//! The expansion is symmetric: exchanging i and j reverses t and L and leaves the rest. A pair that is too close, or in which a plane of
//! one cluster cuts the other, has no such expansion and is of **zeroth order**: one number, no gradient.

use super::tree::{ClusterKind, ClusterNode};
use std::f64::consts::PI;
use zonal_math::Vec3;

/// Where the expansion is used. Figures with these values: `cargo run --release --example against_dense -- c0 c9 c8 --dense 0.003`
/// (`docs/hierarchical.md`).
struct ExpansionParams {
    /// Smallest cosine between a mean normal and t.
    min_cosine: f64,
    /// Smallest distance over the sum of the radii.
    min_distance_over_radii: f64,
    /// Range of the second-order correction c.
    correction_range: [f64; 2],
}

const EXPANSION_PARAMS: ExpansionParams =
    ExpansionParams { min_cosine: 0.05, min_distance_over_radii: 1.0, correction_range: [-0.5, 1.0] };

/// Heights over the plane of a cluster that are zero within rounding: over the sum of the radii of both clusters, and over the largest
/// coordinate in single precision.
const HEIGHT_ROUNDING: [f64; 2] = [1e-5, 3e-7];
/// Sine of the cone of normals below which a cluster is planar.
const PLANAR_CONE_SINE: f32 = 1e-4;
/// Half thickness of a planar cluster, in standard deviations along its normal.
const THICKNESS_IN_DEVIATIONS: f64 = 4.0;

/// Relative position of two clusters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairGeometry {
    /// t, m.
    pub t: Vec3,
    /// r, m.
    pub r: f64,
    /// n_i·t and −n_j·t, m; 1 for volumes.
    pub heights: [f64; 2],
    /// g_i g_j/(π r²), 1/m².
    pub geometric_kernel: f64,
    /// True where the expansion does not apply.
    pub zeroth_order: bool,
}

/// The height n·t of a patch or pane cluster; 1 for volumes.
#[inline]
fn height(kind: ClusterKind, n: Vec3, t: Vec3) -> f64 {
    match kind {
        ClusterKind::Patch => n.dot(t),
        ClusterKind::Pane => n.dot(t).abs(),
        _ => 1.0,
    }
}

/// The part of a node that the kernel depends on: 36 bytes, for the passes over all links.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CompactNode {
    /// Centroid, m.
    pub centre: [f32; 3],
    /// Mean normal.
    pub normal: [f32; 3],
    /// Half diagonal of the box, m.
    pub radius: f32,
    /// Extinction, 1/m.
    pub extinction: f32,
    /// ClusterKind of the leaves.
    pub kind: ClusterKind,
}

impl CompactNode {
    /// Copies the fields of a node.
    pub(crate) fn of(n: &ClusterNode) -> CompactNode {
        let (radius, extinction) = (n.radius() as f32, n.extinction);
        CompactNode { centre: n.centre, normal: n.normal, radius, extinction, kind: n.kind }
    }
    #[inline]
    fn centre_and_normal(&self) -> (Vec3, Vec3) {
        let v = |x: [f32; 3]| Vec3::from_array(x.map(|c| c as f64));
        (v(self.centre), v(self.normal))
    }
}

impl PairGeometry {
    /// Of two clusters.
    #[inline]
    pub(crate) fn new(a: &CompactNode, b: &CompactNode) -> PairGeometry {
        let ((ca, na), (cb, nb)) = (a.centre_and_normal(), b.centre_and_normal());
        let t = cb - ca;
        let r2 = t.length2();
        let r = r2.sqrt();
        let heights = [height(a.kind, na, t), height(b.kind, nb, -t)];
        let mut geometric_kernel = 1.0 / (PI * r2.max(1e-300));
        let mut zeroth_order = r < EXPANSION_PARAMS.min_distance_over_radii * (a.radius + b.radius) as f64;
        for (kind, h) in [(a.kind, heights[0]), (b.kind, heights[1])] {
            if matches!(kind, ClusterKind::Patch | ClusterKind::Pane) {
                geometric_kernel *= (h / r.max(1e-300)).max(0.0);
                zeroth_order |= h < EXPANSION_PARAMS.min_cosine * r;
            }
        }
        zeroth_order |= a.kind == ClusterKind::Mixed || b.kind == ClusterKind::Mixed;
        PairGeometry { t, r, heights, geometric_kernel, zeroth_order }
    }

    /// L for the extinction `kappa`, 1/m; zero for a pair of zeroth order.
    #[inline]
    pub(crate) fn gradient(&self, a: &CompactNode, b: &CompactNode, kappa: f64) -> Vec3 {
        if self.zeroth_order {
            return Vec3::ZERO;
        }
        let (r2, mut p) = (self.r * self.r, 2.0);
        let mut l = Vec3::ZERO;
        let (na, nb) = (a.centre_and_normal().1, b.centre_and_normal().1);
        for (kind, n, h) in [(a.kind, na, self.heights[0]), (b.kind, -nb, self.heights[1])] {
            match kind {
                ClusterKind::Patch => {
                    p += 1.0;
                    l += n / h;
                }
                // A pane exchanges on both sides: |n·t|.
                ClusterKind::Pane => {
                    p += 1.0;
                    l += n * (n.dot(self.t).signum() / h);
                }
                _ => {}
            }
        }
        l - self.t * (p / r2 + kappa / self.r)
    }
}

/// vᵀ C v.
#[inline]
fn quadratic_form(c: &[f32; 6], v: Vec3) -> f64 {
    let c = c.map(|x| x as f64);
    v.x * (c[0] * v.x + 2.0 * (c[3] * v.y + c[4] * v.z))
        + v.y * (c[1] * v.y + 2.0 * c[5] * v.z)
        + v.z * c[2] * v.z
}

/// Second-order terms of a pair.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SecondOrderTerms {
    /// Variation of the kernel over i and over j beyond the gradient: max(q, p tr C/(2 r²)).
    pub variation: [f64; 2],
    /// c, not limited.
    pub correction: f64,
    /// 1 + c within its range: the mean over both clusters relative to the value at the centroids.
    pub mean_factor: f64,
}

impl SecondOrderTerms {
    /// Of two clusters of a pair that is not of zeroth order, with its gradient `l`.
    pub(crate) fn new(
        geometry: &PairGeometry,
        a: &ClusterNode,
        b: &ClusterNode,
        l: Vec3,
        kappa: f64,
    ) -> SecondOrderTerms {
        let (t, r) = (geometry.t, geometry.r);
        let r2 = r * r;
        let q = [quadratic_form(&a.covariance, l), quadratic_form(&b.covariance, l)];
        let p = 2.0 + [a, b].iter().filter(|n| n.kind != ClusterKind::Voxel).count() as f64;
        let trace = |n: &ClusterNode| (n.covariance[0] + n.covariance[1] + n.covariance[2]) as f64;
        let mut c = 0.0;
        for n in [a, b] {
            c -= (p / r2 + kappa / r) * trace(n);
            c += (2.0 * p / (r2 * r2) + kappa / (r2 * r)) * quadratic_form(&n.covariance, t);
            for (m, h) in [(a, geometry.heights[0]), (b, geometry.heights[1])] {
                if m.kind != ClusterKind::Voxel {
                    c -= quadratic_form(&n.covariance, m.normal()) / (h * h);
                }
            }
        }
        let c = 0.5 * (c + q[0] + q[1]);
        let isotropic = |n: &ClusterNode| 0.5 * p / r2 * trace(n);
        let variation = [q[0].max(isotropic(a)), q[1].max(isotropic(b))];
        let [least, most] = EXPANSION_PARAMS.correction_range;
        SecondOrderTerms { variation, correction: c, mean_factor: 1.0 + c.clamp(least, most) }
    }
}

/// True where `high`, the upper end of [`height_range`], is zero within rounding: cluster j lies in the plane of i or behind it.
pub(crate) fn is_behind(i: &ClusterNode, j: &ClusterNode, high: f64) -> bool {
    high <= HEIGHT_ROUNDING[0] * (i.radius() + j.radius())
        + HEIGHT_ROUNDING[1] * i.hi.max_abs().max(i.lo.max_abs())
}

/// Lowest and highest height of cluster j over the planes of i, n·(y − x) over both boxes with a unit normal, widened by the cone of the
/// normals of i, m.
pub(crate) fn height_range(i: &ClusterNode, j: &ClusterNode) -> [f64; 2] {
    let n = i.normal().normalized();
    if i.cone_sine > 1.0 || n == Vec3::ZERO {
        return [f64::NEG_INFINITY, f64::INFINITY];
    }
    // The box of a planar cluster has no extent along the normal.
    let planar = i.is_leaf() || i.cone_sine < PLANAR_CONE_SINE;
    let (centre, mut far) = (i.centre(), 0.0f64);
    let thick = if planar && !i.is_leaf() {
        quadratic_form(&i.covariance, n).max(0.0).sqrt() * THICKNESS_IN_DEVIATIONS
    } else {
        0.0
    };
    let (mut low, mut high) = (0.0, 0.0);
    for k in 0..3 {
        let (l, h) = (j.lo[k] - i.hi[k], j.hi[k] - i.lo[k]);
        far += l.abs().max(h.abs()).powi(2);
        let (l, h) = if planar { (j.lo[k] - centre[k], j.hi[k] - centre[k]) } else { (l, h) };
        let (x, y) = (n[k] * l, n[k] * h);
        low += x.min(y);
        high += x.max(y);
    }
    let tilt = i.cone_sine as f64 * far.sqrt();
    [low - thick - tilt, high + thick + tilt]
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    fn compact_node(c: Vec3, n: Vec3, kind: ClusterKind) -> CompactNode {
        let f = |v: Vec3| v.array().map(|x| x as f32);
        CompactNode { centre: f(c), normal: f(n), radius: 0.1, extinction: 0.0, kind }
    }

    /// ln K at the centres moved by d.
    fn log_kernel(a: &CompactNode, b: &CompactNode, d: Vec3, kappa: f64) -> f64 {
        let (na, nb) = (a.centre_and_normal().1, b.centre_and_normal().1);
        let t = b.centre_and_normal().0 - a.centre_and_normal().0 + d;
        let r = t.length();
        let g = |k: ClusterKind, h: f64| if k == ClusterKind::Voxel { 1.0 } else { h / r };
        (g(a.kind, height(a.kind, na, t)) * g(b.kind, height(b.kind, nb, -t)) / (r * r)).ln() - kappa * r
    }

    #[test]
    fn gradient_is_that_of_the_log_kernel_and_antisymmetric() {
        let kinds = [ClusterKind::Voxel, ClusterKind::Patch, ClusterKind::Pane];
        for ka in kinds {
            for kb in kinds {
                let a = compact_node(Vec3::ZERO, vec3(0.6, 0.0, 0.8), ka);
                let b = compact_node(vec3(1.0, 2.0, 3.0), vec3(-0.6, -0.64, -0.48), kb);
                let kappa = 0.7;
                let p = PairGeometry::new(&a, &b);
                assert!(!p.zeroth_order, "{ka:?} {kb:?}");
                let l = p.gradient(&a, &b, kappa);
                let back = PairGeometry::new(&b, &a).gradient(&b, &a, kappa);
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
