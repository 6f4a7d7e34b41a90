//! Tables of the factors of a grid's voxels.

use super::chunk_evaluator::ChunkEvaluator;
use super::offset_family::MethodCounts;
use super::pair_layout::{AxisRelation, PeriodicGrid};
use super::periodic;
use super::table::FactorTable;
use zonal_math::Bounded;

/// Voxel–voxel factors of a regular voxel grid (m⁴), by offset.
///
/// ```
/// use zonal_exchange::aligned::lattice::GridTables;
/// let table = GridTables::new([0.1; 3], [20, 20, 20], 0.0, 1e-10).voxels();
/// let f = table.get([3, -1, 2]);
/// assert!(f.radius <= 1e-10 * f.value && f == table.get([-2, 3, 1]));
/// ```
#[derive(Clone, Debug)]
pub struct OffsetTable(pub(super) FactorTable);

impl OffsetTable {
    /// The table of a periodic voxel grid: `counts` offsets, each value the sum over its `images`, which hold edges and extinction.
    /// Relative radii are 2e-13; they grow for offsets longer than 30 mean free paths, which are negligible in a row sum. Without extinction
    /// the sum diverges for two periodic axes and is given as 0: such voxels do not emit.
    ///
    /// # Panics
    /// As [`GridTables::voxels`](super::GridTables::voxels).
    pub fn repeated(
        counts: [usize; 3],
        images: &PeriodicGrid,
        evaluator: &dyn ChunkEvaluator,
    ) -> OffsetTable {
        OffsetTable(periodic::constant_basis_table(images, counts, [AxisRelation::Extended; 3], evaluator))
    }

    /// Largest relative radius; of a periodic grid weighted by the share of a row sum.
    pub fn worst_relative_radius(&self) -> f64 {
        self.0.worst_relative_radius()
    }

    /// The factor of two voxels whose indices differ by `offset`, each |component| below its count.
    ///
    /// # Panics
    /// On an offset outside of the voxel grid.
    pub fn get(&self, offset: [i64; 3]) -> Bounded {
        self.0.get(offset)
    }

    /// Number of distinct offsets.
    pub fn len(&self) -> usize {
        self.0.values.len()
    }

    /// False: a table has at least the offset zero.
    pub fn is_empty(&self) -> bool {
        self.0.values.is_empty()
    }

    /// Number of entries by method.
    pub fn method_counts(&self) -> MethodCounts {
        self.0.counts
    }
}
