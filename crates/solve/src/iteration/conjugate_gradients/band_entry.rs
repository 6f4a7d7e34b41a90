//! Entries of the vectors of conjugate gradients, in one band or in three.

use crate::distribution::multivector::VectorEntry;
use crate::operator::ExchangeOperator;
use zonal_math::parallel;
use zonal_scene::Bands;

/// An entry of a vector over the unknowns in N bands. The iteration computes with arrays of N numbers, so that one band costs a third; entries
/// of all bands are [`Bands`], which convert to and from arrays here.
pub(super) trait BandEntry<const N: usize>: VectorEntry {
    /// The numbers of the bands.
    fn lanes(self) -> [f64; N];
    /// The inverse of [`BandEntry::lanes`].
    fn from_lanes(lanes: [f64; N]) -> Self;
    /// The first of three vectors, in the memory of all.
    fn first_of(vectors: Vec<[Self; 3]>) -> Vec<Bands>;
    /// Replaces s of every column by g s.
    fn replace(operator: &dyn ExchangeOperator, columns: &mut Vec<Vec<Self>>);
    /// The entry that evaluates `f` for each band.
    #[inline]
    fn per_lane(f: impl FnMut(usize) -> f64) -> Self {
        Self::from_lanes(per_band(f))
    }
}

impl BandEntry<3> for Bands {
    #[inline]
    fn lanes(self) -> [f64; 3] {
        self.to_rgb()
    }
    #[inline]
    fn from_lanes(lanes: [f64; 3]) -> Bands {
        Bands::from_rgb(lanes)
    }
    fn first_of(vectors: Vec<[Bands; 3]>) -> Vec<Bands> {
        let n = vectors.len();
        let mut out = vectors.into_flattened();
        out.truncate(n);
        out.shrink_to_fit();
        out
    }
    fn replace(operator: &dyn ExchangeOperator, columns: &mut Vec<Vec<Bands>>) {
        operator.replace_many(columns);
    }
}

impl BandEntry<1> for [f64; 1] {
    #[inline]
    fn lanes(self) -> [f64; 1] {
        self
    }
    #[inline]
    fn from_lanes(lanes: [f64; 1]) -> [f64; 1] {
        lanes
    }
    fn first_of(mut vectors: Vec<[[f64; 1]; 3]>) -> Vec<Bands> {
        spread(vectors.as_flattened_mut().as_flattened_mut());
        // Collected in place.
        vectors.into_iter().map(|v| Bands::from_rgb(v.map(|[x]| x))).collect()
    }
    fn replace(operator: &dyn ExchangeOperator, columns: &mut Vec<Vec<[f64; 1]>>) {
        columns.iter_mut().for_each(|c| operator.replace_band(c));
    }
}

pub(super) fn per_band<const N: usize>(f: impl FnMut(usize) -> f64) -> [f64; N] {
    std::array::from_fn(f)
}

/// The first N bands.
pub(super) fn first_lanes<const N: usize>(x: Bands) -> [f64; N] {
    per_band(|b| x.as_slice()[b])
}

/// True if the bands of all entries are bit-identical.
pub(super) fn is_grey(v: &[Bands]) -> bool {
    let is_grey = |x: &Bands| x.all(|y| y.to_bits() == x.first().to_bits());
    parallel::all(v, is_grey)
}

/// Stores each number of the first third three times, in its order.
fn spread(numbers: &mut [f64]) {
    let mut end = numbers.len() / 3;
    // What is written lies beyond what is read.
    while end > 1 {
        let start = end.div_ceil(3);
        let (read, written) = numbers[..3 * end].split_at_mut(end);
        parallel::for_each(&mut written[3 * start - end..], |k, x| *x = read[start + k / 3]);
        end = start;
    }
    numbers.first().copied().into_iter().for_each(|x| numbers[..3].fill(x));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_numbers_stand_three_times() {
        for n in [0, 1, 2, 3, 4, 5, 100, 10_001] {
            let mut numbers: Vec<f64> = (0..n).chain(0..2 * n).map(|i| i as f64).collect();
            spread(&mut numbers);
            assert!(numbers.iter().enumerate().all(|(k, x)| *x == (k / 3) as f64), "{n}");
        }
    }
}
