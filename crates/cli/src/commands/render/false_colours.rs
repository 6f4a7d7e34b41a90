//! A picture in false colours with its scale, or the values themselves.
//!
//! Every pixel has the value of the zone that its central ray meets first; values are not interpolated.

use super::args::{Args, FieldQuantity, is_linear, parse_size};
use crate::colour_scale::{ColourScale, finite_range};
use crate::commands::context::Context;
use crate::legend::{Canvas, Legend, beside};
use zonal_io::output::{self, ColourMap, ScalarImage};
use zonal_render::{ItemBuffer, PaneVisibility};
use zonal_report::plot::AxisScale;
use zonal_report::{Failure, check_output, say};
use zonal_scene::{Bands, Camera, Fields, Progress, Solution};

/// Linear colour of pixels without a zone.
const BACKGROUND: [f32; 3] = [1.0; 3];
/// Difference of values, relative to the largest temperature or radiosity, that is rounding.
const RELATIVE_ROUNDING: f64 = 1e-7;
/// Largest width or height, pixels.
const MAX_SIDE: usize = 16384;

impl FieldQuantity {
    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        ["temperature", "net-flux", "radiosity", "irradiance"][self as usize]
    }
    fn title(self) -> &'static str {
        ["Temperature", "Net flux", "Radiosity", "Irradiance"][self as usize]
    }
    fn unit(self) -> &'static str {
        if self == FieldQuantity::Temperature { "K" } else { "W/m2" }
    }
    /// True for quantities of thermal mode alone.
    #[must_use]
    pub fn is_thermal(self) -> bool {
        matches!(self, FieldQuantity::Temperature | FieldQuantity::NetFlux)
    }
    fn colour_map(self) -> ColourMap {
        if self == FieldQuantity::NetFlux { ColourMap::Diverging } else { ColourMap::Sequential }
    }

    /// The value of every zone, and the difference that is rounding; `None` if the mode of the solution lacks the quantity.
    #[must_use]
    pub fn values(self, s: &Solution) -> Option<(Vec<f64>, f64)> {
        let (f, heat) = (&s.fields, s.fields.heat.as_ref());
        let largest =
            |list: &[f64]| list.iter().filter(|x| x.is_finite()).fold(0.0, |m: f64, x| m.max(x.abs()));
        // The sum over the bands in thermal mode, the mean in light mode as in the viewer.
        let is_rgb = s.scene.bands().is_rgb();
        let scalar = |i: usize, of: fn(&Fields, usize) -> Bands| {
            if is_rgb {
                let v = of(f, i);
                return s.scene.thermal().map_or(v.mean(), |t| t.band_fractions.total(v));
            }
            let all = s.all_bands(|t| of(&t.fields, i));
            let sum: f64 = all.iter().sum();
            if s.scene.thermal().is_some() { sum } else { sum / all.len() as f64 }
        };
        let zones = 0..s.zones.len();
        let radiosity = || zones.clone().map(|i| scalar(i, |f, i| f.radiosity[i])).collect::<Vec<f64>>();
        let values = match self {
            FieldQuantity::Temperature => heat?.temperature.clone(),
            FieldQuantity::NetFlux => {
                // W/m³ of a pane times its thickness.
                let mut net = heat?.net.clone();
                let panes = net[s.zones.pane_offset()..].iter_mut();
                panes.zip(&s.zones.panes).for_each(|(q, z)| *q *= z.thickness);
                net
            }
            FieldQuantity::Radiosity => radiosity(),
            FieldQuantity::Irradiance => {
                let [indirect, direct]: [fn(&Fields, usize) -> Bands; 2] =
                    [|f, i| f.incident[i], |f, i| f.direct_light(i)];
                zones.clone().map(|i| scalar(i, indirect) + scalar(i, direct)).collect()
            }
        };
        let scale = if self == FieldQuantity::NetFlux { largest(&radiosity()) } else { largest(&values) };
        Some((values, RELATIVE_ROUNDING * scale))
    }
}

