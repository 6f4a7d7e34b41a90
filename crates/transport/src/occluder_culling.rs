//! Culling of facets that never occlude.
//!
//! Let the whole scene lie in one closed half-space of a facet's plane. A segment between two points of the scene's convex hull then
//! stays in that half-space, so it can touch the facet but not cross it. The walls of a convex room are of that kind, unless the
//! voxel grid extends beyond them.
//!
//! Each distinct plane is tested once: first against the extreme points of the scene in 26 directions, then against the BVH of
//! the facets.

use crate::bvh::Bvh;
use crate::intersect::Tolerance;
use std::collections::HashMap;
use zonal_math::parallel;
use zonal_math::{Vec3, vec3};
use zonal_scene::{Plate, Scene};

/// For each plate: whether the scene has parts on both sides of its plane. `facets` is the BVH of the facets.
pub(crate) fn planes_dividing_scene(
    scene: &Scene,
    plates: &[Plate],
    facets: &Bvh,
    tol: &Tolerance,
) -> Vec<bool> {
    let extra = pane_and_grid_corners(scene);
    let extreme = extreme_points(scene, &extra);
    // Collect the distinct planes: tessellated walls share few.
    let mut planes: Vec<(Vec3, f64)> = Vec::new();
    let mut plane_index: HashMap<[i64; 4], usize> = HashMap::new();
    let size = scene.diagonal();
    let plane_of_plate: Vec<usize> = plates
        .iter()
        .map(|p| {
            let n = p.normal();
            let c = n.dot(p.centre());
            let round = |x: f64| (x * 1e11).round() as i64;
            let key = [round(n.x), round(n.y), round(n.z), round(c / size)];
            *plane_index.entry(key).or_insert_with(|| {
                planes.push((n, c));
                planes.len() - 1
            })
        })
        .collect();
    // Test each plane on both sides.
    let divides: Vec<bool> = parallel::map(&planes, |&(n, c)| {
        let has_points_above = |n: Vec3, c: f64| {
            let is_above = |x: &Vec3| n.dot(*x) - c > tol.plane;
            extreme.iter().any(is_above)
                || extra.iter().any(is_above)
                || facets.has_points_above(n, c, tol.plane)
        };
        has_points_above(n, c) && has_points_above(-n, -c)
    });
    plane_of_plate.into_iter().map(|k| divides[k]).collect()
}

/// Corners of the panes and of the voxel grid.
fn pane_and_grid_corners(scene: &Scene) -> Vec<Vec3> {
    let panes = scene.panes().iter().flat_map(|p| &p.plates);
    let mut points: Vec<Vec3> = panes
        .flat_map(|p| {
            let (x, n) = p.corners();
            x.into_iter().take(n)
        })
        .collect();
    if let Some(grid) = scene.voxel_grid() {
        let (lo, hi) = (grid.min(), grid.max());
        for k in 0..8 {
            let pick = |bit: usize, l: f64, h: f64| if k >> bit & 1 == 1 { h } else { l };
            points.push(vec3(pick(0, lo.x, hi.x), pick(1, lo.y, hi.y), pick(2, lo.z, hi.z)));
        }
    }
    points
}

/// The extreme points of the scene in 26 directions. They alone show that most interior facets divide the scene.
fn extreme_points(scene: &Scene, extra: &[Vec3]) -> Vec<Vec3> {
    let mut best = vec![(f64::NEG_INFINITY, Vec3::ZERO); 27];
    let mut update = |x: Vec3| {
        for (k, b) in best.iter_mut().enumerate() {
            let d = [k / 9, k / 3 % 3, k % 3].map(|i| i as f64 - 1.0);
            let projection = x.dot(Vec3::from_array(d));
            if projection > b.0 {
                *b = (projection, x);
            }
        }
    };
    for f in scene.facets() {
        let (x, n) = f.plate.corners();
        x[..n].iter().for_each(|x| update(*x));
    }
    extra.iter().for_each(|x| update(*x));
    best.into_iter().map(|b| b.1).collect()
}
