//! Visibility and closest-hit queries on a scene.
//!
//! [`Transport`] holds one bounding volume hierarchy over all facets and one over all pane plates. Queries between two points of the
//! scene itself (suffix `_inside`) use smaller trees without the facets and panes that `occluder_culling` proves harmless. Lengths
//! are in metres, extinctions in 1/m; optical depths are dimensionless.

use crate::bvh::Bvh;
use crate::intersect::Tolerance;
use crate::patch_locator::FacetSide;
use crate::shaft_culling::{Shaft, ShaftEnd};
use crate::solids::Solids;
use crate::uniform_blocks::UniformBlocks;
use crate::{grid_traversal, occluder_culling};
use std::sync::Arc;
use zonal_math::Vec3;
use zonal_scene::voxel_samples::subcell_at;
use zonal_scene::{Bands, Plate, Scene, Zones};

/// The first facet on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray, m.
    pub t: f64,
    /// Index of the facet.
    pub facet: usize,
    /// First parameter of the point on the facet's plate.
    pub u: f64,
    /// Second parameter of the point on the facet's plate.
    pub v: f64,
    /// True when the ray meets the front of the facet.
    pub front: bool,
}

impl Hit {
    /// Number of the side that the ray meets ([`FacetSide::of_facet`]).
    pub fn side(&self) -> usize {
        FacetSide::front_if(self.front).of_facet(self.facet)
    }
}

/// Intersection of a segment with a pane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaneHit {
    /// Distance from the segment's start, m.
    pub t: f64,
    /// Index of the pane.
    pub pane: usize,
    /// Index of the plate within the pane.
    pub plate: usize,
    /// |cosθ| between segment and normal, above 0.
    pub cos: f64,
}

/// The part of a volume zone in a sub-cell.
struct ZonePiece {
    /// Index into `zones.voxels`.
    zone: usize,
    /// Its volume, m³.
    volume: f64,
    /// The sample point of the part, m.
    sample: Vec3,
}

impl ZonePiece {
    /// True if this part has more volume; of equal ones, the one of the zone with the lower index.
    fn precedes(&self, other: &ZonePiece) -> bool {
        other.volume < self.volume || other.volume == self.volume && self.zone < other.zone
    }
}

/// A scene prepared for ray queries.
///
/// ```
/// use zonal_math::{Vec3, vec3};
/// use zonal_scene::{Bands, Scene, SceneParts, VoxelGrid};
/// use zonal_transport::Transport;
///
/// // A uniform medium of extinction 0.5 m⁻¹ in a cube of 2 m.
/// let mut grid = VoxelGrid::new(Vec3::ZERO, Vec3::ONE, [2, 2, 2]).unwrap();
/// (0..8).for_each(|cell| grid.set(cell, Bands::splat(0.5), Bands::ZERO, Bands::ZERO, Bands::ZERO));
/// let parts = SceneParts { voxel_grid: Some(grid.seal().unwrap()), ..SceneParts::default() };
/// let scene = Scene::new(parts).unwrap();
/// let transport = Transport::new(&scene);
///
/// let (a, b) = (vec3(0.0, 1.0, 1.0), vec3(2.0, 1.0, 1.0));
/// assert!(!transport.occluded(a, b));
/// assert!((transport.optical_depth(a, b).first() - 1.0).abs() < 1e-12);
/// assert!((transport.transmittance(a, b).unwrap().first() - (-1.0f64).exp()).abs() < 1e-12);
/// ```
#[derive(Clone, Debug)]
pub struct Transport<'a> {
    scene: &'a Scene,
    geometry: Arc<PreparedGeometry>,
    uniform_blocks: Option<UniformBlocks>,
}

/// What all bands of a scene share.
#[derive(Debug)]
struct PreparedGeometry {
    tolerance: Tolerance,
    facets: Bvh,
    /// The facets that can occlude between points of the scene; `None` when these are all facets.
    interior_facets: Option<Bvh>,
    solids: Solids,
    panes: Bvh,
    /// The pane plates that can lie between points of the scene; `None` when these are all pane plates.
    interior_panes: Option<Bvh>,
    /// Pane, and index within the pane, of every pane plate.
    pane_plates: Vec<(u32, u32)>,
}

