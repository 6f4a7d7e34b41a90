//! Periodic scenes: the exchange of two zones is the exchange of one with all images of the other.
//!
//! A periodic scene is a box on the grid of its medium. Its zones are cells and faces of cells, and tables by offset (`aligned/lattice/periodic.rs`)
//! hold every factor. Memory is that of the distinct offsets, for any extinction. The factor of a zone that is neither a cell nor a face is unknown.

use crate::aligned::Cuboid;
use crate::aligned::lattice::{self, FactorTable, OneProcess};
use zonal_math::{Bounded, Vec3};
use zonal_scene::Scene;

/// Largest deviation of a zone from the grid that counts as rounding, in edges of a cell.
const MAX_GRID_DEVIATION: f64 = 1e-6;

/// The factors of a periodic grid.
pub(super) struct PeriodicFactors {
    min: Vec3,
    cells: [usize; 3],
    edges: [f64; 3],
    periodic: [bool; 3],
    /// One set of tables per distinct extinction, 1/m.
    tables: Vec<(f64, ExtinctionTables)>,
}

/// The factors for one extinction: voxels, walls across each axis with voxels and with the walls opposite, and adjacent walls across the axes (0, 1),
/// (0, 2), (1, 2).
struct ExtinctionTables {
    voxels: FactorTable,
    walls: [Option<FactorTable>; 3],
    opposite: [Option<FactorTable>; 3],
    adjacent: [Option<FactorTable>; 3],
}

/// A cell, or its face on the wall across an axis, low (0) or high (1).
type GridPosition = ([usize; 3], Option<(usize, usize)>);

impl PeriodicFactors {
    /// The factors of a periodic scene; none of any other.
    pub(super) fn of(scene: &Scene) -> Option<PeriodicFactors> {
        let grid = scene.voxel_grid().filter(|_| scene.is_periodic())?;
        let (cells, edges, periodic) = (grid.dims(), grid.cell().array(), scene.periodic());
        let mut out = PeriodicFactors { min: grid.min(), cells, edges, periodic, tables: Vec::new() };
        for kappa in grid.uniform_extinction()? {
            if !out.tables.iter().any(|t| t.0 == kappa) {
                out.tables.push((kappa, out.tables(kappa)));
            }
        }
        Some(out)
    }

    fn tables(&self, kappa: f64) -> ExtinctionTables {
        let period = [0, 1, 2].map(|k| self.periodic[k].then_some(self.cells[k]));
        let counts = [0, 1, 2].map(|k| if self.periodic[k] { self.cells[k] / 2 + 1 } else { self.cells[k] });
        let images = lattice::PeriodicGrid::new(period, self.edges, kappa);
        let table = |normals: &[usize]| {
            let stand = normals.iter().all(|&a| !self.periodic[a]);
            stand.then(|| FactorTable::repeated(counts, normals, &images, &OneProcess))
        };
        ExtinctionTables {
            voxels: FactorTable::repeated(counts, &[], &images, &OneProcess),
            walls: [0, 1, 2].map(|a| table(&[a])),
            opposite: [0, 1, 2].map(|a| table(&[a, a])),
            adjacent: [[0, 1], [0, 2], [1, 2]].map(|pair| table(&pair)),
        }
    }

    /// The position of a zone that lies on the grid.
    fn grid_position(&self, c: &Cuboid) -> Option<GridPosition> {
        let whole = |x: f64, k: usize| {
            let n = (x - self.min[k]) / self.edges[k];
            ((n - n.round()).abs() <= MAX_GRID_DEVIATION && n.round() >= 0.0).then(|| n.round() as usize)
        };
        let mut cell = [0; 3];
        for k in 0..3 {
            let (lo, hi) = (whole(c.lo[k], k)?, whole(c.hi[k], k)?);
            let fits = match c.normal {
                Some((axis, sign)) if axis == k => {
                    hi == lo && lo == if sign > 0 { 0 } else { self.cells[k] } && !self.periodic[k]
                }
                _ => hi == lo + 1 && hi <= self.cells[k],
            };
            if !fits {
                return None;
            }
            cell[k] = lo.min(self.cells[k] - 1);
        }
        Some((cell, c.normal.map(|(axis, sign)| (axis, usize::from(sign < 0)))))
    }

    /// The factor of `a` with all images of `b`, for one of the scene's extinctions `kappa` (1/m).
    pub(super) fn sum(&self, a: &Cuboid, b: &Cuboid, kappa: f64) -> Bounded {
        self.tabulated(a, b, kappa).unwrap_or(Bounded::estimated(0.0, f64::INFINITY))
    }

    fn tabulated(&self, a: &Cuboid, b: &Cuboid, kappa: f64) -> Option<Bounded> {
        let tables = &self.tables.iter().find(|t| t.0 == kappa)?.1;
        let ((i, wall), (j, other)) = (self.grid_position(a)?, self.grid_position(b)?);
        let mut d = [0, 1, 2].map(|k| {
            let d = i[k].abs_diff(j[k]);
            (if self.periodic[k] { d.min(self.cells[k] - d) } else { d }) as i64
        });
        // Cells between a wall and a cell.
        let off = |(axis, side): (usize, usize), cell: [usize; 3]| {
            (if side == 0 { cell[axis] } else { self.cells[axis] - 1 - cell[axis] }) as i64
        };
        match (wall, other) {
            (None, None) => Some(tables.voxels.get(d)),
            (Some(w), None) | (None, Some(w)) => {
                d[w.0] = off(w, if wall.is_some() { j } else { i });
                tables.walls[w.0].as_ref().map(|t| t.get(d))
            }
            (Some(v), Some(w)) if v == w => Some(Bounded::proved(0.0, 0.0)),
            (Some(v), Some(w)) if v.0 == w.0 => {
                d[v.0] = 0;
                tables.opposite[v.0].as_ref().map(|t| t.get(d))
            }
            (Some(v), Some(w)) => {
                (d[v.0], d[w.0]) = (off(v, j), off(w, i));
                tables.adjacent[v.0 + w.0 - 1].as_ref().map(|t| t.get(d))
            }
        }
    }
}
