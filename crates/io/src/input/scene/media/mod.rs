//! `[medium]`, its regions and its gas: voxels while they are filled.
//!
//! | module | contents |
//! |---|---|
//! | `medium` | the section |
//! | `region`, `interior` | regions of the medium, and what surfaces enclose |
//! | `gas` | voxels of a gas model by name |
//! | `density`, `resample` | densities of files; conservative resampling onto the voxels |
//! | `voxel_arrays`, `voxel_field` | one value for each voxel |
//! | `voxel_grid` | voxels while they are filled |

pub(crate) mod density;
pub(crate) mod gas;
pub(crate) mod interior;
pub(crate) mod medium;
pub(crate) mod region;
pub(crate) mod resample;
pub(crate) mod voxel_arrays;
pub(crate) mod voxel_field;
pub(crate) mod voxel_grid;
