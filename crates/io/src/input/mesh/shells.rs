//! Closed parts of a mesh and their orientation: [`zonal_scene::shells`] with welded corners.

use std::f64::consts::PI;
use zonal_math::Vec3;
use zonal_scene::Plate;
use zonal_scene::shells::{Shell, WELD_TOLERANCE};
pub(crate) use zonal_scene::shells::{ShellKind, Shells};

/// Volume of a closed part over that of the bounding box of the model, above which it may contain most of the model.
const MIN_ROOM_VOLUME_FRACTION: f64 = 0.4;
/// The same, below which a closed part with inward normals is a body and no room.
const MAX_BODY_VOLUME_FRACTION: f64 = 0.02;
/// Compactness 36 π V²/A³ of a closed part, 1 of a sphere and 0.52 of a cube, below which one with inward normals is a body: a slab or a backdrop.
const MIN_ROOM_COMPACTNESS: f64 = 0.005;
/// Area of the other parts within the bounding box of a closed part over that of all others, from which it contains most of the model.
const MIN_CONTAINED_AREA_FRACTION: f64 = 0.5;
/// Closed parts, by volume, whose contents are summed.
const MAX_ROOM_CANDIDATES: usize = 4;
/// Extent of the model over the distance by which a contained part may stick out.
const EXTENT_OVER_SLACK: f64 = 1e6;

/// Sides of the open parts of a mesh.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum OpenSides {
    /// Those of the file: both where it does not say.
    OfFile,
    /// Both; parts that are turned inside out count as open.
    Both,
}

/// A closed part whose normals point the wrong way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TurnedPart {
    /// Outward normals around most of the model.
    Room,
    /// Inward normals of a small or flat part.
    Solid,
}

/// The parts that are turned inside out, by the index of the shell; `low` and `high` are the corners of the whole model.
pub(crate) fn turned_parts(
    plates: &[Plate],
    shells: &Shells,
    low: Vec3,
    high: Vec3,
) -> Vec<Option<TurnedPart>> {
    let all = (high - low).product();
    let list = shells.shells();
    let of_solid = |s: &Shell| {
        let is_flat = 36.0 * PI * s.volume * s.volume < MIN_ROOM_COMPACTNESS * s.area.powi(3);
        let is_body = is_flat || -s.volume < MAX_BODY_VOLUME_FRACTION * all;
        (s.kind == ShellKind::Enclosure && is_body).then_some(TurnedPart::Solid)
    };
    let mut out: Vec<Option<TurnedPart>> = list.iter().map(of_solid).collect();
    let is_large =
        |i: &usize| list[*i].kind == ShellKind::Solid && list[*i].volume > MIN_ROOM_VOLUME_FRACTION * all;
    let mut large: Vec<usize> = (0..list.len()).filter(is_large).collect();
    large.sort_by(|a, b| list[*b].volume.total_cmp(&list[*a].volume));
    large.truncate(MAX_ROOM_CANDIDATES);
    if large.is_empty() || list.len() < 2 {
        return out;
    }
    let bounds = bounds_of_shells(plates, shells);
    let slack = Vec3::splat((high - low).max_abs() / EXTENT_OVER_SLACK);
    let total: f64 = list.iter().map(|s| s.area).sum();
    for i in large {
        let (low, high) = (bounds[i].0 - slack, bounds[i].1 + slack);
        let is_within = |(a, b): (Vec3, Vec3)| a.min(low) == low && b.max(high) == high;
        let others = (0..list.len()).filter(|k| *k != i && is_within(bounds[*k]));
        let contained: f64 = others.map(|k| list[k].area).sum();
        if contained >= MIN_CONTAINED_AREA_FRACTION * (total - list[i].area) {
            out[i] = Some(TurnedPart::Room);
        }
    }
    out
}

