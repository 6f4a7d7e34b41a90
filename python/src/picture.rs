//! Pictures of solutions: radiance, values in false colours, PNG files in memory.

use crate::errors::{of_app, of_failure, of_file, refused};
use crate::long_call::CallSettings;
use crate::solution::Solution;
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::{Path, PathBuf};
use zonal_app::Error;
use zonal_app::pages::viewer;
use zonal_app::pictures::{
    DrawOptions, FieldPicture, FieldQuantity, KeySource, MAX_RAYS, MediumSlice, ViewOptions, select_camera,
};
use zonal_app::quality::Quality;
use zonal_app::shown_solution::{check_picture, check_uniform_light, with_shown_bands};
use zonal_io::output::{self, ToneMapping};
use zonal_math::Vec3;
use zonal_render::RenderOptions;
use zonal_report::Failure;
use zonal_scene::Camera;

/// What stands for the file of a solution in messages.
pub(crate) const SOLUTION: &str = "solution";
/// Largest number of pixels, as on the command line.
const MAX_PIXELS: usize = 1 << 26;

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
        if self.samples.max(self.gather) > MAX_RAYS as usize {
            return Err(refused("samples, gather: at most 4096 rays are possible; give fewer"));
        }
        Ok(())
    }
    /// The picture of a quantity; none of light.
    fn field_picture(&self) -> PyResult<Option<FieldPicture>> {
        let Some(name) = &self.show else { return Ok(None) };
        let slice = self.slice.map(medium_slice).transpose()?;
        Ok(Some(FieldPicture::of_quantity(quantity(name)?, self.size, slice)))
    }
}

/// The quantity of a name.
fn quantity(name: &str) -> PyResult<FieldQuantity> {
    let name = name.replace('_', "-");
    let found = FieldQuantity::VARIANTS.into_iter().find(|q| q.name() == name);
    let known = "temperature, net_flux, radiosity, irradiance";
    found.ok_or_else(|| refused(format!("show: '{name}' is not known; give one of {known}")))
}

/// The plane of an axis and a coordinate, m.
fn medium_slice(plane: (usize, f64)) -> PyResult<MediumSlice> {
    let (axis, coordinate) = plane;
    if axis > 2 {
        return Err(refused("slice: there are the axes x, y and z; give one of them and a coordinate"));
    }
    Ok(MediumSlice::new(axis, coordinate))
}

/// A picture or an animation in files.
#[derive(Clone, Debug, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct FileSettings {
    output: PathBuf,
    camera: Option<String>,
    size: (usize, usize),
    samples: Option<u32>,
    gather: Option<u32>,
    stops: Option<f64>,
    contrast: Option<f64>,
    bloom: f64,
    aperture: Option<f64>,
    focus: Option<f64>,
    show: Option<String>,
    range: Option<(f64, f64)>,
    slice: Option<(usize, f64)>,
    log: bool,
    /// File of key frames.
    animate: Option<PathBuf>,
}

impl FileSettings {
    pub(crate) fn options(self) -> PyResult<DrawOptions> {
        Ok(DrawOptions {
            source: SOLUTION.into(),
            output: self.output,
            view: ViewOptions { camera: self.camera, ..ViewOptions::default() },
            size: self.size,
            quality: Quality::Normal,
            samples: self.samples,
            gather: self.gather,
            stops: self.stops,
            contrast: self.contrast,
            bloom: self.bloom,
            aperture: self.aperture,
            focus: self.focus,
            keys: self.animate.map(KeySource::File),
            show: self.show.as_deref().map(quantity).transpose()?,
            range: self.range,
            slice: self.slice.map(medium_slice).transpose()?,
            log: self.log,
        })
    }
}

impl CameraChoice {
    /// The camera; an overview where the scene has none and none is chosen.
    fn camera(&self, s: &zonal_scene::Solution, size: (usize, usize)) -> Result<Camera, Error> {
        let mut camera = match &self.view {
            Some((origin, target, up)) => {
                Camera { up: Vec3::from_array(*up), fov: self.fov, ..Camera::look_at(*origin, *target) }
            }
            None => select_camera(s, self.name.as_deref(), size)?,
        };
        camera.lens.aperture = self.aperture.unwrap_or(camera.lens.aperture);
        camera.lens.focus = self.focus.or(camera.lens.focus);
        camera.check()?;
        Ok(camera)
    }
}

/// A PNG, and the range of its colours where they stand for values.
type Preview<'py> = (Bound<'py, PyBytes>, Option<(f64, f64)>);

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
    if let Some(picture) = settings.field_picture()? {
        let drawn = solution.run(py, call, move |s, observer| {
            let camera = camera.camera(s, settings.size)?;
            Ok::<_, Error>(picture.pixels(s, &camera, observer)?)
        })?;
        let values = drawn.map_err(|e| of_app(&e))?.values;
        return Ok(PyArray1::from_vec(py, values).reshape([height, width])?.into_any());
    }
    let image = solution.run(py, call, move |s, observer| {
        check_picture(Path::new(SOLUTION), s)?;
        let camera = camera.camera(s, settings.size)?;
        let PictureSettings { samples, gather, .. } = settings;
        let options = RenderOptions { width, height, samples, gather, ..RenderOptions::default() };
        Ok::<_, Error>(zonal_render::render(s, &camera, &options, observer))
    })?;
    let flat = image.map_err(|e| of_app(&e))?.pixels.into_flattened();
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
    let picture = settings.field_picture()?;
    let (width, height) = settings.size;
    let drawn = solution.run(py, call, move |s, observer| {
        let camera = camera.camera(s, settings.size)?;
        if let Some(picture) = picture {
            let drawn = picture.pixels(s, &camera, observer)?;
            let png = output::encode_png(width, height, &drawn.colours);
            return Ok::<_, Error>((png.unwrap_or_default(), Some(drawn.range)));
        }
        check_picture(Path::new(SOLUTION), s)?;
        let options = RenderOptions { width, height, samples: settings.samples, ..RenderOptions::default() };
        let image = zonal_render::render(s, &camera, &options, observer);
        let tone = ToneMapping::filmic(output::auto_exposure(&image.pixels));
        Ok((output::encode_picture_png(width, height, &image.pixels, &tone)?, None))
    })?;
    let (png, range) = drawn.map_err(|e| of_app(&e))?;
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
    let call = CallSettings { threads, progress };
    let text = solution.run(py, call, move |s, observer| {
        check_uniform_light(Path::new(SOLUTION), s)?;
        let detail =
            viewer::package::PackageDetail { max_vertices, ..viewer::package::PackageDetail::default() };
        let shown = (first_band > 0).then(|| with_shown_bands(s.clone(), first_band)).transpose()?;
        let packed = viewer::package::package(shown.as_ref().unwrap_or(s), &detail, observer)?;
        Ok::<_, Failure>(viewer::page::single_file(&packed))
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
    let png = output::encode_picture_png(width, height, pixels, &tone).map_err(|e| of_file(&e))?;
    Ok(PyBytes::new(py, &png))
}
