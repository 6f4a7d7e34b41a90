//! The medium as image data (.vti): one cell a cell of the voxmap.
//!
//! | cell array | what |
//! |---|---|
//! | `zones`, `zone` | how many zones share the cell; the first of them among all zones, −1 for none |
//! | `volume [m3]` | free volume V of all its zones; 0 in walls and solids |
//! | `radiosity [W/m2]` | B, direct light included |
//! | `fluence [W/m2]`, `direct [W/m2]` | G without direct light, G_dir |
//! | `error [W/m2]`, `direct error [W/m2]` | estimated error of the fluence, and of direct light |
//! | `extinction [1/m]`, `albedo` | κ, Ω |
//! | `emission [W/m2]`, `source [W/m3]` | black emissive power E, volumetric source q |
//! | `temperature [K]`, `temperature error [K]` | in thermal mode; not a number where none is defined |
//! | `net heat [W/m3]`, `net heat error [W/m3]` | given |
//! | `radiosity of NAME [W/m2]` | the share of each light group, where there are several |
//!
//! Values of a cell that walls divide are means over its zones by volume: B = Σ B_j V_j/V. With V the free volume, Σ BV, and Σ κBV
//! with it (κ is one number a cell), are those of the zones: 4 Σ κBV is what the medium emits and scatters, Σ κ(1−Ω)(G + G_dir)V
//! what it absorbs; the temperature is that of the mean of T⁴. Cells without zones are 0.

use super::FileError;
use super::vtk::{Array, Document, Number};
use super::vtu::radiosity;
use std::path::Path;
use zonal_scene::{Bands, Solution, Voxmap, bands};

/// Writes the medium of a solution; see the module's header for the fields. An error where there is none.
pub fn write_vti(path: &Path, s: &Solution) -> Result<(), FileError> {
    let Some(map) = s.scene.voxmap() else {
        let what = "this solution has no medium to write; write its surfaces as .vtu";
        return Err(FileError::new(path, "", what));
    };
    let [nx, ny, nz] = map.dims();
    let extent = format!("0 {nx} 0 {ny} 0 {nz}");
    let (o, h) = (map.min(), map.cell());
    let head = format!(
        " WholeExtent=\"{extent}\" Origin=\"{} {} {}\" Spacing=\"{} {} {}\"",
        o.x, o.y, o.z, h.x, h.y, h.z
    );
    let mut d = Document::new("ImageData", &head);
    d.names(&[("group names", s.groups.iter().map(|x| x.name.as_str()).collect())]);
    d.open(&format!("Piece Extent=\"{extent}\""));
    d.section("CellData", fields(s, map));
    d.close("Piece");
    d.write(path)
}

/// The voxmap's index of cell `i` in VTK's order, x fastest.
fn cell(map: &Voxmap, i: usize) -> usize {
    let [nx, ny, _] = map.dims();
    map.index([i % nx, i / nx % ny, i / (nx * ny)])
}

fn fields<'a>(s: &'a Solution, map: &'a Voxmap) -> Vec<Array<'a>> {
    let (zones, f, n, first) = (&s.zones, &s.fields, map.len(), s.zones.voxel_offset());
    let here = move |i: usize| zones.of_cell(cell(map, i));
    let volume = move |i: usize| here(i).map(|j| zones.voxels[j].volume).sum::<f64>();
    let mean = move |i: usize, value: &dyn Fn(usize) -> Bands| {
        let (whole, mut sum) = (volume(i), [0.0; 3]);
        for j in here(i) {
            let (x, share) = (value(j), zones.voxels[j].volume / whole);
            sum = bands(|b| sum[b] + share * x[b]);
        }
        sum
    };
    let of = |name: &str, list: &'a [Bands]| Array::three(name, n, move |i| mean(i, &|j| list[first + j]));
    let mut out = vec![
        of("radiosity [W/m2]", &f.radiosity),
        of("fluence [W/m2]", &f.incident),
        of("direct [W/m2]", &f.direct),
        of("error [W/m2]", &f.error),
        Array::three("direct error [W/m2]", n, move |i| {
            mean(i, &|j| f.direct_error.get(first + j).copied().unwrap_or_default())
        }),
        Array::three("extinction [1/m]", n, move |i| mean(i, &|j| zones.voxels[j].extinction)),
        Array::three("albedo", n, move |i| mean(i, &|j| zones.voxels[j].albedo)),
        Array::three("emission [W/m2]", n, move |i| mean(i, &|j| zones.voxels[j].emission)),
        Array::three("source [W/m3]", n, move |i| mean(i, &|j| zones.voxels[j].source)),
        Array::one("volume [m3]", Number::Float64, n, volume),
        Array::one("zones", Number::Int64, n, move |i| here(i).len() as f64),
        Array::one("zone", Number::Int64, n, move |i| here(i).next().map_or(-1.0, |j| (first + j) as f64)),
    ];
    if let Some(h) = &f.heat {
        let one = |name: &str, list: &'a [f64], power: i32| {
            let value = move |i: usize| {
                let at = |j: usize| [list[first + j].powi(power); 3];
                mean(i, &at)[0].powf(1.0 / f64::from(power))
            };
            Array::one(name, Number::Float64, n, value)
        };
        out.push(one("temperature [K]", &h.temperature, 4));
        out.push(one("temperature error [K]", &h.temperature_error, 1));
        out.push(one("net heat [W/m3]", &h.net, 1));
        out.push(one("net heat error [W/m3]", &h.net_error, 1));
    }
    for g in s.groups.iter().filter(|_| s.groups.len() > 1) {
        let name = format!("radiosity of {} [W/m2]", g.name);
        out.push(Array::three(&name, n, move |i| mean(i, &|j| radiosity(s, g, first + j))));
    }
    out
}
