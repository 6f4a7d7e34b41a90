//! Packed symmetric matrices: the lower triangle is stored by rows, entry (i, j ≤ i) at i(i+1)/2 + j.
//!
//! The product y = M x reads every entry once: entry (i, j) adds M_ij x_j to y_i and M_ij x_i to y_j. Rows are divided into a
//! fixed number of blocks with partial sums of their own, which are added in the order of the blocks: the bits do not depend on the number of threads.
//!
//! Cost: bound by the memory bandwidth, 8 bytes an entry for n²/2 entries.

use rayon::prelude::*;

/// Number of blocks of rows; fixed, so that sums do not depend on the number of threads.
const ROW_BLOCKS: usize = 32;

/// A symmetric matrix in packed storage.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PackedSymmetric {
    n: usize,
    entries: Vec<f64>,
}

/// Number of stored entries for `n` rows.
pub(crate) fn packed_length(n: usize) -> usize {
    n * (n + 1) / 2
}

impl PackedSymmetric {
    /// A zero matrix of `n` rows.
    pub(crate) fn zeros(n: usize) -> PackedSymmetric {
        PackedSymmetric { n, entries: vec![0.0; packed_length(n)] }
    }
    /// The stored rows, row i of length i + 1.
    pub(crate) fn rows_mut(&mut self) -> Vec<&mut [f64]> {
        let mut rest = &mut self.entries[..];
        (0..self.n)
            .map(|i| {
                let (row, tail) = std::mem::take(&mut rest).split_at_mut(i + 1);
                rest = tail;
                row
            })
            .collect()
    }
    fn row(&self, i: usize) -> &[f64] {
        &self.entries[packed_length(i)..packed_length(i + 1)]
    }

    /// M x for several right-hand sides at once.
    pub(crate) fn apply<const K: usize>(&self, x: &[[f64; K]]) -> Vec<[f64; K]> {
        assert_eq!(x.len(), self.n);
        let edges = block_edges(self.n);
        let partial: Vec<Vec<[f64; K]>> =
            edges.par_windows(2).map(|w| self.apply_rows(x, w[0], w[1])).collect();
        let mut y = vec![[0.0; K]; self.n];
        for p in &partial {
            for (a, b) in y.iter_mut().zip(p) {
                (0..K).for_each(|k| a[k] += b[k]);
            }
        }
        y
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

/// Row numbers that divide the triangle into blocks of about equal numbers of entries.
fn block_edges(n: usize) -> Vec<usize> {
    let mut edges: Vec<usize> =
        (0..=ROW_BLOCKS).map(|b| (n as f64 * (b as f64 / ROW_BLOCKS as f64).sqrt()) as usize).collect();
    edges[ROW_BLOCKS] = n;
    edges.dedup();
    edges
}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn threads_do_not_change_a_bit() {
        let m = sample(300);
        let x: Vec<[f64; 2]> = (0..300).map(|i| [(i as f64).sin(), 0.1 * i as f64]).collect();
        let with = |t: usize| {
            rayon::ThreadPoolBuilder::new().num_threads(t).build().unwrap().install(|| m.apply(&x))
        };
        assert_eq!(with(1), with(3));
    }
}
