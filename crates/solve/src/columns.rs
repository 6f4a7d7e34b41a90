//! Vectors over zones, many at a time, with the same bits for any number of threads: fixed chunks, sums in their order.

use rayon::prelude::*;
use zonal_scene::{Bands, bands};

/// Zones a chunk; fixed, so that sums are the same for any number of threads.
pub const CHUNK: usize = 1 << 12;

/// One vector over the zones for each column.
pub type Columns = Vec<Vec<Bands>>;

/// Σ term(i) over i < n, band by band.
pub fn sum<const N: usize>(n: usize, term: impl Fn(usize) -> [f64; N] + Sync) -> [f64; N] {
    let plus = |s: [f64; N], t: [f64; N]| std::array::from_fn(|b| s[b] + t[b]);
    let chunk = |k: usize| (k * CHUNK..((k + 1) * CHUNK).min(n)).fold([0.0; N], |s, i| plus(s, term(i)));
    let parts: Vec<[f64; N]> = (0..n.div_ceil(CHUNK)).into_par_iter().map(chunk).collect();
    parts.into_iter().fold([0.0; N], plus)
}

/// a b, entry by entry.
pub fn times<const N: usize>(a: &[[f64; N]], b: &[[f64; N]]) -> Vec<[f64; N]> {
    a.par_iter().zip(b).map(|(x, y)| std::array::from_fn(|k| x[k] * y[k])).collect()
}

/// All columns of `zones` zones together, one after the other.
pub fn total<'a>(zones: usize, columns: impl IntoIterator<Item = &'a Vec<Bands>>) -> Vec<Bands> {
    let mut sum = vec![[0.0; 3]; zones];
    for c in columns {
        sum.iter_mut().zip(c).for_each(|(a, x)| *a = bands(|b| a[b] + x[b]));
    }
    sum
}