impl<'a> Transport<'a> {
    /// Builds the hierarchies over facets, panes and solids.
    pub fn new(scene: &'a Scene) -> Transport<'a> {
        let tolerance = Tolerance::of(scene);
        let (lo, hi) = scene.bounds();
        let facet_plates: Vec<(u32, Plate)> =
            (0u32..).zip(scene.facets()).map(|(k, f)| (k, f.plate)).collect();
        let facets = Bvh::new(&facet_plates, lo, hi);
        let pane_plates: Vec<(u32, u32)> = (0u32..)
            .zip(scene.panes())
            .flat_map(|(p, pane)| (0..pane.plates.len() as u32).map(move |k| (p, k)))
            .collect();
        let plates = scene.panes().iter().flat_map(|p| &p.plates);
        let panes: Vec<(u32, Plate)> = (0u32..).zip(plates.copied()).collect();

        let interior = |list: &[(u32, Plate)]| {
            let plates: Vec<Plate> = list.iter().map(|x| x.1).collect();
            let divides = occluder_culling::planes_dividing_scene(scene, &plates, &facets, &tolerance);
            let kept: Vec<(u32, Plate)> = list.iter().zip(divides).filter(|x| x.1).map(|x| *x.0).collect();
            (kept.len() < list.len()).then(|| Bvh::new(&kept, lo, hi))
        };
        let interior_facets = interior(&facet_plates);
        let interior_panes = interior(&panes);
        let geometry = PreparedGeometry {
            tolerance,
            solids: Solids::new(scene, &tolerance),
            panes: Bvh::new(&panes, lo, hi),
            interior_facets,
            interior_panes,
            facets,
            pane_plates,
        };
        Transport::of_bands(scene, Arc::new(geometry))
    }

    /// The same geometry with the extinction of other bands: `scene` is another block of bands of the same scene. Takes the time of one pass over the
    /// cells of a medium.
    #[must_use]
    pub fn with_bands<'b>(&self, scene: &'b Scene) -> Transport<'b> {
        Transport::of_bands(scene, self.geometry.clone())
    }

    fn of_bands(scene: &Scene, geometry: Arc<PreparedGeometry>) -> Transport<'_> {
        Transport { scene, geometry, uniform_blocks: scene.voxel_grid().and_then(UniformBlocks::new) }
    }

    /// The scene.
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }
    /// The length below which points coincide, m: 10⁻⁹ of the scene's diagonal.
    pub fn epsilon(&self) -> f64 {
        self.geometry.tolerance.plane
    }
    /// A point on the ray `origin + t dir` well outside the scene: the far end of a segment towards the sun or the sky.
    pub fn exterior_point(&self, origin: Vec3, dir: Vec3) -> Vec3 {
        let (lo, hi) = self.scene.bounds();
        let away = ((lo + hi) * 0.5 - origin).length();
        origin + dir * (away + 2.0 * self.scene.diagonal())
    }

    /// True when a facet crosses the open segment a–b. A facet that holds an end of the segment, or whose plane holds the segment,
    /// does not occlude.
    #[inline]
    pub fn occluded(&self, a: Vec3, b: Vec3) -> bool {
        self.geometry.facets.any(a, b, &self.geometry.tolerance)
    }
    /// [`Transport::occluded`] for two points of the scene itself (on its surfaces, or in its voxel grid): tests only the facets that
    /// can lie between such points.
    #[inline]
    pub fn occluded_inside(&self, a: Vec3, b: Vec3) -> bool {
        self.interior_facets().any(a, b, &self.geometry.tolerance)
    }
    /// True when a facet or an absorbing pane stands between two points of the scene itself.
    pub fn separated_inside(&self, a: Vec3, b: Vec3) -> bool {
        self.occluded_inside(a, b) || self.has_interior_panes() && self.pane_depth_inside(a, b) != Bands::ZERO
    }
    /// False when no facet can stand between any point of one zone and any of the other, both zones of the scene: then
    /// [`Transport::occluded_inside`] is false for all pairs of points. True when this is not proved.
    pub fn may_occlude(&self, ends: [ShaftEnd; 2]) -> bool {
        self.interior_facets().any_in(&Shaft::new(ends), &self.geometry.tolerance)
    }
    /// False when no pane can stand between any point of one zone and any of the other; true when this is not proved.
    pub fn pane_may_intersect(&self, ends: [ShaftEnd; 2]) -> bool {
        self.interior_panes().any_in(&Shaft::new(ends), &self.geometry.tolerance)
    }
    /// True when no segment between two zones of the scene meets the interior of a box, given by its lower and upper corner; false when this is
    /// not proved.
    pub fn shaft_avoids_box(&self, ends: [ShaftEnd; 2], corners: [Vec3; 2]) -> bool {
        Shaft::new(ends).avoids_box(corners, &self.geometry.tolerance)
    }
    /// True when some facet can lie between two points of the scene.
    pub fn has_occluders(&self) -> bool {
        self.occluder_count() > 0
    }
    /// Number of facets that can lie between two points of the scene.
    pub fn occluder_count(&self) -> usize {
        self.interior_facets().len()
    }
    /// True when some pane can lie between two points of the scene.
    pub fn has_interior_panes(&self) -> bool {
        self.interior_panes().len() > 0
    }

    /// The first facet on the ray with t_min < t < t_max (m, may be infinite); `dir` has unit length. Facets whose plane holds the
    /// ray or its origin are ignored. Of facets met at the same t the one of the smallest index is taken.
    pub fn closest_hit(&self, origin: Vec3, dir: Vec3, t_min: f64, t_max: f64) -> Option<Hit> {
        let (id, [t, u, v], front) =
            self.geometry.facets.nearest(origin, dir, t_min, t_max, &self.geometry.tolerance)?;
        let facet = id as usize;
        Some(Hit { t, facet, u, v, front })
    }

    /// Calls `each` with every facet that the segment a–b crosses, in no order. A facet that holds an end is not crossed.
    pub fn facet_crossings(&self, a: Vec3, b: Vec3, each: &mut dyn FnMut(Hit)) {
        let length = (b - a).length();
        self.geometry.facets.all(a, b, &self.geometry.tolerance, &mut |id, [t, u, v], along| {
            each(Hit { t: t * length, facet: id as usize, u, v, front: along < 0.0 });
        });
    }

    /// Calls `each` with (cell, t0, t1) for every cell of the voxel grid on the segment a–b in order, t in metres from a.
    #[inline]
    pub fn traverse_grid(&self, a: Vec3, b: Vec3, each: &mut impl FnMut(usize, f64, f64)) {
        if let Some(grid) = self.scene.voxel_grid() {
            grid_traversal::traverse(grid, a, b, each);
        }
    }

    /// The volume zone, an index into `zones.voxels`, that holds point `p` of a cell. Where walls divide the cell: of the zones whose sample in the
    /// sub-cell of `p` sees it, the one with the most volume there; without any, the zone of the nearest sample that sees it; without any, of the nearest sample.
    ///
    /// Behind the edge of a wall two zones of a sub-cell may see `p`. One may be a thin layer between the wall and the face of the cell; it ends at the edge.
    pub fn volume_zone_at(&self, zones: &Zones, cell: usize, p: Vec3) -> Option<usize> {
        let range = zones.voxel_zones_of_cell(cell);
        if range.len() <= 1 {
            return range.into_iter().next();
        }
        self.visible_volume_zone(zones, cell, p)
            .or_else(|| self.nearest_samples(zones, cell, p).first().map(|n| n.1))
    }

    /// As [`Transport::volume_zone_at`]; `None` where no sample tried sees `p`.
    pub fn visible_volume_zone(&self, zones: &Zones, cell: usize, p: Vec3) -> Option<usize> {
        self.volume_zone_in_subcell(zones, cell, p).or_else(|| {
            let candidates = self.nearest_samples(zones, cell, p);
            candidates.iter().find(|n| !self.occluded(p, n.2)).map(|n| n.1)
        })
    }

    /// The zone with the most volume in the sub-cell of `p` among those whose sample there sees `p`; the first of equal ones.
    fn volume_zone_in_subcell(&self, zones: &Zones, cell: usize, p: Vec3) -> Option<usize> {
        let mut hidden: Option<ZonePiece> = None;
        loop {
            let parts = self.parts_of_subcell(zones, cell, p)?;
            let rest = parts.filter(|part| hidden.as_ref().is_none_or(|h| h.precedes(part)));
            let next = rest.reduce(|a, b| if b.precedes(&a) { b } else { a })?;
            if !self.occluded_inside(p, next.sample) {
                return Some(next.zone);
            }
            hidden = Some(next);
        }
    }

    /// True if [`Transport::volume_zone_at`] is `zone`, an index into `zones.voxels`, at a point `p` that sees the sample `seen` of the zone in the sub-cell of `p`.
    pub fn volume_zone_holds(&self, zones: &Zones, zone: usize, seen: Vec3, p: Vec3) -> bool {
        let cell = zones.voxels.at(zone).cell;
        if zones.voxel_zones_of_cell(cell).len() <= 1 {
            return true;
        }
        let parts = || self.parts_of_subcell(zones, cell, p).into_iter().flatten();
        match parts().find(|part| part.zone == zone && part.sample == seen) {
            Some(own) => !parts().any(|part| part.precedes(&own) && !self.occluded_inside(p, part.sample)),
            None => self.volume_zone_at(zones, cell, p) == Some(zone),
        }
    }

    /// The parts of the zones of a cell in the sub-cell of `p`, in the order of the zones.
    fn parts_of_subcell<'z>(
        &self,
        zones: &'z Zones,
        cell: usize,
        p: Vec3,
    ) -> Option<impl Iterator<Item = ZonePiece> + 'z> {
        let grid = self.scene.voxel_grid()?;
        let subcell = subcell_at(grid.corner(grid.coordinates(cell)), grid.cell(), p);
        let part = move |zone: usize| {
            let sample = zones.voxels.at(zone).samples.sample_in(subcell)?;
            Some(ZonePiece { zone, volume: sample.volume, sample: sample.point })
        };
        Some(zones.voxel_zones_of_cell(cell).filter_map(part))
    }

    /// Squared distance, zone and position of the sample of each zone of a cell that is nearest to `p`, the nearest first.
    fn nearest_samples(&self, zones: &Zones, cell: usize, p: Vec3) -> Vec<(f64, usize, Vec3)> {
        let range = zones.voxel_zones_of_cell(cell);
        let nearest_sample = |z: usize| {
            let samples = zones.voxels.at(z).samples.iter().map(|s| ((s.point - p).length2(), z, s.point));
            samples.min_by(|a, b| a.0.total_cmp(&b.0))
        };
        let mut candidates: Vec<(f64, usize, Vec3)> = range.filter_map(nearest_sample).collect();
        candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
        candidates
    }

    /// True when `p` lies in the material of a closed solid.
    pub fn inside_solid(&self, p: Vec3) -> bool {
        self.geometry.solids.contains(p)
    }
    /// True when some part of the voxel grid may have no medium.
    pub fn may_lack_medium(&self) -> bool {
        self.has_solids() || self.exterior_medium_is_inert()
    }
    /// True when the medium at `p` exchanges: `p` lies in no solid, nor outside the closed rooms where the exterior medium is inert.
    pub fn has_medium_at(&self, p: Vec3) -> bool {
        !(self.inside_solid(p) || self.exterior_medium_is_inert() && self.is_outside_rooms(p))
    }

    /// True when some surface bounds closed solids.
    pub(crate) fn has_solids(&self) -> bool {
        self.geometry.solids.has_material()
    }
    /// The facet through which a ray leaves the solid that holds `p`, an index; `None` where no solid holds `p`.
    pub(crate) fn enclosing_solid_facet(&self, p: Vec3) -> Option<usize> {
        self.geometry.solids.enclosing_facet(p)
    }
    /// True where the medium outside the closed rooms touches nothing else, so that it has no zones.
    pub(crate) fn exterior_medium_is_inert(&self) -> bool {
        self.geometry.solids.exterior_is_inert()
    }
    /// True when `p` lies outside every closed room.
    pub(crate) fn is_outside_rooms(&self, p: Vec3) -> bool {
        self.geometry.solids.is_outside_rooms(p)
    }
    /// Indices of the facets whose boxes overlap [lo, hi], ascending.
    pub(crate) fn facets_overlapping(&self, lo: Vec3, hi: Vec3) -> Vec<u32> {
        let mut ids = Vec::new();
        self.geometry.facets.overlapping(lo, hi, |id| ids.push(id));
        ids.sort_unstable();
        ids
    }
    /// Pane, and index within the pane, of the pane plates whose boxes overlap [lo, hi], ascending.
    pub(crate) fn pane_plates_overlapping(&self, lo: Vec3, hi: Vec3) -> Vec<(u32, u32)> {
        let mut found = Vec::new();
        self.geometry.panes.overlapping(lo, hi, |id| found.push(self.geometry.pane_plates[id as usize]));
        found.sort_unstable();
        found
    }
    /// The lengths below which points coincide.
    pub(crate) fn tolerance(&self) -> &Tolerance {
        &self.geometry.tolerance
    }
    /// Blocks of cells of equal extinction, if they pay.
    pub(crate) fn uniform_blocks(&self) -> Option<&UniformBlocks> {
        self.uniform_blocks.as_ref()
    }
    /// The tree over all pane plates.
    pub(crate) fn panes(&self) -> &Bvh {
        &self.geometry.panes
    }
    /// The tree over the pane plates that can lie between points of the scene.
    pub(crate) fn interior_panes(&self) -> &Bvh {
        self.geometry.interior_panes.as_ref().unwrap_or(&self.geometry.panes)
    }
    /// Pane, and index within the pane, of pane plate number `id`.
    pub(crate) fn pane_plate(&self, id: u32) -> (u32, u32) {
        self.geometry.pane_plates[id as usize]
    }
    /// The tree over the facets that can occlude between points of the scene.
    fn interior_facets(&self) -> &Bvh {
        self.geometry.interior_facets.as_ref().unwrap_or(&self.geometry.facets)
    }
}
