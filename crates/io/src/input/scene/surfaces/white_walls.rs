//! Warnings about walls of reflectance 1 between which light is never absorbed.
//!
//! The light that n reflections leave is ρⁿ: with ρ = 1 and no absorber the power between such walls is their source times the number of reflections until light
//! finds a way out, and an error of the exchange areas is multiplied by the same number. Two arrangements have it: sheets that are white on both sides and stand around a
//! space (through joints of walls of no thickness light enters their backs), and closed white rooms without an absorber inside.

use crate::input::reading::notes::quoted_list;
use zonal_math::Vec3;
use zonal_scene::shells::{ShellKind, Shells, WELD_TOLERANCE};
use zonal_scene::{Bands, Diagnostic, Plate, SceneParts, Sides, Surface};

/// Reflectance from which a surface counts as white.
const MIN_WHITE: f64 = 1.0 - 1e-9;
/// Length of the sum of the area vectors of sheets over their area, below which they stand around a space.
const MAX_ONE_SIDED_FRACTION: f64 = 0.5;
/// Surfaces that a warning names.
const MAX_NAMES: usize = 8;

/// The warnings of a scene in light mode.
pub(crate) fn white_walls(parts: &SceneParts) -> Vec<Diagnostic> {
    let is_white = |s: &Surface| {
        s.reflectance.any(|r| r >= MIN_WHITE) && s.reflectance_texture.is_none() && s.transmission.is_none()
    };
    if parts.thermal.is_some() || !parts.surfaces.iter().any(is_white) {
        return Vec::new();
    }
    let white: Vec<bool> = parts.surfaces.iter().map(is_white).collect();
    [white_sheets(parts, &white), white_rooms(parts, &white)].into_iter().flatten().collect()
}

fn names(parts: &SceneParts, mut surfaces: Vec<usize>) -> String {
    surfaces.sort_unstable();
    surfaces.dedup();
    let names: Vec<&str> = surfaces.iter().map(|s| parts.surfaces[*s].name.as_str()).collect();
    quoted_list(&names, MAX_NAMES)
}

/// The warning about sheets that are white on both sides.
fn white_sheets(parts: &SceneParts, white: &[bool]) -> Option<Diagnostic> {
    let is_sheet = |s: usize| white[s] && parts.surfaces[s].sides == Sides::Both && !parts.surfaces[s].solid;
    let sheets = parts.facets.iter().filter(|f| is_sheet(f.surface));
    let (mut sum, mut area, mut surfaces) = (Vec3::ZERO, 0.0, Vec::new());
    for f in sheets {
        sum += f.plate.normal() * f.plate.area();
        area += f.plate.area();
        surfaces.push(f.surface);
    }
    (area > 0.0 && sum.length() < MAX_ONE_SIDED_FRACTION * area).then(|| {
        let text = format!(
            "surfaces {} reflect all light on both sides, and stand around a space: light between them ends nowhere, and errors grow with every reflection; give a reflectance of 0.95 at most, or sides = \"front\"",
            names(parts, surfaces)
        );
        Diagnostic::warning("white-walls", text)
    })
}

/// The warning about closed white rooms without an absorber inside.
fn white_rooms(parts: &SceneParts, white: &[bool]) -> Option<Diagnostic> {
    let one_sided: Vec<usize> = (0..parts.facets.len())
        .filter(|i| parts.surfaces[parts.facets[*i].surface].sides == Sides::Front)
        .collect();
    let plates: Vec<Plate> = one_sided.iter().map(|i| parts.facets[*i].plate).collect();
    let shells = Shells::find(&plates, WELD_TOLERANCE);
    let of_shell = |k: usize| shells.shell_index(k);
    let mut is_white: Vec<bool> = shells.shells().iter().map(|s| s.kind == ShellKind::Enclosure).collect();
    for (k, i) in one_sided.iter().enumerate() {
        is_white[of_shell(k)] &= white[parts.facets[*i].surface];
    }
    if !is_white.contains(&true) || absorbs(parts) {
        return None;
    }
    let empty = (Vec3::splat(f64::INFINITY), Vec3::splat(f64::NEG_INFINITY));
    let mut bounds = vec![empty; is_white.len()];
    for (k, p) in plates.iter().enumerate() {
        let (low, high) = p.bounds();
        let own = &mut bounds[of_shell(k)];
        *own = (own.0.min(low), own.1.max(high));
    }
    // An absorber whose box meets that of a room may lie in it.
    let absorbers = parts.facets.iter().filter(|f| !white[f.surface]).map(|f| f.plate.bounds());
    let absorbers = absorbers.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or(empty);
    let meets =
        |(low, high): (Vec3, Vec3)| (0..3).all(|k| low[k] <= absorbers.1[k] && high[k] >= absorbers.0[k]);
    (0..is_white.len()).for_each(|s| is_white[s] &= !meets(bounds[s]));
    let walls = one_sided.iter().enumerate().filter(|(k, _)| is_white[of_shell(*k)]);
    let surfaces: Vec<usize> = walls.map(|(_, i)| parts.facets[*i].surface).collect();
    (!surfaces.is_empty()).then(|| {
        let text = format!(
            "surfaces {} are a closed room that reflects all light, and nothing inside absorbs: its light has no end; give a reflectance of 0.95 at most",
            names(parts, surfaces)
        );
        Diagnostic::warning("white-walls", text)
    })
}

/// True if a medium or a pane absorbs.
fn absorbs(parts: &SceneParts) -> bool {
    let grid = parts.voxel_grid.as_ref();
    let is_absorbing =
        |extinction: Bands, albedo: Bands| (extinction * (Bands::ONE - albedo)).any(|x| x > 0.0);
    grid.is_some_and(|g| (0..g.len()).any(|c| is_absorbing(g.extinction(c), g.albedo(c))))
        || parts.panes.iter().any(|p| is_absorbing(p.extinction, p.albedo))
}
