//! Patches and panes as an unstructured grid (.vtu): one cell a zone, so that every sum of a report is a sum over cells.
//!
//! | cell array | what |
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
//! | `emission [W/m2]` | E of zones that emit (lamps that are direct light have none) |
//! | `temperature [K]`, `temperature error [K]` | in thermal mode; not a number where none is defined |
//! | `net flux [W/m2]`, `net flux error [W/m2]` | given by a square metre: of panes, through both faces |
//! | `radiosity of NAME [W/m2]` | the share of each light group, where there are several |
//!
//! Sums: over patches Σ BA is the power that leaves them, Σ (1−ρ)(H + H_dir)A what they absorb; over panes 4κ Σ BAt is what
//! they emit and scatter, κ(1−Ω) Σ (G + G_dir)At what they absorb. Corners are those of the zones, each with its own points.

use super::FileError;
use super::vtk::{Array, Document, Number};
use std::path::Path;
use zonal_scene::{Bands, Group, Plate, PlateKind, Solution, Zones, bands};

/// Writes the patches and panes of a solution; see the module's header for the fields.
pub fn write_vtu(path: &Path, s: &Solution) -> Result<(), FileError> {
    let grid = Cells::new(s);
    let n = grid.len();
    let corners: Vec<usize> =
        (0..n).scan(0, |sum, i| Some(std::mem::replace(sum, *sum + grid.corners(i)))).collect();
    let points = corners.last().map_or(0, |c| c + grid.corners(n - 1));
    let owner: Vec<u32> = (0..n).flat_map(|i| std::iter::repeat_n(i as u32, grid.corners(i))).collect();
    let mut d = Document::new("UnstructuredGrid", "");
    d.names(&[
        ("surface names", s.scene.surfaces().iter().map(|x| x.name.as_str()).collect()),
        ("pane names", s.scene.panes().iter().map(|x| x.name.as_str()).collect()),
        ("group names", s.groups.iter().map(|x| x.name.as_str()).collect()),
    ]);
    d.open(&format!("Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{n}\""));
    d.section("CellData", fields(&grid));
    let place = |p: usize| {
        let i = owner[p] as usize;
        grid.plate(i).corners().0[p - corners[i]].array()
    };
    d.section("Points", vec![Array::three("position [m]", points, place)]);
    let ends = |i: usize| (corners[i] + grid.corners(i)) as f64;
    // VTK's numbers for a triangle and a quadrilateral.
    let shape = |i: usize| if grid.corners(i) == 3 { 5.0 } else { 9.0 };
    let cells = vec![
        Array::one("connectivity", Number::Int64, points, |p| p as f64),
        Array::one("offsets", Number::Int64, n, ends),
        Array::one("types", Number::UInt8, n, shape),
    ];
    d.section("Cells", cells);
    d.close("Piece");
    d.write(path)
}

/// Patches, then pieces of panes.
struct Cells<'a> {
    s: &'a Solution,
    patches: usize,
}

impl<'a> Cells<'a> {
    fn new(s: &'a Solution) -> Cells<'a> {
        Cells { s, patches: s.zones.patches.len() }
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
    /// An array with a value a patch and one a pane zone.
    fn each<T>(
        &self,
        patch: impl Fn(&'a zonal_scene::Patch) -> T,
        pane: impl Fn(&'a zonal_scene::PaneZone) -> T,
    ) -> impl Fn(usize) -> T {
        let (zones, patches): (&'a Zones, usize) = (&self.s.zones, self.patches);
        move |i| if i < patches { patch(&zones.patches[i]) } else { pane(&zones.panes[i - patches]) }
    }
}

fn fields<'a>(c: &'a Cells<'a>) -> Vec<Array<'a>> {
    let (n, f, s) = (c.len(), &c.s.fields, c.s);
    let zero = [0.0; 3];
    let of = |name: &str, list: &'a [Bands]| Array::three(name, n, move |i| list[c.zone(i)]);
    let when =
        move |patch: bool, i: usize| if (i < c.patches) == patch { f.incident[c.zone(i)] } else { zero };
    let int = |name: &str, value: Box<dyn Fn(usize) -> f64 + 'a>| Array::one(name, Number::Int64, n, value);
    let mut out = vec![
        of("radiosity [W/m2]", &f.radiosity),
        Array::three("irradiance [W/m2]", n, move |i| when(true, i)),
        Array::three("fluence [W/m2]", n, move |i| when(false, i)),
        of("direct [W/m2]", &f.direct),
        of("error [W/m2]", &f.error),
        Array::three("direct error [W/m2]", n, move |i| {
            f.direct_error.get(c.zone(i)).copied().unwrap_or(zero)
        }),
        Array::three("reflectance", n, c.each(|p| p.reflectance, |_| [0.0; 3])),
        Array::three("extinction [1/m]", n, c.each(|_| [0.0; 3], |p| p.extinction)),
        Array::three("albedo", n, c.each(|_| [0.0; 3], |p| p.albedo)),
        Array::three("emission [W/m2]", n, c.each(|p| p.emission, |p| p.emission)),
        Array::one("area [m2]", Number::Float64, n, c.each(|p| p.area, |p| p.area)),
        Array::one("thickness [m]", Number::Float64, n, c.each(|_| 0.0, |p| p.thickness)),
        int("kind", Box::new(c.each(|_| 0.0, |_| 1.0))),
        int("zone", Box::new(move |i| c.zone(i) as f64)),
        int("surface", Box::new(c.each(|p| p.surface as f64, |_| -1.0))),
        int("pane", Box::new(c.each(|_| -1.0, |p| p.pane as f64))),
    ];
    if let Some(h) = &f.heat {
        // Of a pane W/m³ times its thickness.
        let thick = move |i: usize| match i.checked_sub(c.patches) {
            Some(k) => s.zones.panes[k].thickness,
            None => 1.0,
        };
        let real =
            |name: &str, list: &'a [f64]| Array::one(name, Number::Float64, n, move |i| list[c.zone(i)]);
        let flux = |name: &str, list: &'a [f64]| {
            Array::one(name, Number::Float64, n, move |i| list[c.zone(i)] * thick(i))
        };
        out.push(real("temperature [K]", &h.temperature));
        out.push(real("temperature error [K]", &h.temperature_error));
        out.push(flux("net flux [W/m2]", &h.net));
        out.push(flux("net flux error [W/m2]", &h.net_error));
    }
    for g in s.groups.iter().filter(|_| s.groups.len() > 1) {
        let name = format!("radiosity of {} [W/m2]", g.name);
        out.push(Array::three(&name, n, move |i| radiosity(s, g, c.zone(i))));
    }
    out
}

/// B of one light group, direct light included.
pub(super) fn radiosity(s: &Solution, g: &Group, zone: usize) -> Bands {
    let (h, d, (rho, _)) = (g.incident.at(zone), g.direct.at(zone), s.zones.response(zone));
    let e = if g.kind.emits(&s.zones, zone) { s.zones.emission(zone) } else { [0.0; 3] };
    bands(|b| e[b] + rho[b] * (h[b] * g.incident_scale[b] + d[b] * g.direct_scale[b]))
}
