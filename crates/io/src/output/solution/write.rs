//! Writing of a solution.

use super::faces::write_faces;
use super::header::encode_header;
use super::shading::write_shading;
use crate::output::atomic::write_atomic;
use crate::output::error::FileError;
use crate::output::npz::writer::{ArraySink, ArrayWriter, NpzWriter};
use std::borrow::Cow;
use std::io::{self, Cursor, Seek, Write};
use std::path::Path;
use zonal_scene::{
    Bands, CellFractions, Fields, LightGroup, Plate, Scene, Solution, ThermalCondition, VoxelGrid,
    VoxelZones, ZoneValues,
};

/// The arrays of thermal mode.
const THERMAL_ARRAYS: [&str; 4] = ["temperature", "temperature_error", "net", "net_error"];

/// Writes a solution as an npz that numpy opens: the arrays `radiosity`, `incident`, `direct`, `error`, those of zones, facets, panes,
/// textures and the medium, and `header.json` with names, options, report and provenance.
///
/// # Errors
///
/// The file cannot be written.
pub fn write_solution(path: impl AsRef<Path>, s: &Solution) -> Result<(), FileError> {
    write_divided_solution(path, s, &|own| Cow::Borrowed(own))
}

/// As [`write_solution`], of a solution that processes have divided. `collect` gives the values of all zones for those of this process; the others call
/// [`collect_solution`] at the same time.
///
/// # Errors
///
/// The file cannot be written.
pub fn write_divided_solution(
    path: impl AsRef<Path>,
    s: &Solution,
    collect: &CollectZones,
) -> Result<(), FileError> {
    write_atomic(path.as_ref(), |out| write(out, s, collect))
}

/// The values of all zones for those of this process; single precision is not divided.
fn all_values<'a>(own: &'a ZoneValues, collect: &CollectZones) -> Cow<'a, ZoneValues> {
    match own {
        ZoneValues::Double(list) => match collect(list) {
            Cow::Borrowed(_) => Cow::Borrowed(own),
            Cow::Owned(all) => Cow::Owned(ZoneValues::Double(all)),
        },
        ZoneValues::Single(_) => Cow::Borrowed(own),
    }
}

/// Collects the values of zones of a divided solution for the process that calls [`write_divided_solution`].
pub fn collect_solution(s: &Solution, collect: &CollectZones) {
    let blocks: Vec<&Solution> = s.blocks().collect();
    let fields =
        Fields::LISTS.iter().flat_map(|list| blocks.iter().map(move |t| (list.of)(&t.fields).as_slice()));
    fields.for_each(|list| drop(collect(list)));
    let blocks = &blocks;
    let groups = (0..s.groups.len()).flat_map(group_values);
    let values = groups.flat_map(|values| blocks.iter().map(move |t| values.of(t)));
    values.for_each(|own| drop(all_values(own, collect)));
}

