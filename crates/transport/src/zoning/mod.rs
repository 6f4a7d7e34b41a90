//! Zoning: the cut of a scene into the pieces on which radiosity is constant.
//!
//! | module | content |
//! |---|---|
//! | `plate_subdivision` | plates subdivided to a size |
//! | `wall_splitting` | patches split along the walls that stand on them; covered patches removed |
//! | `patches` | surface zones and pane zones |
//! | `cell_overlap` | cells of the voxel grid that facets intersect |
//! | `cell_lattice` | sample lattice of a cell and its crossings with facets |
//! | `cell_parts` | free parts of a cell that facets intersect |
//! | `voxel_zones` | volume zones |
//! | `work_sharing` | zoning by several processes |
//! | `exclusions`, `left_out_medium` | surfaces and medium without zones |
//! | `coincident_surfaces` | areas that count twice |
//!
//! The result does not depend on the number of threads.

mod cell_lattice;
mod cell_overlap;
mod cell_parts;
mod coincident_surfaces;
mod exclusions;
mod left_out_medium;
mod patches;
mod plate_subdivision;
mod voxel_zones;
mod wall_splitting;
mod work_sharing;

pub use cell_overlap::{crossed_cells, crossed_subcells};
pub use exclusions::excluded_parts;
pub use work_sharing::WorkSharing;

use crate::transport::Transport;
use rayon::prelude::*;
use zonal_scene::{EvenExtension, Facet, PlateKind, Scene, SceneError, SheetSides, Sides, VoxelZones, Zones};

/// Facets whose patches are counted one after the other.
const FACETS_PER_BLOCK: usize = 4096;
/// A face longer than this fraction of the scene's diagonal counts as a wall of an enclosure.
const MIN_WALL_LENGTH_SHARE: f64 = 1e-2;
/// Smallest width of such a wall, as a fraction of the diagonal. Rays start 1e-9 of the diagonal off a zone and would pass through
/// anything nearer.
const MIN_WALL_WIDTH_SHARE: f64 = 2e-9;

/// Cuts a scene into zones.
///
/// ```
/// use zonal_math::{Vec3, vec3};
/// use zonal_scene::{Bands, Scene, SceneParts, VoxelGrid};
/// use zonal_transport::{Transport, build_zones};
///
/// let mut grid = VoxelGrid::new(Vec3::ZERO, vec3(0.5, 0.5, 1.0), [4, 4, 2]).unwrap();
/// (0..32).for_each(|cell| grid.set(cell, Bands::splat(0.1), Bands::ZERO, Bands::ZERO, Bands::ZERO));
/// let parts = SceneParts { voxel_grid: Some(grid.seal().unwrap()), ..SceneParts::default() };
/// let scene = Scene::new(parts).unwrap();
/// let zones = build_zones(&scene, &Transport::new(&scene)).unwrap();
/// assert_eq!((zones.patches.len(), zones.voxels.len()), (0, 32));
/// assert!((zones.voxels.iter().map(|v| v.volume).sum::<f64>() - 8.0).abs() < 1e-12);
/// ```
///
/// # Errors
///
/// When the patch size leads to more patches than supported, or a wall is too narrow for the scene's size.
pub fn build_zones(scene: &Scene, transport: &Transport) -> Result<Zones, SceneError> {
    build_shared_zones(scene, transport, None)
}

/// The zones of [`build_zones`], which several processes find together.
///
/// # Errors
/// As [`build_zones`], on all processes alike.
pub fn build_shared_zones(
    scene: &Scene,
    transport: &Transport,
    sharing: Option<&dyn WorkSharing>,
) -> Result<Zones, SceneError> {
    // A scene with symmetry planes has the zones of its part of the even extension, where walls and solids continue behind the symmetry planes.
    if let Some(extension) = EvenExtension::of(scene)? {
        let all =
            zones_without_symmetry_planes(&extension.scene, &Transport::new(&extension.scene), sharing)?;
        return Ok(extension.zones_of_part(&all));
    }
    zones_without_symmetry_planes(scene, transport, sharing)
}

