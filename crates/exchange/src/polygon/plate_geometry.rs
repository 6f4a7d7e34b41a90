//! Plates with precomputed geometry, and tensor rules arranged in SIMD lanes.

use std::sync::OnceLock;
use zonal_math::{Vec3, gauss_jacobi, gauss_legendre};
use zonal_scene::{Plate, PlateKind};

/// Numbers per vector.
pub(super) const LANES: usize = 8;

/// A plate with its corners relative to its origin; a triangle's edges turned so that e2 is the shortest.
#[derive(Clone, Debug)]
pub(super) struct PlateGeometry {
    pub origin: Vec3,
    /// The points of the plate are origin + base + α e1 + β e2.
    pub base: Vec3,
    pub e1: Vec3,
    pub e2: Vec3,
    pub kind: PlateKind,
    pub normal: Vec3,
    pub area: f64,
    /// Relative to the origin, counter-clockwise.
    pub corners: [Vec3; 4],
    pub count: usize,
    /// Relative to the origin.
    pub centre: Vec3,
    /// Largest distance of a corner from the centre and from the origin.
    pub radius: f64,
    pub reach: f64,
    /// Longest segments of the two directions of a rule.
    pub lengths: [f64; 2],
    /// The directions' extreme segments, over the shortest of each.
    directions: [[Vec3; 2]; 2],
}

impl PlateGeometry {
    pub(super) fn new(p: &Plate) -> PlateGeometry {
        let triangle = p.kind == PlateKind::Triangle;
        let (corners, count) = if triangle {
            ([Vec3::ZERO, p.e1, p.e2, p.e2], 3)
        } else {
            ([Vec3::ZERO, p.e1, p.e1 + p.e2, p.e2], 4)
        };
        let [base, e1, e2] = if triangle { shortest_edge_last(p) } else { [Vec3::ZERO, p.e1, p.e2] };
        let centre = if triangle { (p.e1 + p.e2) / 3.0 } else { (p.e1 + p.e2) * 0.5 };
        let farthest = |at: Vec3| corners.iter().fold(0.0f64, |s, c| s.max((*c - at).length()));
        let last = if triangle { e1 - e2 } else { e1 };
        let shortest = if triangle { distance_from_edge(e1, e2) } else { e1.length() };
        let (long, short) = (e1.length().max(last.length()), e2.length());
        PlateGeometry {
            origin: p.origin,
            base,
            e1,
            e2,
            kind: p.kind,
            normal: p.normal(),
            area: p.area(),
            corners,
            count,
            centre,
            radius: farthest(centre),
            reach: farthest(Vec3::ZERO),
            lengths: [long, short],
            directions: [[e1 / shortest, last / shortest], [e2 / short, e2 / short]],
        }
    }

    /// A lower bound of the sine between direction k's segments and any line from this plate to one whose centre lies along
    /// `axis`, within a `cone` of that sine and cosine.
    #[inline(always)]
    pub(super) fn least_sine(&self, k: usize, axis: Vec3, cone: [f64; 2]) -> f64 {
        let [e, f] = self.directions[k];
        let cosine = e.dot(axis).abs().max(f.dot(axis).abs());
        if cosine >= 1.0 {
            return 0.0;
        }
        let sine = (1.0 - cosine * cosine).sqrt() * cone[1] - cosine * cone[0];
        // Allowance for the roundings of the cosines.
        (sine - 1e-12).max(0.0)
    }
}

/// Base and edges of a triangle in that turn which makes e2 the shortest edge.
fn shortest_edge_last(p: &Plate) -> [Vec3; 3] {
    let (a, b, c) = (p.e2.length2(), p.e1.length2(), (p.e2 - p.e1).length2());
    if a <= b && a <= c {
        [Vec3::ZERO, p.e1, p.e2]
    } else if b <= c {
        [p.e1, p.e2 - p.e1, -p.e1]
    } else {
        [p.e2, -p.e2, p.e1 - p.e2]
    }
}

/// Distance of the corner e1 from the edge e2 through the origin: the shortest segment of a collapsed triangle.
fn distance_from_edge(e1: Vec3, e2: Vec3) -> f64 {
    let t = (e1.dot(e2) / e2.length2()).clamp(0.0, 1.0);
    (e1 - e2 * t).length()
}

/// A tensor rule: lanes of (α, β, weight), the points o + α e₁ + β e₂, weights summing to one; filled up with weight zero.
#[derive(Debug)]
pub(super) struct TensorRule {
    pub points: usize,
    pub rows: Vec<[[f64; LANES]; 3]>,
}

/// Points of a rule in one direction at most.
pub(super) const MAX_POINTS_PER_DIRECTION: usize = 8;

/// The rule with n[0] points along e1 and n[1] along e2.
pub(super) fn tensor_rule(kind: PlateKind, n: [usize; 2]) -> &'static TensorRule {
    static RULES: [[[OnceLock<TensorRule>; MAX_POINTS_PER_DIRECTION + 1]; MAX_POINTS_PER_DIRECTION + 1]; 2] = [const {
        [const { [const { OnceLock::new() }; MAX_POINTS_PER_DIRECTION + 1] }; MAX_POINTS_PER_DIRECTION + 1]
    };
        2];
    RULES[(kind == PlateKind::Triangle) as usize][n[0]][n[1]].get_or_init(|| make_rule(kind, n))
}

fn make_rule(kind: PlateKind, n: [usize; 2]) -> TensorRule {
    let second = gauss_legendre::rule(n[1]);
    let first = match kind {
        PlateKind::Parallelogram => gauss_legendre::rule(n[0]),
        PlateKind::Triangle => gauss_jacobi::rule(n[0]),
    };
    let mut points = Vec::new();
    for (u, wu) in first.nodes.iter().zip(&first.weights) {
        for (v, wv) in second.nodes.iter().zip(&second.weights) {
            let beta = if kind == PlateKind::Triangle { (1.0 - u) * v } else { *v };
            points.push([*u, beta, wu * wv]);
        }
    }
    let filled = |chunk: &[[f64; 3]], l: usize, k: usize| match chunk.get(l) {
        Some(p) => p[k],
        None if k == 2 => 0.0,
        None => chunk[0][k],
    };
    let rows =
        points.chunks(LANES).map(|c| [0, 1, 2].map(|k| std::array::from_fn(|l| filled(c, l, k)))).collect();
    TensorRule { points: points.len(), rows }
}
