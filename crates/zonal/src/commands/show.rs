//! `zonal render --show`: a picture of numbers, in false colours with their scale, or as the numbers themselves.

use super::render::{Args, find_camera, parse_size};
use super::{Context, check_output};
use crate::failure::say;
use crate::legend::{Legend, beside};
use crate::scale::{Scale, ends};
use crate::{Failure, meter::Meter};
use zonal_io::output::{self, ColourMap, FieldPicture};
use zonal_render::ZonesSeen;
use zonal_scene::{Bands, Camera, Solution};

/// Linear colour of what is no zone.
const BACKGROUND: [f32; 3] = [1.0; 3];
/// Differences that are rounding, relative to the largest temperature or radiosity.
const ROUNDING: f64 = 1e-7;

/// The most pixels along a side.
const LONGEST: usize = 16384;

/// What a picture of numbers shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Field {
    /// Temperature, K, of surfaces and panes (thermal mode).
    Temperature,
    /// Net flux, W/m2, positive where heat leaves, of surfaces and panes (thermal mode).
    NetFlux,
    /// Radiosity B, W/m2, direct light included, of surfaces: the mean of the bands, in thermal mode all together.
    Radiosity,
    /// Irradiance H, W/m2, direct light included, of surfaces: likewise.
    #[value(alias = "irradiation")]
    Irradiance,
}

impl Field {
    fn word(self) -> &'static str {
        ["temperature", "net-flux", "radiosity", "irradiance"][self as usize]
    }
    fn title(self) -> &'static str {
        ["Temperature", "Net flux", "Radiosity", "Irradiance"][self as usize]
    }
    fn unit(self) -> &'static str {
        if self == Field::Temperature { "K" } else { "W/m2" }
    }
    fn is_heat(self) -> bool {
        matches!(self, Field::Temperature | Field::NetFlux)
    }
    fn map(self) -> ColourMap {
        if self == Field::NetFlux { ColourMap::Signed } else { ColourMap::Plain }
    }

    /// The value of every zone, and below which difference it is rounding; `None` where this mode does not have it.
    fn values(self, s: &Solution) -> Option<(Vec<f64>, f64)> {
        let (f, heat) = (&s.fields, s.fields.heat.as_ref());
        let largest =
            |list: &[f64]| list.iter().filter(|x| x.is_finite()).fold(0.0, |m: f64, x| m.max(x.abs()));
        // One number of three bands, as the viewer has it in light mode.
        let one = |v: Bands| match s.scene.thermal() {
            Some(t) => t.shares.total(v),
            None => (v[0] + v[1] + v[2]) / 3.0,
        };
        let radiosity = || f.radiosity.iter().map(|b| one(*b)).collect::<Vec<f64>>();
        let values = match self {
            Field::Temperature => heat?.temperature.clone(),
            Field::NetFlux => {
                // Of a pane W/m³ times its thickness.
                let mut net = heat?.net.clone();
                let panes = net[s.zones.pane_offset()..].iter_mut();
                panes.zip(&s.zones.panes).for_each(|(q, z)| *q *= z.thickness);
                net
            }
            Field::Radiosity => radiosity(),
            Field::Irradiance => f.incident.iter().zip(&f.direct).map(|(h, d)| one(*h) + one(*d)).collect(),
        };
        let scale = if self == Field::NetFlux { largest(&radiosity()) } else { largest(&values) };
        Some((values, ROUNDING * scale))
    }
}

/// What the arguments ask for, checked as far as they go by themselves.
struct Wish {
    field: Field,
    size: (usize, usize),
    range: Option<(f64, f64)>,
    slice: Option<(usize, f64)>,
    numbers: bool,
}

