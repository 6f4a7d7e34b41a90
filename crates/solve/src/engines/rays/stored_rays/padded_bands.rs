//! Bands in single precision, padded to four lanes: the storage of radiosities that products read, converted from and to [`Bands`] here.

use zonal_scene::{Bands, PerBand};

/// Lanes of [`PaddedBands`].
pub(crate) const LANES: usize = 4;

/// A quantity of every band, such as a radiosity in W/m². The fourth lane is zero, so that one aligned load reads all bands.
pub(crate) type PaddedBands = [f32; LANES];

/// Rounds the bands to single precision.
#[inline]
pub(crate) fn padded(v: Bands) -> PaddedBands {
    let [a, b, c] = v.to_rgb();
    [a as f32, b as f32, c as f32, 0.0]
}

/// Pads a quantity of every band with zero.
#[inline]
pub(crate) fn padded_f32(v: PerBand<f32>) -> PaddedBands {
    let [a, b, c] = v.into_rgb();
    [a, b, c, 0.0]
}

/// The bands in double precision.
#[inline]
pub(crate) fn widened(v: PaddedBands) -> Bands {
    without_padding(v.map(f64::from))
}

/// The bands of four lanes.
#[inline]
pub(crate) fn without_padding([a, b, c, _]: [f64; LANES]) -> Bands {
    Bands::from_rgb([a, b, c])
}
