//! A linear picture and its conversion to single precision.

/// A linear picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Radiance, W/(m² sr) a band, row by row, row 0 on top; values beyond single precision are its largest number.
    pub pixels: Vec<[f32; 3]>,
}

/// A radiance in single precision, clamped to the finite range. NaN stays NaN: `min` would hide it.
pub(crate) fn to_single_precision(radiance: f64) -> f32 {
    radiance.clamp(f32::MIN.into(), f32::MAX.into()) as f32
}
