//! Spherical caps that a plane cuts: the cosine integral above the plane, and samples of that part.
//!
//! A cap of half-angle α about the unit axis a, with the elevation ε of a above the plane of the unit normal n (sin ε = n·a), sends to the plane, per unit radiance,
//!
//! ```text
//! I(α, ε) = ∫ n·ω dω over the directions of the cap with n·ω > 0
//!         = π sin²α sin ε                                         ε ≥ α
//!         = β − sinα cosα cosε sinψ + ψ sin²α sinε                −α < ε ≤ 0, cosβ = cosα/cosε, cosψ = −tanε/tanα
//!         = π sin²α sin ε + I(α, −ε)                              0 < ε < α
//!         = 0                                                     ε ≤ −α
//! ```
//!
//! The second line is the area of the orthographic projection onto the plane (Nusselt's analog), between the horizon and the arc of the cap's ellipse. Its terms
//! cancel where a sliver of the cap is above the plane. There the integral over the elevation ζ of a direction is evaluated,
//!
//! ```text
//! I = ∫ 2 φ(ζ) sinζ cosζ dζ,   sin²(φ/2) = sin((α + ζ − ε)/2) sin((α − ζ + ε)/2) / (cosζ cosε)
//! ```
//!
//! with φ the half-width of the cap in azimuth, by a Gauss–Legendre rule in the square root of the distance from the upper end, at which φ has a branch point.
//! The relative error is below 1e-12.

use crate::direction_sampling::sin_cos_turns;
use crate::gauss_legendre;
use crate::vec3::Vec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// Extent in elevation, radians, below which the integral over the elevation replaces the closed form.
const SLIVER: f64 = 0.3;
/// Nodes of the integral over the elevation.
const NODES: usize = 32;

/// A cap of directions as seen from a plane.
#[derive(Clone, Copy, Debug)]
pub struct CapOverPlane {
    /// Half-angle α, radians, at most π/2.
    half_angle: f64,
    /// Elevation ε, radians.
    elevation: f64,
    /// Sine of the elevation, exact to rounding.
    sine: f64,
    normal: Vec3,
    /// Unit vector of the plane below the axis of the cap.
    along: Vec3,
}

impl CapOverPlane {
    /// The cap of half-angle `half_angle`, radians, from 0 to π/2, about the unit vector `axis`, over the plane of the unit normal `normal`.
    ///
    /// ```
    /// use zonal_math::spherical_cap::CapOverPlane;
    /// use zonal_math::vec3;
    /// use std::f64::consts::FRAC_PI_2;
    /// // Half of a hemisphere about a horizontal axis is above the plane.
    /// let cap = CapOverPlane::new(FRAC_PI_2, vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0));
    /// assert!((cap.mean_cosine() - 0.5).abs() < 1e-14);
    /// ```
    #[must_use]
    pub fn new(half_angle: f64, axis: Vec3, normal: Vec3) -> CapOverPlane {
        let sine = normal.dot(axis);
        let across = axis - normal * sine;
        let cosine = across.length();
        let along = if cosine > 0.0 { across / cosine } else { normal.frame().0 };
        CapOverPlane { half_angle, elevation: sine.atan2(cosine), sine, normal, along }
    }

    /// True where the plane cuts the cap, so that a part of it is above and a part below.
    #[must_use]
    pub fn is_cut(&self) -> bool {
        self.elevation.abs() < self.half_angle
    }

    /// True where the whole cap is above the plane.
    #[must_use]
    pub fn is_above(&self) -> bool {
        self.elevation >= self.half_angle && self.sine > 0.0
    }

    /// I over π sin²α: the irradiance of the plane over that of a plane normal to the axis of the cap. The sine of the elevation for a cap above the plane.
    ///
    /// ```
    /// use zonal_math::spherical_cap::CapOverPlane;
    /// use zonal_math::vec3;
    /// // A cap of 53.13° whose axis is 25° below the plane.
    /// let (sin, cos) = (-25f64).to_radians().sin_cos();
    /// let cap = CapOverPlane::new(0.8f64.asin(), vec3(cos, 0.0, sin), vec3(0.0, 0.0, 1.0));
    /// assert!((cap.mean_cosine() - 0.055453).abs() < 5e-7);
    /// ```
    #[must_use]
    pub fn mean_cosine(&self) -> f64 {
        let area = PI * self.half_angle.sin().powi(2);
        if self.is_above() {
            self.sine
        } else if area > 0.0 {
            self.cosine_integral() / area
        } else {
            0.0
        }
    }

    /// I, sr.
    fn cosine_integral(&self) -> f64 {
        let whole = PI * self.half_angle.sin().powi(2) * self.sine;
        if self.is_above() {
            whole
        } else if !self.is_cut() {
            0.0
        } else if self.elevation > 0.0 {
            whole + lower_cap(self.half_angle, -self.elevation)
        } else {
            lower_cap(self.half_angle, self.elevation)
        }
    }

    /// A direction of the part of the cap above the plane at a point of the unit square, and its weight n·ω/p, sr, with p its density; the mean of the weight is I.
    /// The sine of the elevation squared is uniform, and so is the azimuth. `None` where the weight is 0.
    #[must_use]
    pub fn sample_above(&self, u: [f64; 2]) -> Option<(Vec3, f64)> {
        let top = self.elevation + self.half_angle;
        let highest = if top < FRAC_PI_2 { top.sin() } else { 1.0 };
        let z = highest * (1.0 - u[0]).max(0.0).sqrt();
        let width = half_width(self.half_angle, self.elevation, z.min(1.0).asin());
        let weight = highest * highest * width;
        let (sin, cos) = sin_cos_turns((u[1] - 0.5) * width / PI);
        let horizontal = (1.0 - z * z).max(0.0).sqrt();
        let across = self.normal.cross(self.along);
        let direction = self.normal * z + (self.along * cos + across * sin) * horizontal;
        (weight > 0.0 && z > 0.0).then(|| (direction.normalized(), weight))
    }
}

