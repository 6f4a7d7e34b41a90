//! The radiation of medium and panes along a ray, by expected values.
//!
//! A ray that ends after the distance T meets the radiosity B(t) with the density of its absorption; with l the transmittance from its origin
//!
//! ```text
//! ∫ B (−dl) = Σ_k (l_k − l_{k+1}) B_k        over the pieces k of the way in volume zones and panes, then l(T) B of the surface at its end
//! ```
//!
//! No random number decides where the medium stops the ray, so the medium adds no variance of its own, in any band.
//!
//! A stretch of the ray that crosses many cells of one extinction meets six of them instead: points of equal absorption, one in each sixth of it, so that
//! the mean is the same.
//!
//! **Cost.** One step of the grid traversal a cell and one exponential, or one for each band; or six points a stretch.

use crate::engines::rays::stored_rays::padded_bands::{LANES, PaddedBands};
use crate::engines::rays::stored_rays::ray_tracer::RayTracer;
use crate::right_hand_side::surroundings::zone_rays::WeightedRay;
use std::ops::Range;
use zonal_math::Vec3;
use zonal_math::parallel;
use zonal_scene::voxel_samples::subcell_at;
use zonal_scene::{Band, Bands, SUBCELLS, VoxelGrid, Zones};
use zonal_transport::zoning::{crossed_cells, crossed_subcells};
use zonal_transport::{PaneHit, Transport};

/// Samples of a cell that a point tries to see.
const SAMPLES_TRIED: usize = 8;
/// Optical depth below which the absorbed fraction is a sum of five terms; the next is below 10⁻¹⁰ of it.
const SERIES_DEPTH: f64 = 0.04;
/// Cells on a stretch of one extinction above which it is sampled at [`POINTS_ON_STRETCH`] points.
const MIN_CELLS_FOR_POINTS: f64 = 12.0;
/// Points on a stretch of one extinction.
const POINTS_ON_STRETCH: usize = 6;
/// Absorbed share of a ray below which the zone that absorbs it does not matter.
const NEGLIGIBLE_SHARE: f64 = 1e-8;

/// A zone on a path and the weight of its radiosity in every band.
#[derive(Clone, Copy)]
pub(crate) struct WeightedZone {
    /// Number of the zone.
    pub zone: u32,
    /// Weight.
    pub weight: PaddedBands,
}

/// A part of a ray in a medium of one extinction.
pub(crate) struct MediumPiece {
    /// The extinction, 1/m.
    extinction: Bands,
    /// Distances of its ends from the origin of the ray, m.
    ends: Range<f64>,
    /// Weight of the ray at its beginning.
    weight: Bands,
    /// Its zones among those that the ray collects.
    pub zones: Range<usize>,
}

impl MediumPiece {
    /// The distances of its ends from the origin of the ray, m.
    pub(crate) fn ends(&self) -> Range<f64> {
        self.ends.clone()
    }

    /// The distance from the origin, m, before which the share `u` of what the piece absorbs is absorbed, by the mean of the bands.
    pub(crate) fn distance(&self, u: f64) -> f64 {
        let (k, length) = (self.extinction.mean(), self.ends.end - self.ends.start);
        let depth = -(-u * absorbed_fraction(k * length)).ln_1p();
        self.ends.start + (depth / k).min(length)
    }

    /// Density of that distance at `s`, 1/m.
    pub(crate) fn density(&self, s: f64) -> f64 {
        let (k, length) = (self.extinction.mean(), self.ends.end - self.ends.start);
        k * (-k * (s - self.ends.start)).exp() / absorbed_fraction(k * length)
    }

    /// Weight of a radiosity for each metre of the ray at the distance `s`, 1/m.
    pub(crate) fn weight_at(&self, s: f64) -> Bands {
        self.weight * self.extinction * (-self.extinction * (s - self.ends.start)).exp()
    }
}

/// The zones that a ray meets, with their weights.
#[derive(Default)]
pub(crate) struct CollectedZones {
    /// The zones with their weights.
    pub zones: Vec<WeightedZone>,
    /// The parts of the ray in the medium, in order; kept on demand.
    pub pieces: Vec<MediumPiece>,
}

impl CollectedZones {
    /// Removes everything.
    pub(crate) fn clear(&mut self) {
        self.zones.clear();
        self.pieces.clear();
    }
}

/// Whether the parts of rays in the medium are kept.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pieces {
    /// They are not.
    Dropped,
    /// They are.
    Kept,
}

