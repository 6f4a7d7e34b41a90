//! Patches and panes as an unstructured grid (.vtu): one cell for each zone, so that the sums of a report are sums over cells.
//!
//! | cell array | contents |
//! |---|---|
//! | `kind` | 0 a patch, 1 a piece of a pane |
//! | `zone` | index among all zones: the row of the solution's arrays |
//! | `surface`, `pane` | row of the field data's `surface names`, `pane names`; −1 on the others |
//! | `area [m2]`, `thickness [m]` | A; t of panes |
//! | `radiosity [W/m2]` | B, direct light included |
//! | `irradiance [W/m2]` | H of patches without direct light; 0 on panes |
//! | `fluence [W/m2]` | G of panes without direct light; 0 on patches |
//! | `direct [W/m2]` | H_dir of patches, G_dir of panes |
//! | `error [W/m2]`, `direct error [W/m2]` | estimated error of irradiance or fluence, and of direct light |
//! | `reflectance`, `extinction [1/m]`, `albedo` | ρ of patches; κ and Ω of panes; 0 on the others |
//! | `emission [W/m2]` | E of zones that emit (surfaces that are direct lights have none) |
//! | `temperature [K]`, `temperature error [K]` | in thermal mode; NaN if undefined |
//! | `net flux [W/m2]`, `net flux error [W/m2]` | net radiative flux that leaves; of panes, through both faces |
//! | `radiosity of NAME [W/m2]` | radiosity of each light group, if there are several |
//!
//! On request there is point data too ([`CornerArray`]); each cell has points of its own, so that values may jump between cells.
//!
//! Sums: over patches Σ BA is the power that leaves them, Σ (1−ρ)(H + H_dir)A what they absorb; over panes 4κ Σ BAt is what
//! they emit and scatter, κ(1−Ω) Σ (G + G_dir)At what they absorb. Corners are those of the zones, each with its own points.

use super::document::{DataArray, NumberType, VtkDocument, name_with_unit};
use super::group_radiosity::group_radiosity;
use crate::output::error::FileError;
use std::path::Path;
use zonal_scene::{Bands, Fields, Plate, PlateKind, Solution, Zones};

/// Values at the corners of the cells of a .vtu, for all bands.
#[derive(Clone, Debug, PartialEq)]
pub struct CornerArray {
    /// Name with unit.
    pub name: &'static str,
    /// For each block of bands the values of the corners of the patches, then of the panes, one zone after the other.
    pub blocks: Vec<Vec<Bands>>,
}

/// Writes the patches and panes of a solution as an unstructured grid with one cell for each zone: radiosity, irradiance or fluence,
/// direct light, errors, material properties, area, owner, temperatures and net flux in thermal mode, and the radiosity of each light
/// group.
///
/// # Errors
///
/// The file cannot be written.
pub fn write_vtu(path: impl AsRef<Path>, s: &Solution) -> Result<(), FileError> {
    write_vtu_with_points(path.as_ref(), s, &[])
}

/// As [`write_vtu`], with arrays of point data.
///
/// # Errors
///
/// The file cannot be written, or an array has another number of blocks or corners than the solution.
pub fn write_vtu_with_points(path: &Path, s: &Solution, arrays: &[CornerArray]) -> Result<(), FileError> {
    let grid = ZoneCells::new(s);
    let blocks: Vec<ZoneCells> = s.blocks().map(ZoneCells::new).collect();
    let n = grid.len();
    let corners: Vec<usize> =
        (0..n).scan(0, |sum, i| Some(std::mem::replace(sum, *sum + grid.corners(i)))).collect();
    let points = corners.last().map_or(0, |c| c + grid.corners(n - 1));
    let owner: Vec<u32> = (0..n).flat_map(|i| std::iter::repeat_n(i as u32, grid.corners(i))).collect();
    let fits = |a: &CornerArray| a.blocks.len() == blocks.len() && a.blocks.iter().all(|v| v.len() == points);
    if let Some(a) = arrays.iter().find(|a| !fits(a)) {
        let message =
            format!("'{}' does not have {points} values for each of {} blocks", a.name, blocks.len());
        return Err(FileError::new(path, "", message));
    }
    let mut d = VtkDocument::new("UnstructuredGrid", "");
    d.names(&[
        ("surface names", s.scene.surfaces().iter().map(|x| x.name.as_str()).collect()),
        ("pane names", s.scene.panes().iter().map(|x| x.name.as_str()).collect()),
        ("group names", s.groups.iter().map(|x| x.name.as_str()).collect()),
    ]);
    d.open(&format!("Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{n}\""));
    if !arrays.is_empty() {
        let of_block = |t: usize| {
            arrays.iter().map(|a| DataArray::bands(a.name, points, move |p| a.blocks[t][p])).collect()
        };
        let all = (0..blocks.len()).map(of_block).collect();
        d.section("PointData", DataArray::joined(s.scene.bands(), all));
    }
    d.section("CellData", DataArray::joined(s.scene.bands(), blocks.iter().map(fields).collect()));
    let place = |p: usize| {
        let i = owner[p] as usize;
        grid.plate(i).corners().0[p - corners[i]].array()
    };
    d.section("Points", vec![DataArray::vectors("position [m]", points, place)]);
    let ends = |i: usize| (corners[i] + grid.corners(i)) as f64;
    // VTK's numbers for a triangle and a quadrilateral.
    let shape = |i: usize| if grid.corners(i) == 3 { 5.0 } else { 9.0 };
    let cells = vec![
        DataArray::scalar("connectivity", NumberType::Int64, points, |p| p as f64),
        DataArray::scalar("offsets", NumberType::Int64, n, ends),
        DataArray::scalar("types", NumberType::UInt8, n, shape),
    ];
    d.section("Cells", cells);
    d.close("Piece");
    d.write(path)
}

