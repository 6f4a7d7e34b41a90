//! Detectors: the surfaces, points and volumes whose received light is measured.

use zonal_math::Vec3;
use zonal_scene::voxel_samples::subcell_coordinates;
use zonal_scene::{Patch, Plate, SUBCELLS, VolumeSample, VoxelGrid, VoxelZone};

/// A surface, point or volume that receives light.
#[derive(Clone, Debug)]
pub enum Detector {
    /// The side of a plate that `normal` points to: H, the mean over its area.
    Patch {
        /// The plate.
        plate: Plate,
        /// Unit normal of the side that receives.
        normal: Vec3,
    },
    /// Plates of a surface, at least one: H, the mean over all of their area.
    Surface(Vec<SurfacePlate>),
    /// A point in free space: G there.
    Point(Vec3),
    /// A box without obstacles: G, the mean over its volume.
    Cell {
        /// Lower corner, m.
        lo: Vec3,
        /// Upper corner, m.
        hi: Vec3,
    },
    /// The free part of a cell that walls divide: G, the mean over its volume. The points of each box that see the box's sample
    /// point belong to the part.
    Part(Vec<SubcellPart>),
    /// A piece of a pane: G, the mean over its volume.
    Pane {
        /// Index of the pane.
        pane: usize,
        /// Its middle plane.
        plate: Plate,
    },
}

/// A plate of a surface, on the side that `normal` points to.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePlate {
    /// The plate.
    pub plate: Plate,
    /// Unit normal of the side that receives.
    pub normal: Vec3,
    /// Area of the plates of the surface up to this one, m².
    pub area_up_to: f64,
}

impl SurfacePlate {
    /// The plate in which the fraction `u` of the area of all plates ends; `u` is in [0, 1).
    pub(super) fn at_share(plates: &[SurfacePlate], u: f64) -> &SurfacePlate {
        let last = plates.len() - 1;
        let area = u * plates[last].area_up_to;
        &plates[plates.partition_point(|p| p.area_up_to <= area).min(last)]
    }
}

/// The share of a sub-cell in a part of a cell.
#[derive(Clone, Copy, Debug)]
pub struct SubcellPart {
    /// Lower corner of the sub-cell, m.
    pub lo: Vec3,
    /// Upper corner of the sub-cell, m.
    pub hi: Vec3,
    /// A sample point of the part.
    pub point: Vec3,
    /// Free volume, m³.
    pub volume: f64,
}

impl Detector {
    /// The exchanging side of a patch.
    pub fn patch(p: &Patch) -> Detector {
        Detector::Patch { plate: p.plate, normal: p.normal }
    }

    /// The exchanging sides of patches, at least one.
    pub fn surface<'p>(patches: impl Iterator<Item = &'p Patch>) -> Detector {
        let plates = patches.scan(0.0, |area_up_to, p| {
            *area_up_to += p.area;
            Some(SurfacePlate { plate: p.plate, normal: p.normal, area_up_to: *area_up_to })
        });
        Detector::Surface(plates.collect())
    }

    /// A volume zone.
    pub fn voxel(z: VoxelZone, grid: &VoxelGrid) -> Detector {
        let c = grid.coordinates(z.cell);
        let (lo, edge) = (grid.corner(c), grid.cell());
        if z.samples.is_empty() {
            return Detector::Cell { lo, hi: lo + edge };
        }
        let small = edge / SUBCELLS as f64;
        let part = |s: VolumeSample| {
            let lo = lo + small.scale(subcell_coordinates(s.subcell));
            SubcellPart { lo, hi: lo + small, point: s.point, volume: s.volume }
        };
        Detector::Part(z.samples.iter().map(part).collect())
    }

    /// True where the reading is an irradiance.
    pub(super) fn is_surface(&self) -> bool {
        matches!(self, Detector::Patch { .. } | Detector::Surface(_))
    }
}
