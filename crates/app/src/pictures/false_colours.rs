//! A picture in false colours with its scale, or the values themselves.
//!
//! Every pixel has the value of the zone that its central ray meets first; values are not interpolated.

use super::colour_scale::{ColourScale, finite_range};
use super::field_quantity::{FieldQuantity, FieldValues, MediumSlice};
use super::legend::{Canvas, Legend, beside};
use super::options::{DrawOptions, KeySource, is_linear};
use zonal_io::output::{self, ScalarImage};
use zonal_render::ItemBuffer;
use zonal_report::plot::AxisScale;
use zonal_report::{Failure, check_output};
use zonal_scene::{Camera, Progress, Solution};

/// Linear colour of pixels without a zone.
const BACKGROUND: [f32; 3] = [1.0; 3];
/// Largest width or height, pixels.
const MAX_SIDE: usize = 16384;

/// Refuses ranges that are not finite or have no width; `text` is the range in messages.
///
/// # Errors
/// If the range is not valid.
pub fn check_range(range: (f64, f64), text: &str) -> Result<(), Failure> {
    let wrong = |why: &str| Failure::new(format!("--range: '{text}' {why}; write for example 400,1200"));
    let (low, high) = range;
    if !(low.is_finite() && high.is_finite()) {
        return Err(wrong("is not finite"));
    }
    if !(high - low).is_finite() {
        return Err(wrong("is too wide"));
    }
    if low >= high {
        return Err(wrong("has no low end below its high end"));
    }
    Ok(())
}

/// A picture in false colours whose options were checked.
pub struct FieldPicture {
    quantity: FieldQuantity,
    size: (usize, usize),
    range: Option<(f64, f64)>,
    slice: Option<MediumSlice>,
    scale: AxisScale,
    /// True for the values themselves, false for colours.
    writes_values: bool,
}

impl FieldPicture {
    /// The picture of a quantity with a linear scale of its visible values; with the medium on a plane.
    #[must_use]
    pub fn of_quantity(
        quantity: FieldQuantity,
        size: (usize, usize),
        slice: Option<MediumSlice>,
    ) -> FieldPicture {
        let scale = AxisScale::Linear;
        FieldPicture { quantity, size, range: None, slice, scale, writes_values: false }
    }

    pub(super) fn new(options: &DrawOptions, quantity: FieldQuantity) -> Result<FieldPicture, Failure> {
        options.check_size_and_rays()?;
        let size = options.size;
        if size.0.max(size.1) > MAX_SIDE {
            let reason = format!("with --show a side has at most {MAX_SIDE} pixels");
            return Err(Failure::new(format!("--size: '{}': {reason}", options.size_text())));
        }
        refuse_light_options(options)?;
        check_output(&options.output, &["png", "exr"])?;
        let writes_values = is_linear(&options.output);
        for (flag, given) in [("--range", options.range.is_some()), ("--log", options.log)] {
            if given && writes_values {
                let reason =
                    "does not apply to an .exr, which holds the values; leave it out, or write a .png";
                return Err(Failure::new(format!("{flag}: {reason}")));
            }
        }
        if options.log && quantity == FieldQuantity::NetFlux {
            return Err(Failure::new("--log: net fluxes have a sign; leave it out"));
        }
        let range = options.range;
        if let Some((low, high)) = range {
            check_range((low, high), &format!("{low:?},{high:?}"))?;
        }
        if options.log && range.is_some_and(|r| r.0 <= 0.0) {
            return Err(Failure::new(
                "--range: a logarithmic scale begins above 0; leave out --log, or raise the low end",
            ));
        }
        let slice = options.slice.clone();
        if slice.is_some() && quantity != FieldQuantity::Temperature {
            let reason = "a plane through the medium shows temperatures; leave it out, or show temperature";
            return Err(Failure::new(format!("--slice: {reason}")));
        }
        let scale = if options.log { AxisScale::Logarithmic } else { AxisScale::Linear };
        Ok(FieldPicture { quantity, size, range, slice, scale, writes_values })
    }