/// Settings of a picture in false colours, from the arguments.
pub(super) struct FieldPictureSettings {
    quantity: FieldQuantity,
    size: (usize, usize),
    range: Option<(f64, f64)>,
    slice: Option<(usize, f64)>,
    scale: AxisScale,
    /// True for the values themselves, false for colours.
    writes_values: bool,
}

impl FieldPictureSettings {
    pub(super) fn from_args(args: &Args, quantity: FieldQuantity) -> Result<FieldPictureSettings, Failure> {
        let size = parse_size(&args.size)?;
        if size.0.max(size.1) > MAX_SIDE {
            let reason = format!("with --show a side has at most {MAX_SIDE} pixels");
            return Err(Failure::new(format!("--size: '{}': {reason}", args.size)));
        }
        refuse_light_options(args)?;
        check_output(&args.output, &["png", "exr"])?;
        let writes_values = is_linear(&args.output);
        for (flag, given) in [("--range", args.range.is_some()), ("--log", args.log)] {
            if given && writes_values {
                let reason =
                    "does not apply to an .exr, which holds the values; leave it out, or write a .png";
                return Err(Failure::new(format!("{flag}: {reason}")));
            }
        }
        if args.log && quantity == FieldQuantity::NetFlux {
            return Err(Failure::new("--log: net fluxes have a sign; leave it out"));
        }
        let range = args.range.as_deref().map(parse_range).transpose()?;
        if args.log && range.is_some_and(|r| r.0 <= 0.0) {
            return Err(Failure::new(
                "--range: a logarithmic scale begins above 0; leave out --log, or raise the low end",
            ));
        }
        let slice = args.slice.as_deref().map(parse_slice).transpose()?;
        if slice.is_some() && quantity != FieldQuantity::Temperature {
            let reason = "a plane through the medium shows temperatures; leave it out, or show temperature";
            return Err(Failure::new(format!("--slice: {reason}")));
        }
        let scale = if args.log { AxisScale::Logarithmic } else { AxisScale::Linear };
        Ok(FieldPictureSettings { quantity, size, range, slice, scale, writes_values })
    }
}

/// Refuses options of pictures of light.
fn refuse_light_options(args: &Args) -> Result<(), Failure> {
    for (flag, given) in [
        ("--animate", args.animate.is_some()),
        ("--gather", args.gather.is_some_and(|n| n != 0)),
        ("--samples", args.samples.is_some()),
        ("--stops", args.stops.is_some()),
        ("--contrast", args.contrast.is_some()),
        ("--bloom", args.bloom != 0.0),
        ("--aperture", args.aperture.is_some()),
        ("--focus", args.focus.is_some()),
    ] {
        if given {
            let reason = "applies to pictures of light; leave it out, or leave out --show";
            return Err(Failure::new(format!("{flag}: {reason}")));
        }
    }
    Ok(())
}

/// The ends of a range from `LOW,HIGH`.
fn parse_range(text: &str) -> Result<(f64, f64), Failure> {
    let wrong = |why: &str| Failure::new(format!("--range: '{text}' {why}; write for example 400,1200"));
    let (low, high) = text.split_once(',').ok_or_else(|| wrong("is not LOW,HIGH"))?;
    let number = |s: &str| s.trim().parse::<f64>().map_err(|_| wrong("is not two numbers"));
    let (low, high) = (number(low)?, number(high)?);
    if !(low.is_finite() && high.is_finite()) {
        return Err(wrong("is not finite"));
    }
    if !(high - low).is_finite() {
        return Err(wrong("is too wide"));
    }
    if low >= high {
        return Err(wrong("has no low end below its high end"));
    }
    Ok((low, high))
}

/// Axis and coordinate, m, from `AXIS=METRES`.
fn parse_slice(text: &str) -> Result<(usize, f64), Failure> {
    let read = || {
        let (axis, coordinate) = text.split_once('=')?;
        let axis = ["x", "y", "z"].iter().position(|a| *a == axis.trim())?;
        Some((axis, coordinate.trim().parse::<f64>().ok().filter(|x| x.is_finite())?))
    };
    read()
        .ok_or_else(|| Failure::new(format!("--slice: '{text}' is not AXIS=METRES; write for example z=1.0")))
}

