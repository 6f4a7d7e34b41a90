//! Tables of a grid's walls: patches are the outer faces of its cells, looking inwards.

use super::offset_family::{MethodCounts, OffsetFamily};
use super::offset_index::OffsetIndex;
use super::pair_layout::{AxisRelation, PeriodicGrid};
use super::periodic;
use super::table::FactorTable;
use zonal_math::Bounded;

/// Factors of a grid's wall patches with its voxels (m³) or with patches of other walls (m²), by offset.
///
/// An offset has a component an axis: along a wall's normal the number of whole cells between the wall and the near side of
/// the voxel or patch (0 for a zone on the wall), along any other axis the difference of the cells' indices, of any sign.
#[derive(Clone, Debug)]
pub struct WallTable(FactorTable);

impl WallTable {
    /// Voxels and the patches of a wall across `axis`; component `axis` of an offset is the voxel's distance in cells.
    ///
    /// Edges m, `kappa` 1/m; radii at most `tolerance` · value.
    ///
    /// # Panics
    /// As [`OffsetTable::new`](super::OffsetTable::new); on an axis above 2.
    pub fn voxels(edges: [f64; 3], counts: [usize; 3], axis: usize, kappa: f64, tolerance: f64) -> WallTable {
        let mut extents = edges.map(|e| (e, e));
        let mut shift = [0.0; 3];
        (extents[axis].1, shift[axis]) = (0.0, 0.5);
        let index = OffsetIndex::with_odd_axis(axis, [edges[(axis + 1) % 3], edges[(axis + 2) % 3]], counts);
        WallTable(FactorTable::new(index, &OffsetFamily::new(extents, edges, shift, kappa, tolerance)))
    }

    /// Patches of the two walls across `axis`; component `axis` of an offset is zero.
    ///
    /// # Panics
    /// As [`WallTable::voxels`].
    pub fn opposite(
        edges: [f64; 3],
        counts: [usize; 3],
        axis: usize,
        kappa: f64,
        tolerance: f64,
    ) -> WallTable {
        let mut extents = edges.map(|e| (e, e));
        let (mut shift, mut folded) = ([0.0; 3], counts);
        (extents[axis], shift[axis], folded[axis]) = ((0.0, 0.0), counts[axis] as f64, 1);
        let index = OffsetIndex::with_odd_axis(axis, [edges[(axis + 1) % 3], edges[(axis + 2) % 3]], folded);
        WallTable(FactorTable::new(index, &OffsetFamily::new(extents, edges, shift, kappa, tolerance)))
    }

    /// Patches of two adjacent walls, across two different axes: component `axes[0]` of an offset is the distance in cells of the second wall's
    /// patch from the first wall, `axes[1]` the other way round.
    ///
    /// # Panics
    /// As [`WallTable::voxels`]; on equal axes.
    pub fn adjacent(
        edges: [f64; 3],
        counts: [usize; 3],
        axes: [usize; 2],
        kappa: f64,
        tolerance: f64,
    ) -> WallTable {
        assert!(axes[0] != axes[1] && axes[0] < 3 && axes[1] < 3, "axes {axes:?}");
        let mut extents = edges.map(|e| (e, e));
        let mut shift = [0.0; 3];
        for axis in axes {
            (extents[axis].1, shift[axis]) = (0.0, 0.5);
        }
        let index = OffsetIndex::with_odd_axis(3 - axes[0] - axes[1], axes.map(|k| edges[k]), counts);
        WallTable(FactorTable::new(index, &OffsetFamily::new(extents, edges, shift, kappa, tolerance)))
    }

    /// The tables of a grid that is periodic along other axes than the walls' normals, as [`WallTable::voxels`],
    /// [`WallTable::opposite`] and [`WallTable::adjacent`] in turn: `normals` names one axis, two times the same one, or two.
    /// `counts` are the numbers of offsets along each axis, each value the sum over its `images`; between opposite walls the count is the number
    /// of cells.
    ///
    /// # Panics
    /// As [`WallTable::voxels`].
    pub fn repeated(counts: [usize; 3], normals: &[usize], images: &PeriodicGrid) -> WallTable {
        let relations = [0, 1, 2].map(|k| match normals.iter().filter(|&&a| a == k).count() {
            0 => AxisRelation::Extended,
            1 => AxisRelation::OffWall,
            _ => AxisRelation::OppositeWalls,
        });
        WallTable(periodic::constant_basis_table(images, counts, relations))
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
