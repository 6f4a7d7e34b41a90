//! The images that a computation represents: as many as the tolerance needs.

use crate::bounds::Bounds;
use crate::bounds::direction_cell::DirectionCell;
use crate::geometry::Geometry;
use crate::periods::PeriodicImages;
use crate::settings::ViewFactorSettings;
use crate::sky::{SkyTraversal, direction_cells};
use rayon::prelude::*;
use zonal_scene::{Progress, SceneError};

/// Nodes of facets at which the surroundings are divided.
const MIN_SKY_NODES: usize = 512;
/// Rounds of division, at most.
const MAX_DIVISIONS: usize = 64;
/// Share of the requested absolute radius that the exchange in unresolved directions should not exceed.
const UNRESOLVED_SHARE: f64 = 1.0;

/// Images whose unresolved rays meet the tolerance, or as many as the limit of the cost allows; the occluders become those of all images.
pub(crate) fn choose_images(
    geometry: &mut Geometry,
    extent: &Bounds,
    settings: &ViewFactorSettings,
    progress: &dyn Progress,
) -> Result<PeriodicImages, SceneError> {
    let first = PeriodicImages::new(settings, extent, [false; 2]);
    let endless = geometry.endless_axes(&first);
    let mut images = PeriodicImages::new(settings, extent, endless);
    geometry.set_images(&images);
    let goal = settings.goal(geometry.facets.len());
    while images.any() {
        let Some(more) = images.doubled(endless, geometry.facets.len()) else { break };
        let cells = unresolved_cells(&images);
        let nodes = sky_nodes(geometry);
        let run = |node: &u32| {
            let idle = progress.is_interrupted();
            let traversal = SkyTraversal::new(geometry, &images, goal, settings.up);
            if idle { Vec::new() } else { traversal.run(*node, &cells) }
        };
        let found: Vec<_> = nodes.par_iter().with_max_len(1).map(run).collect();
        if progress.is_interrupted() {
            return Err(SceneError::interrupted());
        }
        let allowed =
            |f: u32| UNRESOLVED_SHARE * goal.absolute * geometry.facets[f as usize].polygon().area();
        if found.iter().flatten().all(|(f, s)| s.unresolved <= allowed(*f)) {
            break;
        }
        images = more;
        geometry.set_images(&images);
    }
    Ok(images)
}

/// The cells of directions whose rays may leave all represented images unseen.
pub(crate) fn unresolved_cells(images: &PeriodicImages) -> Vec<DirectionCell> {
    direction_cells(images).into_iter().filter(|c| images.is_unresolved(c)).collect()
}

/// Nodes of facets at which the surroundings are divided.
pub(crate) fn sky_nodes(geometry: &Geometry) -> Vec<u32> {
    let mut nodes = vec![0u32];
    for _ in 0..MAX_DIVISIONS {
        if nodes.len() >= MIN_SKY_NODES {
            break;
        }
        let children = |n: &u32| geometry.node(*n).children.map_or_else(|| vec![*n], |c| c.to_vec());
        nodes = nodes.iter().flat_map(children).collect();
    }
    nodes
}
