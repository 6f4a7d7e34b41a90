//! A solution as one `.npz`: a zip of numpy arrays, and a JSON header.
//!
//! ```python
//! import json, numpy as np
//! z = np.load("room.npz")
//! header = json.loads(bytes(z["header.json"]))        # names, lights, cameras, options, report, provenance
//! B = z["radiosity"]                                   # [zones, 3], W/m²; patches, then voxels, then panes
//! ```
//!
//! | arrays | shape | what |
//! |---|---|---|
//! | `radiosity`, `incident`, `direct`, `error` | [zones, 3] | B; H or G without direct light; H_dir or G_dir; error of `incident` |
//! | `direct_error` | [zones, 3] or [0, 3] | error of `direct` |
//! | `surroundings_error` | [zones, 3] or [0, 3] | the part of `error` that comes in from the surroundings |
//! | `temperature`, `temperature_error`, `net`, `net_error` | \[zones\] | in thermal mode: K, and the net power that a zone gives, W/m² of patches, W/m³ of the others; a temperature that is not defined is NaN |
//! | `group_0_incident`, `group_0_direct`, … | [zones, 3], `<f8` or `<f4`; [0, 3] for none | the share of each light group, times `incident_scale` and `direct_scale` in `report.groups` of the header |
//! | `group_0_error`, … | [zones, 3] | its part of `error`, times `incident_scale`, where errors are known of each group |
//! | `group_0_direct_error`, … | [zones, 3] | its part of `direct_error`, times `direct_scale`, where it has direct light |
//! | `patch_origin`, `_e1`, `_e2`, `_kind`, `_normal`, `_area`, `_facet`, `_surface`, `_reflectance`, `_emission` | [patches, …] | surface zones; kind 0 triangle, 1 parallelogram |
//! | `voxel_cell`, `_centre`, `_volume`, `_extinction`, `_albedo`, `_emission`, `_source` | [voxels, …] | volume zones |
//! | `voxel_part_first`, `part_subcell`, `part_packed` | CSR | samples of cut voxels: zone i has the rows `first[i]` to `first[i+1]`; `part_packed.view("<u2").reshape(-1, 4)` is the place in the sub-cell and the share of the volume, in 2⁻¹⁶ |
//! | `pane_zone_*` | [pane zones, …] | pane zones |
//! | `facet_origin`, `_e1`, `_e2`, `_kind`, `_surface`, `_uv` | [facets, …] | the scene's surfaces |
//! | `pane_plate_*`, `pane_plate_pane` | [plates, …] | the scene's panes |
//! | `texture_0` … | [height, width, 3] f32 | linear textures |
//! | `voxmap_extinction`, `_albedo`, `_emission`, `_source` | [nx, ny, nz, 3] | the medium |
//! | `voxmap_heat` | [nx, ny, nz, 3] | in thermal mode: 1, T, 0 where the temperature is known (K), else 0, 0, Q (W/m³) |
//!
//! A quantity of patches, voxels, pane zones or cells whose rows are all the same is one row, of shape [1, 3] or [1, 1, 1, 3]; numpy
//! repeats it in arithmetic. Nothing is compressed. Version 5; files of other versions are refused by name.
//!
//! Reals are `<f8`, indices `<i8`, kinds and sub-cells `|u1`.

use super::header::{self, FORMAT_VERSION};
use super::heat;
use super::report;
use super::{FileError, atomic::write_atomic, reader, reader::Rows, writer};
use serde_json::Value;
use std::io::{self, Cursor, Seek, Write};
use std::path::Path;
use zonal_math::Vec3;
use zonal_scene::{
    Facet, Fields, Group, Heat, Kind, Known, Pane, PaneZone, Part, Patch, Plate, Scene, SceneError,
    SceneParts, Solution, Texture, VoxelZone, Voxmap, Zones, zones::SUBCELLS,
};

/// Writes a solution; see the module's header for the layout.
pub fn write_solution(path: &Path, s: &Solution) -> Result<(), FileError> {
    write_atomic(path, |out| write(out, s))
}

