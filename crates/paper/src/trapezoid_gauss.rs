//! Gauss rules for the trapezoid density of the difference of two uniform coordinates, with error bounds and the number of points.
//!
//! On an axis where two boxes have the extents a and b, t = x_b − x_a is spread around the difference X of the centres over
//! [X − h, X + h], h = (a + b)/2, with a trapezoid as density: level on the inner |a − b|/(a + b) of it. The n-point Gauss
//! rule of that density is exact for polynomials of degree 2n − 1, has positive weights of sum one and is symmetric.
//!
//! **Error.** f analytic in the Bernstein ellipse of parameter ϱ around the interval, |f| ≤ M there: its Chebyshev
//! coefficients are at most 2Mϱ^{−k}, odd terms give nothing by symmetry, and |I T_k|, |Q T_k| ≤ 1, so
//!
//! ```text
//! |I f − Q f| ≤ Σ_{k ≥ 2n, even} 2Mϱ^{−k} (1 + 1) = 4 M ϱ^{−2n}/(1 − ϱ^{−2}).
//! ```
//!
//! **Rounding of the rule.** For the computed nodes and weights, δ = max_{k<2n} |Q T_k − I T_k| is measured when the rule is
//! made (plus the rounding of that measurement: T_k = cos(k acos x) errs by at most (2πk + 2)ε), and adds δ M (1 + ϱ^{−2})/(1 − ϱ^{−2}).
//!
//! **For the kernel 1/|t|²** and boxes at least g apart in t (g the distance of the support from 0), direction k complex on an ellipse with
//! semi-axes A along, B across, c² the least sum of the other squares, |t·t| ≥ R with (header of `aligned::ellipse`)
//!
//! ```text
//! R = c² + X²β − B², β = B²/(A² + B²), if XA ≤ A² + B², else c² + (X − A)²;   c² + max(X − h, 0)² = g².
//! ```
//!
//! For fixed g this is concave and continuously differentiable in X on [h, g + h] and grows on [0, h], so it is least at X = 0 or at X = g + h (c = 0):
//! [`min_square_distance`]. With E|t|² ≤ (g + |h|)² + |h|²/3 and Jensen, E 1/|t|² ≥ 1/E|t|², the error relative to the integral is at most
//! 4ϱ^{−2n}/(1 − ϱ^{−2}) · E|t|²/R for each direction, and for fixed ϱ that falls with g. [`PointsByDistance`] tabulates it by steps of g.

use crate::rounding::UNIT_ROUNDOFF;
use std::cell::Cell;
use std::sync::OnceLock;
use zonal_math::gauss_legendre;

/// Bound of a Chebyshev coefficient over M ϱ^{−k}, times |I T_k| + |Q T_k| ≤ 2.
const GAUSS_ERROR_FACTOR: f64 = 2.0 * (1.0 + 1.0); // bound
/// Largest number of points of a rule.
pub(super) const MAX_POINTS: usize = 24;

/// A rule on [−1, 1], weights of sum one.
#[derive(Clone, Debug)]
pub(super) struct TrapezoidRule {
    pub nodes: Vec<f64>,
    pub weights: Vec<f64>,
    /// max |Q T_k − I T_k| below the degree of exactness.
    pub defect: f64,
}

/// The `n`-point rule for the density that is level on |u| ≤ `plateau` and falls to zero at |u| = 1;
/// `plateau` = 1 is the uniform density.
pub(super) fn trapezoid_rule(n: usize, plateau: f64) -> TrapezoidRule {
    let fine = exact_moments(n, plateau);
    let beta = recurrence_coefficients(n, &fine);
    let nodes = zeros(n, &beta);
    let weights = nodes.iter().map(|&x| christoffel_weight(n, &beta, x)).collect();
    let mut rule = TrapezoidRule { nodes, weights, defect: 0.0 };
    rule.defect = moment_defect(&rule, &fine);
    rule
}

/// The rule of two equal extents, whose density is a triangle; computed once.
pub(super) fn triangle_rule(n: usize) -> &'static TrapezoidRule {
    static RULES: [OnceLock<TrapezoidRule>; MAX_POINTS + 1] = [const { OnceLock::new() }; MAX_POINTS + 1];
    RULES[n].get_or_init(|| trapezoid_rule(n, 0.0))
}

