//! The axes of a sky in the scene.

use std::f64::consts::TAU;
use zonal_math::direction_sampling::sin_cos_turns;
use zonal_math::{Vec3, vec3};

/// Cosine between up and −z from which on the frame of straight up is turned about x.
const STRAIGHT_DOWN_COSINE: f64 = -1.0 + 1e-12;
/// Largest deviation of the length of an axis from 1, and of the cosine of two axes from 0.
const AXIS_TOLERANCE: f64 = 1e-6;

/// Unit vectors: up, forward (the turn 0) and left of it (a quarter turn), right-handed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SkyFrame {
    pub(super) up: Vec3,
    forward: Vec3,
    left: Vec3,
}

impl SkyFrame {
    /// The frame of the unit vector `up`: its forward vector is x under the smallest rotation that takes z to `up`, then turned by `rotation` radians about `up`,
    /// counterclockwise as seen from above.
    pub(super) fn new(up: Vec3, rotation: f64) -> SkyFrame {
        let (z, x) = (vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0));
        let first = if up.z > STRAIGHT_DOWN_COSINE {
            let (cos, axis) = (z.dot(up), z.cross(up));
            x * cos + axis.cross(x) + axis * (axis.dot(x) / (1.0 + cos))
        } else {
            x
        };
        let side = up.cross(first);
        let (sin, cos) = rotation.sin_cos();
        SkyFrame { up, forward: first * cos + side * sin, left: side * cos - first * sin }
    }

    /// The frame of `up` whose forward vector lies below `towards`; that of [`SkyFrame::new`] where `towards` is up.
    pub(super) fn towards(up: Vec3, towards: Vec3) -> SkyFrame {
        let across = towards - up * towards.dot(up);
        let forward = across.normalized();
        if across.length() > AXIS_TOLERANCE {
            SkyFrame { up, forward, left: up.cross(forward) }
        } else {
            SkyFrame::new(up, 0.0)
        }
    }

    /// Height z and turn in [0, 1) of a unit direction.
    pub(super) fn coordinates(&self, direction: Vec3) -> (f64, f64) {
        let (x, y) = (direction.dot(self.forward), direction.dot(self.left));
        let turn = y.atan2(x) / TAU;
        (direction.dot(self.up), if turn < 0.0 { (turn + 1.0).min(1.0 - f64::EPSILON) } else { turn })
    }

    /// The unit direction of a height and a turn.
    pub(super) fn direction(&self, z: f64, turn: f64) -> Vec3 {
        let (sin, cos) = sin_cos_turns(turn);
        let across = (1.0 - z * z).max(0.0).sqrt();
        (self.up * z + (self.forward * cos + self.left * sin) * across).normalized()
    }

    /// The components of the three vectors.
    pub(super) fn numbers(&self) -> impl Iterator<Item = f64> {
        [self.up, self.forward, self.left].into_iter().flat_map(|v| [v.x, v.y, v.z])
    }

    /// How many [`SkyFrame::numbers`] there are.
    pub(super) const NUMBERS: usize = 9;

    /// The frame of its numbers; `None` unless they are orthogonal unit vectors.
    pub(super) fn from_numbers(numbers: &[f64]) -> Option<SkyFrame> {
        let [a, b, c, d, e, f, g, h, i] = *numbers else { return None };
        let out = SkyFrame { up: vec3(a, b, c), forward: vec3(d, e, f), left: vec3(g, h, i) };
        out.is_valid().then_some(out)
    }

    /// True if the vectors are orthogonal unit vectors.
    pub(super) fn is_valid(&self) -> bool {
        let axes = [self.up, self.forward, self.left];
        axes.iter().all(|v| (v.length() - 1.0).abs() < AXIS_TOLERANCE)
            && [(0, 1), (1, 2), (2, 0)].iter().all(|&(i, j)| axes[i].dot(axes[j]).abs() < AXIS_TOLERANCE)
    }
}
