//! Sampling of directions from numbers in [0, 1): uniform over the sphere, cosine-weighted over a hemisphere (Malley's method).
//!
//! sin and cos of 2πu by their Taylor series about the nearest quarter turn, |x| ≤ π/4; the first omitted term is below 10⁻¹⁷. All
//! processors return the same bits, which a system's mathematical library does not guarantee.

use crate::vec3::{Vec3, vec3};
use std::f64::consts::FRAC_PI_2;

/// Taylor coefficients (−1)^k/(2k+1)! of the sine, highest order first.
const SINE_SERIES: [f64; 8] = [
    -1.0 / 1_307_674_368_000.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 39_916_800.0,
    1.0 / 362_880.0,
    -1.0 / 5_040.0,
    1.0 / 120.0,
    -1.0 / 6.0,
    1.0,
];
/// Taylor coefficients (−1)^k/(2k)! of the cosine, highest order first.
const COSINE_SERIES: [f64; 9] = [
    1.0 / 20_922_789_888_000.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 479_001_600.0,
    -1.0 / 3_628_800.0,
    1.0 / 40_320.0,
    -1.0 / 720.0,
    1.0 / 24.0,
    -0.5,
    1.0,
];

/// (sin, cos) of 2πu for |u| up to some thousands, to 2·10⁻¹⁶ and the rounding of u.
///
/// ```
/// use zonal_math::direction_sampling::sin_cos_turns;
/// assert_eq!(sin_cos_turns(0.25), (1.0, 0.0));
/// assert_eq!(sin_cos_turns(0.5), (0.0, -1.0));
/// ```
#[inline]
pub fn sin_cos_turns(u: f64) -> (f64, f64) {
    let quarters = (4.0 * u + if u < 0.0 { -0.5 } else { 0.5 }) as i64;
    let x = (4.0 * u - quarters as f64) * FRAC_PI_2;
    let x2 = x * x;
    let series = |c: &[f64]| c.iter().fold(0.0, |s, c| s * x2 + c);
    let (sin, cos) = (x * series(&SINE_SERIES), series(&COSINE_SERIES));
    match quarters & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// A direction uniformly distributed over the unit sphere, from a uniform point `u` of the unit square.
#[inline]
pub fn uniform_sphere(u: [f64; 2]) -> Vec3 {
    let z = 1.0 - 2.0 * u[0];
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = sin_cos_turns(u[1]);
    vec3(r * cos, r * sin, z)
}

/// A direction of density cosθ/π about the unit vector `n`, from a uniform point `u` of the unit square.
#[inline]
pub fn cosine_hemisphere(n: Vec3, u: [f64; 2]) -> Vec3 {
    let (t, b) = n.frame();
    let r = u[0].sqrt();
    let (sin, cos) = sin_cos_turns(u[1]);
    t * (r * cos) + b * (r * sin) + n * (1.0 - u[0]).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn sine_and_cosine_of_turns_match_the_library() {
        for k in -4000..4000 {
            let u = k as f64 / 1024.0;
            let ((s, c), (sin, cos)) = (sin_cos_turns(u), (TAU * u).sin_cos());
            assert!((s - sin).abs() < 5e-15 && (c - cos).abs() < 5e-15, "{u}");
            assert!((s * s + c * c - 1.0).abs() < 4e-16, "{u}");
        }
        assert_eq!(sin_cos_turns(0.25), (1.0, 0.0));
        assert_eq!(sin_cos_turns(0.5), (0.0, -1.0));
    }

    #[test]
    fn sampled_directions_have_the_means_of_their_densities() {
        let n = vec3(0.6, 0.0, 0.8);
        let (mut spherical, mut hemispherical) = (Vec3::ZERO, Vec3::ZERO);
        let count = 10_000;
        for k in 0..count {
            let u = crate::low_discrepancy::r2(k, [0.1, 0.7]);
            let (d, e) = (uniform_sphere(u), cosine_hemisphere(n, u));
            assert!((d.length() - 1.0).abs() < 1e-12 && (e.length() - 1.0).abs() < 1e-12);
            assert!(e.dot(n) >= 0.0);
            spherical += d;
            hemispherical += e;
        }
        assert!(spherical.length() < 1e-2 * count as f64);
        // ⟨cosθ⟩ over a density cosθ/π is 2/3.
        assert!((hemispherical / count as f64 - n * (2.0 / 3.0)).length() < 1e-3);
    }
}
