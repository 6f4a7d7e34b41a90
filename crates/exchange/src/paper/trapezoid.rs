//! Gauss rules for the difference of two uniform coordinates, and how many points they need.
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
//! **The rule itself** is floating-point: whatever its nodes and weights are, δ = max_{k<2n} |Q T_k − I T_k| is measured when it is
//! made (the rounding of the measurement added: T_k = cos(k acos x) errs by at most (2πk + 2)ε), and adds δ M (1 + ϱ^{−2})/(1 − ϱ^{−2}).
//!
//! **For the kernel 1/|t|²** and boxes at least g apart in t (g the distance of the support from 0), direction k complex on an ellipse with
//! semi-axes A along, B across, c² the least sum of the other squares, |t·t| ≥ R with (header of `aligned::ellipse`)
//!
//! ```text
//! R = c² + X²β − B², β = B²/(A² + B²), if XA ≤ A² + B², else c² + (X − A)²;   c² + max(X − h, 0)² = g².
//! ```
//!
//! For fixed g this is concave and continuously differentiable in X on [h, g + h] and grows on [0, h], so it is least at X = 0 or at X = g + h (c = 0):
//! [`floor`]. With E|t|² ≤ (g + |h|)² + |h|²/3 and Jensen, E 1/|t|² ≥ 1/E|t|², the error relative to the integral is at most
//! 4ϱ^{−2n}/(1 − ϱ^{−2}) · E|t|²/R for each direction, and for fixed ϱ that falls with g. [`Ladder`] keeps it by steps of g.

use std::cell::Cell;
use std::sync::OnceLock;
use zonal_math::gauss;

const EPS: f64 = 0.5 * f64::EPSILON;
/// Bound of a Chebyshev coefficient over M ϱ^{−k}, times |I T_k| + |Q T_k| ≤ 2.
const GAUSS: f64 = 2.0 * (1.0 + 1.0); // bound
/// The most points of a rule.
pub(super) const MOST: usize = 24;

/// A rule on [−1, 1], weights of sum one.
#[derive(Clone, Debug)]
pub(super) struct Rule {
    pub nodes: Vec<f64>,
    pub weights: Vec<f64>,
    /// max |Q T_k − I T_k| below the degree of exactness.
    pub defect: f64,
}

/// The `n`-point rule for the density that is level on |u| ≤ `plateau` and falls to zero at |u| = 1;
/// `plateau` = 1 is the uniform density.
pub(super) fn rule(n: usize, plateau: f64) -> Rule {
    let fine = fine(n, plateau);
    let beta = recurrence(n, &fine);
    let nodes = zeros(n, &beta);
    let weights = nodes.iter().map(|&x| christoffel(n, &beta, x)).collect();
    let mut rule = Rule { nodes, weights, defect: 0.0 };
    rule.defect = defect(&rule, &fine);
    rule
}

/// The rule of two equal extents, a triangle: made once, as those of [`gauss`] are.
pub(super) fn triangle(n: usize) -> &'static Rule {
    static RULES: [OnceLock<Rule>; MOST + 1] = [const { OnceLock::new() }; MOST + 1];
    RULES[n].get_or_init(|| rule(n, 0.0))
}

