//! Options of a picture: one structure for all pictures, since their options exclude each other by values.

use super::camera_choice::ViewOptions;
use super::field_quantity::{FieldQuantity, MediumSlice};
use crate::quality::Quality;
use std::path::{Path, PathBuf};
use zonal_render::RenderOptions;
use zonal_report::Failure;

/// Largest number of pixels of a picture.
const MAX_PIXELS: usize = 1 << 26;
/// Largest number of rays of a pixel, and of a final gather.
pub const MAX_RAYS: u32 = 4096;

/// Options of a picture, and its file or folder.
#[derive(Clone, Debug, Default)]
pub struct DrawOptions {
    /// The file of the solution, which messages name.
    pub source: PathBuf,
    /// Picture to write (.png, .exr), or folder of frames.
    pub output: PathBuf,
    /// The camera.
    pub view: ViewOptions,
    /// Pixels across and down.
    pub size: (usize, usize),
    /// Rays at once.
    pub quality: Quality,
    /// Rays of a pixel in place of those of the quality.
    pub samples: Option<u32>,
    /// Rays of the final gather in place of those of the quality; 0 is none.
    pub gather: Option<u32>,
    /// Exposure of a .png relative to the automatic one, stops.
    pub stops: Option<f64>,
    /// Contrast of a .png: exponent of the luminance about middle grey.
    pub contrast: Option<f64>,
    /// Fraction of the light that the lens scatters over the picture, 0 to 1.
    pub bloom: f64,
    /// Diameter of the lens, m; that of the camera if `None`.
    pub aperture: Option<f64>,
    /// Distance in focus, m; that of the camera if `None`.
    pub focus: Option<f64>,
    /// The key frames of an animation in place of one picture.
    pub keys: Option<KeySource>,
    /// A quantity in false colours in place of light.
    pub show: Option<FieldQuantity>,
    /// Ends of the scale of false colours.
    pub range: Option<(f64, f64)>,
    /// A plane through the medium, whose temperatures are shown.
    pub slice: Option<MediumSlice>,
    /// Whether the scale is logarithmic.
    pub log: bool,
}

/// Where key frames come from.
#[derive(Clone, Debug)]
pub enum KeySource {
    /// A file (.toml).
    File(PathBuf),
    /// The chosen camera goes around its target in this number of frames.
    Turntable(u32),
}

impl DrawOptions {
    /// Options of the renderer.
    pub(super) fn render_options(&self) -> RenderOptions {
        let options = self.quality.of_picture(self.size);
        let samples = self.samples.map_or(options.samples, |n| n as usize);
        let gather = self.gather.map_or(options.gather, |n| n as usize);
        RenderOptions { samples, gather, ..options }
    }

    /// Refuses sizes and numbers of rays that are out of range.
    pub(super) fn check_size_and_rays(&self) -> Result<(), Failure> {
        check_size(self.size, &self.size_text())?;
        if self.samples == Some(0) || self.samples.max(self.gather).is_some_and(|n| n > MAX_RAYS) {
            return Err(Failure::new(format!(
                "--samples, --gather: at most {MAX_RAYS} rays are possible, and --samples has at least one; give another number"
            )));
        }
        Ok(())
    }

    pub(super) fn size_text(&self) -> String {
        format!("{}x{}", self.size.0, self.size.1)
    }
}

/// Refuses pictures without pixels or with too many; `text` is the size in messages.
///
/// # Errors
/// If the size is out of range.
pub fn check_size(size: (usize, usize), text: &str) -> Result<(), Failure> {
    let wrong = |why: &str| Failure::new(format!("--size: '{text}' {why}; write for example 640x480"));
    let (w, h) = size;
    if w == 0 || h == 0 {
        return Err(wrong("has no pixels"));
    }
    if w.checked_mul(h).is_none_or(|n| n > MAX_PIXELS) {
        return Err(wrong(&format!("has more than {MAX_PIXELS} pixels")));
    }
    Ok(())
}

/// True if a picture holds linear values: its extension is `.exr`.
pub(super) fn is_linear(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"))
}
