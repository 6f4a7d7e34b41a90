//! Direct quadrature cell by cell, with which the series expansion is compared.

use super::plate_geometry::plate_nodes;
use super::surface::SmoothSurface;
use std::f64::consts::PI;
use zonal_exchange::{Factor, Method};
use zonal_math::{Bounded, gauss_legendre};
use zonal_scene::Plate;

/// 𝓕 of `plate` and one cell [[u₀, u₁], [v₀, v₁]] by tensor Gauss rules of `points` points in each of four directions, m². Points
/// behind either count as zero. The radius is the difference to one point less: estimated.
pub fn direct_integral(surface: &SmoothSurface, cell: [[f64; 2]; 2], plate: &Plate, points: usize) -> Factor {
    let sum = |n: usize| {
        let rule = gauss_legendre::rule(n);
        let nodes = plate_nodes(plate, n);
        let (normal, mut sum) = (plate.normal(), 0.0);
        for (x, wx) in rule.nodes.iter().zip(&rule.weights) {
            for (z, wz) in rule.nodes.iter().zip(&rule.weights) {
                let (u, v) =
                    (cell[0][0] + x * (cell[0][1] - cell[0][0]), cell[1][0] + z * (cell[1][1] - cell[1][0]));
                let (s, slope) = (surface.at(u, v), surface.normal(u, v));
                for (y, w) in &nodes {
                    let d = s - *y;
                    sum +=
                        wx * wz * w * normal.dot(d).max(0.0) * (-slope.dot(d)).max(0.0) / d.length2().powi(2);
                }
            }
        }
        sum * plate.area() * (cell[0][1] - cell[0][0]) * (cell[1][1] - cell[1][0]) / PI
    };
    let (fine, coarse) = (sum(points), sum(points - 1));
    let evaluations = (points.pow(4) + (points - 1).pow(4)) as u64;
    Factor { bounded: Bounded::estimated(fine, (fine - coarse).abs()), evaluations, method: Method::Oblique }
}
