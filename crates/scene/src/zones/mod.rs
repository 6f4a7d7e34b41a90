//! Zones: patches, voxel zones and pane zones, on which radiosity is constant or linear.
//!
//! The global order of zones, used by every array of a solution: patches, then voxel zones, then pane zones.

pub(crate) mod merged_patches;
pub(crate) mod sheet_sides;
pub(crate) mod voxel_zones;

use crate::bands::Bands;
use crate::bands::band::Band;
use crate::geometry::plate::Plate;
use crate::zones::merged_patches::MergedPatches;
use crate::zones::sheet_sides::SheetSides;
use crate::zones::voxel_zones::{VoxelZone, VoxelZones};
use zonal_math::Vec3;

/// A surface zone: one side of a piece of a facet.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// Index of its facet.
    pub facet: usize,
    /// Index of its surface.
    pub surface: usize,
    /// Geometry; the front is the side that takes part in the exchange.
    pub plate: Plate,
    /// Unit normal of that side.
    pub normal: Vec3,
    /// Area A, m².
    pub area: f64,
    /// Reflectance ρ, the mean over the patch.
    pub reflectance: Bands,
    /// Emitted flux E, W/m², the mean over the patch; zero if the surface is a direct emitter.
    pub emission: Bands,
}

/// Length of a ray from a surface, over the square root of the area of the patch that it hits, below which the ray goes on from the point hit: there the
/// radiosity varies within the patch. On a ball that lies on a floor the error against light traced without zones is 0.9 % in this way, where the dense
/// engine is 4.2 % off (`docs/error-against-cost.md`, tolerance 0.02).
pub const MAX_CONTINUED_PATCH_SIZES: f64 = 1.5;

impl Patch {
    /// True where a ray from a surface that hits the patch at this distance (m) goes on from the point hit.
    #[must_use]
    pub fn continues_rays(&self, distance: f64) -> bool {
        distance < MAX_CONTINUED_PATCH_SIZES * self.area.sqrt()
    }
}

/// A volume zone outside the voxel grid: a piece of a pane.
#[derive(Clone, Debug, PartialEq)]
pub struct PaneZone {
    /// Index of the pane.
    pub pane: usize,
    /// Geometry of the middle plane.
    pub plate: Plate,
    /// Unit normal.
    pub normal: Vec3,
    /// Area, m²; the volume is area times thickness.
    pub area: f64,
    /// Thickness t, m.
    pub thickness: f64,
    /// Extinction κ, 1/m.
    pub extinction: Bands,
    /// Scattering albedo Ω.
    pub albedo: Bands,
    /// Blackbody emissive power E, W/m².
    pub emission: Bands,
}

/// Smallest cosine between a direction and the normal of a pane: bounds the path through it.
const MIN_PANE_COSINE: f64 = 1e-6;
/// Optical depth below which the path through a pane is its geometric length.
const THIN_OPTICAL_DEPTH: f64 = 1e-12;

impl PaneZone {
    /// (1 − e^{−κt/c})/κ for light in direction `dir` with the cosine c, m: times κ, the fraction that the pane intercepts.
    pub fn effective_path(&self, dir: Vec3) -> Bands {
        let path = self.thickness / self.normal.dot(dir).abs().max(MIN_PANE_COSINE);
        self.extinction.map(|k| if k * path > THIN_OPTICAL_DEPTH { -(-k * path).exp_m1() / k } else { path })
    }
}

/// Kinds of zones, in their global order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ZoneKind {
    /// A surface zone.
    Patch,
    /// A volume zone of the voxel grid.
    Voxel,
    /// A volume zone of a pane.
    Pane,
}

/// One zone of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ZoneRef<'a> {
    /// A patch; its global index is its index among the patches.
    Patch(&'a Patch),
    /// A voxel zone and its index among the voxel zones.
    Voxel(usize, VoxelZone<'a>),
    /// A pane zone and its index among the pane zones.
    Pane(usize, &'a PaneZone),
}

impl ZoneRef<'_> {
    /// Its kind.
    pub fn kind(&self) -> ZoneKind {
        match self {
            ZoneRef::Patch(_) => ZoneKind::Patch,
            ZoneRef::Voxel(..) => ZoneKind::Voxel,
            ZoneRef::Pane(..) => ZoneKind::Pane,
        }
    }
    /// Centre of a plate, of the free volume of a voxel zone, m.
    pub fn centre(&self) -> Vec3 {
        match self {
            ZoneRef::Patch(p) => p.plate.centre(),
            ZoneRef::Voxel(_, v) => v.centre,
            ZoneRef::Pane(_, p) => p.plate.centre(),
        }
    }
    /// Area of a patch or of a piece of a pane, m²; volume of a voxel zone, m³.
    pub fn size(&self) -> f64 {
        match self {
            ZoneRef::Patch(p) => p.area,
            ZoneRef::Voxel(_, v) => v.volume,
            ZoneRef::Pane(_, p) => p.area,
        }
    }
}

/// All zones of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Zones {
    /// Surface zones.
    pub patches: Vec<Patch>,
    /// Volume zones of the voxel grid, by ascending cell.
    pub voxels: VoxelZones,
    /// Volume zones of the panes.
    pub panes: Vec<PaneZone>,
    /// Reflectance of each patch in thermal mode where emissivities depend on temperature or side, whatever the equations use in its place; empty
    /// where every patch has that of its facet.
    pub own_reflectances: Vec<Bands>,
    /// The sides of sheets that transmit diffusely.
    pub sheets: SheetSides,
    /// Patches that share one radiosity; none but in the solve on larger zones that estimates the discretization error.
    pub merged: MergedPatches,
}

