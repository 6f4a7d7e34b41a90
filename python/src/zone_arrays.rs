//! Arrays of the zones of a solution: patches, then voxel zones, then pane zones.
//!
//! | array | shape | content |
//! |---|---|---|
//! | `size` | `n` | area of patches, m²; volume of volume zones, m³ |
//! | `kind` | `n` | 0 patch, 1 voxel zone, 2 pane zone |
//! | `name_index` | `n` | index into the names of surfaces, medium and panes |
//! | `centre`, `normal` | [n, 3] | m; unit normal, 0 of voxel zones |
//! | `corners` | [patches + panes, 4, 3] | corners of patches, then of pane zones, m; the last corner of a triangle is twice there |
//! | `is_triangle` | patches + panes | 1 for triangles |
//! | `facet`, `face` | patches | index of the facet; of the face among those of all meshes, −1 for none |
//! | `cell` | voxel zones | index of the cell of the grid, (x ny + y) nz + z |
//! | `reflectance` | [n, bands] | ρ of patches, Ω of volumes |
//! | `extinction` | [n, bands] | κ of volumes, 1/m; 0 of patches |
//! | `emission` | [n, bands] | the part of the radiosity that is emitted, W/m² |

use crate::arrays;
use numpy::PyArrayMethods;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use zonal_io::output::FaceColumns;
use zonal_math::Vec3;
use zonal_scene::{
    Bands, Fields, HeatReport, LightGroup, Plate, PlateKind, Solution, SurfaceResult, ZoneValues,
};

/// The names of the arrays.
pub(crate) const NAMES: [&str; 13] = [
    "size",
    "kind",
    "name_index",
    "centre",
    "normal",
    "corners",
    "is_triangle",
    "facet",
    "face",
    "cell",
    "reflectance",
    "extinction",
    "emission",
];

/// Names of the surfaces, of the medium and of the panes.
pub(crate) fn names(s: &Solution) -> Vec<String> {
    let mut names: Vec<String> = s.scene.surfaces().iter().map(|s| s.name.clone()).collect();
    if !s.zones.voxels.is_empty() {
        names.push("medium".into());
    }
    names.extend(s.scene.panes().iter().map(|p| p.name.clone()));
    names
}

/// The array of a name; none for other names.
pub(crate) fn array<'py>(py: Python<'py>, s: &Solution, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
    let z = &s.zones;
    let (voxels, panes, n) = (z.voxel_offset(), z.pane_offset(), z.len());
    let plates = || z.patches.iter().map(|p| &p.plate).chain(z.panes.iter().map(|p| &p.plate));
    let is_triangle = |p: &Plate| p.kind == PlateKind::Triangle;
    let array = match name {
        "size" => arrays::list(py, (0..n).map(|i| z.response(i).1).collect()).into_any(),
        "kind" => {
            let kind = |i: usize| usize::from(i >= voxels) + usize::from(i >= panes);
            arrays::integers(py, (0..n).map(kind)).into_any()
        }
        "name_index" => arrays::integers(py, name_indices(s).into_iter()).into_any(),
        "centre" => vectors(py, (0..n).map(|i| centre(s, i)).collect())?,
        "normal" => vectors(py, (0..n).map(|i| normal(s, i)).collect())?,
        "corners" => {
            let flat: Vec<f64> = plates().flat_map(corners).flat_map(Vec3::array).collect();
            let count = flat.len() / 12;
            arrays::list(py, flat).reshape([count, 4, 3])?.into_any()
        }
        "is_triangle" => arrays::integers(py, plates().map(|p| usize::from(is_triangle(p)))).into_any(),
        "facet" => arrays::integers(py, z.patches.iter().map(|p| p.facet)).into_any(),
        "face" => {
            let face = |f: usize| s.scene.faces().face_of(f).map_or(-1, |f| f as i64);
            let faces: Vec<i64> = z.patches.iter().map(|p| face(p.facet)).collect();
            numpy::PyArray1::from_vec(py, faces).into_any()
        }
        "cell" => arrays::integers(py, z.voxels.iter().map(|v| v.cell)).into_any(),
        "reflectance" => {
            let of = |t: &Solution, i: usize| t.zones.response(i).0 * if i < voxels { 1.0 } else { 4.0 };
            band_rows(py, s, &of)?
        }
        "extinction" => band_rows(py, s, &extinction)?,
        "emission" => band_rows(py, s, &|t: &Solution, i: usize| t.zones.emission(i))?,
        _ => return Ok(None),
    };
    Ok(Some(array))
}

