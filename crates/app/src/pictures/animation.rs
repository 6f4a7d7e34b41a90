//! The frames of a camera animation, and a video of them.
//!
//! Every frame carries a fingerprint of everything that it depends on; an existing frame with its fingerprint is not drawn again. Lights are scaled in the
//! solution ([`zonal_solve::relight`]), without a solve.

use super::camera_animation::{AnimationFrame, animation_frames};
use super::camera_choice::turntable;
use super::options::{DrawOptions, KeySource};
use super::style::PictureStyle;
use crate::solving::if_all_succeeded;
use rayon::prelude::*;
use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use zonal_io::input::{self, CameraPath};
use zonal_io::output::{self, ToneMapping};
use zonal_math::low_discrepancy;
use zonal_render::RenderOptions;
use zonal_report::{Failure, check_output};
use zonal_scene::{Bands, NoProgress, Progress, SceneError, Solution};
use zonal_solve::distribution::Communicator;
use zonal_solve::relight;

/// Keyword of the fingerprint in a PNG.
const FINGERPRINT_KEYWORD: &str = "frame";

/// Width of the pictures for the automatic exposure, pixels.
const EXPOSURE_PREVIEW_WIDTH: usize = 96;
/// Largest number of key frames for the automatic exposure.
const MAX_EXPOSURE_PREVIEWS: usize = 24;

/// A frame with its file.
struct FrameFile {
    frame: AnimationFrame,
    tone: ToneMapping,
    path: PathBuf,
    fingerprint: String,
}

/// Settings of all frames.
struct FrameSettings {
    exposure: f64,
    options: RenderOptions,
    style: PictureStyle,
}

impl KeySource {
    /// The failure of a frame whose camera is not valid.
    fn failure(&self, e: &SceneError) -> Failure {
        match self {
            KeySource::File(path) => Failure::in_file(path, format!("{e}; move the keys around this time")),
            KeySource::Turntable(_) => {
                Failure::new(format!("--turntable: {e}; give a camera that does not look straight down"))
            }
        }
    }
}

/// Refuses options that are not valid or do not apply, and folders that cannot be written; returns the style of the frames.
pub(super) fn check(options: &DrawOptions) -> Result<PictureStyle, Failure> {
    options.check_size_and_rays()?;
    let style = PictureStyle::new(options)?;
    if options.aperture.is_some() || options.focus.is_some() {
        return Err(Failure::new(
            "--aperture, --focus: frames have the lenses of their cameras; leave these options out",
        ));
    }
    if matches!(options.keys, Some(KeySource::File(_))) && !options.view.is_default() {
        return Err(Failure::new("--camera: the key frames have cameras of their own; leave it out"));
    }
    check_folder(&options.output)?;
    Ok(style)
}

/// Draws the frames that are missing, of a solution that pictures show, and the video. Processes draw some frames each, and the first
/// one makes the video.
pub(super) fn write(
    drawn: &DrawOptions,
    source: &KeySource,
    style: PictureStyle,
    solution: &Solution,
    progress: &dyn Progress,
    communicator: &dyn Communicator,
) -> Result<AnimationSummary, Failure> {
    let (options, size, output) = (drawn.render_options(), drawn.size, &drawn.output);
    let keys = match source {
        KeySource::File(path) => read_keys(path, solution)?,
        KeySource::Turntable(count) => {
            turntable(&drawn.view.select(solution, size)?, *count, solution.groups.len())
        }
    };
    let frames = animation_frames(&keys);
    for f in &frames {
        f.camera.check().map_err(|e| source.failure(&e))?;
    }
    // Draw the frames that are missing.
    let exposure = keys.exposure.map_or_else(|| common_exposure(solution, &keys, &options), Ok)?;
    let folder = std::fs::create_dir_all(output).map_err(|e| {
        Failure::new(format!("{}: the folder cannot be created ({e}); choose another", output.display()))
    });
    if_all_succeeded(folder, communicator)?;
    let settings = FrameSettings { exposure, options, style };
    let files = frame_files(frames, solution, &settings, output);
    let (rank, ranks, count) = (communicator.rank(), communicator.size(), files.len());
    let own: Vec<FrameFile> = files.into_iter().skip(rank).step_by(ranks).collect();
    let drawn = if_all_succeeded(draw_missing(solution, &own, &settings, progress), communicator)?;
    let drawn = drawn.of_all(communicator);
    let mut video = Ok(None);
    if rank == 0 {
        output::remove_stale_temporaries(output);
        // Encode the video.
        video = encode_video(output, keys.frames_per_second, count);
    }
    Ok(AnimationSummary { size, exposure, frames: count, drawn, video })
}

/// The frames of an animation.
pub struct AnimationSummary {
    /// Pixels across and down.
    pub size: (usize, usize),
    /// Exposure of all frames without their stops.
    pub exposure: f64,
    /// Number of frames.
    pub frames: usize,
    /// Frames that were drawn; the other frames existed.
    pub drawn: DrawnFrames,
    /// The video; none of a single frame; the reason and the command if it could not be encoded.
    pub video: Result<Option<PathBuf>, String>,
}

