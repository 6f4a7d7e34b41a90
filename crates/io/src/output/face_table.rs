//! Results by face of the mesh files of a solution: one row for each face, in the order of the files.
//!
//! | column | contents |
//! |---|---|
//! | `mesh` | name of the surface that shows the mesh; in an npy its number from 0 |
//! | `face` | number of the face in its mesh file, from 0 |
//! | `surface` | name of the surface of its patches; in an npy its index, −1 without patches |
//! | `area_m2` | area of its patches: both sides of a face that exchanges on both |
//! | `net_flux_W_m2`, `…_error_W_m2` | net flux that leaves |
//! | `temperature_K`, `temperature_error_K` | in thermal mode |
//! | `incident_flux_W_m2`, `…_error_W_m2` | incident flux, direct light included |
//! | `radiosity_W_m2`, `…_error_W_m2` | radiosity |
//! | `absorbed_sunlight_W` | absorbed sunlight, in thermal mode with lights |
//!
//! Errors are those of the exchange, of direct light and of the solver; that of the finite zones is known by surface only.
//!
//! Fluxes are totals in thermal mode. In light mode each band has its columns, `net_flux_0_W_m2` and so on. Faces without patches (without area, panes,
//! covered faces, materials that are left out) have no values: the cell is empty, NaN in an npy.

use super::atomic::write_atomic;
use super::csv::csv_name;
use super::error::FileError;
use super::npz::arrays::write_array;
use super::vtk::document::{DataArray, NumberType, VtkDocument};
use std::io::Write;
use std::path::Path;
use zonal_scene::{Bands, FaceResult, PlateKind, Solution};

/// Results by face as columns of numbers, NaN where there is none.
pub struct FaceColumns {
    /// Name, with the unit at its end, and values of each column after `surface`.
    pub columns: Vec<(String, Vec<f64>)>,
    /// Mesh, face in the mesh, and surface of each row.
    pub keys: Vec<(usize, usize, Option<usize>)>,
}

impl FaceColumns {
    /// The results by face of a solution.
    #[must_use]
    pub fn new(s: &Solution) -> FaceColumns {
        let blocks = s.faces_by_block();
        let faces = &blocks[0];
        let meshes = s.scene.faces().meshes.iter().enumerate();
        let places = meshes.flat_map(|(m, mesh)| (0..mesh.faces).map(move |f| (m, f)));
        let keys = places.zip(faces).map(|((m, f), x)| (m, f, x.surface)).collect();
        let mut out = FaceColumns { columns: Vec::new(), keys };
        out.columns.push(("area_m2".into(), faces.iter().map(|f| f.area).collect()));
        out.add_fluxes(s, &blocks, "net_flux", |f| f.net);
        if s.fields.heat.is_some() {
            for (k, name) in ["temperature_K", "temperature_error_K"].into_iter().enumerate() {
                let kelvin = |f: &FaceResult| f.temperature.map_or(f64::NAN, |t| t[k]);
                out.columns.push((name.into(), faces.iter().map(kelvin).collect()));
            }
        }
        out.add_fluxes(s, &blocks, "incident_flux", |f| f.incident);
        out.add_fluxes(s, &blocks, "radiosity", |f| f.radiosity);
        if s.scene.bands().has_solar_band() {
            let watts = |f: &FaceResult| f.absorbed_sunlight.filter(|_| f.area > 0.0).unwrap_or(f64::NAN);
            out.columns.push(("absorbed_sunlight_W".into(), faces.iter().map(watts).collect()));
        }
        out
    }

    /// Adds a flux and its error: totals in thermal mode, else one pair of columns for each band.
    fn add_fluxes(
        &mut self,
        s: &Solution,
        blocks: &[Vec<FaceResult>],
        name: &str,
        of: fn(&FaceResult) -> [Bands; 2],
    ) {
        let windows: Vec<usize> = s.blocks().map(|t| t.scene.window().len()).collect();
        // All bands of face number `f`: values, or errors.
        let bands = |f: usize, k: usize| -> Vec<f64> {
            let of_block = |(t, count): (usize, &usize)| of(&blocks[t][f])[k].into_iter().take(*count);
            windows.iter().enumerate().flat_map(of_block).collect()
        };
        let mut add = |name: String, k: usize, number: &dyn Fn(Vec<f64>) -> f64| {
            let value = |f: usize| if blocks[0][f].area > 0.0 { number(bands(f, k)) } else { f64::NAN };
            self.columns.push((name, (0..blocks[0].len()).map(value).collect()));
        };
        if s.scene.thermal().is_none() {
            for b in 0..s.scene.bands().count() {
                add(format!("{name}_{b}_W_m2"), 0, &|x| x[b]);
                add(format!("{name}_{b}_error_W_m2"), 1, &|x| x[b]);
            }
            return;
        }
        // The net flux is a total already.
        let is_total = name == "net_flux";
        let total = |x: Vec<f64>| if is_total { x[0] } else { x.iter().sum() };
        add(format!("{name}_W_m2"), 0, &total);
        add(format!("{name}_error_W_m2"), 1, &total);
    }
}

