//! Arguments of `zonal render`, and their values: size, camera, sampling.

use super::camera_choice::ViewArgs;
use crate::commands::quality::Quality;
use std::path::{Path, PathBuf};
use zonal_render::RenderOptions;
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
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub samples: Option<u32>,
    /// Final gather: N rays from each visible point for the indirect light of surfaces, in place of interpolation between patches; 0 is off. Sharp creases and
    /// contact shadows, slow: 64 is grainy, 256 is smooth [default: that of --quality; normal is 0].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=4096))]
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

/// Quantity of a picture in false colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum FieldQuantity {
    /// Temperature, K, of surfaces and panes (thermal mode).
    Temperature,
    /// Net radiative flux, W/m2, positive where heat leaves, of surfaces and panes (thermal mode).
    NetFlux,
    /// Radiosity B, W/m2, direct light included, of surfaces: mean over the bands; in thermal mode their sum.
    Radiosity,
    /// Irradiance H, W/m2, direct light included, of surfaces: mean over the bands; in thermal mode their sum.
    Irradiance,
}

/// Largest number of pixels of a picture.
const MAX_PIXELS: usize = 1 << 26;

/// Width and height from `WxH`.
///
/// # Errors
/// If the text has another form, or the picture no pixels or too many.
pub fn parse_size(text: &str) -> Result<(usize, usize), Failure> {
    let wrong = |why: &str| Failure::new(format!("--size: '{text}' {why}; write for example 640x480"));
    let (w, h) = text.split_once(['x', 'X']).ok_or_else(|| wrong("is not WxH"))?;
    let number = |s: &str| s.trim().parse::<usize>().map_err(|_| wrong("is not two whole numbers"));
    let (w, h) = (number(w)?, number(h)?);
    if w == 0 || h == 0 {
        return Err(wrong("has no pixels"));
    }
    if w.checked_mul(h).is_none_or(|n| n > MAX_PIXELS) {
        return Err(wrong(&format!("has more than {MAX_PIXELS} pixels")));
    }
    Ok((w, h))
}

/// Options of the renderer for a picture of this size.
#[must_use]
pub fn render_options(args: &Args, size: (usize, usize)) -> RenderOptions {
    let options = args.quality.of_picture(size);
    let samples = args.samples.map_or(options.samples, |n| n as usize);
    let gather = args.gather.map_or(options.gather, |n| n as usize);
    RenderOptions { samples, gather, ..options }
}

/// True if a picture holds linear values: its extension is `.exr`.
#[must_use]
pub fn is_linear(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"))
}
