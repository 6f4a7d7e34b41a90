//! The exchange of one pair, and counts of how pairs were computed.

use zonal_scene::Bands;

/// Numbers of pairs and rays by method.
#[derive(Clone, Copy, Debug, Default)]
pub struct PairCounts {
    /// Pairs of axis-aligned zones by exact factors.
    pub aligned: u64,
    /// Pairs of voxels by a [`VolumeFactorMethod`](crate::pair::VolumeFactorMethod).
    pub by_volume_method: u64,
    /// Pairs with a plate in a general position.
    pub general: u64,
    /// Pairs whose geometric factor has an estimated radius.
    pub estimated: u64,
    /// Pairs with a cut voxel.
    pub cut: u64,
    /// Pairs with a pane.
    pub pane: u64,
    /// Pairs that face away from each other.
    pub facing_away: u64,
    /// Partly visible pairs, which took additional rays.
    pub partial: u64,
    /// Rays.
    pub rays: u64,
}

zonal_math::counters!(
    PairCounts of u64: aligned, by_volume_method, general, estimated, cut, pane, facing_away, partial, rays
);

impl PairCounts {
    /// True if every radius is proved: no ray and no estimate took part.
    pub fn all_proved(&self) -> bool {
        self.rays + self.estimated == 0
    }
}

/// g_ij with its error radius in each band.
#[derive(Clone, Copy, Debug, Default)]
pub struct PairFactor {
    /// g_ij: m² (ss), m³ (sv), m⁴ (vv).
    pub value: Bands,
    /// Error radius: estimated, or proved where no ray and no general quadrature took part.
    pub radius: Bands,
}
