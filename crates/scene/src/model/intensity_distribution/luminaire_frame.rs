//! The axes of a photometric table in the scene.

use std::f64::consts::TAU;
use zonal_math::{Vec3, vec3};

/// Cosine with straight up from which on the aim counts as straight up.
const STRAIGHT_UP_COSINE: f64 = 1.0 - 1e-12;
/// Largest deviation of the length of an axis from 1.
const AXIS_TOLERANCE: f64 = 1e-6;

/// Unit vectors of the direction γ = 0 and of the planes C = 0° and C = 90°, right-handed or, after a reflection, left-handed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LuminaireFrame {
    aim: Vec3,
    c0: Vec3,
    c90: Vec3,
}

impl LuminaireFrame {
    /// The frame of the unit vector `aim`, turned by `rotation` radians about it.
    pub(super) fn new(aim: Vec3, rotation: f64) -> LuminaireFrame {
        // The smallest rotation from straight down to the aim, applied to the x axis (Rodrigues).
        let (down, x) = (vec3(0.0, 0.0, -1.0), vec3(1.0, 0.0, 0.0));
        let c0 = if aim.z < STRAIGHT_UP_COSINE {
            let (cos, axis) = (down.dot(aim), down.cross(aim));
            x * cos + axis.cross(x) + axis * (axis.dot(x) / (1.0 + cos))
        } else {
            x
        };
        let c90 = c0.cross(aim);
        let (sin, cos) = rotation.sin_cos();
        LuminaireFrame { aim, c0: c0 * cos + c90 * sin, c90: c90 * cos - c0 * sin }
    }

    /// γ in [0, π] and C in [0, 2π) of a unit direction, radians.
    pub(super) fn angles(&self, direction: Vec3) -> [f64; 2] {
        let (x, y, z) = (direction.dot(self.c0), direction.dot(self.c90), direction.dot(self.aim));
        let c = y.atan2(x);
        [x.hypot(y).atan2(z), if c < 0.0 { c + TAU } else { c }]
    }

    /// The unit direction of γ and C, radians.
    pub(super) fn direction(&self, [gamma, c]: [f64; 2]) -> Vec3 {
        let (across, along) = gamma.sin_cos();
        let (sin, cos) = c.sin_cos();
        (self.aim * along + (self.c0 * cos + self.c90 * sin) * across).normalized()
    }

    /// The frame after a reflection of vectors.
    pub(super) fn reflected(&self, reflect: impl Fn(Vec3) -> Vec3) -> LuminaireFrame {
        LuminaireFrame { aim: reflect(self.aim), c0: reflect(self.c0), c90: reflect(self.c90) }
    }

    /// The components of the three vectors.
    pub(super) fn numbers(&self) -> impl Iterator<Item = f64> {
        [self.aim, self.c0, self.c90].into_iter().flat_map(|v| [v.x, v.y, v.z])
    }

    /// How many [`LuminaireFrame::numbers`] there are.
    pub(super) const NUMBERS: usize = 9;

    /// The frame of its numbers.
    pub(super) fn from_numbers(numbers: &[f64]) -> Option<LuminaireFrame> {
        let [a, b, c, d, e, f, g, h, i] = *numbers else { return None };
        Some(LuminaireFrame { aim: vec3(a, b, c), c0: vec3(d, e, f), c90: vec3(g, h, i) })
    }

    /// True if the vectors are unit vectors.
    pub(super) fn is_valid(&self) -> bool {
        [self.aim, self.c0, self.c90].into_iter().all(|v| (v.length() - 1.0).abs() < AXIS_TOLERANCE)
    }
}
