//! `zonal render --animate`: the frames of a flight, and a video of them.
//!
//! A frame's picture carries a mark of all that it depends on; frames that are there with their mark are not drawn again. Lights are
//! turned in the solution (`relight`), which solves nothing.

use super::render::{Args, Look, parse_size};
use super::{Context, read_light};
use crate::failure::say;
use crate::flight::{Shot, shots};
use crate::{Failure, meter::Meter};
use rayon::prelude::*;
use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use zonal_io::input::{self, Flight};
use zonal_io::output::{self, Tone};
use zonal_math::sequence;
use zonal_render::RenderOptions;
use zonal_scene::{Bands, Progress, Quiet, Solution};
use zonal_solve::relight;

/// Keyword of the mark in a frame.
const MARK: &str = "frame";

/// Width of the pictures that the automatic exposure is taken from, and how many keys have one at most.
const PREVIEW: (usize, usize) = (96, 24);

/// A frame that is to be there: what it shows, its file and its mark.
struct Frame {
    shot: Shot,
    tone: Tone,
    path: PathBuf,
    mark: String,
}

/// Runs the command.
pub fn run(args: &Args, path: &Path, context: Context) -> Result<(), Failure> {
    let (width, height) = parse_size(&args.size)?;
    let look = Look::of(args)?;
    check_folder(&args.output)?;
    let options = super::render::options(args, (width, height));
    let solution = read_light(&args.run)?;
    let flight = read(path, &solution)?;
    let shots = shots(&flight);
    for s in &shots {
        s.camera
            .check()
            .map_err(|e| Failure::in_file(path, format!("{e}; move the keys around this time")))?;
    }
    let exposure = flight.exposure.map_or_else(|| exposure(&solution, &flight, &options), Ok)?;
    std::fs::create_dir_all(&args.output).map_err(|e| {
        Failure::new(format!("{}: the folder cannot be made ({e}); choose another", args.output.display()))
    })?;
    let frames = frames(shots, &solution, exposure, &options, &look, &args.output);
    let drawn = draw(&solution, &frames, &options, &look, context)?;
    output::remove_stale(&args.output);
    let video = video(&args.output, flight.frames_per_second, frames.len());
    let folder = args.output.display();
    if context.json {
        return say(&format!(
            "{}",
            serde_json::json!({
                "frames": frames.len(), "drawn": drawn.frames, "width": width, "height": height, "samples": args.samples,
                "exposure": exposure, "clipped": drawn.clipped, "written": folder.to_string(),
                "video": video.as_ref().ok().and_then(|v| v.as_ref()).map(|v| v.display().to_string()),
            })
        ));
    }
    let kept = frames.len() - drawn.frames;
    say(&format!("{folder}: {} frames of {width}×{height}, exposure {exposure:.4e}", frames.len()))?;
    if kept > 0 {
        say(&format!("{kept} of them were there already; delete a frame to draw it again"))?;
    }
    match video {
        Ok(Some(v)) => say(&format!("video written: {}", v.display())),
        Ok(None) => Ok(()),
        Err(why) => say(&why),
    }
}

/// Refuses a folder that cannot be made or written, before any work.
fn check_folder(path: &Path) -> Result<(), Failure> {
    if path.exists() && !path.is_dir() {
        let what = "is a file; with --animate name a folder for the frames";
        return Err(Failure::new(format!("{}: {what}", path.display())));
    }
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    if ["png", "exr", "mp4"].contains(&ending.as_str()) {
        let what = "with --animate the output is a folder for the frames; name one without this ending";
        return Err(Failure::new(format!("{}: {what}", path.display())));
    }
    let inside = if path.is_dir() { path.join("frame.png") } else { path.with_extension("png") };
    super::check_output(&inside, &["png"])
}

/// The flight, with a focus at every key and lights that can be turned.
fn read(path: &Path, solution: &Solution) -> Result<Flight, Failure> {
    let groups: Vec<&str> = solution.groups.iter().map(|g| g.name.as_str()).collect();
    let mut flight = input::read_flight(path, solution.scene.cameras(), &groups)?;
    for key in &flight.keys {
        let wanted = wanted(solution, &key.lights);
        if !wanted.is_empty() {
            let at = |e| Failure::in_file(path, format!("{}.lights: {e}", key.camera.name));
            relight::check(&solution.groups, &wanted).map_err(at)?;
        }
    }
    if flight.keys.iter().any(|k| k.camera.lens.aperture > 0.0) {
        let cameras: Vec<_> = flight.keys.iter().map(|k| k.camera.clone()).collect();
        let seen = zonal_render::middle_distances(solution, &cameras);
        for (key, distance) in flight.keys.iter_mut().zip(seen) {
            let c = &mut key.camera;
            c.lens.focus = c.lens.focus.or(distance).or(Some((c.target - c.origin).length()));
        }
    }
    Ok(flight)
}

/// The groups that are turned, with their factors.
fn wanted(solution: &Solution, lights: &[Bands]) -> Vec<(String, Bands)> {
    let turned = solution.groups.iter().zip(lights).filter(|(_, f)| **f != [1.0; 3]);
    turned.map(|(g, f)| (g.name.clone(), *f)).collect()
}

/// The solution with its lights turned.
fn lit<'a>(solution: &'a Solution, lights: &[Bands]) -> Result<Cow<'a, Solution>, Failure> {
    let wanted = wanted(solution, lights);
    if wanted.is_empty() {
        return Ok(Cow::Borrowed(solution));
    }
    Ok(Cow::Owned(relight::relight(solution.clone(), &wanted)?))
}

