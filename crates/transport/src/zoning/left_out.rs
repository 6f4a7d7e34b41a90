//! Parts of a scene that have no zones: surfaces inside solids or covered by others, and medium outside the closed rooms.
//!
//! Of a surface with area A = Σ facets (both sides where both exchange) whose patches have the area P, the share 1 − P/A is left out. A surface
//! without any patch that would give off light or heat is refused where it lies inside a solid; any other is named.

use crate::Transport;
use zonal_scene::{Known, Note, Scene, SceneError, Sides, Zones};

/// Share of a surface that rounding may leave out.
const ROUNDING: f64 = 1e-6;
/// Names in one message.
const NAMED: usize = 3;
/// Facets of a surface that are asked whether they lie inside a solid.
const FACETS_ASKED: usize = 64;
/// Cells that are asked whether they lie outside the rooms.
const CELLS_ASKED: usize = 4096;

/// Looks for parts of a scene without zones: warnings of whole surfaces that take no part, then notes of shares that take none as they should.
/// Refuses a surface inside a solid that would give off light or heat.
pub fn left_out(scene: &Scene, transport: &Transport, zones: &Zones) -> Result<Vec<Note>, SceneError> {
    let mut out = Vec::new();
    let n = scene.surfaces().len();
    let (mut whole, mut kept) = (vec![0.0; n], vec![0.0; n]);
    for f in scene.facets() {
        let s = &scene.surfaces()[f.surface];
        whole[f.surface] += f.plate.area() * if s.sides == Sides::Both && !s.solid { 2.0 } else { 1.0 };
    }
    zones.patches.iter().for_each(|p| kept[p.surface] += p.area);
    let mut covered = Vec::new();
    let mut partly = Vec::new();
    for (k, s) in scene.surfaces().iter().enumerate().filter(|(k, _)| whole[*k] > 0.0) {
        let share = 1.0 - kept[k] / whole[k];
        if kept[k] > 0.0 {
            partly.extend((share > ROUNDING).then_some((share, s.name.as_str())));
            continue;
        }
        match solid_around(scene, transport, k) {
            Some(around) if gives(scene, k) => {
                return Err(SceneError::new(
                    format!("surface '{}'", s.name),
                    format!(
                        "all of it lies inside the solid '{around}', whose normals point outwards: nothing of what it gives off would take part; turn the normals of '{around}' inwards if it is a room, write solid = false or sides = \"both\" for walls of no thickness, or remove this surface"
                    ),
                ));
            }
            Some(around) => {
                let text = format!(
                    "lies inside the solid '{around}' and takes no part; turn the normals of '{around}' inwards if it is a room, or remove the surface"
                );
                out.push(Note::warning("surface-inside-solid", text).at(format!("surface '{}'", s.name)));
            }
            None => covered.push(s.name.as_str()),
        }
    }
    if !covered.is_empty() {
        let (names, have) = (listed(covered.iter().map(|n| format!("'{n}'"))), covered.len() > 1);
        let text = format!(
            "surface{} {names} {} covered by what lies on {} and takes no part",
            if have { "s" } else { "" },
            if have { "are" } else { "is" },
            if have { "them" } else { "it" }
        );
        out.push(Note::warning("surface-covered", text));
    }
    if !partly.is_empty() {
        partly.sort_by(|a, b| b.0.total_cmp(&a.0));
        let shares = partly.iter().map(|(share, name)| format!("{} of '{name}'", percent(*share)));
        let text = format!(
            "parts of surfaces lie inside solids or against other surfaces and take no part: {}",
            listed(shares)
        );
        out.push(Note::new("parts-covered", text));
    }
    out.extend(outside(scene, transport, zones).map(|t| Note::new("cells-outside", t)));
    Ok(out)
}

fn percent(share: f64) -> String {
    let p = 100.0 * share;
    if p >= 9.95 { format!("{p:.0} %") } else { format!("{p:.2} %") }
}

/// The first three of a list, and how many more there are.
fn listed(mut list: impl ExactSizeIterator<Item = String>) -> String {
    let first: Vec<String> = list.by_ref().take(NAMED).collect();
    match list.len() {
        0 => first.join(", "),
        n => format!("{} and {n} more", first.join(", ")),
    }
}

/// True where a surface emits, is a light, or has a temperature or a net power other than none.
fn gives(scene: &Scene, surface: usize) -> bool {
    let known = scene.thermal().and_then(|t| t.surfaces.get(surface));
    match known {
        Some(Known::Temperature(_)) => true,
        Some(Known::Flux(q) | Known::Power(q)) => *q != 0.0,
        None => scene.surfaces()[surface].emission != [0.0; 3] || scene.is_direct_emitter(surface),
    }
}

/// The name of a solid that holds every facet of a surface.
fn solid_around<'a>(scene: &'a Scene, transport: &Transport, surface: usize) -> Option<&'a str> {
    if !transport.has_solids() {
        return None;
    }
    let own: Vec<usize> =
        (0..scene.facets().len()).filter(|k| scene.facets()[*k].surface == surface).collect();
    let step = own.len().div_ceil(FACETS_ASKED).max(1);
    let mut around = None;
    for k in own.into_iter().step_by(step) {
        let plate = &scene.facets()[k].plate;
        // The same distance as that of the zones' own test.
        let facet = transport.solid_around(plate.centre() + plate.normal() * (1e3 * transport.epsilon()))?;
        around = around.or(Some(scene.facets()[facet].surface));
    }
    around.map(|s| scene.surfaces()[s].name.as_str())
}

/// The note of medium that lies outside the closed rooms.
fn outside(scene: &Scene, transport: &Transport, zones: &Zones) -> Option<String> {
    let map = scene.voxmap().filter(|_| transport.void_outside_rooms())?;
    let cell = map.cell().product();
    let lacking = |c: usize| cell - zones.of_cell(c).map(|z| zones.voxels[z].volume).sum::<f64>();
    let cells: Vec<usize> = (0..map.len()).filter(|c| lacking(*c) > ROUNDING * cell).collect();
    let step = cells.len().div_ceil(CELLS_ASKED).max(1);
    let asked = cells.iter().step_by(step).copied();
    let beyond = asked.filter(|c| transport.outside_rooms(map.centre(map.coordinates(*c))));
    let volume = beyond.map(lacking).sum::<f64>() * step as f64;
    (volume > 0.0).then(|| {
        format!(
            "about {volume:.3e} m3 of the medium lie outside the closed rooms, where no surface is: this part is left out of sums and means"
        )
    })
}
