//! Gauss–Legendre quadrature rules on [0, 1] and the proved bound of their error.
//!
//! Nodes are the zeros of P_n, weights w = 2/((1−x²) P_n'(x)²). Newton's iteration starts from Tricomi's approximation, ends in
//! double-double arithmetic and is rounded once: nodes in [0, 1] and weights carry a **relative** error of at most 2⁻⁵². Each rule is
//! computed once a process and cached.
//!
//! **Error.** If f is analytic inside the Bernstein ellipse of parameter ϱ > 1 (the image of |z| = ϱ under
//! (z + 1/z)/2) and |f| ≤ M there, the n-point rule on [−1,1] errs by at most
//! (64/15) M ϱ^{−2n} / (1 − ϱ^{−2}) (Trefethen, Approximation Theory and Approximation Practice, Theorem 19.3).

use crate::double_double::DoubleDouble;
use std::sync::OnceLock;

/// The largest number of points of a rule.
pub const MAX_POINTS: usize = 64;

/// Nodes and weights of a quadrature rule on [0, 1]; the weights sum to one.
#[derive(Debug)]
pub struct QuadratureRule {
    /// Nodes in (0, 1), ascending.
    pub nodes: Vec<f64>,
    /// Weights, positive.
    pub weights: Vec<f64>,
}

/// The `n`-point Gauss–Legendre rule on [0, 1], exact for polynomials of degree 2n − 1.
///
/// ```
/// let rule = zonal_math::gauss_legendre::rule(3);
/// let integral: f64 = rule.nodes.iter().zip(&rule.weights).map(|(x, w)| w * x.powi(5)).sum();
/// assert!((integral - 1.0 / 6.0).abs() < 1e-15);
/// ```
///
/// # Panics
/// If `n` is zero or above [`MAX_POINTS`].
pub fn rule(n: usize) -> &'static QuadratureRule {
    static RULES: [OnceLock<QuadratureRule>; MAX_POINTS + 1] = [const { OnceLock::new() }; MAX_POINTS + 1];
    assert!((1..=MAX_POINTS).contains(&n), "a Gauss rule has 1 to {MAX_POINTS} points, not {n}");
    RULES[n].get_or_init(|| compute_rule(n))
}

/// P_n and its derivative at x, |x| < 1.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut p0, mut p1) = (1.0, x);
    for k in 2..=n {
        let k = k as f64;
        (p0, p1) = (p1, ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k);
    }
    (p1, n as f64 * (x * p1 - p0) / (x * x - 1.0))
}

fn compute_rule(n: usize) -> QuadratureRule {
    let mut nodes = vec![0.0; n];
    let mut weights = vec![0.0; n];
    for i in 0..n.div_ceil(2) {
        let (near, far, w) = node(n, i);
        (nodes[i], nodes[n - 1 - i]) = (near, far);
        (weights[i], weights[n - 1 - i]) = (w, w);
    }
    QuadratureRule { nodes, weights }
}

/// The `i`-th node on [0, 1] counted from either end, with its weight: ((1−x)/2, (1+x)/2, 1/((1−x²)P_n'²)).
fn node(n: usize, i: usize) -> (f64, f64, f64) {
    let x = DoubleDouble::new(legendre_zero(n, i));
    // Two Newton steps in double-double arithmetic double the number of digits twice.
    let x = x.sub(newton_step(n, x));
    let x = if 2 * i + 1 == n { DoubleDouble::new(0.0) } else { x.sub(newton_step(n, x)) };
    let (_, d) = legendre_double_double(n, x);
    let one = DoubleDouble::new(1.0);
    let w = one.div(one.sub(x.mul(x)).mul(d).mul(d));
    let half = DoubleDouble::new(0.5);
    (half.mul(one.sub(x)).hi, half.mul(one.add(x)).hi, w.hi)
}

/// Largest number of Newton steps in double precision.
const MAX_NEWTON_STEPS: usize = 100;
/// Length of a Newton step on [−1, 1] below which the iteration ends.
const NEWTON_STEP_LIMIT: f64 = 1e-15;

/// The `i`-th zero of P_n from the right end of [−1, 1], in double precision.
fn legendre_zero(n: usize, i: usize) -> f64 {
    let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
    for _ in 0..MAX_NEWTON_STEPS {
        let (p, d) = legendre(n, x);
        let step = p / d;
        x -= step;
        if step.abs() < NEWTON_STEP_LIMIT {
            break;
        }
    }
    x
}

/// P_n/P_n' at x.
fn newton_step(n: usize, x: DoubleDouble) -> DoubleDouble {
    let (p, d) = legendre_double_double(n, x);
    p.div(d)
}

/// P_n and its derivative at x in double-double arithmetic.
fn legendre_double_double(n: usize, x: DoubleDouble) -> (DoubleDouble, DoubleDouble) {
    let (mut p0, mut p1) = (DoubleDouble::new(1.0), x);
    for k in 2..=n {
        let k = k as f64;
        let next = DoubleDouble::new(2.0 * k - 1.0).mul(x).mul(p1).sub(DoubleDouble::new(k - 1.0).mul(p0));
        (p0, p1) = (p1, next.div(DoubleDouble::new(k)));
    }
    let slope = DoubleDouble::new(n as f64).mul(x.mul(p1).sub(p0)).div(x.mul(x).sub(DoubleDouble::new(1.0)));
    (p1, slope)
}

/// Trefethen's constant 64/15, halved for an interval of length one instead of two.
pub const TREFETHEN_CONSTANT: f64 = 32.0 / 15.0; // bound

