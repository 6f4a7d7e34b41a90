//! The voxel zones of a scene, stored once where they are equal.
//!
//! Where every cell of the grid is one whole zone, the zones have no list: cell, centre and volume of zone i follow from i and the grid. Else
//! each zone has the number of its cell, and a stored centre, volume and samples only if it is no whole cell. Extinction, albedo, emission and
//! source are each stored once if all zones have the same bits, and by zone otherwise: a uniform medium takes no memory for each zone, a varying
//! one 24 bytes for each property that varies.

use crate::bands::Bands;
use crate::medium::cell_values::MediumValues;
use crate::medium::grid_geometry::GridGeometry;
use crate::medium::voxel_grid::VoxelGrid;
use crate::medium::voxel_samples::VoxelSamples;
use std::sync::Arc;
use zonal_math::Vec3;

/// A volume zone: the part of a voxel outside solids, or one of the parts into which walls divide it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoxelZone<'a> {
    /// Index of the cell in the voxel grid.
    pub cell: usize,
    /// Centre of the free volume, a point of free space, m.
    pub centre: Vec3,
    /// Free volume V, m³.
    pub volume: f64,
    /// Sample points of a cut voxel; empty for a whole voxel.
    pub samples: &'a VoxelSamples,
    /// Extinction κ, 1/m.
    pub extinction: Bands,
    /// Scattering albedo Ω.
    pub albedo: Bands,
    /// Blackbody emissive power E, W/m².
    pub emission: Bands,
    /// Volumetric source q, W/m³.
    pub source: Bands,
}

/// Where a voxel zone lies: its cell, centre (m), free volume (m³), and the samples of a cut voxel.
#[derive(Clone, Debug, PartialEq)]
pub struct VoxelPlace {
    /// Index of the cell in the voxel grid.
    pub cell: usize,
    /// Centre of the free volume, a point of free space, m.
    pub centre: Vec3,
    /// Free volume V, m³.
    pub volume: f64,
    /// Sample points of a cut voxel; empty for a whole voxel.
    pub samples: VoxelSamples,
}

impl VoxelPlace {
    /// A whole cell of a grid.
    pub fn whole(grid: &VoxelGrid, cell: usize) -> VoxelPlace {
        let geometry = grid.geometry();
        VoxelPlace {
            cell,
            centre: geometry.centre(geometry.coordinates(cell)),
            volume: geometry.volume(),
            samples: VoxelSamples::default(),
        }
    }
}

/// In [`ZoneList::part_of_zone`], a zone that is a whole cell.
const WHOLE_CELL: u32 = u32::MAX;

static NO_SAMPLES: VoxelSamples = VoxelSamples::none();

/// The zones of a grid of which some cell is cut, divided or without medium.
#[derive(Clone, Debug, Default)]
struct ZoneList {
    /// The cell of each zone, ascending.
    cells: Vec<u32>,
    /// `cell_starts[c]..cell_starts[c+1]` are the zones of cell c.
    cell_starts: Vec<u32>,
    /// The index in `parts` of each zone, or [`WHOLE_CELL`].
    part_of_zone: Vec<u32>,
    /// Centre, volume and samples of the zones that are no whole cells.
    parts: Vec<(Vec3, f64, VoxelSamples)>,
}

impl ZoneList {
    fn new(geometry: &GridGeometry, places: impl IntoIterator<Item = VoxelPlace>) -> ZoneList {
        let mut out = ZoneList::default();
        for place in places {
            let VoxelPlace { cell, centre, volume, samples } = place;
            let of_cell = geometry.centre(geometry.coordinates(cell));
            let is_whole = samples.is_empty()
                && centre.array().map(f64::to_bits) == of_cell.array().map(f64::to_bits)
                && volume.to_bits() == geometry.volume().to_bits();
            out.cells.push(cell as u32);
            out.part_of_zone.push(if is_whole { WHOLE_CELL } else { out.parts.len() as u32 });
            out.parts.extend((!is_whole).then_some((centre, volume, samples)));
        }
        out.cell_starts = vec![0; geometry.len() + 1];
        out.cells.iter().for_each(|&c| out.cell_starts[c as usize + 1] += 1);
        for c in 0..geometry.len() {
            out.cell_starts[c + 1] += out.cell_starts[c];
        }
        out
    }

