//! Memory of a solve by the spectral and by the layered engine.

use crate::device::basis::BasisOrder;
use crate::engines::layered::{LayerStack, LayeredOperator};
use crate::engines::problem_size::ProblemSize;
use crate::engines::spectral::SpectralOperator;
use crate::engines::spectral::enclosure::BoxEnclosure;
use crate::errors::discretization;
use crate::right_hand_side::light_groups;
use zonal_math::parallel;
use zonal_scene::{Band, Scene, Zones};

/// True if no phase of a spectral solve of the scene needs all zones on each process.
pub(crate) fn divides_zones(scene: &Scene) -> bool {
    scene.thermal().is_none()
        && !scene.has_symmetry_planes()
        && !discretization::is_requested(scene)
        && !has_shadow_rays(scene)
}

/// True if some light is no emitting surface, whose light may follow from exchange areas.
fn has_shadow_rays(scene: &Scene) -> bool {
    scene.lights().iter().any(|l| l.surface().is_none())
}

/// Bytes of one of `ranks` processes of a spectral solve: the engine, the medium, the zones, and the larger of the iteration and the fields.
pub(crate) fn spectral_solve_bytes(
    scene: &Scene,
    zones: &Zones,
    size: &ProblemSize,
    enclosure: &BoxEnclosure,
    order: BasisOrder,
    ranks: usize,
) -> u64 {
    let kappa = enclosure.extinction_groups().1.len();
    let columns = light_groups::select_groups(scene, zones).0.len() as u64;
    let grey = kappa == 1
        && parallel::all(&zones.patches, |p| p.reflectance.is_grey() && p.emission.is_grey())
        && zones.sheets.is_empty()
        && zones
            .voxels
            .distinct_media()
            .all(|v| v.albedo.is_grey() && v.emission.is_grey() && v.source.is_grey());
    // Closure defects and targets; the roots of the weights, and of each group the sources and the four vectors of the iteration, in one band or all.
    let bands = if grey { 1 } else { Band::count() as u64 };
    let solving = 24 + 8 + 8 * bands + columns * (24 + 4 * 8 * bands);
    // Radiosity, incident, error; of each group the incident power, in an open box the strengths too, and the sum of several. With lights, direct light
    // and its error, and four vectors of its reflection, six where shadow rays draw signs; of each light the field, its error, and that of the group.
    let of_group = if enclosure.is_open() { 48 } else { 24 };
    let lights = scene.lights().len() as u64;
    let of_reflection = if has_shadow_rays(scene) { 6 } else { 4 };
    let direct = (2 + of_reflection) * 24 * u64::from(lights > 0) + 3 * 24 * lights;
    let fields = 3 * 24 + columns * of_group + 24 * u64::from(columns > 1) + direct;
    let of_openings = 24 * u64::from(enclosure.is_open());
    let [voxel, patch] = [order.voxel_components() - 1, order.patch_components() - 1].map(|n| n as u64);
    // Of each slope the vectors of the iteration, and the index of its zone.
    let solving_with_lights = solving + 2 * 24 * lights;
    // Each process has the voxels of its planes, unless a phase needs all zones.
    let divides = divides_zones(scene) && enclosure.outside.is_empty();
    let voxels = zones.voxels.total() / if divides { ranks } else { 1 };
    let own = (zones.patches.len() + voxels) as u64;
    let slopes = voxel * voxels as u64 + patch * zones.patches.len() as u64;
    let unknowns = own * (solving_with_lights.max(fields) + of_openings) + slopes * (solving + 4);
    let medium = scene.voxel_grid().map_or(0, |v| v.bytes() as u64);
    let border = 28 * (enclosure.outside.len() * zones.total()) as u64;
    SpectralOperator::bytes(&enclosure.grid, kappa, order, ranks)
        + medium
        + size.zone_bytes
        + unknowns
        + border
}

/// Bytes of a layered solve: the engine, the zones and the fields.
pub(crate) fn layered_solve_bytes(size: &ProblemSize, stack: &LayerStack) -> u64 {
    LayeredOperator::bytes(stack) + size.zone_bytes + size.field_bytes + 4 * stack.element.len() as u64
}
