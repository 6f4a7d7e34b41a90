//! Cholesky decomposition of a dense symmetric matrix, M = L Lᵀ, and solutions with it.
//!
//! Left-looking, in blocks of [`BLOCK`] columns: entries L_ij of a block are M_ij − Σ_k L_ik L_jk over the columns to the left, sums over contiguous rows,
//! four columns at a time in lanes of fixed number, so that all processors and all numbers of threads give the same bits. Rows are computed in parallel.
//! Reference: Golub and Van Loan, Matrix Computations, §4.2. Cost: n³/3 multiplications once, n² for each solution.

use zonal_math::parallel;
use zonal_math::simd::{LANES, SimdKernel, run};

/// Columns of a block.
const BLOCK: usize = 48;

/// Columns whose sums are computed together.
const COLUMNS: usize = 4;

/// Sums of a row with four other rows.
struct DotProducts<'a> {
    row: &'a [f64],
    others: [&'a [f64]; COLUMNS],
}

impl SimdKernel for DotProducts<'_> {
    type Output = [f64; COLUMNS];
    #[inline(always)]
    fn evaluate(self) -> [f64; COLUMNS] {
        let mut sums = [[0.0; LANES]; COLUMNS];
        let (head, tail) = self.row.as_chunks::<LANES>();
        let others = self.others.map(|o| o[..self.row.len()].as_chunks::<LANES>());
        for (k, a) in head.iter().enumerate() {
            for (sum, (o, _)) in sums.iter_mut().zip(&others) {
                let b = &o[k];
                (0..LANES).for_each(|l| sum[l] += a[l] * b[l]);
            }
        }
        std::array::from_fn(|c| {
            let rest: f64 = tail.iter().zip(others[c].1).map(|(a, b)| a * b).sum();
            sums[c].iter().sum::<f64>() + rest
        })
    }
}

/// Sum of the products of two lists.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    run(SumOfTerms { a, b, term: |x, y| x * y })
}

/// Sum of the squares of the products of two lists.
pub(super) fn dot_of_squares(a: &[f64], b: &[f64]) -> f64 {
    run(SumOfTerms { a, b, term: |x, y| (x * y) * (x * y) })
}

/// Sum of a term of each two entries of two lists.
struct SumOfTerms<'a, F> {
    a: &'a [f64],
    b: &'a [f64],
    term: F,
}

impl<F: Fn(f64, f64) -> f64> SimdKernel for SumOfTerms<'_, F> {
    type Output = f64;
    #[inline(always)]
    fn evaluate(self) -> f64 {
        let mut sums = [[0.0; LANES]; 2];
        let (a, b) = (&self.a[..self.b.len()], self.b);
        let (pairs, tail) = a.as_chunks::<{ 2 * LANES }>();
        let (others, rest) = b.as_chunks::<{ 2 * LANES }>();
        for (x, y) in pairs.iter().zip(others) {
            for l in 0..LANES {
                sums[0][l] += (self.term)(x[l], y[l]);
                sums[1][l] += (self.term)(x[LANES + l], y[LANES + l]);
            }
        }
        let ends: f64 = tail.iter().zip(rest).map(|(x, y)| (self.term)(*x, *y)).sum();
        sums[0].iter().zip(&sums[1]).map(|(x, y)| x + y).sum::<f64>() + ends
    }
}

/// Subtracts `x` times a row.
pub(super) struct SubtractRow<'a> {
    pub from: &'a mut [f64],
    pub row: &'a [f64],
    pub x: f64,
}

impl SimdKernel for SubtractRow<'_> {
    type Output = ();
    #[inline(always)]
    fn evaluate(self) {
        self.from.iter_mut().zip(self.row).for_each(|(b, l)| *b -= self.x * l);
    }
}

/// The factor L of a symmetric matrix of n rows.
#[derive(Clone, Debug)]
pub(super) struct Cholesky {
    n: usize,
    /// L row by row; the upper half holds no values.
    l: Vec<f64>,
}

