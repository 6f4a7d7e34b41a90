//! Tone and bloom of pictures.

use super::options::DrawOptions;
use zonal_io::output::ToneMapping;
use zonal_render::Image;
use zonal_report::Failure;

/// Tone and bloom of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureStyle {
    /// Exponent of the luminance about middle grey.
    pub contrast: f64,
    /// Fraction of the light that the lens scatters over the picture.
    pub bloom: f64,
    /// Exposure relative to the automatic one, stops.
    pub stops: f64,
}

impl Default for PictureStyle {
    fn default() -> PictureStyle {
        PictureStyle { contrast: 1.0, bloom: 0.0, stops: 0.0 }
    }
}

impl PictureStyle {
    /// The style of the options.
    ///
    /// # Errors
    /// If a value is out of range.
    pub(super) fn new(options: &DrawOptions) -> Result<PictureStyle, Failure> {
        let default = PictureStyle::default();
        let style = PictureStyle {
            contrast: options.contrast.unwrap_or(default.contrast),
            bloom: options.bloom,
            stops: options.stops.unwrap_or(default.stops),
        };
        for (flag, x, range) in [
            ("--stops", style.stops, -30.0..=30.0),
            ("--contrast", style.contrast, 0.1..=10.0),
            ("--bloom", style.bloom, 0.0..=1.0),
        ] {
            if !range.contains(&x) {
                let (from, to) = range.into_inner();
                return Err(Failure::new(format!(
                    "{flag}: {x} is out of range; give a number between {from} and {to}"
                )));
            }
        }
        Ok(style)
    }
    /// Tone mapping with an exposure to which the stops are added.
    pub(super) fn tone_mapping(&self, exposure: f64) -> ToneMapping {
        ToneMapping { contrast: self.contrast, ..ToneMapping::filmic(exposure * self.stops.exp2()) }
    }
    /// The picture with bloom.
    pub(super) fn with_bloom(&self, image: Image) -> Image {
        if self.bloom > 0.0 { zonal_render::bloom(&image, self.bloom) } else { image }
    }
}
