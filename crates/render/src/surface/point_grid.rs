//! Cells of a uniform hash grid.

use zonal_math::Vec3;

/// The cell, of edge `cell` (m), that contains a point.
pub(crate) fn cell_of(p: Vec3, cell: f64) -> [i64; 3] {
    p.array().map(|x| (x / cell).floor() as i64)
}
