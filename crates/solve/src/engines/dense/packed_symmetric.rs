//! Packed symmetric matrices: the lower triangle is stored by rows, entry (i, j ≤ i) at i(i+1)/2 + j.
//!
//! The product y = M x reads every entry once: entry (i, j) adds M_ij x_j to y_i and M_ij x_i to y_j. Rows are divided into a
//! fixed number of blocks with partial sums of their own, which are added along a binary tree: the bits do not depend on the number of threads, nor on that of
//! the processes that share the rows. A process has the rows of consecutive blocks. It sends the sums of the largest subtrees that it has alone, and every
//! process adds those of all.
//!
//! Cost: bound by the memory bandwidth, 8 bytes an entry for n²/2 entries.

use super::row_blocks::{RowBlocks, packed_length};
use crate::distribution::Communicator;
use zonal_math::parallel;

/// A symmetric matrix in packed storage, or the rows of it that a process has.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PackedSymmetric {
    blocks: RowBlocks,
    entries: Vec<f64>,
}

impl PackedSymmetric {
    /// A zero matrix of `n` rows.
    pub(crate) fn zeros(n: usize) -> PackedSymmetric {
        PackedSymmetric::zeros_of(RowBlocks::all(n))
    }
    /// Zeros in the rows of one process.
    pub(crate) fn zeros_of(blocks: RowBlocks) -> PackedSymmetric {
        let entries = vec![0.0; blocks.entries(blocks.own_rows())];
        PackedSymmetric { blocks, entries }
    }
    /// The stored rows, row i of length i + 1, from the first one on.
    pub(crate) fn rows_mut(&mut self) -> Vec<&mut [f64]> {
        let mut rest = &mut self.entries[..];
        self.blocks
            .own_rows()
            .map(|i| {
                let (row, tail) = std::mem::take(&mut rest).split_at_mut(i + 1);
                rest = tail;
                row
            })
            .collect()
    }
    /// The stored row `i`.
    pub(crate) fn row(&self, i: usize) -> &[f64] {
        let start = packed_length(i) - packed_length(self.blocks.own_rows().start);
        &self.entries[start..start + i + 1]
    }

    /// M x for several right-hand sides at once, of a matrix with all its rows.
    pub(crate) fn apply<const K: usize>(&self, x: &[[f64; K]]) -> Vec<[f64; K]> {
        self.apply_on_ranks(x, &crate::distribution::SingleProcess)
    }

    /// M x for several right-hand sides at once, by the rows of all processes.
    pub(crate) fn apply_on_ranks<const K: usize>(
        &self,
        x: &[[f64; K]],
        communicator: &dyn Communicator,
    ) -> Vec<[f64; K]> {
        assert_eq!(x.len(), self.blocks.rows());
        let own: Vec<usize> = self.blocks.own().collect();
        let partial = |b: usize| {
            let rows = self.blocks.rows_of(b);
            self.apply_rows(x, rows.start, rows.end)
        };
        let partial: Vec<Vec<[f64; K]>> = parallel::map(&own, |b| partial(*b));
        self.blocks.sum(partial, communicator, [0.0; K], |a, b| std::array::from_fn(|k| a[k] + b[k]))
    }

    fn apply_rows<const K: usize>(&self, x: &[[f64; K]], from: usize, to: usize) -> Vec<[f64; K]> {
        let mut y = vec![[0.0; K]; to];
        for i in from..to {
            let row = self.row(i);
            let xi = x[i];
            let mut own = [0.0; K];
            let (lower, rest) = y.split_at_mut(i);
            for ((m, xj), yj) in row[..i].iter().zip(&x[..i]).zip(lower) {
                for k in 0..K {
                    own[k] += m * xj[k];
                    yj[k] += m * xi[k];
                }
            }
            for k in 0..K {
                rest[0][k] += own[k] + row[i] * xi[k];
            }
        }
        y
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::thread_ranks::on_ranks;

    fn sample(n: usize) -> PackedSymmetric {
        let mut m = PackedSymmetric::zeros(n);
        for (i, row) in m.rows_mut().into_iter().enumerate() {
            for (j, x) in row.iter_mut().enumerate() {
                *x = 1.0 / (1.0 + i as f64 + 2.0 * j as f64);
            }
        }
        m
    }

    /// Entry (i, j).
    fn entry(m: &PackedSymmetric, i: usize, j: usize) -> f64 {
        m.row(i.max(j))[i.min(j)]
    }

    // Guards (numbers): reciprocity holds by construction: F_ij and F_ji are one stored number.
    #[test]
    fn product_equals_the_full_symmetric_product() {
        for n in [1, 2, 3, 50, 200] {
            let m = sample(n);
            let x: Vec<[f64; 2]> = (0..n).map(|i| [i as f64 - 3.0, 1.0]).collect();
            let y = m.apply(&x);
            for i in 0..n {
                for k in 0..2 {
                    let want: f64 = (0..n).map(|j| entry(&m, i, j) * x[j][k]).sum();
                    assert!((y[i][k] - want).abs() < 1e-11 * want.abs().max(1.0), "n={n} i={i}");
                }
            }
        }
    }

    // Guards (determinism): matrix products do not depend on the number of threads.
    #[test]
    fn threads_do_not_change_a_bit() {
        let m = sample(300);
        let x: Vec<[f64; 2]> = (0..300).map(|i| [(i as f64).sin(), 0.1 * i as f64]).collect();
        let with = |t: usize| {
            rayon::ThreadPoolBuilder::new().num_threads(t).build().unwrap().install(|| m.apply(&x))
        };
        assert_eq!(with(1), with(3));
    }

    #[test]
    fn ranks_do_not_change_a_bit() {
        let all = sample(300);
        let x: Vec<[f64; 2]> = (0..300).map(|i| [(i as f64).sin(), 0.1 * i as f64]).collect();
        let want = all.apply(&x);
        for size in [1, 2, 3, 7, 40] {
            let product = |c: &dyn Communicator| {
                let mut part = PackedSymmetric::zeros_of(RowBlocks::of_rank(300, c));
                let rows = part.blocks.own_rows();
                for (i, row) in rows.zip(part.rows_mut()) {
                    row.copy_from_slice(all.row(i));
                }
                part.apply_on_ranks(&x, c)
            };
            for found in on_ranks(size, product) {
                assert!(found == want, "{size} ranks");
            }
        }
    }
}