/// The volume zones of the cells, and of the sub-cells of cells that walls divide.
pub(crate) struct CellZones<'a> {
    transport: &'a Transport<'a>,
    zones: &'a Zones,
    grid: &'a VoxelGrid,
    /// Entry of every cell: a volume zone, with the bit [`WALLED`] where facets cross its cell; [`WITHOUT_ZONE`]; or [`DIVIDED`] and the number of
    /// a table.
    cells: Vec<u32>,
    /// The zone of each sub-cell of a divided cell, with the bit [`WALLED`] where a facet crosses it or zones share it;
    /// [`WITHOUT_ZONE`] where it has no sample.
    divided: Vec<[u32; SUBCELLS * SUBCELLS * SUBCELLS]>,
}

const WITHOUT_ZONE: u32 = u32::MAX;
const DIVIDED: u32 = 1 << 31;
const WALLED: u32 = 1 << 30;

impl<'a> CellZones<'a> {
    /// The table of a scene with a voxel grid.
    pub(crate) fn new(transport: &'a Transport<'a>, zones: &'a Zones, grid: &'a VoxelGrid) -> CellZones<'a> {
        let mut divided = Vec::new();
        let mut cells: Vec<u32> = (0..grid.len())
            .map(|cell| {
                let range = zones.voxel_zones_of_cell(cell);
                if range.is_empty() {
                    return WITHOUT_ZONE;
                }
                if range.len() == 1 && zones.voxels.at(range.start).samples.is_empty() {
                    return range.start as u32;
                }
                divided.push(cell);
                DIVIDED | (divided.len() - 1) as u32
            })
            .collect();
        let divided = parallel::map(&divided, |cell| divided_cell(transport, zones, grid, *cell));
        for cell in crossed_cells(transport.scene(), grid) {
            if cells[cell] & DIVIDED == 0 {
                cells[cell] |= WALLED;
            }
        }
        CellZones { transport, zones, grid, cells, divided }
    }

    /// The zone, counted from the first patch, that holds `point` of a cell.
    #[inline]
    fn zone_at(&self, cell: usize, point: impl Fn() -> Vec3) -> Option<u32> {
        let entry = self.cells[cell];
        let offset = self.zones.voxel_index(0) as u32;
        if entry & (DIVIDED | WALLED) == 0 {
            return Some(entry + offset);
        }
        if entry == WITHOUT_ZONE {
            return None;
        }
        if entry & DIVIDED == 0 {
            return self.sees_samples(cell, point()).then_some((entry & !WALLED) + offset);
        }
        let p = point();
        let lower = self.grid.corner(self.grid.coordinates(cell));
        let subcell = subcell_at(lower, self.grid.cell(), p) as usize;
        let known = self.divided[(entry & !DIVIDED) as usize][subcell];
        if known & WALLED == 0 {
            return Some(known + offset);
        }
        // Part of the sub-cell may lie behind a wall.
        self.transport.visible_volume_zone(self.zones, cell, p).map(|z| z as u32 + offset)
    }

    /// True if `p` sees the centre of one of the nearest sub-cells of its cell. A wall that leaves all samples of a cell in one zone
    /// may cut off a part in which `p` lies.
    fn sees_samples(&self, cell: usize, p: Vec3) -> bool {
        let lower = self.grid.corner(self.grid.coordinates(cell));
        let step = self.grid.cell() * (1.0 / SUBCELLS as f64);
        // The nearest so far, by ascending distance.
        let mut nearest = [(f64::INFINITY, Vec3::ZERO); SAMPLES_TRIED];
        for k in 0..SUBCELLS * SUBCELLS * SUBCELLS {
            let at = [k / (SUBCELLS * SUBCELLS), k / SUBCELLS % SUBCELLS, k % SUBCELLS];
            let [x, y, z] = at.map(|i| i as f64 + 0.5);
            let mut next = lower + step.scale(Vec3 { x, y, z });
            let mut distance = (next - p).length2();
            for slot in &mut nearest {
                if distance < slot.0 {
                    (distance, next) = std::mem::replace(slot, (distance, next));
                }
            }
        }
        nearest.iter().any(|(_, centre)| !self.transport.occluded(p, *centre))
    }
}

