//! Writing of a solution.

use super::faces::write_faces;
use super::header::encode_header;
use crate::output::atomic::write_atomic;
use crate::output::error::FileError;
use crate::output::npz::writer::NpzWriter;
use crate::output::report::report_json;
use std::io::{self, Cursor, Seek, Write};
use std::path::Path;
use zonal_scene::{
    Bands, CellFractions, Fields, LightGroup, Plate, Solution, ThermalCondition, VoxelGrid, ZoneValues,
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
    let path = path.as_ref();
    write_atomic(path, |out| write(out, s))
}

/// As [`write_solution`], into memory.
///
/// # Errors
///
/// The archive cannot be written.
pub fn solution_bytes(s: &Solution) -> io::Result<Vec<u8>> {
    let mut out = Cursor::new(Vec::new());
    write(&mut out, s)?;
    Ok(out.into_inner())
}

fn write<W: Write + Seek>(out: W, s: &Solution) -> io::Result<()> {
    let mut npz = NpzWriter::new(out, s.scene.bands());
    let triples: Vec<&Solution> = s.triples().collect();
    npz.bytes("header.json", encode_header(&s.scene, report_json(s)).to_string().as_bytes())?;
    write_fields(&mut npz, &triples)?;
    for k in 0..s.groups.len() {
        let mut values = |name: &str, of: fn(&LightGroup) -> &ZoneValues| {
            let list: Vec<&ZoneValues> = triples.iter().map(|t| of(&t.groups[k])).collect();
            npz.values(&format!("group_{k}_{name}"), &list)
        };
        values("incident", |g| &g.incident)?;
        values("direct", |g| &g.direct)?;
        if triples.iter().any(|t| !t.groups[k].error.is_empty()) {
            values("error", |g| &g.error)?;
        }
        if triples.iter().any(|t| !t.groups[k].direct_error.is_empty()) {
            values("direct_error", |g| &g.direct_error)?;
        }
    }
    write_patches(&mut npz, &triples)?;
    write_voxels(&mut npz, &triples)?;
    write_pane_zones(&mut npz, &triples)?;
    write_scene(&mut npz, &triples)?;
    npz.finish()
}

fn write_fields<W: Write + Seek>(npz: &mut NpzWriter<W>, triples: &[&Solution]) -> io::Result<()> {
    let zones = triples[0].zones.len();
    let mut bands = |name: &str, of: fn(&Fields) -> &Vec<Bands>, least: usize| {
        let list: Vec<&[Bands]> = triples.iter().map(|t| of(&t.fields).as_slice()).collect();
        npz.bands(name, &list, least)
    };
    bands("radiosity", |f| &f.radiosity, zones)?;
    bands("incident", |f| &f.incident, zones)?;
    bands("direct", |f| &f.direct, zones)?;
    bands("error", |f| &f.error, zones)?;
    bands("direct_error", |f| &f.direct_error, 0)?;
    bands("surroundings_error", |f| &f.surroundings_error, 0)?;
    let Some(h) = &triples[0].fields.heat else { return Ok(()) };
    for (name, list) in
        THERMAL_ARRAYS.into_iter().zip([&h.temperature, &h.temperature_error, &h.net, &h.net_error])
    {
        npz.reals(name, list.iter().copied())?;
    }
    Ok(())
}

fn write_patches<W: Write + Seek>(npz: &mut NpzWriter<W>, triples: &[&Solution]) -> io::Result<()> {
    let patches = &triples[0].zones.patches;
    let n = [patches.len()];
    npz.plates("patch", patches.iter().map(|p| &p.plate))?;
    npz.vectors("patch_normal", patches.iter().map(|p| p.normal))?;
    npz.reals("patch_area", patches.iter().map(|p| p.area))?;
    npz.ints("patch_facet", patches.iter().map(|p| p.facet))?;
    npz.ints("patch_surface", patches.iter().map(|p| p.surface))?;
    npz.band_rows("patch_reflectance", &n, |t, i| triples[t].zones.patches[i].reflectance)?;
    npz.band_rows("patch_emission", &n, |t, i| triples[t].zones.patches[i].emission)
}