    /// Draws and writes the picture of a solution.
    pub(super) fn write(
        &self,
        options: &DrawOptions,
        solution: &Solution,
        progress: &dyn Progress,
    ) -> Result<FieldPictureSummary, Failure> {
        let Some(values) = self.quantity.values(solution) else {
            let reason = "exists only in mode = \"thermal\", and this is a solution of light; show radiosity or irradiance";
            let message = format!("--show: {} {reason}", self.quantity.name());
            return Err(Failure::in_file(&options.source, message));
        };
        if let Some(slice) = &self.slice {
            slice.check(solution)?;
        }
        let camera = options.view.select(solution, self.size)?;
        // Find the zone of each pixel.
        let view = self.item_buffer(solution, &camera);
        let zones = view.zones(progress);
        if zones.iter().all(Option::is_none) {
            return Err(self.nothing_visible(options, solution, &camera));
        }
        let visible = VisibleValues::new(&zones, &values.values);
        // Write values or colours.
        let scale = if self.writes_values {
            self.write_values(options, &visible)?;
            None
        } else {
            let scale = self.choose_scale(&visible, values.rounding)?;
            let picture = coloured(&view, &scale, &values.values, progress);
            self.write_canvas(options, &self.canvas(&picture, &scale, &visible, solution), &scale)?;
            Some(scale)
        };
        Ok(FieldPictureSummary::new(self, camera, &visible, scale))
    }

    /// Colours of the visible values, with their scale.
    ///
    /// # Errors
    /// If the solution lacks the quantity, or no visible zone has a value.
    pub(crate) fn draw(
        &self,
        solution: &Solution,
        camera: &Camera,
        progress: &dyn Progress,
    ) -> Result<Canvas, Failure> {
        let values = self.values(solution)?;
        let view = self.item_buffer(solution, camera);
        let visible = VisibleValues::new(&view.zones(progress), &values.values);
        let scale = self.choose_scale(&visible, values.rounding)?;
        let picture = coloured(&view, &scale, &values.values, progress);
        Ok(self.canvas(&picture, &scale, &visible, solution))
    }

    /// Values and colours of the pixels, without their scale.
    ///
    /// # Errors
    /// If the solution lacks the quantity, or the plane does not cut its medium.
    pub fn pixels(
        &self,
        solution: &Solution,
        camera: &Camera,
        progress: &dyn Progress,
    ) -> Result<FieldPixels, Failure> {
        let FieldValues { values, rounding } = self.values(solution)?;
        if let Some(slice) = &self.slice {
            slice.check(solution)?;
        }
        let view = self.item_buffer(solution, camera);
        let visible = VisibleValues::new(&view.zones(progress), &values);
        let (map, axis) = (self.quantity.colour_map(), self.scale);
        let scale = self.choose_scale(&visible, rounding);
        let scale = scale.unwrap_or(ColourScale { low: 0.0, high: 1.0, map, axis });
        let colours = coloured(&view, &scale, &values, progress);
        Ok(FieldPixels { values: visible.values, colours, range: (scale.low, scale.high) })
    }

    /// The values of all zones.
    fn values(&self, solution: &Solution) -> Result<FieldValues, Failure> {
        self.quantity.values(solution).ok_or_else(|| {
            Failure::new(format!(
                "show: {} exists only in thermal mode, and this is a solution of light; show radiosity or irradiance",
                self.quantity.name()
            ))
        })
    }

