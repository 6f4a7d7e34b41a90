//! Reading of a solution, with validation of all of its contents.

use super::faces::read_faces;
use super::header::{CellPolynomials, FORMAT, FORMAT_VERSION, Provenance, SceneHeader, VoxelGridHeader};
use super::shading::read_shading;
use super::write::{sky_name, texture_name};
use crate::output::error::FileError;
use crate::output::npz::reader::{NpzReader, ZoneRows};
use crate::output::report::codec::{BandLists, block_of_document, decode_at};
use crate::output::report::{decode_bands, decode_document};
use serde_json::Value;
use std::io::Cursor;
use std::path::Path;
use zonal_math::Vec3;
use zonal_scene::{
    BandSet, Facet, Fields, Light, LightGroup, LightGroupKind, Pane, PaneZone, Patch, Plate, SUBCELLS, Scene,
    SceneError, SceneParts, SheetSides, Solution, Texture, ThermalCondition, ThermalFields, VoxelGrid,
    VoxelPlace, VoxelSamples, VoxelZones, Zones,
};

/// Reads a solution and validates its shapes, ranges and numbers.
///
/// # Errors
///
/// The file cannot be read, is damaged or hostile, or has another format version.
///
/// ```no_run
/// let solution = zonal_io::output::read_solution(std::path::Path::new("room.npz"))?;
/// println!("{} zones", solution.zones.len());
/// # Ok::<(), zonal_io::output::FileError>(())
/// ```
pub fn read_solution(path: impl AsRef<Path>) -> Result<Solution, FileError> {
    let path = path.as_ref();
    read_blocks(NpzReader::open(path)?)
}

/// As [`read_solution`], from a file's bytes.
///
/// # Errors
///
/// As [`read_solution`].
pub fn read_solution_from_bytes(bytes: &[u8]) -> Result<Solution, FileError> {
    read_blocks(NpzReader::new(Path::new("memory"), Box::new(Cursor::new(bytes)), bytes.len() as u64)?)
}

/// Reads all blocks of bands of a file.
fn read_blocks(mut npz: NpzReader<'_>) -> Result<Solution, FileError> {
    let document = read_header(&mut npz)?;
    let header_error = |npz: &NpzReader, e: String| npz.error("header.json", e);
    let bands = decode_bands(&document["bands"]).map_err(|e| header_error(&npz, e))?;
    let lists: BandLists =
        decode_at("band_lists", &document["band_lists"]).map_err(|e| header_error(&npz, e))?;
    let mut solutions = Vec::new();
    for block in 0..bands.block_count() {
        npz.set_block(bands.clone(), block);
        let own = block_of_document(&document, &lists, &bands, block).map_err(|e| header_error(&npz, e))?;
        solutions.push(read(&mut npz, &own, &bands, block)?);
    }
    let scenes = solutions.iter().map(|s| s.scene.clone()).collect();
    let scene = Scene::from_blocks(scenes).map_err(|e| scene_error(&npz, &e))?;
    Ok(Solution::of_blocks(scene, solutions))
}

/// Reads one block of bands.
fn read(
    npz: &mut NpzReader<'_>,
    document: &Value,
    bands: &BandSet,
    block: usize,
) -> Result<Solution, FileError> {
    // Decode the header.
    let json_error = |e: String| npz.error("header.json", e);
    let header: SceneHeader = decode_at("", document).map_err(json_error)?;
    let (mut report, groups) = decode_document(&document["report"]).map_err(json_error)?;
    let provenance: Provenance = decode_at("provenance", &document["provenance"]).map_err(json_error)?;
    if block > 0 {
        // The table of heat belongs to all bands.
        report.heat = None;
    }
    // Read the scene and its zones.
    let scene = read_scene(npz, header, bands, block)?;
    let patches = read_patches(npz, &scene)?;
    let zones = Zones {
        sheets: SheetSides::of(&scene, &patches),
        patches,
        voxels: read_voxels(npz, &scene)?,
        panes: read_pane_zones(npz, &scene)?,
        ..Zones::default()
    };
    // Read the fields.
    let n = zones.len();
    let mut fields = Fields::default();
    for field in Fields::LISTS {
        *(field.of_mut)(&mut fields) = npz.field(&field, n)?;
    }
    fields.direct = Fields::direct_unless_zero(fields.direct);
    if scene.thermal().is_some() && block == 0 {
        fields.heat = Some(read_thermal_fields(npz, n)?);
    }
    let groups = read_groups(npz, groups, &scene, n)?;
    let Provenance { scene_hash, version } = provenance;
    Ok(Solution { report, further_blocks: Vec::new(), scene_hash, version, scene, zones, fields, groups })
}