fn write_voxels<W: Write + Seek>(npz: &mut NpzWriter<W>, triples: &[&Solution]) -> io::Result<()> {
    let voxels = &triples[0].zones.voxels;
    let n = [voxels.len()];
    npz.ints("voxel_cell", voxels.iter().map(|v| v.cell))?;
    npz.vectors("voxel_centre", voxels.iter().map(|v| v.centre))?;
    npz.reals("voxel_volume", voxels.iter().map(|v| v.volume))?;
    npz.band_rows("voxel_extinction", &n, |t, i| triples[t].zones.voxels.at(i).extinction)?;
    npz.band_rows("voxel_albedo", &n, |t, i| triples[t].zones.voxels.at(i).albedo)?;
    npz.band_rows("voxel_emission", &n, |t, i| triples[t].zones.voxels.at(i).emission)?;
    npz.band_rows("voxel_source", &n, |t, i| triples[t].zones.voxels.at(i).source)?;
    let mut parts = 0;
    let first = (0..voxels.len() + 1).map(|i| {
        let first = parts;
        parts += if i < voxels.len() { voxels.at(i).samples.len() } else { 0 };
        first
    });
    npz.ints("voxel_part_first", first)?;
    let (mut packed, mut cells) = (Vec::new(), Vec::new());
    for (mask, samples) in voxels.iter().filter(|v| !v.samples.is_empty()).map(|v| v.samples.packed()) {
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

fn write_pane_zones<W: Write + Seek>(npz: &mut NpzWriter<W>, triples: &[&Solution]) -> io::Result<()> {
    let panes = &triples[0].zones.panes;
    let n = [panes.len()];
    npz.plates("pane_zone", panes.iter().map(|p| &p.plate))?;
    npz.vectors("pane_zone_normal", panes.iter().map(|p| p.normal))?;
    npz.ints("pane_zone_pane", panes.iter().map(|p| p.pane))?;
    npz.reals("pane_zone_area", panes.iter().map(|p| p.area))?;
    npz.reals("pane_zone_thickness", panes.iter().map(|p| p.thickness))?;
    npz.band_rows("pane_zone_extinction", &n, |t, i| triples[t].zones.panes[i].extinction)?;
    npz.band_rows("pane_zone_albedo", &n, |t, i| triples[t].zones.panes[i].albedo)?;
    npz.band_rows("pane_zone_emission", &n, |t, i| triples[t].zones.panes[i].emission)
}

fn write_scene<W: Write + Seek>(npz: &mut NpzWriter<W>, triples: &[&Solution]) -> io::Result<()> {
    let scene = &triples[0].scene;
    let facets = scene.facets();
    npz.plates("facet", facets.iter().map(|f| &f.plate))?;
    npz.ints("facet_surface", facets.iter().map(|f| f.surface))?;
    npz.grid("facet_uv", &[facets.len(), 3, 2], facets.iter().flat_map(|f| f.uv).flatten())?;
    write_faces(npz, scene.faces(), facets.len())?;
    let owned: Vec<(usize, &Plate)> =
        scene.panes().iter().enumerate().flat_map(|(i, p)| p.plates.iter().map(move |q| (i, q))).collect();
    npz.plates("pane_plate", owned.iter().map(|o| o.1))?;
    npz.ints("pane_plate_pane", owned.iter().map(|o| o.0))?;
    for (t, triple) in triples.iter().enumerate() {
        for (i, texture) in triple.scene.textures().iter().enumerate() {
            npz.picture(&texture_name(t, i), texture.width, texture.height, &texture.pixels)?;
        }
    }
    let grids: Vec<&VoxelGrid> = triples.iter().filter_map(|t| t.scene.voxel_grid()).collect();
    if let Some(v) = grids.first() {
        let dims = v.dims();
        npz.band_rows("voxmap_extinction", &dims, |t, i| grids[t].extinction(i))?;
        npz.band_rows("voxmap_albedo", &dims, |t, i| grids[t].albedo(i))?;
        npz.band_rows("voxmap_emission", &dims, |t, i| grids[t].emission(i))?;
        npz.band_rows("voxmap_source", &dims, |t, i| grids[t].source(i))?;
        if v.is_thermal() {
            let known = |i| match v.heat(i) {
                Some(ThermalCondition::Temperature(t)) => [1.0, t, 0.0],
                Some(ThermalCondition::Flux(q) | ThermalCondition::Power(q)) => [0.0, 0.0, q],
                None => [0.0; 3],
            };
            npz.rows("voxmap_heat", &dims, (0..v.len()).map(known))?;
        }
    }
    write_cell_fractions(npz, triples)
}

/// Name of the array of a texture; each triple of bands has its own.
pub(super) fn texture_name(triple: usize, texture: usize) -> String {
    if triple == 0 { format!("texture_{texture}") } else { format!("texture_{texture}_triple_{triple}") }
}

/// Band fractions that differ from cell to cell: the kind of each cell, and the polynomials of every kind and band.
fn write_cell_fractions<W: Write + Seek>(npz: &mut NpzWriter<W>, triples: &[&Solution]) -> io::Result<()> {
    let of = |s: &&Solution| s.scene.thermal().and_then(|t| t.cell_fractions.clone());
    let all: Vec<CellFractions> = triples.iter().filter_map(of).collect();
    let Some(first) = all.first() else { return Ok(()) };
    npz.ints("cell_fraction_kind", first.kind_of_cell.iter().map(|k| *k as usize))?;
    let polynomials = |kind: usize| -> Vec<Vec<f64>> {
        let own = all.iter().zip(triples).flat_map(|(f, s)| {
            let coefficients = f.kinds[kind].coefficients();
            coefficients.into_iter().flatten().take(s.scene.window().len()).cloned().collect::<Vec<_>>()
        });
        own.collect()
    };
    let kinds: Vec<Vec<Vec<f64>>> = (0..first.kinds.len()).map(polynomials).collect();
    let powers = kinds.iter().flatten().map(Vec::len).max().unwrap_or(0);
    let bands = kinds.first().map_or(0, Vec::len);
    let padded = kinds.iter().flatten().flat_map(|p| (0..powers).map(|k| p.get(k).copied().unwrap_or(0.0)));
    npz.grid("cell_fraction_polynomials", &[kinds.len(), bands, powers], padded)
}