/// Points on [0, 1] and weights of sum one that integrate even polynomials of degree ≤ 2n + 1 times the density exactly.
fn fine(n: usize, plateau: f64) -> Vec<(f64, f64)> {
    let r = gauss::rule(n + 1);
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
fn recurrence(n: usize, fine: &[(f64, f64)]) -> Vec<f64> {
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
fn monic(n: usize, beta: &[f64], x: f64) -> (f64, f64) {
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
    let rising = monic(k, beta, high).0 > 0.0;
    let mut x = 0.5 * (low + high);
    for _ in 0..100 {
        let (p, d) = monic(k, beta, x);
        if (p > 0.0) == rising {
            high = x
        } else {
            low = x
        }
        let newton = x - p / d;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        let step = (next - x).abs();
        x = next;
        if step <= 2.0 * EPS {
            break;
        }
    }
    x
}

/// The weight at a zero: 1/Σ p_k²/‖p_k‖².
fn christoffel(n: usize, beta: &[f64], x: f64) -> f64 {
    let (mut p0, mut p1, mut norm, mut sum) = (0.0, 1.0, 1.0, 1.0);
    for k in 1..n {
        (p0, p1) = (p1, x * p1 - beta[k - 1] * p0);
        norm *= beta[k];
        sum += p1 * p1 / norm;
    }
    1.0 / sum
}

fn defect(rule: &Rule, fine: &[(f64, f64)]) -> f64 {
    let n = rule.nodes.len();
    let angle = |x: f64| x.clamp(-1.0, 1.0).acos();
    let ours: Vec<(f64, f64)> = rule.nodes.iter().zip(&rule.weights).map(|(&x, &w)| (angle(x), w)).collect();
    let theirs: Vec<(f64, f64)> = fine.iter().map(|&(x, w)| (angle(x), w)).collect();
    let mean = |points: &[(f64, f64)], k: usize| -> f64 {
        points.iter().map(|&(t, w)| w * (k as f64 * t).cos()).sum()
    };
    let worst = (0..n).map(|k| (mean(&ours, 2 * k) - mean(&theirs, 2 * k)).abs()).fold(0.0, f64::max);
    // Two evaluations of T_k, k < 2n, at (2πk + 2)ε each; the sums and the fine weights 20ε.
    worst + (26.0 * n as f64 + 24.0) * EPS
}

/// One axis of a pair: what the density of t looks like there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shape {
    /// Half the width of the support.
    pub half: f64,
    /// The inner share on which the density is level.
    pub plateau: f64,
    /// Variance of t.
    pub variance: f64,
}

impl Shape {
    /// The shape for two extents.
    pub(super) fn new(a: f64, b: f64) -> Shape {
        let plateau = if a + b > 0.0 { (a - b).abs() / (a + b) } else { 1.0 };
        Shape { half: 0.5 * (a + b), plateau, variance: (a * a + b * b) / 12.0 }
    }
}

/// Shares of the widest ellipse that are tried.
const FRACTIONS: [f64; 6] = [0.95, 0.88, 0.78, 0.62, 0.42, 0.25];

/// The least |t·t| over all positions of a box at distance `g`, one coordinate on an ellipse of semi-axes (a, b) around
/// an interval of half-length `h`.
fn floor(g: f64, h: f64, a: f64, b: f64) -> f64 {
    let x = g + h;
    let axial =
        if x * a >= a * a + b * b { (x - a) * (x - a) } else { b * b * (x * x / (a * a + b * b) - 1.0) };
    axial.min(g * g - b * b)
}

/// (ϱ, E|t|²/R) of the ellipses for an interval of half-length `h` in boxes of half-extents with squared sum `h2`, g apart.
pub(super) fn ellipses(g: f64, h: f64, h2: f64) -> impl Iterator<Item = (f64, f64)> {
    let widest = g.min((0.5 * g * (g + 2.0 * h)).sqrt());
    let reach = g + h2.sqrt();
    let square = reach * reach + h2 / 3.0;
    FRACTIONS.into_iter().filter_map(move |f| {
        let b = f * widest;
        let a = (b * b + h * h).sqrt();
        let least = floor(g, h, a, b);
        (least > 0.0).then(|| ((a + b) / h, square / least))
    })
}

/// Bound 4 m ϱ^{−2n}/(1 − ϱ^{−2}) of an n-point rule.
pub(super) fn error(n: usize, rho: f64, m: f64) -> f64 {
    let r2 = rho * rho;
    GAUSS * m * r2.powi(-(n as i32)) / (1.0 - 1.0 / r2)
}

/// What a rule does at a distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// Points.
    pub points: usize,
    /// Error of the direction relative to the integral, exact nodes and weights given.
    pub error: f64,
    /// What multiplies the rule's defect.
    pub factor: f64,
}

