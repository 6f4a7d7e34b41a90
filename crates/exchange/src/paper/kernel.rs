//! What all methods share: the pair of boxes as a difference of coordinates, its kernel, and ellipses for any direction.
//!
//! ```text
//! 𝓕 = W E[ t_x^{p_x} t_y^{p_y} t_z^{p_z} e^{−κr}/r^q ],   W = |a||b|/π,   q = 2 + m for m patches,
//! ```
//!
//! E the mean over both boxes, t = x_b − x_a with signs such that what a patch sees has t > 0. Parts behind a patch are clipped off
//! first: the remaining boxes lie wholly in front.
//!
//! **Ellipses.** Direction: one coordinate of one box (or a shift along an axis), which moves t_k over an interval of half-length h′ inside
//! [X_k − h_k, X_k + h_k]. On its Bernstein ellipse with semi-axes A, B, |t·t| ≥ R and Re √(t·t) ≥ √R, where R is that of `aligned::ellipse` for
//! the interval nearest to zero (R grows with the distance of its centre), c² the least sum of the other squares; the numerator is at most
//! Π_{j≠k} hi_j^{p_j} (X_k + h_k − h′ + A)^{p_k}. So |f| ≤ M = numerator · R^{−q/2} e^{−κ√R}.

use super::trapezoid::{self, Shape};
use crate::aligned::Cuboid;

pub(super) const EPS: f64 = 0.5 * f64::EPSILON;

/// Two boxes, clipped to what they see of each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    /// Differences of the centres, m, signs such that patches see t > 0.
    pub centre: [f64; 3],
    /// Extents of both boxes on each axis, m.
    pub extents: [[f64; 2]; 3],
    pub shapes: [Shape; 3],
    /// Signs that were applied to the axes.
    pub sign: [f64; 3],
    /// Power of t on each axis.
    pub power: [i32; 3],
    pub patches: i32,
    /// |a||b|/π.
    pub weight: f64,
    /// Absolute error of a coordinate of t by rounding, m.
    pub shake: f64,
    /// |a| and |b|: m³ or m².
    pub measures: [f64; 2],
    /// Relative error of measures and of what does not depend on a method.
    pub grain: f64,
}

/// Clips `b` to what lies in front of patch `a`; false if nothing is left.
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

/// The pair, or `None` when the two do not see each other.
///
/// # Panics
/// On invalid boxes.
pub(super) fn pair(a: &Cuboid, b: &Cuboid) -> Option<Pair> {
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
    Some(Pair {
        centre: all.map(|x| x.0),
        extents: all.map(|x| x.1),
        shapes: all.map(|x| Shape::new(x.1[0], x.1[1])),
        sign,
        power,
        patches: power.iter().sum(),
        weight: p.measure() * q.measure() * std::f64::consts::FRAC_1_PI,
        // Differences of coordinates: one rounding each of a number up to `spread`; midpoints and nodes eight more.
        shake: 16.0 * EPS * spread.min(2.0 * size + spread),
        measures: [p.measure(), q.measure()],
        grain: 16.0 * EPS,
    })
}

