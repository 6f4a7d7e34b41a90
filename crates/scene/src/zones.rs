//! Zones: the pieces on which radiosity is constant.
//!
//! Global order, used by every array of a solution: patches, then voxel zones, then pane zones.

use crate::{Bands, Part, Plate, bands};
use zonal_math::Vec3;

pub use crate::part::SUBCELLS;

/// A surface zone: one side of a piece of a facet.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// Index of the facet it is cut from.
    pub facet: usize,
    /// Index of the surface.
    pub surface: usize,
    /// Shape; its front is the side that exchanges.
    pub plate: Plate,
    /// Unit normal of that side.
    pub normal: Vec3,
    /// Area A, m².
    pub area: f64,
    /// Reflectance ρ, the mean over the patch.
    pub reflectance: Bands,
    /// Emitted flux E, W/m², the mean over the patch; zero where the surface is a direct emitter.
    pub emission: Bands,
}

/// A volume zone: the free part of a voxel, or one of the parts that a wall separates.
#[derive(Clone, Debug, PartialEq)]
pub struct VoxelZone {
    /// Index of the cell in the voxmap.
    pub cell: usize,
    /// Centre of the free volume, in free space, m.
    pub centre: Vec3,
    /// Free volume V, m³.
    pub volume: f64,
    /// Empty for a whole voxel; else the samples that make up this part.
    pub part: Part,
    /// Extinction κ, 1/m.
    pub extinction: Bands,
    /// Scattering albedo Ω.
    pub albedo: Bands,
    /// Black emissive power E, W/m².
    pub emission: Bands,
    /// Volumetric source q, W/m³.
    pub source: Bands,
}

/// A volume zone off the voxmap: a piece of a pane.
#[derive(Clone, Debug, PartialEq)]
pub struct PaneZone {
    /// Index of the pane.
    pub pane: usize,
    /// Shape of its middle plane.
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
    /// Black emissive power E, W/m².
    pub emission: Bands,
}

impl PaneZone {
    /// (1 − e^{−κt/c})/κ of light in direction `dir`, c the cosine, m: over the thickness, what the pane takes of it.
    pub fn effective_path(&self, dir: Vec3) -> Bands {
        let path = self.thickness / self.normal.dot(dir).abs().max(1e-6);
        self.extinction.map(|k| if k * path > 1e-12 { -(-k * path).exp_m1() / k } else { path })
    }
}

/// All zones of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Zones {
    /// Surface zones.
    pub patches: Vec<Patch>,
    /// Volume zones of the voxmap, by ascending cell.
    pub voxels: Vec<VoxelZone>,
    /// Volume zones of the panes.
    pub panes: Vec<PaneZone>,
    /// `first[c]..first[c+1]` are the voxel zones of cell c; empty without a voxmap.
    pub first: Vec<u32>,
}

impl Zones {
    /// Number of zones.
    pub fn len(&self) -> usize {
        self.patches.len() + self.voxels.len() + self.panes.len()
    }
    /// True without any zone.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
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
    pub fn of_cell(&self, cell: usize) -> std::ops::Range<usize> {
        if self.first.is_empty() {
            return 0..0;
        }
        self.first[cell] as usize..self.first[cell + 1] as usize
    }
    /// ρ of a patch, Ω/4 of the others, and the measure (A in m², V in m³) of zone `i`: B = E + response · (H or G).
    pub fn response(&self, i: usize) -> (Bands, f64) {
        if i < self.voxel_offset() {
            let p = &self.patches[i];
            (p.reflectance, p.area)
        } else if i < self.pane_offset() {
            let v = &self.voxels[i - self.voxel_offset()];
            (v.albedo.map(|o| 0.25 * o), v.volume)
        } else {
            let p = &self.panes[i - self.pane_offset()];
            (p.albedo.map(|o| 0.25 * o), p.area * p.thickness)
        }
    }
    /// Own emission of zone `i` as a radiosity, W/m²: E of a patch, (1−Ω)E + q/(4κ) of the others.
    pub fn emission(&self, i: usize) -> Bands {
        if i < self.voxel_offset() {
            self.patches[i].emission
        } else if i < self.pane_offset() {
            let v = &self.voxels[i - self.voxel_offset()];
            bands(|b| {
                let q = if v.extinction[b] > 0.0 { v.source[b] / (4.0 * v.extinction[b]) } else { 0.0 };
                (1.0 - v.albedo[b]) * v.emission[b] + q
            })
        } else {
            let p = &self.panes[i - self.pane_offset()];
            bands(|b| (1.0 - p.albedo[b]) * p.emission[b])
        }
    }
}
