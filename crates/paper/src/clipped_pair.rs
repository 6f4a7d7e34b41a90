//! A pair of boxes clipped to the parts that see each other: difference coordinates, kernel, Bernstein ellipses.
//!
//! ```text
//! 𝓕 = W E[ t_x^{p_x} t_y^{p_y} t_z^{p_z} e^{−κr}/r^q ],   W = |a||b|/π,   q = 2 + m for m patches,
//! ```
//!
//! E the mean over both boxes, t = x_b − x_a with signs such that t > 0 in front of a patch. Parts behind a patch are clipped off
//! first, so the remaining boxes lie wholly in front.
//!
//! **Ellipses.** Direction: one coordinate of one box (or a shift along an axis), which moves t_k over an interval of half-length h′ inside
//! [X_k − h_k, X_k + h_k]. On its Bernstein ellipse with semi-axes A, B, |t·t| ≥ R and Re √(t·t) ≥ √R, where R is that of `aligned::ellipse` for
//! the interval nearest to zero (R grows with the distance of its centre), c² the least sum of the other squares; the numerator is at most
//! Π_{j≠k} hi_j^{p_j} (X_k + h_k − h′ + A)^{p_k}. So |f| ≤ M = numerator · R^{−q/2} e^{−κ√R}.

use super::trapezoid_gauss::{self, TrapezoidDensity};
use crate::rounding::UNIT_ROUNDOFF;
use zonal_exchange::aligned::Cuboid;

/// Two boxes, clipped to the parts that see each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClippedPair {
    /// Differences of the centres, m, signs such that patches see t > 0.
    pub centre: [f64; 3],
    /// Extents of both boxes on each axis, m.
    pub extents: [[f64; 2]; 3],
    pub densities: [TrapezoidDensity; 3],
    /// Signs that were applied to the axes.
    pub sign: [f64; 3],
    /// Power of t on each axis.
    pub power: [i32; 3],
    pub patches: i32,
    /// |a||b|/π.
    pub weight: f64,
    /// Absolute error of a coordinate of t by rounding, m.
    pub coordinate_error: f64,
    /// |a| and |b|: m³ or m².
    pub measures: [f64; 2],
    /// Relative rounding error of the measures and of the common factor.
    pub relative_error: f64,
}

/// Clips `b` to the half-space in front of patch `a`; false if nothing remains.
fn clip(a: &Cuboid, b: &mut Cuboid) -> bool {
    let Some((axis, sign)) = a.normal else { return true };
    let plane = a.lo[axis];
    let (mut lo, mut hi) = (b.lo.array(), b.hi.array());
    if sign > 0 {
        lo[axis] = lo[axis].max(plane)
    } else {
        hi[axis] = hi[axis].min(plane)
    }
    let seen = match b.normal {
        Some((flat, _)) if flat == axis => (b.lo[axis] - plane) * sign as f64 > 0.0,
        _ => lo[axis] < hi[axis],
    };
    if !matches!(b.normal, Some((flat, _)) if flat == axis) {
        b.lo = zonal_math::vec3(lo[0], lo[1], lo[2]);
        b.hi = zonal_math::vec3(hi[0], hi[1], hi[2]);
    }
    seen
}

