//! A picture of light.

use super::options::{DrawOptions, is_linear};
use super::style::PictureStyle;
use std::path::Path;
use zonal_io::output::{self, ToneMapping};
use zonal_render::{Image, sky_noise};
use zonal_report::{Failure, check_output};
use zonal_scene::{Camera, Diagnostic, Progress, Solution};

/// A picture whose options were checked.
pub(super) struct LightPicture {
    style: PictureStyle,
}

impl LightPicture {
    pub(super) fn new(options: &DrawOptions) -> Result<LightPicture, Failure> {
        options.check_size_and_rays()?;
        let style = PictureStyle::new(options)?;
        check_lens(options)?;
        check_picture_output(options)?;
        Ok(LightPicture { style })
    }

    /// Draws and writes the picture of a solution that pictures show.
    pub(super) fn write(
        &self,
        options: &DrawOptions,
        solution: &Solution,
        progress: &dyn Progress,
    ) -> Result<LightPictureSummary, Failure> {
        let camera = camera_with_lens(options, solution)?;
        let rays = options.render_options();
        let image = zonal_render::render(solution, &camera, &rays, progress);
        let saved = save(&options.output, image, &self.style)?;
        let warnings = sky_noise(solution, &rays).into_iter().collect();
        Ok(LightPictureSummary { camera, saved, warnings })
    }
}

/// A picture of light that was written.
pub struct LightPictureSummary {
    /// Its camera.
    pub camera: Camera,
    /// Its properties.
    pub saved: SavedPicture,
    /// Warnings of noise.
    pub warnings: Vec<Diagnostic>,
}

/// Refuses lenses that are not valid.
fn check_lens(options: &DrawOptions) -> Result<(), Failure> {
    if options.aperture.is_some_and(|x| !(x.is_finite() && x >= 0.0)) {
        return Err(Failure::new("--aperture: give the diameter of the lens in metres, from 0"));
    }
    if options.focus.is_some_and(|x| !(x.is_finite() && x > 0.0)) {
        return Err(Failure::new("--focus: give a distance in metres above 0"));
    }
    Ok(())
}

/// Refuses an output that cannot be written, and tone settings for linear pictures.
fn check_picture_output(options: &DrawOptions) -> Result<(), Failure> {
    check_output(&options.output, &["png", "exr"])?;
    for (flag, value) in [("--stops", options.stops), ("--contrast", options.contrast)] {
        if value.is_some() && is_linear(&options.output) {
            let reason = "does not apply to the linear radiance of an .exr; leave it out, or write a .png";
            return Err(Failure::new(format!("{flag}: {reason}")));
        }
    }
    Ok(())
}

/// The selected camera, with the lens of the options.
fn camera_with_lens(options: &DrawOptions, solution: &Solution) -> Result<Camera, Failure> {
    let mut camera = options.view.select(solution, options.size)?;
    camera.lens.aperture = options.aperture.unwrap_or(camera.lens.aperture);
    camera.lens.focus = options.focus.or(camera.lens.focus);
    if options.focus.is_some() && camera.lens.aperture == 0.0 {
        return Err(Failure::new(
            "--focus: a pinhole is sharp at every distance; give the lens an --aperture too",
        ));
    }
    Ok(camera)
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
