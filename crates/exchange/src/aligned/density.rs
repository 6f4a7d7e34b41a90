//! Gauss rules made for the densities themselves: no cut at the kink of a triangle, a few points for far pairs, a medium or none.
//!
//! **Rules.** A direction's density is fixed, uniform or, for two equal extents, the triangle 1 − |x| on [−1, 1]. The n-point
//! Gauss rule of the triangle: its even moments 2/((2k+1)(2k+2)) give the recursion p_{k+1} = x p_k − β_k p_{k−1} by Chebyshev's
//! algorithm, nodes are the zeros of p_n and weights h_{n−1}/(p_n' p_{n−1}). All of it in pairs of doubles: the moments'
//! condition (1 + √2)^{4n} ≤ 6·10¹³ leaves 18 digits for n ≤ 9; nodes and weights are rounded once.
//!
//! **Error of one direction.** Let ω be symmetric and positive with mass W, Q its n-point rule, f analytic inside the Bernstein
//! ellipse of parameter ϱ and |f| ≤ M there. Chebyshev's coefficients obey |a_k| ≤ 2Mϱ^{−k}; Q is exact for k < 2n and, by
//! symmetry, for odd k; |∫T_k ω − Q T_k| is the defect d_n W for k = 2n, a number of the rule, and at most 2W beyond. So
//!
//! ```text
//! |∫fω − Qf| ≤ 2 M W ϱ^{−2n} (d_n + 2ϱ^{−2} / (1 − ϱ^{−2})),
//! ```
//!
//! with equality for f = T_{2n} and ϱ → ∞.
//!
//! The three directions add (see `apart.rs`); M is the supremum of the complexified kernel as there: with the other two variables
//! real, c² the least sum of their squares, semi-axis A along, R = c² + min Re z²,
//!
//! ```text
//! M = Π_{j≠k} (c_j + h_j)^{p_j} · (c_k + A)^{p_k} · R^{−q/2} e^{−κ√R}.
//! ```
//!
//! **Rounding.** Served are D ≤ RATIO·r as in `moments.rs`, so |t| ≥ 0.4 r. A node t = c + hx is within 3ε(|c| + h) ≤ 4.8 ε r √3 in all, and the geometry adds
//! 4.4 ε r: 1/|t|^q has q·(33 + 6)ε; numerators (t from the near end, all terms positive) 8ε each; weights, lengths, mass, π: 30ε; sums 3·9ε;
//! the attenuation κ|t|·36ε + 4ε with κ|t| ≤ 1.6 κr. In all (280 + 60 κr)ε, which also covers extents that
//! differ by two ulp and are taken for equal: 24ε.

mod plan;

pub(super) use plan::{Hint, Plan};

use std::sync::OnceLock;
use zonal_math::gauss::{self, Pair};
use zonal_math::simd;

/// The most points a direction.
pub(super) const MOST: usize = 9;
const EPS: f64 = 0.5 * f64::EPSILON;
const UP: f64 = 1.000_001;
/// |a_k| ≤ 2 M ϱ^{−k}.
const COEFFICIENT: f64 = 2.0; // bound
/// |∫T_k ω| + |Q T_k| ≤ 2 W.
const NORMS: f64 = 2.0; // bound
/// Roundings of a value without a medium: 156 + 16 + 30 + 27 + 4 + 24, see above.
const ROUNDINGS: f64 = 280.0; // bound
/// Roundings for each mean free path to the centre: 1.6 · 36.
const ROUNDINGS_DEPTH: f64 = 60.0; // bound

/// Nodes on [−1, 1] and weights of sum one.
#[derive(Debug)]
pub(super) struct Rule {
    pub nodes: Vec<f64>,
    pub weights: Vec<f64>,
}

/// The n-point Gauss rule of 1 − |x| on [−1, 1], 1 ≤ n ≤ [`MOST`].
pub(super) fn triangle(n: usize) -> &'static Rule {
    static RULES: OnceLock<Vec<Rule>> = OnceLock::new();
    &RULES.get_or_init(|| {
        let beta = recursion();
        let mut zeros: Vec<f64> = vec![];
        (0..=MOST)
            .map(|n| {
                zeros = interlaced(n, &beta, &zeros);
                Rule::new(n, &beta, &zeros)
            })
            .collect()
    })[n]
}

/// β_k, k = 1..2·MOST, from the even moments (Chebyshev's algorithm; α_k = 0).
fn recursion() -> Vec<Pair> {
    let count = 2 * MOST + 2;
    let number = |x: usize| Pair::new(x as f64);
    let moment = |l: usize| {
        if l % 2 == 1 { Pair::new(0.0) } else { number(2).div(number(l + 1).mul(number(l + 2))) }
    };
    let mut before = vec![Pair::new(0.0); count];
    let mut now: Vec<Pair> = (0..count).map(moment).collect();
    let mut beta = vec![now[0]];
    for k in 1..=MOST {
        let mut next = vec![Pair::new(0.0); count];
        for l in k..count - k {
            next[l] = now[l + 1].sub(beta[k - 1].mul(if k == 1 { Pair::new(0.0) } else { before[l] }));
        }
        beta.push(next[k].div(now[k - 1]));
        (before, now) = (now, next);
    }
    beta
}