/// Refuses a plane outside of the medium.
///
/// # Errors
/// If the scene has no medium, or the plane does not cut it.
pub fn check_slice(s: &Solution, (axis, coordinate): (usize, f64)) -> Result<(), Failure> {
    let Some(grid) = s.scene.voxel_grid() else {
        return Err(Failure::new("--slice: the scene has no medium to cut; leave it out"));
    };
    let (low, high) = (grid.min()[axis], grid.max()[axis]);
    if !(low..=high).contains(&coordinate) {
        let axis = ["x", "y", "z"][axis];
        let reason = format!(
            "{axis}={coordinate} does not cut the medium, which is from {axis}={low} to {axis}={high}"
        );
        return Err(Failure::new(format!("--slice: {reason}")));
    }
    Ok(())
}

/// Visible values of a picture.
struct VisibleValues {
    /// The value of each pixel; NaN if the pixel has no zone or the zone no value.
    values: Vec<f64>,
    /// Number of pixels of zones without a value.
    without_value: usize,
}

/// Draws and writes a picture in false colours.
///
/// # Errors
/// As `zonal render`.
pub fn run(args: &Args, quantity: FieldQuantity, context: Context) -> Result<(), Failure> {
    // Check the arguments and read the solution.
    let settings = FieldPictureSettings::from_args(args, quantity)?;
    let solution = output::read_solution(&args.run)?;
    let summary = write(args, &settings, &solution, &context.progress())?;
    if context.json { summary.print_json(args) } else { summary.print_text(args) }
}

/// Draws and writes a picture in false colours of a solution.
pub(super) fn write(
    args: &Args,
    settings: &FieldPictureSettings,
    solution: &Solution,
    progress: &dyn Progress,
) -> Result<FieldPictureSummary, Failure> {
    let quantity = settings.quantity;
    let Some((values, rounding)) = quantity.values(solution) else {
        let reason = "exists only in mode = \"thermal\", and this is a solution of light; show radiosity or irradiance";
        return Err(Failure::in_file(&args.run, format!("--show: {} {reason}", quantity.name())));
    };
    if let Some(slice) = settings.slice {
        check_slice(solution, slice)?;
    }
    let camera = args.view.select(solution, settings.size)?;
    // Find the zone of each pixel.
    let view = item_buffer(settings, solution, &camera);
    let zones = view.zones(progress);
    check_visible(args, solution, quantity, (&zones, &camera))?;
    let visible = visible_values(&zones, &values);
    // Write values or colours.
    let scale = if settings.writes_values {
        write_values(args, settings, &visible)?;
        None
    } else {
        let (canvas, scale) = coloured(settings, (&view, &values, rounding), &visible, solution, progress)?;
        write_canvas(args, settings, &canvas, &scale)?;
        Some(scale)
    };
    Ok(FieldPictureSummary::new(settings, camera, &visible, scale))
}

/// A picture in false colours of the visible values, with their scale.
///
/// # Errors
/// If the solution lacks the quantity, or no visible zone has a value.
pub fn draw(
    solution: &Solution,
    quantity: FieldQuantity,
    (camera, size): (&Camera, (usize, usize)),
    progress: &dyn Progress,
) -> Result<Canvas, Failure> {
    let settings = FieldPictureSettings {
        quantity,
        size,
        range: None,
        slice: None,
        scale: AxisScale::Linear,
        writes_values: false,
    };
    let missing = || Failure::new(format!("the solution has no {}", quantity.name()));
    let (values, rounding) = quantity.values(solution).ok_or_else(missing)?;
    let view = item_buffer(&settings, solution, camera);
    let visible = visible_values(&view.zones(progress), &values);
    Ok(coloured(&settings, (&view, &values, rounding), &visible, solution, progress)?.0)
}

