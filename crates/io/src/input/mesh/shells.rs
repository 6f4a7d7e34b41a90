//! Closed parts of a mesh and their orientation: [`zonal_scene::shells`] with welded corners.

use zonal_scene::Plate;
use zonal_scene::shells::WELD_TOLERANCE;
pub(crate) use zonal_scene::shells::{ShellKind, Shells};

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
}
