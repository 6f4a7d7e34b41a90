//! The faces of mesh files and the values by face in a solution file.
//!
//! | array | contents |
//! |---|---|
//! | `facet_face` | index of each facet's face among the faces of all meshes, plus 1; 0 for none |
//! | `facet_condition` | rows of kind and value: 0 none, 1 temperature (K), 2 flux (W/m²), 3 power of the face (W) |
//! | `facet_reflectance`, `facet_emission` | ρ, and E in W/m²; −1 for none |
//!
//! Arrays without content are left out. The names of the meshes and their numbers of faces are in the header.

use crate::output::error::FileError;
use crate::output::npz::reader::NpzReader;
use crate::output::npz::writer::{ArraySink, ArrayWriter};
use std::io;
use zonal_scene::{Bands, FaceMesh, FaceTable, FacetValues, ThermalCondition};

/// Bytes that a reader needs for each face.
const BYTES_PER_FACE: u64 = 512;
/// A row without a value.
const NO_VALUE: [f64; 3] = [-1.0; 3];

/// Writes the faces of `facets` facets.
pub(super) fn write_faces<S: ArraySink>(
    npz: &mut ArrayWriter<S>,
    table: &FaceTable,
    facets: usize,
) -> io::Result<()> {
    if !table.meshes.is_empty() {
        npz.ints("facet_face", facets, |k| table.face_of(k).map_or(0, |f| f + 1))?;
    }
    let has = |of: fn(&FacetValues) -> bool| table.values.iter().any(of);
    let rows = |of: fn(FacetValues) -> [f64; 3]| move |k| of(table.values_of(k));
    if has(|v| v.condition.is_some()) {
        npz.rows("facet_condition", &[facets], rows(condition_row))?;
    }
    if has(|v| v.reflectance.is_some()) {
        npz.rows("facet_reflectance", &[facets], rows(|v| v.reflectance.map_or(NO_VALUE, Bands::to_rgb)))?;
    }
    if has(|v| v.emission.is_some()) {
        npz.rows("facet_emission", &[facets], rows(|v| v.emission.map_or(NO_VALUE, Bands::to_rgb)))?;
    }
    Ok(())
}

fn condition_row(v: FacetValues) -> [f64; 3] {
    match v.condition {
        None => [0.0; 3],
        Some(ThermalCondition::Temperature(t)) => [1.0, t, 0.0],
        Some(ThermalCondition::Flux(q)) => [2.0, q, 0.0],
        Some(ThermalCondition::Power(p)) => [3.0, p, 0.0],
    }
}

fn condition_of_row(row: [f64; 3]) -> Option<ThermalCondition> {
    match row[0] as i64 {
        1 => Some(ThermalCondition::Temperature(row[1])),
        2 => Some(ThermalCondition::Flux(row[1])),
        3 => Some(ThermalCondition::Power(row[1])),
        _ => None,
    }
}

/// Reads the faces of `facets` facets. Ranges are checked by the constructor of the scene.
pub(super) fn read_faces(
    npz: &mut NpzReader<'_>,
    meshes: Vec<FaceMesh>,
    facets: usize,
) -> Result<FaceTable, FileError> {
    let mut table = FaceTable { meshes, ..FaceTable::default() };
    let faces = table.meshes.iter().fold(0u64, |n, m| n.saturating_add(m.faces as u64));
    npz.charge("facet_face", faces.saturating_mul(BYTES_PER_FACE))?;
    if npz.has("facet_face") {
        let faces = npz.ints("facet_face", Some(facets), faces as usize + 1)?;
        table.face_of_facet = faces.into_iter().map(|f| f.checked_sub(1)).collect();
    }
    let mut values = vec![FacetValues::default(); facets];
    let band = |row: [f64; 3]| (row != NO_VALUE).then(|| Bands::from_rgb(row));
    let mut read = |name: &str, set: &dyn Fn(&mut FacetValues, [f64; 3])| {
        if npz.has(name) {
            let rows = npz.same_or_each(name, &[facets])?;
            values.iter_mut().enumerate().for_each(|(k, v)| set(v, rows[k]));
        }
        Ok::<(), FileError>(())
    };
    read("facet_condition", &|v, row| v.condition = condition_of_row(row))?;
    read("facet_reflectance", &|v, row| v.reflectance = band(row))?;
    read("facet_emission", &|v, row| v.emission = band(row))?;
    if values.iter().any(|v| *v != FacetValues::default()) {
        table.values = values;
    }
    Ok(table)
}
