//! Suns whose direct light a viewer draws itself, with a shadow map: sharp at every distance, which light at vertices is not.
//!
//! The direct light of a separate sun at a point x with normal n is
//!
//! ```text
//!     H_dir(x) = E⊥ cosθ τ(x) e^{−D(x)}      G_dir(x) = E⊥ τ(x) e^{−D(x)}      D(x) = ∫ κ ds from x towards the sun
//! ```
//!
//! with τ = 0 behind a surface, else the transmittance of the panes towards the sun. A viewer finds τ by its shadow map. D is given at the
//! corners of the voxels, or of blocks of them where there are more than `MAX_DEPTH_NODES`, and is trilinear between them, as in pictures
//! ([`crate::lights::sun_depth_cache`]). Wide suns and suns of scenes with symmetry planes are baked with the other lights. Cost: one grid traversal
//! a node and sun.

use super::baked::{BakedSun, SunDepths, SunlightMode};
use super::group_fields::GroupField;
use crate::image::to_single_precision;
use crate::lights::WIDE_SUN_DIAMETER;
use zonal_math::Vec3;
use zonal_math::parallel;
use zonal_scene::{EvenExtension, Light, Scene, VoxelGrid};
use zonal_transport::Transport;

/// Largest number of separate suns of a scene; a viewer needs a shadow map for each.
const MAX_SEPARATE_SUNS: usize = 4;
/// Largest number of nodes of the depth along an axis, and of all: the least maximum size of 3D textures in WebGL 2, and about 3 MB.
const MAX_DEPTH_NODES: (usize, usize) = (256, 500_000);

/// For each light of the scene true where its direct light is left to the viewer.
pub(super) fn separate_suns(scene: &Scene, mode: SunlightMode) -> Vec<bool> {
    let has_symmetry_planes = !matches!(EvenExtension::of(scene), Ok(None));
    let mut left = match mode {
        SunlightMode::Separate if !has_symmetry_planes => MAX_SEPARATE_SUNS,
        _ => 0,
    };
    let is_separate = |light: &Light| {
        let narrow = light.distant_disc().is_some_and(|(_, diameter)| diameter < WIDE_SUN_DIAMETER);
        let separate = narrow && light.is_emitting(scene.surfaces()) && left > 0;
        left -= usize::from(separate);
        separate
    };
    scene.lights().iter().map(is_separate).collect()
}

/// True for a scene with suns whose direct light is left to viewers by [`SunlightMode::Separate`].
#[must_use]
pub fn has_separate_suns(scene: &Scene) -> bool {
    separate_suns(scene, SunlightMode::Separate).contains(&true)
}

/// The separate suns with their optical depths.
pub(super) fn bake_suns(
    scene: &Scene,
    transport: &Transport,
    groups: &[GroupField],
    is_separate: &[bool],
) -> Vec<BakedSun> {
    let suns = scene.lights().iter().enumerate().filter(|(l, _)| is_separate[*l]);
    let bake = |(l, light): (usize, &Light)| {
        let (direction, angular_diameter) = light.distant_disc()?;
        let group = groups.iter().position(|g| g.kind.has_light(l))?;
        Some(BakedSun {
            group: group as u32,
            towards: -direction,
            irradiance: to_single_precision(light.strength()?),
            angular_diameter,
            depths: scene.voxel_grid().and_then(|map| sun_depths(map, transport, -direction)),
        })
    };
    suns.filter_map(bake).collect()
}

/// D at the nodes of a grid; `None` where it is zero everywhere.
fn sun_depths(map: &VoxelGrid, transport: &Transport, towards: Vec3) -> Option<SunDepths> {
    let cells = map.dims();
    let dims_of = |block: usize| cells.map(|n| n.div_ceil(block) + 1);
    let (along, all) = MAX_DEPTH_NODES;
    let fits = |n: [usize; 3]| n.iter().all(|x| *x <= along) && n.iter().product::<usize>() <= all;
    let dims = (1..).map(dims_of).find(|n| fits(*n))?;
    let (low, size) = (map.min(), map.max() - map.min());
    let depth = |i: usize| {
        let at = [i / (dims[1] * dims[2]), i / dims[2] % dims[1], i % dims[2]];
        let place = |k: usize| low[k] + size[k] * (at[k] as f64 / (dims[k] - 1) as f64);
        let x = Vec3::from_array([0, 1, 2].map(place));
        to_single_precision(transport.medium_depth(x, transport.exterior_point(x, towards)))
    };
    let values: Vec<[f32; 3]> = parallel::collect(dims.iter().product(), depth);
    values.iter().flatten().any(|d| *d > 0.0).then_some(SunDepths { dims, values })
}
