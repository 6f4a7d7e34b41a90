//! Whether a point lies in a closed solid.
//!
//! Follow a direction outward and count: a front (entering a solid) +1, a back (leaving one) −1. The count falls below zero
//! somewhere if and only if the point started inside. Overlapping solids, solids in a room whose walls are solid, and faces that
//! touch all come out right. Three skew directions vote, so one that runs through an edge or an open bottom is outvoted.

use crate::bvh::Bvh;
use crate::meet::Tolerance;
use zonal_math::{Vec3, vec3};

const DIRECTIONS: [Vec3; 3] = [
    vec3(0.382_917_511, 0.267_410_983, 0.884_207_139),
    vec3(-0.711_309_127, 0.621_937_419, 0.327_514_807),
    vec3(0.287_631_903, -0.530_713_331, -0.797_279_619),
];

/// True when most of the three directions say so. `reach` is longer than the scene's diagonal.
pub(crate) fn inside(solids: &Bvh, p: Vec3, reach: f64, tol: &Tolerance) -> bool {
    if solids.len() == 0 {
        return false;
    }
    let votes = |k: usize| leaves_solid(solids, p, DIRECTIONS[k] * reach, tol);
    let (x, y) = (votes(0), votes(1));
    if x == y { x } else { votes(2) }
}

fn leaves_solid(solids: &Bvh, p: Vec3, d: Vec3, tol: &Tolerance) -> bool {
    let mut hits: Vec<(f64, i32)> = Vec::new();
    solids.all(p, p + d, tol, |_, [t, ..], along| {
        hits.push((t, if along < 0.0 { 1 } else { -1 }));
    });
    hits.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
    let mut count = 0;
    hits.iter().any(|h| {
        count += h.1;
        count < 0
    })
}
