//! Gauss rules with the densities as weights: no cut at the kink of a triangle density, few points for far pairs, with or without a medium.
//!
//! **Rules.** A direction's density is fixed, uniform or, for two equal extents, the triangle 1 − |x| on [−1, 1]. The n-point
//! Gauss rule of the triangle: its even moments 2/((2k+1)(2k+2)) give the recursion p_{k+1} = x p_k − β_k p_{k−1} by Chebyshev's
//! algorithm, nodes are the zeros of p_n and weights h_{n−1}/(p_n' p_{n−1}). All in double-double arithmetic: the moments'
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
//! The three directions add (see `separated_cells.rs`); M is the supremum of the complexified kernel as there: with the other two variables
//! real, c² the least sum of their squares, semi-axis A along, R = c² + min Re z²,
//!
//! ```text
//! M = Π_{j≠k} (c_j + h_j)^{p_j} · (c_k + A)^{p_k} · R^{−q/2} e^{−κ√R}.
//! ```
//!
//! **Rounding.** The rules apply to D ≤ `MAX_SIZE_OVER_DISTANCE`·r as in `moment_series.rs`, so |t| ≥ 0.4 r. A node t = c + hx is within
//! 3ε(|c| + h) ≤ 4.8 ε r √3 in all, and the geometry adds 4.4 ε r: 1/|t|^q has q·(33 + 6)ε; numerators (t from the near end, all terms positive) 8ε each; weights, lengths, mass, π: 30ε; sums 3·9ε;
//! the attenuation κ|t|·36ε + 4ε with κ|t| ≤ 1.6 κr. In all (280 + 60 κr)ε, which also covers extents that
//! differ by two ulp and are taken for equal: 24ε.

mod family;
mod plan;
mod triangle_rule;

pub(super) use family::{DensityFamily, RulePlan, power, shell};
pub(super) use plan::PlanHint;

#[cfg(test)]
mod tests {
    use super::family::{DensityKind, ROUNDINGS, ROUNDINGS_PER_DEPTH};
    use super::plan::{COEFFICIENT_BOUND, NORM_BOUND, defect};
    use super::triangle_rule::{MAX_RULE_POINTS, triangle};

    #[test]
    fn triangle_rules_are_exact_for_moments() {
        // Two points: x² = 1/6. Three: x² = 2/5, weights 5/24, 7/12, 5/24.
        assert!((triangle(2).nodes[0] + (1.0f64 / 6.0).sqrt()).abs() < 2e-16);
        assert!((triangle(3).weights[1] - 7.0 / 12.0).abs() < 2e-16);
        for n in 1..=MAX_RULE_POINTS {
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
    fn bound_of_chebyshev(kind: DensityKind, n: usize, rho: f64) -> f64 {
        let per = 1.0 / (rho * rho);
        let m = 0.5 * (rho.powi(2 * n as i32) + rho.powi(-2 * n as i32));
        COEFFICIENT_BOUND * m * rho.powi(-2 * n as i32) * (defect(kind, n) + NORM_BOUND * per / (1.0 - per))
    }

    #[test]
    fn chebyshev_polynomials_attain_error_bound() {
        for n in 1..=MAX_RULE_POINTS {
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
                assert!(error <= bound_of_chebyshev(DensityKind::Triangle, n, rho) + 1e-9, "{n} {rho}");
            }
            assert!(error >= 0.99 * bound_of_chebyshev(DensityKind::Triangle, n, 1e3), "{n}: {error}");
        }
    }

    #[test]
    fn norm_bound_equals_norms_of_integral_and_rule() {
        for n in 1..=MAX_RULE_POINTS {
            let q: f64 = triangle(n).weights.iter().map(|w| w.abs()).sum();
            assert!(1.0 + q <= NORM_BOUND * (1.0 + 1e-14) && NORM_BOUND <= (1.0 + q) * (1.0 + 1e-14));
        }
    }

    #[test]
    fn rounding_constants_cover_their_counts() {
        let (kernel, numerator, weights, sums, exponential, extents) =
            (4.0 * 39.0, 16.0, 30.0, 27.0, 4.0, 24.0);
        assert!(ROUNDINGS >= kernel + numerator + weights + sums + exponential + extents);
        let (farthest, a_path) = (1.0 + crate::aligned::moment_series::MAX_SIZE_OVER_DISTANCE, 36.0);
        assert!(ROUNDINGS_PER_DEPTH >= farthest * a_path);
    }
}
