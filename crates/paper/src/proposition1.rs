//! Proposition 1: the transmittance taken out of the integral, its error, and the proven bound on the rest.
//!
//! ```text
//! 𝓕(κ) = W E[e^{−κr}/r²],     𝓕(κ) ≈ e^{−κd} 𝓕(0),     d the distance of the centres.
//! ```
//!
//! The relative error (exact − approximation)/exact is **−κℓ C(u)** to first order, C(u) = ⟨1/r⟩/⟨1/r²⟩ − |u| over two unit voxels at offset u
//! ([`centre_constant`]): the paper loses the sign in its last step and prints other values. It is corrected here by
//!
//! ```text
//! 𝓕(κ) ≈ e^{−κd} W (E r^{−2} − κ (E r^{−1} − d E r^{−2})),
//! ```
//!
//! since e^{−κ(r−d)} = 1 − κ(r−d) + ρ. **Rest:** |ρ| = |e^{−x} − 1 + x| ≤ ½x² max(1, e^{−x}), x = κ(r − d) ≥ −κ(d − g), g the least distance, so
//!
//! ```text
//! |rest| ≤ ½ κ² max(1, e^{κ(d−g)}) e^{−κd} W E[(r−d)²/r²],   E[(r−d)²/r²] = 1 − 2d E r^{−1} + d² E r^{−2}.
//! ```
//!
//! The means come with proved radii (`mean_inverse_distance.rs`), which enter. For patches the same with the cosines: E r^{−1} becomes E[n r^{1−q}], which is not
//! tabulated: there [`factor`] bounds |r − d| by the spread of r, hence a larger radius.

use super::clipped_pair::clipped_pair;
use super::mean_inverse_distance;
use crate::rounding::UNIT_ROUNDOFF;
use zonal_exchange::aligned::{Cuboid, geometric_factor};
use zonal_exchange::{AccuracyRequest, Factor, Method};
use zonal_math::{Bounded, Vec3};

/// Whether the transmittance at the centres is corrected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CentreCorrection {
    /// e^{−κd} as the paper has it.
    None,
    /// Corrected by −κℓ C(u), the first order in κ.
    FirstOrder,
}

/// ½ of the second-order remainder of e^{−x}.
const SECOND_TAYLOR_COEFFICIENT: f64 = 0.5; // bound

/// C(u) for unit voxels at lattice offset `u`, without unit.
pub fn centre_constant(u: [i32; 3]) -> Bounded {
    let a = Cuboid::voxel(Vec3::splat(0.0), Vec3::splat(1.0));
    let shift = zonal_math::vec3(u[0] as f64, u[1] as f64, u[2] as f64);
    let b = Cuboid::voxel(shift, shift + Vec3::splat(1.0));
    let (one, two) = (
        mean_inverse_distance::mean_inverse_power(&a, &b, 1),
        mean_inverse_distance::mean_inverse_power(&a, &b, 2),
    );
    let quotient = one.value / two.value;
    let d = shift.length();
    let radius = 1.001 * quotient * (one.radius / one.value + two.radius / two.value + 2.0 * UNIT_ROUNDOFF)
        + 4.0 * UNIT_ROUNDOFF * d;
    Bounded::proved(quotient - d, radius)
}

/// e^{−κd}·𝓕(0) as in the paper, without the correction; the radius includes the neglected part. κ in 1/m.
///
/// # Panics
/// On invalid boxes or a negative extinction.
pub fn uncorrected_factor(a: &Cuboid, b: &Cuboid, kappa: f64, demand: &AccuracyRequest) -> Factor {
    attenuate_at_centres(
        a,
        b,
        kappa,
        &geometric_factor(a, b, 0.0, 0.1 * demand.tolerance),
        CentreCorrection::None,
    )
}

