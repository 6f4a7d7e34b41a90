//! Pictures of solutions: radiance, values in false colours, PNG files in memory.

use crate::errors::{of_failure, of_file, of_scene, refused};
use crate::long_call::{CallSettings, Observer};
use crate::solution::Solution;
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::Path;
use zonal_cli::colour_scale::ColourScale;
use zonal_cli::commands::context::check_picture;
use zonal_cli::commands::render::args::FieldQuantity;
use zonal_cli::commands::render::camera_choice::select_camera;
use zonal_cli::commands::render::false_colours::check_slice;
use zonal_io::output::{self, ColourMap, ToneMapping};
use zonal_math::Vec3;
use zonal_render::{ItemBuffer, PaneVisibility, RenderOptions};
use zonal_report::Failure;
use zonal_report::plot::AxisScale;
use zonal_scene::{Camera, Lens};

/// What stands for the file of a solution in messages.
const SOLUTION: &str = "solution";
/// Largest number of pixels, as on the command line.
const MAX_PIXELS: usize = 1 << 26;
/// Colour of pixels without a zone.
const BACKGROUND: [f32; 3] = [1.0; 3];

/// A camera: one of the scene by name, or a new one.
#[derive(Clone, Debug, Default, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct CameraChoice {
    name: Option<String>,
    /// Origin, target and upward direction of a new camera.
    view: Option<([f64; 3], [f64; 3], [f64; 3])>,
    /// Field of view of a new camera, degrees.
    fov: f64,
    aperture: Option<f64>,
    focus: Option<f64>,
}

/// What is drawn.
#[derive(Clone, Debug, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct PictureSettings {
    /// Pixels across and down.
    size: (usize, usize),
    /// Rays for each pixel; 0 is adaptive.
    samples: usize,
    /// Rays of the final gather; 0 is none.
    gather: usize,
    /// A quantity in place of light.
    show: Option<String>,
    /// Axis and coordinate of a plane through the medium, m.
    slice: Option<(usize, f64)>,
}

impl PictureSettings {
    fn check(&self) -> PyResult<()> {
        let (w, h) = self.size;
        if w == 0 || h == 0 || w.checked_mul(h).is_none_or(|n| n > MAX_PIXELS) {
            return Err(refused(format!("size: {w} x {h} is out of range; give 1 to {MAX_PIXELS} pixels")));
        }
        if self.samples > 4096 || self.gather > 4096 {
            return Err(refused("samples, gather: at most 4096 rays are possible; give fewer"));
        }
        if self.slice.is_some_and(|(axis, _)| axis > 2) {
            return Err(refused("slice: there are the axes x, y and z; give one of them and a coordinate"));
        }
        Ok(())
    }
    fn quantity(&self) -> PyResult<Option<FieldQuantity>> {
        use clap::ValueEnum;
        let Some(name) = &self.show else { return Ok(None) };
        let name = name.replace('_', "-");
        let found = FieldQuantity::from_str(&name, false);
        let known = "temperature, net_flux, radiosity, irradiance";
        found.map(Some).map_err(|_| refused(format!("show: '{name}' is not known; give one of {known}")))
    }
}

impl CameraChoice {
    /// The camera; an overview where the scene has none and none is chosen.
    fn camera(&self, s: &zonal_scene::Solution, size: (usize, usize)) -> Result<Camera, CameraFault> {
        let mut camera = match &self.view {
            Some((origin, target, up)) => Camera {
                up: Vec3::from_array(*up),
                fov: self.fov,
                lens: Lens::default(),
                ..Camera::look_at(*origin, *target)
            },
            None => select_camera(s, self.name.as_deref(), size).map_err(CameraFault::Failure)?,
        };
        camera.lens.aperture = self.aperture.unwrap_or(camera.lens.aperture);
        camera.lens.focus = self.focus.or(camera.lens.focus);
        camera.check().map_err(CameraFault::Scene)?;
        Ok(camera)
    }
}