/// Patches, then pieces of panes.
struct ZoneCells<'a> {
    s: &'a Solution,
    patches: usize,
}

impl<'a> ZoneCells<'a> {
    fn new(s: &'a Solution) -> ZoneCells<'a> {
        ZoneCells { s, patches: s.zones.patches.len() }
    }
    fn len(&self) -> usize {
        self.patches + self.s.zones.panes.len()
    }
    fn plate(&self, i: usize) -> &'a Plate {
        if i < self.patches {
            &self.s.zones.patches[i].plate
        } else {
            &self.s.zones.panes[i - self.patches].plate
        }
    }
    fn corners(&self, i: usize) -> usize {
        if self.plate(i).kind == PlateKind::Triangle { 3 } else { 4 }
    }
    /// The cell's zone among all zones.
    fn zone(&self, i: usize) -> usize {
        if i < self.patches { i } else { self.s.zones.pane_offset() + i - self.patches }
    }
    /// The value of a cell, by a function of patches and one of pane zones.
    fn of_zone<T>(
        &self,
        patch: impl Fn(&'a zonal_scene::Patch) -> T,
        pane: impl Fn(&'a zonal_scene::PaneZone) -> T,
    ) -> impl Fn(usize) -> T {
        let (zones, patches): (&'a Zones, usize) = (&self.s.zones, self.patches);
        move |i| if i < patches { patch(&zones.patches[i]) } else { pane(&zones.panes[i - patches]) }
    }
}

fn fields<'a>(c: &'a ZoneCells<'a>) -> Vec<DataArray<'a>> {
    let (n, f, s) = (c.len(), &c.s.fields, c.s);
    let when = move |patch: bool, i: usize| {
        if (i < c.patches) == patch { f.incident[c.zone(i)] } else { Bands::ZERO }
    };
    let int = |name: &str, value: Box<dyn Fn(usize) -> f64 + 'a>| {
        DataArray::scalar(name, NumberType::Int64, n, value)
    };
    let mut out = Vec::new();
    for list in Fields::in_tables() {
        if list.name == "incident" {
            out.push(DataArray::bands("irradiance [W/m2]", n, move |i| when(true, i)));
            out.push(DataArray::bands("fluence [W/m2]", n, move |i| when(false, i)));
        } else {
            let (name, values) = (name_with_unit(list.name), (list.of)(f));
            out.push(DataArray::bands(&name, n, move |i| values.get(c.zone(i)).copied().unwrap_or_default()));
        }
    }
    out.extend([
        DataArray::bands("reflectance", n, c.of_zone(|p| p.reflectance, |_| Bands::ZERO)),
        DataArray::bands("extinction [1/m]", n, c.of_zone(|_| Bands::ZERO, |p| p.extinction)),
        DataArray::bands("albedo", n, c.of_zone(|_| Bands::ZERO, |p| p.albedo)),
        DataArray::bands("emission [W/m2]", n, c.of_zone(|p| p.emission, |p| p.emission)),
        DataArray::scalar("area [m2]", NumberType::Float64, n, c.of_zone(|p| p.area, |p| p.area)),
        DataArray::scalar("thickness [m]", NumberType::Float64, n, c.of_zone(|_| 0.0, |p| p.thickness)),
        int("kind", Box::new(c.of_zone(|_| 0.0, |_| 1.0))),
        int("zone", Box::new(move |i| c.zone(i) as f64)),
        int("surface", Box::new(c.of_zone(|p| p.surface as f64, |_| -1.0))),
        int("pane", Box::new(c.of_zone(|_| -1.0, |p| p.pane as f64))),
    ]);
    if let Some(h) = &f.heat {
        // Of panes, W/m³ times the thickness.
        let thickness = move |i: usize| match i.checked_sub(c.patches) {
            Some(k) => s.zones.panes[k].thickness,
            None => 1.0,
        };
        let real = |name: &str, list: &'a [f64]| {
            DataArray::scalar(name, NumberType::Float64, n, move |i| list[c.zone(i)])
        };
        let flux = |name: &str, list: &'a [f64]| {
            DataArray::scalar(name, NumberType::Float64, n, move |i| list[c.zone(i)] * thickness(i))
        };
        out.push(real("temperature [K]", &h.temperature));
        out.push(real("temperature error [K]", &h.temperature_error));
        out.push(flux("net flux [W/m2]", &h.net));
        out.push(flux("net flux error [W/m2]", &h.net_error));
    }
    for g in s.groups.iter().filter(|_| s.groups.len() > 1) {
        let name = format!("radiosity of {} [W/m2]", g.name);
        out.push(DataArray::bands(&name, n, move |i| group_radiosity(s, g, c.zone(i))));
    }
    out
}
