//! A regular grid of equal voxels.

use zonal_exchange::aligned::Cuboid;
use zonal_math::{Vec3, vec3};
use zonal_scene::VoxelGrid;

/// A regular grid of voxels; lengths in metres. Its order is that of [`VoxelGrid`]: z runs fastest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UniformGrid {
    /// Lower corner.
    pub origin: Vec3,
    /// Edges of a voxel.
    pub cell: Vec3,
    /// Voxels along each axis.
    pub dims: [usize; 3],
}

impl UniformGrid {
    /// The grid of a scene's medium.
    pub fn of(map: &VoxelGrid) -> UniformGrid {
        UniformGrid { origin: map.min(), cell: map.cell(), dims: map.dims() }
    }
    /// Number of voxels.
    pub fn len(&self) -> usize {
        self.dims.iter().product()
    }
    /// True when an axis has no voxel.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Index of a voxel.
    pub fn index(&self, c: [usize; 3]) -> usize {
        (c[0] * self.dims[1] + c[1]) * self.dims[2] + c[2]
    }
    /// The voxel as a box.
    pub fn voxel(&self, c: [usize; 3]) -> Cuboid {
        let corner = |d: usize| {
            let at = |k: usize| self.origin[k] + self.cell[k] * (c[k] + d) as f64;
            vec3(at(0), at(1), at(2))
        };
        Cuboid::voxel(corner(0), corner(1))
    }
}
