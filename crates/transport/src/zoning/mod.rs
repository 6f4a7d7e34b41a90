//! Zones: the pieces on which radiosity is taken as constant.
//!
//! | module | what |
//! |---|---|
//! | `cut` | plates cut to the wanted size |
//! | `split` | patches cut along the walls that stand on them; covered ones left out |
//! | `patches` | surface and pane zones |
//! | `overlap` | which facets pass through which cells |
//! | `cells` | the free parts of a cell that facets pass through |
//! | `voxels` | the volume zones |
//! | `left_out` | what has no zones: refused, or told |
//!
//! The result is the same for any number of threads.

mod cells;
mod cut;
mod left_out;
mod overlap;
mod patches;
mod split;
mod voxels;

pub use left_out::left_out;
pub use patches::MAX_PATCHES;

use crate::Transport;
use zonal_scene::{PlateKind, Scene, SceneError, Zones};

/// A face that is as long as this share of the scene's diagonal is a wall, not a detail.
const LONG: f64 = 1e-2;
/// The least width of such a wall over the diagonal: rays leave a zone after 1e-9 of it, and would pass through what is nearer.
const NARROWEST: f64 = 2e-9;

/// Cuts a scene into zones; fails when the wanted patch size makes too many.
pub fn build_zones(scene: &Scene, transport: &Transport) -> Result<Zones, SceneError> {
    check_resolved(scene)?;
    let patches = patches::patches(scene, transport)?;
    let panes = patches::panes(scene)?;
    let (voxels, first) = match scene.voxmap() {
        Some(map) => voxels::voxels(scene, map, transport),
        None => Default::default(),
    };
    Ok(Zones { patches, voxels, panes, first })
}

/// Refuses enclosures so thin that rays leave them: rectangles across much of the scene that are too narrow. A periodic scene's
/// enclosure ends nowhere, and a solid's narrow face has nothing before it.
fn check_resolved(scene: &Scene) -> Result<(), SceneError> {
    let size = scene.diagonal();
    for f in scene.facets() {
        let s = &scene.surfaces()[f.surface];
        let long = f.plate.e1.length().max(f.plate.e2.length());
        let narrow = f.plate.area() / long;
        let wall = f.plate.kind == PlateKind::Parallelogram && !s.solid && long > LONG * size;
        if wall && narrow < NARROWEST * size && scene.periodic() == [false; 3] {
            let key = format!("surface '{}'", s.name);
            let what = format!(
                "a face is {long:.3e} m long and {narrow:.3e} m wide, too narrow for a scene of {size:.3e} m, whose rays start {:.1e} m off; cut the scene down to what matters, or make it periodic",
                0.5 * NARROWEST * size
            );
            return Err(SceneError::new(key, what));
        }
    }
    Ok(())
}