impl Wish {
    fn of(args: &Args, field: Field) -> Result<Wish, Failure> {
        let size = parse_size(&args.size)?;
        if size.0.max(size.1) > LONGEST {
            let what = format!("with --show a side has {LONGEST} pixels at most");
            return Err(Failure::new(format!("--size: '{}': {what}", args.size)));
        }
        for (flag, given) in [
            ("--animate", args.animate.is_some()),
            ("--gather", args.gather != 0),
            ("--samples", args.samples.is_some()),
            ("--stops", args.stops.is_some()),
            ("--contrast", args.contrast.is_some()),
            ("--bloom", args.bloom != 0.0),
            ("--aperture", args.aperture.is_some()),
            ("--focus", args.focus.is_some()),
        ] {
            if given {
                let what = "is for pictures of light; leave it out, or leave out --show";
                return Err(Failure::new(format!("{flag}: {what}")));
            }
        }
        check_output(&args.output, &["png", "exr"])?;
        let numbers = super::render::is_linear(&args.output);
        for (flag, given) in [("--range", args.range.is_some()), ("--log", args.log)] {
            if given && numbers {
                let what = "an .exr holds the values as they are; leave it out, or write a .png";
                return Err(Failure::new(format!("{flag}: {what}")));
            }
        }
        if args.log && field == Field::NetFlux {
            return Err(Failure::new("--log: net fluxes have a sign; leave it out"));
        }
        let range = args.range.as_deref().map(parse_range).transpose()?;
        if args.log && range.is_some_and(|r| r.0 <= 0.0) {
            return Err(Failure::new(
                "--range: a logarithmic scale begins above 0; leave out --log, or raise the low end",
            ));
        }
        let slice = args.slice.as_deref().map(parse_slice).transpose()?;
        if slice.is_some() && field != Field::Temperature {
            let what = "a plane through the medium shows temperatures; leave it out, or show temperature";
            return Err(Failure::new(format!("--slice: {what}")));
        }
        Ok(Wish { field, size, range, slice, numbers })
    }
}

/// Two ends from `LOW,HIGH`.
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

/// Axis and place, m, from `AXIS=METRES`.
fn parse_slice(text: &str) -> Result<(usize, f64), Failure> {
    let read = || {
        let (axis, place) = text.split_once('=')?;
        let axis = ["x", "y", "z"].iter().position(|a| *a == axis.trim())?;
        Some((axis, place.trim().parse::<f64>().ok().filter(|x| x.is_finite())?))
    };
    read()
        .ok_or_else(|| Failure::new(format!("--slice: '{text}' is not AXIS=METRES; write for example z=1.0")))
}

/// Refuses a plane that does not cut the medium.
fn check_slice(s: &Solution, (axis, place): (usize, f64)) -> Result<(), Failure> {
    let Some(map) = s.scene.voxmap() else {
        return Err(Failure::new("--slice: the scene has no medium to cut; leave it out"));
    };
    let (low, high) = (map.min()[axis], map.max()[axis]);
    if !(low..=high).contains(&place) {
        let axis = ["x", "y", "z"][axis];
        let what =
            format!("{axis}={place} does not cut the medium, which is from {axis}={low} to {axis}={high}");
        return Err(Failure::new(format!("--slice: {what}")));
    }
    Ok(())
}

/// The camera of that name, or the first; `overview` is there in any scene, and the first where there is no other.
fn camera(s: &Solution, name: Option<&str>, (width, height): (usize, usize)) -> Result<Camera, Failure> {
    let overview = Camera::overview(s.scene.bounds(), width as f64 / height as f64);
    let cameras = s.scene.cameras();
    match name {
        None => Ok(cameras.first().cloned().unwrap_or(overview)),
        Some("overview") if !cameras.iter().any(|c| c.name == "overview") => Ok(overview),
        Some(n) if cameras.is_empty() => Err(Failure::new(format!(
            "--camera: there is no camera '{n}'; the scene has none but 'overview', add a [[camera]] and solve again"
        ))),
        name => find_camera(s, name).cloned(),
    }
}

/// Runs the command.
pub fn run(args: &Args, field: Field, context: Context) -> Result<(), Failure> {
    let wish = Wish::of(args, field)?;
    let solution = output::read_solution(&args.run)?;
    let Some((values, floor)) = field.values(&solution) else {
        let what = "is found in mode = \"thermal\" only, and this is a solution of light; show radiosity or irradiance";
        return Err(Failure::in_file(&args.run, format!("--show: {} {what}", field.word())));
    };
    if let Some(slice) = wish.slice {
        check_slice(&solution, slice)?;
    }
    let camera = camera(&solution, args.camera.as_deref(), wish.size)?;
    let meter = Meter::new(context.quiet);
    let view = ZonesSeen::new(&solution, &camera, wish.size, field.is_heat());
    let view = match wish.slice {
        Some((axis, place)) => view.sliced(axis, place),
        None => view,
    };
    let zones = view.zones(&meter);
    if zones.iter().all(Option::is_none) {
        let (none, panes) = (solution.zones.patches.is_empty(), solution.zones.panes.is_empty());
        if none && (panes || !field.is_heat()) {
            let what = match (field, solution.scene.voxmap()) {
                (Field::Temperature, Some(_)) => "give a --slice of the medium",
                _ => "write its zones with zonal export",
            };
            let told = format!("--show: there is no surface that has a {}; {what}", field.word());
            return Err(Failure::in_file(&args.run, told));
        }
        let what = "sees no zone of a surface or pane (backs of one-sided surfaces are none); choose another --camera";
        return Err(Failure::new(format!("--camera: '{}' {what}", camera.name)));
    }
    let seen: Vec<f64> = zones.iter().map(|z| z.map_or(f64::NAN, |z| values[z as usize])).collect();
    let without = zones.iter().zip(&seen).filter(|(z, v)| z.is_some() && v.is_nan()).count();
    let scale = if wish.numbers {
        let (width, height) = wish.size;
        let values = seen.iter().map(|v| *v as f32).collect();
        let (quantity, unit) = (field.word().to_string(), field.unit().to_string());
        output::write_exr_field(&args.output, &FieldPicture { width, height, values, quantity, unit })?;
        None
    } else {
        let scale = match wish.range {
            Some((low, high)) => Scale { low, high, map: field.map(), log: args.log },
            None => {
                Scale::of(seen.iter().copied(), field.map(), args.log, floor).ok_or_else(|| no_scale(args))?
            }
        };
        let colour = |z: Option<usize>| z.map_or(BACKGROUND, |z| scale.colour(values[z]));
        let picture = view.coloured(&colour, &meter);
        write(args, &wish, &picture, (scale, without > 0), &solution)?;
        Some(scale)
    };
    let beyond = scale.map(|s| seen.iter().filter(|v| **v < s.low || **v > s.high).count());
    tell(
        args,
        &wish,
        &camera,
        &Told { range: scale.map(|s| (s.low, s.high)), seen: ends(seen.iter().copied()), without, beyond },
        context,
    )
}

