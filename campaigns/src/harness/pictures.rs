//! Pictures beside a reference with standard errors: means, blocks of pixels, and both side by side.

use super::Error;
use std::path::Path;
use zonal_io::output::{self, RgbImage};

/// Pixels along the edge of a block.
pub(crate) const BLOCK_PIXELS: usize = 8;

/// A picture with the standard errors of its pixels.
pub(crate) struct MeasuredPicture {
    /// Radiances, W/(m² sr).
    pub mean: RgbImage,
    /// Their standard errors.
    pub error: RgbImage,
}

/// Sums over the pixels of a block, a band each.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PictureBlock {
    /// Its upper left pixel.
    pub corner: [usize; 2],
    pub ours: [f64; 3],
    pub theirs: [f64; 3],
    /// Of the reference.
    pub variance: [f64; 3],
}

impl MeasuredPicture {
    /// Reads `STEM.exr` and `STEM_stderr.exr`.
    pub(crate) fn read(stem: &Path) -> Result<MeasuredPicture, Error> {
        let file = |end: &str| output::read_exr(Path::new(&format!("{}{end}.exr", stem.display())));
        Ok(MeasuredPicture { mean: file("")?, error: file("_stderr")? })
    }

    /// Means and standard errors of a band.
    pub(crate) fn band(&self, b: usize) -> [Vec<f64>; 2] {
        [&self.mean, &self.error].map(|p| p.pixels.iter().map(|x| f64::from(x[b])).collect())
    }

    /// The mean of our pixels over that of the reference, less 1, from pixel `first` on.
    pub(crate) fn means(&self, ours: &[[f32; 3]], first: usize) -> [f64; 3] {
        let sum = |p: &[[f32; 3]], b: usize| p[first..].iter().map(|c| f64::from(c[b])).sum::<f64>();
        [0, 1, 2].map(|b| sum(ours, b) / sum(&self.mean.pixels, b) - 1.0)
    }

    /// All whole blocks, row by row.
    pub(crate) fn blocks(&self, ours: &[[f32; 3]]) -> Vec<PictureBlock> {
        let (width, across) = (self.mean.width, self.mean.width / BLOCK_PIXELS);
        let block = |k: usize| {
            let corner = [k % across, k / across].map(|i| i * BLOCK_PIXELS);
            let pixels = (0..BLOCK_PIXELS * BLOCK_PIXELS)
                .map(|p| (corner[1] + p / BLOCK_PIXELS) * width + corner[0] + p % BLOCK_PIXELS);
            let sum = |p: &[[f32; 3]], power: i32| {
                let of = |b: usize| pixels.clone().map(|i| f64::from(p[i][b]).powi(power)).sum::<f64>();
                [0, 1, 2].map(of)
            };
            PictureBlock {
                corner,
                ours: sum(ours, 1),
                theirs: sum(&self.mean.pixels, 1),
                variance: sum(&self.error.pixels, 2),
            }
        };
        (0..across * (self.mean.height / BLOCK_PIXELS)).map(block).collect()
    }

    /// Writes ours, the reference, and four times the difference in tiles about grey. `tile` is the number of pixels along the edge of a tile.
    pub(crate) fn write_side_by_side(
        &self,
        path: &Path,
        ours: &[[f32; 3]],
        tile: usize,
    ) -> Result<(), Error> {
        const MAGNIFICATION: usize = 2;
        let (theirs, width, height) = (&self.mean.pixels, self.mean.width, self.mean.height);
        let exposure = output::auto_exposure(theirs);
        let difference = |x: usize, y: usize| {
            let span = |at: usize, end: usize| at / tile * tile..(at / tile * tile + tile).min(end);
            let inside = || span(y, height).flat_map(|v| span(x, width).map(move |u| v * width + u));
            [0, 1, 2]
                .map(|b| inside().map(|k| ours[k][b] - theirs[k][b]).sum::<f32>() / inside().count() as f32)
        };
        let (w, h) = (3 * width * MAGNIFICATION, height * MAGNIFICATION);
        let pixel = |i: usize| {
            let (x, y) = (i % w / MAGNIFICATION, i / w / MAGNIFICATION);
            let k = y * width + x % width;
            match x / width {
                0 => ours[k],
                1 => theirs[k],
                _ => difference(x % width, y).map(|d| (0.18 / exposure as f32 + 4.0 * d).max(0.0)),
            }
        };
        let pixels: Vec<[f32; 3]> = (0..w * h).map(pixel).collect();
        Ok(output::write_png(path, w, h, &pixels, &output::ToneMapping::filmic(exposure))?)
    }
}