impl Zones {
    /// Number of zones.
    pub fn len(&self) -> usize {
        self.patches.len() + self.voxels.len() + self.panes.len()
    }
    /// Number of zones of all processes: more than [`Zones::len`] where this process has some voxel zones alone ([`VoxelZones::of_cells`]).
    pub fn total(&self) -> usize {
        self.patches.len() + self.voxels.total() + self.panes.len()
    }
    /// True if there are no zones.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Zone `i` by its global index.
    // As [`VoxelZones::at`]: what a caller does not use of a voxel is then not computed.
    #[inline(always)]
    pub fn zone(&self, i: usize) -> ZoneRef<'_> {
        if i < self.voxel_offset() {
            ZoneRef::Patch(&self.patches[i])
        } else if i < self.pane_offset() {
            let k = i - self.voxel_offset();
            ZoneRef::Voxel(k, self.voxels.at(k))
        } else {
            let k = i - self.pane_offset();
            ZoneRef::Pane(k, &self.panes[k])
        }
    }
    /// The kind of zone `i`.
    pub fn kind(&self, i: usize) -> ZoneKind {
        match i {
            i if i < self.voxel_offset() => ZoneKind::Patch,
            i if i < self.pane_offset() => ZoneKind::Voxel,
            _ => ZoneKind::Pane,
        }
    }
    /// The zones of each kind: patches, voxel zones and pane zones.
    pub fn ranges_of_kinds(&self) -> [std::ops::Range<usize>; 3] {
        let (voxels, panes) = (self.voxel_offset(), self.pane_offset());
        [0..voxels, voxels..panes, panes..self.len()]
    }
    /// Global index of voxel zone `k`.
    #[inline]
    pub fn voxel_index(&self, k: usize) -> usize {
        self.voxel_offset() + k
    }
    /// Global index of pane zone `k`.
    #[inline]
    pub fn pane_index(&self, k: usize) -> usize {
        self.pane_offset() + k
    }
    /// Global index of the first voxel zone.
    pub fn voxel_offset(&self) -> usize {
        self.patches.len()
    }
    /// Global index of the first pane zone.
    pub fn pane_offset(&self) -> usize {
        self.patches.len() + self.voxels.len()
    }
    /// The voxel zones of a cell, as indices into `voxels`.
    pub fn voxel_zones_of_cell(&self, cell: usize) -> std::ops::Range<usize> {
        self.voxels.zones_of_cell(cell)
    }
    /// Radiosity that zone `i` scatters of the incident fields H and G of the zones, W/m²: ρ H of a patch, with τ H of the other side of a sheet, Ω/4 G of a
    /// volume zone.
    pub fn scattered(&self, i: usize, field: impl Fn(usize) -> Bands) -> Bands {
        let own = self.response(i).0 * field(i);
        self.sheets.opposite(i).map_or(own, |j| own + self.sheets.transmittance(j) * field(j))
    }
    /// The mean (ρ x_i + τ x_j)/(ρ + τ) of a field x of both sides of a sheet: times ρ + τ, its part in the radiosity of side i, W/m². The field of other
    /// zones.
    pub fn mixed(&self, i: usize, field: impl Fn(usize) -> Bands) -> Bands {
        let Some(j) = self.sheets.opposite(i) else { return field(i) };
        let (rho, tau) = (self.patches[i].reflectance, self.sheets.transmittance(i));
        (rho * field(i) + tau * field(j)).zip_map(rho + tau, |x, w| if w > 0.0 { x / w } else { 0.0 })
    }
    /// Response and measure of zone `i`: (ρ, A in m²) of a patch, (Ω/4, V in m³) of a volume zone; B = E + response · (H or G), with the transmitted light of
    /// sheets ([`Zones::scattered`]).
    pub fn response(&self, i: usize) -> (Bands, f64) {
        match self.zone(i) {
            ZoneRef::Patch(p) => (p.reflectance, p.area),
            ZoneRef::Voxel(_, v) => (0.25 * v.albedo, v.volume),
            ZoneRef::Pane(_, p) => (0.25 * p.albedo, p.area * p.thickness),
        }
    }
    /// Strength κB of the source of zone `i` in the bands in which it is transparent, W/m³: q/4, where q/(4κ) has no value. Zero for other zones.
    pub fn transparent_source(&self, i: usize) -> Bands {
        match self.zone(i) {
            ZoneRef::Voxel(_, v) => {
                v.source.zip_map(v.extinction, |q, k| if k > 0.0 { 0.0 } else { 0.25 * q })
            }
            _ => Bands::ZERO,
        }
    }
    /// True if a voxel zone without extinction has a source, in some band.
    pub fn has_transparent_sources(&self) -> bool {
        let emits = |q: f64, k: f64| q > 0.0 && k == 0.0;
        self.voxels.distinct_media().any(|v| Band::all().any(|b| emits(v.source[b], v.extinction[b])))
    }
    /// Emission of zone `i` as a radiosity, W/m²: E of a patch, (1−Ω)E + q/(4κ) of a volume zone; without the source where κ is 0
    /// ([`Zones::transparent_source`]).
    pub fn emission(&self, i: usize) -> Bands {
        match self.zone(i) {
            ZoneRef::Patch(p) => p.emission,
            ZoneRef::Voxel(_, v) => {
                let q = v.source.zip_map(v.extinction, |q, k| if k > 0.0 { q / (4.0 * k) } else { 0.0 });
                (1.0 - v.albedo) * v.emission + q
            }
            ZoneRef::Pane(_, p) => (1.0 - p.albedo) * p.emission,
        }
    }
}