/// Writes the results by face as a table with one line for each face.
///
/// # Errors
///
/// The file cannot be written.
pub fn write_faces_csv(path: &Path, s: &Solution) -> Result<(), FileError> {
    let table = FaceColumns::new(s);
    let meshes: Vec<String> = s.scene.faces().meshes.iter().map(|m| csv_name(&m.name)).collect();
    let surfaces: Vec<String> = s.scene.surfaces().iter().map(|x| csv_name(&x.name)).collect();
    write_atomic(path, |out| {
        write!(out, "mesh,face,surface")?;
        table.columns.iter().try_for_each(|c| write!(out, ",{}", c.0))?;
        writeln!(out)?;
        for (row, (mesh, face, surface)) in table.keys.iter().enumerate() {
            write!(out, "{},{face},{}", meshes[*mesh], surface.map_or("", |k| surfaces[k].as_str()))?;
            for (_, values) in &table.columns {
                match values[row] {
                    x if x.is_nan() => write!(out, ",")?,
                    x => write!(out, ",{x}")?,
                }
            }
            writeln!(out)?;
        }
        Ok(())
    })
}

/// Writes the results by face as an array of doubles, [faces, columns], with the columns of the table.
///
/// # Errors
///
/// The file cannot be written.
pub fn write_faces_npy(path: &Path, s: &Solution) -> Result<(), FileError> {
    let table = FaceColumns::new(s);
    let row = |(row, (mesh, face, surface)): (usize, &(usize, usize, Option<usize>))| {
        let keys = [*mesh as f64, *face as f64, surface.map_or(-1.0, |k| k as f64)];
        let values: Vec<f64> = table.columns.iter().map(|c| c.1[row]).collect();
        keys.into_iter().chain(values)
    };
    let values: Vec<f64> = table.keys.iter().enumerate().flat_map(row).collect();
    write_array(path, &[table.keys.len(), 3 + table.columns.len()], &values)
}

/// Writes the facets of the mesh files as an unstructured grid; cells have the results of their face, its number and the number of its mesh. A polygon that
/// is triangulated has several cells.
///
/// # Errors
///
/// The file cannot be written.
pub fn write_faces_vtu(path: &Path, s: &Solution) -> Result<(), FileError> {
    let table = FaceColumns::new(s);
    let faces = s.scene.faces();
    let cells: Vec<(usize, usize)> =
        (0..s.scene.facets().len()).filter_map(|k| Some((k, faces.face_of(k)?))).collect();
    let n = cells.len();
    let plate = |i: usize| &s.scene.facets()[cells[i].0].plate;
    let corners = |i: usize| if plate(i).kind == PlateKind::Triangle { 3 } else { 4 };
    let ends: Vec<usize> = (0..n)
        .scan(0, |sum, i| {
            *sum += corners(i);
            Some(*sum)
        })
        .collect();
    let owner: Vec<usize> = (0..n).flat_map(|i| std::iter::repeat_n(i, corners(i))).collect();
    let points = owner.len();
    let mut d = VtkDocument::new("UnstructuredGrid", "");
    d.names(&[("mesh names", faces.meshes.iter().map(|m| m.name.as_str()).collect())]);
    d.open(&format!("Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{n}\""));
    let (keys, cells_of) = (&table.keys, &cells);
    let int = |name: &str, of: fn((usize, usize, Option<usize>)) -> usize| {
        DataArray::scalar(name, NumberType::Int64, n, move |i| of(keys[cells_of[i].1]) as f64)
    };
    let mut arrays = vec![int("mesh", |k| k.0), int("face", |k| k.1)];
    let named = |(name, values): &'_ (String, Vec<f64>)| (vtk_name(name), values.clone());
    arrays.extend(table.columns.iter().map(named).map(|(name, values)| {
        DataArray::scalar(&name, NumberType::Float64, n, move |i| values[cells_of[i].1])
    }));
    d.section("CellData", arrays);
    let place = |p: usize| {
        let i = owner[p];
        plate(i).corners().0[p + corners(i) - ends[i]].array()
    };
    d.section("Points", vec![DataArray::vectors("position [m]", points, place)]);
    let shape = |i: usize| if corners(i) == 3 { 5.0 } else { 9.0 };
    let arrays = vec![
        DataArray::scalar("connectivity", NumberType::Int64, points, |p| p as f64),
        DataArray::scalar("offsets", NumberType::Int64, n, |i| ends[i] as f64),
        DataArray::scalar("types", NumberType::UInt8, n, shape),
    ];
    d.section("Cells", arrays);
    d.close("Piece");
    d.write(path)
}

/// `net_flux_error_W_m2` ↦ `net flux error [W/m2]`, as in the other files of VTK.
fn vtk_name(column: &str) -> String {
    let units = [("_W_m2", " [W/m2]"), ("_K", " [K]"), ("_m2", " [m2]"), ("_W", " [W]")];
    let unit = units.into_iter().find_map(|(end, unit)| Some((column.strip_suffix(end)?, unit)));
    let (name, unit) = unit.unwrap_or((column, ""));
    format!("{}{unit}", name.replace('_', " "))
}
