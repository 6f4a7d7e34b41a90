//! Tables of a grid's walls: patches are the outer faces of its cells, looking inwards.

use super::fill::{Family, Tally};
use super::index::Index;
use super::{Along, Images, Table};
use zonal_math::Bounded;

/// Factors of a grid's wall patches with its voxels (m³) or with patches of other walls (m²), by offset.
///
/// An offset has a component an axis: along a wall's normal the number of whole cells between the wall and the near side of
/// the voxel or patch (0 for what stands on the wall), along any other axis the difference of the cells' indices, of any sign.
#[derive(Clone, Debug)]
pub struct WallTable(Table);

impl WallTable {
    /// Voxels and the patches of a wall across `axis`; component `axis` of an offset is the voxel's distance in cells.
    ///
    /// Edges m, `kappa` 1/m; radii at most `tolerance` · value.
    ///
    /// # Panics
    /// As [`super::OffsetTable::new`]; on an axis above 2.
    pub fn voxels(edges: [f64; 3], counts: [usize; 3], axis: usize, kappa: f64, tolerance: f64) -> WallTable {
        let mut extents = edges.map(|e| (e, e));
        let mut shift = [0.0; 3];
        (extents[axis].1, shift[axis]) = (0.0, 0.5);
        let index = Index::odd(axis, edges[(axis + 1) % 3] == edges[(axis + 2) % 3], counts);
        WallTable(Table::new(index, &Family::new(extents, edges, shift, kappa, tolerance)))
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
        let index = Index::odd(axis, edges[(axis + 1) % 3] == edges[(axis + 2) % 3], folded);
        WallTable(Table::new(index, &Family::new(extents, edges, shift, kappa, tolerance)))
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
        let index = Index::odd(3 - axes[0] - axes[1], edges[axes[0]] == edges[axes[1]], counts);
        WallTable(Table::new(index, &Family::new(extents, edges, shift, kappa, tolerance)))
    }

    /// The tables of a grid that repeats itself along other axes than the walls' normals, as [`WallTable::voxels`],
    /// [`WallTable::opposite`] and [`WallTable::adjacent`] in turn: `normals` names one axis, two times the same one, or two.
    /// `counts` are the offsets wanted of each axis, each value the sum over its `images`; across opposite walls the count is the number of cells
    /// between them.
    ///
    /// # Panics
    /// As [`WallTable::voxels`].
    pub fn repeated(counts: [usize; 3], normals: &[usize], images: &Images) -> WallTable {
        let along = [0, 1, 2].map(|k| match normals.iter().filter(|&&a| a == k).count() {
            0 => Along::Between,
            1 => Along::Depth,
            _ => Along::Across,
        });
        WallTable(images.table(counts, along))
    }

    /// Largest radius over value; where the grid repeats itself, of what counts in a row.
    pub fn worst(&self) -> f64 {
        self.0.worst()
    }

    /// The factor at an offset.
    ///
    /// # Panics
    /// On an offset outside of the grid.
    pub fn get(&self, offset: [i64; 3]) -> Bounded {
        self.0.get(offset)
    }

    /// Distinct offsets kept.
    pub fn len(&self) -> usize {
        self.0.values.len()
    }

    /// False: there is one offset at least.
    pub fn is_empty(&self) -> bool {
        self.0.values.is_empty()
    }

    /// Which methods served how many entries.
    pub fn tally(&self) -> Tally {
        self.0.tally
    }
}
