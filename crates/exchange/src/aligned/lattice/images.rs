//! Grids that repeat themselves: the factor of an offset d is the sum over its images,
//!
//! ```text
//!     Σ_m 𝓕(d + m ∘ n),      m an integer along each periodic axis, n the cells of a period.
//! ```
//!
//! `gaussians.rs` computes it, for any extinction, without counting images. The images of a cell whose period is one cell are the cells of a row.

use super::gaussians::{RADIUS, step};
use super::index::Index;
use super::linear::{Along, Linear};
use super::{Table, Tally};

/// How a grid repeats itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Images {
    /// Cells of a period along each axis; `None` where the grid ends.
    pub period: [Option<usize>; 3],
    /// Edges of a cell, m.
    pub edges: [f64; 3],
    /// Extinction, 1/m.
    pub kappa: f64,
}

impl Images {
    /// Of a grid with extinction `kappa` ≥ 0 (1/m).
    pub fn new(period: [Option<usize>; 3], edges: [f64; 3], kappa: f64) -> Images {
        Images { period, edges, kappa }
    }

    /// True where an axis repeats itself.
    pub fn any(&self) -> bool {
        self.period.iter().any(Option::is_some)
    }

    /// The table of constant radiosity of zones that lie as `along` says; `counts` as in [`Linear`].
    pub(super) fn table(&self, counts: [usize; 3], along: [Along; 3]) -> Table {
        let pairs = Linear { edges: self.edges, counts, along, kappa: self.kappa, images: self };
        let mut tables = pairs.tables(&[[0; 3]]);
        let index = Index::plain(pairs.slots());
        let values = tables.swap_remove(0);
        // The nearest image of each offset, in mean free paths.
        let near = |k: usize, d: usize| match along[k] {
            Along::Across => counts[k] as f64,
            Along::Depth => d as f64,
            Along::Between => {
                let d = self.period[k].map_or(d, |n| d.min(n - d.min(n)));
                d.saturating_sub(1) as f64
            }
        };
        let depth = |o: &[u16; 3]| {
            let r = (0..3).map(|k| (near(k, o[k] as usize) * self.edges[k]).powi(2)).sum::<f64>().sqrt();
            self.kappa * r
        };
        let depths: Vec<f64> = index.offsets().iter().map(depth).collect();
        let radii = values.iter().zip(&depths).map(|(v, d)| v * (RADIUS + step(*d))).collect();
        // Far ones weigh less in a row, e^{−κr} and more.
        let relative = depths.iter().map(|d| RADIUS + step(*d) * (-0.5 * d).exp()).fold(0.0, f64::max);
        let tally = Tally { gaussians: values.len(), ..Tally::default() };
        Table { index, values, radii, tally, relative: Some(relative) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{OffsetTable, WallTable};
    use super::*;

    #[test]
    fn sums_are_those_of_the_plain_tables() {
        let (edges, kappa) = ([0.5, 0.4, 0.3], 9.0);
        let images = Images::new([Some(4), Some(3), None], edges, kappa);
        let table = OffsetTable::repeated([3, 2, 5], &images);
        let plain = OffsetTable::new(edges, [14, 15, 5], kappa, 1e-12);
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
    fn a_row_of_images_is_one_box() {
        // A period of one cell against the sum over cells of a period of two, of which every second is at an odd distance.
        let (edges, kappa) = ([0.5, 0.4, 0.3], 9.0);
        let one = Images::new([Some(1), None, None], edges, kappa);
        let two = Images::new([Some(2), None, None], edges, kappa);
        let a = OffsetTable::repeated([1, 3, 3], &one);
        let b = OffsetTable::repeated([2, 3, 3], &two);
        for at in [[0, 0, 0], [0, 1, 0], [0, 2, 2]] {
            let sum = b.get(at).value + b.get([1, at[1], at[2]]).value;
            assert!((a.get(at).value / sum - 1.0).abs() < 1e-12, "{at:?}: {:?} {sum}", a.get(at));
        }
    }

    /// A level field of strength one: what arrives at a patch of the wall below and at a voxel of each layer, over A and 4V less one.
    fn defects(cells: [usize; 3], periodic: [bool; 3], edges: [f64; 3], kappa: f64) -> Vec<f64> {
        let period = [0, 1, 2].map(|k| periodic[k].then_some(cells[k]));
        let counts = [0, 1, 2].map(|k| if periodic[k] { cells[k] / 2 + 1 } else { cells[k] });
        let images = Images::new(period, edges, kappa);
        let walls: Vec<usize> = (0..3).filter(|&k| !periodic[k]).collect();
        let voxels = OffsetTable::repeated(counts, &images);
        // Distance along a periodic axis, and all cells.
        let fold = |k: usize, d: usize| if periodic[k] { d.min(cells[k] - d) } else { d } as i64;
        let all = || {
            let [n0, n1, n2] = cells;
            (0..n0 * n1 * n2).map(move |i| [i / n2 / n1, i / n2 % n1, i % n2])
        };
        let mut rows: Vec<f64> = Vec::new();
        let mut of_voxels = vec![0.0; cells.iter().product()];
        for (i, at) in all().enumerate() {
            for to in all() {
                let d = [0, 1, 2].map(|k| fold(k, at[k].abs_diff(to[k])));
                of_voxels[i] += kappa * voxels.get(d).value;
            }
        }
        let on = |at: &[usize; 3], a: usize| at[a] == 0;
        for &a in &walls {
            let table = WallTable::repeated(counts, &[a], &images);
            let opposite = WallTable::repeated(counts, &[a, a], &images);
            let area = (0..3).filter(|&k| k != a).map(|k| edges[k]).product::<f64>();
            for (i, at) in all().enumerate() {
                for to in all().filter(|to| on(to, a)) {
                    let mut d = [0, 1, 2].map(|k| fold(k, at[k].abs_diff(to[k])));
                    for height in [at[a], cells[a] - 1 - at[a]] {
                        d[a] = height as i64;
                        of_voxels[i] += table.get(d).value;
                    }
                }
            }
            let others = walls.iter().filter(|&&b| b != a);
            let corners: Vec<(usize, WallTable)> =
                others.map(|&b| (b, WallTable::repeated(counts, &[a, b], &images))).collect();
            for at in all().filter(|at| on(at, a)) {
                let mut row = 0.0;
                for to in all() {
                    let mut d = [0, 1, 2].map(|k| fold(k, at[k].abs_diff(to[k])));
                    d[a] = to[a] as i64;
                    row += kappa * table.get(d).value;
                    if on(&to, a) {
                        d[a] = 0;
                        row += opposite.get(d).value;
                    }
                }
                for (b, adjacent) in &corners {
                    for to in all().filter(|to| on(to, *b)) {
                        let mut d = [0, 1, 2].map(|k| fold(k, at[k].abs_diff(to[k])));
                        for side in [at[*b], cells[*b] - 1 - at[*b]] {
                            (d[a], d[*b]) = (to[a] as i64, side as i64);
                            row += adjacent.get(d).value;
                        }
                    }
                }
                rows.push(row / area - 1.0);
            }
        }
        let volume = 4.0 * edges.iter().product::<f64>();
        rows.extend(of_voxels.iter().map(|x| x / volume - 1.0));
        rows
    }

    #[test]
    fn rows_close_at_every_extinction() {
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
                let worst = defects(cells, periodic, edges, kappa).iter().fold(0.0f64, |m, d| m.max(d.abs()));
                assert!(worst < 4e-13, "{cells:?} {periodic:?} {kappa:e}: {worst:e}");
            }
        }
    }

    #[test]
    fn a_transparent_slab_has_its_limits() {
        // Walls with walls see each other whole; of a layer of voxels each wall is half of the surroundings.
        let images = Images::new([Some(1), Some(1), None], [0.7, 1.1, 0.25], 0.0);
        let area = 0.7 * 1.1;
        let opposite = WallTable::repeated([1, 1, 6], &[2, 2], &images).get([0, 0, 0]);
        assert!((opposite.value / area - 1.0).abs() < opposite.radius / area, "{opposite:?}");
        let layer = WallTable::repeated([1, 1, 6], &[2], &images).get([0, 0, 4]);
        assert!((layer.value / (2.0 * area * 0.25) - 1.0).abs() < 2e-13, "{layer:?}");
        assert_eq!(OffsetTable::repeated([1, 1, 6], &images).get([0, 0, 3]).value, 0.0);
    }

    #[test]
    fn a_slab_has_its_exponential_integrals() {
        // Opposite walls: 2 E₃(κL) A.
        for kappa in [1e-6, 1e-3, 0.1, 1.0, 5.0] {
            let images = Images::new([Some(3), Some(2), None], [0.7, 1.1, 0.25], kappa);
            let table = WallTable::repeated([2, 2, 6], &[2, 2], &images);
            let sum: f64 = (0..3)
                .flat_map(|i| (0..2).map(move |j| [[0, 1, 1][i], j, 0]))
                .map(|d: [i64; 3]| table.get(d).value)
                .sum();
            let want = 2.0 * zonal_math::special::e3(1.5 * kappa) * 0.77;
            assert!((sum - want).abs() < 3e-14, "{kappa}: {sum} {want}");
        }
    }
}
