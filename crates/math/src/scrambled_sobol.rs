//! Sobol's sequence with nested uniform scrambling (Owen 1995), in eight dimensions, by the crate `sobol_burley` (Burley 2020).
//!
//! The first 2^k points with any seed form a digital net, so that smooth integrands of few effective dimensions converge much faster than with
//! independent points. Two seeds give independent sequences: the difference of two means is a sample of their error.

use crate::low_discrepancy;

/// Most points of one sequence.
pub const MAX_POINTS: usize = 1 << 16;

/// Distance of all coordinates from the ends of the unit interval: a point of a patch must not lie on an adjacent wall.
const BORDER_DISTANCE: f64 = 1e-6;

/// The `n`-th point of the sequence of a seed in the open eight-dimensional unit cube; `n` below [`MAX_POINTS`].
///
/// ```
/// use zonal_math::scrambled_sobol::point;
/// // Of the first 64 points each half of every coordinate has 32.
/// for k in 0..8 {
///     assert_eq!((0..64).filter(|&n| point(n, 7)[k] < 0.5).count(), 32);
/// }
/// ```
#[inline]
pub fn point(n: usize, seed: u32) -> [f64; 8] {
    let (a, b) = (four_dimensions(n, 0, seed), four_dimensions(n, 1, seed));
    std::array::from_fn(|k| if k < 4 { a[k] } else { b[k - 4] })
}

/// Dimensions 4 `part` to 4 `part` + 3 of the `n`-th point.
#[inline]
fn four_dimensions(n: usize, part: u32, seed: u32) -> [f64; 4] {
    let inside = |x: f32| f64::from(x).clamp(BORDER_DISTANCE, 1.0 - BORDER_DISTANCE);
    sobol_burley::sample_4d((n % MAX_POINTS) as u32, part, seed).map(inside)
}

/// The first four dimensions of [`point`], at half of its cost.
#[inline]
fn first_dimensions(n: usize, seed: u32) -> [f64; 4] {
    four_dimensions(n, 0, seed)
}

/// Four further dimensions of the `n`-th point, number 4 `part` to 4 `part` + 3, for parts from 2 on. Points of another seed would not do: their halves
/// change with those of the first dimensions, so that pairs of coordinates fill half of a square.
///
/// ```
/// use zonal_math::scrambled_sobol::{further_dimensions, point};
/// // Each quarter of the square of two coordinates has its share of points.
/// let upper = |n: usize| point(n, 7)[0] > 0.5 && further_dimensions(n, 2, 7)[0] > 0.5;
/// assert_eq!((0..256).filter(|&n| upper(n)).count(), 64);
/// ```
#[inline]
pub fn further_dimensions(n: usize, part: u32, seed: u32) -> [f64; 4] {
    four_dimensions(n, part, seed)
}

/// The `n`-th point of a sequence of any length: blocks of [`MAX_POINTS`] points, each with a seed of its own.
#[inline]
pub fn point_of_blocks(n: usize, seed: u64) -> [f64; 8] {
    point(n, seed_of_block(n, seed))
}

/// The first four dimensions of [`point_of_blocks`], at half of its cost.
#[inline]
pub fn first_dimensions_of_blocks(n: usize, seed: u64) -> [f64; 4] {
    first_dimensions(n, seed_of_block(n, seed))
}

/// The seed of the block that holds point `n`.
#[inline]
fn seed_of_block(n: usize, seed: u64) -> u32 {
    let block = (n / MAX_POINTS) as u64;
    low_discrepancy::split_mix64(seed ^ block << 48) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nets_are_stratified_in_every_pair_of_leading_dimensions() {
        // Each of 8 × 8 boxes in the first two coordinates holds one of 64 points.
        let mut hit = [0; 64];
        for n in 0..64 {
            let p = point(n, 0x1234_5678);
            hit[(p[0] * 8.0) as usize * 8 + (p[1] * 8.0) as usize] += 1;
        }
        assert!(hit.iter().all(|h| *h == 1), "{hit:?}");
    }

    #[test]
    fn blocks_of_a_long_sequence_differ() {
        assert_eq!(point_of_blocks(3, 7), point_of_blocks(3, 7));
        assert_ne!(point_of_blocks(3, 7), point_of_blocks(3 + MAX_POINTS, 7));
        assert_ne!(point_of_blocks(3, 7), point_of_blocks(3, 8));
        for n in [0, 5, MAX_POINTS + 2] {
            assert_eq!(first_dimensions_of_blocks(n, 7), point_of_blocks(n, 7)[..4]);
        }
    }

    #[test]
    fn means_of_a_smooth_function_converge_faster_than_random_points() {
        // The product of six factors of mean one; its standard deviation is 0.6.
        let f = |p: [f64; 8]| (0..6).map(|k| 1.0 + 0.8 * (p[k] - 0.5)).product::<f64>();
        let n = 1024;
        let mean = |seed| (0..n).map(|k| f(point(k, seed))).sum::<f64>() / n as f64;
        let rms = ((0..32).map(|s| (mean(s) - 1.0).powi(2)).sum::<f64>() / 32.0).sqrt();
        assert!(rms < 0.2 * 0.6 / (n as f64).sqrt(), "{rms}");
    }
}
