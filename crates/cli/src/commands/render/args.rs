//! Arguments of `zonal render`.

use super::view_args::ViewArgs;
use std::path::PathBuf;
use zonal_app::pictures::{
    DrawOptions, FieldQuantity, KeySource, MAX_RAYS, MediumSlice, check_range, check_size,
};
use zonal_app::quality::Quality;
use zonal_report::Failure;

const EXAMPLES: &str = "Examples:
  zonal render church.npz -o nave.png                                    first camera of the scene
  zonal render church.npz --from 0,8,1.7 --look-at 0,30,4 --fov 70 -o nave.png
  zonal render church.npz --camera overview --turntable 48 -o turn        frames around the scene
  zonal render church.npz --camera rose --size 1920x1080 -o rose.png --bloom 0.1 --contrast 1.3
  zonal render church.npz --aperture 0.05 --focus 6 --samples 64 -o near.png
  zonal render church.npz -o nave.exr                                    linear radiance, W/(m2 sr)
  zonal render furnace.npz --show temperature -o walls.png               false colours with a scale
  zonal render furnace.npz --show temperature --slice x=1 -o gas.png     the medium on a plane
  zonal render furnace.npz --show net-flux --range -25000,55000 -o flux.png
  zonal render church.npz --animate scenes/church-flight.toml --size 640x360 -o flight

Key frames of an animation (docs/how-to/animation.md):
  frames_per_second = 24
  [[key]]
  time = 0                        # seconds
  camera = \"nave\"
  [[key]]
  time = 5
  origin = [0, 8, 2.4]            # omitted values stay as at the key before
  lights = { sun = 0.2, candles = 2 }";

const FALSE_COLOURS_HEADING: &str = "False colours";

/// Draw a picture from a solution, or the frames of a camera animation.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Solution (.npz).
    pub run: PathBuf,
    /// The camera.
    #[command(flatten)]
    pub view: ViewArgs,
    /// Pixels across and down. With --show the scale is drawn beside them.
    #[arg(long, default_value = "640x480", value_name = "WxH")]
    pub size: String,
    /// Picture to write: .png (exposed, tone-mapped, 8 bits, dithered) or .exr (linear radiance, W/(m2 sr)). With --animate: a folder.
    #[arg(long, short, value_name = "PICTURE")]
    pub output: PathBuf,
    /// Rays at once: draft takes one in each pixel, fine 16 and a final gather of 64.
    #[arg(long, value_enum, default_value_t)]
    pub quality: Quality,
    /// Rays per pixel, 1 to 4096 [default: that of --quality; normal is adaptive, one to nine where neighbouring pixels differ; about twelve times as fast as 9].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_RAYS)))]
    pub samples: Option<u32>,
    /// Final gather: N rays from each visible point for the indirect light of surfaces, in place of interpolation between patches; 0 is off. Sharp creases and
    /// contact shadows, slow: 64 is grainy, 256 is smooth [default: that of --quality; normal is 0].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=i64::from(MAX_RAYS)))]
    pub gather: Option<u32>,
    /// Exposure of a .png relative to the automatic one, stops, -30 to 30 [default: 0].
    #[arg(long, allow_hyphen_values = true)]
    pub stops: Option<f64>,
    /// Contrast of a .png: exponent of the luminance about middle grey, 0.1 to 10 [default: 1]. 1.3 restores depth in haze.
    #[arg(long)]
    pub contrast: Option<f64>,
    /// Fraction of the light that the lens scatters over the picture, 0 to 1; 0.1 glows around windows.
    #[arg(long, default_value_t = 0.0, value_name = "FRACTION")]
    pub bloom: f64,
    /// Diameter of the lens, m, for depth of field; 0 is a pinhole [default: that of the camera]. A pixel then has 64 rays, or --samples.
    #[arg(long, value_name = "METRES", conflicts_with_all = ["animate", "turntable"])]
    pub aperture: Option<f64>,
    /// Distance in focus, m [default: that of the camera, else that of the object in the centre of the picture].
    #[arg(long, value_name = "METRES", conflicts_with_all = ["animate", "turntable"])]
    pub focus: Option<f64>,
    /// Draw the frames of these key frames (.toml) into the folder --output, and a video if ffmpeg is installed. Existing frames are kept.
    #[arg(long, value_name = "KEYS.toml")]
    pub animate: Option<PathBuf>,
    /// Draw N frames into the folder --output, in which the camera goes once around the vertical through its target, and a video if ffmpeg is installed.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=9999), conflicts_with_all = ["animate", "show"])]
    pub turntable: Option<u32>,
    /// Draw false colours in place of light: each zone has the colour of its value. A ray ends at the first surface or pane that has the quantity; it passes
    /// through the medium (except a --slice) and the backs of one-sided surfaces. Grey zones have no value. A .png has a scale, an .exr holds the values.
    #[arg(long, value_name = "QUANTITY", value_enum, help_heading = FALSE_COLOURS_HEADING)]
    pub show: Option<FieldQuantity>,
    /// Ends of the scale in the unit of the quantity [default: the smallest and largest visible value]. Values beyond an end have its colour; the scale of net
    /// fluxes has zero in its middle.
    #[arg(long, value_name = "LOW,HIGH", allow_hyphen_values = true, requires = "show", help_heading = FALSE_COLOURS_HEADING)]
    pub range: Option<String>,
    /// With --show temperature: show the medium on the plane at METRES across an axis, such as z=1.0.
    #[arg(long, value_name = "AXIS=METRES", requires = "show", help_heading = FALSE_COLOURS_HEADING)]
    pub slice: Option<String>,
    /// Logarithmic scale, over at most three decades unless --range is wider.
    #[arg(long, requires = "show", help_heading = FALSE_COLOURS_HEADING)]
    pub log: bool,
}

