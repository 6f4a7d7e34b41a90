//! `zonal render`: a picture from a solution.

use super::show::Field;
use super::{Context, check_output, read_light};
use crate::failure::say;
use crate::{Failure, meter::Meter};
use std::path::{Path, PathBuf};
use zonal_io::output::{self, Tone};
use zonal_render::{Image, RenderOptions};
use zonal_scene::{Camera, Note, Progress, Solution};

const EXAMPLES: &str = "Examples:
  zonal render church.npz -o nave.png                                    the scene's first camera
  zonal render church.npz --camera rose --size 1920x1080 -o rose.png --bloom 0.1 --contrast 1.3
  zonal render church.npz --aperture 0.05 --focus 6 --samples 64 -o near.png
  zonal render church.npz -o nave.exr                                    linear radiance, W/(m2 sr)
  zonal render furnace.npz --show temperature -o walls.png               false colours with a scale
  zonal render furnace.npz --show temperature --slice x=1 -o gas.png     the medium on a plane
  zonal render furnace.npz --show net-flux --range -25000,55000 -o flux.png
  zonal render church.npz --animate scenes/church-flight.toml --size 640x360 -o flight

A path of key frames looks like this (docs/animation.md):
  frames_per_second = 24
  [[key]]
  time = 0                        # seconds
  camera = \"nave\"
  [[key]]
  time = 5
  origin = [0, 8, 2.4]            # what a key leaves out stays as it was
  lights = { sun = 0.2, candles = 2 }";

/// Draw a picture from a solution, or the frames of a flight through it.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Solution (.npz).
    pub run: PathBuf,
    /// Name of a camera of the scene (default: the first). With --show there is an `overview` too, of the whole scene from a corner
    /// above, which is the default where the scene has no camera.
    #[arg(long)]
    pub camera: Option<String>,
    /// Pixels across and down. With --show the scale comes beside them.
    #[arg(long, default_value = "640x480", value_name = "WxH")]
    pub size: String,
    /// Picture to write: .png (exposed, filmic, 8 bits, dithered) or .exr (linear radiance). With --animate: a folder.
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
    /// Exposure of a .png in stops above the automatic one [default: 0].
    #[arg(long, allow_hyphen_values = true)]
    pub stops: Option<f64>,
    /// Contrast of a .png: exponent of the luminance about middle grey [default: 1]. 1.3 suits hazy air.
    #[arg(long)]
    pub contrast: Option<f64>,
    /// Share of the light that the lens scatters over the picture, 0 to 1; 0.1 is a glow around windows.
    #[arg(long, default_value_t = 0.0, value_name = "SHARE")]
    pub bloom: f64,
    /// Diameter of the lens in metres, for depth of field (default: the camera's; 0 is sharp throughout). A pixel has 64 rays then, or --samples.
    #[arg(long, value_name = "METRES", conflicts_with = "animate")]
    pub aperture: Option<f64>,
    /// Distance in focus (default: the camera's, or that of what the middle of the picture sees).
    #[arg(long, value_name = "METRES", conflicts_with = "animate")]
    pub focus: Option<f64>,
    /// Draw the frames of this path of key frames (.toml) into the folder --output, and a video if ffmpeg is at hand. Frames that are
    /// there already are kept.
    #[arg(long, value_name = "PATH", conflicts_with = "camera")]
    pub animate: Option<PathBuf>,
    /// False colours of zones in place of light: of what a ray meets first among surfaces and panes, each zone in the colour of its one
    /// value. The medium (but for a --slice) and backs of one-sided surfaces are looked through; grey has no value. A .png has a scale, an .exr the values themselves.
    #[arg(long, value_name = "FIELD", value_enum, help_heading = NUMBERS)]
    pub show: Option<Field>,
    /// Ends of the scale (default: those of what is seen). Beyond them the colours of the ends hold; net fluxes have zero in the middle of the colours.
    #[arg(long, value_name = "LOW,HIGH", allow_hyphen_values = true, requires = "show", help_heading = NUMBERS)]
    pub range: Option<String>,
    /// With --show temperature: the temperature of the medium where the plane across an axis at METRES cuts it, such as z=1.0.
    #[arg(long, value_name = "AXIS=METRES", requires = "show", help_heading = NUMBERS)]
    pub slice: Option<String>,
    /// A logarithmic scale, over three decades at most unless --range says more.
    #[arg(long, requires = "show", help_heading = NUMBERS)]
    pub log: bool,
}

const NUMBERS: &str = "Pictures of numbers";

/// How light becomes a picture, apart from its exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Exponent of the luminance about middle grey.
    pub contrast: f64,
    /// Share of the light that is scattered over the picture.
    pub bloom: f64,
    /// Stops above the automatic exposure.
    pub stops: f64,
}

impl Default for Look {
    fn default() -> Look {
        Look { contrast: 1.0, bloom: 0.0, stops: 0.0 }
    }
}

