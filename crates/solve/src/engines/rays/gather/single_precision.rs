//! Bands in single precision: the storage of sums and means of all zones.

use zonal_scene::{Bands, PerBand};

/// A quantity of every band in single precision.
pub(crate) type SingleBands = PerBand<f32>;

/// The bands in double precision.
pub(crate) fn to_double(v: SingleBands) -> Bands {
    v.map(f64::from)
}

/// Rounds the bands to single precision.
pub(crate) fn to_single(v: Bands) -> SingleBands {
    v.map(|x| x as f32)
}

/// Adds to a sum, which is rounded once.
pub(crate) fn add_to(sum: &mut SingleBands, more: Bands) {
    *sum = to_single(to_double(*sum) + more);
}

/// The bands as words of a checkpoint.
pub(crate) fn words(v: SingleBands) -> [u32; 3] {
    v.into_rgb().map(f32::to_bits)
}

/// The bands of the words of a checkpoint.
pub(crate) fn from_words(words: [u32; 3]) -> SingleBands {
    PerBand::from_rgb(words).map(f32::from_bits)
}
