//! The number of Gauss points along a direction, by a proved error bound on Bernstein ellipses (Trefethen 2008).
//!
//! A direction of a cell is a real interval [X − h, X + h], X ≥ h; its Bernstein ellipse with semi-axes A, B,
//! A² = B² + h², has the parameter ϱ = (A + B)/h. For z on or inside it and real c
//!
//! ```text
//! Re z² ≥ −B² (1 − X²/(A² + B²))  (or (X − A)² when X A ≥ A² + B²),
//! ```
//!
//! the minimum of a harmonic function, taken on the ellipse at cos φ = −XA/(A² + B²). So with
//! R = c² + min Re z² > 0 the squared distance r² = z² + c² stays in the right half-plane: r is analytic (principal
//! branch), |r²| ≥ R and Re r ≥ √R. R reaches zero at B² = [P + √(P² + 8c²h²)]/4, P = 2c² + X² − h².

use zonal_math::gauss_legendre;

/// An ellipse around a direction's interval.
#[derive(Clone, Copy, Debug)]
pub(super) struct BernsteinEllipse {
    /// Semi-axis along the interval.
    pub a: f64,
    /// Its parameter ϱ > 1.
    pub rho: f64,
    /// Lower bound of Re(z² + c²) on it, positive.
    pub square: f64,
}

/// Minor semi-axes of the candidate ellipses relative to the widest ellipse, from wide to narrow: narrow ones serve optically thick pairs, whose
/// e^{−κr} grows fast off the real axis.
const ELLIPSE_FRACTIONS: [f64; 12] =
    [0.95, 0.86, 0.72, 0.55, 0.38, 0.24, 0.14, 0.07, 0.03, 0.012, 0.005, 0.002];

/// B² of the ellipse on which R vanishes.
fn widest(x: f64, h: f64, c2: f64) -> f64 {
    let p = 2.0 * c2 + x * x - h * h;
    0.25 * (p + (p * p + 8.0 * c2 * h * h).sqrt())
}

/// The parameter ϱ of the widest ellipse, which decides whether a cell is cut.
pub(super) fn widest_rho(lo: f64, len: f64, c2: f64) -> f64 {
    let h = 0.5 * len;
    let b2 = widest(lo + h, h, c2);
    ((b2 + h * h).sqrt() + b2.sqrt()) / h
}

/// Candidates around [lo, lo + len] at squared distance `c2` ≥ 0 from the axis; lo > 0 or c2 > 0.
pub(super) fn ellipses_around(lo: f64, len: f64, c2: f64) -> impl Iterator<Item = BernsteinEllipse> {
    let h = 0.5 * len;
    let x = lo + h;
    let b_max = widest(x, h, c2).sqrt();
    ELLIPSE_FRACTIONS.iter().map(move |f| {
        let b = f * b_max;
        let (b2, a2) = (b * b, b * b + h * h);
        let a = a2.sqrt();
        let dip = if x * a >= a2 + b2 { (x - a) * (x - a) } else { b2 * (x * x / (a2 + b2) - 1.0) };
        BernsteinEllipse { a, rho: (a + b) / h, square: c2 + dip }
    })
}

/// A number of points and the error that it is proved to leave.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointCount {
    pub points: usize,
    pub error: f64,
}

/// Points along a direction, at most; a cell that needs more is cut instead.
pub(super) const MAX_POINTS: usize = 40;

/// The smallest number of points whose error (64/15)/2 · M ϱ^{−2n}/(1 − ϱ^{−2}) is within `budget` for one of the
/// candidates (ln M, ϱ), M including the cell's volume; candidates are tried while they improve. Capped at [`MAX_POINTS`], with the error at the cap.
pub(super) fn fewest_points(candidates: impl Iterator<Item = (f64, f64)>, budget: f64) -> PointCount {
    let goal = budget.ln();
    let (mut needed, mut best) = (f64::INFINITY, None);
    for (ln_m, rho) in candidates {
        let n = (ln_m + LN_32_15 - (1.0 - 1.0 / (rho * rho)).ln() - goal) / (2.0 * rho.ln());
        // The negation also covers NaN.
        if !(n < needed || best.is_none() && n.is_finite()) {
            break;
        }
        (needed, best) = (n, Some((ln_m, rho)));
    }
    let Some((ln_m, rho)) = best else {
        // Squares that underflow leave no ellipse and no bound of the error.
        return PointCount { points: MAX_POINTS, error: f64::INFINITY };
    };
    let points = needed.ceil().clamp(1.0, MAX_POINTS as f64) as usize;
    let error = LOGARITHM_ROUNDING * gauss_legendre::error_bound(points, rho, 1.0) * ln_m.exp();
    PointCount { points, error }
}

/// ln(32/15).
const LN_32_15: f64 = 0.757_685_701_697_516_5; // bound
/// The rounding of logarithms and exponentials, far below one part in a million.
const LOGARITHM_ROUNDING: f64 = 1.000_001; // bound

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn real_part_on_ellipse_stays_above_bound() {
        for (lo, len, c2) in
            [(0.0, 1.0, 1.0), (1.0, 1.0, 0.0), (0.01, 1.0, 0.3), (5.0, 1.0, 2.0), (2.0, 0.1, 0.0)]
        {
            for e in ellipses_around(lo, len, c2) {
                let (h, b) = (0.5 * len, (e.a * e.a - 0.25 * len * len).sqrt());
                let lowest = (0..2000)
                    .map(|i| {
                        let phi = i as f64 * std::f64::consts::TAU / 2000.0;
                        let (x, y) = (lo + h + e.a * phi.cos(), b * phi.sin());
                        x * x - y * y + c2
                    })
                    .fold(f64::INFINITY, f64::min);
                assert!(e.square > 0.0 && e.rho > 1.0);
                assert!(e.square <= lowest * (1.0 + 1e-9), "{} {lowest}", e.square);
                assert!((e.square - lowest).abs() <= 1e-3 * (lowest + len * len), "{} {lowest}", e.square);
                assert!(e.rho <= widest_rho(lo, len, c2));
            }
        }
    }

    #[test]
    fn ln_32_15_equals_logarithm_of_trefethen_constant() {
        assert!((LN_32_15 - gauss_legendre::TREFETHEN_CONSTANT.ln()).abs() < 1e-15);
    }

    #[test]
    fn fewest_points_meet_budget() {
        for budget in [1e-3, 1e-8, 1e-14] {
            for (ln_m, rho) in [(0.0, 2.0), (3.0, 1.7), (-8.0, 5.0)] {
                let c = fewest_points(std::iter::once((ln_m, rho)), budget);
                let bound = |n: usize| gauss_legendre::error_bound(n, rho, f64::exp(ln_m));
                assert!(c.error >= bound(c.points) && c.error <= 1.000_01 * bound(c.points), "{c:?}");
                assert!(c.error <= 1.000_01 * budget, "{c:?}");
                assert!(c.points == 1 || bound(c.points - 1) > budget, "{c:?}");
            }
        }
    }
}
