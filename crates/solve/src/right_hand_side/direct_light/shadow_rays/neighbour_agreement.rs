//! Agreement of the pilot samples of a zone with those of the cells around it.

use super::params::{AGREEMENT_REACH, PILOT_SAMPLES};
use super::zone_sampler::{DirectLightEstimate, ZoneLightSampler};
use zonal_math::parallel;
use zonal_scene::VoxelGrid;

/// Visibility of the pilot samples around each cell.
pub(super) struct NeighbourAgreement<'a> {
    grid: &'a VoxelGrid,
    /// [`DirectLightEstimate::visibility_bits`] over the cells up to [`AGREEMENT_REACH`] away along each axis.
    bits: Vec<u8>,
}

impl<'a> NeighbourAgreement<'a> {
    pub(super) fn new(
        sampler: &ZoneLightSampler,
        grid: &'a VoxelGrid,
        pilot: &[DirectLightEstimate],
    ) -> NeighbourAgreement<'a> {
        let zones = sampler.zones;
        let of_cell = |c: usize| {
            zones.voxel_zones_of_cell(c).fold(0, |s, z| s | pilot[zones.voxel_index(z)].visibility_bits())
        };
        let mut bits: Vec<u8> = (0..grid.len()).map(of_cell).collect();
        let dims = grid.dims();
        for (axis, stride) in [dims[1] * dims[2], dims[2], 1].into_iter().enumerate() {
            let spread = |c: usize| {
                let at = c / stride % dims[axis];
                let (back, ahead) = (at.min(AGREEMENT_REACH), (dims[axis] - 1 - at).min(AGREEMENT_REACH));
                (c - back * stride..=c + ahead * stride).step_by(stride).fold(0, |s, d| s | bits[d])
            };
            bits = parallel::collect(grid.len(), spread);
        }
        NeighbourAgreement { grid, bits }
    }

    /// Number of samples around zone `i` if all of them agree with its own, else 0.
    pub(super) fn agreeing_samples(
        &self,
        sampler: &ZoneLightSampler,
        one: &DirectLightEstimate,
        i: usize,
    ) -> usize {
        let around = sampler.cell_of(self.grid, i).map(|c| self.bits[c]);
        let side: usize = 2 * AGREEMENT_REACH + 1;
        // The cells in front of a surface represent its creases less well than their own volume.
        let count = side.pow(if i < sampler.zones.patches.len() { 2 } else { 3 });
        if around == Some(one.visibility_bits()) && one.agrees() { PILOT_SAMPLES[1] * count } else { 0 }
    }
}