fn name_indices(s: &Solution) -> Vec<usize> {
    let z = &s.zones;
    let surfaces = s.scene.surfaces().len();
    let first_pane = surfaces + usize::from(!z.voxels.is_empty());
    let patches = z.patches.iter().map(|p| p.surface);
    let voxels = std::iter::repeat_n(surfaces, z.voxels.len());
    patches.chain(voxels).chain(z.panes.iter().map(|p| first_pane + p.pane)).collect()
}

fn plate_centre(p: &Plate) -> Vec3 {
    let share = if p.kind == PlateKind::Triangle { 1.0 / 3.0 } else { 0.5 };
    p.origin + (p.e1 + p.e2) * share
}

fn centre(s: &Solution, i: usize) -> Vec3 {
    let z = &s.zones;
    if i < z.voxel_offset() {
        plate_centre(&z.patches[i].plate)
    } else if i < z.pane_offset() {
        z.voxels.at(i - z.voxel_offset()).centre
    } else {
        plate_centre(&z.panes[i - z.pane_offset()].plate)
    }
}

fn normal(s: &Solution, i: usize) -> Vec3 {
    let z = &s.zones;
    if i < z.voxel_offset() {
        z.patches[i].normal
    } else if i < z.pane_offset() {
        Vec3::ZERO
    } else {
        z.panes[i - z.pane_offset()].normal
    }
}

fn extinction(s: &Solution, i: usize) -> Bands {
    let z = &s.zones;
    if i < z.voxel_offset() {
        Bands::ZERO
    } else if i < z.pane_offset() {
        z.voxels.at(i - z.voxel_offset()).extinction
    } else {
        z.panes[i - z.pane_offset()].extinction
    }
}

fn corners(p: &Plate) -> [Vec3; 4] {
    let (a, b, d) = (p.origin, p.origin + p.e1, p.origin + p.e2);
    if p.kind == PlateKind::Triangle { [a, b, d, d] } else { [a, b, b + p.e2, d] }
}

fn vectors(py: Python<'_>, values: Vec<Vec3>) -> PyResult<Bound<'_, PyAny>> {
    let flat = values.into_iter().flat_map(Vec3::array).collect();
    Ok(arrays::rows(py, flat, 3)?.into_any())
}

/// A row of all bands for each zone.
fn band_rows<'py>(
    py: Python<'py>,
    s: &Solution,
    value: &dyn Fn(&Solution, usize) -> Bands,
) -> PyResult<Bound<'py, PyAny>> {
    let flat: Vec<f64> = (0..s.zones.len()).flat_map(|i| s.all_bands(|t| value(t, i))).collect();
    Ok(arrays::rows(py, flat, s.scene.bands().count())?.into_any())
}

/// A field of a solution of more than three bands, by the index of its name.
pub(crate) fn field_of_blocks<'py>(
    py: Python<'py>,
    s: &Solution,
    field: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let of = |f: &Fields, i: usize| -> Bands {
        // Lists without rows stand for zeros.
        (Fields::LISTS[field].of)(f).get(i).copied().unwrap_or_default()
    };
    band_rows(py, s, &|t: &Solution, i: usize| of(&t.fields, i))
}

/// A field of thermal mode of a solution of more than three bands.
pub(crate) fn heat_of_blocks<'py>(py: Python<'py>, s: &Solution, field: usize) -> Option<Bound<'py, PyAny>> {
    let heat = s.fields.heat.as_ref()?;
    let lists = [&heat.temperature, &heat.temperature_error, &heat.net, &heat.net_error];
    Some(arrays::list(py, lists[field].clone()).into_any())
}