/// The corrected factor with its proven radius, which is second order in κ: a tolerance is met where that is small enough. κ in 1/m.
///
/// # Panics
/// On invalid boxes or a negative extinction.
pub fn factor(a: &Cuboid, b: &Cuboid, kappa: f64, demand: &AccuracyRequest) -> Factor {
    attenuate_at_centres(
        a,
        b,
        kappa,
        &geometric_factor(a, b, 0.0, 0.1 * demand.tolerance),
        CentreCorrection::FirstOrder,
    )
}

/// Takes the transmittance to a geometric factor `base` of the pair.
pub(super) fn attenuate_at_centres(
    a: &Cuboid,
    b: &Cuboid,
    kappa: f64,
    base: &Factor,
    correction: CentreCorrection,
) -> Factor {
    assert!(kappa >= 0.0 && kappa.is_finite(), "extinction {kappa} 1/m");
    let Some(p) = clipped_pair(a, b) else { return Factor::NOT_VISIBLE };
    let d = p.centre.iter().map(|x| x * x).sum::<f64>().sqrt();
    let g = p.distance();
    let tau = (-kappa * d).exp();
    // e^{−κ(r−d)} is at most this; the distances are rounded.
    let growth = (kappa * (d - g).max(0.0) * (1.0 + 1e-12)).exp();
    let depth = 8.0 * UNIT_ROUNDOFF * kappa * (d + p.max_distance());
    let scale = |v: f64, radius: f64, evaluations: u64| {
        let rounded = radius * tau * (1.0 + 1e-12) + (16.0 * UNIT_ROUNDOFF + depth) * (v * tau).abs();
        let bounded = Bounded::proved(v * tau, 1.000_001 * rounded + f64::MIN_POSITIVE);
        Factor { bounded, evaluations, method: Method::Proposition1 }
    };
    let f = base.bounded;
    if kappa == 0.0 {
        return scale(f.value, f.radius, base.evaluations);
    }
    let top = f.value + f.radius;
    if p.patches > 0 {
        // |e^{−x} − 1| ≤ |x| max(1, e^{−x}), |x| ≤ κ max(d − g, reach − d).
        let spread = kappa * (d - g).max(p.max_distance() - d) * (1.0 + 1e-12);
        return scale(f.value, f.radius + top * (spread * growth).min(growth.max(1.0)), base.evaluations);
    }
    let inverse = mean_inverse_distance::mean_inverse_power(a, b, 1) * p.weight;
    let first = kappa * (inverse.value - d * f.value);
    let first_radius =
        kappa * (inverse.radius + d * f.radius + 8.0 * UNIT_ROUNDOFF * (inverse.value + d * f.value));
    let square = p.weight - 2.0 * d * (inverse.value - inverse.radius) + d * d * top;
    let square =
        (square + 16.0 * UNIT_ROUNDOFF * (p.weight + 2.0 * d * inverse.value + d * d * top)).max(0.0);
    let rest = SECOND_TAYLOR_COEFFICIENT * kappa * kappa * growth * square;
    if correction == CentreCorrection::FirstOrder {
        scale(f.value - first, f.radius + first_radius + rest, 2 * base.evaluations)
    } else {
        scale(f.value, f.radius + first.abs() + first_radius + rest, 2 * base.evaluations)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The remainder comes near its bound: a self pair in a thin medium.
    #[test]
    fn radius_is_close_to_the_remainder() {
        let a = Cuboid::voxel(Vec3::splat(0.0), Vec3::splat(1.0));
        let b = Cuboid::voxel(zonal_math::vec3(3.0, 0.0, 0.0), zonal_math::vec3(4.0, 1.0, 1.0));
        let kappa = 1e-2;
        let exact = geometric_factor(&a, &b, kappa, 1e-13).bounded.value;
        let f = factor(&a, &b, kappa, &AccuracyRequest::relative(1e-12)).bounded;
        let off = (f.value - exact).abs();
        assert!(off <= f.radius && off > 0.6 * f.radius, "{off:e} {:e}", f.radius);
    }
}