/// Points for one axis by the distance of the boxes, worked out as they are asked for.
#[derive(Debug)]
pub(super) struct Ladder {
    /// Half-lengths of the intervals (zero: none), and how many points: given, or as many as a tolerance needs.
    halves: [f64; 2],
    points: Option<usize>,
    tolerance: f64,
    /// Squared sum of the boxes' half-extents.
    h2: f64,
    steps: [Cell<Option<Step>>; STEPS * DOUBLINGS],
}

/// Steps a doubling of the distance, and the doublings from an eighth of the boxes' half-diagonal up.
const STEPS: usize = 4;
const DOUBLINGS: usize = 14;
/// 2^{i/4}.
const FRACTION: [f64; STEPS] = [1.0, 1.189_207_115_002_721, std::f64::consts::SQRT_2, 1.681_792_830_507_429];

impl Ladder {
    /// For intervals of half-length `half` in boxes whose half-extents have the squared sum `h2`: the points that keep the relative error of
    /// this direction below `tolerance`.
    pub(super) fn new(half: f64, h2: f64, tolerance: f64) -> Ladder {
        Ladder {
            halves: [half, 0.0],
            points: None,
            tolerance,
            h2,
            steps: [const { Cell::new(None) }; STEPS * DOUBLINGS],
        }
    }

    /// For two Gauss–Legendre rules of `points` points over the two extents.
    pub(super) fn fixed(extents: [f64; 2], h2: f64, points: usize) -> Ladder {
        let halves = extents.map(|x| 0.5 * x);
        Ladder { points: Some(points), halves, ..Ladder::new(0.0, h2, 0.5) }
    }

    /// The step that serves boxes at distance `g`, if any does.
    pub(super) fn at(&self, g: f64) -> Option<Step> {
        let least = 0.125 * self.h2.sqrt();
        let ratio = g / least * (1.0 - 1e-12);
        if ratio.is_nan() || ratio < 1.0 {
            return None;
        }
        let exponent = (ratio.to_bits() >> 52) as usize - 1023;
        let rest = ratio / f64::from_bits(((exponent + 1023) as u64) << 52);
        let i = (exponent * STEPS + FRACTION.iter().filter(|f| **f <= rest).count() - 1)
            .min(STEPS * DOUBLINGS - 1);
        let step = self.steps[i].get().unwrap_or_else(|| {
            let power = f64::from_bits(((i / STEPS + 1023) as u64) << 52);
            self.make(least * power * FRACTION[i % STEPS])
        });
        self.steps[i].set(Some(step));
        (step.error <= 1.000_001 * self.tolerance && step.points <= MOST).then_some(step)
    }

