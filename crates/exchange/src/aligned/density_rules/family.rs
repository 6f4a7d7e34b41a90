//! Pairs of boxes that differ in their offset alone: densities, kernel, and the integral by a chosen rule.

use super::triangle_rule::{MAX_RULE_POINTS, triangle};
use zonal_math::gauss_legendre;
use zonal_math::simd;

/// Unit roundoff 2⁻⁵³.
const UNIT_ROUNDOFF: f64 = 0.5 * f64::EPSILON;
/// Rounding of the bounds themselves.
pub(super) const BOUND_ROUNDING: f64 = 1.000_001;
/// Roundings of a value without a medium: 156 + 16 + 30 + 27 + 4 + 24, see above.
pub(super) const ROUNDINGS: f64 = 280.0; // bound
/// Roundings for each mean free path to the centre: 1.6 · 36.
pub(super) const ROUNDINGS_PER_DEPTH: f64 = 60.0; // bound

/// The density of one direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::aligned) enum DensityKind {
    /// Both boxes are flat: t is fixed.
    Fixed,
    /// One box is flat.
    Uniform,
    /// Two equal extents.
    Triangle,
}

/// The kernel and the densities of pairs that differ in their offset alone.
#[derive(Clone, Copy, Debug)]
pub(in crate::aligned) struct DensityFamily {
    pub kind: [DensityKind; 3],
    /// Half of the density's width, m.
    pub half: [f64; 3],
    pub power: [i32; 3],
    pub patches: i32,
    /// Mass of the density.
    pub mass: f64,
    /// Extinction, 1/m.
    pub kappa: f64,
}

impl DensityFamily {
    /// The family of two boxes with these extents on each axis (equal, or one or both zero), m.
    pub(in crate::aligned) fn new(extents: [(f64, f64); 3], kappa: f64) -> DensityFamily {
        let power = extents.map(|(a, b)| (a == 0.0) as i32 + (b == 0.0) as i32);
        DensityFamily {
            kind: power
                .map(|p| [DensityKind::Triangle, DensityKind::Uniform, DensityKind::Fixed][p as usize]),
            half: extents.map(|(a, b)| 0.5 * (a + b)),
            power,
            patches: power.iter().sum(),
            mass: extents.iter().flat_map(|&(a, b)| [a, b]).filter(|&x| x > 0.0).product(),
            kappa,
        }
    }

    /// The kernel at the centres, the reference of relative errors.
    #[inline(always)]
    pub(super) fn estimate<const N: usize>(&self, c: &[[f64; N]; 3]) -> [f64; N] {
        let mut out = [0.0; N];
        let mut r2 = [0.0; N];
        for l in 0..N {
            r2[l] = c[0][l] * c[0][l] + c[1][l] * c[1][l] + c[2][l] * c[2][l];
        }
        for l in 0..N {
            out[l] = shell(self.patches, r2[l]);
            for k in 0..3 {
                out[l] *= power(c[k][l], self.power[k]);
            }
        }
        if self.kappa > 0.0 {
            let e = simd::exp(r2.map(|s| -self.kappa * s.sqrt()));
            for l in 0..N {
                out[l] *= e[l];
            }
        }
        out
    }

    /// The relative rounding error at distance `r`, m.
    #[inline(always)]
    pub(in crate::aligned) fn rounding(&self, r: f64) -> f64 {
        UNIT_ROUNDOFF * (ROUNDINGS + ROUNDINGS_PER_DEPTH * self.kappa * r)
    }

