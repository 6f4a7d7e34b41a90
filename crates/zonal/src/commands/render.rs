//! `zonal render`: a picture from a solution.

use super::{Context, check_output};
use crate::failure::say;
use crate::{Failure, meter::Meter};
use std::path::{Path, PathBuf};
use zonal_io::output::{self, Curve};
use zonal_render::{Image, RenderOptions};
use zonal_scene::{Camera, Progress, Solution};

/// Draw a picture from a solution.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Solution (.npz).
    pub run: PathBuf,
    /// Name of a camera of the scene (default: the first).
    #[arg(long)]
    pub camera: Option<String>,
    /// Pixels across and down.
    #[arg(long, default_value = "640x480", value_name = "WxH")]
    pub size: String,
    /// Picture to write: .png (exposed, filmic, 8 bits) or .exr (linear radiance).
    #[arg(long, short)]
    pub output: PathBuf,
    /// Rays of every pixel. Without it: one to nine, where neighbouring pixels differ, and rays through the medium shared where it
    /// is smooth; some twelve times as fast as 9.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub samples: Option<u32>,
    /// Final gather: indirect light of surfaces by N rays from each point seen, not interpolated between patches: crisp creases and
    /// contacts, slow (docs/pictures.md); 64 shows what it does, 256 is smooth.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=4096))]
    pub gather: u32,
    /// Exposure of a .png in stops above the automatic one.
    #[arg(long, default_value_t = 0.0, allow_hyphen_values = true)]
    pub stops: f64,
}

/// The number of samples that stands for as many as a pixel needs.
pub const ADAPTIVE: u32 = 0;
/// The most pixels of a picture.
const MAX_PIXELS: usize = 1 << 26;

/// Width and height from `WxH`.
pub fn parse_size(text: &str) -> Result<(usize, usize), Failure> {
    let wrong = |why: &str| Failure::new(format!("--size: '{text}' {why}; write for example 640x480"));
    let (w, h) = text.split_once(['x', 'X']).ok_or_else(|| wrong("is not WxH"))?;
    let number = |s: &str| s.trim().parse::<usize>().map_err(|_| wrong("is not two whole numbers"));
    let (w, h) = (number(w)?, number(h)?);
    if w == 0 || h == 0 {
        return Err(wrong("has no pixels"));
    }
    if w.checked_mul(h).is_none_or(|n| n > MAX_PIXELS) {
        return Err(wrong("has more pixels than can be drawn"));
    }
    Ok((w, h))
}

/// The camera of that name, or the first.
pub fn find_camera<'a>(solution: &'a Solution, name: Option<&str>) -> Result<&'a Camera, Failure> {
    let cameras = solution.scene.cameras();
    let names = || cameras.iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join(", ");
    match name {
        None => cameras.first().ok_or_else(|| {
            Failure::new("--camera: the scene has no camera; add a [[camera]] and solve again")
        }),
        Some(n) => cameras.iter().find(|c| c.name == n).ok_or_else(|| {
            Failure::new(format!("--camera: there is no camera '{n}'; the scene has: {}", names()))
        }),
    }
}

/// Runs the command.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    let (width, height) = parse_size(&args.size)?;
    if !(args.stops.is_finite() && args.stops.abs() <= 30.0) {
        return Err(Failure::new("--stops: give a number between -30 and 30"));
    }
    check_output(&args.output, &["png", "exr"])?;
    let solution = output::read_solution(&args.run)?;
    let camera = find_camera(&solution, args.camera.as_deref())?;
    let options = RenderOptions {
        width,
        height,
        samples: args.samples.unwrap_or(ADAPTIVE) as usize,
        gather: args.gather as usize,
        ..RenderOptions::default()
    };
    let image = zonal_render::render(&solution, camera, &options, &Meter::new(context.quiet));
    let exposure = save(&args.output, &image, args.stops)?;
    if context.json {
        say(&format!(
            "{}",
            serde_json::json!({
                "camera": camera.name, "width": width, "height": height, "samples": args.samples,
                "exposure": exposure, "mean": mean(&image), "written": args.output.display().to_string(),
            })
        ))?;
    } else {
        say(&format!("{}: {width}×{height} written: {}", camera.name, args.output.display()))?;
    }
    Ok(())
}

/// Draws with so many samples a pixel, or [`ADAPTIVE`].
pub fn draw(
    s: &Solution,
    camera: &Camera,
    (width, height): (usize, usize),
    samples: u32,
    progress: &dyn Progress,
) -> Image {
    let options = RenderOptions { width, height, samples: samples as usize, ..RenderOptions::default() };
    zonal_render::render(s, camera, &options, progress)
}

/// Writes a picture by its name's ending; returns the exposure of a PNG.
pub fn save(path: &Path, image: &Image, stops: f64) -> Result<Option<f64>, Failure> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) {
        output::write_exr(path, image.width, image.height, &image.pixels)?;
        return Ok(None);
    }
    let exposure = output::auto_exposure(&image.pixels) * stops.exp2();
    output::write_png(path, image.width, image.height, &image.pixels, exposure, Curve::Filmic)?;
    Ok(Some(exposure))
}

fn mean(image: &Image) -> [f64; 3] {
    let n = image.pixels.len().max(1) as f64;
    image.pixels.iter().fold([0.0; 3], |s, p| [0, 1, 2].map(|b| s[b] + p[b] as f64 / n))
}