impl Cholesky {
    /// Decomposes a matrix of `n` rows, of which the lower half is read; `None` if it is not positive definite.
    pub(super) fn new(mut m: Vec<f64>, n: usize) -> Option<Cholesky> {
        for from in (0..n).step_by(BLOCK) {
            let to = (from + BLOCK).min(n);
            let (done, rest) = m.split_at_mut(to * n);
            // The rows of the diagonal block, one after the other.
            for i in from..to {
                let (above, row) = done.split_at_mut(i * n);
                eliminate(&mut row[..n], above, from, i.min(to), n);
                let x = row[i] - dot(&row[..i], &row[..i]);
                if x.is_nan() || x <= 0.0 {
                    return None;
                }
                row[i] = x.sqrt();
            }
            // All rows below.
            parallel::chunks(rest, n, |_, row| eliminate(row, done, from, to, n));
        }
        Some(Cholesky { n, l: m })
    }

    /// Replaces b by the solution of L Lᵀ x = b.
    pub(super) fn solve(&self, b: &mut [f64]) {
        let n = self.n;
        for (i, row) in self.l.chunks_exact(n.max(1)).enumerate() {
            b[i] = (b[i] - dot(&row[..i], &b[..i])) / row[i];
        }
        for (i, row) in self.l.chunks_exact(n.max(1)).enumerate().rev() {
            let x = b[i] / row[i];
            b[i] = x;
            run(SubtractRow { from: &mut b[..i], row: &row[..i], x });
        }
    }
}

/// Replaces columns `from..to` of a row by those of L; `above` holds the rows of L before `to`.
fn eliminate(row: &mut [f64], above: &[f64], from: usize, to: usize, n: usize) {
    for first in (from..to).step_by(COLUMNS) {
        let others: [&[f64]; COLUMNS] = std::array::from_fn(|c| &above[(first + c).min(to - 1) * n..][..n]);
        let sums = run(DotProducts { row: &row[..first], others });
        for c in 0..COLUMNS.min(to - first) {
            let (j, own) = (first + c, others[c]);
            // The columns of this group that came before.
            let near: f64 = (first..j).map(|k| row[k] * own[k]).sum();
            row[j] = (row[j] - sums[c] - near) / own[j];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solutions_satisfy_the_equations_for_any_size() {
        for n in [1, 2, 5, 47, 48, 49, 131] {
            let entry = |i: usize, j: usize| {
                let off = ((i * 7 + j * 7 + i * j) % 11) as f64 / 11.0 / n as f64;
                if i == j { 1.0 + off } else { off }
            };
            let m: Vec<f64> = (0..n * n).map(|k| entry(k / n, k % n)).collect();
            let wanted: Vec<f64> = (0..n).map(|i| (i as f64).sin() + 2.0).collect();
            let mut b: Vec<f64> = (0..n).map(|i| (0..n).map(|j| entry(i, j) * wanted[j]).sum()).collect();
            Cholesky::new(m, n).unwrap().solve(&mut b);
            for (x, w) in b.iter().zip(&wanted) {
                assert!((x - w).abs() < 1e-12, "{n}: {x} {w}");
            }
        }
    }

    #[test]
    fn sums_of_products_and_of_squares_hold_for_any_length() {
        for n in [0, 1, 15, 16, 17, 33] {
            let (a, b): (Vec<f64>, Vec<f64>) = (0..n).map(|i| (1.0 + i as f64, 2.0 - i as f64)).unzip();
            let products = a.iter().zip(&b).map(|(x, y)| x * y);
            assert_eq!(dot(&a, &b), products.clone().sum::<f64>(), "{n}");
            assert_eq!(dot_of_squares(&a, &b), products.map(|p| p * p).sum::<f64>(), "{n}");
        }
    }

    #[test]
    fn indefinite_matrices_have_no_factor() {
        assert!(Cholesky::new(vec![1.0, 2.0, 2.0, 1.0], 2).is_none());
        assert!(Cholesky::new(vec![f64::NAN], 1).is_none());
    }
}