    /// True if the zones are all cells of a grid, each whole.
    fn is_all_cells(&self, geometry: &GridGeometry) -> bool {
        self.parts.is_empty()
            && self.cells.len() == geometry.len()
            && self.cells.iter().enumerate().all(|(i, c)| *c as usize == i)
    }

    fn bytes(&self) -> usize {
        size_of::<u32>() * (self.cells.len() + self.cell_starts.len() + self.part_of_zone.len())
            + self.parts.iter().map(|p| size_of_val(p) + p.2.bytes()).sum::<usize>()
    }
}

/// The voxel zones of a scene by ascending cell.
///
/// ```
/// use zonal_math::{Vec3, vec3};
/// use zonal_scene::{Bands, VoxelGrid, VoxelZones};
/// let mut grid = VoxelGrid::new(Vec3::ZERO, vec3(0.5, 0.5, 0.5), [2, 2, 4])?;
/// grid.fill(Bands::splat(0.1), Bands::splat(0.9), Bands::ZERO, Bands::ZERO);
/// let mut zones = VoxelZones::whole(&grid);
/// assert_eq!((zones.len(), zones.at(5).volume), (16, 0.125));
/// assert_eq!(zones.at(5).centre, vec3(0.25, 0.75, 0.75));
/// assert_eq!(zones.bytes(), 0);
/// zones.update_emission(|i, _| Bands::splat(i as f64));
/// assert_eq!((zones.at(7).emission, zones.at(7).albedo), (Bands::splat(7.0), Bands::splat(0.9)));
/// # Ok::<(), zonal_scene::SceneError>(())
/// ```
#[derive(Clone, Debug)]
pub struct VoxelZones {
    geometry: GridGeometry,
    /// The cell of the first zone, where every cell is one whole zone.
    first: usize,
    len: usize,
    /// True if other processes have further zones.
    is_divided: bool,
    /// `None` if every cell is one whole zone. All bands share it.
    list: Option<Arc<ZoneList>>,
    media: MediumValues,
}

impl Default for VoxelZones {
    /// No zones.
    fn default() -> VoxelZones {
        VoxelZones::without_medium(GridGeometry::default(), None)
    }
}

impl PartialEq for VoxelZones {
    /// True if all zones have equal values, however they are stored.
    fn eq(&self, other: &VoxelZones) -> bool {
        self.iter().eq(other.iter())
    }
}

impl VoxelZones {
    /// Every cell of a grid as one zone.
    pub fn whole(grid: &VoxelGrid) -> VoxelZones {
        VoxelZones { media: grid.media().clone(), ..VoxelZones::without_medium(*grid.geometry(), None) }
    }

    /// Zones at given places of a grid, by ascending cell, with the properties of their cells.
    pub fn new(grid: &VoxelGrid, places: impl IntoIterator<Item = VoxelPlace>) -> VoxelZones {
        let list = ZoneList::new(grid.geometry(), places);
        if list.is_all_cells(grid.geometry()) {
            return VoxelZones::whole(grid);
        }
        let media = grid.media().gathered(list.cells.iter().map(|c| *c as usize));
        VoxelZones { media, ..VoxelZones::without_medium(*grid.geometry(), Some(Arc::new(list))) }
    }

    /// Zones at the same places with the properties of the cells of another grid of the same geometry.
    #[must_use]
    pub fn with_media_of(&self, grid: &VoxelGrid) -> VoxelZones {
        let media = match &self.list {
            Some(list) => grid.media().gathered(list.cells.iter().map(|c| *c as usize)),
            None if self.is_divided => grid.media().gathered(self.first..self.first + self.len),
            None => grid.media().clone(),
        };
        VoxelZones { media, list: self.list.clone(), ..*self }
    }