/// Points on [0, 1] and weights of sum one that integrate even polynomials of degree ≤ 2n + 1 times the density exactly.
fn exact_moments(n: usize, plateau: f64) -> Vec<(f64, f64)> {
    let r = gauss_legendre::rule(n + 1);
    let total = 0.5 * (1.0 + plateau);
    let mut out = Vec::with_capacity(2 * n + 2);
    for (u, w) in r.nodes.iter().zip(&r.weights) {
        if plateau > 0.0 {
            out.push((plateau * u, plateau * w / total));
        }
        if plateau < 1.0 {
            out.push((plateau + (1.0 - plateau) * u, (1.0 - plateau) * (1.0 - u) * w / total));
        }
    }
    out
}

/// β of p_{k+1} = x p_k − β_k p_{k−1} (Stieltjes' procedure; the density is even), β_0 unused.
fn recurrence_coefficients(n: usize, fine: &[(f64, f64)]) -> Vec<f64> {
    let mut beta = vec![0.0; n.max(1)];
    let mut before = vec![0.0; fine.len()];
    let mut now = vec![1.0; fine.len()];
    let mut norm = 1.0;
    for k in 1..n {
        for (i, &(x, _)) in fine.iter().enumerate() {
            let next = x * now[i] - beta[k - 1] * before[i];
            (before[i], now[i]) = (now[i], next);
        }
        let square: f64 = fine.iter().zip(&now).map(|(&(_, w), p)| w * p * p).sum();
        beta[k] = square / norm;
        norm = square;
    }
    beta
}

/// p_n and its derivative at x.
fn monic_polynomial(n: usize, beta: &[f64], x: f64) -> (f64, f64) {
    let (mut p0, mut p1, mut d0, mut d1) = (0.0, 1.0, 0.0, 0.0);
    for b in &beta[..n] {
        (d0, d1) = (d1, p1 + x * d1 - b * d0);
        (p0, p1) = (p1, x * p1 - b * p0);
    }
    (p1, d1)
}

/// The zeros of p_n, ascending: the positive ones of p_k lie between those of p_{k−1} (and 0, 1), for one k after the other.
fn zeros(n: usize, beta: &[f64]) -> Vec<f64> {
    let mut found: Vec<f64> = Vec::new();
    for k in 1..=n {
        let mut ends = Vec::with_capacity(found.len() + 2);
        if k % 2 == 0 {
            ends.push(0.0);
        }
        ends.extend_from_slice(&found);
        ends.push(1.0);
        found = ends.windows(2).map(|e| zero_between(k, beta, e[0], e[1])).collect();
    }
    let middle = (n % 2 == 1).then_some(0.0);
    found.iter().rev().map(|z| -z).chain(middle).chain(found.iter().copied()).collect()
}

/// The one zero of p_k between two points: Newton's iteration, halving where it would leave the bracket.
fn zero_between(k: usize, beta: &[f64], mut low: f64, mut high: f64) -> f64 {
    let rising = monic_polynomial(k, beta, high).0 > 0.0;
    let mut x = 0.5 * (low + high);
    for _ in 0..100 {
        let (p, d) = monic_polynomial(k, beta, x);
        if (p > 0.0) == rising {
            high = x
        } else {
            low = x
        }
        let newton = x - p / d;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        let step = (next - x).abs();
        x = next;
        if step <= 2.0 * UNIT_ROUNDOFF {
            break;
        }
    }
    x
}

/// The weight at a zero: 1/Σ p_k²/‖p_k‖².
fn christoffel_weight(n: usize, beta: &[f64], x: f64) -> f64 {
    let (mut p0, mut p1, mut norm, mut sum) = (0.0, 1.0, 1.0, 1.0);
    for k in 1..n {
        (p0, p1) = (p1, x * p1 - beta[k - 1] * p0);
        norm *= beta[k];
        sum += p1 * p1 / norm;
    }
    1.0 / sum
}

