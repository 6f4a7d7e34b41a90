//! Forecast of the processor time of the dense and of the hierarchical engine, by counts alone, so that a choice does not depend on the machine.
//!
//! ```text
//! dense            n (n + 1)/2 pairs × time of a pair          a pair of boxes by formulas, with rays for visibility, or a pair of oblique plates
//! hierarchical     n zones × (stored rays × time of a ray + samples of the gather × time of a sample + time of a zone)
//! ```
//!
//! The times are those of one core of 2023: of a pair measured on a room, the chapel of the demo and the gallery, of a sample on these and the church
//! (`zonal solve`, processor time over counts). Single scenes differ by a factor of three.

use crate::gather::final_gather::expected_samples;
use crate::ray::ray_sampling::{rays_per_zone, total_rays};
use crate::report::cost_estimate::problem_size::ProblemSize;
use rayon::prelude::*;
use zonal_math::Vec3;
use zonal_scene::{Scene, Zones};

/// Microseconds of a pair: boxes without obstacles, boxes that facets may divide, and plates or cut voxels in any position.
const PAIR_MICROSECONDS: [f64; 3] = [0.25, 2.0, 7.0];
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
    /// Of the hierarchical engine, s.
    pub hierarchical: f64,
}

/// True for a plate whose edges lie along the axes.
fn is_aligned(edges: [Vec3; 2]) -> bool {
    let along_axis = |e: Vec3| e.array().iter().filter(|x| x.abs() > 1e-9 * e.length()).count() == 1;
    edges.into_iter().all(along_axis)
}

impl CostForecast {
    /// For the zones of a scene.
    pub(crate) fn new(scene: &Scene, zones: &Zones, size: &ProblemSize) -> CostForecast {
        let tolerance = scene.options().tolerance;
        let aligned = zones.patches.par_iter().all(|p| is_aligned([p.plate.e1, p.plate.e2]));
        let kind = match () {
            () if !aligned || size.cut > 0 || size.panes > 0 => 2,
            () if size.occluders > 0 => 1,
            () => 0,
        };
        let varies = scene.voxel_grid().is_some_and(|g| g.uniform_extinction().is_none());
        let factor = if varies { VARYING_MEDIUM_FACTOR } else { 1.0 };
        let rays = total_rays(zones, rays_per_zone(zones, tolerance, f64::INFINITY)) as f64;
        let n = zones.len() as f64;
        let of_zones = n
            * (SAMPLES_OVER_EXPECTED * expected_samples(tolerance) * SAMPLE_MICROSECONDS + ZONE_MICROSECONDS);
        CostForecast {
            dense: 1e-6 * factor * PAIR_MICROSECONDS[kind] * size.pairs as f64,
            hierarchical: 1e-6 * (rays * RAY_MICROSECONDS + of_zones),
        }
    }
}
