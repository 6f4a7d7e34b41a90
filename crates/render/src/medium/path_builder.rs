//! From a ray to its path: a traversal of the voxel grid, merged with the panes that the ray crosses.
//!
//! A pane of depth κt at the angle θ to its normal multiplies the transmittance by e^{−κt/|cosθ|} and adds the complement times B/π, with B
//! its interpolated radiosity. A voxel whose extinction is interpolated becomes up to four segments (`interpolated_extinction`). Cost: one step per voxel and one lookup per pane.

use super::interpolated_extinction::InterpolatedExtinction;
use super::ray_path::{RayPath, VoxelSegment};
use crate::surface::patch_field::PatchField;
use crate::surface::tiles::pane_field;
use crate::view_ray::ViewRay;
use std::f64::consts::PI;
use zonal_math::Vec3;
use zonal_scene::{Bands, Solution};
use zonal_transport::{PaneHit, Transport};

/// Builds ray paths through one solution.
pub(crate) struct PathBuilder<'a> {
    solution: &'a Solution,
    transport: &'a Transport<'a>,
    /// B of the panes, direct light included.
    panes: PatchField<'a>,
    /// Index of the first plate of each pane among all plates.
    first_plates: Vec<usize>,
    /// The extinction between cells, where it is interpolated.
    extinction: Option<InterpolatedExtinction<'a>>,
}

impl<'a> PathBuilder<'a> {
    /// Prepares the field of the panes.
    pub(crate) fn new(solution: &'a Solution, transport: &'a Transport<'a>) -> PathBuilder<'a> {
        let (panes, first_plates) = pane_field(solution);
        let extinction = solution.scene.voxel_grid().and_then(InterpolatedExtinction::new);
        PathBuilder { solution, transport, panes, first_plates, extinction }
    }

    /// The panes between two points, by distance.
    pub(crate) fn pane_crossings(&self, a: Vec3, b: Vec3) -> Vec<PaneHit> {
        let mut panes = Vec::new();
        self.transport.pane_crossings(a, b, &mut |h| panes.push(h));
        panes
    }

    /// Segments, panes and transmittance of the part of a ray between the distances `from` and `to`, m; `panes` lie within it, by distance.
    pub(crate) fn build(&self, ray: ViewRay, from: f64, to: f64, panes: Vec<PaneHit>) -> RayPath {
        let mut cells = Vec::with_capacity(64);
        self.transport.traverse_grid(ray.at(from), ray.at(to), &mut |cell, t0, t1| {
            cells.push((cell, from + t0, from + t1));
        });
        let segments = Vec::with_capacity(cells.len() + panes.len());
        let mut path = RayPath { transmittance: Bands::ONE, segments, ..RayPath::default() };
        let mut panes = panes.into_iter().peekable();
        for (cell, mut t0, t1) in cells {
            while let Some(p) = panes.next_if(|p| p.t < t1) {
                self.push_segment(&mut path, cell, t0, p.t.max(t0), ray);
                t0 = p.t.max(t0);
                self.cross_pane(&mut path, &p, ray);
            }
            self.push_segment(&mut path, cell, t0, t1, ray);
        }
        panes.for_each(|p| self.cross_pane(&mut path, &p, ray));
        path
    }

    fn push_segment(&self, path: &mut RayPath, cell: usize, t0: f64, t1: f64, ray: ViewRay) {
        if t1 <= t0 {
            return;
        }
        let Some(zone) = self.transport.volume_zone_at(&self.solution.zones, cell, ray.at(0.5 * (t0 + t1)))
        else {
            return;
        };
        let z = self.solution.zones.voxels.at(zone);
        let mut push = |t0: f64, t1: f64, extinction: Bands| {
            path.segments.push(VoxelSegment {
                t0,
                t1,
                zone,
                extinction,
                scattering: extinction * z.albedo,
                transmittance: path.transmittance,
            });
            if extinction != Bands::ZERO {
                path.transmittance *= (-extinction * (t1 - t0)).exp();
            }
        };
        match self.extinction.as_ref().filter(|f| f.is_interpolated(cell)) {
            Some(field) => field.for_each_part(cell, |t| ray.at(t), t0, t1, push),
            None => push(t0, t1, z.extinction),
        }
    }

    fn cross_pane(&self, path: &mut RayPath, hit: &PaneHit, ray: ViewRay) {
        let pane = &self.solution.scene.panes()[hit.pane];
        let (plate, point) = (&pane.plates[hit.plate], ray.at(hit.t));
        let plate_index = self.first_plates[hit.pane] + hit.plate;
        let radiosity: Bands =
            self.panes.at(plate_index, plate.parameters(point), point).unwrap_or(Bands::ZERO);
        let pane_transmittance = (-pane.extinction * pane.thickness / hit.cos).exp();
        path.pane_radiance += path.transmittance * (1.0 - pane_transmittance) * radiosity / PI;
        path.transmittance *= pane_transmittance;
    }
}
