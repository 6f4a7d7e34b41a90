//! A linear picture and its conversion to single precision.

pub(crate) mod bloom;
pub(crate) mod denoise;
pub(crate) mod spectral_colour;

use std::ops::Range;
use zonal_math::parallel;
use zonal_scene::{Bands, Progress};

/// A linear picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Radiance, red, green and blue, W/(m² sr), row by row, row 0 on top; values beyond single precision are its largest number.
    pub pixels: Vec<[f32; 3]>,
}

/// A radiance as a pixel, clamped to the finite range of single precision. NaN stays NaN: `min` would hide it.
pub(crate) fn to_pixel(radiance: Bands) -> [f32; 3] {
    radiance.to_rgb().map(|x| x.clamp(f32::MIN.into(), f32::MAX.into()) as f32)
}

/// The values of the pixels of some rows of `width` pixels, row by row: `pixel(x, y)`. Each row is a step of the progress.
pub(crate) fn pixels_of_rows<T: Send>(
    rows: Range<usize>,
    width: usize,
    progress: &dyn Progress,
    pixel: impl Fn(usize, usize) -> T + Sync,
) -> Vec<T> {
    let row = |y: usize| {
        let row: Vec<T> = (0..width).map(|x| pixel(x, y)).collect();
        progress.advance(1);
        row
    };
    let rows: Vec<Vec<T>> = parallel::collect(rows.len(), |k| row(rows.start + k));
    rows.into_iter().flatten().collect()
}

/// Red, green and blue in single precision.
pub(crate) fn to_single_precision(x: Bands) -> [f32; 3] {
    x.to_rgb().map(|x| x as f32)
}
