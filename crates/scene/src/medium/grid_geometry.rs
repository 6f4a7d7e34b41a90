//! Position and size of the cells of a regular grid.

use zonal_math::{Vec3, vec3};

/// The cells of a regular grid. Cell (i, j, k) is the box min + (i..i+1, j..j+1, k..k+1) ∘ cell; its index is (i·ny + j)·nz + k.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct GridGeometry {
    /// Lower corner, m.
    pub(crate) min: Vec3,
    /// Cell edges, m.
    pub(crate) cell: Vec3,
    /// Cells along each axis.
    pub(crate) dims: [usize; 3],
}

impl GridGeometry {
    /// Number of cells.
    #[inline]
    pub(crate) fn len(&self) -> usize {
        self.dims[0] * self.dims[1] * self.dims[2]
    }
    /// Index of a cell by its coordinates.
    #[inline]
    pub(crate) fn index(&self, c: [usize; 3]) -> usize {
        (c[0] * self.dims[1] + c[1]) * self.dims[2] + c[2]
    }
    /// Coordinates of a cell by its index.
    #[inline]
    pub(crate) fn coordinates(&self, index: usize) -> [usize; 3] {
        let (ny, nz) = (self.dims[1], self.dims[2]);
        [index / (ny * nz), index / nz % ny, index % nz]
    }
    /// Lower corner of a cell, m.
    #[inline]
    pub(crate) fn corner(&self, c: [usize; 3]) -> Vec3 {
        self.min + self.cell.scale(vec3(c[0] as f64, c[1] as f64, c[2] as f64))
    }
    /// Centre of a cell, m.
    #[inline]
    pub(crate) fn centre(&self, c: [usize; 3]) -> Vec3 {
        self.corner(c) + self.cell * 0.5
    }
    /// Volume of a cell, m³.
    #[inline]
    pub(crate) fn volume(&self) -> f64 {
        self.cell.product()
    }
}