/// Gives the values of all zones for those of this process.
pub type CollectZones<'c> = dyn for<'a> Fn(&'a [Bands]) -> Cow<'a, [Bands]> + 'c;

/// One quantity of a light group.
type ValuesOf = fn(&LightGroup) -> &ZoneValues;

/// One quantity of a light group.
#[derive(Clone, Copy)]
struct GroupValues {
    group: usize,
    name: &'static str,
    of: ValuesOf,
}

impl GroupValues {
    fn of(self, s: &Solution) -> &ZoneValues {
        (self.of)(&s.groups[self.group])
    }
}

/// The quantities of a light group, in the order of the file.
fn group_values(group: usize) -> [GroupValues; 4] {
    let list: [(&str, ValuesOf); 4] = [
        ("incident", |g| &g.incident),
        ("direct", |g| &g.direct),
        ("error", |g| &g.error),
        ("direct_error", |g| &g.direct_error),
    ];
    list.map(|(name, of)| GroupValues { group, name, of })
}

/// As [`write_solution`], into memory.
///
/// # Errors
///
/// The archive cannot be written.
pub fn solution_bytes(s: &Solution) -> io::Result<Vec<u8>> {
    let mut out = Cursor::new(Vec::new());
    write(&mut out, s, &|own| Cow::Borrowed(own))?;
    Ok(out.into_inner())
}

fn write<W: Write + Seek + Send>(out: W, s: &Solution, collect: &CollectZones) -> io::Result<()> {
    let mut npz = NpzWriter::new(out, s.scene.bands());
    let blocks: Vec<&Solution> = s.blocks().collect();
    npz.bytes("header.json", encode_header(s).to_string().as_bytes())?;
    write_fields(&mut npz, &blocks, collect)?;
    for values in (0..s.groups.len()).flat_map(group_values) {
        let list: Vec<Cow<ZoneValues>> = blocks.iter().map(|t| all_values(values.of(t), collect)).collect();
        // Errors are left out where there are none.
        if !values.name.ends_with("error") || list.iter().any(|v| !v.is_empty()) {
            let list: Vec<&ZoneValues> = list.iter().map(Cow::as_ref).collect();
            npz.values(&format!("group_{}_{}", values.group, values.name), &list)?;
        }
    }
    write_patches(&mut npz, &blocks)?;
    write_voxels(&mut npz, &blocks)?;
    write_pane_zones(&mut npz, &blocks)?;
    write_scene(&mut npz, &s.scene)?;
    npz.finish()
}

fn write_fields<W: Write + Seek + Send>(
    npz: &mut NpzWriter<W>,
    blocks: &[&Solution],
    collect: &CollectZones,
) -> io::Result<()> {
    let zones = blocks[0].zones.total();
    for field in Fields::LISTS {
        let list: Vec<Cow<[Bands]>> = blocks.iter().map(|t| collect((field.of)(&t.fields))).collect();
        let list: Vec<&[Bands]> = list.iter().map(Cow::as_ref).collect();
        npz.bands(field.name, &list, if field.is_optional { 0 } else { zones })?;
    }
    let Some(h) = &blocks[0].fields.heat else { return Ok(()) };
    for (name, list) in
        THERMAL_ARRAYS.into_iter().zip([&h.temperature, &h.temperature_error, &h.net, &h.net_error])
    {
        npz.reals(name, list.len(), |i| list[i])?;
    }
    Ok(())
}

fn write_patches<W: Write + Seek + Send>(npz: &mut NpzWriter<W>, blocks: &[&Solution]) -> io::Result<()> {
    let patches = &blocks[0].zones.patches;
    let n = patches.len();
    npz.plates("patch", n, |i| &patches[i].plate)?;
    npz.vectors("patch_normal", n, |i| patches[i].normal)?;
    npz.reals("patch_area", n, |i| patches[i].area)?;
    npz.ints("patch_facet", n, |i| patches[i].facet)?;
    npz.ints("patch_surface", n, |i| patches[i].surface)?;
    npz.band_rows("patch_reflectance", &[n], |t, i| blocks[t].zones.patches[i].reflectance)?;
    npz.band_rows("patch_emission", &[n], |t, i| blocks[t].zones.patches[i].emission)
}

/// The voxel zones of all processes; those of divided zones are the cells of the grid.
fn all_voxels(s: &Solution) -> Cow<'_, VoxelZones> {
    match s.scene.voxel_grid() {
        Some(grid) if s.zones.voxels.is_divided() => Cow::Owned(VoxelZones::whole(grid)),
        _ => Cow::Borrowed(&s.zones.voxels),
    }
}

fn write_voxels<W: Write + Seek + Send>(npz: &mut NpzWriter<W>, blocks: &[&Solution]) -> io::Result<()> {
    let all: Vec<Cow<VoxelZones>> = blocks.iter().map(|t| all_voxels(t)).collect();
    let voxels = &all[0];
    let n = voxels.len();
    npz.ints("voxel_cell", n, |i| voxels.at(i).cell)?;
    npz.vectors("voxel_centre", n, |i| voxels.at(i).centre)?;
    npz.reals_or_one("voxel_volume", n, |i| voxels.at(i).volume)?;
    npz.band_rows("voxel_extinction", &[n], |t, i| all[t].at(i).extinction)?;
    npz.band_rows("voxel_albedo", &[n], |t, i| all[t].at(i).albedo)?;
    npz.band_rows("voxel_emission", &[n], |t, i| all[t].at(i).emission)?;
    npz.band_rows("voxel_source", &[n], |t, i| all[t].at(i).source)?;
    let first = voxels.first_samples();
    npz.ints("voxel_part_first", first.len(), |i| first[i])?;
    let (mut packed, mut cells) = (Vec::new(), Vec::new());
    let cut = (0..if first.is_empty() { 0 } else { n }).map(|i| voxels.at(i).samples);
    for (mask, samples) in cut.filter(|s| !s.is_empty()).map(|s| s.packed()) {
        samples.iter().flatten().for_each(|w| packed.extend_from_slice(&w.to_le_bytes()));
        cells.extend(subcells(mask));
    }
    npz.bytes("part_packed", &packed)?;
    npz.bytes("part_subcell", &cells)
}

/// The bits of a mask, ascending.
fn subcells(mask: u64) -> impl Iterator<Item = u8> {
    (0..64u8).filter(move |k| mask >> k & 1 == 1)
}

fn write_pane_zones<W: Write + Seek + Send>(npz: &mut NpzWriter<W>, blocks: &[&Solution]) -> io::Result<()> {
    let panes = &blocks[0].zones.panes;
    let n = panes.len();
    npz.plates("pane_zone", n, |i| &panes[i].plate)?;
    npz.vectors("pane_zone_normal", n, |i| panes[i].normal)?;
    npz.ints("pane_zone_pane", n, |i| panes[i].pane)?;
    npz.reals("pane_zone_area", n, |i| panes[i].area)?;
    npz.reals("pane_zone_thickness", n, |i| panes[i].thickness)?;
    npz.band_rows("pane_zone_extinction", &[n], |t, i| blocks[t].zones.panes[i].extinction)?;
    npz.band_rows("pane_zone_albedo", &[n], |t, i| blocks[t].zones.panes[i].albedo)?;
    npz.band_rows("pane_zone_emission", &[n], |t, i| blocks[t].zones.panes[i].emission)
}

