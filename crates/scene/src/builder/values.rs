//! Values that callers give per band or per voxel.

use crate::Bands;

/// A value for every spectral band: one number for all bands, or one number for each.
pub trait BandValues {
    /// The value of each band.
    fn into_bands(self) -> Bands;
}

impl BandValues for f64 {
    fn into_bands(self) -> Bands {
        Bands::splat(self)
    }
}

impl BandValues for [f64; 3] {
    fn into_bands(self) -> Bands {
        Bands::from_rgb(self)
    }
}

impl BandValues for Bands {
    fn into_bands(self) -> Bands {
        self
    }
}

/// Values of the voxels of a grid.
#[derive(Clone, Debug, PartialEq)]
pub enum VoxelValues {
    /// The same in all voxels.
    Uniform(Bands),
    /// One number for each voxel, in all bands; voxel (x, y, z) of an nx × ny × nz grid has index (x ny + y) nz + z.
    PerVoxel(Vec<f64>),
    /// One value per band for each voxel, in the same order.
    PerVoxelAndBand(Vec<Bands>),
}

impl VoxelValues {
    /// The value of a voxel.
    pub(super) fn at(&self, index: usize) -> Bands {
        match self {
            VoxelValues::Uniform(v) => *v,
            VoxelValues::PerVoxel(list) => list[index].into_bands(),
            VoxelValues::PerVoxelAndBand(list) => list[index],
        }
    }

    /// Number of voxels given; none where all are the same.
    pub(super) fn len(&self) -> Option<usize> {
        match self {
            VoxelValues::Uniform(_) => None,
            VoxelValues::PerVoxel(list) => Some(list.len()),
            VoxelValues::PerVoxelAndBand(list) => Some(list.len()),
        }
    }
}

impl From<f64> for VoxelValues {
    fn from(value: f64) -> VoxelValues {
        VoxelValues::Uniform(value.into_bands())
    }
}

impl From<[f64; 3]> for VoxelValues {
    fn from(value: [f64; 3]) -> VoxelValues {
        VoxelValues::Uniform(value.into_bands())
    }
}

impl From<Bands> for VoxelValues {
    fn from(value: Bands) -> VoxelValues {
        VoxelValues::Uniform(value)
    }
}

impl From<Vec<f64>> for VoxelValues {
    fn from(values: Vec<f64>) -> VoxelValues {
        VoxelValues::PerVoxel(values)
    }
}

impl From<Vec<[f64; 3]>> for VoxelValues {
    fn from(values: Vec<[f64; 3]>) -> VoxelValues {
        VoxelValues::PerVoxelAndBand(values.into_iter().map(Bands::from_rgb).collect())
    }
}

impl From<Vec<Bands>> for VoxelValues {
    fn from(values: Vec<Bands>) -> VoxelValues {
        VoxelValues::PerVoxelAndBand(values)
    }
}
