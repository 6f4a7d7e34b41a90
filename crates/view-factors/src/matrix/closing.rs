//! Rows that sum to one by the smallest change relative to the error radii.
//!
//! With exchange areas S_ij = A_i F_ij = S_ji, surroundings s_i and defects d_i = A_i − Σ_j S_ij − s_i, the corrections minimise
//!
//! ```text
//! Σ_{i<j} δ_ij²/w_ij + Σ_i δ_i²/w_i      subject to   Σ_j δ_ij + δ_i = d_i,       w = min(radius, value)²
//!   ⇒  δ_ij = w_ij (λ_i + λ_j),  δ_i = w_i λ_i,      Σ_j w_ij (λ_i + λ_j) + w_i λ_i = d_i
//! ```
//!
//! so that what is next to nothing, such as the sky in an enclosure, does not take the defects of other entries: a sparse symmetric system, solved by
//! conjugate gradients with its diagonal as preconditioner. Reciprocity stays exact. A value that
//! would become negative becomes zero and the rest is distributed again. The change is added to the radius.

use crate::matrix::ExchangeRows;
use zonal_math::Bounded;
use zonal_math::parallel;

/// Radius of an exact entry relative to its value, for its weight: rounding.
const EXACT_ENTRY_RADIUS: f64 = 1e-12;
/// Rounds of distribution, at most: values that become negative leave after each.
const MAX_ROUNDS: usize = 4;
/// Iterations of a round, at most, and the residual at which it ends, relative to the areas.
const MAX_ITERATIONS: usize = 150;
const RELATIVE_RESIDUAL: f64 = 1e-13;

/// Closes the rows of `rows`; `areas` are their sums. Returns the largest remaining defect relative to its area.
pub(crate) fn close_rows(areas: &[f64], rows: &mut ExchangeRows) -> f64 {
    for _ in 0..MAX_ROUNDS {
        let defects = defects(areas, rows);
        if largest(&defects, areas) <= RELATIVE_RESIDUAL {
            break;
        }
        let lambda = multipliers(rows, &defects, areas);
        if !apply(rows, &lambda) {
            break;
        }
    }
    largest(&defects(areas, rows), areas)
}

fn largest(defects: &[f64], areas: &[f64]) -> f64 {
    defects.iter().zip(areas).fold(0.0, |s, (d, a)| s.max(d.abs() / a))
}

pub(crate) fn defects(areas: &[f64], rows: &ExchangeRows) -> Vec<f64> {
    (0..areas.len()).map(|i| areas[i] - rows.sum(i)).collect()
}

/// The weight of an entry: none for a value of zero, also one that the last round reached.
fn weight(b: &Bounded) -> f64 {
    if b.value <= 0.0 { 0.0 } else { b.radius.min(b.value).max(EXACT_ENTRY_RADIUS * b.value).powi(2) }
}

fn multipliers(rows: &ExchangeRows, defects: &[f64], areas: &[f64]) -> Vec<f64> {
    let n = areas.len();
    let product = |x: &[f64]| -> Vec<f64> {
        let row = |i: usize| {
            let own = (weight(&rows.sky[i]) + weight(&rows.ground[i])) * x[i];
            rows.entries(i).fold(own, |s, (j, b)| s + weight(&b) * (x[i] + x[j]))
        };
        parallel::collect(n, row)
    };
    let diagonal: Vec<f64> = (0..n)
        .map(|i| {
            let own = weight(&rows.sky[i]) + weight(&rows.ground[i]);
            rows.entries(i).fold(own, |s, (_, b)| s + weight(&b)).max(f64::MIN_POSITIVE)
        })
        .collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let mut x = vec![0.0; n];
    let mut r = defects.to_vec();
    let mut z: Vec<f64> = r.iter().zip(&diagonal).map(|(r, d)| r / d).collect();
    let mut p = z.clone();
    let mut rz = dot(&r, &z);
    for _ in 0..MAX_ITERATIONS {
        if largest(&r, areas) <= RELATIVE_RESIDUAL {
            break;
        }
        let q = product(&p);
        let pq = dot(&p, &q);
        if pq.is_nan() || pq <= 0.0 {
            break;
        }
        let alpha = rz / pq;
        for i in 0..n {
            x[i] += alpha * p[i];
            r[i] -= alpha * q[i];
            z[i] = r[i] / diagonal[i];
        }
        let next = dot(&r, &z);
        let beta = next / rz;
        rz = next;
        (0..n).for_each(|i| p[i] = z[i] + beta * p[i]);
    }
    x
}

/// Adds the corrections; false if nothing changed.
fn apply(rows: &mut ExchangeRows, lambda: &[f64]) -> bool {
    let mut changed = false;
    let mut correct = |b: &mut Bounded, by: f64| {
        let value = (b.value + weight(b) * by).max(0.0);
        let change = (value - b.value).abs();
        changed |= change > 0.0;
        *b = Bounded { value, radius: b.radius + change, grade: b.grade };
    };
    for i in 0..lambda.len() {
        correct(&mut rows.sky[i], lambda[i]);
        correct(&mut rows.ground[i], lambda[i]);
    }
    rows.change_pairs(|i, j, b| correct(b, lambda[i] + lambda[j]));
    changed
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::Grade;

    fn rows(sky: f64) -> (Vec<f64>, ExchangeRows) {
        let pairs = [(0, 1, 0.5, 0.02), (0, 2, 0.3, 0.001), (1, 2, 0.9, 0.01)];
        let areas = vec![1.0, 1.5, 1.4];
        let entries = pairs.map(|(i, j, value, radius)| ((i, j), Bounded::estimated(value, radius)));
        let mut rows = ExchangeRows::new(3, entries.into_iter());
        rows.sky = vec![Bounded::estimated(sky, 0.01 * sky); 3];
        (areas, rows)
    }

    #[test]
    fn closed_rows_sum_to_their_areas_and_stay_reciprocal() {
        let (areas, mut made) = rows(0.15);
        let before = made.clone();
        assert!(close_rows(&areas, &mut made) < 1e-12);
        for i in 0..3 {
            for (j, b) in made.entries(i) {
                let back = made.entries(j).find(|e| e.0 == i).expect("the reverse pair").1;
                assert_eq!(b, back);
                let old = before.entries(i).find(|e| e.0 == j).expect("the same pair").1;
                assert!(b.radius >= old.radius + (b.value - old.value).abs() - 1e-15);
                assert_eq!(b.grade, Grade::Estimated);
            }
        }
        // The least change: every pair changes by its weight times the sum of two multipliers, those of the surroundings' changes.
        let multiplier = |i: usize| {
            let (old, new) = (&before.sky[i], &made.sky[i]);
            (new.value - old.value) / weight(old)
        };
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            let find = |r: &ExchangeRows| r.entries(i).find(|e| e.0 == j).expect("a pair").1;
            let change = find(&made).value - find(&before).value;
            let expected = weight(&find(&before)) * (multiplier(i) + multiplier(j));
            assert!(
                (change - expected).abs() < 1e-6 * change.abs().max(1e-6),
                "{i} {j}: {change} {expected}"
            );
        }
    }

    #[test]
    fn values_stay_at_or_above_zero() {
        let (areas, mut made) = rows(0.15);
        made.sky[0] = Bounded::estimated(0.4, 0.5);
        made.sky[2] = Bounded::estimated(1e-3, 1.0);
        assert!(close_rows(&areas, &mut made) < 1e-12);
        assert!(made.sky.iter().all(|s| s.value >= 0.0));
    }
}
