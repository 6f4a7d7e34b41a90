//! Node values from zone means: the interpolation that surfaces and medium share.
//!
//! A zone i has a mean B_i at its centre c_i and a gradient g_i, the weighted least-squares fit to its neighbours (weights 1/d²). The
//! value at a node V is taken over the zones S that touch it (weights w_i, Σ w_i = 1; bars are weighted means):
//!
//! ```text
//! B(V) = B̄ + ḡ·(V − c̄) + ⅔ Σ w_i (g_i − ḡ)·(V − c_i)
//! ```
//!
//! The first term is the average. The second makes the value exact for linear fields, also at borders, where S lies on one side only.
//! The third removes the leading curvature error of an average (for equal zones in a row it is the stencil (−1, 7, 7, −1)/12 for
//! means). The result is limited to one range beyond the values of the zones and their neighbours, and is not negative.

use zonal_math::Vec3;
use zonal_scene::{Bands, PerBand};

/// One gradient a band.
pub(crate) type BandGradients = PerBand<Vec3>;

/// Normal equations of a weighted linear fit through a given centre value.
#[derive(Clone, Copy, Default)]
pub(crate) struct GradientFit {
    m: [f64; 6],
    rhs: Vec3,
}

impl GradientFit {
    /// Adds a neighbour at the offset `d`, m, whose value differs by `difference`.
    pub(crate) fn add(&mut self, d: Vec3, difference: f64) {
        let w = 1.0 / d.length2().max(1e-300);
        let products = [d.x * d.x, d.y * d.y, d.z * d.z, d.x * d.y, d.x * d.z, d.y * d.z];
        (0..6).for_each(|k| self.m[k] += w * products[k]);
        self.rhs += d * (w * difference);
    }
    /// The gradient; zero along directions without a neighbour.
    pub(crate) fn gradient(&self) -> Vec3 {
        let [xx, yy, zz, xy, xz, yz] = self.m;
        let ridge = 1e-9 * (xx + yy + zz);
        if ridge.is_nan() || ridge <= 0.0 {
            return Vec3::ZERO;
        }
        let (a, b, c) = (xx + ridge, yy + ridge, zz + ridge);
        // Symmetric inverse by cofactors.
        let (k0, k1, k2) = (b * c - yz * yz, xz * yz - xy * c, xy * yz - xz * b);
        let det = a * k0 + xy * k1 + xz * k2;
        if det.is_nan() || det <= 0.0 {
            return Vec3::ZERO;
        }
        let (k4, k5, k8) = (a * c - xz * xz, xy * xz - a * yz, a * b - xy * xy);
        let r = self.rhs;
        zonal_math::vec3(
            (k0 * r.x + k1 * r.y + k2 * r.z) / det,
            (k1 * r.x + k4 * r.y + k5 * r.z) / det,
            (k2 * r.x + k5 * r.y + k8 * r.z) / det,
        )
    }
}

/// One zone that touches a node, in one band.
#[derive(Clone, Copy)]
pub(crate) struct NodeZone {
    pub weight: f64,
    pub centre: Vec3,
    pub value: f64,
    pub gradient: Vec3,
    /// Smallest and largest value among the zone and its neighbours.
    pub range: (f64, f64),
}

/// The value at the node `v`; `None` when no zone touches it.
pub(crate) fn node_value(v: Vec3, touching: impl Iterator<Item = NodeZone> + Clone) -> Option<f64> {
    let total: f64 = touching.clone().map(|t| t.weight).sum();
    if total.is_nan() || total <= 0.0 {
        return None;
    }
    let (mut mean, mut centre, mut gradient) = (0.0, Vec3::ZERO, Vec3::ZERO);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for t in touching.clone() {
        let w = t.weight / total;
        mean += w * t.value;
        centre += t.centre * w;
        gradient += t.gradient * w;
        (low, high) = (low.min(t.range.0), high.max(t.range.1));
    }
    let mut x = mean + gradient.dot(v - centre);
    for t in touching {
        x += t.weight / total * (2.0 / 3.0) * (t.gradient - gradient).dot(v - t.centre);
    }
    Some(limit_to_range(x, low, high))
}

/// x limited to one range beyond [low, high], and to zero from below. Negative means, which linear fields in optically thick voxels may have, give
/// zero.
fn limit_to_range(x: f64, low: f64, high: f64) -> f64 {
    let slack = high - low;
    let (low, high) = ((low - slack).max(0.0), (high + slack).max(0.0));
    // Without any value the range is empty, for which `clamp` would panic.
    x.min(high).max(low.min(high))
}

/// Smallest and largest value of a list, band by band.
pub(crate) fn value_ranges(values: impl Iterator<Item = Bands>) -> PerBand<(f64, f64)> {
    values.fold(PerBand::splat((f64::INFINITY, f64::NEG_INFINITY)), |r, v| {
        PerBand::from_fn(|b| (r[b].0.min(v[b]), r[b].1.max(v[b])))
    })
}

/// Σ w_i x_i, band by band.
pub(crate) fn weighted_sum<const N: usize>(weights: [f64; N], values: &[Bands]) -> Bands {
    Bands::from_fn(|b| (0..N).map(|i| weights[i] * values[i][b]).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    #[test]
    fn node_values_are_limited_for_ranges_of_any_sign() {
        let of = |value: f64, range: (f64, f64)| {
            let gradient = vec3(1.0, 0.0, 0.0);
            let zone = NodeZone { weight: 1.0, centre: Vec3::ZERO, value, gradient, range };
            node_value(vec3(0.5, 0.0, 0.0), std::iter::once(zone)).unwrap()
        };
        assert!((of(1.0, (0.9, 1.1)) - 1.3).abs() < 1e-12);
        assert_eq!(of(-2.0, (-2.0, -1.0)), 0.0);
        assert_eq!(of(1.0, (-3.0, 2.0)), 1.5);
        assert_eq!(of(1e-300, (1e-300, 2e-300)), 3e-300);
        assert!(of(1.0, (f64::INFINITY, f64::NEG_INFINITY)) >= 0.0);
    }

    #[test]
    fn gradient_fit_is_exact_for_linear_fields_and_zero_without_neighbours() {
        let g = vec3(1.0, -2.0, 0.5);
        let mut fit = GradientFit::default();
        let points = [vec3(1.0, 0.0, 0.0), vec3(-1.0, 0.3, 0.0), vec3(0.0, 1.0, 1.0), vec3(0.2, 0.0, -1.0)];
        points.iter().for_each(|p| fit.add(*p, g.dot(*p)));
        assert!((fit.gradient() - g).length() < 1e-7);
        let mut flat = GradientFit::default();
        flat.add(vec3(2.0, 0.0, 0.0), 6.0);
        assert!((flat.gradient() - vec3(3.0, 0.0, 0.0)).length() < 1e-7);
        assert_eq!(GradientFit::default().gradient(), Vec3::ZERO);
    }
}