/// The zone of each sub-cell of a cell that walls divide, with the bit [`WALLED`] where a facet crosses it or zones share it; [`WITHOUT_ZONE`]
/// where it has no sample.
fn divided_cell(
    transport: &Transport,
    zones: &Zones,
    grid: &VoxelGrid,
    cell: usize,
) -> [u32; SUBCELLS * SUBCELLS * SUBCELLS] {
    let range = zones.voxel_zones_of_cell(cell);
    let mut table = [WITHOUT_ZONE; SUBCELLS * SUBCELLS * SUBCELLS];
    let masks: Vec<u64> = range.clone().map(|z| zones.voxels.at(z).samples.packed().0).collect();
    for (k, entry) in table.iter_mut().enumerate() {
        let mut holders = range.clone().zip(&masks).filter(|(_, m)| *m >> k & 1 == 1);
        if let Some((z, _)) = holders.next() {
            *entry = z as u32 | if holders.next().is_some() { WALLED } else { 0 };
        }
    }
    let crossed = crossed_subcells(transport, grid, cell);
    (0..table.len()).filter(|k| crossed >> k & 1 == 1).for_each(|k| table[k] |= WALLED);
    table
}

/// 1 − e^{−δ}.
#[inline]
fn absorbed_fraction(depth: f64) -> f64 {
    if depth < SERIES_DEPTH {
        depth * (1.0 - depth / 2.0 * (1.0 - depth / 3.0 * (1.0 - depth / 4.0 * (1.0 - depth / 5.0))))
    } else {
        1.0 - (-depth).exp()
    }
}

/// A part of a ray in one extinction.
#[derive(Clone, Copy)]
struct Stretch {
    /// The extinction, 1/m.
    extinction: Bands,
    /// Distances of its ends from the origin of the ray, m.
    start: f64,
    stop: f64,
}

/// Follows rays through medium and panes.
pub(crate) struct ExpectedPath<'a> {
    tracer: &'a RayTracer<'a>,
    cells: Option<CellZones<'a>>,
    /// True if every cell has one extinction for all bands.
    grey: bool,
    has_panes: bool,
}

/// The state of a walk.
struct Walk<'a, 'b> {
    path: &'b ExpectedPath<'a>,
    origin: Vec3,
    dir: Vec3,
    weight: Bands,
    transmittance: Bands,
    pieces: Pieces,
    out: &'b mut CollectedZones,
}

impl<'a> ExpectedPath<'a> {
    /// Prepares the lookup of volume zones.
    pub(crate) fn new(tracer: &'a RayTracer<'a>) -> ExpectedPath<'a> {
        let scene = tracer.transport.scene();
        let grid = scene.voxel_grid().filter(|g| g.uniform_extinction() != Some(Bands::ZERO));
        let cells = grid.map(|g| CellZones::new(tracer.transport, tracer.zones, g));
        ExpectedPath { tracer, cells, grey: tracer.grey_medium, has_panes: !scene.panes().is_empty() }
    }

    /// The zone that holds a point of the medium.
    pub(crate) fn volume_zone(&self, point: Vec3) -> Option<u32> {
        let cells = self.cells.as_ref()?;
        let cell = cells.grid.index(cells.grid.cell_at(point)?);
        cells.zone_at(cell, || point)
    }

    /// Appends what a ray collects within the distance `end`, and returns its transmittance there. `jitter` ∈ [0, 1) places the points in a medium of one
    /// extinction.
    pub(crate) fn collect(
        &self,
        ray: &WeightedRay,
        end: f64,
        jitter: f64,
        pieces: Pieces,
        out: &mut CollectedZones,
    ) -> Bands {
        let WeightedRay { origin, dir, weight } = *ray;
        let mut walk = Walk { path: self, origin, dir, weight, transmittance: Bands::ONE, pieces, out };
        if self.cells.is_none() && !self.has_panes {
            return Bands::ONE;
        }
        let mut panes: Vec<PaneHit> = Vec::new();
        let target = origin + dir * end;
        if self.has_panes {
            self.tracer.transport.pane_crossings(origin, target, &mut |hit| panes.push(hit));
        }
        let mut panes = panes.iter().peekable();
        if let Some(cells) = &self.cells {
            let mut cross = |walk: &mut Walk, mut stretch: Stretch| {
                while let Some(pane) = panes.next_if(|p| p.t < stretch.stop) {
                    walk.cross_stretch(cells, Stretch { stop: pane.t, ..stretch }, jitter);
                    walk.cross_pane(pane);
                    stretch.start = stretch.start.max(pane.t);
                }
                walk.cross_stretch(cells, stretch, jitter);
            };
            let mut stretch: Option<Stretch> = None;
            self.tracer.transport.traverse_extinction(origin, target, &mut |extinction, start, stop| {
                match &mut stretch {
                    Some(same) if same.extinction == extinction => same.stop = stop,
                    _ => {
                        if let Some(before) = stretch.replace(Stretch { extinction, start, stop }) {
                            cross(&mut walk, before);
                        }
                    }
                }
            });
            if let Some(last) = stretch {
                cross(&mut walk, last);
            }
        }
        panes.for_each(|pane| walk.cross_pane(pane));
        walk.transmittance
    }
}

