//! The medium on a regular grid.
//!
//! | module | contents |
//! |---|---|
//! | `grid_geometry` | position and size of the cells |
//! | `cell_values` | one value for each cell, stored once if they are equal |
//! | `voxel_grid` | extinction, albedo and sources |
//! | [`voxel_samples`] | sample points of cells that walls cut |

pub(crate) mod cell_values;
pub(crate) mod grid_geometry;
pub(crate) mod voxel_grid;
pub mod voxel_samples;