impl Args {
    /// The options of the arguments.
    ///
    /// # Errors
    /// For sizes, ranges and planes that are not valid.
    pub fn options(&self) -> Result<DrawOptions, Failure> {
        let turntable = self.turntable.map(KeySource::Turntable);
        Ok(DrawOptions {
            source: self.run.clone(),
            output: self.output.clone(),
            view: self.view.options(),
            size: parse_size(&self.size)?,
            quality: self.quality,
            samples: self.samples,
            gather: self.gather,
            stops: self.stops,
            contrast: self.contrast,
            bloom: self.bloom,
            aperture: self.aperture,
            focus: self.focus,
            keys: self.animate.clone().map(KeySource::File).or(turntable),
            show: self.show,
            range: self.range.as_deref().map(parse_range).transpose()?,
            slice: self.slice.as_deref().map(MediumSlice::parse).transpose()?,
            log: self.log,
        })
    }
}

/// Width and height from `WxH`.
///
/// # Errors
/// If the text has another form, or the picture no pixels or too many.
pub fn parse_size(text: &str) -> Result<(usize, usize), Failure> {
    let wrong = |why: &str| Failure::new(format!("--size: '{text}' {why}; write for example 640x480"));
    let (w, h) = text.split_once(['x', 'X']).ok_or_else(|| wrong("is not WxH"))?;
    let number = |s: &str| s.trim().parse::<usize>().map_err(|_| wrong("is not two whole numbers"));
    let (w, h) = (number(w)?, number(h)?);
    check_size((w, h), text)?;
    Ok((w, h))
}

/// The ends of a range from `LOW,HIGH`.
fn parse_range(text: &str) -> Result<(f64, f64), Failure> {
    let wrong = |why: &str| Failure::new(format!("--range: '{text}' {why}; write for example 400,1200"));
    let (low, high) = text.split_once(',').ok_or_else(|| wrong("is not LOW,HIGH"))?;
    let number = |s: &str| s.trim().parse::<f64>().map_err(|_| wrong("is not two numbers"));
    let (low, high) = (number(low)?, number(high)?);
    check_range((low, high), text)?;
    Ok((low, high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_two_finite_numbers_in_order() {
        assert_eq!(parse_range("400,1200").unwrap(), (400.0, 1200.0));
        assert_eq!(parse_range(" -1e3 , 0.5 ").unwrap(), (-1000.0, 0.5));
        for bad in [
            "",
            "4",
            "4,",
            ",",
            "a,b",
            "5,4",
            "4,4",
            "nan,1",
            "0,inf",
            "-1e308,1e308,",
            "-1.7e308,1.7e308",
            "1,2,3",
        ] {
            assert!(parse_range(bad).is_err(), "{bad}");
        }
    }
}
