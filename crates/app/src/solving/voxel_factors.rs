//! The formula of the exchange factor of two voxels.

use zonal_exchange::pair::PairSettings;
use zonal_paper::VoxelFormula;

/// Formula of the exchange factor of two voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum VoxelFactors {
    /// Exact: the reduced integral with attenuation inside, to a relative error of 1e-11.
    Exact,
    /// Paper: Gegenbauer series along strips of voxels, times the transmittance between the centres.
    Series,
    /// Paper, Proposition 1: exact geometric factor, times the transmittance between the centres.
    Prop1,
    /// Paper, formula (3): kernel and transmittance between the centres.
    Point,
}

impl VoxelFactors {
    /// The names in options, in the order of [`VoxelFactors::VARIANTS`].
    pub const NAMES: [&str; 4] = ["exact", "series", "prop1", "point"];
    /// All formulas.
    pub const VARIANTS: [VoxelFactors; 4] =
        [VoxelFactors::Exact, VoxelFactors::Series, VoxelFactors::Prop1, VoxelFactors::Point];

    /// Settings of a solve with this formula.
    #[must_use]
    pub fn pair_settings(self) -> PairSettings {
        let formula = match self {
            VoxelFactors::Exact => None,
            VoxelFactors::Series => Some(VoxelFormula::Series),
            VoxelFactors::Prop1 => Some(VoxelFormula::Proposition1),
            VoxelFactors::Point => Some(VoxelFormula::Point),
        };
        PairSettings { volume_factors: formula.map(VoxelFormula::method), ..PairSettings::default() }
    }
}
