//! Forecast of the processor time of the dense and of the rays engine, by counts alone, so that a choice does not depend on the machine.
//!
//! ```text
//! dense            n (n + 1)/2 pairs × time of a pair          a pair of boxes by formulas, with rays for visibility, or a pair of oblique plates
//!                                                              that face each other, whose share is that of a sample of the pairs
//! rays     n zones × (stored rays × time of a ray + samples of the gather × time of a sample + time of a zone)
//! ```
//!
//! The times are those of one core of 2023: of a pair measured on a room, the chapel of the demo and the gallery, of a sample on these and the church
//! (`zonal solve`, processor time over counts). Single scenes differ by a factor of three.

use crate::engines::problem_size::ProblemSize;
use crate::engines::rays::gather::final_gather::expected_samples;
use crate::engines::rays::stored_rays::ray_sampling::{rays_per_zone, total_rays};
use zonal_math::parallel;
use zonal_math::{Vec3, low_discrepancy};
use zonal_scene::{Patch, Scene, Zones};

/// Microseconds of a pair: boxes without obstacles, boxes that facets may divide, and plates or cut voxels in any position that face each other (4.7 to 6.9 in a city, a ball
/// on a floor, a furnished room and the chapel of the demo).
const PAIR_MICROSECONDS: [f64; 3] = [0.25, 2.0, 7.0];
/// Pairs of patches of which the share that face each other is taken.
const SAMPLED_PATCH_PAIRS: usize = 4096;
/// Height up to which a patch counts as in the plane of another, over the sum of their diameters.
const IN_PLANE_HEIGHT: f64 = 1e-10;
/// Factor on the time of a pair where the medium varies.
const VARYING_MEDIUM_FACTOR: f64 = 2.0;
/// Microseconds of a stored ray, of a sample of the gather, and of a zone.
const RAY_MICROSECONDS: f64 = 0.5;
const SAMPLE_MICROSECONDS: f64 = 1.5;
const ZONE_MICROSECONDS: f64 = 100.0;
/// Samples over the expected number that the choice assumes: near the upper end of what scenes need. Where costs are close, the dense engine is taken,
/// whose factors are more accurate than the tolerance.
const SAMPLES_OVER_EXPECTED: f64 = 3.0;

/// Expected processor seconds of both engines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CostForecast {
    /// Of the dense engine, s.
    pub dense: f64,
    /// Of the rays engine, s.
    pub rays: f64,
}

/// True for a plate whose edges lie along the axes.
fn is_aligned(edges: [Vec3; 2]) -> bool {
    let along_axis = |e: Vec3| e.array().iter().filter(|x| x.abs() > 1e-9 * e.length()).count() == 1;
    edges.into_iter().all(along_axis)
}

/// True if patch `q` lies behind patch `p`: such pairs are not computed.
fn lies_behind(q: &Patch, p: &Patch) -> bool {
    let tolerance = IN_PLANE_HEIGHT * (q.plate.diameter() + p.plate.diameter());
    q.plate.is_behind(p.plate.origin, p.normal, tolerance)
}

/// Share of the pairs of zones that are not two patches of which one lies behind the other.
fn share_of_facing_pairs(zones: &Zones) -> f64 {
    let patches = &zones.patches;
    if patches.is_empty() {
        return 1.0;
    }
    let faces = |k: &usize| {
        let [p, q] = low_discrepancy::r2(*k, [0.5; 2]).map(|u| &patches[(u * patches.len() as f64) as usize]);
        !lies_behind(q, p) && !lies_behind(p, q)
    };
    let facing = (0..SAMPLED_PATCH_PAIRS).filter(faces).count() as f64 / SAMPLED_PATCH_PAIRS as f64;
    let both_patches = (patches.len() as f64 / zones.len() as f64).powi(2);
    1.0 - both_patches * (1.0 - facing)
}

impl CostForecast {
    /// For the zones of a scene.
    pub(crate) fn new(scene: &Scene, zones: &Zones, size: &ProblemSize) -> CostForecast {
        let tolerance = scene.options().tolerance;
        let aligned = parallel::all(&zones.patches, |p| is_aligned([p.plate.e1, p.plate.e2]));
        let kind =
            if !aligned || size.cut > 0 || size.panes > 0 { 2 } else { usize::from(size.occluders > 0) };
        let varies = scene.voxel_grid().is_some_and(|g| g.uniform_extinction().is_none());
        let factor = if varies { VARYING_MEDIUM_FACTOR } else { 1.0 };
        let share = if kind == 2 { share_of_facing_pairs(zones) } else { 1.0 };
        let rays = total_rays(zones, rays_per_zone(zones, tolerance, f64::INFINITY)) as f64;
        let n = zones.len() as f64;
        let of_zones = n
            * (SAMPLES_OVER_EXPECTED * expected_samples(tolerance) * SAMPLE_MICROSECONDS + ZONE_MICROSECONDS);
        CostForecast {
            dense: 1e-6 * factor * PAIR_MICROSECONDS[kind] * share * size.pairs as f64,
            rays: 1e-6 * (rays * RAY_MICROSECONDS + of_zones),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;
    use zonal_scene::{Bands, Plate};

    fn patch(origin: Vec3, e1: Vec3, e2: Vec3) -> Patch {
        let (plate, zero) = (Plate::parallelogram(origin, e1, e2), Bands::ZERO);
        Patch {
            facet: 0,
            surface: 0,
            plate,
            normal: plate.normal(),
            area: 1.0,
            reflectance: zero,
            emission: zero,
        }
    }

    #[test]
    fn patches_of_a_plane_do_not_face_each_other_and_walls_do() {
        let (x, y, z) = (vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0));
        let floor = patch(Vec3::ZERO, x, y);
        let beside = patch(x, x, y);
        let wall = patch(Vec3::ZERO, y, z);
        let ceiling = patch(z, y, x);
        assert!(lies_behind(&beside, &floor) && lies_behind(&floor, &beside));
        assert!(!lies_behind(&wall, &floor) && !lies_behind(&floor, &wall));
        assert!(!lies_behind(&ceiling, &floor) && !lies_behind(&floor, &ceiling));
        // Two floors and a ceiling: of nine ordered pairs the four of a floor and the ceiling.
        let zones = Zones { patches: vec![floor, beside, ceiling], ..Zones::default() };
        let share = share_of_facing_pairs(&zones);
        assert!((share - 4.0 / 9.0).abs() < 0.01, "{share}");
    }
}
