//! The number of points per direction by the error bound of `density_rules.rs`.
//!
//! The bound holds for any ellipse; the best of six candidates is used. Neighbouring entries of a table need similar rules, so the ellipse of one
//! entry is tried first for the next. Its bound is proved like any other; only the selection is cheaper.

use super::family::{BOUND_ROUNDING, DensityFamily, DensityKind, RulePlan, shell};
use super::triangle_rule::{MAX_RULE_POINTS, triangle};
use crate::aligned::moment_series::MAX_SIZE_OVER_DISTANCE;
use std::sync::OnceLock;
use zonal_math::{gauss_legendre, simd};

/// |a_k| ≤ 2 M ϱ^{−k}.
pub(super) const COEFFICIENT_BOUND: f64 = 2.0; // bound
/// |∫T_k ω| + |Q T_k| ≤ 2 W.
pub(super) const NORM_BOUND: f64 = 2.0; // bound
/// Minor semi-axes of the candidate ellipses relative to the widest ellipse.
const ELLIPSE_FRACTIONS: [f64; 6] = [0.95, 0.75, 0.5, 0.3, 0.15, 0.06];
/// Distance in mean free paths beyond which the exponential may underflow.
const MAX_OPTICAL_DEPTH: f64 = 300.0;

/// The rule of a previous entry: number of points, ellipse, and remaining uses before all ellipses are tried.
#[derive(Clone, Copy, Debug)]
struct ServedDirection {
    points: usize,
    ellipse: usize,
    left: u8,
}

/// The rules of the previous entry, per direction.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::aligned) struct PlanHint([Option<ServedDirection>; 3]);

/// Uses of a hint before all ellipses are tried.
const MAX_HINT_USES: u8 = 24;

/// The distance along a direction, the least squared distance across it, the numerator's other factors, B² of the widest ellipse.
struct DirectionGeometry<const N: usize> {
    x: [f64; N],
    c2: [f64; N],
    front: [f64; N],
    widest: [f64; N],
}

/// d_n of the rules of [`DensityKind::Uniform`] and [`DensityKind::Triangle`]: |mean of T_{2n} − Q T_{2n}|, the means by a rule that is exact
/// for them.
pub(super) fn defect(kind: DensityKind, n: usize) -> f64 {
    static DEFECTS: OnceLock<[[f64; MAX_RULE_POINTS + 1]; 2]> = OnceLock::new();
    let chebyshev = |n: usize, x: f64| (2.0 * n as f64 * x.clamp(-1.0, 1.0).acos()).cos();
    let exact = gauss_legendre::rule(gauss_legendre::MAX_POINTS);
    let mean = |n: usize, weight: &dyn Fn(f64) -> f64| -> f64 {
        exact.nodes.iter().zip(&exact.weights).map(|(u, w)| w * weight(*u) * chebyshev(n, *u)).sum()
    };
    let table = DEFECTS.get_or_init(|| {
        [
            std::array::from_fn(|n| {
                let rule = gauss_legendre::rule(n.max(1));
                let q: f64 =
                    rule.nodes.iter().zip(&rule.weights).map(|(u, w)| w * chebyshev(n, 2.0 * u - 1.0)).sum();
                (mean(n, &|_| 1.0) - q).abs() + 1e-12
            }),
            std::array::from_fn(|n| {
                let rule = triangle(n.max(1));
                let q: f64 = rule.nodes.iter().zip(&rule.weights).map(|(x, w)| w * chebyshev(n, *x)).sum();
                (mean(n, &|u| 2.0 * (1.0 - u)) - q).abs() + 1e-12
            }),
        ]
    });
    table[(kind == DensityKind::Triangle) as usize][n]
}

/// Of each candidate ellipse: 2M ϱ^{−2n} after n points, ϱ⁻², and the share of the coefficients beyond T_{2n}.
struct CandidateEllipses<const N: usize> {
    error: [[f64; N]; ELLIPSE_FRACTIONS.len()],
    decay: [[f64; N]; ELLIPSE_FRACTIONS.len()],
    rest: [[f64; N]; ELLIPSE_FRACTIONS.len()],
}

