//! The pairs of zones that a table holds: how both lie along each axis, the grid, its period.

/// Relative position of two zones along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisRelation {
    /// Both have an extent: the offset is the difference of their cells.
    Extended,
    /// One is a patch across this axis; the offset is the number of cells between it and the other.
    OffWall,
    /// Both are patches across this axis; the count is the number of cells between them.
    OppositeWalls,
}

/// Accuracy of the factors of a table for radiosity that is linear inside each cell; tables of periodic grids have full accuracy always.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TableAccuracy {
    /// About 1e-11 of the factor of a cell.
    #[default]
    Full,
    /// About 1e-8: for a solve that is compared with another one.
    Comparison,
}

/// The pairs of zones of a table, for radiosity that is linear inside each cell.
#[derive(Clone, Copy, Debug)]
pub struct LinearBasisPairs<'a> {
    /// Edges of a cell, m.
    pub edges: [f64; 3],
    /// Number of offsets along each axis; between opposite walls, the number of cells.
    pub counts: [usize; 3],
    /// Relative positions along the axes.
    pub along: [AxisRelation; 3],
    /// Extinction, 1/m.
    pub kappa: f64,
    /// The period of the grid.
    pub images: &'a PeriodicGrid,
    /// Accuracy of the factors.
    pub accuracy: TableAccuracy,
}

/// A grid with periods along some axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeriodicGrid {
    /// Cells of a period along each axis; `None` where the grid is not periodic.
    pub period: [Option<usize>; 3],
    /// Edges of a cell, m.
    pub edges: [f64; 3],
    /// Extinction, 1/m.
    pub kappa: f64,
}

impl PeriodicGrid {
    /// A grid with extinction `kappa` ≥ 0 (1/m).
    pub fn new(period: [Option<usize>; 3], edges: [f64; 3], kappa: f64) -> PeriodicGrid {
        PeriodicGrid { period, edges, kappa }
    }

    /// True if some axis is periodic.
    pub fn is_periodic(&self) -> bool {
        self.period.iter().any(Option::is_some)
    }
}

impl LinearBasisPairs<'_> {
    /// Number of cells of the lattice of t that [`LinearBasisPairs::tables`] integrates; of a periodic grid, number of offsets.
    pub fn cell_count(&self) -> f64 {
        self.slots().iter().map(|n| *n as f64).product()
    }

    pub(super) fn slots(&self) -> [usize; 3] {
        std::array::from_fn(|k| if self.along[k] == AxisRelation::OppositeWalls { 1 } else { self.counts[k] })
    }

    /// The number of patches in a pair.
    pub(super) fn patches(&self) -> usize {
        self.power().iter().sum::<i32>() as usize
    }

    /// Power of |t_k| in the numerator of the kernel: patches whose normal lies along axis k.
    pub(super) fn power(&self) -> [i32; 3] {
        self.along.map(|a| match a {
            AxisRelation::Extended => 0,
            AxisRelation::OffWall => 1,
            AxisRelation::OppositeWalls => 2,
        })
    }
}