/// p_n, its derivative and p_{n−1}.
fn polynomial(n: usize, beta: &[Pair], x: Pair) -> (Pair, Pair, Pair) {
    let (mut p, mut before) = (Pair::new(1.0), Pair::new(0.0));
    let (mut d, mut d_before) = (Pair::new(0.0), Pair::new(0.0));
    for k in 0..n {
        let b = if k == 0 { Pair::new(0.0) } else { beta[k] };
        let next = x.mul(p).sub(b.mul(before));
        let slope = p.add(x.mul(d)).sub(b.mul(d_before));
        (before, d_before, p, d) = (p, d, next, slope);
    }
    (p, d, before)
}

/// The zeros of p_n between those of p_{n−1}, by bisection.
fn interlaced(n: usize, beta: &[Pair], zeros: &[f64]) -> Vec<f64> {
    let value = |x: f64| polynomial(n, beta, Pair::new(x)).0.hi;
    let ends: Vec<f64> = [-1.0].into_iter().chain(zeros.iter().copied()).chain([1.0]).collect();
    let bracket = |w: &[f64]| {
        let (mut a, mut b) = (w[0], w[1]);
        let rising = value(b) > 0.0;
        for _ in 0..60 {
            let mid = 0.5 * (a + b);
            if (value(mid) > 0.0) == rising { b = mid } else { a = mid }
        }
        0.5 * (a + b)
    };
    if n == 0 { vec![] } else { ends.windows(2).map(bracket).collect() }
}

impl Rule {
    fn new(n: usize, beta: &[Pair], zeros: &[f64]) -> Rule {
        let mut rule = Rule { nodes: vec![0.0; n], weights: vec![0.0; n] };
        // h_{n−1} = β_0 … β_{n−1}.
        let norm = beta[..n].iter().fold(Pair::new(1.0), |h, b| h.mul(*b));
        for i in 0..n.div_ceil(2) {
            let mut x = Pair::new(zeros[i]);
            for _ in 0..2 {
                let (p, d, _) = polynomial(n, beta, x);
                x = x.sub(p.div(d));
            }
            if 2 * i + 1 == n {
                x = Pair::new(0.0);
            }
            let (_, d, before) = polynomial(n, beta, x);
            let w = norm.div(d.mul(before)).hi;
            (rule.nodes[i], rule.nodes[n - 1 - i]) = (x.hi, -x.hi);
            (rule.weights[i], rule.weights[n - 1 - i]) = (w, w);
        }
        rule
    }
}