/// Clips a pair; `None` where the boxes do not see each other.
///
/// # Panics
/// On invalid boxes.
pub(super) fn clipped_pair(a: &Cuboid, b: &Cuboid) -> Option<ClippedPair> {
    assert!(a.is_valid() && b.is_valid(), "not a box or rectangle: {a:?}, {b:?}");
    let (mut p, mut q) = (*a, *b);
    if !clip(a, &mut q) || !clip(b, &mut p) {
        return None;
    }
    let mut sign = [1.0; 3];
    let mut power = [0; 3];
    if let Some((axis, s)) = a.normal {
        sign[axis] = s as f64;
        power[axis] += 1;
    }
    if let Some((axis, s)) = b.normal {
        if power[axis] > 0 && sign[axis] == s as f64 {
            return None;
        }
        sign[axis] = -(s as f64);
        power[axis] += 1;
    }
    let axis = |k: usize| {
        let extents = [p.hi[k] - p.lo[k], q.hi[k] - q.lo[k]];
        let centre = 0.5 * ((q.lo[k] - p.lo[k]) + (q.hi[k] - p.hi[k])) * sign[k];
        (centre, extents)
    };
    let all = [axis(0), axis(1), axis(2)];
    let size = [p.lo, p.hi, q.lo, q.hi].iter().flat_map(|c| c.array()).fold(0.0f64, |m, x| m.max(x.abs()));
    let spread = all.iter().fold(0.0f64, |m, x| m.max(x.0.abs() + x.1[0] + x.1[1]));
    Some(ClippedPair {
        centre: all.map(|x| x.0),
        extents: all.map(|x| x.1),
        densities: all.map(|x| TrapezoidDensity::new(x.1[0], x.1[1])),
        sign,
        power,
        patches: power.iter().sum(),
        weight: p.measure() * q.measure() * std::f64::consts::FRAC_1_PI,
        // Differences of coordinates: one rounding each of a number up to `spread`; midpoints and nodes eight more.
        coordinate_error: 16.0 * UNIT_ROUNDOFF * spread.min(2.0 * size + spread),
        measures: [p.measure(), q.measure()],
        relative_error: 16.0 * UNIT_ROUNDOFF,
    })
}

