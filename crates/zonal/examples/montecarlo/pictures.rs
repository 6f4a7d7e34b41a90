//! Our pictures of the cubes beside those of `image_*`.

use crate::cases::Any;
use std::path::Path;
use zonal::io::output;
use zonal::render::{Image, RenderOptions, render};
use zonal::scene::{Quiet, Solution};

/// Samples a pixel and towards lights.
const SAMPLES: usize = 16;
/// Pixels along the edge of a block.
const BLOCK: usize = 8;
/// Pixels of the written picture along one of ours.
const SCALE: usize = 4;

/// Draws a solution, writes `NAME.exr` and `NAME.png` (ours, the reference, four times the difference about grey), and says how they
/// compare.
pub fn compare(s: &Solution, case: &str, folder: &Path, (out, name): (&Path, &str)) -> Result<String, Any> {
    let file = folder.join(format!("image_{case}_inside_64.npz"));
    let (shape, theirs) = output::read_array(&file, "img")?;
    let errors = output::read_array(&file, "se")?.1;
    let &[height, width] = shape.as_slice() else {
        return Err(format!("{}: not a picture of one band", file.display()).into());
    };
    let options = RenderOptions { width, height, samples: SAMPLES, ..RenderOptions::default() };
    let camera = s.scene.cameras().first().ok_or("the scene has no camera")?;
    let image = render(s, camera, &options, &Quiet);
    output::write_exr(&out.join(format!("{name}.exr")), width, height, &image.pixels)?;
    side_by_side(&image, &theirs, &out.join(format!("{name}.png")))?;
    let n = theirs.len() as f64;
    let ours: Vec<f64> = image.pixels.iter().map(|p| f64::from(p[0])).collect();
    let mean = theirs.iter().sum::<f64>() / n;
    let square: f64 = ours.iter().zip(&theirs).map(|(o, t)| (o - t) * (o - t)).sum();
    let noise: f64 = errors.iter().map(|e| e * e).sum();
    Ok(format!(
        "  picture: sqrt(mean d² − mean σ²) = {:.2} % of the mean (σ: {:.2} %), mean {:+.2} %, blocks of {BLOCK}×{BLOCK}: {:.2} % RMS",
        100.0 * ((square - noise).max(0.0) / n).sqrt() / mean,
        100.0 * (noise / n).sqrt() / mean,
        100.0 * (ours.iter().sum::<f64>() / n / mean - 1.0),
        100.0 * blocks(&ours, &theirs, width)
    ))
}

/// Root mean square of the relative difference of blocks.
fn blocks(ours: &[f64], theirs: &[f64], width: usize) -> f64 {
    let (across, down) = (width / BLOCK, theirs.len() / width / BLOCK);
    let sum = |p: &[f64], k: usize| -> f64 {
        let first = (k / across * width + k % across) * BLOCK;
        (0..BLOCK * BLOCK).map(|i| p[first + i / BLOCK * width + i % BLOCK]).sum()
    };
    crate::rms((0..across * down).map(|k| sum(ours, k) / sum(theirs, k) - 1.0))
}

fn side_by_side(ours: &Image, theirs: &[f64], path: &Path) -> Result<(), Any> {
    let grey: Vec<[f32; 3]> = theirs.iter().map(|t| [*t as f32; 3]).collect();
    let exposure = output::auto_exposure(&grey);
    let (w, h) = (3 * ours.width * SCALE, ours.height * SCALE);
    let pixel = |i: usize| {
        let (x, y) = (i % w / SCALE, i / w / SCALE);
        let k = y * ours.width + x % ours.width;
        match x / ours.width {
            0 => ours.pixels[k],
            1 => grey[k],
            _ => [(0.18 / exposure as f32 + 4.0 * (ours.pixels[k][0] - grey[k][0])).max(0.0); 3],
        }
    };
    let pixels: Vec<[f32; 3]> = (0..w * h).map(pixel).collect();
    Ok(output::write_png(path, w, h, &pixels, &output::Tone::filmic(exposure))?)
}