/// The zones that the pixels show.
fn item_buffer<'a>(settings: &FieldPictureSettings, s: &'a Solution, camera: &Camera) -> ItemBuffer<'a> {
    let is_thermal = settings.quantity.is_thermal();
    let panes = if is_thermal { PaneVisibility::Opaque } else { PaneVisibility::Transparent };
    let view = ItemBuffer::new(s, camera, settings.size.0, settings.size.1, panes);
    match settings.slice {
        Some((axis, coordinate)) => view.with_slice(axis, coordinate),
        None => view,
    }
}

/// The colours of the values of all zones with their scale beside them, and the scale.
fn coloured(
    settings: &FieldPictureSettings,
    (view, values, rounding): (&ItemBuffer, &[f64], f64),
    visible: &VisibleValues,
    s: &Solution,
    progress: &dyn Progress,
) -> Result<(Canvas, ColourScale), Failure> {
    let scale = choose_scale(settings, visible, rounding)?;
    let colour = |z: Option<usize>| z.map_or(BACKGROUND, |z| scale.colour(values[z]));
    let picture = view.false_colours(&colour, progress);
    let canvas = colour_canvas(settings, (&picture, &scale, visible.without_value), s);
    Ok((canvas, scale))
}

/// Refuses a picture without any zone.
fn check_visible(
    args: &Args,
    solution: &Solution,
    quantity: FieldQuantity,
    (zones, camera): (&[Option<u32>], &Camera),
) -> Result<(), Failure> {
    if zones.iter().any(Option::is_some) {
        return Ok(());
    }
    let has_no_patch = solution.zones.patches.is_empty();
    if has_no_patch && (solution.zones.panes.is_empty() || !quantity.is_thermal()) {
        let remedy = match (quantity, solution.scene.voxel_grid()) {
            (FieldQuantity::Temperature, Some(_)) => "give a --slice of the medium",
            _ => "write its zones with zonal export",
        };
        let message = format!("--show: there is no surface that has a {}; {remedy}", quantity.name());
        return Err(Failure::in_file(&args.run, message));
    }
    let reason = "sees no zone of a surface or pane (the backs of one-sided surfaces are not zones); choose another --camera";
    Err(Failure::new(format!("--camera: '{}' {reason}", camera.name)))
}

fn visible_values(zones: &[Option<u32>], values: &[f64]) -> VisibleValues {
    let visible: Vec<f64> = zones.iter().map(|z| z.map_or(f64::NAN, |z| values[z as usize])).collect();
    let without_value = zones.iter().zip(&visible).filter(|(z, v)| z.is_some() && v.is_nan()).count();
    VisibleValues { values: visible, without_value }
}

/// The scale of the range in the arguments, or of the visible values.
fn choose_scale(
    settings: &FieldPictureSettings,
    visible: &VisibleValues,
    rounding: f64,
) -> Result<ColourScale, Failure> {
    let (map, axis) = (settings.quantity.colour_map(), settings.scale);
    if let Some((low, high)) = settings.range {
        return Ok(ColourScale { low, high, map, axis });
    }
    ColourScale::of_values(visible.values.iter().copied(), (map, axis), rounding).ok_or_else(|| {
        let missing = match axis {
            AxisScale::Logarithmic => "positive value; leave out --log",
            AxisScale::Linear => "value",
        };
        Failure::new(format!(
            "--range: no visible zone has a {missing}, or give the ends of the scale as LOW,HIGH"
        ))
    })
}

/// Writes the values as an .exr.
fn write_values(
    args: &Args,
    settings: &FieldPictureSettings,
    visible: &VisibleValues,
) -> Result<(), Failure> {
    let (width, height) = settings.size;
    let values = visible.values.iter().map(|v| *v as f32).collect();
    let (quantity, unit) = (settings.quantity.name().to_string(), settings.quantity.unit().to_string());
    Ok(output::write_exr_field(&args.output, &ScalarImage { width, height, values, quantity, unit })?)
}