impl DensityFamily {
    /// The fewest points whose error is within the relative `budget` in every lane; `None` if more than [`MAX_RULE_POINTS`] are needed or the
    /// pair is too close.
    #[inline(always)]
    pub(in crate::aligned) fn plan<const N: usize>(
        &self,
        c: &[[f64; N]; 3],
        budget: f64,
    ) -> Option<RulePlan<N>> {
        self.plan_near(c, budget, &mut PlanHint::default())
    }

    /// The same, starting from the rules of the previous entry; may take slightly more points.
    #[inline(always)]
    pub(in crate::aligned) fn plan_near<const N: usize>(
        &self,
        c: &[[f64; N]; 3],
        budget: f64,
        hint: &mut PlanHint,
    ) -> Option<RulePlan<N>> {
        let goal = self.estimate(c).map(|v| v * budget / 3.0);
        let reach2: f64 = self.half.iter().map(|h| h * h).sum();
        let mut served = true;
        for l in 0..N {
            let r2 = c[0][l] * c[0][l] + c[1][l] * c[1][l] + c[2][l] * c[2][l];
            served &= reach2 <= MAX_SIZE_OVER_DISTANCE * MAX_SIZE_OVER_DISTANCE * r2
                && self.kappa * self.kappa * r2 < MAX_OPTICAL_DEPTH * MAX_OPTICAL_DEPTH;
            for k in 0..3 {
                served &= self.power[k] != 1 || c[k][l] * (1.0 + 1e-9) >= self.half[k];
            }
        }
        if !served {
            return None;
        }
        let mut plan = RulePlan { points: [1; 3], error: [0.0; N] };
        for k in (0..3).filter(|&k| self.kind[k] != DensityKind::Fixed) {
            let (points, error) = self.points_along(c, k, &goal, &mut hint.0[k])?;
            plan.points[k] = points;
            for l in 0..N {
                plan.error[l] += error[l];
            }
        }
        Some(plan)
    }

    #[inline(always)]
    fn points_along<const N: usize>(
        &self,
        c: &[[f64; N]; 3],
        k: usize,
        goal: &[f64; N],
        hint: &mut Option<ServedDirection>,
    ) -> Option<(usize, [f64; N])> {
        let side = self.direction_geometry(c, k);
        if let Some(found) = self.plan_from_hint(&side, k, goal, hint) {
            return Some(found);
        }
        let CandidateEllipses { mut error, decay, rest } = self.candidate_ellipses(&side, k);
        for n in 1..=MAX_RULE_POINTS {
            let mut best = [f64::INFINITY; N];
            let defect = defect(self.kind[k], n);
            for f in 0..ELLIPSE_FRACTIONS.len() {
                for l in 0..N {
                    error[f][l] *= decay[f][l];
                    let all = error[f][l] * (defect + rest[f][l]);
                    best[l] = if all < best[l] { all } else { best[l] };
                }
            }
            let mut within = true;
            for l in 0..N {
                within &= best[l] <= goal[l];
            }
            if within {
                // One ellipse that serves all lanes, if there is any.
                let serves = |f: &usize| {
                    (0..N).all(|l| error[*f][l] * (defect + rest[*f][l]) * BOUND_ROUNDING <= goal[l])
                };
                *hint = (0..ELLIPSE_FRACTIONS.len()).find(serves).map(|ellipse| ServedDirection {
                    points: n,
                    ellipse,
                    left: MAX_HINT_USES,
                });
                return Some((n, best.map(|e| e * BOUND_ROUNDING)));
            }
        }
        None
    }

    /// The bounds of all candidate ellipses before any point.
    #[inline(always)]
    fn candidate_ellipses<const N: usize>(
        &self,
        side: &DirectionGeometry<N>,
        k: usize,
    ) -> CandidateEllipses<N> {
        let mut error = [[0.0; N]; ELLIPSE_FRACTIONS.len()];
        let mut decay = [[0.0; N]; ELLIPSE_FRACTIONS.len()];
        let mut rest = [[0.0; N]; ELLIPSE_FRACTIONS.len()];
        for (f, fraction) in ELLIPSE_FRACTIONS.into_iter().enumerate() {
            let (m, per, square) = self.ellipse_bound(side, k, fraction);
            let mut depth = [0.0; N];
            for l in 0..N {
                error[f][l] = COEFFICIENT_BOUND * m[l];
                rest[f][l] = NORM_BOUND * per[l] / (1.0 - per[l]);
                depth[l] = -self.kappa * square[l].sqrt();
            }
            decay[f] = per;
            if self.kappa > 0.0 {
                let e = simd::exp(depth);
                for l in 0..N {
                    error[f][l] *= e[l];
                }
            }
        }
        CandidateEllipses { error, decay, rest }
    }