/// φ(ζ), radians.
fn half_width(half_angle: f64, elevation: f64, zeta: f64) -> f64 {
    let d = zeta - elevation;
    let product = (0.5 * (half_angle + d)).sin() * (0.5 * (half_angle - d)).sin();
    let cosines = zeta.cos() * elevation.cos();
    if product <= 0.0 {
        return 0.0;
    }
    if product >= cosines { PI } else { 2.0 * (product / cosines).sqrt().asin() }
}

/// I for −α < ε ≤ 0.
fn lower_cap(half_angle: f64, elevation: f64) -> f64 {
    let top = half_angle + elevation;
    if top <= 0.0 {
        return 0.0;
    }
    if top > SLIVER {
        let (sin, cos) = half_angle.sin_cos();
        let beta = (cos / elevation.cos()).min(1.0).acos();
        let psi = (-elevation.tan() * cos / sin).clamp(-1.0, 1.0).acos();
        return beta - sin * cos * elevation.cos() * psi.sin() + psi * sin * sin * elevation.sin();
    }
    // ζ = top (1 − t²).
    let rule = gauss_legendre::rule(NODES);
    let of_node = |(t, w): (&f64, &f64)| {
        let zeta = top * (1.0 - t * t);
        let (sin, cos) = zeta.sin_cos();
        w * t * half_width(half_angle, elevation, zeta) * sin * cos
    };
    4.0 * top * rule.nodes.iter().zip(&rule.weights).map(of_node).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{low_discrepancy, vec3};

    fn cap(half_angle: f64, elevation: f64) -> CapOverPlane {
        CapOverPlane::new(half_angle, vec3(elevation.cos(), 0.0, elevation.sin()), vec3(0.0, 0.0, 1.0))
    }

    /// I by a midpoint rule over the cap, in its own polar coordinates.
    fn summed(c: &CapOverPlane) -> f64 {
        let (n, axis) = (1500, c.along * c.elevation.cos() + c.normal * c.sine);
        let (t, b) = axis.frame();
        let mut sum = 0.0;
        for i in 0..n {
            let theta = (i as f64 + 0.5) / n as f64 * c.half_angle;
            for k in 0..n {
                let (sin, cos) = ((k as f64 + 0.5) / n as f64 * 2.0 * PI).sin_cos();
                let d = axis * theta.cos() + (t * cos + b * sin) * theta.sin();
                sum += d.dot(c.normal).max(0.0) * theta.sin();
            }
        }
        sum * c.half_angle * 2.0 * PI / (n * n) as f64
    }

    #[test]
    fn closed_forms_agree_with_sums_over_the_cap() {
        for (alpha, elevation) in
            [(0.93, -0.44), (1.5, -1.3), (0.9, 0.5), (0.2, -0.05), (1.3, 1.2), (0.4, 0.6)]
        {
            let c = cap(alpha, elevation);
            let (value, exact) = (c.cosine_integral(), summed(&c));
            assert!((value / exact - 1.0).abs() < 2e-4, "{alpha} {elevation}: {value} {exact}");
        }
        assert_eq!(cap(0.3, -0.3).cosine_integral(), 0.0);
        assert_eq!(cap(0.3, -0.5).cosine_integral(), 0.0);
    }

    #[test]
    fn both_forms_agree_where_they_meet_and_slivers_have_their_power_law() {
        for alpha in [0.3001, 0.5, 1.0, 1.5] {
            let at = |top: f64| lower_cap(alpha, top - alpha) / top.powf(2.5);
            let (below, above) = (at(SLIVER - 1e-9), at(SLIVER + 1e-9));
            assert!((below / above - 1.0).abs() < 1e-8, "{alpha}: {below} {above}");
            // I = (8√2/15) √(tanα) top^2.5 for top ≪ α: φ² = 2 (top − ζ) sinα/(cosα) near the horizon.
            let top = 1e-7;
            let limit = 8.0 / 15.0 * (2.0 * alpha.sin() / (alpha - top).cos()).sqrt();
            let ratio = lower_cap(alpha, top - alpha) / top.powf(2.5);
            let bound = 10.0 * top / alpha.cos().min(alpha);
            assert!((ratio / limit - 1.0).abs() < bound.max(1e-5), "{alpha}: {ratio} {limit}");
        }
    }

    #[test]
    fn samples_have_the_mean_of_the_integral_and_lie_in_the_cap() {
        for (alpha, elevation) in [(0.93, -0.44), (1.5, -1.499), (0.9, 0.5), (1.55, 1.2), (0.004, -0.0039)] {
            let c = cap(alpha, elevation);
            let axis = c.along * c.elevation.cos() + c.normal * c.sine;
            let n = 20_000;
            let mut sum = 0.0;
            for k in 0..n {
                let Some((d, weight)) = c.sample_above(low_discrepancy::r2(k, [0.5, 0.5])) else { continue };
                assert!(d.dot(c.normal) > 0.0 && d.dot(axis) >= alpha.cos() - 1e-12);
                sum += weight / n as f64;
            }
            assert!((sum / c.cosine_integral() - 1.0).abs() < 1e-3, "{alpha} {elevation}: {sum}");
        }
    }
}