fn moment_defect(rule: &TrapezoidRule, fine: &[(f64, f64)]) -> f64 {
    let n = rule.nodes.len();
    let angle = |x: f64| x.clamp(-1.0, 1.0).acos();
    let ours: Vec<(f64, f64)> = rule.nodes.iter().zip(&rule.weights).map(|(&x, &w)| (angle(x), w)).collect();
    let theirs: Vec<(f64, f64)> = fine.iter().map(|&(x, w)| (angle(x), w)).collect();
    let mean = |points: &[(f64, f64)], k: usize| -> f64 {
        points.iter().map(|&(t, w)| w * (k as f64 * t).cos()).sum()
    };
    let worst = (0..n).map(|k| (mean(&ours, 2 * k) - mean(&theirs, 2 * k)).abs()).fold(0.0, f64::max);
    // Two evaluations of T_k, k < 2n, at (2πk + 2)ε each; the sums and the fine weights 20ε.
    worst + (26.0 * n as f64 + 24.0) * UNIT_ROUNDOFF
}

/// The density of t on one axis of a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TrapezoidDensity {
    /// Half the width of the support.
    pub half: f64,
    /// Fraction of the support on which the density is constant.
    pub plateau: f64,
    /// Variance of t.
    pub variance: f64,
}

impl TrapezoidDensity {
    /// The shape for two extents.
    pub(super) fn new(a: f64, b: f64) -> TrapezoidDensity {
        let plateau = if a + b > 0.0 { (a - b).abs() / (a + b) } else { 1.0 };
        TrapezoidDensity { half: 0.5 * (a + b), plateau, variance: (a * a + b * b) / 12.0 }
    }
}

/// Semi-axes of the ellipses tried, relative to the widest one.
const ELLIPSE_FRACTIONS: [f64; 6] = [0.95, 0.88, 0.78, 0.62, 0.42, 0.25];

/// The least |t·t| over all positions of a box at distance `g`, one coordinate on an ellipse of semi-axes (a, b) around
/// an interval of half-length `h`.
fn min_square_distance(g: f64, h: f64, a: f64, b: f64) -> f64 {
    let x = g + h;
    let axial =
        if x * a >= a * a + b * b { (x - a) * (x - a) } else { b * b * (x * x / (a * a + b * b) - 1.0) };
    axial.min(g * g - b * b)
}

/// (ϱ, E|t|²/R) of the ellipses for an interval of half-length `h` in boxes of half-extents with squared sum `h2`, g apart.
pub(super) fn ellipse_ratios(g: f64, h: f64, h2: f64) -> impl Iterator<Item = (f64, f64)> {
    let widest = g.min((0.5 * g * (g + 2.0 * h)).sqrt());
    let reach = g + h2.sqrt();
    let square = reach * reach + h2 / 3.0;
    ELLIPSE_FRACTIONS.into_iter().filter_map(move |f| {
        let b = f * widest;
        let a = (b * b + h * h).sqrt();
        let least = min_square_distance(g, h, a, b);
        (least > 0.0).then(|| ((a + b) / h, square / least))
    })
}

/// Bound 4 m ϱ^{−2n}/(1 − ϱ^{−2}) of an n-point rule.
pub(super) fn gauss_error(n: usize, rho: f64, m: f64) -> f64 {
    let r2 = rho * rho;
    GAUSS_ERROR_FACTOR * m * r2.powi(-(n as i32)) / (1.0 - 1.0 / r2)
}

/// A rule at a distance of the boxes.
#[derive(Clone, Copy, Debug)]
pub(super) struct RuleAtDistance {
    /// Points.
    pub points: usize,
    /// Error of the direction relative to the integral, exact nodes and weights given.
    pub error: f64,
    /// Factor of the rule's defect.
    pub factor: f64,
}

/// Number of points on one axis by the distance of the boxes, computed on demand.
#[derive(Debug)]
pub(super) struct PointsByDistance {
    /// Half-lengths of the intervals (zero: none), and the number of points where it is given.
    halves: [f64; 2],
    points: Option<usize>,
    tolerance: f64,
    /// Squared sum of the boxes' half-extents.
    h2: f64,
    steps: [Cell<Option<RuleAtDistance>>; STEPS_PER_DOUBLING * MAX_DOUBLINGS],
}

/// Steps of the table in a doubling of the distance.
const STEPS_PER_DOUBLING: usize = 4;
/// Doublings of the distance in the table, from an eighth of the boxes' half-diagonal up.
const MAX_DOUBLINGS: usize = 14;
/// 2^{i/4}.
const STEP_RATIOS: [f64; STEPS_PER_DOUBLING] =
    [1.0, 1.189_207_115_002_721, std::f64::consts::SQRT_2, 1.681_792_830_507_429];