/// Writes all arrays of a scene.
pub(in crate::output) fn write_scene<S: ArraySink>(
    npz: &mut ArrayWriter<S>,
    scene: &Scene,
) -> io::Result<()> {
    let blocks: Vec<Scene> = scene.blocks().collect();
    let facets = scene.facets();
    npz.plates("facet", facets.len(), |i| &facets[i].plate)?;
    npz.ints("facet_surface", facets.len(), |i| facets[i].surface)?;
    npz.grid("facet_uv", &[facets.len(), 3, 2], |i| facets[i / 6].uv[i / 2 % 3][i % 2])?;
    write_faces(npz, scene.faces(), facets.len())?;
    write_shading(npz, scene.shading())?;
    let owned: Vec<(usize, &Plate)> =
        scene.panes().iter().enumerate().flat_map(|(i, p)| p.plates.iter().map(move |q| (i, q))).collect();
    npz.plates("pane_plate", owned.len(), |i| owned[i].1)?;
    npz.ints("pane_plate_pane", owned.len(), |i| owned[i].0)?;
    for (t, block) in blocks.iter().enumerate() {
        for (i, texture) in block.textures().iter().enumerate() {
            npz.picture(&texture_name(t, i), texture.width, texture.height, &texture.pixels)?;
        }
    }
    for (l, light) in scene.lights().iter().enumerate() {
        if let Some(picture) = light.sky().and_then(|(_, d)| d.pixels()) {
            npz.picture(&sky_name(l), picture.width, picture.height, &picture.pixels)?;
        }
    }
    let grids: Vec<&VoxelGrid> = blocks.iter().filter_map(Scene::voxel_grid).collect();
    if let Some(v) = grids.first() {
        let dims = v.dims();
        npz.band_rows("voxmap_extinction", &dims, |t, i| grids[t].extinction(i))?;
        npz.band_rows("voxmap_albedo", &dims, |t, i| grids[t].albedo(i))?;
        npz.band_rows("voxmap_emission", &dims, |t, i| grids[t].emission(i))?;
        npz.band_rows("voxmap_source", &dims, |t, i| grids[t].source(i))?;
        if v.has_interpolated_cells() {
            let all = (0..v.len()).all(|i| v.is_interpolated(i));
            let rows = if all { 1 } else { v.len() };
            npz.ints("voxmap_interpolated", rows, |i| usize::from(v.is_interpolated(i)))?;
        }
        if v.is_thermal() {
            let known = |i| match v.heat(i) {
                Some(ThermalCondition::Temperature(t)) => [1.0, t, 0.0],
                Some(ThermalCondition::Flux(q) | ThermalCondition::Power(q)) => [0.0, 0.0, q],
                None => [0.0; 3],
            };
            npz.rows("voxmap_heat", &dims, known)?;
        }
    }
    write_cell_fractions(npz, &blocks)
}

/// Name of the array of a texture; each block of bands has its own.
pub(super) fn texture_name(block: usize, texture: usize) -> String {
    if block == 0 { format!("texture_{texture}") } else { format!("texture_{texture}_block_{block}") }
}

/// Name of the array of the picture of a sky, by the number of its light.
pub(super) fn sky_name(light: usize) -> String {
    format!("sky_{light}")
}

/// Band fractions that differ from cell to cell: the kind of each cell, and the polynomials of every kind and band.
fn write_cell_fractions<S: ArraySink>(npz: &mut ArrayWriter<S>, blocks: &[Scene]) -> io::Result<()> {
    let of = |s: &Scene| s.thermal().and_then(|t| t.cell_fractions.clone());
    let all: Vec<CellFractions> = blocks.iter().filter_map(of).collect();
    let Some(first) = all.first() else { return Ok(()) };
    npz.ints("cell_fraction_kind", first.kind_of_cell.len(), |i| first.kind_of_cell[i] as usize)?;
    let polynomials = |kind: usize| -> Vec<Vec<f64>> {
        let own = all.iter().zip(blocks).flat_map(|(f, s)| {
            let coefficients = f.kinds[kind].coefficients();
            coefficients.into_iter().flatten().take(s.window().len()).cloned().collect::<Vec<_>>()
        });
        own.collect()
    };
    let kinds: Vec<Vec<Vec<f64>>> = (0..first.kinds.len()).map(polynomials).collect();
    let powers = kinds.iter().flatten().map(Vec::len).max().unwrap_or(0);
    let bands = kinds.first().map_or(0, Vec::len);
    let rows: Vec<&Vec<f64>> = kinds.iter().flatten().collect();
    let coefficient = |i: usize| rows[i / powers].get(i % powers).copied().unwrap_or(0.0);
    npz.grid("cell_fraction_polynomials", &[kinds.len(), bands, powers], coefficient)
}
