//! Medium that has no zones although it absorbs or scatters: a room that is inside out, or a medium outside of all rooms.
//!
//! The cells of a medium are grouped by their properties. A group with an extinction, none of whose volume has a zone, is reported with
//! the reason at its cells. A solid with such cells behind its faces and no medium in front of any of them is reported as a room that
//! is inside out, even if the same medium has zones elsewhere.

use crate::transport::Transport;
use std::collections::BTreeMap;
use zonal_math::Vec3;
use zonal_scene::{Bands, Diagnostic, Scene, VoxelGrid, Zones};

/// Fraction of the volume of a medium below which its zones count as none.
const MIN_KEPT_SHARE: f64 = 1e-6;
/// Maximum number of groups of cells with equal properties. With more, each cell of an array has properties of its own, and only the whole medium is tested.
const MAX_GROUPS: usize = 64;
/// Most cells of a group whose place is tested.
const MAX_TESTED_CELLS: usize = 1024;
/// Most facets of a solid that are tested.
const MAX_TESTED_FACETS: usize = 256;

/// Cells with equal properties.
#[derive(Default)]
struct CellGroup {
    cells: Vec<usize>,
    /// Volume of the zones, m³.
    kept: f64,
}

/// Warnings about media that have no zones.
pub(super) fn left_out_media(scene: &Scene, transport: &Transport, zones: &Zones) -> Vec<Diagnostic> {
    let Some(grid) = scene.voxel_grid() else { return Vec::new() };
    let mut out = Vec::new();
    let solids = inverted_rooms(scene, transport, grid);
    for name in &solids {
        let text = String::from(
            "is a closed body with normals outward, with the medium inside it and none outside: a room that is inside out, whose medium is left out; reverse the corners of each face (trimesh: mesh.invert()), or write room in place of box",
        );
        out.push(Diagnostic::warning("inverted-room", text).at(format!("surface '{name}'")));
    }
    // Where every cell is one whole zone, no medium is left out.
    if zones.voxels.plane_size().is_some() && !zones.voxels.is_divided() {
        return out;
    }
    let volume = grid.cell().product();
    for group in groups(grid, zones) {
        let whole = group.cells.len() as f64 * volume;
        if group.kept > MIN_KEPT_SHARE * whole {
            continue;
        }
        let step = group.cells.len().div_ceil(MAX_TESTED_CELLS).max(1);
        let centres = group.cells.iter().step_by(step).map(|c| grid.centre(grid.coordinates(*c)));
        let Some(reason) = reason(scene, transport, centres, &solids) else { continue };
        let text = format!(
            "{whole:.3e} m3 of the medium with extinction {:.3e} 1/m have no zones and take no part: {reason}",
            grid.extinction(group.cells[0]).max_element()
        );
        out.push(Diagnostic::warning("medium-left-out", text).at("medium"));
    }
    out
}

/// The cells with an extinction, grouped by their properties; one group of all if there are too many.
fn groups(grid: &VoxelGrid, zones: &Zones) -> Vec<CellGroup> {
    let bits = |b: Bands| b.to_rgb().map(f64::to_bits);
    let mut by_properties: BTreeMap<[[u64; 3]; 4], CellGroup> = BTreeMap::new();
    let mut all = CellGroup::default();
    for c in (0..grid.len()).filter(|c| grid.extinction(*c).any(|k| k > 0.0)) {
        let kept = zones.voxel_zones_of_cell(c).map(|z| zones.voxels.at(z).volume).sum::<f64>();
        all.cells.push(c);
        all.kept += kept;
        if by_properties.len() > MAX_GROUPS {
            continue;
        }
        let key = [grid.extinction(c), grid.albedo(c), grid.emission(c), grid.source(c)].map(bits);
        let group = by_properties.entry(key).or_default();
        group.cells.push(c);
        group.kept += kept;
    }
    match by_properties.len() {
        0 => Vec::new(),
        n if n > MAX_GROUPS => vec![all],
        _ => {
            let mut list: Vec<CellGroup> = by_properties.into_values().collect();
            list.sort_by_key(|g| g.cells[0]);
            list
        }
    }
}

/// Why cells have no zones, and the remedy; `None` for those in a room that is reported already.
fn reason(
    scene: &Scene,
    transport: &Transport,
    centres: impl Iterator<Item = Vec3>,
    reported: &[String],
) -> Option<String> {
    let (mut outside, mut solid) = (0, None);
    for p in centres {
        if let Some(facet) = transport.inside_solid(p).then(|| transport.enclosing_solid_facet(p)).flatten() {
            solid = solid.or(Some(scene.facets()[facet].surface));
        } else if transport.exterior_medium_is_inert() && transport.is_outside_rooms(p) {
            outside += 1;
        }
    }
    match solid.map(|s| &scene.surfaces()[s].name) {
        Some(name) if reported.contains(name) => None,
        Some(name) => Some(format!(
            "they lie inside the solid '{name}'; turn its normals inwards if it is a room (trimesh: mesh.invert()), or remove the medium there"
        )),
        None if outside > 0 => Some(
            "they lie outside the closed rooms, where no surface is; move the medium into a room, or open it"
                .into(),
        ),
        None => Some("no part of a cell is free; use smaller cells, or move the medium".into()),
    }
}

/// The surfaces of solids with medium right behind their faces and none right in front of any.
fn inverted_rooms(scene: &Scene, transport: &Transport, grid: &VoxelGrid) -> Vec<String> {
    let has_extinction = |p: Vec3| {
        let cell = grid.cell_at(p).map(|c| grid.index(c));
        cell.is_some_and(|c| grid.extinction(c).any(|k| k > 0.0))
    };
    let mut facets: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (k, f) in scene.facets().iter().enumerate().filter(|(_, f)| scene.surfaces()[f.surface].solid) {
        facets.entry(f.surface).or_default().push(k);
    }
    let lift = 1e3 * transport.epsilon();
    let is_inverted = |list: &[usize]| {
        let step = list.len().div_ceil(MAX_TESTED_FACETS).max(1);
        let mut behind = false;
        for k in list.iter().step_by(step) {
            let plate = &scene.facets()[*k].plate;
            let (c, n) = (plate.centre(), plate.normal());
            if has_extinction(c + n * lift) && !transport.inside_solid(c + n * lift) {
                return false;
            }
            behind |= has_extinction(c - n * lift);
        }
        behind
    };
    let inverted = facets.into_iter().filter(|(_, list)| is_inverted(list));
    inverted.map(|(s, _)| scene.surfaces()[s].name.clone()).collect()
}
