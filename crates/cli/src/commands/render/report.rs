//! Output of `zonal render`.

use super::Args;
use serde_json::{Value, json};
use zonal_app::pictures::{AnimationSummary, Drawing, FieldPictureSummary, LightPictureSummary};
use zonal_report::{Failure, say};

/// Fraction of clipped pixels above which the command suggests a lower exposure.
const CLIPPED_FRACTION_NOTE: f64 = 1e-3;

/// The properties of a drawing as JSON.
pub(super) fn json_of(drawing: &Drawing, args: &Args) -> Value {
    match drawing {
        Drawing::Light(summary) => light_json(summary, args),
        Drawing::Field(summary) => field_json(summary, args),
        Drawing::Frames(summary) => frames_json(summary, args),
    }
}

/// Prints the properties of a drawing.
pub(super) fn print(drawing: &Drawing, args: &Args) -> Result<(), Failure> {
    match drawing {
        Drawing::Light(summary) => print_light(summary, args),
        Drawing::Field(summary) => print_field(summary, args),
        Drawing::Frames(summary) => print_frames(summary, args),
    }
}

fn light_json(s: &LightPictureSummary, args: &Args) -> Value {
    let LightPictureSummary { camera, saved, warnings } = s;
    let (width, height) = saved.size;
    json!({
        "camera": camera.name, "width": width, "height": height, "samples": args.samples,
        "exposure": saved.tone.map(|t| t.exposure), "clipped": saved.clipped, "mean": saved.mean,
        "written": args.output.display().to_string(),
        "warnings": zonal_io::output::notes_json(warnings),
    })
}

fn print_light(s: &LightPictureSummary, args: &Args) -> Result<(), Failure> {
    let LightPictureSummary { camera, saved, warnings } = s;
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

fn field_json(s: &FieldPictureSummary, args: &Args) -> Value {
    let (width, height) = s.size;
    json!({
        "camera": s.camera.name, "width": width, "height": height, "show": s.quantity.name(), "slice": args.slice,
        "unit": s.quantity.unit(), "range": s.scale_range.map(|r| [r.0, r.1]),
        "visible_range": s.visible_range.map(|r| [r.0, r.1]), "without_value": s.without_value,
        "out_of_range": s.out_of_range, "written": args.output.display().to_string(),
    })
}

fn print_field(s: &FieldPictureSummary, args: &Args) -> Result<(), Failure> {
    let ((width, height), written) = (s.size, args.output.display());
    let (name, unit) = (s.quantity.name(), s.quantity.unit());
    let range = match s.visible_range {
        Some((low, high)) => format!(" from {} to {} {unit}", six_digits(low), six_digits(high)),
        None => " without values".into(),
    };
    say(&format!("{}: {width}×{height}, {name}{range}, written: {written}", s.camera.name))?;
    match (s.without_value, s.out_of_range.unwrap_or(0)) {
        (0, 0) => Ok(()),
        (0, n) => say(&format!("{n} pixels are out of range and have the colours of its ends")),
        (n, _) => say(&format!("{n} pixels show zones without a value, grey")),
    }
}

/// A number rounded to six significant digits.
fn six_digits(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x)
}

fn frames_json(s: &AnimationSummary, args: &Args) -> Value {
    let (width, height) = s.size;
    let video = s.video.as_ref().ok().and_then(|v| v.as_ref());
    json!({
        "frames": s.frames, "drawn": s.drawn.frames, "width": width, "height": height, "samples": args.samples,
        "exposure": s.exposure, "clipped": s.drawn.clipped, "written": args.output.display().to_string(),
        "video": video.map(|v| v.display().to_string()),
    })
}
fn print_frames(s: &AnimationSummary, args: &Args) -> Result<(), Failure> {
    let ((width, height), folder) = (s.size, args.output.display());
    let (frames, exposure) = (s.frames, s.exposure);
    say(&format!("{folder}: {frames} frames of {width}×{height}, exposure {exposure:.4e}"))?;
    let existing = frames - s.drawn.frames;
    if existing > 0 {
        say(&format!("{existing} of them existed already; delete a frame to draw it again"))?;
    }
    match &s.video {
        Ok(Some(v)) => say(&format!("video written: {}", v.display())),
        Ok(None) => Ok(()),
        Err(reason) => say(reason),
    }
}