/// As [`write_solution`], into memory.
pub fn solution_bytes(s: &Solution) -> io::Result<Vec<u8>> {
    let mut out = Cursor::new(Vec::new());
    write(&mut out, s)?;
    Ok(out.into_inner())
}

fn write<W: Write + Seek>(out: W, s: &Solution) -> io::Result<()> {
    let mut npz = writer::Npz::new(out);
    npz.bytes("header.json", header::encode(s).to_string().as_bytes())?;
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

fn write_fields<W: Write + Seek>(npz: &mut writer::Npz<W>, f: &Fields) -> io::Result<()> {
    for (name, field) in
        [("radiosity", &f.radiosity), ("incident", &f.incident), ("direct", &f.direct), ("error", &f.error)]
    {
        npz.triples(name, &[field.len()], field.iter().copied())?;
    }
    for (name, part) in [("direct_error", &f.direct_error), ("surroundings_error", &f.surroundings_error)] {
        npz.triples(name, &[part.len()], part.iter().copied())?;
    }
    let Some(h) = &f.heat else { return Ok(()) };
    for (name, list) in HEAT.into_iter().zip([&h.temperature, &h.temperature_error, &h.net, &h.net_error]) {
        npz.reals(name, list.iter().copied())?;
    }
    Ok(())
}

/// The arrays of thermal mode.
const HEAT: [&str; 4] = ["temperature", "temperature_error", "net", "net_error"];

fn write_patches<W: Write + Seek>(npz: &mut writer::Npz<W>, patches: &[Patch]) -> io::Result<()> {
    let n = [patches.len()];
    npz.plates("patch", patches.iter().map(|p| &p.plate))?;
    npz.vectors("patch_normal", patches.iter().map(|p| p.normal))?;
    npz.reals("patch_area", patches.iter().map(|p| p.area))?;
    npz.ints("patch_facet", patches.iter().map(|p| p.facet))?;
    npz.ints("patch_surface", patches.iter().map(|p| p.surface))?;
    npz.rows("patch_reflectance", &n, patches.iter().map(|p| p.reflectance))?;
    npz.rows("patch_emission", &n, patches.iter().map(|p| p.emission))
}

fn write_voxels<W: Write + Seek>(npz: &mut writer::Npz<W>, voxels: &[VoxelZone]) -> io::Result<()> {
    let n = [voxels.len()];
    npz.ints("voxel_cell", voxels.iter().map(|v| v.cell))?;
    npz.vectors("voxel_centre", voxels.iter().map(|v| v.centre))?;
    npz.reals("voxel_volume", voxels.iter().map(|v| v.volume))?;
    npz.rows("voxel_extinction", &n, voxels.iter().map(|v| v.extinction))?;
    npz.rows("voxel_albedo", &n, voxels.iter().map(|v| v.albedo))?;
    npz.rows("voxel_emission", &n, voxels.iter().map(|v| v.emission))?;
    npz.rows("voxel_source", &n, voxels.iter().map(|v| v.source))?;
    let mut first = vec![0];
    first.extend(voxels.iter().scan(0, |sum, v| {
        *sum += v.part.len();
        Some(*sum)
    }));
    npz.ints("voxel_part_first", first.into_iter())?;
    let (mut packed, mut cells) = (Vec::new(), Vec::new());
    for (mask, samples) in voxels.iter().filter(|v| !v.part.is_empty()).map(|v| v.part.packed()) {
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

fn write_pane_zones<W: Write + Seek>(npz: &mut writer::Npz<W>, panes: &[PaneZone]) -> io::Result<()> {
    let n = [panes.len()];
    npz.plates("pane_zone", panes.iter().map(|p| &p.plate))?;
    npz.vectors("pane_zone_normal", panes.iter().map(|p| p.normal))?;
    npz.ints("pane_zone_pane", panes.iter().map(|p| p.pane))?;
    npz.reals("pane_zone_area", panes.iter().map(|p| p.area))?;
    npz.reals("pane_zone_thickness", panes.iter().map(|p| p.thickness))?;
    npz.rows("pane_zone_extinction", &n, panes.iter().map(|p| p.extinction))?;
    npz.rows("pane_zone_albedo", &n, panes.iter().map(|p| p.albedo))?;
    npz.rows("pane_zone_emission", &n, panes.iter().map(|p| p.emission))
}

fn write_scene<W: Write + Seek>(npz: &mut writer::Npz<W>, scene: &Scene) -> io::Result<()> {
    let facets = scene.facets();
    npz.plates("facet", facets.iter().map(|f| &f.plate))?;
    npz.ints("facet_surface", facets.iter().map(|f| f.surface))?;
    npz.grid("facet_uv", &[facets.len(), 3, 2], facets.iter().flat_map(|f| f.uv).flatten())?;
    let owned: Vec<(usize, &Plate)> =
        scene.panes().iter().enumerate().flat_map(|(i, p)| p.plates.iter().map(move |q| (i, q))).collect();
    npz.plates("pane_plate", owned.iter().map(|o| o.1))?;
    npz.ints("pane_plate_pane", owned.iter().map(|o| o.0))?;
    for (i, t) in scene.textures().iter().enumerate() {
        npz.picture(&format!("texture_{i}"), t.width, t.height, &t.pixels)?;
    }
    if let Some(v) = scene.voxmap() {
        let (dims, cells) = (v.dims(), 0..v.len());
        npz.rows("voxmap_extinction", &dims, cells.clone().map(|i| v.extinction(i)))?;
        npz.rows("voxmap_albedo", &dims, cells.clone().map(|i| v.albedo(i)))?;
        npz.rows("voxmap_emission", &dims, cells.clone().map(|i| v.emission(i)))?;
        npz.rows("voxmap_source", &dims, cells.clone().map(|i| v.source(i)))?;
        if v.is_thermal() {
            let known = |i| match v.heat(i) {
                Some(Known::Temperature(t)) => [1.0, t, 0.0],
                Some(Known::Flux(q) | Known::Power(q)) => [0.0, 0.0, q],
                None => [0.0; 3],
            };
            npz.rows("voxmap_heat", &dims, cells.map(known))?;
        }
    }
    Ok(())
}

/// Reads a solution and validates all of it: shapes, ranges, finite numbers. Damaged or hostile files give one clear error.
pub fn read_solution(path: &Path) -> Result<Solution, FileError> {
    read(reader::Npz::open(path)?)
}

/// As [`read_solution`], of a file's bytes.
pub fn read_solution_from_bytes(bytes: &[u8]) -> Result<Solution, FileError> {
    read(reader::Npz::new(Path::new("memory"), Box::new(Cursor::new(bytes)), bytes.len() as u64)?)
}

fn read(mut npz: reader::Npz<'_>) -> Result<Solution, FileError> {
    let header = read_header(&mut npz)?;
    let scene = read_scene(&mut npz, &header)?;
    let zones = Zones {
        patches: read_patches(&mut npz, &scene)?,
        voxels: read_voxels(&mut npz, &scene)?,
        panes: read_pane_zones(&mut npz, &scene)?,
        first: Vec::new(),
    };
    let zones = with_index(zones, &scene);
    let n = [zones.len()];
    let fields = Fields {
        radiosity: npz.triples("radiosity", &n)?,
        incident: npz.triples("incident", &n)?,
        direct: npz.triples("direct", &n)?,
        error: npz.errors("error", zones.len(), false)?,
        direct_error: npz.errors("direct_error", zones.len(), true)?,
        surroundings_error: npz.errors("surroundings_error", zones.len(), true)?,
        heat: if scene.thermal().is_some() { Some(read_heat(&mut npz, zones.len())?) } else { None },
    };
    let groups = read_groups(&mut npz, &header, &scene, zones.len())?;
    let json = |e: String| npz.error("header.json", e);
    Ok(Solution {
        report: report::decode(&header["report"]).map_err(json)?,
        scene_hash: report::text(&header["provenance"], "scene_hash").map_err(json)?,
        version: report::text(&header["provenance"], "version").map_err(json)?,
        scene,
        zones,
        fields,
        groups,
    })
}

fn read_heat(npz: &mut reader::Npz<'_>, zones: usize) -> Result<Heat, FileError> {
    let temperature = npz.reals_or_nan(HEAT[0], zones, f64::is_finite)?;
    let temperature_error = npz.reals_or_nan(HEAT[1], zones, |e| e >= 0.0)?;
    let (net, net_error) = (npz.reals(HEAT[2], zones)?, npz.error_list(HEAT[3], zones)?);
    Ok(Heat { temperature, temperature_error, net, net_error })
}

fn read_groups(
    npz: &mut reader::Npz<'_>,
    h: &Value,
    scene: &Scene,
    zones: usize,
) -> Result<Vec<Group>, FileError> {
    let groups = header::each(&h["report"], "groups", report::group_in);
    let mut groups = groups.map_err(|e| npz.error("header.json", e))?;
    for (k, g) in groups.iter_mut().enumerate() {
        let known = match g.kind {
            Kind::Light(l) => l < scene.lights().len(),
            Kind::Surface(s) => s < scene.surfaces().len(),
            _ => true,
        };
        if !known {
            return Err(
                npz.error("header.json", format!("light group '{}' is of nothing in the scene", g.name))
            );
        }
        g.incident = npz.values(&format!("group_{k}_incident"), zones)?;
        g.direct = npz.values(&format!("group_{k}_direct"), zones)?;
        let error = format!("group_{k}_error");
        if npz.has(&error) {
            g.error = npz.error_values(&error, zones)?;
        }
        let direct = format!("group_{k}_direct_error");
        if npz.has(&direct) {
            g.direct_error = npz.error_values(&direct, zones)?;
        }
    }
    Ok(groups)
}

fn read_header(npz: &mut reader::Npz<'_>) -> Result<Value, FileError> {
    let header = npz.json("header.json")?;
    if header["format"] != "zonal solution" {
        return Err(npz.error("header.json", "this is not a zonal solution; give a file that zonal wrote"));
    }
    if header["format_version"] != FORMAT_VERSION {
        let found = &header["format_version"];
        let what = format!(
            "format version {found} is not {FORMAT_VERSION}; solve the scene again with this version"
        );
        return Err(npz.error("header.json", what));
    }
    Ok(header)
}

fn read_scene(npz: &mut reader::Npz<'_>, h: &Value) -> Result<Scene, FileError> {
    let path = npz.error("", "").path().to_owned();
    let json = |e: String| FileError::new(&path, "header.json", e);
    let invalid = |e: SceneError| FileError::new(&path, e.key(), e.what());
    let surfaces = header::each(h, "surfaces", header::surface_in).map_err(json)?;
    let panes = header::each(h, "panes", header::pane_in).map_err(json)?;
    let notes = header::each(h, "notes", super::notes::note_in).map_err(json)?;
    let textures = header::int(h, "textures").map_err(json)?;
    let parts = SceneParts {
        name: report::text(h, "name").map_err(json)?,
        facets: read_facets(npz, surfaces.len())?,
        surfaces,
        textures: (0..textures).map(|i| read_texture(npz, i)).collect::<Result<_, _>>()?,
        panes: read_panes(npz, panes)?,
        voxmap: if h["voxmap"].is_null() { None } else { Some(read_voxmap(npz, &h["voxmap"])?) },
        lights: header::each(h, "lights", header::light_in).map_err(json)?,
        surroundings: header::surroundings_in(&h["surroundings"]).map_err(json)?,
        periodic: header::periodic_in(h).map_err(json)?,
        thermal: heat::thermal_in(h).map_err(json)?,
        cameras: header::each(h, "cameras", header::camera_in).map_err(json)?,
        options: header::options_in(&h["options"]).map_err(json)?,
        notes,
    };
    Scene::new(parts).map_err(invalid)
}

fn read_facets(npz: &mut reader::Npz<'_>, surfaces: usize) -> Result<Vec<Facet>, FileError> {
    let plates = npz.plates("facet")?;
    let surface = npz.ints("facet_surface", Some(plates.len()), surfaces)?;
    let (shape, uv) = npz.grid("facet_uv")?;
    if shape != [plates.len(), 3, 2] {
        return Err(npz.error("facet_uv", format!("has shape {shape:?}; solve the scene again")));
    }
    let facet = |(i, plate): (usize, Plate)| Facet {
        surface: surface[i],
        plate,
        uv: std::array::from_fn(|k| [uv[6 * i + 2 * k], uv[6 * i + 2 * k + 1]]),
    };
    Ok(plates.into_iter().enumerate().map(facet).collect())
}

fn read_texture(npz: &mut reader::Npz<'_>, i: usize) -> Result<Texture, FileError> {
    let (width, height, pixels) = npz.picture(&format!("texture_{i}"))?;
    Ok(Texture { width, height, pixels })
}

fn read_panes(npz: &mut reader::Npz<'_>, mut panes: Vec<Pane>) -> Result<Vec<Pane>, FileError> {
    let plates = npz.plates("pane_plate")?;
    let owner = npz.ints("pane_plate_pane", Some(plates.len()), panes.len())?;
    for (plate, i) in plates.into_iter().zip(owner) {
        panes[i].plates.push(plate);
    }
    Ok(panes)
}

fn read_voxmap(npz: &mut reader::Npz<'_>, h: &Value) -> Result<Voxmap, FileError> {
    let path = npz.error("", "").path().to_owned();
    let json = |e: String| FileError::new(&path, "header.json", format!("voxmap.{e}"));
    let invalid = |e: SceneError| FileError::new(&path, e.key(), e.what());
    let min = header::vector(h, "min").map_err(json)?;
    let cell = header::vector(h, "cell").map_err(json)?;
    let dims = report::bands(h, "dims").map_err(json)?.map(|d| d as usize);
    // The arrays come first: what they hold is what gets allocated.
    let extinction = npz.same_or_each("voxmap_extinction", &dims)?;
    let albedo = npz.same_or_each("voxmap_albedo", &dims)?;
    let emission = npz.same_or_each("voxmap_emission", &dims)?;
    let source = npz.same_or_each("voxmap_source", &dims)?;
    let mut voxmap = Voxmap::new(min, cell, dims).map_err(invalid)?;
    // The index of the zones takes four bytes a cell.
    npz.charge("voxmap_extinction", 4 * voxmap.len() as u64)?;
    if let (Rows::Same(k), Rows::Same(o), Rows::Same(e), Rows::Same(q)) =
        (&extinction, &albedo, &emission, &source)
    {
        voxmap.fill(*k, *o, *e, *q);
    } else {
        for i in 0..voxmap.len() {
            voxmap.set(i, extinction[i], albedo[i], emission[i], source[i]);
        }
    }
    if npz.has("voxmap_heat") {
        let known =
            |x: zonal_scene::Bands| if x[0] > 0.0 { Known::Temperature(x[1]) } else { Known::Flux(x[2]) };
        match npz.same_or_each("voxmap_heat", &dims)? {
            Rows::Same(x) => voxmap.fill_heat(known(x)),
            Rows::Each(list) => {
                list.into_iter()
                    .enumerate()
                    .for_each(|(i, x)| voxmap.set_heat(i, known(x), Known::Flux(0.0)));
            }
        }
    }
    voxmap.seal().map_err(invalid)
}

fn read_patches(npz: &mut reader::Npz<'_>, scene: &Scene) -> Result<Vec<Patch>, FileError> {
    let plates = npz.plates("patch")?;
    let n = plates.len();
    let normal = npz.units("patch_normal", n)?;
    let area = npz.positive("patch_area", n)?;
    let facet = npz.ints("patch_facet", Some(n), scene.facets().len())?;
    let surface = npz.ints("patch_surface", Some(n), scene.surfaces().len())?;
    let reflectance = npz.bands("patch_reflectance", n, 1.0)?;
    let emission = npz.bands("patch_emission", n, f64::MAX)?;
    let patch = |(i, plate): (usize, Plate)| Patch {
        facet: facet[i],
        surface: surface[i],
        plate,
        normal: normal[i],
        area: area[i],
        reflectance: reflectance[i],
        emission: emission[i],
    };
    Ok(plates.into_iter().enumerate().map(patch).collect())
}

fn read_voxels(npz: &mut reader::Npz<'_>, scene: &Scene) -> Result<Vec<VoxelZone>, FileError> {
    let cell = npz.ints("voxel_cell", None, scene.voxmap().map_or(0, |v| v.len()))?;
    let n = cell.len();
    if !cell.is_sorted() {
        return Err(npz.error("voxel_cell", "the cells are not in ascending order; solve the scene again"));
    }
    let centre = npz.vectors("voxel_centre", n)?;
    let volume = npz.positive("voxel_volume", n)?;
    let extinction = npz.bands("voxel_extinction", n, f64::MAX)?;
    let albedo = npz.bands("voxel_albedo", n, 1.0)?;
    let emission = npz.bands("voxel_emission", n, f64::MAX)?;
    let source = npz.bands("voxel_source", n, f64::MAX)?;
    let subcell = npz.bytes("part_subcell", None)?;
    let packed = npz.bytes("part_packed", Some(8 * subcell.len()))?;
    let first = npz.ints("voxel_part_first", Some(n + 1), subcell.len() + 1)?;
    if !first.is_sorted() || first[0] != 0 || first[n] != subcell.len() {
        return Err(npz.error("voxel_part_first", "does not cover the samples; solve the scene again"));
    }
    let part = |i: usize| {
        let rows = first[i]..first[i + 1];
        let (mut mask, map) = (0u64, scene.voxmap()?);
        for &k in &subcell[rows.clone()] {
            // Ascending, so each is set once and lies above the others.
            let free = (k as usize) < SUBCELLS.pow(3) && mask.checked_shr(k as u32) == Some(0);
            mask |= if free { 1 << k } else { return None };
        }
        let word = |b: &[u8]| [0, 2, 4, 6].map(|k| u16::from_le_bytes([b[k], b[k + 1]]));
        let samples = packed[8 * rows.start..8 * rows.end].chunks_exact(8).map(word).collect();
        Part::from_packed(map.corner(map.coordinates(cell[i])), map.cell(), volume[i], mask, samples)
    };
    let parts: Option<Vec<Part>> = (0..n).map(part).collect();
    let Some(parts) = parts else {
        return Err(npz.error("part_subcell", "a sample is out of range; solve the scene again"));
    };
    let voxel = |(i, part): (usize, Part)| VoxelZone {
        cell: cell[i],
        centre: centre[i],
        volume: volume[i],
        part,
        extinction: extinction[i],
        albedo: albedo[i],
        emission: emission[i],
        source: source[i],
    };
    Ok(parts.into_iter().enumerate().map(voxel).collect())
}

fn read_pane_zones(npz: &mut reader::Npz<'_>, scene: &Scene) -> Result<Vec<PaneZone>, FileError> {
    let plates = npz.plates("pane_zone")?;
    let n = plates.len();
    let normal: Vec<Vec3> = npz.units("pane_zone_normal", n)?;
    let pane = npz.ints("pane_zone_pane", Some(n), scene.panes().len())?;
    let area = npz.positive("pane_zone_area", n)?;
    let thickness = npz.positive("pane_zone_thickness", n)?;
    let extinction = npz.bands("pane_zone_extinction", n, f64::MAX)?;
    let albedo = npz.bands("pane_zone_albedo", n, 1.0)?;
    let emission = npz.bands("pane_zone_emission", n, f64::MAX)?;
    let zone = |(i, plate): (usize, Plate)| PaneZone {
        pane: pane[i],
        plate,
        normal: normal[i],
        area: area[i],
        thickness: thickness[i],
        extinction: extinction[i],
        albedo: albedo[i],
        emission: emission[i],
    };
    Ok(plates.into_iter().enumerate().map(zone).collect())
}

/// Fills `first` from the ascending cells of the voxel zones.
fn with_index(mut zones: Zones, scene: &Scene) -> Zones {
    if let Some(v) = scene.voxmap() {
        let mut first = vec![0u32; v.len() + 1];
        zones.voxels.iter().for_each(|z| first[z.cell + 1] += 1);
        for c in 0..v.len() {
            first[c + 1] += first[c];
        }
        zones.first = first;
    }
    zones
}

#[cfg(test)]
mod tests;
