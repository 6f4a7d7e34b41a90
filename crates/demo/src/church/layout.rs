//! The layout in plan: bays, half-spaces within walls, frames of walls, vaults over bays.

use super::arch::{PointedArch, RibVault};
use super::plan::{AISLE_VAULT_RISE, BAY_LENGTH, ChurchPlan, NAVE_WALL_OFFSETS, OUTER_WALL_OFFSET};
use super::wall::WallFrame;
use std::f64::consts::PI;
use zonal_math::{Vec3, vec3};

/// A church to be built.
pub(super) struct Church<'a> {
    pub plan: &'a ChurchPlan,
}

impl Church<'_> {
    pub(super) fn end(&self) -> f64 {
        self.plan.length()
    }
    /// An arch of masonry.
    pub(super) fn head(&self, half: f64, rise: f64) -> PointedArch {
        PointedArch::new(half, rise, self.plan.arc)
    }
    pub(super) fn border(&self, bay: usize) -> f64 {
        BAY_LENGTH * bay as f64
    }

    /// The apse's corners in plan at a radius, from large x to small.
    pub(super) fn choir(&self, radius: f64, z: f64) -> Vec<Vec3> {
        (0..=5)
            .map(|k| {
                let (sin, cos) = (PI * k as f64 / 5.0).sin_cos();
                vec3(radius * cos, self.end() + radius * sin, z)
            })
            .collect()
    }

    /// The half-spaces within the walls of nave and apse.
    pub(super) fn nave(&self) -> Vec<(Vec3, f64)> {
        let corners = self.choir(NAVE_WALL_OFFSETS.0, 0.0);
        let mut plan = vec![vec3(-NAVE_WALL_OFFSETS.0, 0.0, 0.0), vec3(NAVE_WALL_OFFSETS.0, 0.0, 0.0)];
        plan.extend(corners);
        plan.push(plan[0]);
        let inward = |p: &[Vec3]| {
            let d = (p[1] - p[0]).normalized();
            let n = vec3(-d.y, d.x, 0.0);
            (n, n.dot(p[0]))
        };
        plan.windows(2).map(inward).collect()
    }

    /// The half-spaces within the walls of an aisle.
    pub(super) fn aisle(&self, s: f64) -> [(Vec3, f64); 4] {
        let (across, along) = (vec3(s, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        [(across, NAVE_WALL_OFFSETS.1), (-across, -OUTER_WALL_OFFSET), (along, 0.0), (-along, -self.end())]
    }

    /// The vault of a bay from `x0` to `x1`, m, that springs at height `spring` and rises by `rise`.
    pub(super) fn vault(&self, bay: usize, x0: f64, x1: f64, spring: f64, rise: f64) -> RibVault {
        let (y0, y1) = (self.border(bay), self.border(bay + 1));
        RibVault { lo: vec3(x0, y0, spring), hi: vec3(x1, y1, spring), rise, pieces: self.plan.pieces }
    }

    /// The wall of a bay at `x` from the axis, on the side `s`, seen from the axis.
    pub(super) fn side(&self, s: f64, x: f64, bay: usize) -> WallFrame {
        let middle = vec3(s * x, self.border(bay) + 0.5 * BAY_LENGTH, 0.0);
        WallFrame::new(middle, vec3(0.0, 1.0, 0.0), vec3(-s, 0.0, 0.0))
    }

    /// The end wall of an aisle at `y`, and the arch of the vault over it.
    pub(super) fn end_of_aisle(&self, s: f64, y: f64, inward: Vec3) -> (WallFrame, PointedArch) {
        let middle = vec3(s * 0.5 * (NAVE_WALL_OFFSETS.1 + OUTER_WALL_OFFSET), y, 0.0);
        let arch = PointedArch::new(
            0.5 * (OUTER_WALL_OFFSET - NAVE_WALL_OFFSETS.1),
            AISLE_VAULT_RISE,
            self.plan.pieces,
        );
        (WallFrame::new(middle, vec3(1.0, 0.0, 0.0), inward), arch)
    }
}