fn no_scale(args: &Args) -> Failure {
    let what = if args.log { "positive value; leave out --log" } else { "value" };
    Failure::new(format!(
        "--range: nothing that is seen has a {what}, or give the ends of the scale as LOW,HIGH"
    ))
}

/// Writes the picture with its scale.
fn write(
    args: &Args,
    wish: &Wish,
    picture: &[[f32; 3]],
    (scale, has_no_value): (Scale, bool),
    s: &Solution,
) -> Result<(), Failure> {
    let (prefix, factor) = match scale.low.abs().max(scale.high.abs()) {
        _ if wish.field == Field::Temperature => ("", 1.0),
        x if x >= 1e7 => ("M", 1e-6),
        x if x >= 1e4 => ("k", 1e-3),
        _ => ("", 1.0),
    };
    let mut title = vec![wish.field.title().to_string()];
    if !wish.field.is_heat() && s.scene.thermal().is_none() {
        title.push("mean of bands".into());
    }
    title.push(format!("{prefix}{}", wish.field.unit().replace('2', "²")));
    let shown = Scale { low: scale.low * factor, high: scale.high * factor, ..scale };
    let canvas = beside(picture, wish.size, &Legend { title, scale: shown, has_no_value });
    let range = format!("{} {}", scale.low, scale.high);
    let mut notes = vec![("show", wish.field.word()), ("unit", wish.field.unit()), ("range", range.as_str())];
    notes.extend(args.slice.as_deref().map(|slice| ("slice", slice)));
    output::write_png_bytes(&args.output, (canvas.width, canvas.height), &canvas.bytes, &notes)?;
    Ok(())
}

/// What was seen.
struct Told {
    range: Option<(f64, f64)>,
    seen: Option<(f64, f64)>,
    without: usize,
    beyond: Option<usize>,
}

fn tell(args: &Args, wish: &Wish, camera: &Camera, told: &Told, context: Context) -> Result<(), Failure> {
    let ((width, height), written) = (wish.size, args.output.display());
    let (field, unit) = (wish.field.word(), wish.field.unit());
    if context.json {
        return say(&format!(
            "{}",
            serde_json::json!({
                "camera": camera.name, "width": width, "height": height, "show": field, "slice": args.slice, "unit": unit,
                "range": told.range.map(|r| [r.0, r.1]), "seen": told.seen.map(|s| [s.0, s.1]),
                "without_value": told.without, "beyond_range": told.beyond, "written": written.to_string(),
            })
        ));
    }
    let ends = match told.seen {
        Some((low, high)) => format!(" from {} to {} {unit}", short(low), short(high)),
        None => " nowhere".into(),
    };
    say(&format!("{}: {width}×{height}, {field}{ends}, written: {written}", camera.name))?;
    let pixels = |n: usize, what: &str| say(&format!("{n} pixels {what}"));
    match (told.without, told.beyond.unwrap_or(0)) {
        (0, 0) => Ok(()),
        (0, n) => pixels(n, "lie beyond the range and have the colours of its ends"),
        (n, _) => pixels(n, "show zones without a value, grey"),
    }
}

/// Six digits.
fn short(x: f64) -> f64 {
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
