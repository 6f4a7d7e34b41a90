//! The tables of a grid that is not periodic.

use super::chunk_evaluator::{ChunkEvaluator, OneProcess};
use super::offset_family::OffsetFamily;
use super::offset_index::OffsetIndex;
use super::table::FactorTable;

/// Tables of a grid of `counts` voxels: every radius is at most `tolerance` · value, as for
/// [`geometric_factor`](crate::aligned::geometric_factor).
///
/// ```
/// use zonal_exchange::aligned::lattice::GridTables;
/// let grid = GridTables::new([0.1; 3], [8, 8, 8], 0.5, 1e-10);
/// let (near, far) = (grid.opposite(2).get([0, 0, 0]), grid.opposite(2).get([7, 7, 0]));
/// assert!(near.value > far.value && near.radius <= 1e-10 * near.value);
/// ```
#[derive(Clone, Copy)]
pub struct GridTables<'a> {
    edges: [f64; 3],
    counts: [usize; 3],
    kappa: f64,
    tolerance: f64,
    evaluator: &'a dyn ChunkEvaluator,
}

impl GridTables<'static> {
    /// Tables for voxels with these `edges` (m) and extinction `kappa` ≥ 0 (1/m), computed by rayon's threads.
    pub fn new(edges: [f64; 3], counts: [usize; 3], kappa: f64, tolerance: f64) -> GridTables<'static> {
        GridTables { edges, counts, kappa, tolerance, evaluator: &OneProcess }
    }
}

impl GridTables<'_> {
    /// The same tables, computed by `evaluator`.
    #[must_use]
    pub fn by(self, evaluator: &dyn ChunkEvaluator) -> GridTables<'_> {
        GridTables { evaluator, ..self }
    }

    /// Two voxels.
    ///
    /// # Panics
    /// On an edge or tolerance that is not positive and finite, a negative or infinite extinction, a count of zero or above 65,535.
    pub fn voxels(&self) -> FactorTable {
        let family = self.family(self.edges.map(|e| (e, e)), [0.0; 3]);
        FactorTable::new(OffsetIndex::of_edges(self.edges, self.counts), &family, self.evaluator)
    }

    /// Voxels and the patches of a wall across `axis`; component `axis` of an offset is the voxel's distance in cells.
    ///
    /// # Panics
    /// As [`GridTables::voxels`]; on an axis above 2.
    pub fn wall(&self, axis: usize) -> FactorTable {
        let mut extents = self.edges.map(|e| (e, e));
        let mut shift = [0.0; 3];
        (extents[axis].1, shift[axis]) = (0.0, 0.5);
        let index = OffsetIndex::with_odd_axis(axis, self.others(axis), self.counts);
        FactorTable::new(index, &self.family(extents, shift), self.evaluator)
    }

    /// Patches of the two walls across `axis`; component `axis` of an offset is zero.
    ///
    /// # Panics
    /// As [`GridTables::wall`].
    pub fn opposite(&self, axis: usize) -> FactorTable {
        let mut extents = self.edges.map(|e| (e, e));
        let (mut shift, mut folded) = ([0.0; 3], self.counts);
        (extents[axis], shift[axis], folded[axis]) = ((0.0, 0.0), self.counts[axis] as f64, 1);
        let index = OffsetIndex::with_odd_axis(axis, self.others(axis), folded);
        FactorTable::new(index, &self.family(extents, shift), self.evaluator)
    }

    /// Patches of two adjacent walls, across two different axes: component `axes[0]` of an offset is the distance in cells of the second wall's
    /// patch from the first wall, `axes[1]` the other way round.
    ///
    /// # Panics
    /// As [`GridTables::wall`]; on equal axes.
    pub fn adjacent(&self, axes: [usize; 2]) -> FactorTable {
        assert!(axes[0] != axes[1] && axes[0] < 3 && axes[1] < 3, "axes {axes:?}");
        let mut extents = self.edges.map(|e| (e, e));
        let mut shift = [0.0; 3];
        for axis in axes {
            (extents[axis].1, shift[axis]) = (0.0, 0.5);
        }
        let edges = axes.map(|k| self.edges[k]);
        let index = OffsetIndex::with_odd_axis(3 - axes[0] - axes[1], edges, self.counts);
        FactorTable::new(index, &self.family(extents, shift), self.evaluator)
    }

    /// Edges along the axes of a wall across `axis`.
    fn others(&self, axis: usize) -> [f64; 2] {
        [self.edges[(axis + 1) % 3], self.edges[(axis + 2) % 3]]
    }

    fn family(&self, extents: [(f64, f64); 3], shift: [f64; 3]) -> OffsetFamily {
        OffsetFamily::new(extents, self.edges, shift, self.kappa, self.tolerance)
    }
}
