//! Pointed arches, vaults over rectangular bays, and the ribs beneath them.
//!
//! A pointed arch of half span h and rise R ≥ h is two arcs of radius r = (R² + h²)/(2h) about points on the springing line:
//!
//! ```text
//! |x|(z) = √(r² − z²) − (r − h)
//! ```
//!
//! A ribbed vault is the upper envelope of two such barrels of the same rise, square to one another. At equal heights their half widths
//! a(z), b(z) meet in the groin, which the diagonal rib follows; each web is ruled by level lines from a groin to the bay's border.

use super::model::{ChurchMaterial, ChurchModel};
use zonal_math::{Vec3, vec3};

/// A pointed arch.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointedArch {
    /// Half span, m.
    pub half: f64,
    /// Rise over the springing line, m; at least the half span.
    pub rise: f64,
    /// Straight pieces from springing to crown.
    pub pieces: usize,
}

impl PointedArch {
    /// An arch with a number of pieces on each side.
    pub(super) fn new(half: f64, rise: f64, pieces: usize) -> PointedArch {
        PointedArch { half, rise: rise.max(half), pieces }
    }
    fn radius(&self) -> f64 {
        (self.rise * self.rise + self.half * self.half) / (2.0 * self.half)
    }
    /// Half width at a height over the springing line, m.
    pub(super) fn width(&self, z: f64) -> f64 {
        let r = self.radius();
        ((r * r - z * z).max(0.0).sqrt() - (r - self.half)).max(0.0)
    }
    /// Points (x, z) from the springing at −half over the crown to +half, evenly spaced along the arcs.
    pub(super) fn points(&self) -> Vec<[f64; 2]> {
        let (r, n) = (self.radius(), self.pieces);
        let end = ((r - self.half) / r).acos();
        let right = |k: usize| {
            let (sin, cos) = (end * k as f64 / n as f64).sin_cos();
            if k == n { [0.0, self.rise] } else { [r * cos - (r - self.half), r * sin] }
        };
        let left = (0..n).map(right).map(|[x, z]| [-x, z]);
        left.chain((0..=n).rev().map(right)).collect()
    }
}

/// A vault over a bay.
#[derive(Clone, Copy, Debug)]
pub(super) struct RibVault {
    /// Corners of the bay in plan, at the springing height, m.
    pub lo: Vec3,
    /// The opposite corner.
    pub hi: Vec3,
    /// Rise, m.
    pub rise: f64,
    /// Pieces from springing to crown.
    pub pieces: usize,
}

/// The profile of ribs: side and depth, m; negative depth hangs below the web, at which the flanks are parted.
pub(super) fn rib(width: f64, depth: f64) -> Vec<[f64; 2]> {
    let (w, c) = (0.5 * width, 0.28 * width);
    let below = [[-w, 0.0], [-w, -0.5 * depth], [-c, -depth], [c, -depth], [w, -0.5 * depth], [w, 0.0]];
    [[-w, 0.03]].into_iter().chain(below).chain([[w, 0.03]]).collect()
}

impl RibVault {
    fn centre(&self) -> Vec3 {
        (self.lo + self.hi) * 0.5
    }
    /// The barrel across the bay, whose profile lies in x.
    pub(super) fn across(&self) -> PointedArch {
        PointedArch::new(0.5 * (self.hi.x - self.lo.x), self.rise, self.pieces)
    }
    /// The barrel along the bay, whose profile lies in y.
    pub(super) fn along(&self) -> PointedArch {
        PointedArch::new(0.5 * (self.hi.y - self.lo.y), self.rise, self.pieces)
    }
    /// Heights of the level lines, m over the springing.
    pub(super) fn levels(&self) -> Vec<f64> {
        self.across().points()[..=self.pieces].iter().map(|p| p[1]).collect::<Vec<f64>>()
    }

