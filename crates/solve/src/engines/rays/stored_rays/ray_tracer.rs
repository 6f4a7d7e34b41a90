//! Traces single rays and batches of rays from the zones.
//!
//! Whatever attenuates a ray, medium or pane, also stops it: at the point where the mean transmittance of the bands falls below a
//! uniform random number u. The weight of the ray in each band, with l the transmittance of that band there, has the mean one over
//! all u (Modest, collision-based Monte Carlo with one path for all bands):
//!
//! ```text
//! in the medium κ l/⟨κ l⟩      in a pane (l⁻ − l⁺)/⟨l⁻ − l⁺⟩      on a facet l/⟨l⟩      ⟨⟩ the mean of the bands
//! ```
//!
//! A ray from a pane starts with the fraction that the pane's own medium lets out; the rest is the self-exchange of the pane.
//!
//! **Cost.** One traversal of the bounding volume hierarchy a ray, and a second optical depth where a varying medium stops it. A batch
//! traverses for [`RAYS_PER_BATCH`] rays first and then reads the patches hit for all of them, so that the cache misses overlap. (Sorting the
//! rays by direction was measured: the sort cost more than the coherent traversal saved.)

use crate::right_hand_side::surroundings::zone_rays::{WeightedRay, zone_ray};
use zonal_math::{Vec3, low_discrepancy};
use zonal_scene::{Band, Bands, PerBand, Scene, VoxelGrid, Zones};
use zonal_transport::patch_locator::{PatchLocator, facet_side_locator, pane_piece_locator};
use zonal_transport::{Hit, PaneHit, Transport};

/// End of a ray that leaves the scene, in place of a zone.
pub(crate) const ESCAPED: u32 = u32::MAX;
/// End of a ray on the black back of a facet.
pub(crate) const BACK_FACE: u32 = u32::MAX - 1;
/// End of a ray at a point without a zone.
pub(crate) const NO_ZONE: u32 = u32::MAX - 2;
/// The smallest of the codes that are no zone.
pub(crate) const FIRST_CODE: u32 = NO_ZONE;
/// Seed that separates the random numbers of these rays from those of others.
pub(crate) const RAY_SEED: u64 = 0x5bd1_e995_0000_0000;
/// Bisection steps that locate the point at which a medium stops a ray within a piece of one extinction.
const BISECTION_STEPS: usize = 20;
/// Rays of a batch that are traversed before their patches are looked up.
const RAYS_PER_BATCH: usize = 64;
/// Length of a ray that meets nothing, in diagonals of the scene.
const MAX_LENGTH_IN_DIAGONALS: f64 = 3.0;
/// Distance from its origin at which a ray may meet a facet first, in diagonals of the scene.
const OFFSET_IN_DIAGONALS: f64 = 1e-9;

/// Which ray of which zone.
#[derive(Clone, Copy)]
pub(crate) struct RayNumber {
    /// The zone.
    pub zone: usize,
    /// The number of the ray among the rays of the zone.
    pub number: usize,
}

/// End point of a ray.
pub(crate) struct RayEnd {
    /// The zone, or a code of at least [`FIRST_CODE`].
    pub zone: u32,
    /// Weight of the ray in each band.
    pub weight: PerBand<f32>,
    /// Length of the ray, m.
    pub distance: f64,
    /// Position, m.
    pub position: Vec3,
}

/// Transmittance of a ray up to a distance.
struct PathTransmittance {
    /// m.
    distance: f64,
    /// Transmittance of the panes crossed.
    panes: Bands,
    /// Transmittance of panes and medium.
    total: Bands,
}

/// A straight ray.
#[derive(Clone, Copy)]
struct Segment {
    origin: Vec3,
    dir: Vec3,
}

impl Segment {
    fn at(&self, t: f64) -> Vec3 {
        self.origin + self.dir * t
    }
}