impl ClippedPair {
    /// True if neither box was clipped.
    pub(super) fn is_unclipped(&self, a: &Cuboid, b: &Cuboid) -> bool {
        self.measures == [a.measure(), b.measure()]
    }
    /// The power of r in the denominator.
    pub(super) fn distance_power(&self) -> i32 {
        2 + self.patches
    }
    /// The least |t_k| on an axis.
    pub(super) fn axis_distance(&self, k: usize) -> f64 {
        (self.centre[k].abs() - self.densities[k].half).max(0.0)
    }
    /// The least |t|.
    pub(super) fn distance(&self) -> f64 {
        [0, 1, 2].map(|k| self.axis_distance(k) * self.axis_distance(k)).iter().sum::<f64>().sqrt()
    }
    /// The largest |t_k|.
    pub(super) fn axis_reach(&self, k: usize) -> f64 {
        self.centre[k].abs() + self.densities[k].half
    }
    /// The largest |t|.
    pub(super) fn max_distance(&self) -> f64 {
        [0, 1, 2].map(|k| self.axis_reach(k) * self.axis_reach(k)).iter().sum::<f64>().sqrt()
    }
    /// Numerator over r^q e^{κr} at t.
    pub(super) fn kernel(&self, t: [f64; 3], kappa: f64) -> f64 {
        let r = (t[0] * t[0] + t[1] * t[1] + t[2] * t[2]).sqrt();
        let numerator: f64 = (0..3).map(|k| t[k].powi(self.power[k])).product();
        numerator * (-kappa * r).exp() * r.powi(-self.distance_power())
    }
    /// Adds the rounding of corners computed as first + step·i, with coordinates as large as those of `zones`.
    pub(super) fn with_lattice_rounding(mut self, zones: &[&Cuboid]) -> ClippedPair {
        let corners = zones.iter().flat_map(|z| [z.lo, z.hi]).flat_map(|c| c.array());
        let size = corners.fold(0.0f64, |m, x| m.max(x.abs()));
        let extents = self.extents.iter().flatten().filter(|e| **e > 0.0);
        let thin = extents.fold(f64::INFINITY, |m, e| m.min(*e));
        self.coordinate_error += 8.0 * UNIT_ROUNDOFF * size;
        self.relative_error += 24.0 * UNIT_ROUNDOFF * size / thin;
        self
    }
    /// Bound of the change of the mean when every node moves by √3 · `coordinate_error`: |∇f| ≤ (κ + (q + m)/r) e^{−κr}/r², r ≥ g.
    pub(super) fn displacement_error(&self, g: f64, kappa: f64) -> f64 {
        let q = (self.distance_power() + self.patches) as f64;
        1.001 * 3f64.sqrt() * self.coordinate_error * (kappa + q / g) * (-kappa * g).exp() / (g * g)
    }
    /// Proven upper bound of 𝓕, for touching pairs: ∫ dV/r² over a volume V is at most that over the ball of the same volume, 4π(3V/4π)^{1/3};
    /// two patches exchange at most the smaller area.
    pub(super) fn upper_bound(&self) -> f64 {
        let ball = |v: f64| 4.0 * (3.0 * v / (4.0 * std::f64::consts::PI)).cbrt();
        let [a, b] = self.measures;
        let [a_is_flat, b_is_flat] = [0, 1].map(|i| (0..3).any(|k| self.extents[k][i] == 0.0));
        let bound = if a_is_flat && b_is_flat {
            a.min(b)
        } else if a_is_flat {
            a * ball(b)
        } else if b_is_flat {
            b * ball(a)
        } else {
            (a * ball(b)).min(b * ball(a))
        };
        1.000_001 * bound
    }
    /// Proven bound of the error of a tensor of Gauss rules for the densities, `lines` on the three axes, on the mean of f.
    pub(super) fn quadrature_error(&self, lines: [(usize, f64); 3], kappa: f64) -> f64 {
        (0..3)
            .filter(|&k| self.densities[k].half > 0.0)
            .map(|k| {
                let (points, defect) = lines[k];
                let best = |e: &mut (f64, f64), (rho, m): (f64, f64)| {
                    e.0 = e.0.min(trapezoid_gauss::gauss_error(points, rho, m));
                    e.1 = e.1.min(defect * m * (rho * rho + 1.0) / (rho * rho - 1.0));
                };
                let mut e = (f64::INFINITY, f64::INFINITY);
                self.bernstein_ellipses(k, self.density_half(k), kappa).for_each(|c| best(&mut e, c));
                e.0 + e.1
            })
            .sum()
    }
    /// Points on each axis that keep [`ClippedPair::quadrature_error`] without defects below `goal`; `None` if that needs more than the largest rule.
    pub(super) fn points_for_error(&self, kappa: f64, goal: f64) -> Option<[usize; 3]> {
        let mut points = [1; 3];
        for k in (0..3).filter(|&k| self.densities[k].half > 0.0) {
            let fewest = self
                .bernstein_ellipses(k, self.density_half(k), kappa)
                .map(|(rho, m)| {
                    let r2 = rho * rho;
                    (trapezoid_gauss::gauss_error(0, rho, m) * 3.0 / goal).ln() / r2.ln()
                })
                .fold(f64::INFINITY, f64::min);
            points[k] = fewest.ceil().max(1.0) as usize;
        }
        points.iter().all(|&n| n <= trapezoid_gauss::MAX_POINTS).then_some(points)
    }
    /// Half the width of the density on an axis, without the sweep.
    fn density_half(&self, k: usize) -> f64 {
        0.5 * (self.extents[k][0] + self.extents[k][1])
    }
    /// The pair with t_k swept by ±`by`.
    pub(super) fn swept_along(mut self, k: usize, by: f64) -> ClippedPair {
        self.densities[k].half += by;
        self
    }
    /// (ϱ, M) for a direction on axis `k` whose interval has the half-length `half` and lies within the support (a swept one too);
    /// |f| ≤ M, without W.
    pub(super) fn bernstein_ellipses(
        &self,
        k: usize,
        half: f64,
        kappa: f64,
    ) -> impl Iterator<Item = (f64, f64)> {
        let pair = *self;
        let c2: f64 = (0..3).filter(|&j| j != k).map(|j| pair.axis_distance(j) * pair.axis_distance(j)).sum();
        let rest: f64 = (0..3).filter(|&j| j != k).map(|j| pair.axis_reach(j).powi(pair.power[j])).product();
        let x = (pair.centre[k].abs() - (pair.densities[k].half - half)).max(0.0);
        let widest = {
            let p = 2.0 * c2 + x * x - half * half;
            (0.25 * (p + (p * p + 8.0 * c2 * half * half).sqrt())).max(0.0).sqrt()
        };
        ELLIPSE_FRACTIONS.into_iter().filter_map(move |f| {
            let b = f * widest;
            let a = (b * b + half * half).sqrt();
            let axial = if x * a >= a * a + b * b {
                (x - a) * (x - a)
            } else {
                b * b * (x * x / (a * a + b * b) - 1.0)
            };
            let square = (c2 + axial) * (1.0 - 1e-12) - 1e-14 * (c2 + x * x);
            let top = (pair.axis_reach(k) - half + a).powi(pair.power[k]) * rest;
            let m = top
                * square.powf(-0.5 * pair.distance_power() as f64)
                * (-kappa * square.max(0.0).sqrt()).exp();
            (square > 0.0 && b > 0.0).then(|| ((a + b) / half, 1.000_001 * m))
        })
    }
}

