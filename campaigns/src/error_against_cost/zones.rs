//! Zones of a scene: where points lie, which patches are at contacts, which are picked.

use crate::harness::zone_sampling::detector;
use zonal_math::Vec3;
use zonal_reference::path_tracer::{WalkZones, ZoneLocator};
use zonal_scene::{Patch, Plate, PlateKind, Scene, Zones};
use zonal_transport::Transport;
use zonal_transport::patch_locator::{
    FacetSide, PatchLocator, clamped_parameters, facet_side_locator, pane_piece_locator,
};

/// Locates points among the zones of a scene.
pub(crate) struct SceneLocator<'a> {
    scene: &'a Scene,
    zones: &'a Zones,
    transport: &'a Transport<'a>,
    patches: PatchLocator,
    first_pane_plate: Vec<usize>,
    pane_pieces: PatchLocator,
}

impl<'a> SceneLocator<'a> {
    /// Prepares the look-up.
    pub(crate) fn new(scene: &'a Scene, zones: &'a Zones, transport: &'a Transport<'a>) -> SceneLocator<'a> {
        let (first_pane_plate, pane_pieces) = pane_piece_locator(scene, zones);
        let patches = facet_side_locator(scene, zones);
        SceneLocator { scene, zones, transport, patches, first_pane_plate, pane_pieces }
    }

    /// The zones for walks, which go on from the point that they meet within this number of patch sizes.
    pub(crate) fn walk_zones(&self, max_continued_patch_sizes: f64) -> WalkZones<'_> {
        WalkZones {
            detectors: (0..self.zones.len()).map(|i| detector(self.scene, self.zones, i)).collect(),
            reflectances: self.zones.patches.iter().map(|p| p.reflectance).collect(),
            max_continued_patch_sizes,
            locator: self,
        }
    }
}

impl ZoneLocator for SceneLocator<'_> {
    fn on_facet(&self, facet: u32, front: bool, uv: [f64; 2]) -> Option<usize> {
        let side = if front { FacetSide::Front } else { FacetSide::Back };
        self.patches.locate(side.of_facet(facet as usize), uv).map(|i| i as usize)
    }

    fn in_medium(&self, at: Vec3) -> Option<usize> {
        let grid = self.scene.voxel_grid()?;
        let cell = [0, 1, 2].map(|k| {
            let x = ((at[k] - grid.min()[k]) / grid.cell()[k]).floor();
            x.clamp(0.0, grid.dims()[k] as f64 - 1.0) as usize
        });
        let zone = self.transport.volume_zone_at(self.zones, grid.index(cell), at)?;
        Some(self.zones.voxel_offset() + zone)
    }

    fn in_pane(&self, pane: usize, at: Vec3) -> Option<usize> {
        let outside = |plate: &Plate| {
            let [u, v] = clamped_parameters(plate, at);
            (plate.at(u, v) - at).length2()
        };
        let plates = &self.scene.panes()[pane].plates;
        let nearest =
            (0..plates.len()).min_by(|&a, &b| outside(&plates[a]).total_cmp(&outside(&plates[b])))?;
        let uv = clamped_parameters(&plates[nearest], at);
        let piece = self.pane_pieces.locate(self.first_pane_plate[pane] + nearest, uv)?;
        Some(self.zones.pane_offset() + piece as usize)
    }
}

/// Height in front of a patch, relative to its size, from which a facet counts as another body.
const MIN_RELATIVE_HEIGHT: f64 = 0.02;

/// True for a patch at a contact: another facet reaches in front of its side and comes nearer to its centre than half its size.
pub(crate) fn at_contact(scene: &Scene, patch: &Patch) -> bool {
    let (centre, size) = (patch.plate.centre(), patch.area.sqrt());
    scene.facets().iter().enumerate().filter(|(k, _)| *k != patch.facet).any(|(_, f)| {
        let (lo, hi) = f.plate.bounds();
        let outside = (lo - centre).max(centre - hi).max(Vec3::ZERO);
        if outside.length() >= 0.5 * size {
            return false;
        }
        let (corners, n) = f.plate.corners();
        let rises = corners[..n].iter().any(|c| (*c - centre).dot(patch.normal) > MIN_RELATIVE_HEIGHT * size);
        rises && distance_to_plate(&f.plate, centre) < 0.49 * size
    })
}

/// Distance of a point from a plate, m.
fn distance_to_plate(plate: &Plate, p: Vec3) -> f64 {
    let (corners, n) = plate.corners();
    let [u, v] = plate.parameters(p);
    let inside = match plate.kind {
        PlateKind::Parallelogram => u.min(v).min(1.0 - u).min(1.0 - v) >= 0.0,
        PlateKind::Triangle => u.min(v).min(1.0 - u - v) >= 0.0,
    };
    if inside {
        return (p - corners[0]).dot(plate.normal()).abs();
    }
    let to_edge = |k: usize| {
        let (a, b) = (corners[k], corners[(k + 1) % n]);
        let t = ((p - a).dot(b - a) / (b - a).length2()).clamp(0.0, 1.0);
        (a + (b - a) * t - p).length()
    };
    (0..n).map(to_edge).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::harness::zone_sampling::pick;
    use zonal_math::vec3;

    #[test]
    fn distances_to_plates() {
        let square = Plate::parallelogram(Vec3::ZERO, vec3(2.0, 0.0, 0.0), vec3(0.0, 2.0, 0.0));
        assert!((distance_to_plate(&square, vec3(1.0, 1.0, 3.0)) - 3.0).abs() < 1e-12);
        assert!((distance_to_plate(&square, vec3(5.0, 1.0, 4.0)) - 5.0).abs() < 1e-12);
        let triangle = Plate::triangle(Vec3::ZERO, vec3(2.0, 0.0, 0.0), vec3(0.0, 2.0, 0.0));
        assert!((distance_to_plate(&triangle, vec3(2.0, 2.0, 0.0)) - 2f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn picks_are_distinct_and_ascending() {
        let all = pick(10..20, 100, 1);
        assert_eq!(all, (10..20).collect::<Vec<_>>());
        let some = pick(0..1000, 50, 1);
        assert_eq!(some.len(), 50);
        assert!(some.windows(2).all(|w| w[0] < w[1]));
    }
}