impl Walk<'_, '_> {
    /// Collects from a stretch: cell by cell, or at a few points where it crosses many cells.
    #[inline]
    fn cross_stretch(&mut self, cells: &CellZones, stretch: Stretch, jitter: f64) {
        let Stretch { extinction, start, stop } = stretch;
        if stop <= start || extinction == Bands::ZERO {
            return;
        }
        let edges = cells.grid.cell();
        let crossed = (0..3).map(|k| self.dir[k].abs() / edges[k]).sum::<f64>() * (stop - start);
        if crossed > MIN_CELLS_FOR_POINTS {
            return self.collect_at_points(stretch, jitter);
        }
        let (from, to) = (self.origin + self.dir * start, self.origin + self.dir * stop);
        self.path.tracer.transport.traverse_grid(from, to, &mut |cell, t0, t1| {
            self.cross_cell(cells, cell, Stretch { extinction, start: start + t0, stop: start + t1 });
        });
    }

    /// Collects from the medium of a cell.
    #[inline]
    fn cross_cell(&mut self, cells: &CellZones, cell: usize, stretch: Stretch) {
        let Stretch { extinction, start, stop } = stretch;
        let length = stop - start;
        let fraction = if self.path.grey {
            Bands::splat(absorbed_fraction(extinction.first() * length))
        } else {
            extinction.map(|k| absorbed_fraction(k * length))
        };
        let before = self.transmittance;
        let absorbed = before * fraction;
        self.transmittance -= absorbed;
        if absorbed.max_element() > NEGLIGIBLE_SHARE {
            let middle = || self.origin + self.dir * (0.5 * (start + stop));
            if let Some(zone) = cells.zone_at(cell, middle) {
                let first = self.out.zones.len();
                self.push(zone, absorbed);
                self.keep_piece(stretch, before, first);
            }
        }
    }

    /// Collects from a stretch at a few points of equal absorption by the mean of the bands.
    fn collect_at_points(&mut self, stretch: Stretch, jitter: f64) {
        let Stretch { extinction, start, stop } = stretch;
        let (mean, length) = (extinction.mean(), stop - start);
        let absorbed = absorbed_fraction(mean * length);
        let first = self.out.zones.len();
        for k in 0..POINTS_ON_STRETCH {
            let u = (k as f64 + jitter) / POINTS_ON_STRETCH as f64;
            let depth = -(-u * absorbed).ln_1p();
            let s = (depth / mean).min(length);
            let share = absorbed / POINTS_ON_STRETCH as f64;
            let weight = if self.path.grey {
                Bands::splat(share)
            } else {
                extinction.map(|k| share * k / mean * (depth - k * s).exp())
            };
            if let Some(zone) = self.path.volume_zone(self.origin + self.dir * (start + s)) {
                self.push(zone, self.transmittance * weight);
            }
        }
        self.keep_piece(stretch, self.transmittance, first);
        self.transmittance *= (-extinction * length).exp();
    }

    /// Keeps a piece that begins with this transmittance, of the zones from number `first` on.
    #[inline]
    fn keep_piece(&mut self, stretch: Stretch, transmittance: Bands, first: usize) {
        let zones = first..self.out.zones.len();
        if self.pieces == Pieces::Kept && !zones.is_empty() {
            let Stretch { extinction, start, stop } = stretch;
            let weight = self.weight * transmittance;
            self.out.pieces.push(MediumPiece { extinction, ends: start..stop, weight, zones });
        }
    }

    /// Collects from a pane.
    fn cross_pane(&mut self, pane: &PaneHit) {
        let depth = self.path.tracer.transport.slant_depth(pane);
        let absorbed = self.transmittance * depth.map(absorbed_fraction);
        self.transmittance -= absorbed;
        if absorbed.max_element() > NEGLIGIBLE_SHARE
            && let Some(zone) = self.path.tracer.pane_zone(pane, self.origin + self.dir * pane.t)
        {
            self.push(zone as u32, absorbed);
        }
    }

    #[inline]
    fn push(&mut self, zone: u32, absorbed: Bands) {
        self.out.zones.push(weighted_zone(zone, self.weight * absorbed));
    }
}

/// A zone with its weight in single precision.
#[inline]
pub(crate) fn weighted_zone(zone: u32, weight: Bands) -> WeightedZone {
    let mut lanes = [0.0; LANES];
    Band::all().zip(&mut lanes).for_each(|(b, lane)| *lane = weight[b] as f32);
    WeightedZone { zone, weight: lanes }
}