impl PointsByDistance {
    /// For intervals of half-length `half` in boxes whose half-extents have the squared sum `h2`: the points that keep the relative error of
    /// this direction below `tolerance`.
    pub(super) fn new(half: f64, h2: f64, tolerance: f64) -> PointsByDistance {
        PointsByDistance {
            halves: [half, 0.0],
            points: None,
            tolerance,
            h2,
            steps: [const { Cell::new(None) }; STEPS_PER_DOUBLING * MAX_DOUBLINGS],
        }
    }

    /// For two Gauss–Legendre rules of `points` points over the two extents.
    pub(super) fn fixed(extents: [f64; 2], h2: f64, points: usize) -> PointsByDistance {
        let halves = extents.map(|x| 0.5 * x);
        PointsByDistance { points: Some(points), halves, ..PointsByDistance::new(0.0, h2, 0.5) }
    }

    /// The rule for boxes at distance `g`; `None` if none is admissible.
    pub(super) fn at(&self, g: f64) -> Option<RuleAtDistance> {
        let least = 0.125 * self.h2.sqrt();
        let ratio = g / least * (1.0 - 1e-12);
        if ratio.is_nan() || ratio < 1.0 {
            return None;
        }
        let exponent = (ratio.to_bits() >> 52) as usize - 1023;
        let rest = ratio / f64::from_bits(((exponent + 1023) as u64) << 52);
        let i = (exponent * STEPS_PER_DOUBLING + STEP_RATIOS.iter().filter(|f| **f <= rest).count() - 1)
            .min(STEPS_PER_DOUBLING * MAX_DOUBLINGS - 1);
        let step = self.steps[i].get().unwrap_or_else(|| {
            let power = f64::from_bits(((i / STEPS_PER_DOUBLING + 1023) as u64) << 52);
            self.make(least * power * STEP_RATIOS[i % STEPS_PER_DOUBLING])
        });
        self.steps[i].set(Some(step));
        (step.error <= 1.000_001 * self.tolerance && step.points <= MAX_POINTS).then_some(step)
    }