/// d_n of the rules of [`Kind::Uniform`] and [`Kind::Triangle`]: |mean of T_{2n} − Q T_{2n}|, the means by a rule that is exact for them.
fn defect(kind: Kind, n: usize) -> f64 {
    static DEFECTS: OnceLock<[[f64; MOST + 1]; 2]> = OnceLock::new();
    let chebyshev = |n: usize, x: f64| (2.0 * n as f64 * x.clamp(-1.0, 1.0).acos()).cos();
    let exact = gauss::rule(gauss::MAX_POINTS);
    let mean = |n: usize, weight: &dyn Fn(f64) -> f64| -> f64 {
        exact.nodes.iter().zip(&exact.weights).map(|(u, w)| w * weight(*u) * chebyshev(n, *u)).sum()
    };
    let table = DEFECTS.get_or_init(|| {
        [
            std::array::from_fn(|n| {
                let rule = gauss::rule(n.max(1));
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
    table[(kind == Kind::Triangle) as usize][n]
}

/// The density of one direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// t is known.
    Fixed,
    /// One box is flat.
    Uniform,
    /// Two equal extents.
    Triangle,
}

/// A kernel and the densities of a family of pairs that differ in their offset alone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    pub kind: [Kind; 3],
    /// Half of the density's width, m.
    pub half: [f64; 3],
    pub power: [i32; 3],
    pub patches: i32,
    /// Mass of the density.
    pub mass: f64,
    /// Extinction, 1/m.
    pub kappa: f64,
}

impl Grid {
    /// Of two boxes with these extents on each axis (equal, or one or both zero), m.
    pub(super) fn new(extents: [(f64, f64); 3], kappa: f64) -> Grid {
        let power = extents.map(|(a, b)| (a == 0.0) as i32 + (b == 0.0) as i32);
        Grid {
            kind: power.map(|p| [Kind::Triangle, Kind::Uniform, Kind::Fixed][p as usize]),
            half: extents.map(|(a, b)| 0.5 * (a + b)),
            power,
            patches: power.iter().sum(),
            mass: extents.iter().flat_map(|&(a, b)| [a, b]).filter(|&x| x > 0.0).product(),
            kappa,
        }
    }

    /// The kernel at the centres: what errors are compared with.
    #[inline(always)]
    fn estimate<const N: usize>(&self, c: &[[f64; N]; 3]) -> [f64; N] {
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
    pub(super) fn rounding(&self, r: f64) -> f64 {
        EPS * (ROUNDINGS + ROUNDINGS_DEPTH * self.kappa * r)
    }

    /// Values and radii by the planned rules.
    #[inline(always)]
    pub(super) fn integrate<const N: usize>(
        &self,
        c: &[[f64; N]; 3],
        plan: &Plan<N>,
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
            radius[l] = UP * (front * plan.error[l] + self.rounding(r) * value[l]);
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
    ) -> ([[f64; N]; MOST], [[f64; N]; MOST]) {
        let (mut square, mut factor) = ([[0.0; N]; MOST], [[1.0; N]; MOST]);
        for i in 0..n {
            let (w, low, x) = match self.kind[k] {
                Kind::Fixed => (1.0, 0.0, 0.0),
                Kind::Uniform => (gauss::rule(n).weights[i], -1.0, 2.0 * gauss::rule(n).nodes[i]),
                Kind::Triangle => (triangle(n).weights[i], 0.0, triangle(n).nodes[i]),
            };
            for l in 0..N {
                // From the near end where the rule's nodes are relatively accurate there.
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
fn shell(patches: i32, r2: f64) -> f64 {
    match patches {
        0 => 1.0 / r2,
        1 => 1.0 / (r2 * r2.sqrt()),
        _ => 1.0 / (r2 * r2),
    }
}

#[inline(always)]
fn power(t: f64, p: i32) -> f64 {
    match p {
        0 => 1.0,
        1 => t,
        _ => t * t,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_of_the_triangle_are_exact() {
        // Two points: x² = 1/6. Three: x² = 2/5, weights 5/24, 7/12, 5/24.
        assert!((triangle(2).nodes[0] + (1.0f64 / 6.0).sqrt()).abs() < 2e-16);
        assert!((triangle(3).weights[1] - 7.0 / 12.0).abs() < 2e-16);
        for n in 1..=MOST {
            let r = triangle(n);
            for k in 0..n {
                let got: f64 = r.nodes.iter().zip(&r.weights).map(|(x, w)| w * x.powi(2 * k as i32)).sum();
                let want = 1.0 / ((2 * k + 1) * (k + 1)) as f64;
                assert!((got / want - 1.0).abs() < 2e-15, "{n} {k}: {got} {want}");
            }
            assert!(r.nodes.is_sorted() && r.weights.iter().all(|w| *w > 0.0));
        }
    }

    /// The bound for T_{2n}, whose modulus on the ellipse is (ϱ^{2n} + ϱ^{−2n})/2.
    fn bound_of_chebyshev(kind: Kind, n: usize, rho: f64) -> f64 {
        let per = 1.0 / (rho * rho);
        let m = 0.5 * (rho.powi(2 * n as i32) + rho.powi(-2 * n as i32));
        COEFFICIENT * m * rho.powi(-2 * n as i32) * (defect(kind, n) + NORMS * per / (1.0 - per))
    }

    #[test]
    fn the_bound_is_met_by_chebyshev() {
        for n in 1..=MOST {
            let (rule, degree) = (triangle(n), 2.0 * n as f64);
            let t = |x: f64| (degree * x.acos()).cos();
            let q: f64 = rule.nodes.iter().zip(&rule.weights).map(|(x, w)| w * t(*x)).sum();
            // By the substitution x = cos φ, midpoints.
            let steps = 200_000;
            let exact: f64 = (0..steps)
                .map(|i| {
                    let phi = (i as f64 + 0.5) * std::f64::consts::PI / steps as f64;
                    (degree * phi).cos() * (1.0 - phi.cos().abs()) * phi.sin() * std::f64::consts::PI
                        / steps as f64
                })
                .sum();
            let error = (exact - q).abs();
            for rho in [2.0, 10.0, 1e3] {
                assert!(error <= bound_of_chebyshev(Kind::Triangle, n, rho) + 1e-9, "{n} {rho}");
            }
            assert!(error >= 0.99 * bound_of_chebyshev(Kind::Triangle, n, 1e3), "{n}: {error}");
        }
    }

    #[test]
    fn the_norms_of_integral_and_rule() {
        for n in 1..=MOST {
            let q: f64 = triangle(n).weights.iter().map(|w| w.abs()).sum();
            assert!(1.0 + q <= NORMS * (1.0 + 1e-14) && NORMS <= (1.0 + q) * (1.0 + 1e-14));
        }
    }

    #[test]
    fn the_counts_of_roundings() {
        let (kernel, numerator, weights, sums, exponential, extents) =
            (4.0 * 39.0, 16.0, 30.0, 27.0, 4.0, 24.0);
        assert!(ROUNDINGS >= kernel + numerator + weights + sums + exponential + extents);
        let (farthest, a_path) = (1.0 + crate::aligned::moments::RATIO, 36.0);
        assert!(ROUNDINGS_DEPTH >= farthest * a_path);
    }
}
