//! Three bands in single precision, padded to four lanes.

use zonal_scene::Bands;

/// A quantity of every band, such as a radiosity in W/m². The fourth lane is zero, so that one aligned load reads all bands.
pub(crate) type PaddedBands = [f32; 4];

/// Rounds three bands to single precision.
pub(crate) fn padded(v: Bands) -> PaddedBands {
    [v[0] as f32, v[1] as f32, v[2] as f32, 0.0]
}

/// Pads the weight of a ray.
pub(crate) fn padded_weight([a, b, c]: [f32; 3]) -> PaddedBands {
    [a, b, c, 0.0]
}