impl Pair {
    /// True when nothing of the two boxes was clipped off.
    pub(super) fn whole(&self, a: &Cuboid, b: &Cuboid) -> bool {
        self.measures == [a.measure(), b.measure()]
    }
    /// The power of r in the denominator.
    pub(super) fn q(&self) -> i32 {
        2 + self.patches
    }
    /// The least |t_k| on an axis.
    pub(super) fn gap(&self, k: usize) -> f64 {
        (self.centre[k].abs() - self.shapes[k].half).max(0.0)
    }
    /// The least |t|.
    pub(super) fn distance(&self) -> f64 {
        [0, 1, 2].map(|k| self.gap(k) * self.gap(k)).iter().sum::<f64>().sqrt()
    }
    /// The largest |t_k|.
    pub(super) fn far(&self, k: usize) -> f64 {
        self.centre[k].abs() + self.shapes[k].half
    }
    /// The largest |t|.
    pub(super) fn reach(&self) -> f64 {
        [0, 1, 2].map(|k| self.far(k) * self.far(k)).iter().sum::<f64>().sqrt()
    }
    /// Numerator over r^q e^{κr} at t.
    pub(super) fn kernel(&self, t: [f64; 3], kappa: f64) -> f64 {
        let r = (t[0] * t[0] + t[1] * t[1] + t[2] * t[2]).sqrt();
        let numerator: f64 = (0..3).map(|k| t[k].powi(self.power[k])).product();
        numerator * (-kappa * r).exp() * r.powi(-self.q())
    }
    /// The pair when one zone is first + step·i, its corners rounded: coordinates as large as those of `zones`.
    pub(super) fn of_lattice(mut self, zones: &[&Cuboid]) -> Pair {
        let corners = zones.iter().flat_map(|z| [z.lo, z.hi]).flat_map(|c| c.array());
        let size = corners.fold(0.0f64, |m, x| m.max(x.abs()));
        let extents = self.extents.iter().flatten().filter(|e| **e > 0.0);
        let thin = extents.fold(f64::INFINITY, |m, e| m.min(*e));
        self.shake += 8.0 * EPS * size;
        self.grain += 24.0 * EPS * size / thin;
        self
    }
    /// Bound of what moving every node by √3 · shake does to the mean: |∇f| ≤ (κ + (q + m)/r) e^{−κr}/r², r ≥ g.
    pub(super) fn shaken(&self, g: f64, kappa: f64) -> f64 {
        let q = (self.q() + self.patches) as f64;
        1.001 * 3f64.sqrt() * self.shake * (kappa + q / g) * (-kappa * g).exp() / (g * g)
    }
    /// A proven upper bound of 𝓕, for pairs that touch: ∫ dV/r² over a volume V is at most that over the ball of the same volume, 4π(3V/4π)^{1/3};
    /// two patches exchange at most the smaller area.
    pub(super) fn cap(&self) -> f64 {
        let ball = |v: f64| 4.0 * (3.0 * v / (4.0 * std::f64::consts::PI)).cbrt();
        let [a, b] = self.measures;
        let flat = |i: usize| (0..3).any(|k| self.extents[k][i] == 0.0);
        1.000_001
            * match (flat(0), flat(1)) {
                (true, true) => a.min(b),
                (true, false) => a * ball(b),
                (false, true) => b * ball(a),
                (false, false) => (a * ball(b)).min(b * ball(a)),
            }
    }
    /// Proven bound of the error of a tensor of Gauss rules for the densities, `lines` on the three axes, on the mean of f.
    pub(super) fn quadrature(&self, lines: [(usize, f64); 3], kappa: f64) -> f64 {
        (0..3)
            .filter(|&k| self.shapes[k].half > 0.0)
            .map(|k| {
                let (points, defect) = lines[k];
                let best = |e: &mut (f64, f64), (rho, m): (f64, f64)| {
                    e.0 = e.0.min(trapezoid::error(points, rho, m));
                    e.1 = e.1.min(defect * m * (rho * rho + 1.0) / (rho * rho - 1.0));
                };
                let mut e = (f64::INFINITY, f64::INFINITY);
                self.ellipses(k, self.density_half(k), kappa).for_each(|c| best(&mut e, c));
                e.0 + e.1
            })
            .sum()
    }
    /// Points on each axis that keep [`Pair::quadrature`] without defects below `goal`; `None` if more than the rules have.
    pub(super) fn points(&self, kappa: f64, goal: f64) -> Option<[usize; 3]> {
        let mut points = [1; 3];
        for k in (0..3).filter(|&k| self.shapes[k].half > 0.0) {
            let fewest = self
                .ellipses(k, self.density_half(k), kappa)
                .map(|(rho, m)| {
                    let r2 = rho * rho;
                    (trapezoid::error(0, rho, m) * 3.0 / goal).ln() / r2.ln()
                })
                .fold(f64::INFINITY, f64::min);
            points[k] = fewest.ceil().max(1.0) as usize;
        }
        points.iter().all(|&n| n <= trapezoid::MOST).then_some(points)
    }
    /// Half the width of the density on an axis, without what a sweep has added.
    fn density_half(&self, k: usize) -> f64 {
        0.5 * (self.extents[k][0] + self.extents[k][1])
    }
    /// The pair with t_k swept by ±`by`.
    pub(super) fn swept(mut self, k: usize, by: f64) -> Pair {
        self.shapes[k].half += by;
        self
    }
    /// (ϱ, M) for a direction on axis `k` whose interval has the half-length `half` and lies within the support (a swept one too);
    /// |f| ≤ M, without W.
    pub(super) fn ellipses(&self, k: usize, half: f64, kappa: f64) -> impl Iterator<Item = (f64, f64)> {
        let pair = *self;
        let c2: f64 = (0..3).filter(|&j| j != k).map(|j| pair.gap(j) * pair.gap(j)).sum();
        let rest: f64 = (0..3).filter(|&j| j != k).map(|j| pair.far(j).powi(pair.power[j])).product();
        let x = (pair.centre[k].abs() - (pair.shapes[k].half - half)).max(0.0);
        let widest = {
            let p = 2.0 * c2 + x * x - half * half;
            (0.25 * (p + (p * p + 8.0 * c2 * half * half).sqrt())).max(0.0).sqrt()
        };
        FRACTIONS.into_iter().filter_map(move |f| {
            let b = f * widest;
            let a = (b * b + half * half).sqrt();
            let axial = if x * a >= a * a + b * b {
                (x - a) * (x - a)
            } else {
                b * b * (x * x / (a * a + b * b) - 1.0)
            };
            let square = (c2 + axial) * (1.0 - 1e-12) - 1e-14 * (c2 + x * x);
            let top = (pair.far(k) - half + a).powi(pair.power[k]) * rest;
            let m = top * square.powf(-0.5 * pair.q() as f64) * (-kappa * square.max(0.0).sqrt()).exp();
            (square > 0.0 && b > 0.0).then(|| ((a + b) / half, 1.000_001 * m))
        })
    }
}

