//! One number for each spectral band, as an array.

/// One value a band.
pub type Bands = [f64; 3];

/// Evaluates `f` for each band.
///
/// ```
/// assert_eq!(zonal_scene::bands(|b| 2.0 * b as f64), [0.0, 2.0, 4.0]);
/// ```
pub fn bands(f: impl FnMut(usize) -> f64) -> Bands {
    std::array::from_fn(f)
}