/// The part of a light group in a field; none for other names.
pub(crate) fn group_array<'py>(
    py: Python<'py>,
    s: &Solution,
    group: &str,
    name: &str,
) -> PyResult<Option<Bound<'py, PyAny>>> {
    let Some(k) = s.groups.iter().position(|g| g.name == group) else { return Ok(None) };
    let values = |g: &LightGroup| -> Option<(&'static str, Bands)> { scale(g, name) };
    if values(&s.groups[k]).is_none() {
        return Ok(None);
    }
    let of = |t: &Solution, i: usize| {
        let g = &t.groups[k];
        let list: &ZoneValues = match name {
            "incident" => &g.incident,
            "direct" => &g.direct,
            "error" => &g.error,
            _ => &g.direct_error,
        };
        list.at(i) * scale(g, name).map_or(Bands::ONE, |s| s.1)
    };
    band_rows(py, s, &of).map(Some)
}

/// The name of a field of a light group, and its factor.
fn scale(g: &LightGroup, name: &str) -> Option<(&'static str, Bands)> {
    Some(match name {
        "incident" => ("incident", g.incident_scale),
        "error" => ("error", g.incident_scale),
        "direct" => ("direct", g.direct_scale),
        "direct_error" => ("direct_error", g.direct_scale),
        _ => return None,
    })
}

/// Columns of results by name: of surfaces, medium and panes in thermal mode, of surfaces in light mode. Unknown numbers are NaN, unknown errors
/// infinite.
pub(crate) fn table<'py>(py: Python<'py>, s: &Solution) -> PyResult<Bound<'py, PyDict>> {
    match &s.report.heat {
        Some(heat) => heat_table(py, s, heat),
        None => surface_table(py, s),
    }
}

/// A column; unknown numbers are NaN.
fn numbers(py: Python<'_>, values: Vec<Option<f64>>) -> Bound<'_, PyAny> {
    arrays::list(py, values.into_iter().map(|x| x.unwrap_or(f64::NAN)).collect()).into_any()
}

/// Value, total error and its parts as four columns: `NAME`, `NAME_error`, `NAME_exchange_error`, `NAME_discretization_error`.
fn set_quantity(out: &Bound<'_, PyDict>, name: &str, rows: &[[Option<f64>; 4]]) -> PyResult<()> {
    for (k, part) in ["", "_error", "_exchange_error", "_discretization_error"].into_iter().enumerate() {
        let column = rows.iter().map(|r| r[k]).collect();
        out.set_item(format!("{name}{part}"), numbers(out.py(), column))?;
    }
    Ok(())
}

/// Temperatures, fluxes and powers of surfaces, medium and panes. Each error is whole, and its parts stand beside it; unknown ones are infinite.
fn heat_table<'py>(py: Python<'py>, s: &Solution, heat: &HeatReport) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    let zones = s.report.discretization_error.as_ref();
    let rows = &heat.rows;
    out.set_item("name", rows.iter().map(|r| r.name.clone()).collect::<Vec<_>>())?;
    out.set_item("kind", rows.iter().map(|r| r.kind.name()).collect::<Vec<_>>())?;
    out.set_item("size", numbers(py, rows.iter().map(|r| Some(r.size)).collect()))?;
    let mut columns: [Vec<[Option<f64>; 4]>; 3] = Default::default();
    for (k, r) in rows.iter().enumerate() {
        let of_zones = zones.and_then(|z| z.heat.get(k)).copied();
        let [kelvin, watts] = of_zones.unwrap_or([f64::INFINITY; 2]);
        let [of_temperature, of_flux, of_power] = r.errors(of_zones);
        let [flux, flux_error] = r.flux();
        let flux_of_zones = if watts.is_finite() { r.over_size(watts) } else { watts };
        let known = |x: f64| r.temperature.map(|_| x);
        columns[0].push([r.temperature, known(of_temperature), r.temperature_error, known(kelvin)]);
        columns[1].push([flux, of_flux, flux_error, flux_of_zones].map(Some));
        columns[2].push([r.power, of_power, r.power_error, watts].map(Some));
    }
    for (name, rows) in ["temperature", "net_flux", "net_power"].into_iter().zip(&columns) {
        set_quantity(&out, name, rows)?;
    }
    if s.scene.bands().has_solar_band() {
        out.set_item("absorbed_sunlight", numbers(py, rows.iter().map(|r| r.absorbed_sunlight).collect()))?;
    }
    Ok(out)
}

