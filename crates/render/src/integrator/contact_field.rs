//! Irradiance near contacts: corrections of the interpolated field where surfaces lie closer than a patch is large.
//!
//! The interpolated irradiance H̄ of a patch cannot follow the light below a ball that lies on it, or in a crease. A patch with surfaces within its
//! reach r = [`REACH_IN_PATCH_SIZES`] √A has a lattice of nodes. At a node x the gather gives H and the nearness f, the mean of (1 − t/r)⁺ over rays
//! of length t, and
//!
//! ```text
//! δ(x) = w(f) (H(x) − H̄(x))        w = s²(3 − 2s), s = min(1, f/f₁)
//! ```
//!
//! is interpolated between the nodes (`node_lattice`) and added to H̄. All nodes have the same directions: the error of the gather varies smoothly and is no
//! grain, and nodes on a common edge of two patches agree. The weight w vanishes where nothing is near, so that the field joins that of patches
//! without nodes. The spacing of the nodes is a few pixels of the camera; patches that are not larger have none. Cost: one gather for each node that
//! a camera ray needs.

use super::final_gather::{FinalGather, GatherInputs};
use super::node_lattice::{NodeLattice, Viewpoint};
use super::ray_sampler::RaySampler;
use crate::interpolation::lazy_values::LazyValues;
use crate::surface::patch_field::PatchField;
use crate::surface::shading::ReceiverPoint;
use zonal_math::{Vec3, direction_sampling, low_discrepancy};
use zonal_scene::{Bands, Patch, PlateKind, Solution};
use zonal_transport::Transport;

/// r over √A.
const REACH_IN_PATCH_SIZES: f64 = 1.5;
/// f₁.
const FULL_NEARNESS: f64 = 0.06;
/// Rays of a node.
const RAYS_PER_NODE: usize = 256;
/// Pixels between nodes, and most intervals along an edge.
const PIXELS_PER_NODE: f64 = 4.0;
const MAX_INTERVALS: usize = 8;
/// Points of a patch from which near surfaces are sought, by their parameters, and rays of each.
const TEST_POINTS: [[f64; 2]; 5] = [[0.33, 0.33], [0.02, 0.02], [0.96, 0.02], [0.02, 0.96], [0.96, 0.96]];
const RAYS_PER_TEST_POINT: usize = 16;

/// Corrections of the interpolated irradiance near contacts, for one camera.
pub(crate) struct ContactField<'a> {
    solution: &'a Solution,
    transport: &'a Transport<'a>,
    gather: FinalGather<'a>,
    viewpoint: Viewpoint,
    lattices: LazyValues<Option<NodeLattice>>,
}

impl<'a> ContactField<'a> {
    /// No correction is computed yet.
    pub(crate) fn new(
        s: &'a Solution,
        transport: &'a Transport<'a>,
        viewpoint: Viewpoint,
    ) -> ContactField<'a> {
        ContactField {
            solution: s,
            transport,
            gather: FinalGather::new(s, transport, RAYS_PER_NODE),
            viewpoint,
            lattices: LazyValues::new(s.zones.patches.len()),
        }
    }

    /// Leaves the nodes of the camera before.
    pub(crate) fn look_from(&mut self, viewpoint: Viewpoint) {
        self.viewpoint = viewpoint;
        self.lattices = LazyValues::new(self.solution.zones.patches.len());
    }

    /// The correction of `irradiance`, the interpolated H, at a point of patch `i`, W/m².
    pub(crate) fn correction(
        &self,
        inputs: GatherInputs,
        irradiance: &PatchField,
        i: usize,
        point: Vec3,
    ) -> Bands {
        let Some(lattice) = self.lattices.get(i, || self.lattice(i)) else { return Bands::ZERO };
        let scale = irradiance.on_tile(i, point);
        let node = |at: Vec3| self.node(inputs, irradiance, i, at);
        lattice.at(&self.solution.zones.patches[i].plate, point, scale, &node)
    }

    /// The lattice of a patch; `None` where nothing is near or the camera does not resolve it.
    fn lattice(&self, i: usize) -> Option<NodeLattice> {
        let patch = &self.solution.zones.patches[i];
        let intervals = self.viewpoint.intervals(&patch.plate, PIXELS_PER_NODE, MAX_INTERVALS);
        (intervals > 0 && self.is_near_a_surface(patch)).then(|| NodeLattice::new(intervals))
    }

    fn is_near_a_surface(&self, patch: &Patch) -> bool {
        let reach = REACH_IN_PATCH_SIZES * patch.area.sqrt();
        TEST_POINTS.iter().any(|&[u, v]| {
            let point = match patch.plate.kind {
                PlateKind::Triangle if u + v > 1.0 => patch.plate.at(0.49, 0.49),
                _ => patch.plate.at(u, v),
            };
            (0..RAYS_PER_TEST_POINT).any(|k| {
                let dir =
                    direction_sampling::cosine_hemisphere(patch.normal, low_discrepancy::r2(k, [0.5; 2]));
                self.transport.closest_hit(point, dir, 1e-6 * reach, reach).is_some()
            })
        })
    }

    /// δ at a node of patch `i`.
    fn node(&self, inputs: GatherInputs, irradiance: &PatchField, i: usize, at: Vec3) -> Bands {
        let patch = &self.solution.zones.patches[i];
        let reach = REACH_IN_PATCH_SIZES * patch.area.sqrt();
        let sampler = RaySampler::of_ray(0, 1, [0.5; 3]);
        let surface = ReceiverPoint::without_map(self.transport, patch.facet, at, patch.normal);
        let gathered = self.gather.irradiance_and_nearness(inputs, surface, reach, sampler);
        let s = (gathered.nearness / FULL_NEARNESS).min(1.0);
        let interpolated = irradiance.on_tile(i, at);
        (gathered.irradiance - interpolated) * (s * s * (3.0 - 2.0 * s))
    }
}

