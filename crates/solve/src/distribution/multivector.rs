//! Vectors over the zones, several side by side. Sums use fixed chunks in a fixed order, so that the bits do not depend on the number of threads.

use zonal_math::parallel;
use zonal_scene::Bands;

/// Entries of a chunk.
pub(crate) const CHUNK_LENGTH: usize = 1 << 12;

/// One vector over the unknowns for each column.
pub(crate) type MultiVector = Vec<Vec<Bands>>;

/// A value that is summed over the unknowns: a number, one for each band, or several of these.
pub(crate) trait VectorEntry: Copy + Send + Sync {
    /// The empty sum.
    const ZERO: Self;
    /// The sum of two entries.
    fn plus(self, other: Self) -> Self;
    /// The product of two entries, element by element.
    fn times(self, other: Self) -> Self;
}

impl VectorEntry for f64 {
    const ZERO: f64 = 0.0;
    #[inline]
    fn plus(self, other: f64) -> f64 {
        self + other
    }
    #[inline]
    fn times(self, other: f64) -> f64 {
        self * other
    }
}

impl VectorEntry for Bands {
    const ZERO: Bands = Bands::ZERO;
    #[inline]
    fn plus(self, other: Bands) -> Bands {
        self + other
    }
    #[inline]
    fn times(self, other: Bands) -> Bands {
        self * other
    }
}

impl<T: VectorEntry, const N: usize> VectorEntry for [T; N] {
    const ZERO: [T; N] = [T::ZERO; N];
    #[inline]
    fn plus(self, other: [T; N]) -> [T; N] {
        std::array::from_fn(|k| self[k].plus(other[k]))
    }
    #[inline]
    fn times(self, other: [T; N]) -> [T; N] {
        std::array::from_fn(|k| self[k].times(other[k]))
    }
}

/// Σ term(i) over i < n.
pub(crate) fn sum<T: VectorEntry>(n: usize, term: impl Fn(usize) -> T + Sync) -> T {
    let chunk =
        |k: usize| (k * CHUNK_LENGTH..((k + 1) * CHUNK_LENGTH).min(n)).fold(T::ZERO, |s, i| s.plus(term(i)));
    let partial: Vec<T> = parallel::collect(n.div_ceil(CHUNK_LENGTH), chunk);
    partial.into_iter().fold(T::ZERO, T::plus)
}

/// The entrywise product of two vectors.
pub(crate) fn times<T: VectorEntry>(a: &[T], b: &[T]) -> Vec<T> {
    parallel::collect(a.len(), |i| a[i].times(b[i]))
}

/// The scaling `d` after an earlier one.
pub(crate) fn times_scaling(earlier: &Option<Vec<Bands>>, d: &[Bands]) -> Vec<Bands> {
    earlier.as_ref().map_or_else(|| d.to_vec(), |earlier| times(earlier, d))
}

/// The sum of all columns over `n` unknowns, in the order of the columns.
pub(crate) fn total<'a>(n: usize, columns: impl IntoIterator<Item = &'a Vec<Bands>>) -> Vec<Bands> {
    let mut sum = vec![Bands::ZERO; n];
    for c in columns {
        sum.iter_mut().zip(c).for_each(|(a, x)| *a += x);
    }
    sum
}