impl Look {
    /// What the arguments say, checked.
    pub fn of(args: &Args) -> Result<Look, Failure> {
        let plain = Look::default();
        let look = Look {
            contrast: args.contrast.unwrap_or(plain.contrast),
            bloom: args.bloom,
            stops: args.stops.unwrap_or(plain.stops),
        };
        for (flag, x, range) in [
            ("--stops", look.stops, -30.0..=30.0),
            ("--contrast", look.contrast, 0.1..=10.0),
            ("--bloom", look.bloom, 0.0..=1.0),
        ] {
            if !range.contains(&x) {
                let (from, to) = range.into_inner();
                return Err(Failure::new(format!(
                    "{flag}: {x} is out of range; give a number between {from} and {to}"
                )));
            }
        }
        Ok(look)
    }
    /// Development with an exposure that these stops are added to.
    pub fn tone(&self, exposure: f64) -> Tone {
        Tone { contrast: self.contrast, ..Tone::filmic(exposure * self.stops.exp2()) }
    }
    /// The picture with its bloom.
    pub fn scattered(&self, image: Image) -> Image {
        if self.bloom > 0.0 { zonal_render::bloom(&image, self.bloom) } else { image }
    }
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

/// The camera that the arguments ask for, with its lens.
fn camera(args: &Args, solution: &Solution) -> Result<Camera, Failure> {
    let mut camera = find_camera(solution, args.camera.as_deref())?.clone();
    camera.lens.aperture = args.aperture.unwrap_or(camera.lens.aperture);
    camera.lens.focus = args.focus.or(camera.lens.focus);
    Ok(camera)
}

/// Refuses lenses that are none.
fn check_lens(args: &Args) -> Result<(), Failure> {
    if args.aperture.is_some_and(|x| !(x.is_finite() && x >= 0.0)) {
        return Err(Failure::new("--aperture: give the lens's diameter in metres, from 0"));
    }
    if args.focus.is_some_and(|x| !(x.is_finite() && x > 0.0)) {
        return Err(Failure::new("--focus: give a distance in metres above 0"));
    }
    Ok(())
}

/// Runs the command.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    if let Some(field) = args.show {
        return super::show::run(args, field, context);
    }
    if let Some(path) = &args.animate {
        return super::animate::run(args, path, context);
    }
    let (width, height) = parse_size(&args.size)?;
    let look = Look::of(args)?;
    check_lens(args)?;
    check_output(&args.output, &["png", "exr"])?;
    if is_linear(&args.output) {
        for (flag, given) in [("--stops", args.stops), ("--contrast", args.contrast)] {
            if given.is_some() {
                let what = "an .exr holds radiance as it is; leave it out, or write a .png";
                return Err(Failure::new(format!("{flag}: {what}")));
            }
        }
    }
    let solution = read_light(&args.run)?;
    let camera = camera(args, &solution)?;
    if args.focus.is_some() && camera.lens.aperture == 0.0 {
        return Err(Failure::new("--focus: a pinhole is sharp everywhere; give the lens an --aperture too"));
    }
    let image =
        zonal_render::render(&solution, &camera, &options(args, (width, height)), &Meter::new(context.quiet));
    let saved = save(&args.output, image, &look)?;
    let written = args.output.display();
    let warnings: Vec<Note> = zonal_solve::forecast::sky_in_medium(&solution.scene).into_iter().collect();
    if context.json {
        say(&format!(
            "{}",
            serde_json::json!({
                "camera": camera.name, "width": width, "height": height, "samples": args.samples,
                "exposure": saved.tone.map(|t| t.exposure), "clipped": saved.clipped, "mean": saved.mean,
                "written": written.to_string(),
                "warnings": output::notes_json(&warnings),
            })
        ))?;
        return context.judge(&warnings);
    }
    say(&format!("{}: {width}×{height} written: {written}", camera.name))?;
    for w in &warnings {
        say(&w.line())?;
    }
    match saved.clipped.map(|n| n as f64 / (width * height) as f64) {
        Some(share) if share > 1e-3 => {
            say(&format!(
                "{:.1} % of the pixels are clipped; --stops -1 darkens the picture",
                100.0 * share
            ))?;
        }
        _ => {}
    }
    context.judge(&warnings)
}

/// What the arguments say of rays.
pub fn options(args: &Args, (width, height): (usize, usize)) -> RenderOptions {
    let samples = args.samples.unwrap_or(ADAPTIVE) as usize;
    RenderOptions { width, height, samples, gather: args.gather as usize, ..RenderOptions::default() }
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

/// A picture that was written.
pub struct Saved {
    /// How a PNG was developed.
    pub tone: Option<Tone>,
    /// Pixels of a PNG that are clipped.
    pub clipped: Option<usize>,
    /// Mean radiance, W/(m² sr).
    pub mean: [f64; 3],
}

/// True where a picture's name asks for numbers as they are.
pub fn is_linear(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"))
}

/// Writes a picture by its name's ending. Bloom does not change the exposure.
pub fn save(path: &Path, image: Image, look: &Look) -> Result<Saved, Failure> {
    let tone = (!is_linear(path)).then(|| look.tone(output::auto_exposure(&image.pixels)));
    let image = look.scattered(image);
    match &tone {
        Some(tone) => output::write_png(path, image.width, image.height, &image.pixels, tone)?,
        None => output::write_exr(path, image.width, image.height, &image.pixels)?,
    }
    let clipped = tone.map(|t| t.clipped(&image.pixels));
    Ok(Saved { tone, clipped, mean: mean(&image) })
}

fn mean(image: &Image) -> [f64; 3] {
    let n = image.pixels.len().max(1) as f64;
    image.pixels.iter().fold([0.0; 3], |s, p| [0, 1, 2].map(|b| s[b] + p[b] as f64 / n))
}