/// Traces rays from zones.
pub(crate) struct RayTracer<'a> {
    scene: &'a Scene,
    /// Zones.
    pub zones: &'a Zones,
    /// Facets, panes and medium.
    pub transport: &'a Transport<'a>,
    /// Patches by the two sides of every facet.
    patches: PatchLocator,
    /// Pane zones by the plates of all panes.
    pane_pieces: PatchLocator,
    /// Number of each pane's first plate in `pane_pieces`.
    first_plate: Vec<usize>,
    max_length: f64,
    offset: f64,
    /// True where every ray has weight 1 in every band.
    pub grey: bool,
    /// True if the medium has one extinction for all bands in every cell.
    pub grey_medium: bool,
    uniform_extinction: Option<Bands>,
    /// Surfaces whose reflectance has a texture.
    textured: Vec<bool>,
}

/// The side of the facet hit, and the position on it.
fn side_and_position(hit: &Hit) -> (usize, [f64; 2]) {
    (hit.side(), [hit.u, hit.v])
}

/// True where the medium has one extinction for all bands in every cell.
fn is_grey(grid: &VoxelGrid) -> bool {
    match grid.uniform_extinction() {
        Some(k) => k.is_grey(),
        None => (0..grid.len()).all(|i| grid.extinction(i).is_grey()),
    }
}

