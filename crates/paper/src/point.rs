//! Formula (3) of the paper: the kernel at the centres, with a proven error bound.
//!
//! ```text
//! 𝓕 ≈ W f(X),   f(t) = t_x^{p_x} t_y^{p_y} t_z^{p_z} e^{−κr}/r^q,   X the difference of the centres, W = |a||b|/π.
//! ```
//!
//! **Error.** t = X + δ with a density symmetric about X: the first order vanishes, so |E f − f(X)| ≤ ½ Σ_k Var t_k · max ‖∂²f‖, the largest second
//! derivative in any direction over the support, Var t_k = (a_k² + b_k²)/12. With h(r) = e^{−κr}/r^q, the numerator's degree m and its
//! bounds r^m, m r^{m−1}, m(m−1) r^{m−2} for value, first and second directional derivative,
//!
//! ```text
//! ‖∂²f‖ ≤ r^m max(h″, |h′|/r) + 2m r^{m−1}|h′| + m(m−1) r^{m−2} h,
//! h′ = −(κ + q/r) h,   h″ = (κ² + 2qκ/r + q(q+1)/r²) h,
//! ```
//!
//! every term decreases with r and is taken at the least distance g. Parts behind a patch are clipped off first. Boxes that touch (g = 0): the radius is the
//! value plus a proven upper bound. Rounding: κr 4ε absolute, 40ε relative, the coordinate error of X.

use super::clipped_pair::{ClippedPair, clipped_pair};
use crate::rounding::UNIT_ROUNDOFF;
use zonal_exchange::aligned::Cuboid;
use zonal_exchange::{Factor, Method};
use zonal_math::Bounded;

/// ½ of the second-order Taylor term.
const SECOND_TAYLOR_COEFFICIENT: f64 = 0.5; // bound

/// Bound of the second derivatives at distance `g` or more.
fn second_derivative_bound(p: &ClippedPair, kappa: f64, g: f64) -> f64 {
    let (q, m) = (p.distance_power() as f64, p.patches as f64);
    let h = (-kappa * g).exp() * g.powi(-p.distance_power());
    let first = (kappa + q / g) * h;
    let second = (kappa * kappa + 2.0 * q * kappa / g + q * (q + 1.0) / (g * g)) * h;
    let power = g.powi(p.patches);
    power * (second.max(first / g) + 2.0 * m * first / g + m * (m - 1.0) * h / (g * g))
}

/// Returns the factor by formula (3) with e^{−κd}, κ in 1/m.
///
/// # Panics
/// On invalid boxes or a negative extinction.
pub fn factor(a: &Cuboid, b: &Cuboid, kappa: f64) -> Factor {
    assert!(kappa >= 0.0 && kappa.is_finite(), "extinction {kappa} 1/m");
    let Some(p) = clipped_pair(a, b) else { return Factor::NOT_VISIBLE };
    let g = p.distance();
    let f = if p.centre == [0.0; 3] { 0.0 } else { p.kernel(p.centre, kappa) };
    let value = p.weight * f;
    let radius = if g > 0.0 {
        let variance: f64 = p.densities.iter().map(|s| s.variance).sum();
        let r = p.max_distance();
        let rounding = (40.0 + 4.0 * kappa * r) * UNIT_ROUNDOFF * f
            + p.relative_error * f
            + p.displacement_error(g, kappa);
        1.000_001
            * p.weight
            * (SECOND_TAYLOR_COEFFICIENT * variance * second_derivative_bound(&p, kappa, g) + rounding)
            + f64::MIN_POSITIVE
    } else {
        f64::INFINITY
    };
    let radius = radius.min(value + p.upper_bound());
    Factor { bounded: Bounded::proved(value, radius), evaluations: 1, method: Method::Point }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    /// Two thin rods far apart: the true second-order term along the line of sight is close to the bound.
    #[test]
    fn radius_is_close_to_the_second_order_term() {
        // A rod along x against a rod along x, far away: E f − f(X) = ½ Var f″ (1 + O(1/r)).
        let a = Cuboid::voxel(vec3(0.0, 0.0, 0.0), vec3(1.0, 1e-3, 1e-3));
        let b = Cuboid::voxel(vec3(50.0, 0.0, 0.0), vec3(51.0, 1e-3, 1e-3));
        let f = factor(&a, &b, 0.0).bounded;
        let exact = zonal_exchange::aligned::geometric_factor(&a, &b, 0.0, 1e-12).bounded.value;
        let off = (f.value - exact).abs();
        assert!(off <= f.radius && off > 0.55 * f.radius, "{off:e} {:e}", f.radius);
    }
}