/// Shares of the widest ellipse, wide to narrow: narrow ones serve optically long pairs.
const FRACTIONS: [f64; 14] =
    [0.97, 0.92, 0.86, 0.78, 0.68, 0.55, 0.4, 0.27, 0.17, 0.1, 0.05, 0.02, 0.008, 0.003];

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    #[test]
    fn clipping_leaves_what_is_seen() {
        let patch = Cuboid::patch(vec3(0.0, 0.0, 0.0), vec3(0.0, 1.0, 1.0), 0, 1);
        let half = Cuboid::voxel(vec3(-1.0, 0.0, 2.0), vec3(1.0, 1.0, 3.0));
        let p = pair(&patch, &half).unwrap();
        assert_eq!((p.measures, p.centre[0], p.gap(0)), ([1.0, 1.0], 0.5, 0.0));
        assert!(pair(&patch, &Cuboid::voxel(vec3(-2.0, 0.0, 0.0), vec3(-1.0, 1.0, 1.0))).is_none());
        let other = Cuboid::patch(vec3(2.0, 0.0, 0.0), vec3(2.0, 1.0, 1.0), 0, 1);
        assert!(pair(&patch, &other).is_none());
    }

    #[test]
    fn the_ellipses_bound_the_kernel() {
        let a = Cuboid::patch(vec3(0.0, 0.0, 0.0), vec3(0.0, 1.0, 2.0), 0, 1);
        let b = Cuboid::voxel(vec3(1.5, 0.5, -1.0), vec3(2.0, 3.0, 1.0));
        let p = pair(&a, &b).unwrap();
        for kappa in [0.0, 2.0] {
            for k in 0..3 {
                let half = 0.5 * p.extents[k][1];
                for (rho, m) in p.ellipses(k, half, kappa) {
                    let (big, small) = (0.5 * half * (rho + 1.0 / rho), 0.5 * half * (rho - 1.0 / rho));
                    for i in 0..400 {
                        let phi = i as f64 * std::f64::consts::TAU / 400.0;
                        for shift in [-1.0, 0.3, 1.0] {
                            let x = p.centre[k] + shift * (p.shapes[k].half - half);
                            let (re, im) = (x + big * phi.cos(), small * phi.sin());
                            let mut c2 = 0.0;
                            let mut numerator = re.hypot(im).powi(p.power[k]);
                            for j in (0..3).filter(|&j| j != k) {
                                let t = p.gap(j) + 0.1 * p.shapes[j].half;
                                c2 += t * t;
                                numerator *= t.powi(p.power[j]);
                            }
                            let (u, v) = (re * re - im * im + c2, 2.0 * re * im);
                            let r2 = u.hypot(v);
                            let root = (0.5 * (r2 + u)).sqrt();
                            let f = numerator * r2.powf(-0.5 * p.q() as f64) * (-kappa * root).exp();
                            assert!(f <= m, "{k} {rho} {f} {m}");
                        }
                    }
                }
            }
        }
    }
}
