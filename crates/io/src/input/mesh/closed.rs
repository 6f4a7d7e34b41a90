//! Which parts of a mesh are closed, and which way they look: [`zonal_scene::closed`] with corners welded on 1e-6 of the mesh's extent.

use zonal_scene::Plate;
pub(crate) use zonal_scene::closed::{Shell, Shells};

/// Corners nearer than this share of the mesh's extent are one.
const WELD: f64 = 1e-6;

/// The components of a mesh.
pub(crate) fn shells(plates: &[Plate]) -> Shells {
    Shells::find(plates, WELD)
}

/// Refuses plates that do not bound a body.
pub(crate) fn check_closed(plates: &[Plate]) -> Result<(), String> {
    let shells = shells(plates);
    let open = (0..plates.len()).filter(|i| shells.of(*i) == Shell::Open).count();
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
    use crate::input::shapes::faces;
    use zonal_math::{Vec3, vec3};

    #[test]
    fn bodies_rooms_and_open_shells_are_told_apart() {
        let outer = faces(Vec3::ZERO, Vec3::splat(4.0), true);
        let inner = faces(Vec3::ONE, Vec3::splat(2.0), false);
        let lid = Plate::triangle(vec3(9.0, 0.0, 0.0), vec3(10.0, 0.0, 0.0), vec3(9.0, 1.0, 0.0));
        let all: Vec<Plate> = outer.into_iter().chain(inner).chain([lid]).collect();
        let s = shells(&all);
        assert!((0..6).all(|i| s.of(i) == Shell::Room));
        assert!((6..12).all(|i| s.of(i) == Shell::Body));
        assert_eq!(s.of(12), Shell::Open);
        let open = |plates: &[Plate]| (0..plates.len()).all(|i| shells(plates).of(i) == Shell::Open);
        assert!(open(&inner[..5]));
        let mut turned = inner;
        turned[2] = turned[2].flipped();
        assert!(open(&turned));
    }
}