/// Why there is no picture.
enum CameraFault {
    Failure(Failure),
    Scene(zonal_scene::SceneError),
}

impl From<Failure> for CameraFault {
    fn from(e: Failure) -> CameraFault {
        CameraFault::Failure(e)
    }
}

impl From<CameraFault> for PyErr {
    fn from(e: CameraFault) -> PyErr {
        match e {
            CameraFault::Failure(e) => of_failure(&e),
            CameraFault::Scene(e) => of_scene(&e),
        }
    }
}

/// A PNG, and the range of its colours where they stand for values.
type Preview<'py> = (Bound<'py, PyBytes>, Option<(f64, f64)>);

/// The values of a picture of a quantity, and its colours.
struct FieldPicture {
    values: Vec<f64>,
    colours: Vec<[f32; 3]>,
    range: (f64, f64),
}

/// Draws a quantity on the zones that each pixel sees.
fn field_picture(
    s: &zonal_scene::Solution,
    (camera, settings): (&Camera, &PictureSettings),
    quantity: FieldQuantity,
    observer: &Observer,
) -> Result<FieldPicture, Failure> {
    let Some((values, rounding)) = quantity.values(s) else {
        return Err(Failure::new(format!(
            "show: {} exists only in thermal mode, and this is a solution of light; show radiosity or irradiance",
            quantity.name()
        )));
    };
    let panes = if quantity.is_thermal() { PaneVisibility::Opaque } else { PaneVisibility::Transparent };
    let mut view = ItemBuffer::new(s, camera, settings.size.0, settings.size.1, panes);
    if let Some(slice) = settings.slice {
        check_slice(s, slice)?;
        view = view.with_slice(slice.0, slice.1);
    }
    let zones = view.zones(observer);
    let visible: Vec<f64> = zones.iter().map(|z| z.map_or(f64::NAN, |z| values[z as usize])).collect();
    let map = if quantity == FieldQuantity::NetFlux { ColourMap::Diverging } else { ColourMap::Sequential };
    let scale = ColourScale::of_values(visible.iter().copied(), (map, AxisScale::Linear), rounding)
        .unwrap_or(ColourScale { low: 0.0, high: 1.0, map, axis: AxisScale::Linear });
    let colour = |z: Option<usize>| z.map_or(BACKGROUND, |z| scale.colour(values[z]));
    let colours = view.false_colours(&colour, observer);
    Ok(FieldPicture { values: visible, colours, range: (scale.low, scale.high) })
}

/// Radiance of a picture, [height, width, 3] of f4, W/(m² sr); or the values of a quantity, [height, width] of f8.
#[pyfunction]
#[pyo3(signature = (solution, camera, settings, progress=None, threads=None))]
pub(crate) fn render<'py>(
    py: Python<'py>,
    solution: &Solution,
    camera: CameraChoice,
    settings: PictureSettings,
    progress: Option<&Bound<'py, PyAny>>,
    threads: Option<i64>,
) -> PyResult<Bound<'py, PyAny>> {
    settings.check()?;
    let call = CallSettings { threads, progress };
    let (width, height) = settings.size;
    if let Some(quantity) = settings.quantity()? {
        let drawn = solution.run(py, call, move |s, observer| {
            let camera = camera.camera(s, settings.size)?;
            Ok::<_, CameraFault>(field_picture(s, (&camera, &settings), quantity, observer)?)
        })??;
        return Ok(PyArray1::from_vec(py, drawn.values).reshape([height, width])?.into_any());
    }
    let image = solution.run(py, call, move |s, observer| {
        check_picture(Path::new(SOLUTION), s)?;
        let camera = camera.camera(s, settings.size)?;
        let PictureSettings { samples, gather, .. } = settings;
        let options = RenderOptions { width, height, samples, gather, ..RenderOptions::default() };
        Ok::<_, CameraFault>(zonal_render::render(s, &camera, &options, observer))
    })??;
    let flat = image.pixels.into_flattened();
    Ok(PyArray1::from_vec(py, flat).reshape([height, width, 3])?.into_any())
}

