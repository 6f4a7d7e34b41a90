//! Writing of a solution.

use super::faces::write_faces;
use super::header::encode_header;
use crate::output::atomic::write_atomic;
use crate::output::error::FileError;
use crate::output::npz::writer::NpzWriter;
use crate::output::report::report_json;
use std::io::{self, Cursor, Seek, Write};
use std::path::Path;
use zonal_scene::{Fields, PaneZone, Patch, Plate, Scene, Solution, ThermalCondition, VoxelZone};

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
    let mut npz = NpzWriter::new(out);
    npz.bytes("header.json", encode_header(&s.scene, report_json(s)).to_string().as_bytes())?;
    write_fields(&mut npz, &s.fields)?;
    for (k, g) in s.groups.iter().enumerate() {
        npz.values(&format!("group_{k}_incident"), &g.incident)?;
        npz.values(&format!("group_{k}_direct"), &g.direct)?;
        if !g.error.is_empty() {
            npz.values(&format!("group_{k}_error"), &g.error)?;
        }
        if !g.direct_error.is_empty() {
            npz.values(&format!("group_{k}_direct_error"), &g.direct_error)?;
        }
    }
    write_patches(&mut npz, &s.zones.patches)?;
    write_voxels(&mut npz, &s.zones.voxels)?;
    write_pane_zones(&mut npz, &s.zones.panes)?;
    write_scene(&mut npz, &s.scene)?;
    npz.finish()
}

fn write_fields<W: Write + Seek>(npz: &mut NpzWriter<W>, f: &Fields) -> io::Result<()> {
    for (name, field) in
        [("radiosity", &f.radiosity), ("incident", &f.incident), ("direct", &f.direct), ("error", &f.error)]
    {
        npz.bands(name, field)?;
    }
    for (name, part) in [("direct_error", &f.direct_error), ("surroundings_error", &f.surroundings_error)] {
        npz.bands(name, part)?;
    }
    let Some(h) = &f.heat else { return Ok(()) };
    for (name, list) in
        THERMAL_ARRAYS.into_iter().zip([&h.temperature, &h.temperature_error, &h.net, &h.net_error])
    {
        npz.reals(name, list.iter().copied())?;
    }
    Ok(())
}

fn write_patches<W: Write + Seek>(npz: &mut NpzWriter<W>, patches: &[Patch]) -> io::Result<()> {
    let n = [patches.len()];
    npz.plates("patch", patches.iter().map(|p| &p.plate))?;
    npz.vectors("patch_normal", patches.iter().map(|p| p.normal))?;
    npz.reals("patch_area", patches.iter().map(|p| p.area))?;
    npz.ints("patch_facet", patches.iter().map(|p| p.facet))?;
    npz.ints("patch_surface", patches.iter().map(|p| p.surface))?;
    npz.band_rows("patch_reflectance", &n, patches.iter().map(|p| p.reflectance))?;
    npz.band_rows("patch_emission", &n, patches.iter().map(|p| p.emission))
}

fn write_voxels<W: Write + Seek>(npz: &mut NpzWriter<W>, voxels: &[VoxelZone]) -> io::Result<()> {
    let n = [voxels.len()];
    npz.ints("voxel_cell", voxels.iter().map(|v| v.cell))?;
    npz.vectors("voxel_centre", voxels.iter().map(|v| v.centre))?;
    npz.reals("voxel_volume", voxels.iter().map(|v| v.volume))?;
    npz.band_rows("voxel_extinction", &n, voxels.iter().map(|v| v.extinction))?;
    npz.band_rows("voxel_albedo", &n, voxels.iter().map(|v| v.albedo))?;
    npz.band_rows("voxel_emission", &n, voxels.iter().map(|v| v.emission))?;
    npz.band_rows("voxel_source", &n, voxels.iter().map(|v| v.source))?;
    let mut first = vec![0];
    first.extend(voxels.iter().scan(0, |sum, v| {
        *sum += v.samples.len();
        Some(*sum)
    }));
    npz.ints("voxel_part_first", first.into_iter())?;
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

fn write_pane_zones<W: Write + Seek>(npz: &mut NpzWriter<W>, panes: &[PaneZone]) -> io::Result<()> {
    let n = [panes.len()];
    npz.plates("pane_zone", panes.iter().map(|p| &p.plate))?;
    npz.vectors("pane_zone_normal", panes.iter().map(|p| p.normal))?;
    npz.ints("pane_zone_pane", panes.iter().map(|p| p.pane))?;
    npz.reals("pane_zone_area", panes.iter().map(|p| p.area))?;
    npz.reals("pane_zone_thickness", panes.iter().map(|p| p.thickness))?;
    npz.band_rows("pane_zone_extinction", &n, panes.iter().map(|p| p.extinction))?;
    npz.band_rows("pane_zone_albedo", &n, panes.iter().map(|p| p.albedo))?;
    npz.band_rows("pane_zone_emission", &n, panes.iter().map(|p| p.emission))
}

fn write_scene<W: Write + Seek>(npz: &mut NpzWriter<W>, scene: &Scene) -> io::Result<()> {
    let facets = scene.facets();
    npz.plates("facet", facets.iter().map(|f| &f.plate))?;
    npz.ints("facet_surface", facets.iter().map(|f| f.surface))?;
    npz.grid("facet_uv", &[facets.len(), 3, 2], facets.iter().flat_map(|f| f.uv).flatten())?;
    write_faces(npz, scene.faces(), facets.len())?;
    let owned: Vec<(usize, &Plate)> =
        scene.panes().iter().enumerate().flat_map(|(i, p)| p.plates.iter().map(move |q| (i, q))).collect();
    npz.plates("pane_plate", owned.iter().map(|o| o.1))?;
    npz.ints("pane_plate_pane", owned.iter().map(|o| o.0))?;
    for (i, t) in scene.textures().iter().enumerate() {
        npz.picture(&format!("texture_{i}"), t.width, t.height, &t.pixels)?;
    }
    if let Some(v) = scene.voxel_grid() {
        let (dims, cells) = (v.dims(), 0..v.len());
        npz.band_rows("voxmap_extinction", &dims, cells.clone().map(|i| v.extinction(i)))?;
        npz.band_rows("voxmap_albedo", &dims, cells.clone().map(|i| v.albedo(i)))?;
        npz.band_rows("voxmap_emission", &dims, cells.clone().map(|i| v.emission(i)))?;
        npz.band_rows("voxmap_source", &dims, cells.clone().map(|i| v.source(i)))?;
        if v.is_thermal() {
            let known = |i| match v.heat(i) {
                Some(ThermalCondition::Temperature(t)) => [1.0, t, 0.0],
                Some(ThermalCondition::Flux(q) | ThermalCondition::Power(q)) => [0.0, 0.0, q],
                None => [0.0; 3],
            };
            npz.rows("voxmap_heat", &dims, cells.map(known))?;
        }
    }
    Ok(())
}