/// Semi-axes of the ellipses tried, relative to the widest one, in decreasing order: narrow ellipses suit optically long pairs.
const ELLIPSE_FRACTIONS: [f64; 14] =
    [0.97, 0.92, 0.86, 0.78, 0.68, 0.55, 0.4, 0.27, 0.17, 0.1, 0.05, 0.02, 0.008, 0.003];

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    #[test]
    fn clipping_keeps_the_visible_part() {
        let patch = Cuboid::patch(vec3(0.0, 0.0, 0.0), vec3(0.0, 1.0, 1.0), 0, 1);
        let half = Cuboid::voxel(vec3(-1.0, 0.0, 2.0), vec3(1.0, 1.0, 3.0));
        let p = clipped_pair(&patch, &half).unwrap();
        assert_eq!((p.measures, p.centre[0], p.axis_distance(0)), ([1.0, 1.0], 0.5, 0.0));
        assert!(clipped_pair(&patch, &Cuboid::voxel(vec3(-2.0, 0.0, 0.0), vec3(-1.0, 1.0, 1.0))).is_none());
        let other = Cuboid::patch(vec3(2.0, 0.0, 0.0), vec3(2.0, 1.0, 1.0), 0, 1);
        assert!(clipped_pair(&patch, &other).is_none());
    }

    #[test]
    fn ellipses_bound_the_kernel() {
        let a = Cuboid::patch(vec3(0.0, 0.0, 0.0), vec3(0.0, 1.0, 2.0), 0, 1);
        let b = Cuboid::voxel(vec3(1.5, 0.5, -1.0), vec3(2.0, 3.0, 1.0));
        let p = clipped_pair(&a, &b).unwrap();
        for kappa in [0.0, 2.0] {
            for k in 0..3 {
                let half = 0.5 * p.extents[k][1];
                for (rho, m) in p.bernstein_ellipses(k, half, kappa) {
                    let (big, small) = (0.5 * half * (rho + 1.0 / rho), 0.5 * half * (rho - 1.0 / rho));
                    for i in 0..400 {
                        let phi = i as f64 * std::f64::consts::TAU / 400.0;
                        for shift in [-1.0, 0.3, 1.0] {
                            let x = p.centre[k] + shift * (p.densities[k].half - half);
                            let (re, im) = (x + big * phi.cos(), small * phi.sin());
                            let mut c2 = 0.0;
                            let mut numerator = re.hypot(im).powi(p.power[k]);
                            for j in (0..3).filter(|&j| j != k) {
                                let t = p.axis_distance(j) + 0.1 * p.densities[j].half;
                                c2 += t * t;
                                numerator *= t.powi(p.power[j]);
                            }
                            let (u, v) = (re * re - im * im + c2, 2.0 * re * im);
                            let r2 = u.hypot(v);
                            let root = (0.5 * (r2 + u)).sqrt();
                            let f =
                                numerator * r2.powf(-0.5 * p.distance_power() as f64) * (-kappa * root).exp();
                            assert!(f <= m, "{k} {rho} {f} {m}");
                        }
                    }
                }
            }
        }
    }
}