    fn make(&self, g: f64) -> Step {
        let mut step = Step { points: self.points.unwrap_or(1), error: 0.0, factor: 0.0 };
        for half in self.halves.into_iter().filter(|h| *h > 0.0) {
            let (mut points, mut least, mut factor) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
            for (rho, m) in ellipses(g, half, self.h2) {
                let r2 = rho * rho;
                factor = factor.min(m * (r2 + 1.0) / (r2 - 1.0));
                if let Some(n) = self.points {
                    least = least.min(error(n, rho, m));
                    continue;
                }
                let front = GAUSS * m / ((1.0 - 1.0 / r2) * self.tolerance);
                let needed = (front.ln() / r2.ln()).ceil().max(1.0);
                if needed < points && needed <= MOST as f64 {
                    (points, least) = (needed, error(needed as usize, rho, m));
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
            for n in 1..=MOST {
                let r = rule(n, plateau);
                let slack = (26.0 * n as f64 + 24.0) * EPS;
                assert!(r.defect <= slack + 1e-14, "n={n} plateau={plateau} {:e}", r.defect - slack);
                assert!(r.weights.iter().all(|&w| w > 0.0) && r.nodes.is_sorted());
                assert!(r.nodes.iter().zip(r.nodes.iter().rev()).all(|(a, b)| *a == -b));
            }
        }
        // The uniform density is Legendre's.
        let (r, g) = (rule(7, 1.0), gauss::rule(7));
        for i in 0..7 {
            assert!((0.5 * (r.nodes[i] + 1.0) - g.nodes[i]).abs() < 2e-16);
            assert!((r.weights[i] - g.weights[i]).abs() < 2e-16);
        }
    }

    /// The triangle's second moment is 1/6, its fourth 1/15; the trapezoid's variance is that of two uniforms.
    #[test]
    fn moments_of_the_densities() {
        let r = rule(3, 0.0);
        let moment =
            |r: &Rule, k: i32| -> f64 { r.nodes.iter().zip(&r.weights).map(|(x, w)| w * x.powi(k)).sum() };
        assert!((moment(&r, 2) - 1.0 / 6.0).abs() < 1e-15 && (moment(&r, 4) - 1.0 / 15.0).abs() < 1e-15);
        let s = Shape::new(1.0, 3.0);
        let got = moment(&rule(3, s.plateau), 2) * s.half * s.half;
        assert!((got - s.variance).abs() < 1e-14 && s.plateau == 0.5);
    }

    /// A defect is seen: a weight changed by 1e-10 shows.
    #[test]
    fn the_defect_is_measured() {
        let fine = fine(5, 0.0);
        let mut r = rule(5, 0.0);
        r.weights[2] += 1e-10;
        assert!(defect(&r, &fine) >= 0.9e-10);
    }

    #[test]
    fn the_constant_is_its_derivation() {
        // Coefficients of a function bounded by M: 2 M ϱ^{-k}, reached by none but approached: (1/π)∫ f cos(kθ) dθ · ... ≤ 2 M ϱ^{-k}.
        // T_k of even k at the Gauss nodes of the Chebyshev density: Q T_2n = −1, I T_2n = 0; of the point masses at ±1: I = 1.
        let (coefficient, exact, rule) = (2.0, 1.0, 1.0);
        assert_eq!(GAUSS, coefficient * (exact + rule));
        // T_2n on a wide ellipse: M = ½ϱ^{2n}; the bound is then 2 |I − Q| at least, |I − Q| ≤ 2.
        assert!((error(3, 1e3, 0.5 * 1e18) - 2.0).abs() < 1e-5);
    }

    /// A pole beside the interval: the bound holds and is within a factor of a hundred.
    #[test]
    fn the_error_bound_holds_and_is_near() {
        for plateau in [0.0, 0.5, 1.0] {
            let f = |x: f64| 1.0 / (x - 1.5);
            let exact: f64 = {
                let r = rule(MOST, plateau);
                r.nodes.iter().zip(&r.weights).map(|(x, w)| w * f(*x)).sum()
            };
            for n in 1..12 {
                let r = rule(n, plateau);
                let got: f64 = r.nodes.iter().zip(&r.weights).map(|(x, w)| w * f(*x)).sum();
                let bound = (1..60)
                    .map(|i| {
                        let a = 1.0 + 0.5 * i as f64 / 60.0;
                        error(n, a + (a * a - 1.0).sqrt(), 1.0 / (1.5 - a))
                    })
                    .fold(f64::INFINITY, f64::min);
                let off = (got - exact).abs();
                assert!(off <= bound + 1e-15 && bound <= 3000.0 * off + 1e-14, "n={n}: {off:e} {bound:e}");
            }
        }
    }

    #[test]
    fn the_floor_is_below_every_position() {
        for (g, h) in [(1.0, 1.0), (3.0, 1.0), (0.4, 1.0), (20.0, 1.0)] {
            for (rho, m) in ellipses(g, h, 3.0 * h * h) {
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
