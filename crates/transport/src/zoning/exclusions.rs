//! Parts of a scene that have no zones: surfaces inside solids or covered by others, and medium in solids or outside the closed rooms; and
//! surfaces that count twice.
//!
//! Of a surface with area A = Σ facets (both sides where both exchange) whose patches have the area P, the fraction 1 − P/A is
//! excluded. A surface without any patch is refused where it lies inside a solid and would emit light or heat; otherwise it is
//! reported.

use super::coincident_surfaces::coincident_surfaces;
use super::left_out_medium::left_out_media;
use super::wall_splitting::contact_gap;
use crate::transport::Transport;
use zonal_scene::{Bands, Diagnostic, Scene, SceneError, Sides, ThermalCondition, Zones};

/// Fraction of a surface, or of a cell, whose exclusion counts as rounding.
const ROUNDING_SHARE: f64 = 1e-6;
/// Most names listed in one message.
const MAX_LISTED_NAMES: usize = 3;
/// Most facets of a surface that are tested for lying inside a solid.
const MAX_TESTED_FACETS: usize = 64;
/// Most cells that are tested for lying outside the rooms.
const MAX_TESTED_CELLS: usize = 4096;

/// Reports the parts of a scene without zones, and surfaces that coincide: warnings for whole surfaces and media, notes for parts.
///
/// # Errors
///
/// When a surface inside a solid would emit light or heat.
pub fn excluded_parts(
    scene: &Scene,
    transport: &Transport,
    zones: &Zones,
) -> Result<Vec<Diagnostic>, SceneError> {
    let mut out = Vec::new();
    // Compare the area of each surface with that of its patches.
    let (whole, kept) = surface_areas(scene, zones);
    let mut covered = Vec::new();
    let mut partial = Vec::new();
    for (k, s) in scene.surfaces().iter().enumerate().filter(|(k, _)| whole[*k] > 0.0) {
        let share = 1.0 - kept[k] / whole[k];
        if kept[k] > 0.0 {
            partial.extend((share > ROUNDING_SHARE).then_some((share, s.name.as_str())));
            continue;
        }
        match enclosing_solid(scene, transport, k) {
            Some(solid) if emits(scene, k) => return Err(emitter_inside_solid(&s.name, solid)),
            Some(solid) => {
                let text = format!(
                    "lies inside the solid '{solid}' and is excluded; turn the normals of '{solid}' inwards if it is a room, or remove the surface"
                );
                out.push(
                    Diagnostic::warning("surface-inside-solid", text).at(format!("surface '{}'", s.name)),
                );
            }
            None => covered.push(s.name.as_str()),
        }
    }
    // Report covered surfaces, parts of surfaces, and the medium outside the rooms.
    if !covered.is_empty() {
        out.push(Diagnostic::warning("surface-covered", covered_message(&covered)));
    }
    if !partial.is_empty() {
        partial.sort_by(|a, b| b.0.total_cmp(&a.0));
        let shares = partial.iter().map(|(share, name)| format!("{} of '{name}'", percent(*share)));
        let text = format!(
            "parts of surfaces lie inside solids or against other surfaces and are excluded: {}",
            listed(shares)
        );
        out.push(Diagnostic::note("parts-covered", text));
    }
    out.extend(coincident_surfaces(scene, transport, zones));
    out.extend(left_out_media(scene, transport, zones));
    out.extend(medium_outside_rooms(scene, transport, zones).map(|t| Diagnostic::note("cells-outside", t)));
    Ok(out)
}

/// The exchanging area of each surface, and the area of its patches, m².
fn surface_areas(scene: &Scene, zones: &Zones) -> (Vec<f64>, Vec<f64>) {
    let n = scene.surfaces().len();
    let (mut whole, mut kept) = (vec![0.0; n], vec![0.0; n]);
    for f in scene.facets() {
        let s = &scene.surfaces()[f.surface];
        whole[f.surface] += f.plate.area() * if s.sides == Sides::Both && !s.solid { 2.0 } else { 1.0 };
    }
    zones.patches.iter().for_each(|p| kept[p.surface] += p.area);
    (whole, kept)
}