#[cfg(test)]
mod tests {
    use super::super::radiance::Integrator;
    use super::*;
    use crate::test_scenes::{quad, solution, surface};
    use crate::view_ray::ViewRay;
    use std::f64::consts::PI;
    use zonal_math::vec3;
    use zonal_scene::SceneParts;

    /// Height and half the width of a plate of emission 1 above a floor, m.
    const HEIGHT: f64 = 0.1;
    const HALF_WIDTH: f64 = 0.2;

    /// H of the floor below the plate: the midpoint rule over h²/(π r⁴).
    fn exact(p: Vec3) -> f64 {
        let n = 200;
        let step = 2.0 * HALF_WIDTH / n as f64;
        let at = |k: usize| -HALF_WIDTH + (k as f64 + 0.5) * step;
        let cell = |k: usize| {
            let r2 = (at(k / n) - p.x).powi(2) + (at(k % n) - p.y).powi(2) + HEIGHT * HEIGHT;
            HEIGHT * HEIGHT / (PI * r2 * r2) * step * step
        };
        (0..n * n).map(cell).sum()
    }

    #[test]
    fn light_near_a_floor_is_resolved_within_its_patches() {
        let floor = quad(0, vec3(-1.0, -1.0, 0.0), vec3(2.0, 0.0, 0.0), vec3(0.0, 2.0, 0.0));
        let edge = 2.0 * HALF_WIDTH;
        let plate =
            quad(1, vec3(-HALF_WIDTH, -HALF_WIDTH, HEIGHT), vec3(0.0, edge, 0.0), vec3(edge, 0.0, 0.0));
        let parts = SceneParts {
            surfaces: vec![surface("floor", 0.5, 0.0), surface("plate", 0.0, 1.0)],
            facets: vec![floor, plate],
            ..SceneParts::default()
        };
        // The mean of the patch of 0.25 m about the point.
        let mean = |p: Vec3, n: Vec3| {
            let at = |k: usize| 0.25 * ((k as f64 + 0.5) / 8.0 - 0.5);
            let points = (0..64).map(|k| exact(vec3(p.x + at(k / 8), p.y + at(k % 8), 0.0)));
            if p.z == 0.0 && n.z > 0.0 { points.sum::<f64>() / 64.0 } else { 0.0 }
        };
        let s = solution(parts, mean, |_| 0.0);
        let transport = Transport::new(&s.scene);
        let smooth = Integrator::new(&s, &transport);
        let mut resolved = Integrator::new(&s, &transport);
        resolved.look_from(Viewpoint { origin: vec3(0.0, 0.0, 0.05), pixel_angle: 1e-3 });
        let sampler = RaySampler::of_ray(0, 1, [0.5; 3]);
        let (mut worst, mut worst_smooth) = (0.0f64, 0.0f64);
        for k in 0..60 {
            let x = 0.5 * k as f64 / 60.0;
            let ray = ViewRay { origin: vec3(x, 0.03, 0.05), dir: vec3(0.0, 0.0, -1.0) };
            let off = |i: &Integrator| {
                let h = i.radiance(ray, sampler).first() * PI / 0.5;
                (h - exact(ray.origin)).abs() / exact(vec3(0.0, 0.0, 0.0))
            };
            (worst, worst_smooth) = (worst.max(off(&resolved)), worst_smooth.max(off(&smooth)));
        }
        assert!(worst < 0.04 && worst_smooth > 0.15, "{worst:.3}, interpolated {worst_smooth:.3}");
    }
}
