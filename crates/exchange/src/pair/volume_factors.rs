//! The interface of a formula that replaces the exact factor of two whole voxels.

use crate::aligned::{Cuboid, FactorCache};
use std::fmt::Debug;
use zonal_math::Bounded;
use zonal_scene::VoxelGrid;

/// Two different voxels of a voxel grid.
#[derive(Clone, Copy)]
pub struct VoxelPair<'a> {
    /// The voxels; the first one is that of the row.
    pub voxels: [&'a Cuboid; 2],
    /// Their volumes, m³.
    pub volumes: [f64; 2],
    /// Distance of the centres, m.
    pub distance: f64,
    /// The result of [`VolumeFactorMethod::row`] for the first voxel.
    pub row: &'a [Bounded],
    /// The cell of the second voxel in the voxel grid.
    pub cell: usize,
    /// Exact factors.
    pub exact: &'a FactorCache,
}

/// The transmittance inside the factor of a voxel with itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SelfAttenuation {
    /// Inside the integral, as in the exact factor.
    Integrated,
    /// That of the distance between the centres, which is 1.
    AtCentre,
}

/// A formula for the geometric factor 𝓕 of two whole voxels, m⁴, without attenuation. The transmittance of the distance between the
/// centres multiplies it.
pub trait VolumeFactorMethod: Debug + Sync {
    /// A name without spaces; checkpoints of solves by different methods differ by it.
    fn name(&self) -> &'static str;

    /// 𝓕 of `voxel` with every cell of the voxel grid, by cell, where the method computes a row at once; else empty.
    fn row(&self, _voxel: &Cuboid, _grid: &VoxelGrid) -> Vec<Bounded> {
        Vec::new()
    }

    /// 𝓕 of a pair with its error radius.
    fn factor(&self, pair: &VoxelPair) -> Bounded;

    /// How the factor of a voxel with itself, which is exact but for its attenuation, is attenuated.
    fn self_attenuation(&self) -> SelfAttenuation;
}
