//! Gauss–Jacobi quadrature rules for triangles: ∫₀¹ 2(1 − u) f(u) du.
//!
//! A triangle in collapsed coordinates x = o + u e₁ + (1 − u) v e₂ has the Jacobian 1 − u. The n-point rule for that weight is exact
//! to degree 2n − 1. On [−1, 1] its nodes are the zeros of (P_n − P_{n+1})/(1 − x), one between any two zeros of P_{n+1}, and its
//! weights (1 − x²)/((n+1) P_n(x))² (the Gauss–Radau rule without its end point, Abramowitz and Stegun 25.4.31). Nodes are bracketed by
//! bisection, converged by Newton's iteration in double-double arithmetic and rounded once.
//!
//! **Error** for a function with 2n derivatives: f⁽²ⁿ⁾(ξ)/(2n)! · ∫ 2(1 − u) π_n(u)² du, with π_n the monic orthogonal polynomial:
//! the integral is 1/((n+1) binom(2n+1, n)²) ([`gauss_jacobi_remainder`]). For Legendre's rule on [0, 1] it is 1/((2n+1) binom(2n, n)²)
//! ([`gauss_legendre_remainder`]).

use crate::double_double::DoubleDouble;
use crate::gauss_legendre::{self, QuadratureRule};
use std::sync::OnceLock;

/// The largest number of points of a rule.
pub const MAX_POINTS: usize = 24;

/// The `n`-point rule for the weight 2(1 − u) on [0, 1]: nodes ascending, weights positive with sum one.
///
/// ```
/// let rule = zonal_math::gauss_jacobi::rule(2);
/// let integral: f64 = rule.nodes.iter().zip(&rule.weights).map(|(u, w)| w * u.powi(3)).sum();
/// assert!((integral - 0.1).abs() < 1e-15);
/// ```
///
/// # Panics
/// If `n` is zero or above [`MAX_POINTS`].
pub fn rule(n: usize) -> &'static QuadratureRule {
    static RULES: [OnceLock<QuadratureRule>; MAX_POINTS + 1] = [const { OnceLock::new() }; MAX_POINTS + 1];
    assert!((1..=MAX_POINTS).contains(&n), "a Gauss-Jacobi rule has 1 to {MAX_POINTS} points, not {n}");
    RULES[n].get_or_init(|| compute_rule(n))
}

/// ∫₀¹ 2(1 − u) π_n² du: the error of the `n`-point Gauss–Jacobi rule is at most this times max |f⁽²ⁿ⁾|/(2n)!.
pub fn gauss_jacobi_remainder(n: usize) -> f64 {
    1.0 / ((n as f64 + 1.0) * binomial(2 * n + 1, n).powi(2))
}

/// ∫₀¹ π_n² du: the error of the `n`-point Gauss–Legendre rule on [0, 1] is at most this times max |f⁽²ⁿ⁾|/(2n)!.
pub fn gauss_legendre_remainder(n: usize) -> f64 {
    1.0 / ((2.0 * n as f64 + 1.0) * binomial(2 * n, n).powi(2))
}

/// The binomial coefficient (n over k).
pub fn binomial(n: usize, k: usize) -> f64 {
    (1..=k).fold(1.0, |b, i| b * (n + 1 - i) as f64 / i as f64)
}

/// P_n, P_{n+1} and their derivatives at x.
fn legendre(n: usize, x: DoubleDouble) -> [DoubleDouble; 4] {
    let one = DoubleDouble::new(1.0);
    let (mut p0, mut p1) = (one, x);
    for k in 2..=n + 1 {
        let k = k as f64;
        let next = DoubleDouble::new(2.0 * k - 1.0).mul(x).mul(p1).sub(DoubleDouble::new(k - 1.0).mul(p0));
        (p0, p1) = (p1, next.div(DoubleDouble::new(k)));
    }
    let (m, denominator) = (DoubleDouble::new(n as f64 + 1.0), one.sub(x.mul(x)));
    let low = m.mul(x.mul(p0).sub(p1)).div(denominator);
    let high = m.mul(p0.sub(x.mul(p1))).div(denominator);
    [p0, p1, low, high]
}

fn compute_rule(n: usize) -> QuadratureRule {
    let zeros = &gauss_legendre::rule(n + 1).nodes;
    let mut rule = QuadratureRule { nodes: Vec::with_capacity(n), weights: Vec::with_capacity(n) };
    for k in 0..n {
        let (u, w) = node(n, 2.0 * zeros[k] - 1.0, 2.0 * zeros[k + 1] - 1.0);
        rule.nodes.push(u);
        rule.weights.push(w);
    }
    rule
}

/// Bisections before Newton's iteration: the bracket shrinks to 2⁻⁴⁰ of the distance between two zeros.
const BISECTIONS: usize = 40;
/// Newton steps in double-double arithmetic; each doubles the number of digits.
const NEWTON_STEPS: usize = 2;

/// The node between two zeros of P_{n+1} and its weight, on [0, 1].
fn node(n: usize, mut lo: f64, mut hi: f64) -> (f64, f64) {
    let g = |x: f64| {
        let [p, q, ..] = legendre(n, DoubleDouble::new(x));
        p.sub(q).hi
    };
    let rising = g(hi) > g(lo);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (lo + hi);
        if (g(middle) > 0.0) == rising { hi = middle } else { lo = middle }
    }
    let mut x = DoubleDouble::new(0.5 * (lo + hi));
    for _ in 0..NEWTON_STEPS {
        let [p, q, dp, dq] = legendre(n, x);
        x = x.sub(p.sub(q).div(dp.sub(dq)));
    }
    let (one, half) = (DoubleDouble::new(1.0), DoubleDouble::new(0.5));
    let scaled = legendre(n, x)[0].mul(DoubleDouble::new(n as f64 + 1.0));
    let w = one.sub(x.mul(x)).div(scaled.mul(scaled)).mul(half);
    (half.mul(one.add(x)).hi, w.hi)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_exact_for_polynomials() {
        for n in [1, 2, 3, 5, 8, 13, MAX_POINTS] {
            let r = rule(n);
            assert!(r.nodes.is_sorted());
            for degree in [0, 1, n, 2 * n - 1] {
                let got: f64 = r.nodes.iter().zip(&r.weights).map(|(u, w)| w * u.powi(degree as i32)).sum();
                let d = degree as f64;
                let want = 2.0 / ((d + 1.0) * (d + 2.0));
                assert!((got / want - 1.0).abs() < 2e-15, "n={n} degree={degree}: {got} against {want}");
            }
        }
    }

    /// For u^{2n} the derivative is constant and the bound equals the error.
    #[test]
    fn remainders_are_attained_by_even_powers() {
        for n in 1..8 {
            let even = 2 * n as i32;
            let exact = 2.0 / ((even as f64 + 1.0) * (even as f64 + 2.0));
            let r = rule(n);
            let got: f64 = r.nodes.iter().zip(&r.weights).map(|(u, w)| w * u.powi(even)).sum();
            assert!(((exact - got) / gauss_jacobi_remainder(n) - 1.0).abs() < 1e-6, "n={n}");
            let r = gauss_legendre::rule(n);
            let got: f64 = r.nodes.iter().zip(&r.weights).map(|(u, w)| w * u.powi(even)).sum();
            let error = 1.0 / (even as f64 + 1.0) - got;
            assert!((error / gauss_legendre_remainder(n) - 1.0).abs() < 1e-6, "n={n}");
        }
    }
}
