//! Two aligned rectangles without a medium, in closed form.
//!
//! **Parallel**, at distance z: the density of t has the second derivative Σ s_i δ(p_i) on each axis, s = (+, −, −, +) at the breakpoints. So with
//! ∂x²∂y² Φ = z²/r⁴
//!
//! ```text
//! π𝓕 = Σ_ij s_i s_j Φ(p_i, q_j),   2Φ = y a atan(y/a) + x b atan(x/b) − (z²/2) ln(r²/S²),   a² = x² + z²,  b² = y² + z².
//! ```
//!
//! **Perpendicular**, with the normals' axes x and ξ and the common axis y: the densities of x and ξ are 1 on [x₀, x₁], [ξ₀, ξ₁] (cut at 0, where the
//! other plane is), and with ∂x∂ξ∂y² Ψ = xξ/r⁴
//!
//! ```text
//! π𝓕 = Σ ± s_i Ψ(x, ξ, p_i),   −2Ψ = y s atan(y/s) − ¼ (s² − y²) ln(r²/S²),   s² = x² + ξ²,
//! ```
//!
//! with plus at (x₀, ξ₀), (x₁, ξ₁) and minus at the others. S is free, its terms cancel: the centres' distance, so that the logarithms are
//! small. These hold
//! for any offsets, and are C-11 and C-14 of Howell's catalogue where the rectangles are opposed or share an edge
//! (after Ehlert and Smith 1993).
//!
//! **Rounding.** For far pairs the terms cancel, so the error is relative to the terms. With ε = 2⁻⁵³ and elementary functions within 2 ulp, of
//! one term
//! let P be the sum of the moduli of its products with an arc and z²/2·(1 + |ln|), or ¼(s² + y²)(1 + |ln|) in the same way.
//!
//! - Evaluation: roots 2ε, arguments of arcs 4ε (an arc's condition is at most 1), arcs 4ε, products 3ε, logarithms 4ε absolutely and 4ε
//!   relatively, s² − y² 4ε of s² + y²: at most 16εP.
//! - Breakpoints are a relative ε off, each on its own. x ∂x (2Φ) = (x²y/a) atan(y/a) + x b atan(x/b) is at most the arcs' part of P, y alike,
//!   and since Φ is homogeneous of degree 2 but for the logarithm, z ∂z (2Φ) is at most 4P. y ∂y (2Ψ) = y s atan + ½ y² ln + ½ y² and
//!   x∂x + ξ∂ξ of 2Ψ = y s atan − ½ s² ln − ½ s² are at most 2P each. Together at most 6εP.
//! - Sixteen additions, every partial sum below ΣP: 16εΣP. Mass, π and the half: 4ε of the value.
//!
//! So the radius is **40 ε ΣP/2 /π** and 4ε|𝓕|.

use super::reduced_pair::ReducedPair;
use std::f64::consts::FRAC_1_PI;
use zonal_math::Bounded;

/// Unit roundoff 2⁻⁵³.
const UNIT_ROUNDOFF: f64 = 0.5 * f64::EPSILON;
/// Errors of the terms in ε times their moduli: 16 + 6 + 16, rounded up.
const TERM_ROUNDINGS: f64 = 40.0; // bound
/// Signs of the second derivative of the density at its breakpoints.
const BREAKPOINT_SIGNS: [f64; 4] = [1.0, -1.0, -1.0, 1.0];
/// Evaluations counted per factor: one per pair of corners.
pub(super) const EVALUATIONS: u64 = 16;

/// A sum of terms and of their moduli.
#[derive(Clone, Copy, Default)]
struct TermSum {
    value: f64,
    moduli: f64,
}

impl TermSum {
    fn add(&mut self, sign: f64, value: f64, modulus: f64) {
        self.value += sign * value;
        self.moduli += modulus;
    }
    fn bounded(self) -> Bounded {
        let value = 0.5 * FRAC_1_PI * self.value;
        let radius = 0.5 * FRAC_1_PI * TERM_ROUNDINGS * UNIT_ROUNDOFF * self.moduli
            + 4.0 * UNIT_ROUNDOFF * value.abs();
        Bounded::proved(value, radius * 1.000_001)
    }
}

/// The factor of two rectangles at κ = 0; `None` for other pairs.
pub(super) fn factor(pair: &ReducedPair) -> Option<Bounded> {
    let normal = |power: i32| (0..3).find(|&k| pair.0[k].power() == power);
    match pair.patches() {
        2 => Some(match normal(2) {
            Some(z) => parallel(pair, z),
            None => perpendicular(pair, normal(0)?),
        }),
        _ => None,
    }
}

/// The squared distance of the centres.
fn scale(pair: &ReducedPair) -> f64 {
    pair.0.iter().map(|a| (0.5 * (a.p[0] + a.p[3])).powi(2)).sum()
}

fn parallel(pair: &ReducedPair, normal: usize) -> Bounded {
    let [x, y, z] = [1, 2, 3].map(|k| pair.0[(normal + k) % 3].p);
    let (z2, s2) = (z[0] * z[0], scale(pair));
    let arc = |u: f64, root: f64| (u * root * (u / root).atan()).abs();
    let root = |p: [f64; 4]| p.map(|u| (u * u + z2).sqrt());
    let (a, b) = (root(x), root(y));
    let mut sum = TermSum::default();
    for i in 0..4 {
        for j in 0..4 {
            // Even in x and y: moduli serve.
            let arcs = arc(y[j], a[i]) + arc(x[i], b[j]);
            let log = ((x[i] * x[i] + y[j] * y[j] + z2) / s2).ln();
            sum.add(
                BREAKPOINT_SIGNS[i] * BREAKPOINT_SIGNS[j],
                arcs - 0.5 * z2 * log,
                arcs + 0.5 * z2 * (1.0 + log.abs()),
            );
        }
    }
    sum.bounded()
}

fn perpendicular(pair: &ReducedPair, common: usize) -> Bounded {
    let [x, xi] = [1, 2].map(|k| {
        let p = pair.0[(common + k) % 3].p;
        [p[0].max(0.0), p[3]]
    });
    let (y, s2) = (pair.0[common].p, scale(pair));
    let mut sum = TermSum::default();
    for i in 0..2 {
        for j in 0..2 {
            let sigma = x[i] * x[i] + xi[j] * xi[j];
            let root = sigma.sqrt();
            for k in 0..4 {
                let sign = if i == j { -BREAKPOINT_SIGNS[k] } else { BREAKPOINT_SIGNS[k] };
                let (value, modulus) = term(y[k], sigma, root, s2);
                sum.add(sign, value, modulus);
            }
        }
    }
    sum.bounded()
}

/// −2Ψ and its modulus; the limit 0 at r = 0.
fn term(y: f64, sigma: f64, root: f64, s2: f64) -> (f64, f64) {
    let y2 = y * y;
    let r2 = sigma + y2;
    if r2 == 0.0 {
        return (0.0, 0.0);
    }
    let arc = if root > 0.0 { (y * root * (y / root).atan()).abs() } else { 0.0 };
    let log = (r2 / s2).ln();
    (arc - 0.25 * (sigma - y2) * log, arc + 0.25 * r2 * (1.0 + log.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_constants_cover_their_counts() {
        let (evaluation, breakpoints, additions) = (16.0, 6.0, 16.0);
        assert!(TERM_ROUNDINGS >= evaluation + breakpoints + additions);
    }
}
