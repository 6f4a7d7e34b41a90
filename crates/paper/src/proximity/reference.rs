//! A reference point of a block with the bounds of its development: truncation by Cauchy's estimate, quadrature over B, clamping at the horizon.

use super::error_constants::{POINT_ROUNDINGS, RADIUS_SLACK};
use super::plate_geometry::{distance, farthest};
use super::surface::{LocalForm, Majorant, SmoothSurface};
use super::visibility::grazing_error;
use crate::rounding::UNIT_ROUNDOFF;
use std::f64::consts::PI;
use zonal_math::{Vec3, gauss_legendre};
use zonal_scene::{Plate, PlateKind};

/// Radii of the polydiscs tried for Cauchy's estimate, relative to the block.
const POLYDISC_SCALES: [f64; 14] =
    [1.15, 1.3, 1.5, 1.75, 2.0, 2.5, 3.0, 4.0, 5.0, 7.0, 10.0, 15.0, 25.0, 50.0];
/// Displacements of y tried in the bound of the quadrature, relative to the distance.
const NODE_DISPLACEMENTS: [f64; 6] = [0.1, 0.2, 0.35, 0.5, 0.65, 0.8];
/// Largest number of points in one direction over B.
const MAX_POINTS: usize = 32;
/// Largest W/D for which |d·d| ≥ (D − W)² holds.
const MAX_RELATIVE_DISPLACEMENT: f64 = 0.5;

/// A reference point with the extents of its block.
pub(super) struct Reference {
    /// (u₀, v₀).
    pub at: [f64; 2],
    /// Half extents in u and v.
    pub half: [f64; 2],
    pub local: LocalForm,
    /// S₀, m.
    pub s: Vec3,
    pub normal: Vec3,
    /// Smallest and largest distance of B, m.
    pub near: f64,
    pub far: f64,
    /// Largest |N₀·d₀| over B, and |m·d₀|.
    pub facing: f64,
    pub height: f64,
}

impl Reference {
    /// The reference in the middle of a block, [from, to] in u and in v; `shake` is the error of a point, m.
    pub(super) fn new(surface: &SmoothSurface, plate: &Plate, block: [[f64; 2]; 2], shake: f64) -> Reference {
        let extent = |[from, to]: [f64; 2]| (0.5 * (from + to), 0.5 * (to - from));
        let ((u, hu), (v, hv)) = (extent(block[0]), extent(block[1]));
        let (s, normal) = (surface.at(u, v), surface.normal(u, v));
        let (corners, n) = plate.corners();
        let facing = corners[..n].iter().fold(0.0f64, |m, c| m.max(normal.dot(*c - s).abs()));
        let far = farthest(plate, s) + shake;
        Reference {
            at: [u, v],
            half: [hu * RADIUS_SLACK, hv * RADIUS_SLACK],
            local: surface.local(u, v),
            s,
            normal,
            near: (distance(plate, s) - shake).max(0.0),
            far,
            facing: (facing + normal.length() * (shake + POINT_ROUNDINGS * UNIT_ROUNDOFF * far))
                * RADIUS_SLACK,
            height: (plate.normal().dot(s - plate.origin).abs() + shake) * RADIUS_SLACK,
        }
    }

    /// (s, M) of the polydiscs that fit.
    pub(super) fn discs(&self) -> Vec<(f64, f64)> {
        let disc = |s: f64| {
            let m = self.local.majorant(self.half.map(|h| h * s));
            let [reach, linear, rest] = [m.displacement, m.linear, m.rest].map(|x| x * RADIUS_SLACK);
            let twisted = if reach <= MAX_RELATIVE_DISPLACEMENT * self.near {
                (self.near - reach).powi(2)
            } else {
                0.0
            };
            let straight = if linear < self.near {
                (self.near - linear).powi(2) - 2.0 * (self.near + linear) * rest - rest * rest
            } else {
                0.0
            };
            let square = twisted.max(straight) / RADIUS_SLACK;
            (square > 0.0).then(|| {
                let facing = self.facing + m.normal_change * (self.far + reach) + self.normal.length() * rest;
                (s, (self.height + reach) * facing / (PI * square * square) * RADIUS_SLACK)
            })
        };
        POLYDISC_SCALES.iter().filter_map(|s| disc(*s)).collect()
    }

    /// Bound of |K| where rounding leaves the sign of K open, for cells that see B along the surface.
    pub(super) fn clamp(&self, m: &Majorant, shake: f64) -> f64 {
        let reach = m.displacement * RADIUS_SLACK;
        let (near, far) = (self.near - reach, self.far + reach);
        let tilt = grazing_error(m.normal, shake, far);
        let either = shake * m.normal * far + tilt * (self.height + reach) + shake * tilt;
        2.0 * either * RADIUS_SLACK / (PI * near.powi(4))
    }

    /// Points in a direction over B for an error `wanted` of the mean of K, and their error bound.
    pub(super) fn points(&self, plate: &Plate, m: &Majorant, wanted: f64) -> (usize, f64) {
        let (near, far) =
            (self.near - m.displacement * RADIUS_SLACK, self.far + m.displacement * RADIUS_SLACK);
        let front = (self.height + m.displacement * RADIUS_SLACK) * m.normal / PI;
        let triangle = plate.kind == PlateKind::Triangle;
        let across = if triangle { (plate.e2 - plate.e1).length() } else { plate.e2.length() };
        let along = if triangle { plate.e1.length().max(plate.e2.length()) } else { plate.e1.length() };
        let one = |n: usize, length: f64, weighted: bool| {
            let bound = |share: &f64| {
                let delta = share * near;
                let b = 2.0 * delta / (length * RADIUS_SLACK);
                let a = (1.0 + b * b).sqrt();
                let m = front * (far + delta) / (near - delta).powi(4);
                gauss_legendre::error_bound(n, a + b, m * if weighted { 1.0 + a } else { 1.0 })
            };
            NODE_DISPLACEMENTS.iter().map(bound).fold(f64::INFINITY, f64::min)
        };
        let error = |n: usize| (one(n, along, triangle) + one(n, across, false)) * RADIUS_SLACK;
        let n = (2..MAX_POINTS).find(|n| error(*n) <= wanted).unwrap_or(MAX_POINTS);
        (n, error(n))
    }
}

/// M θ^{N+1}/(1 − θ) at its best.
pub(super) fn remainder(discs: &[(f64, f64)], tau: f64, order: usize) -> f64 {
    let term = |(s, m): &(f64, f64)| {
        let theta = tau / s;
        m * theta.powi(order as i32 + 1) / (1.0 - theta)
    };
    discs.iter().map(term).fold(f64::INFINITY, f64::min) * RADIUS_SLACK
}
