//! The medium as image data (.vti): one cell for each voxel.
//!
//! | cell array | contents |
//! |---|---|
//! | `zones`, `zone` | number of zones in the cell; index of the first among all zones, −1 for none |
//! | `volume [m3]` | free volume V of all its zones; 0 in walls and solids |
//! | `radiosity [W/m2]` | B, direct light included |
//! | `fluence [W/m2]`, `direct [W/m2]` | G without direct light, G_dir |
//! | `error [W/m2]`, `direct error [W/m2]` | estimated error of the fluence, and of direct light |
//! | `extinction [1/m]`, `albedo` | κ, Ω |
//! | `emission [W/m2]`, `source [W/m3]` | black emissive power E, volumetric source q |
//! | `temperature [K]`, `temperature error [K]` | in thermal mode; NaN if undefined |
//! | `net heat [W/m3]`, `net heat error [W/m3]` | net radiative power that leaves |
//! | `radiosity of NAME [W/m2]` | radiosity of each light group, if there are several |
//!
//! A cell that walls divide has the volume means over its zones: B = Σ B_j V_j/V. With V the free volume, Σ BV, and Σ κBV
//! with it (κ is one number per cell), are those of the zones: 4 Σ κBV is what the medium emits and scatters, Σ κ(1−Ω)(G + G_dir)V
//! what it absorbs; the temperature is that of the mean of T⁴. Cells without zones are 0.

use super::document::{DataArray, NumberType, VtkDocument, name_with_unit};
use super::group_radiosity::group_radiosity;
use crate::output::error::FileError;
use std::path::Path;
use zonal_scene::{Bands, FieldList, Fields, Solution, VoxelGrid};

/// Writes the medium of a solution as image data with one cell for each voxel: radiosity, fluence, direct light, errors, extinction,
/// albedo, emission and source, volume and zone, temperatures and net heat in thermal mode, and the radiosity of each light group.
///
/// # Errors
///
/// The solution has no medium, or the file cannot be written.
pub fn write_vti(path: impl AsRef<Path>, s: &Solution) -> Result<(), FileError> {
    let path = path.as_ref();
    let Some(map) = s.scene.voxel_grid() else {
        let message = "this solution has no medium to write; write its surfaces as .vtu";
        return Err(FileError::new(path, "", message));
    };
    let [nx, ny, nz] = map.dims();
    let extent = format!("0 {nx} 0 {ny} 0 {nz}");
    let (o, h) = (map.min(), map.cell());
    let head = format!(
        " WholeExtent=\"{extent}\" Origin=\"{} {} {}\" Spacing=\"{} {} {}\"",
        o.x, o.y, o.z, h.x, h.y, h.z
    );
    let mut d = VtkDocument::new("ImageData", &head);
    d.names(&[("group names", s.groups.iter().map(|x| x.name.as_str()).collect())]);
    d.open(&format!("Piece Extent=\"{extent}\""));
    let arrays = s.blocks().map(|t| fields(t, map)).collect();
    d.section("CellData", DataArray::joined(s.scene.bands(), arrays));
    d.close("Piece");
    d.write(path)
}

/// The voxel index of cell `i` in VTK's order, x fastest.
fn cell(map: &VoxelGrid, i: usize) -> usize {
    let [nx, ny, _] = map.dims();
    map.index([i % nx, i / nx % ny, i / (nx * ny)])
}

fn fields<'a>(s: &'a Solution, map: &'a VoxelGrid) -> Vec<DataArray<'a>> {
    let (zones, f, n, first) = (&s.zones, &s.fields, map.len(), s.zones.voxel_offset());
    let here = move |i: usize| zones.voxel_zones_of_cell(cell(map, i));
    let volume = move |i: usize| here(i).map(|j| zones.voxels.at(j).volume).sum::<f64>();
    let mean = move |i: usize, value: &dyn Fn(usize) -> Bands| {
        let (whole, mut sum) = (volume(i), Bands::ZERO);
        for j in here(i) {
            let (x, fraction) = (value(j), zones.voxels.at(j).volume / whole);
            sum += fraction * x;
        }
        sum
    };
    let of_list = |list: FieldList| {
        let name = if list.name == "incident" { "fluence" } else { list.name };
        let values = (list.of)(f);
        let value = move |j: usize| values.get(first + j).copied().unwrap_or_default();
        DataArray::bands(&name_with_unit(name), n, move |i| mean(i, &value))
    };
    let mut out: Vec<DataArray> = Fields::in_tables().map(of_list).collect();
    out.extend([
        DataArray::bands("extinction [1/m]", n, move |i| mean(i, &|j| zones.voxels.at(j).extinction)),
        DataArray::bands("albedo", n, move |i| mean(i, &|j| zones.voxels.at(j).albedo)),
        DataArray::bands("emission [W/m2]", n, move |i| mean(i, &|j| zones.voxels.at(j).emission)),
        DataArray::bands("source [W/m3]", n, move |i| mean(i, &|j| zones.voxels.at(j).source)),
        DataArray::scalar("volume [m3]", NumberType::Float64, n, volume),
        DataArray::scalar("zones", NumberType::Int64, n, move |i| here(i).len() as f64),
        DataArray::scalar("zone", NumberType::Int64, n, move |i| {
            here(i).next().map_or(-1.0, |j| (first + j) as f64)
        }),
    ]);
    if let Some(h) = &f.heat {
        let one = |name: &str, list: &'a [f64], power: i32| {
            let value = move |i: usize| {
                let whole = volume(i);
                let terms = here(i).map(|j| zones.voxels.at(j).volume / whole * list[first + j].powi(power));
                terms.fold(0.0, |sum, x| sum + x).powf(1.0 / f64::from(power))
            };
            DataArray::scalar(name, NumberType::Float64, n, value)
        };
        out.push(one("temperature [K]", &h.temperature, 4));
        out.push(one("temperature error [K]", &h.temperature_error, 1));
        out.push(one("net heat [W/m3]", &h.net, 1));
        out.push(one("net heat error [W/m3]", &h.net_error, 1));
    }
    for g in s.groups.iter().filter(|_| s.groups.len() > 1) {
        let name = format!("radiosity of {} [W/m2]", g.name);
        out.push(DataArray::bands(&name, n, move |i| mean(i, &|j| group_radiosity(s, g, first + j))));
    }
    out
}
