//! Factors of periodic grids: the factor of an offset d is the sum over its images,
//!
//! ```text
//!     Σ_m 𝓕(d + m ∘ n),      m an integer along each periodic axis, n the cells of a period.
//! ```
//!
//! `gaussian_sums.rs` computes it for any extinction at a cost that does not depend on the number of images. The images of a cell whose period
//! is one cell are the cells of a row.

use super::chunk_evaluator::ChunkEvaluator;
use super::gaussian_sums::{RELATIVE_RADIUS, step_error};
use super::offset_family::MethodCounts;
use super::offset_index::OffsetIndex;
use super::pair_layout::{AxisRelation, LinearBasisPairs, PeriodicGrid, TableAccuracy};
use super::table::FactorTable;

impl FactorTable {
    /// The table of a grid that is periodic along axes without walls, as [`GridTables::voxels`](super::GridTables::voxels),
    /// [`GridTables::wall`](super::GridTables::wall), [`GridTables::opposite`](super::GridTables::opposite) and
    /// [`GridTables::adjacent`](super::GridTables::adjacent) in turn: `normals` names no axis, one, two times the same one, or two.
    /// `counts` are the numbers of offsets along each axis, each value the sum over its `images`, which hold edges and extinction; between opposite walls
    /// the count is the number of cells. Relative radii are 2e-13; they grow for offsets longer than 30 mean free paths, which are negligible in a row sum.
    /// Without extinction the sum of two voxels diverges for two periodic axes and is given as 0: such voxels do not emit.
    ///
    /// # Panics
    /// As [`GridTables::voxels`](super::GridTables::voxels).
    pub fn repeated(
        counts: [usize; 3],
        normals: &[usize],
        images: &PeriodicGrid,
        evaluator: &dyn ChunkEvaluator,
    ) -> FactorTable {
        let relations = [0, 1, 2].map(|k| match normals.iter().filter(|&&a| a == k).count() {
            0 => AxisRelation::Extended,
            1 => AxisRelation::OffWall,
            _ => AxisRelation::OppositeWalls,
        });
        constant_basis_table(images, counts, relations, evaluator)
    }
}

/// The table of constant radiosity; `counts` and `relations` as in [`LinearBasisPairs`].
fn constant_basis_table(
    grid: &PeriodicGrid,
    counts: [usize; 3],
    relations: [AxisRelation; 3],
    evaluator: &dyn ChunkEvaluator,
) -> FactorTable {
    let pairs = LinearBasisPairs {
        edges: grid.edges,
        counts,
        along: relations,
        kappa: grid.kappa,
        images: grid,
        accuracy: TableAccuracy::Full,
    };
    let mut tables = pairs.tables(&[[0; 3]], evaluator);
    let index = OffsetIndex::plain(pairs.slots());
    let values = tables.swap_remove(0);
    // The nearest image of each offset, in mean free paths.
    let near = |k: usize, d: usize| match relations[k] {
        AxisRelation::OppositeWalls => counts[k] as f64,
        AxisRelation::OffWall => d as f64,
        AxisRelation::Extended => {
            let d = grid.period[k].map_or(d, |n| d.min(n - d.min(n)));
            d.saturating_sub(1) as f64
        }
    };
    let depth = |o: &[u16; 3]| {
        let r = (0..3).map(|k| (near(k, o[k] as usize) * grid.edges[k]).powi(2)).sum::<f64>().sqrt();
        grid.kappa * r
    };
    let depths: Vec<f64> = index.offsets(0..index.len()).iter().map(depth).collect();
    let radii = values.iter().zip(&depths).map(|(v, d)| v * (RELATIVE_RADIUS + step_error(*d))).collect();
    // In a row sum a far entry weighs e^{−κr} or less.
    let worst =
        depths.iter().map(|d| RELATIVE_RADIUS + step_error(*d) * (-0.5 * d).exp()).fold(0.0, f64::max);
    let method_counts = MethodCounts { gaussians: values.len(), ..MethodCounts::default() };
    FactorTable { index, values, radii, counts: method_counts, worst_relative: Some(worst) }
}

#[cfg(test)]
mod tests {
    use super::super::chunk_evaluator::OneProcess;
    use super::super::grid_tables::GridTables;
    use super::*;

