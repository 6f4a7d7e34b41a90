//! Solution of dense linear equations by Gaussian elimination with partial pivoting (Golub and Van Loan, Matrix Computations, §3.4). Cost: n³/3 multiplications.

use super::cholesky::SubtractRow;
use zonal_math::parallel;
use zonal_math::simd::run;

/// Solves M x = b of a square matrix, row by row; `None` if it is singular.
pub(super) fn solve(mut m: Vec<f64>, mut b: Vec<f64>) -> Option<Vec<f64>> {
    let n = b.len();
    for k in 0..n {
        let size = |i: &usize| m[i * n + k].abs();
        let pivot = (k + 1..n).fold(k, |best, i| if size(&i) > size(&best) { i } else { best });
        if size(&pivot).is_nan() || size(&pivot) == 0.0 {
            return None;
        }
        if pivot != k {
            let (above, below) = m.split_at_mut(pivot * n);
            above[k * n..(k + 1) * n].swap_with_slice(&mut below[..n]);
            b.swap(k, pivot);
        }
        // Subtract the row of the pivot from all rows below; the factors stay in their column.
        let (done, rest) = m.split_at_mut((k + 1) * n);
        let row = &done[k * n..];
        parallel::chunks(rest, n, |_, other| {
            let x = other[k] / row[k];
            other[k] = x;
            if x != 0.0 {
                run(SubtractRow { from: &mut other[k + 1..], row: &row[k + 1..], x });
            }
        });
        for i in k + 1..n {
            b[i] -= m[i * n + k] * b[k];
        }
    }
    for k in (0..n).rev() {
        let row = &m[k * n..(k + 1) * n];
        let known: f64 = (k + 1..n).map(|j| row[j] * b[j]).sum();
        b[k] = (b[k] - known) / row[k];
    }
    Some(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solutions_satisfy_the_equations() {
        for n in [1, 2, 7, 40] {
            // Large entries right of the diagonal: the first pivot is 0.
            let entry = |i: usize, j: usize| {
                let large = if j == (i + 1) % n { 3.0 } else { 0.0 };
                large + (i * (7 * i + 5 * j) % 17) as f64 / 17.0 / n as f64
            };
            let m: Vec<f64> = (0..n * n).map(|k| entry(k / n, k % n)).collect();
            let wanted: Vec<f64> = (0..n).map(|i| 1.0 + i as f64).collect();
            let b = (0..n).map(|i| (0..n).map(|j| entry(i, j) * wanted[j]).sum()).collect();
            let found = solve(m, b).unwrap();
            assert!(found.iter().zip(&wanted).all(|(x, w)| (x - w).abs() < 1e-7 * w), "{n}: {found:?}");
        }
    }

    #[test]
    fn singular_matrices_have_no_solution() {
        assert_eq!(solve(vec![1.0, 2.0, 2.0, 4.0], vec![1.0, 1.0]), None);
        assert_eq!(solve(vec![f64::NAN], vec![1.0]), None);
    }
}
