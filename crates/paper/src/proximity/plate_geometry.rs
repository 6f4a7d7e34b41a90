//! Distances, quadrature nodes and condition of a plate.

use super::error_constants::RADIUS_SLACK;
use zonal_math::{Vec3, gauss_legendre};
use zonal_scene::{Plate, PlateKind};

/// Smallest distance of a point to a plate, m, rounded down.
pub(super) fn distance(plate: &Plate, x: Vec3) -> f64 {
    let (corners, n) = plate.corners();
    let [u, v] = plate.parameters(x);
    let inside = u >= 0.0 && v >= 0.0 && if n == 3 { u + v <= 1.0 } else { u <= 1.0 && v <= 1.0 };
    let to_edge = |k: usize| {
        let (a, e) = (corners[k], corners[(k + 1) % n] - corners[k]);
        let t = ((x - a).dot(e) / e.length2()).clamp(0.0, 1.0);
        (x - a - e * t).length()
    };
    let flat = if inside { plate.normal().dot(x - plate.origin).abs() } else { f64::INFINITY };
    (0..n).map(to_edge).fold(flat, f64::min) / RADIUS_SLACK
}

/// Largest distance of a point to a plate, m.
pub(super) fn farthest(plate: &Plate, x: Vec3) -> f64 {
    let (corners, n) = plate.corners();
    corners[..n].iter().fold(0.0f64, |s, c| s.max((x - *c).length())) * RADIUS_SLACK
}

/// Nodes of B and their weights, of sum one to quadrature.
pub(super) fn plate_nodes(plate: &Plate, n: usize) -> Vec<(Vec3, f64)> {
    let rule = gauss_legendre::rule(n);
    let mut out = Vec::with_capacity(n * n);
    for (s, ws) in rule.nodes.iter().zip(&rule.weights) {
        for (t, wt) in rule.nodes.iter().zip(&rule.weights) {
            out.push(match plate.kind {
                PlateKind::Parallelogram => (plate.at(*s, *t), ws * wt),
                PlateKind::Triangle => (plate.at(s * (1.0 - t), s * t), 2.0 * s * ws * wt),
            });
        }
    }
    out
}

/// Sum of the lengths from which a plate's points are computed, m.
pub(super) fn coordinate_scale(plate: &Plate) -> f64 {
    plate.origin.length() + plate.e1.length() + plate.e2.length()
}

/// Amplification of the rounding of the edges in a plate's normal and area: 1 for a rectangle.
pub(super) fn edge_skew(plate: &Plate) -> f64 {
    plate.e1.length() * plate.e2.length() / plate.e1.cross(plate.e2).length()
}
