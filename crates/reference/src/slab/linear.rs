//! Linear systems with several right-hand sides, by elimination with partial pivoting.

/// Replaces the rows of `right` by the solution X of A X = right; `None` if A is singular.
pub(super) fn solve(mut matrix: Vec<Vec<f64>>, mut right: Vec<Vec<f64>>) -> Option<Vec<Vec<f64>>> {
    let n = matrix.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|&a, &b| matrix[a][k].abs().total_cmp(&matrix[b][k].abs()))?;
        matrix.swap(k, pivot);
        right.swap(k, pivot);
        if matrix[k][k] == 0.0 {
            return None;
        }
        let (pivot_row, pivot_right) = (matrix[k].clone(), right[k].clone());
        for i in k + 1..n {
            let factor = matrix[i][k] / pivot_row[k];
            if factor != 0.0 {
                subtract(&mut matrix[i][k..], factor, &pivot_row[k..]);
                subtract(&mut right[i], factor, &pivot_right);
            }
        }
    }
    for k in (0..n).rev() {
        let mut row = std::mem::take(&mut right[k]);
        for j in k + 1..n {
            subtract(&mut row, matrix[k][j], &right[j]);
        }
        row.iter_mut().for_each(|x| *x /= matrix[k][k]);
        right[k] = row;
    }
    Some(right)
}

fn subtract(row: &mut [f64], factor: f64, other: &[f64]) {
    row.iter_mut().zip(other).for_each(|(x, y)| *x -= factor * y);
}