fn zones_without_symmetry_planes(
    scene: &Scene,
    transport: &Transport,
    sharing: Option<&dyn WorkSharing>,
) -> Result<Zones, SceneError> {
    check_resolved(scene)?;
    let patches = patches::patches(scene, transport)?;
    let panes = patches::panes(scene)?;
    let voxels = match scene.voxel_grid() {
        Some(grid) => voxel_zones::voxel_zones(scene, grid, transport, sharing),
        None => VoxelZones::default(),
    };
    let sheets = SheetSides::of(scene, &patches);
    Ok(Zones { patches, voxels, panes, sheets, ..Zones::default() })
}

/// The zones of other bands: zones at the same places with the optical properties of `scene`, another block of bands of the scene that `zones` were built of.
///
/// **Cost:** linear in the number of zones, without a search for walls.
#[must_use]
pub fn zones_of_bands(scene: &Scene, zones: &Zones) -> Zones {
    let patches = patches::patches_of_bands(scene, &zones.patches);
    let panes = zones.panes.iter().map(|p| patches::pane_zone(scene, p.pane, p.plate)).collect();
    let voxels = match scene.voxel_grid() {
        Some(grid) => zones.voxels.with_media_of(grid),
        None => VoxelZones::default(),
    };
    let sheets = SheetSides::of(scene, &patches);
    Zones { patches, voxels, panes, sheets, merged: zones.merged.clone(), own_reflectances: Vec::new() }
}

/// Patches that a surface is expected to have.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExpectedPatches {
    /// Their number.
    pub patches: f64,
    /// Their area together, m².
    pub area: f64,
}

/// Expected patches of each surface of a scene for a size in metres: their number is exact to a factor of two, without the cuts along walls.
#[must_use]
pub fn expected_patches_of_surfaces(scene: &Scene, size: f64) -> Vec<ExpectedPatches> {
    let mut out = vec![ExpectedPatches::default(); scene.surfaces().len()];
    let rule = scene.options().patch_rule;
    for f in scene.facets() {
        let (sides, own) = (sides_of(scene, f), &mut out[f.surface]);
        own.patches += sides * plate_subdivision::estimate_count(&f.plate, size, rule);
        own.area += sides * f.plate.area();
    }
    out
}

/// Number of patches of a size in metres that the area of a scene has: faces smaller than a patch count by their area, so that the number does not depend on
/// how finely a part is meshed.
#[must_use]
pub fn patches_of_area(scene: &Scene, size: f64) -> f64 {
    let rule = scene.options().patch_rule;
    let of_facet = |f: &Facet| sides_of(scene, f) * plate_subdivision::count_by_area(&f.plate, size, rule);
    // Sums of blocks, so that the result is the same for any number of threads.
    let blocks = scene.facets().par_chunks(FACETS_PER_BLOCK);
    blocks.map(|b| b.iter().map(of_facet).sum::<f64>()).collect::<Vec<_>>().into_iter().sum()
}

/// Number of sides of a facet that exchange.
fn sides_of(scene: &Scene, f: &Facet) -> f64 {
    let s = &scene.surfaces()[f.surface];
    if s.sides == Sides::Both && !s.solid { 2.0 } else { 1.0 }
}

/// Refuses enclosures so thin that rays leave them: long rectangles of too small a width. Exempt are periodic scenes, whose enclosure
/// has no end, and solids, whose narrow faces have no enclosure in front.
fn check_resolved(scene: &Scene) -> Result<(), SceneError> {
    let size = scene.diagonal();
    for f in scene.facets() {
        let s = &scene.surfaces()[f.surface];
        let length = f.plate.e1.length().max(f.plate.e2.length());
        let width = f.plate.area() / length;
        let wall =
            f.plate.kind == PlateKind::Parallelogram && !s.solid && length > MIN_WALL_LENGTH_SHARE * size;
        if wall && width < MIN_WALL_WIDTH_SHARE * size && scene.periodic() == [false; 3] {
            let key = format!("surface '{}'", s.name);
            let what = format!(
                "a face is {length:.3e} m long and {width:.3e} m wide, too narrow for a scene of {size:.3e} m, whose rays start {:.1e} m off; reduce the extent of the scene, or make it periodic",
                0.5 * MIN_WALL_WIDTH_SHARE * size
            );
            return Err(SceneError::new(key, what));
        }
    }
    Ok(())
}
