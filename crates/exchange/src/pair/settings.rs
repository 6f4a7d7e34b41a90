//! Settings of the exchange of pairs.

use super::volume_factors::VolumeFactorMethod;
use zonal_math::low_discrepancy;

/// How the exchange of pairs is computed.
#[derive(Clone, Copy, Debug)]
pub struct PairSettings {
    /// Relative radius of the axis-aligned factors. The default is 1e-11, far below the other errors of a solve.
    pub aligned_tolerance: f64,
    /// Relative radius of the unobstructed factors of two plates in a general position.
    pub plate_tolerance: f64,
    /// A formula that replaces the exact factor of two whole voxels. Every other pair has its exact factor.
    pub volume_factors: Option<&'static dyn VolumeFactorMethod>,
    /// Prepares every zone once, about 500 bytes each; pays where most pairs are computed.
    pub keep_zones: bool,
    /// Index of the sample of ray points. Samples are independent and of equal quality.
    pub sample: u64,
}

impl PairSettings {
    /// Seed of the sample points of the pair of zones `i` and `j`.
    pub(super) fn seed(&self, i: usize, j: usize) -> u64 {
        ((i as u64) << 32 | j as u64) ^ sample_seed(self.sample)
    }
}

/// The number that distinguishes the points of a sample from those of other samples; 0 for the first sample.
pub fn sample_seed(sample: u64) -> u64 {
    if sample == 0 { 0 } else { low_discrepancy::split_mix64(sample) }
}

impl Default for PairSettings {
    fn default() -> PairSettings {
        PairSettings {
            aligned_tolerance: 1e-11,
            plate_tolerance: 1e-9,
            volume_factors: None,
            keep_zones: true,
            sample: 0,
        }
    }
}
