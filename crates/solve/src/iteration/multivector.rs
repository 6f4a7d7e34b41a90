//! Vectors over the zones, several side by side. Sums use fixed chunks in a fixed order, so that the bits do not depend on the number of threads.

use rayon::prelude::*;
use zonal_scene::{Bands, bands};

/// Entries of a chunk.
pub(crate) const CHUNK_LENGTH: usize = 1 << 12;

/// One vector over the unknowns for each column.
pub(crate) type MultiVector = Vec<Vec<Bands>>;

/// Σ term(i) over i < n in each band.
pub(crate) fn sum<const N: usize>(n: usize, term: impl Fn(usize) -> [f64; N] + Sync) -> [f64; N] {
    let plus = |s: [f64; N], t: [f64; N]| std::array::from_fn(|b| s[b] + t[b]);
    let chunk = |k: usize| {
        (k * CHUNK_LENGTH..((k + 1) * CHUNK_LENGTH).min(n)).fold([0.0; N], |s, i| plus(s, term(i)))
    };
    let partial: Vec<[f64; N]> = (0..n.div_ceil(CHUNK_LENGTH)).into_par_iter().map(chunk).collect();
    partial.into_iter().fold([0.0; N], plus)
}

/// The entrywise product of two vectors.
pub(crate) fn times<const N: usize>(a: &[[f64; N]], b: &[[f64; N]]) -> Vec<[f64; N]> {
    a.par_iter().zip(b).map(|(x, y)| std::array::from_fn(|k| x[k] * y[k])).collect()
}

/// The sum of all columns over `n` unknowns, in the order of the columns.
pub(crate) fn total<'a>(n: usize, columns: impl IntoIterator<Item = &'a Vec<Bands>>) -> Vec<Bands> {
    let mut sum = vec![[0.0; 3]; n];
    for c in columns {
        sum.iter_mut().zip(c).for_each(|(a, x)| *a = bands(|b| a[b] + x[b]));
    }
    sum
}
