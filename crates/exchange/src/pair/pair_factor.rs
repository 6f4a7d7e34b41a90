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

impl PairCounts {
    /// Adds another count.
    pub fn merge(&mut self, o: PairCounts) {
        self.aligned += o.aligned;
        self.by_volume_method += o.by_volume_method;
        self.general += o.general;
        self.estimated += o.estimated;
        self.cut += o.cut;
        self.pane += o.pane;
        self.facing_away += o.facing_away;
        self.partial += o.partial;
        self.rays += o.rays;
    }

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
