//! Geometric factors of two patches alone, for engines that measure visibility and attenuation their own way.

use super::{Exchange, PLATE_ABSOLUTE};
use zonal_math::Bounded;

impl Exchange<'_> {
    /// 𝓕 of the patches `i` and `j`, m², with nothing between them, to the relative radius `tolerance`.
    ///
    /// # Panics
    /// On a zone that is no patch.
    pub fn plates(&self, i: usize, j: usize, tolerance: f64) -> Bounded {
        self.plates.pair(i, j, tolerance, PLATE_ABSOLUTE.max(1e-3 * tolerance)).bounded
    }
}