    /// The zones that the pixels show.
    fn item_buffer<'a>(&self, s: &'a Solution, camera: &Camera) -> ItemBuffer<'a> {
        let panes = self.quantity.pane_visibility();
        let view = ItemBuffer::new(s, camera, self.size.0, self.size.1, panes);
        match &self.slice {
            Some(slice) => view.with_slice(slice.axis, slice.coordinate),
            None => view,
        }
    }

    /// Why no zone is visible.
    fn nothing_visible(&self, options: &DrawOptions, solution: &Solution, camera: &Camera) -> Failure {
        let quantity = self.quantity;
        let has_no_patch = solution.zones.patches.is_empty();
        if has_no_patch && (solution.zones.panes.is_empty() || !quantity.is_thermal()) {
            let remedy = match (quantity, solution.scene.voxel_grid()) {
                (FieldQuantity::Temperature, Some(_)) => "give a --slice of the medium",
                _ => "write its zones with zonal export",
            };
            let message = format!("--show: there is no surface that has a {}; {remedy}", quantity.name());
            return Failure::in_file(&options.source, message);
        }
        let reason = "sees no zone of a surface or pane (the backs of one-sided surfaces are not zones); choose another --camera";
        Failure::new(format!("--camera: '{}' {reason}", camera.name))
    }

    /// The scale of the range of the options, or of the visible values.
    fn choose_scale(&self, visible: &VisibleValues, rounding: f64) -> Result<ColourScale, Failure> {
        let (map, axis) = (self.quantity.colour_map(), self.scale);
        if let Some((low, high)) = self.range {
            return Ok(ColourScale { low, high, map, axis });
        }
        ColourScale::of_values(visible.values.iter().copied(), map, axis, rounding).ok_or_else(|| {
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
    fn write_values(&self, options: &DrawOptions, visible: &VisibleValues) -> Result<(), Failure> {
        let (width, height) = self.size;
        let values = visible.values.iter().map(|v| *v as f32).collect();
        let (quantity, unit) = (self.quantity.name().to_string(), self.quantity.unit().to_string());
        Ok(output::write_exr_field(&options.output, &ScalarImage { width, height, values, quantity, unit })?)
    }

    /// The colours with their scale beside them.
    fn canvas(
        &self,
        picture: &[[f32; 3]],
        scale: &ColourScale,
        visible: &VisibleValues,
        s: &Solution,
    ) -> Canvas {
        let quantity = self.quantity;
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
        let legend = Legend { title, scale: shown, has_no_value: visible.without_value > 0 };
        beside(picture, self.size, &legend)
    }

    /// Writes colours with their scale as a .png.
    fn write_canvas(
        &self,
        options: &DrawOptions,
        canvas: &Canvas,
        scale: &ColourScale,
    ) -> Result<(), Failure> {
        let quantity = self.quantity;
        let range = format!("{} {}", scale.low, scale.high);
        let mut text = vec![("show", quantity.name()), ("unit", quantity.unit()), ("range", range.as_str())];
        text.extend(self.slice.as_ref().map(|slice| ("slice", slice.text.as_str())));
        Ok(output::write_png_bytes(&options.output, canvas.width, canvas.height, &canvas.bytes, &text)?)
    }
}

/// Refuses options of pictures of light.
fn refuse_light_options(options: &DrawOptions) -> Result<(), Failure> {
    for (flag, given) in [
        ("--animate", matches!(options.keys, Some(KeySource::File(_)))),
        ("--gather", options.gather.is_some_and(|n| n != 0)),
        ("--samples", options.samples.is_some()),
        ("--stops", options.stops.is_some()),
        ("--contrast", options.contrast.is_some()),
        ("--bloom", options.bloom != 0.0),
        ("--aperture", options.aperture.is_some()),
        ("--focus", options.focus.is_some()),
    ] {
        if given {
            let reason = "applies to pictures of light; leave it out, or leave out --show";
            return Err(Failure::new(format!("{flag}: {reason}")));
        }
    }
    Ok(())
}

/// The colour of the value of the zone of each pixel.
fn coloured(
    view: &ItemBuffer,
    scale: &ColourScale,
    values: &[f64],
    progress: &dyn Progress,
) -> Vec<[f32; 3]> {
    view.false_colours(&|z| z.map_or(BACKGROUND, |z| scale.colour(values[z])), progress)
}

/// A picture of values in memory, row by row, row 0 on top.
pub struct FieldPixels {
    /// The value of each pixel; NaN without a zone.
    pub values: Vec<f64>,
    /// Linear colours.
    pub colours: Vec<[f32; 3]>,
    /// Values of the first and the last colour.
    pub range: (f64, f64),
}

/// Visible values of a picture.
struct VisibleValues {
    /// The value of each pixel; NaN if the pixel has no zone or the zone no value.
    values: Vec<f64>,
    /// Number of pixels of zones without a value.
    without_value: usize,
}

impl VisibleValues {
    fn new(zones: &[Option<u32>], values: &[f64]) -> VisibleValues {
        let visible: Vec<f64> = zones.iter().map(|z| z.map_or(f64::NAN, |z| values[z as usize])).collect();
        let without_value = zones.iter().zip(&visible).filter(|(z, v)| z.is_some() && v.is_nan()).count();
        VisibleValues { values: visible, without_value }
    }
}

/// Properties of a written picture.
pub struct FieldPictureSummary {
    /// The quantity.
    pub quantity: FieldQuantity,
    /// Pixels across and down of the picture without its scale.
    pub size: (usize, usize),
    /// The camera.
    pub camera: Camera,
    /// Ends of the scale; none for values.
    pub scale_range: Option<(f64, f64)>,
    /// Smallest and largest visible value.
    pub visible_range: Option<(f64, f64)>,
    /// Pixels of zones without a value.
    pub without_value: usize,
    /// Pixels with values beyond the scale.
    pub out_of_range: Option<usize>,
}

impl FieldPictureSummary {
    fn new(
        picture: &FieldPicture,
        camera: Camera,
        visible: &VisibleValues,
        scale: Option<ColourScale>,
    ) -> FieldPictureSummary {
        FieldPictureSummary {
            quantity: picture.quantity,
            size: picture.size,
            camera,
            scale_range: scale.map(|s| (s.low, s.high)),
            visible_range: finite_range(visible.values.iter().copied()),
            without_value: visible.without_value,
            out_of_range: scale
                .map(|s| visible.values.iter().filter(|v| **v < s.low || **v > s.high).count()),
        }
    }
}