/// Bound of the error of the `n`-point rule on the **unit** interval for |f| ≤ `m` on the Bernstein ellipse of parameter `rho` > 1.
///
/// ```
/// use zonal_math::gauss_legendre::{error_bound, points_for};
/// let n = points_for(3.0, 1.0, 1e-12);
/// assert!(error_bound(n, 3.0, 1.0) <= 1.000_001e-12);
/// assert!(error_bound(n - 1, 3.0, 1.0) > 1e-12);
/// ```
pub fn error_bound(n: usize, rho: f64, m: f64) -> f64 {
    let r2 = rho * rho;
    TREFETHEN_CONSTANT * m * r2.powi(-(n as i32)) / (1.0 - 1.0 / r2)
}

/// The smallest number of points, at least one, for which [`error_bound`] is at most `budget`, up to rounding; above every available rule
/// if the budget is not positive or `m` or `rho` is not finite.
pub fn points_for(rho: f64, m: f64, budget: f64) -> usize {
    let r2 = rho * rho;
    let n = ((TREFETHEN_CONSTANT * m / (1.0 - 1.0 / r2)).ln() - budget.max(0.0).ln()) / r2.ln();
    if n.is_nan() { UNREACHABLE_POINTS } else { n.ceil().clamp(1.0, UNREACHABLE_POINTS as f64) as usize }
}

/// A number of points above [`MAX_POINTS`], returned where no rule is known to meet the budget.
const UNREACHABLE_POINTS: usize = 1_000_000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_exact_for_polynomials() {
        for n in [1, 2, 3, 5, 8, 20, 33, 64] {
            let r = rule(n);
            for degree in [0, 1, n, 2 * n - 1] {
                let got: f64 = r
                    .nodes
                    .iter()
                    .zip(&r.weights)
                    .map(|(x, w)| w * (2.0 * x - 1.0).powi(degree as i32))
                    .sum();
                let want = if degree % 2 == 0 { 1.0 / (degree as f64 + 1.0) } else { 0.0 };
                assert!((got - want).abs() < 4e-15, "n={n} degree={degree}: {got} against {want}");
            }
        }
    }

    #[test]
    fn points_for_is_the_smallest_sufficient_number() {
        for (rho, m, budget) in [(1.3, 2.0, 1e-6), (3.0, 0.1, 1e-12), (40.0, 1e5, 1e-9)] {
            let n = points_for(rho, m, budget);
            assert!(error_bound(n, rho, m) <= budget * (1.0 + 1e-9));
            assert!(n == 1 || error_bound(n - 1, rho, m) > budget);
        }
        assert!(points_for(2.0, 1.0, 0.0) > MAX_POINTS && points_for(2.0, 1e-9, 1.0) == 1);
    }

    #[test]
    fn nodes_and_weights_are_relatively_accurate() {
        // n = 5 in closed form: x = sqrt(5 + 2 sqrt(10/7))/3, w = (322 - 13 sqrt 70)/1800 on the unit interval.
        let r = rule(5);
        assert!((r.nodes[0] / 0.046_910_077_030_668_004 - 1.0).abs() < 3e-16);
        assert!((r.weights[0] / 0.118_463_442_528_094_54 - 1.0).abs() < 3e-16);
        // n = 64: the first node and weight (Newton's iteration in 50 decimal digits, mapped to [0, 1]).
        let r = rule(64);
        assert!((r.nodes[0] / 0.000_347_479_132_113_930_3 - 1.0).abs() < 3e-16);
        assert!((r.weights[0] / 0.000_891_640_360_848_216_5 - 1.0).abs() < 3e-16);
    }

    /// The error for T_{2n}, which the n-point rule cannot resolve, is 74 % of the bound on wide ellipses and never above the bound.
    #[test]
    fn error_bound_is_nearly_attained() {
        for n in [2usize, 5, 8, 20, 40] {
            let r = rule(n);
            let chebyshev = |u: f64| (2.0 * n as f64 * (2.0 * u - 1.0).clamp(-1.0, 1.0).acos()).cos();
            let got: f64 = r.nodes.iter().zip(&r.weights).map(|(u, w)| w * chebyshev(*u)).sum();
            let error = (got + 1.0 / (4.0 * (n * n) as f64 - 1.0)).abs();
            let ratio = |rho: f64| {
                let m = 0.5 * (rho.powi(2 * n as i32) + rho.powi(-2 * n as i32));
                error / error_bound(n, rho, m)
            };
            assert!(ratio(30.0) > 0.65 && ratio(30.0) < 1.0, "{n}: {}", ratio(30.0));
            assert!([1.5, 3.0, 8.0].iter().all(|&rho| ratio(rho) <= 1.0));
        }
    }

    #[test]
    fn error_bound_holds_for_a_pole() {
        // f(x) = 1/(x + a) on [0,1]: on [-1,1] the pole lies at -(1+2a), and M is its value at the ellipse's left end.
        let a: f64 = 0.3;
        let exact = ((1.0 + a) / a).ln();
        for n in 1..20 {
            let r = rule(n);
            let got: f64 = r.nodes.iter().zip(&r.weights).map(|(x, w)| w / (x + a)).sum();
            let pole = 1.0 + 2.0 * a;
            let rho = 0.9 * (pole + (pole * pole - 1.0).sqrt());
            let left = 0.5 * (rho + 1.0 / rho);
            let m = 2.0 / (pole - left);
            assert!((got - exact).abs() <= error_bound(n, rho, m) + 4e-16 * exact, "n={n}");
        }
    }
}
