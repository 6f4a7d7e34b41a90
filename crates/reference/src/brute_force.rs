//! Ray queries by brute force.
//!
//! A ray is tested against each facet in turn (Cramer's rule in the plate's plane). The ray is cut into segments at every plane
//! between cells of the voxel grid and at every pane; the cuts are sorted, and the midpoint of each segment determines its cell. The
//! cost of a ray is proportional to the number of facets, planes and panes.

use zonal_math::Vec3;
use zonal_scene::{Bands, Plate, PlateKind, Scene};

/// The first facet on a ray.
#[derive(Clone, Copy, Debug)]
pub struct FacetHit {
    /// Distance, m.
    pub t: f64,
    /// Index of the facet.
    pub facet: usize,
    /// Parameters of the point on the plate.
    pub uv: [f64; 2],
    /// True when the front is hit.
    pub front: bool,
}

/// A segment of a ray in one cell, or outside of all cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RaySegment {
    /// Distance of its start, m.
    pub from: f64,
    /// Distance of its end, m.
    pub to: f64,
    /// The cell; `None` outside of the voxel grid.
    pub cell: Option<usize>,
    /// The pane that is crossed at the start, with its optical depth per band.
    pub pane: Option<(usize, Bands)>,
}

/// Distance along a ray of unit direction to a plate, with plate parameters; `None` for a ray along the plate.
pub(crate) fn intersect_plate(p: &Plate, o: Vec3, d: Vec3) -> Option<(f64, [f64; 2])> {
    let n = p.e1.cross(p.e2);
    let along = n.dot(d);
    if along.abs() < 1e-12 * n.length() {
        return None;
    }
    let t = n.dot(p.origin - o) / along;
    let [u, v] = p.parameters(o + d * t);
    let far = if p.kind == PlateKind::Triangle { u + v <= 1.0 } else { u <= 1.0 && v <= 1.0 };
    (u >= 0.0 && v >= 0.0 && far).then_some((t, [u, v]))
}

/// A scene with the range of its rays.
pub struct BruteForceScene<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Shortest distance of a hit, m.
    pub near: f64,
    /// Length of a ray that hits nothing, m.
    pub far: f64,
}

impl<'a> BruteForceScene<'a> {
    /// Prepares a scene.
    pub fn new(scene: &'a Scene) -> BruteForceScene<'a> {
        let size = scene.diagonal();
        BruteForceScene { scene, near: 1e-9 * size, far: 4.0 * size }
    }

    /// The first facet on the ray.
    pub fn first_hit(&self, o: Vec3, d: Vec3) -> Option<FacetHit> {
        let mut best: Option<FacetHit> = None;
        for (facet, f) in self.scene.facets().iter().enumerate() {
            if let Some((t, uv)) = intersect_plate(&f.plate, o, d)
                && t > self.near
                && best.is_none_or(|b| t < b.t)
            {
                best = Some(FacetHit { t, facet, uv, front: d.dot(f.plate.normal()) < 0.0 });
            }
        }
        best
    }

    /// True when no facet lies between two points.
    pub(crate) fn visible(&self, a: Vec3, b: Vec3) -> bool {
        let r = (b - a).length();
        self.first_hit(a, (b - a) / r).is_none_or(|s| s.t > r - self.near)
    }

    /// The segments of a ray from 0 to `limit` (m), in order.
    pub(crate) fn segments(&self, o: Vec3, d: Vec3, limit: f64) -> Vec<RaySegment> {
        let mut cuts: Vec<(f64, Option<(usize, Bands)>)> = vec![(0.0, None), (limit, None)];
        if let Some(grid) = self.scene.voxel_grid() {
            for axis in 0..3 {
                for k in 0..=grid.dims()[axis] {
                    let t = (grid.min()[axis] + k as f64 * grid.cell()[axis] - o[axis]) / d[axis];
                    if t > 0.0 && t < limit {
                        cuts.push((t, None));
                    }
                }
            }
        }
        for (k, p) in self.scene.panes().iter().enumerate() {
            let hit = p.plates.iter().find_map(|q| intersect_plate(q, o, d).map(|h| (h.0, q.normal())));
            if let Some((t, n)) = hit
                && t > self.near
                && t < limit - self.near
            {
                let path = p.thickness / n.dot(d).abs();
                cuts.push((t, Some((k, p.extinction * path))));
            }
        }
        cuts.sort_by(|a, b| a.0.total_cmp(&b.0));
        cuts.windows(2)
            .map(|w| RaySegment {
                from: w[0].0,
                to: w[1].0,
                cell: self.cell(o + d * (0.5 * (w[0].0 + w[1].0))),
                pane: w[0].1,
            })
            .collect()
    }

    /// The cell that holds `p`.
    fn cell(&self, p: Vec3) -> Option<usize> {
        let grid = self.scene.voxel_grid()?;
        let mut c = [0; 3];
        for axis in 0..3 {
            let x = ((p[axis] - grid.min()[axis]) / grid.cell()[axis]).floor();
            if !(x >= 0.0 && x < grid.dims()[axis] as f64) {
                return None;
            }
            c[axis] = x as usize;
        }
        Some(grid.index(c))
    }

    /// Extinction κ of a segment per band, 1/m.
    pub(crate) fn extinction(&self, segment: &RaySegment) -> Bands {
        segment
            .cell
            .map_or(Bands::ZERO, |c| self.scene.voxel_grid().expect("a cell belongs to a grid").extinction(c))
    }

    /// Optical depth of a ray from 0 to `limit` (m), per band.
    pub(crate) fn optical_depth(&self, o: Vec3, d: Vec3, limit: f64) -> Bands {
        let mut sum = Bands::ZERO;
        for segment in self.segments(o, d, limit) {
            let kappa = self.extinction(&segment);
            sum += segment.pane.map_or(Bands::ZERO, |p| p.1) + kappa * (segment.to - segment.from);
        }
        sum
    }
}
