//! Draws a solution and compares the picture with a reference in blocks of 8×8 pixels and pixel by pixel.
//!
//! `cargo run --release --example compare_picture -- RUN.npz --against ../shared/data/mitsuba-refs/sponza_haze_st0.02_a09 [--camera NAME]
//! [--samples 4] [--lights 4] [--gather 0] [--worst 0] [-o side.png]`
//!
//! `--against X` reads the radiances `X.exr` and their standard errors `X_stderr.exr`. Where the ending of RUN is .exr, it is a picture already.
//! The picture that `-o` writes has ours, the reference, and four times the difference about grey, in tiles of 4 × 4 pixels, so that what is
//! structured shows through the reference's noise.

use std::path::Path;
use zonal_io::output;
use zonal_render::{Image, RenderOptions, render};
use zonal_scene::NoProgress;

/// Pixels along the edge of a block.
const BLOCK_PIXELS: usize = 8;

/// Root mean square, median and 95th percentile of the relative differences of blocks, and what single pixels say.
struct PictureDifference {
    /// Ratio of the means of the whole pictures, minus one, a band.
    means: [f64; 3],
    /// The blocks, by the size of their difference.
    blocks: Vec<BlockDifference>,
    /// The reference's own relative error in a block, root mean square.
    noise: f64,
    /// sqrt(mean d² − mean σ²) over the mean, per band: the part not explained by the reference's noise.
    pixels: [f64; 3],
}

/// Eight by eight pixels, all bands together.
struct BlockDifference {
    /// Its upper left pixel.
    at: [usize; 2],
    /// Ours over the reference's, minus one.
    difference: f64,
    /// The reference's own relative standard error.
    sigma: f64,
}

fn compare(ours: &Image, theirs: &Image, stderr: &[[f32; 3]]) -> PictureDifference {
    let (w, h) = (ours.width, ours.height);
    let n = (w * h) as f64;
    let mean = |p: &[[f32; 3]], b: usize| p.iter().map(|c| c[b] as f64).sum::<f64>() / n;
    let pixels = [0, 1, 2].map(|b| {
        let square = |i: usize| (ours.pixels[i][b] as f64 - theirs.pixels[i][b] as f64).powi(2);
        let noise = |i: usize| (stderr[i][b] as f64).powi(2);
        let excess = (0..w * h).map(|i| square(i) - noise(i)).sum::<f64>() / n;
        excess.max(0.0).sqrt() / mean(&theirs.pixels, b)
    });
    let mut blocks = Vec::new();
    for y in (0..h / BLOCK_PIXELS).map(|y| y * BLOCK_PIXELS) {
        for x in (0..w / BLOCK_PIXELS).map(|x| x * BLOCK_PIXELS) {
            let inside = || {
                (0..BLOCK_PIXELS * BLOCK_PIXELS)
                    .map(move |k| (y + k / BLOCK_PIXELS) * w + x + k % BLOCK_PIXELS)
            };
            let sum = |p: &[[f32; 3]]| inside().flat_map(|i| p[i]).map(f64::from).sum::<f64>();
            let error = inside().flat_map(|i| stderr[i]).map(|e| f64::from(e).powi(2)).sum::<f64>().sqrt();
            let want = sum(&theirs.pixels);
            if want > 0.0 {
                blocks.push(BlockDifference {
                    at: [x, y],
                    difference: sum(&ours.pixels) / want - 1.0,
                    sigma: error / want,
                });
            }
        }
    }
    let square = |b: &BlockDifference| b.sigma.powi(2);
    let noise = (blocks.iter().map(square).sum::<f64>() / blocks.len().max(1) as f64).sqrt();
    blocks.sort_by(|a, b| a.difference.abs().total_cmp(&b.difference.abs()));
    PictureDifference {
        means: [0, 1, 2].map(|b| mean(&ours.pixels, b) / mean(&theirs.pixels, b) - 1.0),
        blocks,
        noise,
        pixels,
    }
}

