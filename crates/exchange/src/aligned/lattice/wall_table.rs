//! Tables of a grid's walls: patches are the outer faces of its cells, looking inwards.

use super::chunk_evaluator::ChunkEvaluator;
use super::offset_family::MethodCounts;
use super::pair_layout::{AxisRelation, PeriodicGrid};
use super::periodic;
use super::table::FactorTable;
use zonal_math::Bounded;

/// Factors of a grid's wall patches with its voxels (m³) or with patches of other walls (m²), by offset.
///
/// An offset has a component an axis: along a wall's normal the number of whole cells between the wall and the near side of
/// the voxel or patch (0 for a zone on the wall), along any other axis the difference of the cells' indices, of any sign.
#[derive(Clone, Debug)]
pub struct WallTable(pub(super) FactorTable);

impl WallTable {
    /// The tables of a grid that is periodic along other axes than the walls' normals, as [`GridTables::wall`](super::GridTables::wall),
    /// [`GridTables::opposite`](super::GridTables::opposite) and [`GridTables::adjacent`](super::GridTables::adjacent) in turn: `normals` names one axis, two times the same one, or two.
    /// `counts` are the numbers of offsets along each axis, each value the sum over its `images`; between opposite walls the count is the number
    /// of cells.
    ///
    /// # Panics
    /// As [`GridTables::voxels`](super::GridTables::voxels).
    pub fn repeated(
        counts: [usize; 3],
        normals: &[usize],
        images: &PeriodicGrid,
        evaluator: &dyn ChunkEvaluator,
    ) -> WallTable {
        let relations = [0, 1, 2].map(|k| match normals.iter().filter(|&&a| a == k).count() {
            0 => AxisRelation::Extended,
            1 => AxisRelation::OffWall,
            _ => AxisRelation::OppositeWalls,
        });
        WallTable(periodic::constant_basis_table(images, counts, relations, evaluator))
    }

    /// Largest relative radius; of a periodic grid weighted by the share of a row sum.
    pub fn worst_relative_radius(&self) -> f64 {
        self.0.worst_relative_radius()
    }

    /// The factor at an offset.
    ///
    /// # Panics
    /// On an offset outside of the grid.
    pub fn get(&self, offset: [i64; 3]) -> Bounded {
        self.0.get(offset)
    }

    /// Number of distinct offsets.
    pub fn len(&self) -> usize {
        self.0.values.len()
    }

    /// False: a table has at least one offset.
    pub fn is_empty(&self) -> bool {
        self.0.values.is_empty()
    }

    /// Number of entries by method.
    pub fn method_counts(&self) -> MethodCounts {
        self.0.counts
    }
}
