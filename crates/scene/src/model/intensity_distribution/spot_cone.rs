//! A cone of light with a smooth edge (glTF, KHR_lights_punctual).
//!
//! With x = cosθ, x_i and x_o the cosines of the inner and the outer half-angle and t = (x − x_o)/(x_i − x_o) in the falloff,
//!
//! ```text
//! f = 1 for x ≥ x_i, t² between, 0 for x ≤ x_o        ∫ f dω = 2π [(1 − x_i) + (x_i − x_o)/3]
//! ```

use std::f64::consts::{PI, TAU};
use zonal_math::Vec3;
use zonal_math::direction_sampling::sin_cos_turns;

/// Largest deviation of the length of the axis from 1.
const AXIS_LENGTH_TOLERANCE: f64 = 1e-6;
/// Least 1 − cos of the outer half-angle, of about 0.08 degrees: narrower cones are lost in rounding.
const MIN_OUTER_HEIGHT: f64 = 1e-6;

/// A spot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SpotCone {
    /// Unit vector along which the cone points.
    pub axis: Vec3,
    /// Cosines of the inner and the outer half-angle.
    pub cosines: [f64; 2],
}

impl SpotCone {
    /// Relative intensity at the cosine `x` with the axis.
    pub(super) fn relative(&self, x: f64) -> f64 {
        let [inner, outer] = self.cosines;
        if x >= inner {
            1.0
        } else if x <= outer {
            0.0
        } else {
            ((x - outer) / (inner - outer)).powi(2)
        }
    }

    /// Largest relative intensity within `half_angle` (radians) of `direction`.
    pub(super) fn upper_bound(&self, direction: Vec3, half_angle: f64) -> f64 {
        let angle = self.axis.cross(direction).length().atan2(self.axis.dot(direction));
        let nearest = (angle - half_angle).max(0.0);
        self.relative(nearest.cos())
    }

    /// ∫ f dω, sr.
    pub(super) fn solid_angle_integral(&self) -> f64 {
        let [inner, outer] = self.cosines;
        TAU * ((1.0 - inner) + (inner - outer) / 3.0)
    }

    /// The direction of density ∝ f at a point of the unit square, from the axis outwards.
    pub(super) fn sample_direction(&self, u: [f64; 2]) -> Vec3 {
        let [inner, outer] = self.cosines;
        let s = u[0] * self.solid_angle_integral() / TAU;
        let height = if s <= 1.0 - inner {
            s
        } else {
            // The part of the falloff within t has the share 1 − t³.
            let beyond = (3.0 * (s - (1.0 - inner)) / (inner - outer)).clamp(0.0, 1.0);
            1.0 - (outer + (inner - outer) * (1.0 - beyond).cbrt())
        };
        let height = height.clamp(0.0, 2.0);
        let (z, r) = (1.0 - height, (height * (2.0 - height)).max(0.0).sqrt());
        let (t, b) = self.axis.frame();
        let (sin, cos) = sin_cos_turns(u[1]);
        (self.axis * z + (t * cos + b * sin) * r).normalized()
    }

    /// What is wrong with the numbers, and the remedy.
    pub(super) fn check(&self) -> Result<(), &'static str> {
        let [inner, outer] = self.cosines;
        if !(self.axis.is_finite() && (self.axis.length() - 1.0).abs() < AXIS_LENGTH_TOLERANCE) {
            return Err("the direction must be a vector with a length");
        }
        if !(inner.is_finite() && outer.is_finite() && inner >= outer) {
            return Err("the inner angle must not exceed the outer angle");
        }
        if 1.0 - outer < MIN_OUTER_HEIGHT || outer < PI.cos() {
            return Err("the outer angle must lie between 0.1 and 180 degrees");
        }
        Ok(())
    }
}