    #[test]
    fn periodic_table_equals_sum_over_plain_table() {
        let (edges, kappa) = ([0.5, 0.4, 0.3], 9.0);
        let images = PeriodicGrid::new([Some(4), Some(3), None], edges, kappa);
        let table = FactorTable::repeated([3, 2, 5], &[], &images, &OneProcess);
        let plain = GridTables::new(edges, [14, 15, 5], kappa, 1e-12).voxels();
        for (d, e) in [([0, 0, 0], [0, 0, 0]), ([2, 1, 4], [2, 1, 4]), ([1, 0, 2], [1, 0, 2])] {
            let mut sum = 0.0;
            for m in -3i64..=3 {
                for k in -4i64..=4 {
                    let at = [d[0] + 4 * m, d[1] + 3 * k, d[2]];
                    if at[0].abs() < 14 && at[1].abs() < 15 {
                        sum += plain.get(at).value;
                    }
                }
            }
            let got = table.get(e);
            assert!((got.value - sum).abs() < 1.5e-12 * sum, "{d:?}: {got:?} {sum}");
        }
    }

    #[test]
    fn period_of_one_cell_equals_sum_over_longer_period() {
        // A period of one cell against the sum over cells of a period of two, of which every second is at an odd distance.
        let (edges, kappa) = ([0.5, 0.4, 0.3], 9.0);
        let one = PeriodicGrid::new([Some(1), None, None], edges, kappa);
        let two = PeriodicGrid::new([Some(2), None, None], edges, kappa);
        let a = FactorTable::repeated([1, 3, 3], &[], &one, &OneProcess);
        let b = FactorTable::repeated([2, 3, 3], &[], &two, &OneProcess);
        for at in [[0, 0, 0], [0, 1, 0], [0, 2, 2]] {
            let sum = b.get(at).value + b.get([1, at[1], at[2]]).value;
            assert!((a.get(at).value / sum - 1.0).abs() < 1e-12, "{at:?}: {:?} {sum}", a.get(at));
        }
    }

    /// A box whose voxels and walls are zones.
    struct PeriodicBox {
        cells: [usize; 3],
        periodic: [bool; 3],
        edges: [f64; 3],
        kappa: f64,
    }

    impl PeriodicBox {
        fn grid(&self) -> PeriodicGrid {
            let period = [0, 1, 2].map(|k| self.periodic[k].then_some(self.cells[k]));
            PeriodicGrid::new(period, self.edges, self.kappa)
        }

        fn counts(&self) -> [usize; 3] {
            [0, 1, 2].map(|k| if self.periodic[k] { self.cells[k] / 2 + 1 } else { self.cells[k] })
        }

        fn all(&self) -> impl Iterator<Item = [usize; 3]> + use<> {
            let [n0, n1, n2] = self.cells;
            (0..n0 * n1 * n2).map(move |i| [i / n2 / n1, i / n2 % n1, i % n2])
        }

        /// Least offset of two cells along each axis.
        fn offset(&self, at: [usize; 3], to: [usize; 3]) -> [i64; 3] {
            [0, 1, 2].map(|k| {
                let d = at[k].abs_diff(to[k]);
                if self.periodic[k] { d.min(self.cells[k] - d) as i64 } else { d as i64 }
            })
        }

        /// Adds the incident power of the wall across axis `a` to each voxel.
        fn add_wall_to_voxels(&self, a: usize, table: &FactorTable, of_voxels: &mut [f64]) {
            for (i, at) in self.all().enumerate() {
                for to in self.all().filter(|to| to[a] == 0) {
                    let mut d = self.offset(at, to);
                    for height in [at[a], self.cells[a] - 1 - at[a]] {
                        d[a] = height as i64;
                        of_voxels[i] += table.get(d).value;
                    }
                }
            }
        }

        /// Incident power of each patch of the wall across axis `a`.
        fn wall_rows(&self, a: usize, walls: &[usize], table: &FactorTable) -> Vec<f64> {
            let (counts, images) = (self.counts(), self.grid());
            let opposite = FactorTable::repeated(counts, &[a, a], &images, &OneProcess);
            let others = walls.iter().filter(|&&b| b != a);
            let corners: Vec<(usize, FactorTable)> =
                others.map(|&b| (b, FactorTable::repeated(counts, &[a, b], &images, &OneProcess))).collect();
            let row = |at: [usize; 3]| {
                let mut row = 0.0;
                for to in self.all() {
                    let mut d = self.offset(at, to);
                    d[a] = to[a] as i64;
                    row += self.kappa * table.get(d).value;
                    if to[a] == 0 {
                        d[a] = 0;
                        row += opposite.get(d).value;
                    }
                }
                for (b, adjacent) in &corners {
                    for to in self.all().filter(|to| to[*b] == 0) {
                        let mut d = self.offset(at, to);
                        for side in [at[*b], self.cells[*b] - 1 - at[*b]] {
                            (d[a], d[*b]) = (to[a] as i64, side as i64);
                            row += adjacent.get(d).value;
                        }
                    }
                }
                row
            };
            self.all().filter(|at| at[a] == 0).map(row).collect()
        }

