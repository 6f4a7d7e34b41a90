//! The paper's formulas for two whole voxels of a scene, as methods of a solve (`zonal solve --factors`).

use crate::voxel_strips::{MomentQuadrature, StripAccuracy, UniformGrid, formfact};
use std::f64::consts::PI;
use zonal_exchange::aligned::Cuboid;
use zonal_exchange::pair::{SelfAttenuation, VolumeFactorMethod, VoxelPair};
use zonal_math::Bounded;
use zonal_scene::VoxelGrid;

/// Relative truncation error of the series: far below the error of taking the transmittance out of the integral.
const SERIES_TOLERANCE: f64 = 1e-6;

/// A formula of the paper for two voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VoxelFormula {
    /// The algorithm `Formfact`, a Gegenbauer series along each strip, times the transmittance of the distance between the centres.
    Series,
    /// Proposition 1: the exact geometric factor times that transmittance.
    Proposition1,
    /// Formula (3): kernel and transmittance at the centres. A voxel with itself, which has no distance, is exact.
    Point,
}

impl VoxelFormula {
    /// The method for the settings of a solve.
    pub fn method(self) -> &'static dyn VolumeFactorMethod {
        match self {
            VoxelFormula::Series => &VoxelFormula::Series,
            VoxelFormula::Proposition1 => &VoxelFormula::Proposition1,
            VoxelFormula::Point => &VoxelFormula::Point,
        }
    }
}

impl VolumeFactorMethod for VoxelFormula {
    fn name(&self) -> &'static str {
        match self {
            VoxelFormula::Series => "Series",
            VoxelFormula::Proposition1 => "Proposition1",
            VoxelFormula::Point => "Point",
        }
    }

    fn row(&self, voxel: &Cuboid, map: &VoxelGrid) -> Vec<Bounded> {
        if *self != VoxelFormula::Series {
            return Vec::new();
        }
        let grid = UniformGrid::of(map);
        let all =
            formfact(voxel, &grid, StripAccuracy::Tolerance(SERIES_TOLERANCE), MomentQuadrature::Reduced);
        (0..grid.len()).map(|k| all.get(k)).collect()
    }

    fn factor(&self, pair: &VoxelPair) -> Bounded {
        let r = pair.distance;
        match self {
            VoxelFormula::Series => pair.row[pair.cell],
            VoxelFormula::Proposition1 => pair.exact.get(pair.voxels[0], pair.voxels[1], 0.0),
            VoxelFormula::Point => Bounded::estimated(pair.volumes[0] * pair.volumes[1] / (PI * r * r), 0.0),
        }
    }

    fn self_attenuation(&self) -> SelfAttenuation {
        match self {
            VoxelFormula::Series | VoxelFormula::Proposition1 => SelfAttenuation::AtCentre,
            VoxelFormula::Point => SelfAttenuation::Integrated,
        }
    }
}
