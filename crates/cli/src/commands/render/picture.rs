//! A picture of light.

use super::args::{Args, is_linear, parse_size, render_options};
use super::style::PictureStyle;
use crate::commands::context::{Context, read_picture_solution};
use std::path::Path;
use zonal_io::output::{self, ToneMapping};
use zonal_render::{Image, RenderOptions, sky_noise};
use zonal_report::{Failure, check_output, say};
use zonal_scene::{Camera, Diagnostic, Progress, Solution};

/// Fraction of clipped pixels above which the command suggests a lower exposure.
const CLIPPED_FRACTION_NOTE: f64 = 1e-3;

/// Draws and writes a picture.
///
/// # Errors
/// As `zonal render`.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    let settings = PictureArguments::from_args(args)?;
    let solution = read_picture_solution(&args.run)?;
    let (camera, saved) = write(args, &settings, &solution, &context.progress())?;
    let options = render_options(args, settings.size);
    let warnings: Vec<Diagnostic> = sky_noise(&solution, &options).into_iter().collect();
    if context.json {
        print_json(args, &camera, &saved, &warnings)?;
    } else {
        print_text(args, &camera, &saved, &warnings)?;
    }
    context.check_warnings(&warnings)
}

/// Size and style of a picture, from arguments that were checked.
pub(super) struct PictureArguments {
    size: (usize, usize),
    style: PictureStyle,
}

impl PictureArguments {
    pub(super) fn from_args(args: &Args) -> Result<PictureArguments, Failure> {
        let (size, style) = (parse_size(&args.size)?, PictureStyle::from_args(args)?);
        check_lens(args)?;
        check_picture_output(args)?;
        Ok(PictureArguments { size, style })
    }
}

/// Draws and writes a picture of a solution that pictures show.
pub(super) fn write(
    args: &Args,
    settings: &PictureArguments,
    solution: &Solution,
    progress: &dyn Progress,
) -> Result<(Camera, SavedPicture), Failure> {
    let camera = camera_with_lens(args, solution, settings.size)?;
    let image = zonal_render::render(solution, &camera, &render_options(args, settings.size), progress);
    let saved = save(&args.output, image, &settings.style)?;
    Ok((camera, saved))
}

/// Refuses lenses that are not valid.
fn check_lens(args: &Args) -> Result<(), Failure> {
    if args.aperture.is_some_and(|x| !(x.is_finite() && x >= 0.0)) {
        return Err(Failure::new("--aperture: give the diameter of the lens in metres, from 0"));
    }
    if args.focus.is_some_and(|x| !(x.is_finite() && x > 0.0)) {
        return Err(Failure::new("--focus: give a distance in metres above 0"));
    }
    Ok(())
}

/// Refuses an output that cannot be written, and tone settings for linear pictures.
fn check_picture_output(args: &Args) -> Result<(), Failure> {
    check_output(&args.output, &["png", "exr"])?;
    for (flag, value) in [("--stops", args.stops), ("--contrast", args.contrast)] {
        if value.is_some() && is_linear(&args.output) {
            let reason = "does not apply to the linear radiance of an .exr; leave it out, or write a .png";
            return Err(Failure::new(format!("{flag}: {reason}")));
        }
    }
    Ok(())
}

/// The selected camera, with the lens of the arguments.
fn camera_with_lens(args: &Args, solution: &Solution, size: (usize, usize)) -> Result<Camera, Failure> {
    let mut camera = args.view.select(solution, size)?;
    camera.lens.aperture = args.aperture.unwrap_or(camera.lens.aperture);
    camera.lens.focus = args.focus.or(camera.lens.focus);
    if args.focus.is_some() && camera.lens.aperture == 0.0 {
        return Err(Failure::new(
            "--focus: a pinhole is sharp at every distance; give the lens an --aperture too",
        ));
    }
    Ok(camera)
}

/// Draws a picture with a number of samples per pixel, or [`crate::commands::quality::ADAPTIVE_SAMPLES`].
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

/// Properties of a written picture.
pub struct SavedPicture {
    /// Pixels across and down.
    pub size: (usize, usize),
    /// Tone mapping of a PNG.
    pub tone: Option<ToneMapping>,
    /// Number of clipped pixels of a PNG.
    pub clipped: Option<usize>,
    /// Mean radiance, W/(m² sr).
    pub mean: [f64; 3],
}

/// Writes a picture in the format of its extension. The exposure is measured before bloom.
///
/// # Errors
/// If the file cannot be written.
pub fn save(path: &Path, image: Image, style: &PictureStyle) -> Result<SavedPicture, Failure> {
    let tone = (!is_linear(path)).then(|| style.tone_mapping(output::auto_exposure(&image.pixels)));
    let image = style.with_bloom(image);
    match &tone {
        Some(tone) => output::write_png(path, image.width, image.height, &image.pixels, tone)?,
        None => output::write_exr(path, image.width, image.height, &image.pixels)?,
    }
    let clipped = tone.map(|t| t.count_clipped(&image.pixels));
    Ok(SavedPicture { size: (image.width, image.height), tone, clipped, mean: mean_radiance(&image) })
}

fn mean_radiance(image: &Image) -> [f64; 3] {
    let n = image.pixels.len().max(1) as f64;
    image.pixels.iter().fold([0.0; 3], |s, p| [0, 1, 2].map(|b| s[b] + p[b] as f64 / n))
}

fn print_json(
    args: &Args,
    camera: &Camera,
    saved: &SavedPicture,
    warnings: &[Diagnostic],
) -> Result<(), Failure> {
    let (width, height) = saved.size;
    let json = serde_json::json!({
        "camera": camera.name, "width": width, "height": height, "samples": args.samples,
        "exposure": saved.tone.map(|t| t.exposure), "clipped": saved.clipped, "mean": saved.mean,
        "written": args.output.display().to_string(),
        "warnings": output::notes_json(warnings),
    });
    say(&json.to_string())
}

fn print_text(
    args: &Args,
    camera: &Camera,
    saved: &SavedPicture,
    warnings: &[Diagnostic],
) -> Result<(), Failure> {
    let (width, height) = saved.size;
    say(&format!("{}: {width}×{height} written: {}", camera.name, args.output.display()))?;
    for w in warnings {
        say(&w.line())?;
    }
    let clipped_fraction = saved.clipped.map_or(0.0, |n| n as f64 / (width * height) as f64);
    if clipped_fraction > CLIPPED_FRACTION_NOTE {
        let percent = 100.0 * clipped_fraction;
        say(&format!("{percent:.1} % of the pixels are clipped; --stops -1 darkens the picture"))?;
    }
    Ok(())
}