        /// Closure defects of a uniform scaled radiosity of one: incident power over A of each wall patch and over 4V of each voxel, less one.
        fn defects(&self) -> Vec<f64> {
            let voxels = FactorTable::repeated(self.counts(), &[], &self.grid(), &OneProcess);
            let walls: Vec<usize> = (0..3).filter(|&k| !self.periodic[k]).collect();
            let mut of_voxels = vec![0.0; self.cells.iter().product()];
            for (i, at) in self.all().enumerate() {
                for to in self.all() {
                    of_voxels[i] += self.kappa * voxels.get(self.offset(at, to)).value;
                }
            }
            let mut defects: Vec<f64> = Vec::new();
            for &a in &walls {
                let table = FactorTable::repeated(self.counts(), &[a], &self.grid(), &OneProcess);
                let area = (0..3).filter(|&k| k != a).map(|k| self.edges[k]).product::<f64>();
                self.add_wall_to_voxels(a, &table, &mut of_voxels);
                defects.extend(self.wall_rows(a, &walls, &table).iter().map(|row| row / area - 1.0));
            }
            let volume = 4.0 * self.edges.iter().product::<f64>();
            defects.extend(of_voxels.iter().map(|x| x / volume - 1.0));
            defects
        }
    }

    // Guards (numbers): rows of periodic grids close at every extinction, including 0.
    #[test]
    fn periodic_rows_close_at_every_extinction() {
        let slab = [true, true, false];
        let cases = [
            ([1, 1, 6], slab, [0.7, 1.1, 0.25]),
            ([1, 1, 1], slab, [1.0; 3]),
            ([4, 3, 7], slab, [0.3, 0.5, 0.2]),
            ([4, 3, 5], [false, true, true], [0.3, 5.0, 0.02]),
            ([3, 4, 2], [false, true, false], [0.3, 0.5, 0.2]),
            ([2, 3, 1], [true, false, false], [8.0, 0.5, 1.2]),
        ];
        for (cells, periodic, edges) in cases {
            for kappa in [0.0, 1e-300, 1e-30, 1e-12, 1e-9, 1e-6, 1e-3, 0.03, 0.5, 4.0, 30.0, 300.0] {
                let worst = PeriodicBox { cells, periodic, edges, kappa }
                    .defects()
                    .iter()
                    .fold(0.0f64, |m, d| m.max(d.abs()));
                assert!(worst < 4e-13, "{cells:?} {periodic:?} {kappa:e}: {worst:e}");
            }
        }
    }

    #[test]
    fn transparent_slab_has_limiting_factors() {
        // The view factor of opposite walls is 1; each wall is half of the surroundings of a voxel layer.
        let images = PeriodicGrid::new([Some(1), Some(1), None], [0.7, 1.1, 0.25], 0.0);
        let area = 0.7 * 1.1;
        let opposite = FactorTable::repeated([1, 1, 6], &[2, 2], &images, &OneProcess).get([0, 0, 0]);
        assert!((opposite.value / area - 1.0).abs() < opposite.radius / area, "{opposite:?}");
        let layer = FactorTable::repeated([1, 1, 6], &[2], &images, &OneProcess).get([0, 0, 4]);
        assert!((layer.value / (2.0 * area * 0.25) - 1.0).abs() < 2e-13, "{layer:?}");
        assert_eq!(FactorTable::repeated([1, 1, 6], &[], &images, &OneProcess).get([0, 0, 3]).value, 0.0);
    }

    #[test]
    fn opposite_walls_of_slab_equal_exponential_integral() {
        // Opposite walls: 2 E₃(κL) A.
        for kappa in [1e-6, 1e-3, 0.1, 1.0, 5.0] {
            let images = PeriodicGrid::new([Some(3), Some(2), None], [0.7, 1.1, 0.25], kappa);
            let table = FactorTable::repeated([2, 2, 6], &[2, 2], &images, &OneProcess);
            let sum: f64 = (0..3)
                .flat_map(|i| (0..2).map(move |j| [[0, 1, 1][i], j, 0]))
                .map(|d: [i64; 3]| table.get(d).value)
                .sum();
            let want = 2.0 * zonal_math::exponential_integral::e3(1.5 * kappa) * 0.77;
            assert!((sum - want).abs() < 3e-14, "{kappa}: {sum} {want}");
        }
    }
}