    /// Tries the ellipse of the hint, with one point less and with as many.
    #[inline(always)]
    fn plan_from_hint<const N: usize>(
        &self,
        side: &DirectionGeometry<N>,
        k: usize,
        goal: &[f64; N],
        hint: &mut Option<ServedDirection>,
    ) -> Option<(usize, [f64; N])> {
        let served = hint.as_mut().filter(|h| h.left > 0)?;
        served.left -= 1;
        let (m, per, square) = self.ellipse_bound(side, k, ELLIPSE_FRACTIONS[served.ellipse]);
        let mut error = m.map(|m| COEFFICIENT_BOUND * m);
        if self.kappa > 0.0 {
            let e = simd::exp(square.map(|s| -self.kappa * s.sqrt()));
            for l in 0..N {
                error[l] *= e[l];
            }
        }
        for n in 1..=served.points {
            let defect = defect(self.kind[k], n);
            for l in 0..N {
                error[l] *= per[l];
            }
            if n + 1 < served.points {
                continue;
            }
            let mut all = [0.0; N];
            let mut within = true;
            for l in 0..N {
                all[l] = error[l] * (defect + NORM_BOUND * per[l] / (1.0 - per[l])) * BOUND_ROUNDING;
                within &= all[l] <= goal[l];
            }
            if within {
                served.points = n;
                return Some((n, all));
            }
        }
        None
    }

    /// The geometry shared by the ellipses of direction k.
    #[inline(always)]
    fn direction_geometry<const N: usize>(&self, c: &[[f64; N]; 3], k: usize) -> DirectionGeometry<N> {
        let mut s = DirectionGeometry { x: [0.0; N], c2: [0.0; N], front: [1.0; N], widest: [0.0; N] };
        for j in (0..3).filter(|&j| j != k) {
            for l in 0..N {
                let near = c[j][l].abs() - self.half[j];
                let near = if near > 0.0 { near } else { 0.0 };
                s.c2[l] += near * near;
            }
            for _ in 0..self.power[j] {
                for l in 0..N {
                    s.front[l] *= c[j][l] + self.half[j];
                }
            }
        }
        let h2 = self.half[k] * self.half[k];
        for l in 0..N {
            s.x[l] = c[k][l].abs();
            let p = 2.0 * s.c2[l] + s.x[l] * s.x[l] - h2;
            s.widest[l] = 0.25 * (p + (p * p + 8.0 * s.c2[l] * h2).sqrt());
        }
        s
    }

    /// M without its exponential, ϱ⁻² and R of direction k's ellipse (see [`super::super::bernstein_ellipse`]).
    #[inline(always)]
    fn ellipse_bound<const N: usize>(
        &self,
        s: &DirectionGeometry<N>,
        k: usize,
        fraction: f64,
    ) -> ([f64; N], [f64; N], [f64; N]) {
        let h = self.half[k];
        let (mut m, mut per, mut square, mut reach) = (s.front, [0.0; N], [0.0; N], [0.0; N]);
        for l in 0..N {
            let x = s.x[l];
            let b2 = fraction * fraction * s.widest[l];
            let a2 = b2 + h * h;
            let (a, b) = (a2.sqrt(), b2.sqrt());
            let flat = b2 * (x * x / (a2 + b2) - 1.0);
            let end = (x - a) * (x - a);
            square[l] = s.c2[l] + if x * a >= a2 + b2 { end } else { flat };
            let inverse = h / (a + b);
            per[l] = inverse * inverse;
            reach[l] = x + a;
        }
        for _ in 0..self.power[k] {
            for l in 0..N {
                m[l] *= reach[l];
            }
        }
        match self.patches {
            0 => (0..N).for_each(|l| m[l] *= shell(0, square[l])),
            1 => (0..N).for_each(|l| m[l] *= shell(1, square[l])),
            _ => (0..N).for_each(|l| m[l] *= shell(2, square[l])),
        }
        (m, per, square)
    }
}
