//! Truncated power series in two variables, by total degree: Σ c_{pq} ξ^p ζ^q, p + q ≤ N.
//!
//! Norm ‖a‖ = Σ|a_{pq}|: the largest modulus on |ξ|, |ζ| ≤ 1 is at most ‖a‖, ‖ab‖ ≤ ‖a‖‖b‖, truncating a series does not increase it.
//!
//! **h = ρ⁻²** by its differential equation: with E = ξ∂_ξ + ζ∂_ζ, ρ E h = −2 h E ρ. For the coefficients, |α| = p + q,
//!
//! ```text
//! h_α = −1/(|α| ρ_0) Σ_{0<β≤α} (|α| + |β|) ρ_β h_{α−β};
//! ```
//!
//! with ρ = r²(1 − 2 cosθ ξ + ξ²) these are the Gegenbauer polynomials of λ = 2. **Rounding**: the computed series satisfies ρEh + 2hEρ = r with
//! |r_α|/|α| ≤ 2γ Σ|ρ_β||h_{α−β}|, γ = (terms + 6)ε. Put h = ρ⁻²t: then Et = ρr, so the error is ρ⁻²E⁻¹(ρr), and ‖E⁻¹(ρr)‖ ≤ ‖ρ‖‖E⁻¹r‖. Hence
//! ‖δh‖ ≤ k‖ρ⁻²‖ with k = 2γ‖ρ‖²‖h‖, that is at most k‖h‖/(1 − k); the rounding of h_0 adds 3ε of the whole.

use crate::rounding::UNIT_ROUNDOFF;

/// Largest total degree of a development.
pub const MAX_ORDER: usize = 24;
/// Roundings of a term besides those of the sum: two products, 1/ρ_0, its quotient by |α| and product, and one for second orders.
const RECURRENCE_ROUNDINGS: f64 = 6.0; // bound
/// Roundings of h_0 = (1/ρ_0)²: the quotient's twice and the product's; and one for second orders.
const CONSTANT_TERM_ROUNDINGS: f64 = 4.0; // bound

/// Coefficients up to a total degree.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PowerSeries {
    pub order: usize,
    pub c: Vec<f64>,
}

/// The place of ξ^p ζ^q.
pub(super) fn coefficient_index(p: usize, q: usize) -> usize {
    (p + q) * (p + q + 1) / 2 + q
}

impl PowerSeries {
    pub(super) fn zero(order: usize) -> PowerSeries {
        PowerSeries { order, c: vec![0.0; coefficient_index(0, order) + 1] }
    }

    /// The outer product of two series in one variable, times a factor, added.
    pub(super) fn add_outer(&mut self, factor: f64, f: &[f64], g: &[f64]) {
        for (p, x) in f.iter().enumerate().filter(|(_, x)| **x != 0.0) {
            for (q, y) in g[..=self.order - p].iter().enumerate() {
                self.c[coefficient_index(p, q)] += factor * x * y;
            }
        }
    }

    /// Adds factor·o.
    pub(super) fn add(&mut self, factor: f64, o: &PowerSeries) {
        for (x, y) in self.c.iter_mut().zip(&o.c) {
            *x += factor * y;
        }
    }

    /// Adds factor·a·b.
    pub(super) fn add_product(&mut self, factor: f64, a: &PowerSeries, b: &PowerSeries) {
        for n in 0..=self.order {
            for q in 0..=n {
                let x = factor * a.c[coefficient_index(n - q, q)];
                if x == 0.0 {
                    continue;
                }
                for m in 0..=self.order - n {
                    let (from, to) = (coefficient_index(m, 0), coefficient_index(m + n - q, q));
                    for (s, y) in self.c[to..=to + m].iter_mut().zip(&b.c[from..=from + m]) {
                        *s += x * y;
                    }
                }
            }
        }
    }

    /// ‖·‖.
    pub(super) fn norm(&self) -> f64 {
        self.c.iter().map(|x| x.abs()).sum()
    }

    /// ρ⁻² into `out`, and a bound of ‖δ‖ for its rounding: infinite if it cannot be had.
    pub(super) fn inverse_square(&self, out: &mut PowerSeries) -> f64 {
        let order = self.order;
        let first = 1.0 / self.c[0];
        out.c.fill(0.0);
        out.c[0] = first * first;
        let rows: Vec<usize> = (1..=order)
            .filter(|m| self.c[coefficient_index(*m, 0)..=coefficient_index(0, *m)].iter().any(|x| *x != 0.0))
            .collect();
        // Scatter: h_β, once known, goes into all higher h_α.
        for n in 0..=order {
            for q in 0..=n {
                let at = coefficient_index(n - q, q);
                if n > 0 {
                    out.c[at] *= -first / n as f64;
                }
                let h = out.c[at];
                for m in rows.iter().take_while(|m| n + **m <= order) {
                    let x = (n + 2 * m) as f64 * h;
                    let (from, to) = (coefficient_index(*m, 0), coefficient_index(n - q + m, q));
                    for (a, b) in out.c[to..=to + m].iter_mut().zip(&self.c[from..=from + m]) {
                        *a += x * b;
                    }
                }
            }
        }
        let terms: usize = rows.iter().map(|m| m + 1).sum();
        let h = out.norm();
        let k = 2.0 * (terms as f64 + RECURRENCE_ROUNDINGS) * UNIT_ROUNDOFF * self.norm().powi(2) * h;
        if k < 0.5 { h * (k / (1.0 - k) + CONSTANT_TERM_ROUNDINGS * UNIT_ROUNDOFF) } else { f64::INFINITY }
    }
}