impl PictureDifference {
    fn percentile(&self, p: f64) -> f64 {
        let last = self.blocks.len().saturating_sub(1);
        self.blocks.get((last as f64 * p).round() as usize).map_or(0.0, |b| b.difference.abs())
    }
    /// The `n` blocks that differ most.
    fn worst(&self, n: usize) -> String {
        let line = |b: &BlockDifference| {
            format!(
                "  block at {:?}: {:+.1} %, {:.1} σ of the reference\n",
                b.at,
                100.0 * b.difference,
                b.difference.abs() / b.sigma
            )
        };
        self.blocks.iter().rev().take(n).map(line).collect()
    }
    fn lines(&self) -> String {
        let percent = |x: f64| format!("{:+.2} %", 100.0 * x);
        let count = |far: &dyn Fn(&BlockDifference) -> bool| self.blocks.iter().filter(|b| far(b)).count();
        let beyond = count(&|b| b.difference.abs() > 0.05 + 2.0 * b.sigma);
        let significant = count(&|b| b.difference.abs() > 4.0 * b.sigma);
        let bands = |v: [f64; 3]| v.map(percent).join(" ");
        format!(
            "means {}\n{} blocks of {BLOCK_PIXELS}×{BLOCK_PIXELS}: median {:.2} %, 95th percentile {:.2} %, largest {}, the reference's own noise {:.2} %\n{beyond} beyond 5 % and two σ of the reference, {significant} beyond four σ\nsqrt(mean d² − mean σ²)/mean {}\n",
            bands(self.means),
            self.blocks.len(),
            100.0 * self.percentile(0.5),
            100.0 * self.percentile(0.95),
            percent(self.blocks.last().map_or(0.0, |b| b.difference)),
            100.0 * self.noise,
            bands(self.pixels)
        )
    }
}

/// Ours, the reference, and four times the difference in tiles about grey, each pixel `MAGNIFICATION` times as large.
fn side_by_side(ours: &Image, theirs: &Image, exposure: f64) -> (usize, usize, Vec<[f32; 3]>) {
    const MAGNIFICATION: usize = 3;
    const TILE_PIXELS: usize = 4;
    let difference = |x: usize, y: usize, c: usize| {
        let span = |at: usize, end: usize| {
            at / TILE_PIXELS * TILE_PIXELS..(at / TILE_PIXELS * TILE_PIXELS + TILE_PIXELS).min(end)
        };
        let tile = || span(y, ours.height).flat_map(|v| span(x, ours.width).map(move |u| v * ours.width + u));
        let sum: f32 = tile().map(|k| ours.pixels[k][c] - theirs.pixels[k][c]).sum();
        sum / tile().count() as f32
    };
    let (w, h) = (3 * ours.width * MAGNIFICATION, ours.height * MAGNIFICATION);
    let pixel = |i: usize| {
        let (x, y) = (i % w / MAGNIFICATION, i / w / MAGNIFICATION);
        let k = y * ours.width + x % ours.width;
        let (a, b) = (ours.pixels[k], theirs.pixels[k]);
        match x / ours.width {
            0 => a,
            1 => b,
            _ => {
                [0, 1, 2].map(|c| (0.18 / exposure as f32 + 4.0 * difference(x % ours.width, y, c)).max(0.0))
            }
        }
    };
    (w, h, (0..w * h).map(pixel).collect())
}

fn image(path: &str) -> Result<Image, Box<dyn std::error::Error>> {
    let p = output::read_exr(Path::new(path))?;
    Ok(Image { width: p.width, height: p.height, pixels: p.pixels })
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let option =
        |name: &str| arguments.iter().position(|a| a == name).and_then(|k| arguments.get(k + 1).cloned());
    let number = |name: &str, default: usize| option(name).map_or(Ok(default), |x| x.parse());
    let run = arguments.first().ok_or("which solution or picture? Give RUN.npz or PICTURE.exr")?;
    let reference = option("--against").ok_or("against which reference? Give --against PATH without .exr")?;
    let (theirs, stderr) = (image(&format!("{reference}.exr"))?, image(&format!("{reference}_stderr.exr"))?);
    let ours = if run.ends_with(".exr") {
        image(run)?
    } else {
        let solution = output::read_solution(Path::new(run))?;
        let cameras = solution.scene.cameras();
        let wanted = option("--camera");
        let camera = cameras.iter().find(|c| wanted.as_ref().is_none_or(|w| *w == c.name));
        let options = RenderOptions {
            width: theirs.width,
            height: theirs.height,
            samples: number("--samples", 4)?,
            light_samples: number("--lights", 4)?,
            gather: number("--gather", 0)?,
        };
        render(&solution, camera.ok_or("the solution has no such camera")?, &options, &NoProgress)
    };
    if (ours.width, ours.height) != (theirs.width, theirs.height) {
        return Err("the two pictures differ in size".into());
    }
    let comparison = compare(&ours, &theirs, &stderr.pixels);
    print!("{}{}", comparison.lines(), comparison.worst(number("--worst", 0)?));
    if let Some(path) = option("-o") {
        let exposure = output::auto_exposure(&theirs.pixels);
        let (w, h, pixels) = side_by_side(&ours, &theirs, exposure);
        output::write_png(Path::new(&path), w, h, &pixels, &output::ToneMapping::filmic(exposure))?;
    }
    Ok(())
}