    fn make(&self, g: f64) -> RuleAtDistance {
        let mut step = RuleAtDistance { points: self.points.unwrap_or(1), error: 0.0, factor: 0.0 };
        for half in self.halves.into_iter().filter(|h| *h > 0.0) {
            let (mut points, mut least, mut factor) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
            for (rho, m) in ellipse_ratios(g, half, self.h2) {
                let r2 = rho * rho;
                factor = factor.min(m * (r2 + 1.0) / (r2 - 1.0));
                if let Some(n) = self.points {
                    least = least.min(gauss_error(n, rho, m));
                    continue;
                }
                let front = GAUSS_ERROR_FACTOR * m / ((1.0 - 1.0 / r2) * self.tolerance);
                let needed = (front.ln() / r2.ln()).ceil().max(1.0);
                if needed < points && needed <= MAX_POINTS as f64 {
                    (points, least) = (needed, gauss_error(needed as usize, rho, m));
                }
            }
            if self.points.is_none() {
                step.points = points.min(1e6) as usize;
            }
            step.error += least;
            step.factor += factor;
        }
        step
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_exact_to_rounding() {
        for plateau in [0.0, 0.3, 0.9, 1.0] {
            for n in 1..=MAX_POINTS {
                let r = trapezoid_rule(n, plateau);
                let slack = (26.0 * n as f64 + 24.0) * UNIT_ROUNDOFF;
                assert!(r.defect <= slack + 1e-14, "n={n} plateau={plateau} {:e}", r.defect - slack);
                assert!(r.weights.iter().all(|&w| w > 0.0) && r.nodes.is_sorted());
                assert!(r.nodes.iter().zip(r.nodes.iter().rev()).all(|(a, b)| *a == -b));
            }
        }
        // The uniform density is Legendre's.
        let (r, g) = (trapezoid_rule(7, 1.0), gauss_legendre::rule(7));
        for i in 0..7 {
            assert!((0.5 * (r.nodes[i] + 1.0) - g.nodes[i]).abs() < 2e-16);
            assert!((r.weights[i] - g.weights[i]).abs() < 2e-16);
        }
    }

    /// The triangle's second moment is 1/6, its fourth 1/15; the trapezoid's variance is that of two uniforms.
    #[test]
    fn rules_have_the_moments_of_the_densities() {
        let r = trapezoid_rule(3, 0.0);
        let moment = |r: &TrapezoidRule, k: i32| -> f64 {
            r.nodes.iter().zip(&r.weights).map(|(x, w)| w * x.powi(k)).sum()
        };
        assert!((moment(&r, 2) - 1.0 / 6.0).abs() < 1e-15 && (moment(&r, 4) - 1.0 / 15.0).abs() < 1e-15);
        let s = TrapezoidDensity::new(1.0, 3.0);
        let got = moment(&trapezoid_rule(3, s.plateau), 2) * s.half * s.half;
        assert!((got - s.variance).abs() < 1e-14 && s.plateau == 0.5);
    }

    /// A defect is seen: a weight changed by 1e-10 shows.
    #[test]
    fn defect_measures_a_changed_weight() {
        let fine = exact_moments(5, 0.0);
        let mut r = trapezoid_rule(5, 0.0);
        r.weights[2] += 1e-10;
        assert!(moment_defect(&r, &fine) >= 0.9e-10);
    }

    #[test]
    fn gauss_error_factor_follows_its_derivation() {
        // Coefficients of a function bounded by M: 2 M ϱ^{-k}, reached by none but approached: (1/π)∫ f cos(kθ) dθ · ... ≤ 2 M ϱ^{-k}.
        // T_k of even k at the Gauss nodes of the Chebyshev density: Q T_2n = −1, I T_2n = 0; of the point masses at ±1: I = 1.
        let (coefficient, exact, rule) = (2.0, 1.0, 1.0);
        assert_eq!(GAUSS_ERROR_FACTOR, coefficient * (exact + rule));
        // T_2n on a wide ellipse: M = ½ϱ^{2n}; the bound is then 2 |I − Q| at least, |I − Q| ≤ 2.
        assert!((gauss_error(3, 1e3, 0.5 * 1e18) - 2.0).abs() < 1e-5);
    }

    /// A pole beside the interval: the bound holds and is within a factor of a hundred.
    #[test]
    fn gauss_error_bounds_a_pole_closely() {
        for plateau in [0.0, 0.5, 1.0] {
            let f = |x: f64| 1.0 / (x - 1.5);
            let exact: f64 = {
                let r = trapezoid_rule(MAX_POINTS, plateau);
                r.nodes.iter().zip(&r.weights).map(|(x, w)| w * f(*x)).sum()
            };
            for n in 1..12 {
                let r = trapezoid_rule(n, plateau);
                let got: f64 = r.nodes.iter().zip(&r.weights).map(|(x, w)| w * f(*x)).sum();
                let bound = (1..60)
                    .map(|i| {
                        let a = 1.0 + 0.5 * i as f64 / 60.0;
                        gauss_error(n, a + (a * a - 1.0).sqrt(), 1.0 / (1.5 - a))
                    })
                    .fold(f64::INFINITY, f64::min);
                let off = (got - exact).abs();
                assert!(off <= bound + 1e-15 && bound <= 3000.0 * off + 1e-14, "n={n}: {off:e} {bound:e}");
            }
        }
    }

    #[test]
    fn min_square_distance_bounds_every_position() {
        for (g, h) in [(1.0, 1.0), (3.0, 1.0), (0.4, 1.0), (20.0, 1.0)] {
            for (rho, m) in ellipse_ratios(g, h, 3.0 * h * h) {
                let (a, b) = (0.5 * h * (rho + 1.0 / rho), 0.5 * h * (rho - 1.0 / rho));
                let least = ((g + 3f64.sqrt() * h).powi(2) + h * h) / m;
                for i in 0..=40 {
                    let x = (g + h) * i as f64 / 40.0;
                    let c2 = g * g - (x - h).max(0.0).powi(2);
                    for k in 0..200 {
                        let t = k as f64 * std::f64::consts::TAU / 200.0;
                        let (re, im) = (x + a * t.cos(), b * t.sin());
                        let (u, v) = (re * re - im * im + c2, 2.0 * re * im);
                        assert!(u.hypot(v) >= least * (1.0 - 1e-9), "{g} {h} {x}");
                    }
                }
            }
        }
    }
}