    /// Zones at given places, by ascending cell, each with the properties of the zone `of_zone` of others.
    pub(crate) fn with_properties_of(
        geometry: GridGeometry,
        places: impl IntoIterator<Item = VoxelPlace>,
        others: &VoxelZones,
        of_zone: &[usize],
    ) -> VoxelZones {
        let list = ZoneList::new(&geometry, places);
        let list = (!list.is_all_cells(&geometry)).then(|| Arc::new(list));
        let media = others.media.gathered(of_zone.iter().copied());
        VoxelZones { media, ..VoxelZones::without_medium(geometry, list) }
    }

    fn without_medium(geometry: GridGeometry, list: Option<Arc<ZoneList>>) -> VoxelZones {
        VoxelZones {
            geometry,
            first: 0,
            is_divided: false,
            len: list.as_ref().map_or(geometry.len(), |l| l.cells.len()),
            list,
            media: MediumValues::uniform([Bands::ZERO; 4]),
        }
    }

    /// The zones of some cells alone, for a process that shares the others with further ones; `None` unless every cell is one whole zone.
    ///
    /// ```
    /// use zonal_math::{Vec3, vec3};
    /// use zonal_scene::{VoxelGrid, VoxelZones};
    /// let zones = VoxelZones::whole(&VoxelGrid::new(Vec3::ZERO, vec3(0.5, 0.5, 0.5), [2, 2, 4])?);
    /// let part = zones.of_cells(4..10).unwrap();
    /// assert_eq!((part.len(), part.total(), part.at(0)), (6, 16, zones.at(4)));
    /// # Ok::<(), zonal_scene::SceneError>(())
    /// ```
    #[must_use]
    pub fn of_cells(&self, cells: std::ops::Range<usize>) -> Option<VoxelZones> {
        let is_whole = self.list.is_none() && self.len == self.geometry.len() && cells.end <= self.len;
        is_whole.then(|| VoxelZones {
            geometry: self.geometry,
            first: cells.start,
            len: cells.len(),
            is_divided: true,
            list: None,
            media: self.media.gathered(cells.clone()),
        })
    }

