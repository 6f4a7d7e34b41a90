//! Our pictures of the cubes beside those of `image_*`.

use crate::validate::measures::rms;
use std::path::Path;
use zonal_io::output;
use zonal_render::{Image, RenderOptions, render};
use zonal_report::Failure;
use zonal_scene::{Progress, Solution};

/// Samples a pixel and towards lights.
const SAMPLES_PER_PIXEL: usize = 16;
/// Pixels along the edge of a block.
const BLOCK_PIXELS: usize = 8;
/// Pixels of the written picture along one of ours.
const PIXEL_MAGNIFICATION: usize = 4;

/// A picture beside its reference.
pub(super) struct PictureComparison {
    /// Ours.
    image: Image,
    theirs: Vec<f64>,
    /// sqrt(mean d² − mean σ²) over the mean, σ the standard error of the reference.
    pub difference: f64,
    /// sqrt(mean σ²) over the mean.
    pub noise: f64,
    /// Our mean over that of the reference, less 1.
    pub mean: f64,
    /// RMS of the relative difference of blocks of 8 × 8 pixels.
    pub blocks: f64,
}

/// Draws a solution from the camera of `image_CASE*` and compares.
pub(super) fn compare(
    s: &Solution,
    case: &str,
    folder: &Path,
    progress: &dyn Progress,
) -> Result<PictureComparison, Failure> {
    let file = folder.join(format!("image_{case}_inside_64.npz"));
    let (shape, theirs) = output::read_array(&file, "img")?;
    let errors = output::read_array(&file, "se")?.1;
    let &[height, width] = shape.as_slice() else {
        return Err(Failure::in_file(&file, "not a picture of one band"));
    };
    let options = RenderOptions { width, height, samples: SAMPLES_PER_PIXEL, ..RenderOptions::default() };
    let camera =
        s.scene.cameras().first().ok_or_else(|| Failure::in_file(&file, "the scene has no camera"))?;
    let image = render(s, camera, &options, progress);
    let n = theirs.len() as f64;
    let ours: Vec<f64> = image.pixels.iter().map(|p| f64::from(p[0])).collect();
    let mean = theirs.iter().sum::<f64>() / n;
    let square: f64 = ours.iter().zip(&theirs).map(|(o, t)| (o - t) * (o - t)).sum();
    let noise: f64 = errors.iter().map(|e| e * e).sum();
    Ok(PictureComparison {
        difference: ((square - noise).max(0.0) / n).sqrt() / mean,
        noise: (noise / n).sqrt() / mean,
        mean: ours.iter().sum::<f64>() / n / mean - 1.0,
        blocks: blocks(&ours, &theirs, width),
        image,
        theirs,
    })
}

/// Root mean square of the relative difference of blocks.
fn blocks(ours: &[f64], theirs: &[f64], width: usize) -> f64 {
    let (across, down) = (width / BLOCK_PIXELS, theirs.len() / width / BLOCK_PIXELS);
    let sum = |p: &[f64], k: usize| -> f64 {
        let first = (k / across * width + k % across) * BLOCK_PIXELS;
        (0..BLOCK_PIXELS * BLOCK_PIXELS).map(|i| p[first + i / BLOCK_PIXELS * width + i % BLOCK_PIXELS]).sum()
    };
    rms((0..across * down).map(|k| sum(ours, k) / sum(theirs, k) - 1.0))
}

impl PictureComparison {
    /// Writes ours, the reference and four times the difference about grey side by side (.png).
    pub(super) fn write(&self, path: &Path) -> Result<(), Failure> {
        let (ours, theirs) = (&self.image, &self.theirs);
        let grey: Vec<[f32; 3]> = theirs.iter().map(|t| [*t as f32; 3]).collect();
        let exposure = output::auto_exposure(&grey);
        let (w, h) = (3 * ours.width * PIXEL_MAGNIFICATION, ours.height * PIXEL_MAGNIFICATION);
        let pixel = |i: usize| {
            let (x, y) = (i % w / PIXEL_MAGNIFICATION, i / w / PIXEL_MAGNIFICATION);
            let k = y * ours.width + x % ours.width;
            match x / ours.width {
                0 => ours.pixels[k],
                1 => grey[k],
                _ => [(0.18 / exposure as f32 + 4.0 * (ours.pixels[k][0] - grey[k][0])).max(0.0); 3],
            }
        };
        let pixels: Vec<[f32; 3]> = (0..w * h).map(pixel).collect();
        Ok(output::write_png(path, w, h, &pixels, &output::ToneMapping::filmic(exposure))?)
    }
}