/// A small PNG of the solution: light, or in thermal mode temperatures in false colours; with the range of the colours.
#[pyfunction]
#[pyo3(signature = (solution, camera, settings, threads=None))]
pub(crate) fn preview<'py>(
    py: Python<'py>,
    solution: &Solution,
    camera: CameraChoice,
    settings: PictureSettings,
    threads: Option<i64>,
) -> PyResult<Preview<'py>> {
    settings.check()?;
    let call = CallSettings { threads, progress: None };
    let quantity = settings.quantity()?;
    let (width, height) = settings.size;
    let (png, range) = solution.run(py, call, move |s, observer| {
        let camera = camera.camera(s, settings.size)?;
        if let Some(quantity) = quantity {
            let drawn = field_picture(s, (&camera, &settings), quantity, observer)?;
            let png = output::encode_png(width, height, &drawn.colours);
            return Ok::<_, CameraFault>((png.unwrap_or_default(), Some(drawn.range)));
        }
        check_picture(Path::new(SOLUTION), s)?;
        let options = RenderOptions { width, height, samples: settings.samples, ..RenderOptions::default() };
        let image = zonal_render::render(s, &camera, &options, observer);
        let tone = ToneMapping::filmic(output::auto_exposure(&image.pixels));
        let png = output::encode_picture_png((width, height), &image.pixels, &tone);
        Ok((png.map_err(Failure::from)?, None))
    })??;
    Ok((PyBytes::new(py, &png), range))
}

/// The page of the viewer with the data of the solution, one HTML text.
#[pyfunction]
#[pyo3(signature = (solution, max_vertices, first_band=0, progress=None, threads=None))]
pub(crate) fn page(
    py: Python<'_>,
    solution: &Solution,
    max_vertices: usize,
    first_band: usize,
    progress: Option<&Bound<'_, PyAny>>,
    threads: Option<i64>,
) -> PyResult<String> {
    use zonal_cli::commands::context::{check_uniform_light, with_shown_bands};
    use zonal_cli::viewer::{package, page};
    let call = CallSettings { threads, progress };
    let text = solution.run(py, call, move |s, observer| {
        check_uniform_light(Path::new(SOLUTION), s)?;
        let detail = package::PackageDetail { max_vertices, ..package::PackageDetail::default() };
        let shown = (first_band > 0).then(|| with_shown_bands(s.clone(), first_band)).transpose()?;
        let packed = package::package(shown.as_ref().unwrap_or(s), &detail, observer)?;
        Ok::<_, Failure>(page::single_file(&packed))
    })?;
    text.map_err(|e| of_failure(&e))
}

/// Radiance, [height, width, 3], as the bytes of a PNG: exposed, tone-mapped, 8 bits.
#[pyfunction]
#[pyo3(signature = (radiance, exposure=None, stops=0.0, contrast=1.0))]
pub(crate) fn encode_png<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    exposure: Option<f64>,
    stops: f64,
    contrast: f64,
) -> PyResult<Bound<'py, PyBytes>> {
    let [height, width, 3] = *radiance.shape() else {
        return Err(refused("radiance: the array has no three bands; give one of shape (height, width, 3)"));
    };
    let flat = radiance.as_slice().map_err(|_| refused("radiance: give a contiguous array"))?;
    let pixels = flat.as_chunks::<3>().0;
    let exposure = exposure.unwrap_or_else(|| output::auto_exposure(pixels)) * stops.exp2();
    let tone = ToneMapping { contrast, ..ToneMapping::filmic(exposure) };
    let png = output::encode_picture_png((width, height), pixels, &tone).map_err(|e| of_file(&e))?;
    Ok(PyBytes::new(py, &png))
}
