//! Tables of the factors of a grid's voxels.

use super::offset_family::{MethodCounts, OffsetFamily};
use super::offset_index::OffsetIndex;
use super::pair_layout::{AxisRelation, PeriodicGrid};
use super::periodic;
use super::table::FactorTable;
use zonal_math::Bounded;

/// Voxel–voxel factors of a regular voxel grid (m⁴), by offset.
///
/// ```
/// use zonal_exchange::aligned::lattice::OffsetTable;
/// let table = OffsetTable::new([0.1; 3], [20, 20, 20], 0.0, 1e-10);
/// let f = table.get([3, -1, 2]);
/// assert!(f.radius <= 1e-10 * f.value && f == table.get([-2, 3, 1]));
/// ```
#[derive(Clone, Debug)]
pub struct OffsetTable(pub(super) FactorTable);

impl OffsetTable {
    /// The table of a voxel grid of `counts` voxels with these `edges` (m), for extinction `kappa` ≥ 0 (1/m); every radius is
    /// at most `tolerance` · value, as for [`geometric_factor`](crate::aligned::geometric_factor). Runs on rayon's threads.
    ///
    /// # Panics
    /// On an edge or tolerance that is not positive and finite, a negative or infinite `kappa`, a count of zero or above 65,535.
    pub fn new(edges: [f64; 3], counts: [usize; 3], kappa: f64, tolerance: f64) -> OffsetTable {
        let family = OffsetFamily::new(edges.map(|e| (e, e)), edges, [0.0; 3], kappa, tolerance);
        OffsetTable(FactorTable::new(OffsetIndex::of_edges(edges, counts), &family))
    }

    /// The table of a periodic voxel grid: `counts` offsets, each value the sum over its `images`, which hold edges and extinction.
    /// Relative radii are 2e-13; they grow for offsets longer than 30 mean free paths, which are negligible in a row sum. Without extinction
    /// the sum diverges for two periodic axes and is given as 0: such voxels do not emit.
    ///
    /// # Panics
    /// As [`OffsetTable::new`].
    pub fn repeated(counts: [usize; 3], images: &PeriodicGrid) -> OffsetTable {
        OffsetTable(periodic::constant_basis_table(images, counts, [AxisRelation::Extended; 3]))
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