/// The colours with their scale beside them.
fn colour_canvas(
    settings: &FieldPictureSettings,
    (picture, scale, without_value): (&[[f32; 3]], &ColourScale, usize),
    s: &Solution,
) -> Canvas {
    let quantity = settings.quantity;
    let (prefix, factor) = match scale.low.abs().max(scale.high.abs()) {
        _ if quantity == FieldQuantity::Temperature => ("", 1.0),
        x if x >= 1e7 => ("M", 1e-6),
        x if x >= 1e4 => ("k", 1e-3),
        _ => ("", 1.0),
    };
    let mut title = vec![quantity.title().to_string()];
    if !quantity.is_thermal() && s.scene.thermal().is_none() {
        title.push("mean of bands".into());
    }
    title.push(format!("{prefix}{}", quantity.unit().replace('2', "²")));
    let shown = ColourScale { low: scale.low * factor, high: scale.high * factor, ..*scale };
    let legend = Legend { title, scale: shown, has_no_value: without_value > 0 };
    beside(picture, settings.size, &legend)
}

/// Writes colours with their scale as a .png.
fn write_canvas(
    args: &Args,
    settings: &FieldPictureSettings,
    canvas: &Canvas,
    scale: &ColourScale,
) -> Result<(), Failure> {
    let quantity = settings.quantity;
    let range = format!("{} {}", scale.low, scale.high);
    let mut text = vec![("show", quantity.name()), ("unit", quantity.unit()), ("range", range.as_str())];
    text.extend(args.slice.as_deref().map(|slice| ("slice", slice)));
    Ok(output::write_png_bytes(&args.output, (canvas.width, canvas.height), &canvas.bytes, &text)?)
}

/// Properties of a written picture.
pub(super) struct FieldPictureSummary {
    quantity: FieldQuantity,
    size: (usize, usize),
    camera: Camera,
    /// Ends of the scale; none for values.
    scale_range: Option<(f64, f64)>,
    /// Smallest and largest visible value.
    visible_range: Option<(f64, f64)>,
    /// Pixels of zones without a value.
    without_value: usize,
    /// Pixels with values beyond the scale.
    out_of_range: Option<usize>,
}

impl FieldPictureSummary {
    fn new(
        settings: &FieldPictureSettings,
        camera: Camera,
        visible: &VisibleValues,
        scale: Option<ColourScale>,
    ) -> FieldPictureSummary {
        FieldPictureSummary {
            quantity: settings.quantity,
            size: settings.size,
            camera,
            scale_range: scale.map(|s| (s.low, s.high)),
            visible_range: finite_range(visible.values.iter().copied()),
            without_value: visible.without_value,
            out_of_range: scale
                .map(|s| visible.values.iter().filter(|v| **v < s.low || **v > s.high).count()),
        }
    }

    fn print_json(&self, args: &Args) -> Result<(), Failure> {
        let (width, height) = self.size;
        let json = serde_json::json!({
            "camera": self.camera.name, "width": width, "height": height, "show": self.quantity.name(), "slice": args.slice,
            "unit": self.quantity.unit(), "range": self.scale_range.map(|r| [r.0, r.1]),
            "visible_range": self.visible_range.map(|s| [s.0, s.1]), "without_value": self.without_value,
            "out_of_range": self.out_of_range, "written": args.output.display().to_string(),
        });
        say(&json.to_string())
    }

    fn print_text(&self, args: &Args) -> Result<(), Failure> {
        let ((width, height), written) = (self.size, args.output.display());
        let (name, unit) = (self.quantity.name(), self.quantity.unit());
        let range = match self.visible_range {
            Some((low, high)) => format!(" from {} to {} {unit}", six_digits(low), six_digits(high)),
            None => " without values".into(),
        };
        say(&format!("{}: {width}×{height}, {name}{range}, written: {written}", self.camera.name))?;
        match (self.without_value, self.out_of_range.unwrap_or(0)) {
            (0, 0) => Ok(()),
            (0, n) => say(&format!("{n} pixels are out of range and have the colours of its ends")),
            (n, _) => say(&format!("{n} pixels show zones without a value, grey")),
        }
    }
}

/// A number rounded to six significant digits.
fn six_digits(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x)
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