    /// The border of the webs along a wall in y: (y from the middle, z).
    pub(super) fn edge(&self) -> Vec<[f64; 2]> {
        let b = self.along();
        let right = self.levels().into_iter().map(|z| [b.width(z), self.lo.z + z]);
        let left = self.levels().into_iter().map(|z| [-b.width(z), self.lo.z + z]);
        let mut out: Vec<[f64; 2]> = left.collect();
        out.extend(right.rev().skip(1));
        out
    }

    /// The four webs.
    pub(super) fn webs(&self, m: &mut ChurchModel) {
        let (a, b, c) = (self.across(), self.along(), self.centre());
        let levels = self.levels();
        let below = c - vec3(0.0, 0.0, 1.0);
        let (hx, hy) = (a.half, b.half);
        let mut course = 0.0;
        for k in 0..levels.len() - 1 {
            let [lower, upper] = [levels[k], levels[k + 1]].map(|z| (a.width(z), b.width(z), z));
            let step = ((lower.0 - upper.0).powi(2) + (upper.2 - lower.2).powi(2)).sqrt();
            for (sx, sy) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
                let at = |x: f64, y: f64, z: f64| c + vec3(sx * x, sy * y, z);
                // The web that runs to the border in y, then the one to that in x.
                let in_y = [
                    (lower.0, lower.1, lower.2),
                    (lower.0, hy, lower.2),
                    (upper.0, hy, upper.2),
                    (upper.0, upper.1, upper.2),
                ];
                let in_x = [
                    (lower.0, lower.1, lower.2),
                    (hx, lower.1, lower.2),
                    (hx, upper.1, upper.2),
                    (upper.0, upper.1, upper.2),
                ];
                for (web, run) in [(in_y, 1), (in_x, 0)] {
                    let corner = |i: usize| {
                        let (x, y, z) = web[i];
                        let p = at(x, y, z);
                        (p, [if run == 1 { p.y } else { p.x }, course + if i < 2 { 0.0 } else { step }])
                    };
                    m.textured(ChurchMaterial::Web, &[corner(0), corner(1), corner(2), corner(3)], below);
                }
            }
            course += step;
        }
    }

    /// Ribs beneath the groins.
    pub(super) fn diagonals(&self, m: &mut ChurchModel, profile: &[[f64; 2]]) {
        let (a, b, c) = (self.across(), self.along(), self.centre());
        let groin = |sx: f64, sy: f64| {
            self.levels()
                .into_iter()
                .map(|z| c + vec3(sx * a.width(z), sy * b.width(z), z))
                .collect::<Vec<_>>()
        };
        for s in [1.0, -1.0] {
            let mut line = groin(-1.0, -s);
            line.extend(groin(1.0, s).into_iter().rev().skip(1));
            let run = line[line.len() - 1] - line[0];
            m.sweep(ChurchMaterial::Dressed, &line, vec3(-run.y, run.x, 0.0).normalized(), profile);
        }
        let boss = c + vec3(0.0, 0.0, self.rise);
        m.turned(
            ChurchMaterial::Dressed,
            boss,
            &[(0.1, -0.34), (0.24, -0.26), (0.26, -0.1), (0.2, 0.01)],
            12,
        );
    }

    /// A rib beneath the border at `y`.
    pub(super) fn transverse(&self, m: &mut ChurchModel, y: f64, profile: &[[f64; 2]]) {
        let c = self.centre();
        let at = |p: [f64; 2]| vec3(c.x + p[0], y, self.lo.z + p[1]);
        let line: Vec<Vec3> = self.across().points().into_iter().map(at).collect();
        m.sweep(ChurchMaterial::Dressed, &line, vec3(0.0, 1.0, 0.0), profile);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arch_points_are_on_the_profile() {
        let a = PointedArch::new(2.0, 3.1, 9);
        for [x, z] in a.points() {
            assert!((a.width(z) - x.abs()).abs() < 1e-6);
        }
        let points = a.points();
        assert!(points.len() == 19 && points[9] == [0.0, 3.1]);
        assert!((points[0][0] + 2.0).abs() + points[0][1].abs() + (points[18][0] - 2.0).abs() < 1e-12);
    }
}