fn emitter_inside_solid(surface: &str, solid: &str) -> SceneError {
    SceneError::new(
        format!("surface '{surface}'"),
        format!(
            "lies entirely inside the solid '{solid}', whose normals point outwards, so its emission would be lost; turn the normals of '{solid}' inwards if it is a room, write solid = false or sides = \"both\" for walls of no thickness, or remove this surface"
        ),
    )
}

fn covered_message(covered: &[&str]) -> String {
    let (names, several) = (listed(covered.iter().map(|n| format!("'{n}'"))), covered.len() > 1);
    format!(
        "surface{} {names} {} covered by other surfaces and excluded",
        if several { "s" } else { "" },
        if several { "are" } else { "is" }
    )
}

fn percent(share: f64) -> String {
    let p = 100.0 * share;
    if p >= 9.95 { format!("{p:.0} %") } else { format!("{p:.2} %") }
}

/// The first [`MAX_LISTED_NAMES`] items of a list, and the number of further ones.
fn listed(mut list: impl ExactSizeIterator<Item = String>) -> String {
    let first: Vec<String> = list.by_ref().take(MAX_LISTED_NAMES).collect();
    match list.len() {
        0 => first.join(", "),
        n => format!("{} and {n} more", first.join(", ")),
    }
}

/// True where a surface emits, is a light, has a temperature or a net power other than 0.
fn emits(scene: &Scene, surface: usize) -> bool {
    let known = scene.thermal().and_then(|t| t.surfaces.get(surface));
    match known {
        Some(ThermalCondition::Temperature(_)) => true,
        Some(ThermalCondition::Flux(q) | ThermalCondition::Power(q)) => *q != 0.0,
        None => scene.surfaces()[surface].emission != Bands::ZERO || scene.is_direct_emitter(surface),
    }
}

/// The name of a solid that holds every tested facet of a surface.
fn enclosing_solid<'a>(scene: &'a Scene, transport: &Transport, surface: usize) -> Option<&'a str> {
    if !transport.has_solids() {
        return None;
    }
    let facets: Vec<usize> =
        (0..scene.facets().len()).filter(|k| scene.facets()[*k].surface == surface).collect();
    let step = facets.len().div_ceil(MAX_TESTED_FACETS).max(1);
    let mut solid = None;
    for k in facets.into_iter().step_by(step) {
        let plate = &scene.facets()[k].plate;
        let point = plate.centre() + plate.normal() * contact_gap(transport);
        let facet = transport.enclosing_solid_facet(point)?;
        solid = solid.or(Some(scene.facets()[facet].surface));
    }
    solid.map(|s| scene.surfaces()[s].name.as_str())
}

/// The note on medium outside the closed rooms.
fn medium_outside_rooms(scene: &Scene, transport: &Transport, zones: &Zones) -> Option<String> {
    let grid = scene.voxel_grid().filter(|_| transport.exterior_medium_is_inert())?;
    let cell = grid.cell().product();
    let missing =
        |c: usize| cell - zones.voxel_zones_of_cell(c).map(|z| zones.voxels.at(z).volume).sum::<f64>();
    let cells: Vec<usize> = (0..grid.len()).filter(|c| missing(*c) > ROUNDING_SHARE * cell).collect();
    let step = cells.len().div_ceil(MAX_TESTED_CELLS).max(1);
    let tested = cells.iter().step_by(step).copied();
    let outside = tested.filter(|c| transport.is_outside_rooms(grid.centre(grid.coordinates(*c))));
    let volume = outside.map(missing).sum::<f64>() * step as f64;
    (volume > 0.0).then(|| {
        format!(
            "about {volume:.3e} m3 of the medium lie outside the closed rooms, where no surface is: this part is excluded from sums and means"
        )
    })
}