/// The automatic exposure of all frames: the lower median of those of small pictures at the keys that are not black.
fn exposure(solution: &Solution, flight: &Flight, options: &RenderOptions) -> Result<f64, Failure> {
    let height = (PREVIEW.0 * options.height).div_ceil(options.width).clamp(1, 4 * PREVIEW.0);
    let small = RenderOptions { width: PREVIEW.0, height, samples: 1, ..options.clone() };
    let step = flight.keys.len().div_ceil(PREVIEW.1);
    let mut found = Vec::new();
    for key in flight.keys.iter().step_by(step) {
        let lit = lit(solution, &key.lights)?;
        let image = zonal_render::render(&lit, &key.camera, &small, &Quiet);
        if image.pixels.iter().flatten().any(|x| *x > 0.0) {
            found.push(output::auto_exposure(&image.pixels));
        }
    }
    found.sort_by(f64::total_cmp);
    Ok(found.get(found.len().saturating_sub(1) / 2).copied().unwrap_or(1.0))
}

fn frames(
    shots: Vec<Shot>,
    solution: &Solution,
    exposure: f64,
    options: &RenderOptions,
    look: &Look,
    folder: &Path,
) -> Vec<Frame> {
    let frame = |(i, shot): (usize, Shot)| {
        let tone = look.tone(exposure * shot.stops.exp2());
        let all = format!(
            "{} {shot:?} {tone:?} {options:?} {look:?} {}",
            solution.scene_hash,
            env!("CARGO_PKG_VERSION")
        );
        Frame { shot, tone, path: folder.join(format!("frame-{:05}.png", i + 1)), mark: mark(&all) }
    };
    shots.into_iter().enumerate().map(frame).collect()
}

/// A hash of a text, 16 hexadecimal digits.
fn mark(text: &str) -> String {
    format!("{:016x}", text.bytes().fold(0, |h, b| sequence::hash(h ^ b as u64)))
}

/// What was drawn.
#[derive(Default)]
struct Drawn {
    frames: usize,
    clipped: usize,
}

/// Draws what is not there, frames of the same light together.
fn draw(
    solution: &Solution,
    frames: &[Frame],
    options: &RenderOptions,
    look: &Look,
    context: Context,
) -> Result<Drawn, Failure> {
    let missing = |f: &&Frame| output::png_note(&f.path, MARK).as_deref() != Some(f.mark.as_str());
    let open: Vec<&Frame> = frames.par_iter().filter(missing).collect();
    let meter = Meter::new(context.quiet);
    meter.begin("frames", (open.len() * options.height) as u64);
    let mut drawn = Drawn::default();
    for same in open.chunk_by(|a, b| a.shot.lights == b.shot.lights) {
        let lit = lit(solution, &same[0].shot.lights)?;
        let cameras: Vec<_> = same.iter().map(|f| f.shot.camera.clone()).collect();
        zonal_render::render_each(&lit, &cameras, options, &Rows(&meter), |i, image| {
            let (f, image) = (same[i], look.scattered(image));
            drawn.frames += 1;
            drawn.clipped += f.tone.clipped(&image.pixels);
            let size = (image.width, image.height);
            output::write_png_noted(&f.path, size, &image.pixels, &f.tone, &[(MARK, &f.mark)])
        })?;
    }
    meter.end();
    Ok(drawn)
}

/// One bar for the rows of all frames.
struct Rows<'a>(&'a Meter);

impl Progress for Rows<'_> {
    fn begin(&self, _: &str, _: u64) {}
    fn advance(&self, steps: u64) {
        self.0.advance(steps);
    }
    fn end(&self) {}
}

/// A video of the frames; none of a single one. Where ffmpeg is not at hand or fails, what to run.
fn video(folder: &Path, rate: f64, frames: usize) -> Result<Option<PathBuf>, String> {
    if frames < 2 {
        return Ok(None);
    }
    let (rate, frames) = (rate.to_string(), frames.to_string());
    // Even sides, and the matrix that players take for high definition.
    let filter = "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv";
    let colours = ["-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "iec61966-2-1"];
    let start = [
        "-v",
        "error",
        "-y",
        "-framerate",
        &rate,
        "-i",
        "frame-%05d.png",
        "-frames:v",
        &frames,
        "-vf",
        filter,
    ];
    let coding = ["-c:v", "libx264", "-crf", "17", "-pix_fmt", "yuv420p", "-movflags", "+faststart"];
    let with = |name: &'static str| -> Vec<&str> { [start.as_slice(), &coding, &colours, &[name]].concat() };
    let partial = ".animation.partial.mp4";
    let run = Command::new("ffmpeg").args(with(partial)).current_dir(folder).stdin(Stdio::null()).output();
    let why = match run {
        Ok(o) if o.status.success() => {
            match std::fs::rename(folder.join(partial), folder.join("animation.mp4")) {
                Ok(()) => return Ok(Some(folder.join("animation.mp4"))),
                Err(e) => format!("the video cannot be written ({e})"),
            }
        }
        Ok(o) => {
            let said = String::from_utf8_lossy(&o.stderr);
            format!("ffmpeg failed ({})", said.lines().next_back().unwrap_or("no reason given"))
        }
        Err(_) => "no video: ffmpeg is not at hand".into(),
    };
    let _ = std::fs::remove_file(folder.join(partial));
    let words = with("animation.mp4")
        .iter()
        .map(|w| if w.contains('(') { format!("'{w}'") } else { w.to_string() })
        .collect::<Vec<_>>()
        .join(" ");
    Err(format!("{why}; for one, install it and run in {}: ffmpeg {words}", folder.display()))
}