/// Refuses a folder that cannot be created or written, before any work.
fn check_folder(path: &Path) -> Result<(), Failure> {
    if path.exists() && !path.is_dir() {
        let reason = "is a file; with --animate and --turntable name a folder for the frames";
        return Err(Failure::new(format!("{}: {reason}", path.display())));
    }
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    if ["png", "exr", "mp4"].contains(&extension.as_str()) {
        let reason = "with --animate and --turntable the output is a folder for the frames; name one without this extension";
        return Err(Failure::new(format!("{}: {reason}", path.display())));
    }
    let inside = if path.is_dir() { path.join("frame.png") } else { path.with_extension("png") };
    check_output(&inside, &["png"])
}

/// The key frames, with a focus distance at every key, and lights that exist.
fn read_keys(path: &Path, solution: &Solution) -> Result<CameraPath, Failure> {
    let groups: Vec<&str> = solution.groups.iter().map(|g| g.name.as_str()).collect();
    let mut keys = input::read_camera_path(path, solution.scene.cameras(), &groups)?;
    for key in &keys.keys {
        let scaled = scaled_groups(solution, &key.lights);
        if !scaled.is_empty() {
            let at = |e| Failure::in_file(path, format!("{}.lights: {e}", key.camera.name));
            relight::check(&solution.groups, &scaled).map_err(at)?;
        }
    }
    if keys.keys.iter().any(|k| k.camera.lens.aperture > 0.0) {
        let cameras: Vec<_> = keys.keys.iter().map(|k| k.camera.clone()).collect();
        let seen = zonal_render::focus_distances(solution, &cameras);
        for (key, distance) in keys.keys.iter_mut().zip(seen) {
            let c = &mut key.camera;
            c.lens.focus = c.lens.focus.or(distance).or(Some((c.target - c.origin).length()));
        }
    }
    Ok(keys)
}

/// The light groups with a factor other than 1, with their factors.
fn scaled_groups(solution: &Solution, lights: &[Bands]) -> Vec<(String, Bands)> {
    let scaled = solution.groups.iter().zip(lights).filter(|(_, f)| **f != Bands::ONE);
    scaled.map(|(g, f)| (g.name.clone(), *f)).collect()
}

/// The solution with its light groups scaled.
fn relit<'a>(solution: &'a Solution, lights: &[Bands]) -> Result<Cow<'a, Solution>, Failure> {
    let scaled = scaled_groups(solution, lights);
    if scaled.is_empty() {
        return Ok(Cow::Borrowed(solution));
    }
    Ok(Cow::Owned(relight::relight(solution.clone(), &scaled)?))
}

/// The automatic exposure of all frames: the lower median of the exposures of small pictures at the keys, black ones excluded.
fn common_exposure(solution: &Solution, keys: &CameraPath, options: &RenderOptions) -> Result<f64, Failure> {
    let height = (EXPOSURE_PREVIEW_WIDTH * options.height)
        .div_ceil(options.width)
        .clamp(1, 4 * EXPOSURE_PREVIEW_WIDTH);
    let small = RenderOptions { width: EXPOSURE_PREVIEW_WIDTH, height, samples: 1, ..options.clone() };
    let step = keys.keys.len().div_ceil(MAX_EXPOSURE_PREVIEWS);
    let mut exposures = Vec::new();
    for key in keys.keys.iter().step_by(step) {
        let lit = relit(solution, &key.lights)?;
        let image = zonal_render::render(&lit, &key.camera, &small, &NoProgress);
        if image.pixels.iter().flatten().any(|x| *x > 0.0) {
            exposures.push(output::auto_exposure(&image.pixels));
        }
    }
    exposures.sort_by(f64::total_cmp);
    Ok(exposures.get(exposures.len().saturating_sub(1) / 2).copied().unwrap_or(1.0))
}

/// Files and fingerprints of the frames.
fn frame_files(
    frames: Vec<AnimationFrame>,
    solution: &Solution,
    settings: &FrameSettings,
    folder: &Path,
) -> Vec<FrameFile> {
    let FrameSettings { exposure, options, style } = settings;
    let file = |(i, frame): (usize, AnimationFrame)| {
        let tone = style.tone_mapping(exposure * frame.stops.exp2());
        let text = format!(
            "{} {frame:?} {tone:?} {options:?} {style:?} {}",
            solution.scene_hash,
            env!("CARGO_PKG_VERSION")
        );
        let path = folder.join(format!("frame-{:05}.png", i + 1));
        FrameFile { frame, tone, path, fingerprint: fingerprint(&text) }
    };
    frames.into_iter().enumerate().map(file).collect()
}

/// A hash of a text, 16 hexadecimal digits.
fn fingerprint(text: &str) -> String {
    format!("{:016x}", text.bytes().fold(0, |h, b| low_discrepancy::split_mix64(h ^ b as u64)))
}

/// Counts of the frames that were drawn.
#[derive(Default)]
pub struct DrawnFrames {
    /// Number of frames.
    pub frames: usize,
    /// Number of their clipped pixels.
    pub clipped: usize,
}