/// Fluxes and powers of surfaces in light mode, with errors as in [`heat_table`].
fn surface_table<'py>(py: Python<'py>, s: &Solution) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    let rows = s.surfaces();
    out.set_item("name", rows.iter().map(|r| r.name.clone()).collect::<Vec<_>>())?;
    out.set_item("kind", rows.iter().map(|_| "surface").collect::<Vec<_>>())?;
    out.set_item("size", numbers(py, rows.iter().map(|r| Some(r.area)).collect()))?;
    let power = |r: &SurfaceResult| {
        let unknown = f64::INFINITY;
        let [whole, of_zones] = [r.total_error(), r.discretization_error].map(|e| e.unwrap_or(unknown));
        [r.net_power, whole, r.exchange_error, of_zones]
    };
    let over_area = |r: &SurfaceResult, x: f64| if r.area > 0.0 { x / r.area } else { 0.0 };
    let flux = |r: &SurfaceResult| power(r).map(|x| if x.is_finite() { over_area(r, x) } else { x });
    set_quantity(&out, "net_flux", &rows.iter().map(|r| flux(r).map(Some)).collect::<Vec<_>>())?;
    set_quantity(&out, "net_power", &rows.iter().map(|r| power(r).map(Some)).collect::<Vec<_>>())?;
    Ok(out)
}

/// A column of a table: its name, and the values of a surface in the bands of a block.
type BandColumn<'a> = (&'static str, &'a dyn Fn(&Solution, usize) -> Bands);

/// Power that every surface absorbs in each band in light mode, W, its total error, and the parts of the error; (surfaces, bands) each.
pub(crate) fn absorbed<'py>(py: Python<'py>, s: &Solution) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    let by_name =
        |list: &[(String, Bands)], k: usize, missing: f64| list.get(k).map_or(Bands::splat(missing), |x| x.1);
    let unknown = f64::INFINITY;
    let exchange = |t: &Solution, k: usize| by_name(&t.report.energy_error.absorbed_surfaces, k, unknown);
    let zones = |t: &Solution, k: usize| {
        let zones = t.report.discretization_error.as_ref();
        zones.map_or(Bands::splat(unknown), |z| by_name(&z.energy.absorbed_surfaces, k, unknown))
    };
    let value = |t: &Solution, k: usize| by_name(&t.report.energy.absorbed_surfaces, k, f64::NAN);
    let whole = |t: &Solution, k: usize| exchange(t, k) + zones(t, k);
    let columns: [BandColumn; 4] = [
        ("absorbed", &value),
        ("absorbed_error", &whole),
        ("absorbed_exchange_error", &exchange),
        ("absorbed_discretization_error", &zones),
    ];
    let surfaces = if s.report.heat.is_none() { s.scene.surfaces().len() } else { 0 };
    for (name, of) in columns {
        let flat: Vec<f64> = (0..surfaces).flat_map(|k| s.all_bands(|t| of(t, k))).collect();
        out.set_item(name, arrays::rows(py, flat, s.scene.bands().count())?)?;
    }
    Ok(out)
}

/// Columns of results by face of the meshes, with the names and units of the table of `zonal export --faces`.
pub(crate) fn face_table<'py>(py: Python<'py>, s: &Solution) -> PyResult<Bound<'py, PyDict>> {
    let table = FaceColumns::new(s);
    let out = PyDict::new(py);
    let (meshes, surfaces) = (&s.scene.faces().meshes, s.scene.surfaces());
    let names = table.keys.iter().map(|k| meshes[k.0].name.clone()).collect::<Vec<_>>();
    out.set_item("mesh", names)?;
    out.set_item("face", arrays::integers(py, table.keys.iter().map(|k| k.1)))?;
    let surface = |k: &(usize, usize, Option<usize>)| k.2.map_or(String::new(), |i| surfaces[i].name.clone());
    out.set_item("surface", table.keys.iter().map(surface).collect::<Vec<_>>())?;
    for (name, values) in table.columns {
        out.set_item(name, arrays::list(py, values))?;
    }
    Ok(out)
}