/// Means of ξ^p over [a, b], p ≤ order: Σ_k a^k b^{p−k}/(p+1), without cancellation where a and b have one sign.
pub(super) fn power_means(a: f64, b: f64, order: usize) -> [f64; MAX_ORDER + 1] {
    let mut out = [0.0; MAX_ORDER + 1];
    let (mut sum, mut power) = (1.0, 1.0);
    for (p, x) in out[..=order].iter_mut().enumerate() {
        if p > 0 {
            power *= b;
            sum = a * sum + power;
        }
        *x = sum / (p + 1) as f64;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rho() -> PowerSeries {
        let mut s = PowerSeries::zero(12);
        for (p, q, c) in [(0, 0, 2.0), (1, 0, -0.4), (0, 1, 0.3), (2, 0, 0.11), (1, 1, 0.05), (0, 2, 0.07)] {
            s.c[coefficient_index(p, q)] = c;
        }
        s
    }

    #[test]
    fn inverse_square_times_square_is_one() {
        let (r, mut h) = (rho(), PowerSeries::zero(12));
        let error = r.inverse_square(&mut h);
        let (mut square, mut one) = (PowerSeries::zero(12), PowerSeries::zero(12));
        square.add_product(1.0, &r, &r);
        one.add_product(1.0, &square, &h);
        one.c[0] -= 1.0;
        assert!(one.norm() < 1e-14 && error < 1e-12 && error > 1e-16, "{} {error}", one.norm());
    }

    #[test]
    fn inverse_square_along_a_line_is_gegenbauer_of_index_two() {
        // C_n^2(c): 1, 4c, 12c² − 2, 32c³ − 12c.
        let c: f64 = 0.3;
        let (mut r, mut h) = (PowerSeries::zero(3), PowerSeries::zero(3));
        (r.c[coefficient_index(0, 0)], r.c[coefficient_index(1, 0)], r.c[coefficient_index(2, 0)]) =
            (1.0, -2.0 * c, 1.0);
        r.inverse_square(&mut h);
        for (n, want) in
            [1.0, 4.0 * c, 12.0 * c * c - 2.0, 32.0 * c.powi(3) - 12.0 * c].into_iter().enumerate()
        {
            assert!((h.c[coefficient_index(n, 0)] - want).abs() < 1e-15);
        }
    }

    #[test]
    fn rounding_bounds_count_their_operations() {
        let (products, quotient, over_degree, times, second_orders) = (2.0, 1.0, 1.0, 1.0, 1.0);
        assert_eq!(RECURRENCE_ROUNDINGS, products + quotient + over_degree + times + second_orders);
        assert_eq!(CONSTANT_TERM_ROUNDINGS, 2.0 * quotient + times + second_orders);
        // A chain of one term: h_n = (n + 1)(−a)^n for ρ = 1 + aξ. In half precision of the bound it would not hold for all a.
        let mut worst: f64 = 0.0;
        for k in 1..400 {
            let a = 0.001 * k as f64 + 0.3;
            let (mut r, mut h) = (PowerSeries::zero(24), PowerSeries::zero(24));
            (r.c[coefficient_index(0, 0)], r.c[coefficient_index(1, 0)]) = (1.0, a);
            let bound = r.inverse_square(&mut h);
            let exact = |n: usize| (n + 1) as f64 * (-a).powi(n as i32);
            let off: f64 = (0..=24).map(|n| (h.c[coefficient_index(n, 0)] - exact(n)).abs()).sum();
            worst = worst.max(off / bound);
        }
        assert!(worst <= 1.0 && worst > 1e-3, "{worst}");
    }

    #[test]
    fn power_means_match_closed_form() {
        let m = power_means(-0.3, 0.5, 5);
        for (p, x) in m[..=5].iter().enumerate() {
            let k = p as i32 + 1;
            let want = (0.5f64.powi(k) - (-0.3f64).powi(k)) / (0.8 * k as f64);
            assert!((x - want).abs() < 1e-16);
        }
    }
}