/// The bounding box of each shell.
fn bounds_of_shells(plates: &[Plate], shells: &Shells) -> Vec<(Vec3, Vec3)> {
    let empty = (Vec3::splat(f64::INFINITY), Vec3::splat(f64::NEG_INFINITY));
    let mut out = vec![empty; shells.shells().len()];
    for (i, p) in plates.iter().enumerate() {
        let (low, high) = p.bounds();
        let own = &mut out[shells.shell_index(i)];
        *own = (own.0.min(low), own.1.max(high));
    }
    out
}

/// The components of a mesh.
pub(crate) fn find_shells(plates: &[Plate]) -> Shells {
    Shells::find(plates, WELD_TOLERANCE)
}

/// Refuses plates that do not bound a body.
pub(crate) fn check_closed(plates: &[Plate]) -> Result<(), String> {
    let shells = find_shells(plates);
    let open = (0..plates.len()).filter(|i| shells.of(*i) == ShellKind::Open).count();
    match open {
        0 => Ok(()),
        n => Err(format!(
            "{n} of the {} faces belong to no closed body, so that nothing is inside; close the mesh",
            plates.len()
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::scene::shapes::{Facing, box_faces};
    use zonal_math::{Vec3, vec3};

    #[test]
    fn bodies_rooms_and_open_shells_are_distinguished() {
        let outer = box_faces(Vec3::ZERO, Vec3::splat(4.0), Facing::Inward);
        let inner = box_faces(Vec3::ONE, Vec3::splat(2.0), Facing::Outward);
        let lid = Plate::triangle(vec3(9.0, 0.0, 0.0), vec3(10.0, 0.0, 0.0), vec3(9.0, 1.0, 0.0));
        let all: Vec<Plate> = outer.into_iter().chain(inner).chain([lid]).collect();
        let s = find_shells(&all);
        assert!((0..6).all(|i| s.of(i) == ShellKind::Enclosure));
        assert!((6..12).all(|i| s.of(i) == ShellKind::Solid));
        assert_eq!(s.of(12), ShellKind::Open);
        let open = |plates: &[Plate]| (0..plates.len()).all(|i| find_shells(plates).of(i) == ShellKind::Open);
        assert!(open(&inner[..5]));
        let mut turned = inner;
        turned[2] = turned[2].flipped();
        assert!(open(&turned));
    }

    #[test]
    fn parts_that_are_turned_inside_out_are_found_by_their_contents() {
        let kinds = |boxes: &[(f64, f64, Facing)]| {
            let plates: Vec<Plate> = boxes
                .iter()
                .flat_map(|&(low, high, facing)| box_faces(Vec3::splat(low), Vec3::splat(high), facing))
                .collect();
            let (low, high) =
                plates.iter().map(Plate::bounds).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap();
            turned_parts(&plates, &find_shells(&plates), low, high)
        };
        let (inward, outward) = (Facing::Inward, Facing::Outward);
        assert_eq!(kinds(&[(0.0, 4.0, outward), (1.0, 2.0, outward)]), [Some(TurnedPart::Room), None]);
        assert_eq!(kinds(&[(0.0, 4.0, inward), (1.0, 1.5, inward)]), [None, Some(TurnedPart::Solid)]);
        assert_eq!(kinds(&[(0.0, 4.0, inward), (1.0, 2.0, outward)]), [None, None]);
        // A large body beside a small one contains nothing.
        assert_eq!(kinds(&[(0.0, 4.0, outward), (4.1, 4.2, outward)]), [None, None]);
        assert_eq!(kinds(&[(0.0, 4.0, outward)]), [None]);
        // A slab that is turned inside out, of any share of the bounding box.
        let slab = box_faces(Vec3::ZERO, vec3(9.0, 9.0, 0.1), Facing::Inward);
        let found = turned_parts(&slab, &find_shells(&slab), Vec3::ZERO, vec3(9.0, 9.0, 0.1));
        assert_eq!(found, [Some(TurnedPart::Solid)]);
    }
}