impl<'a> RayTracer<'a> {
    /// Prepares the lookup of patches and pane zones.
    pub(crate) fn new(scene: &'a Scene, zones: &'a Zones, transport: &'a Transport<'a>) -> RayTracer<'a> {
        let (first_plate, pane_pieces) = pane_piece_locator(scene, zones);
        let grid = scene.voxel_grid();
        let grey_medium = grid.is_none_or(is_grey);
        RayTracer {
            scene,
            zones,
            transport,
            pane_pieces,
            first_plate,
            patches: facet_side_locator(scene, zones),
            max_length: MAX_LENGTH_IN_DIAGONALS * scene.diagonal(),
            offset: OFFSET_IN_DIAGONALS * scene.diagonal(),
            grey: grey_medium && scene.panes().is_empty(),
            grey_medium,
            uniform_extinction: grid.and_then(|m| m.uniform_extinction()),
            textured: scene.surfaces().iter().map(|s| s.reflectance_texture.is_some()).collect(),
        }
    }

    fn ray_of_zone(&self, ray: RayNumber) -> (Segment, Bands) {
        let WeightedRay { origin, dir, weight } =
            zone_ray(self.zones, self.transport, ray.zone, RAY_SEED, ray.number);
        (Segment { origin, dir }, weight)
    }

    /// Traces one ray. Medium or pane stops it where the mean transmittance falls below `u`.
    pub(crate) fn trace(&self, origin: Vec3, dir: Vec3, u: f64) -> RayEnd {
        let ray = Segment { origin, dir };
        self.end(ray, self.closest_hit(ray), u)
    }

    fn closest_hit(&self, ray: Segment) -> Option<Hit> {
        self.transport.closest_hit(ray.origin, ray.dir, self.offset, self.max_length)
    }

    /// The end of a ray whose closest facet is `hit`.
    fn end(&self, ray: Segment, hit: Option<Hit>, u: f64) -> RayEnd {
        let t = hit.map_or(self.max_length, |h| h.t);
        let mut panes = Bands::ONE;
        let mut stopped = None;
        self.transport.pane_crossings(ray.origin, ray.at(t), &mut |p| {
            if stopped.is_none() {
                stopped = self.cross_pane(ray, &p, &mut panes, u);
            }
        });
        stopped.unwrap_or_else(|| {
            let path = self.transmittance(ray, t, panes);
            if u >= path.total.mean() {
                return self.end_in_medium(ray, &path, u);
            }
            self.weighted_end(self.zone_of_hit(hit), ray, t, path.total)
        })
    }

    /// The patch that a facet is met in, or a code.
    fn zone_of_hit(&self, hit: Option<Hit>) -> u32 {
        hit.map_or(ESCAPED, |hit| {
            let (side, uv) = side_and_position(&hit);
            self.patches.locate(side, uv).unwrap_or(BACK_FACE)
        })
    }

    /// Ratio of the reflectance of the texture at a point of zone `i` to that of the zone; 1 without a texture, and where the radiosity is not that of a
    /// reflectance alone.
    pub(crate) fn texture_ratio(&self, i: usize, at: Vec3) -> Bands {
        let Some(p) = self.zones.patches.get(i).filter(|p| self.textured[p.surface]) else {
            return Bands::ONE;
        };
        if p.emission != Bands::ZERO || self.zones.sheets.opposite(i).is_some() {
            return Bands::ONE;
        }
        let [u, v] = self.scene.facets()[p.facet].plate.parameters(at);
        let here = self.scene.reflectance_at(p.facet, u, v);
        here.zip_map(p.reflectance, |here, mean| if mean > 0.0 { here / mean } else { 1.0 })
    }

    /// True where the reflectance of some surface has a texture.
    pub(crate) fn has_textures(&self) -> bool {
        self.textured.contains(&true)
    }

    /// The first facet on a ray, whatever the medium and the panes; the weight is 1.
    pub(crate) fn first_surface(&self, origin: Vec3, dir: Vec3) -> RayEnd {
        let ray = Segment { origin, dir };
        let hit = self.closest_hit(ray);
        let distance = hit.map_or(self.max_length, |h| h.t);
        let weight = PerBand::splat(1.0);
        RayEnd { zone: self.zone_of_hit(hit), weight, distance, position: ray.at(distance) }
    }

    /// The pane zone at a point of a pane.
    pub(crate) fn pane_zone(&self, hit: &PaneHit, point: Vec3) -> Option<usize> {
        let uv = self.scene.panes()[hit.pane].plates[hit.plate].parameters(point);
        let piece = self.pane_pieces.locate(self.first_plate[hit.pane] + hit.plate, uv)?;
        Some(self.zones.pane_index(piece as usize))
    }

    /// Transmittance up to the distance `t`, behind panes of transmittance `panes`.
    fn transmittance(&self, ray: Segment, t: f64, panes: Bands) -> PathTransmittance {
        let depth = self.transport.medium_depth(ray.origin, ray.at(t));
        PathTransmittance { distance: t, panes, total: panes * (-depth).exp() }
    }

    /// A ray end whose weight is `light` over its mean.
    fn weighted_end(&self, zone: u32, ray: Segment, distance: f64, light: Bands) -> RayEnd {
        let whole = light.mean();
        let one = |l: f64| if whole > 0.0 { (l / whole) as f32 } else { 1.0 };
        let weight = if self.grey { PerBand::splat(1.0) } else { light.map(one) };
        RayEnd { zone, weight, distance, position: ray.at(distance) }
    }

    /// The end of the ray before a pane or in it, if there is one; otherwise multiplies `panes` by the transmittance of the pane.
    fn cross_pane(&self, ray: Segment, hit: &PaneHit, panes: &mut Bands, u: f64) -> Option<RayEnd> {
        let before = self.transmittance(ray, hit.t, *panes);
        if u >= before.total.mean() {
            return Some(self.end_in_medium(ray, &before, u));
        }
        let pass = (-self.transport.slant_depth(hit)).exp();
        let after = before.total * pass;
        if u >= after.mean() {
            let zone = self.pane_zone(hit, ray.at(hit.t)).map_or(NO_ZONE, |z| z as u32);
            let absorbed = before.total - after;
            return Some(self.weighted_end(zone, ray, hit.t, absorbed));
        }
        *panes *= pass;
        None
    }

    /// Fraction of the emission of pane zone `i` that the zone itself absorbs, by the weights of its first `rays` rays.
    pub(crate) fn self_exchange(&self, i: usize, rays: usize) -> Bands {
        let sum = (0..rays).map(|k| self.ray_of_zone(RayNumber { zone: i, number: k }).1);
        1.0 - sum.sum::<Bands>() / rays as f64
    }

    /// The random number by which medium or pane stops a ray. It belongs to the sequence of the directions: a number
    /// of the sequence of the origins would be correlated with these over thousands of rays.
    fn stopping_number(ray: RayNumber) -> f64 {
        let seed = low_discrepancy::split_mix64((ray.zone as u64 * 8 + 7) ^ RAY_SEED) as u32;
        low_discrepancy::sobol_third_dimension(ray.number as u32, seed)
    }

    /// Traces `rays` rays in order. `source` returns which ray stands at a place of the batch; `ended` receives the place and the end of
    /// the ray.
    pub(crate) fn trace_batch(
        &self,
        rays: usize,
        source: impl Fn(usize) -> RayNumber,
        mut ended: impl FnMut(usize, RayEnd),
    ) {
        let mut hits = Vec::with_capacity(RAYS_PER_BATCH);
        let mut places = Vec::with_capacity(RAYS_PER_BATCH);
        for start in (0..rays).step_by(RAYS_PER_BATCH) {
            let batch = start..(start + RAYS_PER_BATCH).min(rays);
            hits.clear();
            hits.extend(batch.clone().map(|r| {
                let (ray, weight) = self.ray_of_zone(source(r));
                (ray, weight, self.closest_hit(ray))
            }));
            self.patches
                .prefetch(hits.iter().filter_map(|m| m.2.as_ref()).map(side_and_position), &mut places);
            for (r, &(ray, weight, hit)) in batch.zip(&hits) {
                let mut end = self.end(ray, hit, RayTracer::stopping_number(source(r)));
                Band::all().for_each(|b| end.weight[b] *= weight[b] as f32);
                ended(r, end);
            }
        }
    }

    /// The distance at which the mean transmittance of a ray falls to `u`, within the distance of `path`: by bisection in the piece of one extinction that
    /// holds it.
    fn distance_in_medium(&self, ray: Segment, path: &PathTransmittance, u: f64) -> f64 {
        let (mut depth, mut found) = (Bands::ZERO, None);
        let light = |depth: Bands| (path.panes * (-depth).exp()).mean();
        self.transport.traverse_extinction(ray.origin, ray.at(path.distance), &mut |extinction, t0, t1| {
            if found.is_some() {
                return;
            }
            let after = depth + extinction * (t1 - t0);
            if light(after) <= u {
                let (mut lo, mut hi) = (0.0, t1 - t0);
                for _ in 0..BISECTION_STEPS {
                    let middle = 0.5 * (lo + hi);
                    if light(depth + extinction * middle) > u { lo = middle } else { hi = middle }
                }
                found = Some(t0 + 0.5 * (lo + hi));
            }
            depth = after;
        });
        found.unwrap_or(path.distance)
    }

    /// The end of a ray that the medium stops within the distance of `path`.
    fn end_in_medium(&self, ray: Segment, path: &PathTransmittance, u: f64) -> RayEnd {
        let PathTransmittance { distance: t, panes, .. } = *path;
        let no_zone = RayEnd { zone: NO_ZONE, weight: PerBand::splat(1.0), distance: t, position: ray.at(t) };
        let Some(grid) = self.scene.voxel_grid() else { return no_zone };
        let s = match self.uniform_extinction {
            Some(k) if self.grey && grid.cell_at(ray.origin).is_some() => -u.max(1e-300).ln() / k.first(),
            _ => self.distance_in_medium(ray, path, u),
        };
        let position = ray.at(s.min(t));
        let Some(cell) = grid.cell_at(position).map(|c| grid.index(c)) else { return no_zone };
        let zone = self.transport.volume_zone_at(self.zones, cell, position);
        let zone = zone.map_or(NO_ZONE, |z| self.zones.voxel_index(z) as u32);
        let light = if self.grey {
            Bands::ONE
        } else {
            let (k, l) = (grid.extinction(cell), self.transmittance(ray, s, panes).total);
            k * l
        };
        self.weighted_end(zone, ray, s.min(t), light)
    }
}
