//! The mesh of a surface in its parameters, and the factors of its cells.

use std::ops::Range;
use zonal_exchange::Factor;

/// Edges of the cells of a mesh in the parameters of its surface, ascending.
#[derive(Clone, Debug, PartialEq)]
pub struct ParametricMesh {
    /// Edges along u.
    pub u: Vec<f64>,
    /// Edges along v.
    pub v: Vec<f64>,
}

impl ParametricMesh {
    /// A mesh of `n` by `m` equal cells between two corners (u, v).
    pub fn regular(lo: [f64; 2], hi: [f64; 2], n: usize, m: usize) -> ParametricMesh {
        let edges =
            |k: usize, n: usize| (0..=n).map(|i| lo[k] + (hi[k] - lo[k]) * i as f64 / n as f64).collect();
        ParametricMesh { u: edges(0, n), v: edges(1, m) }
    }

    /// Cells along u and along v.
    pub fn cells(&self) -> [usize; 2] {
        [self.u.len() - 1, self.v.len() - 1]
    }

    pub(super) fn patch(&self, j: usize, k: usize) -> [[f64; 2]; 2] {
        self.part(&(j..j + 1), &(k..k + 1))
    }

    pub(super) fn part(&self, js: &Range<usize>, ks: &Range<usize>) -> [[f64; 2]; 2] {
        [[self.u[js.start], self.u[js.end]], [self.v[ks.start], self.v[ks.end]]]
    }
}

/// The factor of a cell, or why there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CellFactor {
    /// 𝓕 with its proven radius, m²; exactly zero for a cell that B does not see. `evaluations` are those of the block divided by its cells.
    Factor(Factor),
    /// It sees a part of B, or the bounds cannot decide; left to another method.
    PartlyVisible,
    /// No polydisc fits between it and B, or the radius would exceed the value, or the budget was spent: left to another method.
    Near,
}

/// The factors of all cells of a mesh, with their cost.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshFactors {
    /// Row by row: the cell (j, k) at j·(cells along v) + k.
    pub cells: Vec<CellFactor>,
    /// Blocks, each with a reference of its own.
    pub references: usize,
    /// Number of series: one for each node of B and each reference.
    pub evaluations: u64,
}