    /// Number of zones.
    #[inline]
    pub fn len(&self) -> usize {
        self.len
    }
    /// Cell of the first zone where every cell is one whole zone.
    pub fn first_cell(&self) -> usize {
        self.first
    }
    /// True if other processes have further zones ([`VoxelZones::of_cells`]).
    pub fn is_divided(&self) -> bool {
        self.is_divided
    }
    /// Number of zones of all processes: that of the scene.
    pub fn total(&self) -> usize {
        if self.list.is_none() { self.geometry.len() } else { self.len }
    }
    /// Cells of a plane across x if every cell is one whole zone: zones lie plane by plane.
    pub fn plane_size(&self) -> Option<usize> {
        self.list.is_none().then(|| self.geometry.dims[1] * self.geometry.dims[2])
    }
    /// True if there are no zones.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }
    /// Zone `i`; panics beyond the last one.
    #[inline(always)]
    pub fn at(&self, i: usize) -> VoxelZone<'_> {
        assert!(i < self.len, "voxel zone {i} of {}", self.len);
        let (cell, part) = match &self.list {
            None => (self.first + i, None),
            Some(list) => (list.cells[i] as usize, list.parts.get(list.part_of_zone[i] as usize)),
        };
        let (centre, volume, samples) = match part {
            None => {
                (self.geometry.centre(self.geometry.coordinates(cell)), self.geometry.volume(), &NO_SAMPLES)
            }
            Some((centre, volume, samples)) => (*centre, *volume, samples),
        };
        VoxelZone {
            cell,
            centre,
            volume,
            samples,
            extinction: self.media.extinction.get(i),
            albedo: self.media.albedo.get(i),
            emission: self.media.emission.get(i),
            source: self.media.source.get(i),
        }
    }
    /// All zones in their order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = VoxelZone<'_>> + DoubleEndedIterator + Clone {
        (0..self.len).map(|i| self.at(i))
    }
    /// The zones of a cell; empty without a voxel grid.
    #[inline]
    pub(crate) fn zones_of_cell(&self, cell: usize) -> std::ops::Range<usize> {
        match &self.list {
            None if (self.first..self.first + self.len).contains(&cell) => {
                cell - self.first..cell - self.first + 1
            }
            None => 0..0,
            Some(list) => list.cell_starts[cell] as usize..list.cell_starts[cell + 1] as usize,
        }
    }
    /// Zones with every extinction, albedo, emission and source that some zone has: the first of a uniform medium, else all.
    pub fn distinct_media(&self) -> impl Iterator<Item = VoxelZone<'_>> {
        self.iter().take(if self.media.is_uniform() { 1 } else { self.len })
    }
    /// Largest optical depth across a zone, along the longest edge of a cell of `grid`; 0 without a grid.
    pub fn max_thickness(&self, grid: Option<&VoxelGrid>) -> f64 {
        let Some(grid) = grid else { return 0.0 };
        let edge = grid.cell().max_abs();
        let worst = |z: VoxelZone| z.extinction.iter().fold(0.0f64, |m, k| m.max(k * edge));
        self.distinct_media().map(worst).fold(0.0, f64::max)
    }
    /// Number of zones that are parts of cut voxels.
    pub fn cut_count(&self) -> usize {
        self.list.as_ref().map_or(0, |l| l.parts.iter().filter(|p| !p.2.is_empty()).count())
    }
    /// For each zone the number of samples of the zones before it, and last their total; empty if no zone is cut.
    #[must_use]
    pub fn first_samples(&self) -> Vec<usize> {
        if self.cut_count() == 0 {
            return Vec::new();
        }
        let mut first = vec![0];
        self.iter().for_each(|z| first.push(first[first.len() - 1] + z.samples.len()));
        first
    }
    /// Heap memory, bytes.
    pub fn bytes(&self) -> usize {
        self.list.as_ref().map_or(0, |l| l.bytes()) + self.media.bytes()
    }

    /// Replaces the extinction of every zone (1/m) by a function of its index and extinction.
    pub fn update_extinction(&mut self, value: impl Fn(usize, Bands) -> Bands) {
        self.media.extinction.update(self.len, value);
    }
    /// Replaces the albedo of every zone by a function of its index and albedo.
    pub fn update_albedo(&mut self, value: impl Fn(usize, Bands) -> Bands) {
        self.media.albedo.update(self.len, value);
    }
    /// Replaces the emission of every zone (W/m²) by a function of its index and emission.
    pub fn update_emission(&mut self, value: impl Fn(usize, Bands) -> Bands) {
        self.media.emission.update(self.len, value);
    }
    /// Replaces the source of every zone (W/m³) by a function of its index and source.
    pub fn update_source(&mut self, value: impl Fn(usize, Bands) -> Bands) {
        self.media.source.update(self.len, value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    fn grid() -> VoxelGrid {
        let mut grid = VoxelGrid::new(vec3(-1.0, 0.1, 3.0), vec3(0.1, 0.3, 0.7), [3, 2, 4]).unwrap();
        grid.fill(Bands::splat(0.3), Bands::splat(0.5), Bands::ZERO, Bands::ZERO);
        grid
    }

    fn is_whole_cell(grid: &VoxelGrid, zone: VoxelZone) -> bool {
        let place = VoxelPlace::whole(grid, zone.cell);
        zone.centre == grid.centre(grid.coordinates(zone.cell))
            && (zone.centre, zone.volume, zone.samples) == (place.centre, place.volume, &place.samples)
    }

    #[test]
    fn whole_cells_of_a_uniform_medium_take_no_memory() {
        let grid = grid();
        let zones = VoxelZones::new(&grid, (0..grid.len()).map(|c| VoxelPlace::whole(&grid, c)));
        assert_eq!((zones.len(), zones.bytes(), zones.cut_count()), (24, 0, 0));
        assert_eq!(zones, VoxelZones::whole(&grid));
        for (i, zone) in zones.iter().enumerate() {
            assert!(is_whole_cell(&grid, zone));
            assert_eq!((zone.cell, zone.extinction, zone.albedo), (i, Bands::splat(0.3), Bands::splat(0.5)));
            assert_eq!(zones.zones_of_cell(i), i..i + 1);
        }
        assert_eq!(zones.distinct_media().count(), 1);
    }

    #[test]
    fn cut_and_missing_cells_keep_their_places_and_the_media_of_their_cells() {
        let mut grid = grid();
        (0..grid.len())
            .for_each(|c| grid.set(c, Bands::splat(c as f64), Bands::splat(0.5), Bands::ZERO, Bands::ZERO));
        // Cell 1 has two parts, cell 2 none; cell 3 is whole but off its centre by one bit.
        let cell = |c: usize| VoxelPlace::whole(&grid, c);
        let part = |c: usize, x: f64| {
            let (lo, at) = (grid.corner(grid.coordinates(c)), cell(c).centre + vec3(x, 0.0, 0.0));
            let samples = [crate::VolumeSample { point: at, volume: 0.001, subcell: 21 }];
            let samples = VoxelSamples::new(lo, grid.cell(), 0.004, &samples);
            VoxelPlace { cell: c, centre: at, volume: 0.004, samples }
        };
        let off = VoxelPlace { centre: vec3(cell(3).centre.x.next_up(), cell(3).centre.y, 4.0), ..cell(3) };
        let mut places = vec![cell(0), part(1, 0.01), part(1, -0.01), off];
        places.extend((4..grid.len()).map(cell));
        let zones = VoxelZones::new(&grid, places.clone());
        assert_eq!((zones.len(), zones.cut_count()), (24, 2));
        for (zone, place) in zones.iter().zip(&places) {
            let found = (zone.cell, zone.centre, zone.volume, zone.samples);
            assert_eq!(found, (place.cell, place.centre, place.volume, &place.samples));
            assert_eq!(zone.extinction, Bands::splat(place.cell as f64));
        }
        let of_cells: Vec<_> = (0..5).map(|c| zones.zones_of_cell(c)).collect();
        assert_eq!(of_cells, [0..1, 1..3, 3..3, 3..4, 4..5]);
        // A varying property takes 24 bytes a zone, the places of whole cells 12 and those of the three others 40 more.
        let samples: usize = zones.iter().map(|z| z.samples.bytes()).sum();
        assert_eq!(zones.bytes() - samples, 24 * (24 + 8) + 4 * 25 + 3 * 40);
        assert_ne!(zones, VoxelZones::whole(&grid));
        assert_eq!(zones.distinct_media().count(), 24);
    }

    #[test]
    fn updates_store_equal_bits_once() {
        let mut zones = VoxelZones::whole(&grid());
        zones.update_emission(|i, _| if i == 5 { Bands::ONE } else { Bands::ZERO });
        assert_eq!(zones.bytes(), 24 * 24);
        zones.update_emission(|_, old| old + 1.0);
        assert_eq!((zones.at(5).emission, zones.at(6).emission), (Bands::splat(2.0), Bands::ONE));
        zones.update_emission(|_, _| Bands::splat(3.0));
        assert_eq!((zones.at(6).emission, zones.bytes()), (Bands::splat(3.0), 0));
        // Zeros of both signs have different bits.
        zones.update_source(|i, _| if i == 7 { Bands::splat(-0.0) } else { Bands::ZERO });
        assert!(zones.at(7).source.first().is_sign_negative() && zones.bytes() > 0);
        zones.update_albedo(|i, _| Bands::splat(if i < 2 { f64::NAN } else { 0.0 }));
        assert!(zones.at(1).albedo.first().is_nan() && !zones.at(2).albedo.first().is_nan());
    }
}