fn read_thermal_fields(npz: &mut NpzReader<'_>, zones: usize) -> Result<ThermalFields, FileError> {
    let temperature = npz.reals_or_nan("temperature", zones, f64::is_finite)?;
    let temperature_error = npz.reals_or_nan("temperature_error", zones, |e| e >= 0.0)?;
    let (net, net_error) = (npz.reals("net", zones)?, npz.error_list("net_error", zones)?);
    Ok(ThermalFields { temperature, temperature_error, net, net_error })
}

/// Reads the fields of light groups.
fn read_groups(
    npz: &mut NpzReader<'_>,
    mut groups: Vec<LightGroup>,
    scene: &Scene,
    zones: usize,
) -> Result<Vec<LightGroup>, FileError> {
    for (k, g) in groups.iter_mut().enumerate() {
        let exists = match g.kind {
            LightGroupKind::Light(l) => l < scene.lights().len(),
            LightGroupKind::Surface(s) => s < scene.surfaces().len(),
            _ => true,
        };
        if !exists {
            let message = format!("light group '{}' is of nothing in the scene", g.name);
            return Err(npz.error("header.json", message));
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

/// Reads the header and checks its format and version.
fn read_header(npz: &mut NpzReader<'_>) -> Result<Value, FileError> {
    let header = npz.json("header.json")?;
    if header["format"] != FORMAT {
        return Err(npz.error("header.json", "this is not a zonal solution; give a file that zonal wrote"));
    }
    let version = &header["format_version"];
    if version.as_u64() != Some(FORMAT_VERSION) {
        let message = format!(
            "format version {version} is not {FORMAT_VERSION}; solve the scene again with this version"
        );
        return Err(npz.error("header.json", message));
    }
    Ok(header)
}

fn read_scene(
    npz: &mut NpzReader<'_>,
    header: SceneHeader,
    bands: &BandSet,
    block: usize,
) -> Result<Scene, FileError> {
    let cells = if header.thermal.is_some() { read_cell_fractions(npz, bands)? } else { None };
    let thermal = header.thermal.map(|t| t.into_thermal(bands, block, cells)).transpose();
    let facets = read_facets(npz, header.surfaces.len())?;
    let parts = SceneParts {
        name: header.name,
        faces: read_faces(npz, header.meshes, facets.len())?,
        shading: read_shading(npz, facets.len(), header.surfaces.len(), header.textures)?,
        facets,
        surfaces: header.surfaces,
        textures: (0..header.textures).map(|i| read_texture(npz, block, i)).collect::<Result<_, _>>()?,
        panes: read_panes(npz, header.panes)?,
        voxel_grid: header.voxel_grid.map(|v| read_voxel_grid(npz, &v)).transpose()?,
        lights: read_lights(npz, header.lights)?,
        surroundings: header.surroundings,
        periodic: header.periodic,
        thermal: thermal.map_err(|e| npz.error("header.json", e))?,
        symmetry_planes: header.symmetry_planes,
        boundary_box: header.boundary_box.map(|[min, max]| (Vec3::from_array(min), Vec3::from_array(max))),
        cameras: header.cameras,
        options: header.options,
        notes: header.notes,
        bands: bands.clone(),
        block,
    };
    Scene::new(parts).map_err(|e| scene_error(npz, &e))
}

/// Band fractions that differ from cell to cell, as [`super::write`] stores them: the kind of each cell, and the polynomials of every kind and band.
fn read_cell_fractions(
    npz: &mut NpzReader<'_>,
    bands: &BandSet,
) -> Result<Option<CellPolynomials>, FileError> {
    const POLYNOMIALS: &str = "cell_fraction_polynomials";
    if !npz.has(POLYNOMIALS) {
        return Ok(None);
    }
    let (shape, data) = npz.grid(POLYNOMIALS)?;
    let &[kinds, own, powers] = shape.as_slice() else {
        return Err(npz.error(POLYNOMIALS, format!("has shape {shape:?}; solve the scene again")));
    };
    if own != bands.count() || powers == 0 {
        return Err(npz.error(POLYNOMIALS, format!("has shape {shape:?}; solve the scene again")));
    }
    let polynomials = data.chunks_exact(powers).map(<[f64]>::to_vec).collect::<Vec<_>>();
    let polynomials = polynomials.chunks_exact(own).map(<[Vec<f64>]>::to_vec).collect();
    let kind_of_cell = npz.ints("cell_fraction_kind", None, kinds)?;
    let kind_of_cell = kind_of_cell.into_iter().map(|k| k as u32).collect();
    Ok(Some(CellPolynomials { kind_of_cell, kinds: polynomials }))
}

/// The error of an invalid scene.
fn scene_error(npz: &NpzReader<'_>, e: &SceneError) -> FileError {
    npz.error(e.key(), e.message())
}

fn read_facets(npz: &mut NpzReader<'_>, surfaces: usize) -> Result<Vec<Facet>, FileError> {
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

fn read_texture(npz: &mut NpzReader<'_>, block: usize, i: usize) -> Result<Texture, FileError> {
    let (width, height, pixels) = npz.picture(&texture_name(block, i))?;
    Ok(Texture { width, height, pixels })
}

/// The lights with the pictures of skies.
fn read_lights(npz: &mut NpzReader<'_>, mut lights: Vec<Light>) -> Result<Vec<Light>, FileError> {
    for (l, light) in lights.iter_mut().enumerate() {
        if let Some(distribution) = light.sky_distribution_mut().filter(|d| d.lacks_pixels()) {
            let name = sky_name(l);
            let (width, height, pixels) = npz.picture(&name)?;
            let with_pixels = distribution.with_pixels(Texture { width, height, pixels });
            *distribution = with_pixels.map_err(|e| npz.error(&name, e))?;
        }
    }
    Ok(lights)
}

fn read_panes(npz: &mut NpzReader<'_>, mut panes: Vec<Pane>) -> Result<Vec<Pane>, FileError> {
    let plates = npz.plates("pane_plate")?;
    let owner = npz.ints("pane_plate_pane", Some(plates.len()), panes.len())?;
    for (plate, i) in plates.into_iter().zip(owner) {
        panes[i].plates.push(plate);
    }
    Ok(panes)
}

fn read_voxel_grid(npz: &mut NpzReader<'_>, h: &VoxelGridHeader) -> Result<VoxelGrid, FileError> {
    let dims = h.dims;
    // Read the arrays first: their size bounds the memory of the grid.
    let extinction = npz.band_rows("voxmap_extinction", &dims)?;
    let albedo = npz.band_rows("voxmap_albedo", &dims)?;
    let emission = npz.band_rows("voxmap_emission", &dims)?;
    let source = npz.band_rows("voxmap_source", &dims)?;
    let mut voxel_grid = VoxelGrid::new(h.min, h.cell, dims).map_err(|e| scene_error(npz, &e))?;
    // The index of the zones takes four bytes per cell.
    npz.charge("voxmap_extinction", 4 * voxel_grid.len() as u64)?;
    if let (ZoneRows::Same(k), ZoneRows::Same(o), ZoneRows::Same(e), ZoneRows::Same(q)) =
        (&extinction, &albedo, &emission, &source)
    {
        voxel_grid.fill(*k, *o, *e, *q);
    } else {
        for i in 0..voxel_grid.len() {
            voxel_grid.set(i, extinction[i], albedo[i], emission[i], source[i]);
        }
    }
    if npz.has("voxmap_interpolated") {
        let marks = npz.ints("voxmap_interpolated", None, 2)?;
        if marks.len() != 1 && marks.len() != voxel_grid.len() {
            return Err(npz.error(
                "voxmap_interpolated",
                format!("has {} marks for {} cells; solve the scene again", marks.len(), voxel_grid.len()),
            ));
        }
        let is_marked = |i: &usize| marks[i % marks.len()] == 1;
        (0..voxel_grid.len()).filter(is_marked).for_each(|i| voxel_grid.mark_interpolated(i));
    }
    if npz.has("voxmap_heat") {
        // Rows of (1, temperature, 0) or (0, 0, heat source).
        let condition = |[is_temperature, temperature, flux]: [f64; 3]| {
            if is_temperature > 0.0 {
                ThermalCondition::Temperature(temperature)
            } else {
                ThermalCondition::Flux(flux)
            }
        };
        match npz.same_or_each("voxmap_heat", &dims)? {
            ZoneRows::Same(x) => voxel_grid.fill_heat(condition(x)),
            ZoneRows::Each(list) => {
                list.into_iter()
                    .enumerate()
                    .for_each(|(i, x)| voxel_grid.set_heat(i, condition(x), ThermalCondition::Flux(0.0)));
            }
        }
    }
    voxel_grid.seal().map_err(|e| scene_error(npz, &e))
}

fn read_patches(npz: &mut NpzReader<'_>, scene: &Scene) -> Result<Vec<Patch>, FileError> {
    let plates = npz.plates("patch")?;
    let n = plates.len();
    let normal = npz.units("patch_normal", n)?;
    let area = npz.positive("patch_area", n)?;
    let facet = npz.ints("patch_facet", Some(n), scene.facets().len())?;
    let surface = npz.ints("patch_surface", Some(n), scene.surfaces().len())?;
    let reflectance = npz.bands_up_to("patch_reflectance", n, 1.0)?;
    let emission = npz.bands_up_to("patch_emission", n, f64::MAX)?;
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

fn read_voxels(npz: &mut NpzReader<'_>, scene: &Scene) -> Result<VoxelZones, FileError> {
    let cell = npz.ints("voxel_cell", None, scene.voxel_grid().map_or(0, |v| v.len()))?;
    let n = cell.len();
    if !cell.is_sorted() {
        return Err(npz.error("voxel_cell", "the cells are not in ascending order; solve the scene again"));
    }
    let centre = npz.vectors("voxel_centre", n)?;
    let volume = npz.positive_or_one("voxel_volume", n)?;
    let extinction = npz.bands_up_to("voxel_extinction", n, f64::MAX)?;
    let albedo = npz.bands_up_to("voxel_albedo", n, 1.0)?;
    let emission = npz.bands_up_to("voxel_emission", n, f64::MAX)?;
    let source = npz.bands_up_to("voxel_source", n, f64::MAX)?;
    let subcell = npz.bytes("part_subcell", None)?;
    let packed = npz.bytes("part_packed", Some(8 * subcell.len()))?;
    let first = npz.ints("voxel_part_first", None, subcell.len() + 1)?;
    // No numbers where no voxel is cut.
    let covers = match first[..] {
        [] => subcell.is_empty(),
        [0, .., last] => last == subcell.len() && first.len() == n + 1 && first.is_sorted(),
        _ => n == 0 && first == [0] && subcell.is_empty(),
    };
    if !covers {
        return Err(npz.error("voxel_part_first", "does not cover the samples; solve the scene again"));
    }
    let part = |i: usize| {
        let rows = if first.is_empty() { 0..0 } else { first[i]..first[i + 1] };
        let (mut mask, map) = (0u64, scene.voxel_grid()?);
        for &k in &subcell[rows.clone()] {
            // Indices ascend, so that each bit is set once, above the others.
            let free = (k as usize) < SUBCELLS.pow(3) && mask.checked_shr(k as u32) == Some(0);
            mask |= if free { 1 << k } else { return None };
        }
        let word = |b: &[u8]| [0, 2, 4, 6].map(|k| u16::from_le_bytes([b[k], b[k + 1]]));
        let samples = packed[8 * rows.start..8 * rows.end].chunks_exact(8).map(word).collect();
        VoxelSamples::from_packed(map.corner(map.coordinates(cell[i])), map.cell(), volume[i], mask, samples)
    };
    let parts: Option<Vec<VoxelSamples>> = (0..n).map(part).collect();
    let Some(parts) = parts else {
        return Err(npz.error("part_subcell", "a sample is out of range; solve the scene again"));
    };
    let place = |(i, samples): (usize, VoxelSamples)| VoxelPlace {
        cell: cell[i],
        centre: centre[i],
        volume: volume[i],
        samples,
    };
    let Some(grid) = scene.voxel_grid() else { return Ok(VoxelZones::default()) };
    let mut zones = VoxelZones::new(grid, parts.into_iter().enumerate().map(place));
    zones.update_extinction(|i, _| extinction[i]);
    zones.update_albedo(|i, _| albedo[i]);
    zones.update_emission(|i, _| emission[i]);
    zones.update_source(|i, _| source[i]);
    Ok(zones)
}

fn read_pane_zones(npz: &mut NpzReader<'_>, scene: &Scene) -> Result<Vec<PaneZone>, FileError> {
    let plates = npz.plates("pane_zone")?;
    let n = plates.len();
    let normal: Vec<Vec3> = npz.units("pane_zone_normal", n)?;
    let pane = npz.ints("pane_zone_pane", Some(n), scene.panes().len())?;
    let area = npz.positive("pane_zone_area", n)?;
    let thickness = npz.positive("pane_zone_thickness", n)?;
    let extinction = npz.bands_up_to("pane_zone_extinction", n, f64::MAX)?;
    let albedo = npz.bands_up_to("pane_zone_albedo", n, 1.0)?;
    let emission = npz.bands_up_to("pane_zone_emission", n, f64::MAX)?;
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