impl DrawnFrames {
    /// The counts of all processes.
    fn of_all(self, communicator: &dyn Communicator) -> DrawnFrames {
        let own = [self.frames, self.clipped].map(|n| n as u64);
        let all = communicator.all_gather(own.iter().flat_map(|n| n.to_le_bytes()).collect());
        let at =
            |bytes: &Vec<u8>, k: usize| bytes.as_chunks::<8>().0.get(k).map_or(0, |n| u64::from_le_bytes(*n));
        let [frames, clipped] = [0, 1].map(|k| all.iter().map(|bytes| at(bytes, k) as usize).sum());
        DrawnFrames { frames, clipped }
    }
}

/// Draws the missing frames, those with the same light groups together.
fn draw_missing(
    solution: &Solution,
    files: &[FrameFile],
    settings: &FrameSettings,
    progress: &dyn Progress,
) -> Result<DrawnFrames, Failure> {
    let FrameSettings { options, style, .. } = settings;
    let is_missing = |f: &&FrameFile| {
        output::read_png_text(&f.path, FINGERPRINT_KEYWORD).as_deref() != Some(f.fingerprint.as_str())
    };
    let missing: Vec<&FrameFile> = files.par_iter().filter(is_missing).collect();
    progress.begin("frames", (missing.len() * options.height) as u64);
    let mut drawn = DrawnFrames::default();
    for same in missing.chunk_by(|a, b| a.frame.lights == b.frame.lights) {
        let lit = relit(solution, &same[0].frame.lights)?;
        let cameras: Vec<_> = same.iter().map(|f| f.frame.camera.clone()).collect();
        zonal_render::render_each(&lit, &cameras, options, &RowsOfAllFrames(progress), |i, image| {
            let (f, image) = (same[i], style.with_bloom(image));
            drawn.frames += 1;
            drawn.clipped += f.tone.count_clipped(&image.pixels);
            let size = (image.width, image.height);
            let text = [(FINGERPRINT_KEYWORD, f.fingerprint.as_str())];
            output::write_png_with_text(&f.path, size.0, size.1, &image.pixels, &f.tone, &text)
        })?;
    }
    progress.end();
    Ok(drawn)
}

/// One progress bar for the rows of all frames.
struct RowsOfAllFrames<'a>(&'a dyn Progress);

impl Progress for RowsOfAllFrames<'_> {
    fn begin(&self, _: &str, _: u64) {}
    fn advance(&self, steps: u64) {
        self.0.advance(steps);
    }
    fn end(&self) {}
    fn is_interrupted(&self) -> bool {
        self.0.is_interrupted()
    }
}

/// Options of ffmpeg for the input: errors only, overwrite, frames by number.
fn ffmpeg_input<'a>(rate: &'a str, frames: &'a str) -> [&'a str; 9] {
    ["-v", "error", "-y", "-framerate", rate, "-i", "frame-%05d.png", "-frames:v", frames]
}

/// Options of ffmpeg for the output: even sides, H.264, and the colour matrix that players assume for high definition.
const FFMPEG_OUTPUT: [&str; 16] = [
    "-vf",
    "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv",
    "-c:v",
    "libx264",
    "-crf",
    "17",
    "-pix_fmt",
    "yuv420p",
    "-movflags",
    "+faststart",
    "-colorspace",
    "bt709",
    "-color_primaries",
    "bt709",
    "-color_trc",
    "iec61966-2-1",
];

/// Encodes a video of the frames with ffmpeg; none of a single frame. An error is the reason, and the command to run.
fn encode_video(folder: &Path, rate: f64, frames: usize) -> Result<Option<PathBuf>, String> {
    if frames < 2 {
        return Ok(None);
    }
    let (rate, frames) = (rate.to_string(), frames.to_string());
    let arguments = |name: &'static str| -> Vec<&str> {
        [ffmpeg_input(&rate, &frames).as_slice(), &FFMPEG_OUTPUT, &[name]].concat()
    };
    // Encode under a temporary name, which becomes the name of the video on success.
    let partial = ".animation.partial.mp4";
    let run =
        Command::new("ffmpeg").args(arguments(partial)).current_dir(folder).stdin(Stdio::null()).output();
    let reason = match run {
        Ok(o) if o.status.success() => {
            match std::fs::rename(folder.join(partial), folder.join("animation.mp4")) {
                Ok(()) => return Ok(Some(folder.join("animation.mp4"))),
                Err(e) => format!("the video cannot be written ({e})"),
            }
        }
        Ok(o) => {
            let message = String::from_utf8_lossy(&o.stderr);
            format!("ffmpeg failed ({})", message.lines().next_back().unwrap_or("no reason given"))
        }
        Err(_) => "no video: ffmpeg is not installed".into(),
    };
    let _ = std::fs::remove_file(folder.join(partial));
    let words = arguments("animation.mp4")
        .iter()
        .map(|w| if w.contains('(') { format!("'{w}'") } else { w.to_string() })
        .collect::<Vec<_>>()
        .join(" ");
    Err(format!("{reason}; to encode one, install it and run in {}: ffmpeg {words}", folder.display()))
}
