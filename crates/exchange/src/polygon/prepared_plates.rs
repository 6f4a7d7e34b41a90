//! The factors of pairs of many plates without a medium. Each plate is prepared once.

use super::mapped_zone::assert_valid_plate;
use super::plate_geometry::PlateGeometry;
use super::plate_pair::{self, RadiusGoal};
use crate::Factor;
use zonal_scene::Plate;

/// Plates prepared for many pairs.
#[derive(Clone, Debug)]
pub struct PreparedPlates(Vec<PlateGeometry>);

impl PreparedPlates {
    /// Prepares plates.
    ///
    /// # Panics
    /// On a plate without area or with corners that are not finite.
    pub fn new(plates: &[Plate]) -> PreparedPlates {
        plates.iter().for_each(assert_valid_plate);
        PreparedPlates(plates.iter().map(PlateGeometry::new).collect())
    }
    /// 𝓕 of plates `i` and `j` in m², without a medium and with nothing between them: radius at most
    /// max(`relative` · 𝓕, `absolute` · the smaller area) where rounding allows. The same bits in either order.
    pub fn pair(&self, i: usize, j: usize, relative: f64, absolute: f64) -> Factor {
        let (a, b) = (&self.0[i.min(j)], &self.0[i.max(j)]);
        plate_pair::factor_without_medium(
            a,
            b,
            RadiusGoal { relative, absolute: absolute * a.area.min(b.area) },
        )
    }
}
