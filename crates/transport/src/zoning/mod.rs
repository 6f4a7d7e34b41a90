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

pub use left_out::{LeftOut, left_out};
pub use patches::MAX_PATCHES;

use crate::Transport;
use zonal_scene::{Scene, SceneError, Zones};

/// Cuts a scene into zones; fails when the wanted patch size makes too many.
pub fn build_zones(scene: &Scene, transport: &Transport) -> Result<Zones, SceneError> {
    let patches = patches::patches(scene, transport)?;
    let panes = patches::panes(scene)?;
    let (voxels, first) = match scene.voxmap() {
        Some(map) => voxels::voxels(scene, map, transport),
        None => Default::default(),
    };
    Ok(Zones { patches, voxels, panes, first })
}