    /// Values and radii by the planned rules.
    #[inline(always)]
    pub(in crate::aligned) fn integrate<const N: usize>(
        &self,
        c: &[[f64; N]; 3],
        plan: &RulePlan<N>,
    ) -> ([f64; N], [f64; N]) {
        let sum = match (self.patches, self.kappa > 0.0) {
            (0, false) => self.sum::<0, false, N>(c, plan.points),
            (1, false) => self.sum::<1, false, N>(c, plan.points),
            (_, false) => self.sum::<2, false, N>(c, plan.points),
            (0, true) => self.sum::<0, true, N>(c, plan.points),
            (1, true) => self.sum::<1, true, N>(c, plan.points),
            (_, true) => self.sum::<2, true, N>(c, plan.points),
        };
        let front = self.mass * std::f64::consts::FRAC_1_PI;
        let (mut value, mut radius) = ([0.0; N], [0.0; N]);
        for l in 0..N {
            let r = (c[0][l] * c[0][l] + c[1][l] * c[1][l] + c[2][l] * c[2][l]).sqrt();
            value[l] = front * sum[l];
            radius[l] = BOUND_ROUNDING * (front * plan.error[l] + self.rounding(r) * value[l]);
        }
        (value, radius)
    }

    /// Squares of the nodes of one direction, and weights times the numerator's share.
    #[inline(always)]
    fn nodes<const N: usize>(
        &self,
        c: &[f64; N],
        k: usize,
        n: usize,
    ) -> ([[f64; N]; MAX_RULE_POINTS], [[f64; N]; MAX_RULE_POINTS]) {
        let (mut square, mut factor) = ([[0.0; N]; MAX_RULE_POINTS], [[1.0; N]; MAX_RULE_POINTS]);
        for i in 0..n {
            let (w, low, x) = match self.kind[k] {
                DensityKind::Fixed => (1.0, 0.0, 0.0),
                DensityKind::Uniform => {
                    (gauss_legendre::rule(n).weights[i], -1.0, 2.0 * gauss_legendre::rule(n).nodes[i])
                }
                DensityKind::Triangle => (triangle(n).weights[i], 0.0, triangle(n).nodes[i]),
            };
            for l in 0..N {
                // From the near end, where the nodes of the rule have small relative errors.
                let t = (c[l] + self.half[k] * low) + self.half[k] * x;
                square[i][l] = t * t;
                factor[i][l] = w * power(t, self.power[k]);
            }
        }
        (square, factor)
    }

    #[inline(always)]
    fn sum<const M: i32, const ATTENUATED: bool, const N: usize>(
        &self,
        c: &[[f64; N]; 3],
        points: [usize; 3],
    ) -> [f64; N] {
        let [(x, fx), (y, fy), (z, fz)] = [0, 1, 2].map(|k| self.nodes(&c[k], k, points[k]));
        let mut total = [0.0; N];
        for i in 0..points[0] {
            let mut plane = [0.0; N];
            for j in 0..points[1] {
                let mut line = [0.0; N];
                for k in 0..points[2] {
                    let mut r2 = [0.0; N];
                    let mut v = [0.0; N];
                    for l in 0..N {
                        r2[l] = x[i][l] + y[j][l] + z[k][l];
                        v[l] = fz[k][l] * shell(M, r2[l]);
                    }
                    if ATTENUATED {
                        let e = simd::exp(r2.map(|s| -self.kappa * s.sqrt()));
                        for l in 0..N {
                            v[l] *= e[l];
                        }
                    }
                    for l in 0..N {
                        line[l] += v[l];
                    }
                }
                for l in 0..N {
                    plane[l] += fy[j][l] * line[l];
                }
            }
            for l in 0..N {
                total[l] += fx[i][l] * plane[l];
            }
        }
        total
    }
}

/// 1/r^{2+m} from r².
#[inline(always)]
pub(in crate::aligned) fn shell(patches: i32, r2: f64) -> f64 {
    match patches {
        0 => 1.0 / r2,
        1 => 1.0 / (r2 * r2.sqrt()),
        _ => 1.0 / (r2 * r2),
    }
}

/// t^p for p ≤ 2.
#[inline(always)]
pub(in crate::aligned) fn power(t: f64, p: i32) -> f64 {
    match p {
        0 => 1.0,
        1 => t,
        _ => t * t,
    }
}

/// A number of points per direction, and the error that they leave in each lane (without mass/π).
#[derive(Clone, Copy, Debug)]
pub(in crate::aligned) struct RulePlan<const N: usize> {
    pub points: [usize; 3],
    pub error: [f64; N],
}
