//! The paper's algorithm `Formfact` for a voxel of the scene.

use super::Exchange;
use crate::paper::strip::{Ask, Means, formfact};
use zonal_math::Bounded;

/// Wanted relative truncation of the series: far below what taking the transmittance out of the integral costs.
const SERIES_TOLERANCE: f64 = 1e-6;

impl Exchange<'_> {
    /// 𝓕 of voxel zone `i` with every cell of the voxmap, m⁴, by cell.
    pub(super) fn strips(&self, i: usize) -> Vec<Bounded> {
        let (Some(own), Some(grid)) = (self.items.get(i).aligned, self.grid) else {
            unreachable!("a whole voxel is a cell of a voxmap");
        };
        let all = formfact(&own, &grid, Ask::Tolerance(SERIES_TOLERANCE), Means::Reduced);
        (0..grid.len()).map(|k| all.get(k)).collect()
    }
}
