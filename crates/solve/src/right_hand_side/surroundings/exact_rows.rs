//! Rays to the surroundings where they are needed: after the exchange areas are known.
//!
//! The loss of a zone is its closure target less its exchange with all other zones. Where the error of that sum is far below what rays reach, rays are superfluous:
//! a few pilot rays of every zone show that the scene is open, and the restoration of closure gives the rest of an exact row to its loss. All rays are traced
//! by the other zones, and by those that may see the black back of a one-sided surface, since rays divide a loss between backs and surroundings.

use super::stage;
use super::surroundings_exchange::SurroundingsExchange;
use crate::operator::AdjustableExchange;
use crate::settings::SolveSettings;
use zonal_exchange::pair::{PairSettings, StripImages, closure_target, scaled_radiosity_coefficient};
use zonal_math::parallel;
use zonal_math::{Vec3, vec3};
use zonal_scene::{Bands, Plate, Scene, Sides, ZoneRef, Zones};
use zonal_transport::Transport;

/// Error of the sum of an exact row, over its loss and the tolerance.
const ERROR_OVER_TOLERANCE: f64 = 0.1;
/// The same over the closure target, below which it does not matter.
const NEGLIGIBLE_ERROR: f64 = 1e-9;
/// Bound of the error of a sum in multiples of the standard error.
const ERROR_MULTIPLE: f64 = 3.0;
/// One-sided facets for which the zones behind them are determined; with more, all zones may see a back.
const MAX_FACETS: usize = 1000;
/// Height below the plane of a facet up to which a point counts as in the plane, over the diagonal of the scene.
const IN_PLANE_HEIGHT: f64 = 1e-9;

/// Whether the dense engine restores the closure of its rows: as the scene sets, else yes unless formulas of the paper, whose defects are kept for comparison, replace exact factors.
pub(crate) fn are_restored(scene: &Scene, settings: &PairSettings) -> bool {
    scene.restores_rows() && (scene.options().restore_closure.is_some() || settings.volume_factors.is_none())
}

/// True if the dense engine traces pilot rays alone before it knows the exchange areas: where rows are restored, but not on an even extension, whose images
/// share their rays.
pub(crate) fn are_known_later(scene: &Scene, zones: &Zones, settings: &PairSettings) -> bool {
    are_restored(scene, settings) && StripImages::of(scene, zones).is_none()
}

/// Completes the exchange with the surroundings, of which pilot rays are known, by the rays of all zones that need them.
pub(crate) fn complete(
    operator: &dyn AdjustableExchange,
    zones: &Zones,
    transport: &Transport,
    pilot: SurroundingsExchange,
    settings: &SolveSettings,
) -> SurroundingsExchange {
    if pilot.is_closed() {
        return pilot;
    }
    let (scene, n) = (transport.scene(), zones.len());
    let squares: Vec<Bands> = (0..n).map(|i| scaled_radiosity_coefficient(zones, i).map(|c| c * c)).collect();
    let variance = operator.variance_product(&squares);
    let tolerance = ERROR_OVER_TOLERANCE * scene.options().tolerance;
    let is_exact = |i: usize| {
        let admissible =
            (pilot.total_of(i) * tolerance).map(|e| e.max(NEGLIGIBLE_ERROR * closure_target(zones, i)));
        variance[i].zip_map(admissible, |v, e| e - ERROR_MULTIPLE * v.sqrt()).all(|room| room >= 0.0)
    };
    let backs = one_sided_facets(scene);
    let slack = IN_PLANE_HEIGHT * scene.diagonal();
    let may_see_back = |i: usize| match &backs {
        Some(list) => list.iter().any(|p| reaches_behind(scene, zones, i, p, slack)),
        None => true,
    };
    let needs: Vec<bool> = parallel::collect(n, |i| !is_exact(i) || may_see_back(i));
    if !needs.contains(&true) {
        return pilot;
    }
    stage::measure_zones(zones, transport, Some(&needs), settings)
}

/// The plates of all one-sided facets; `None` if they are many.
fn one_sided_facets(scene: &Scene) -> Option<Vec<Plate>> {
    let facets = scene.facets().iter().filter(|f| scene.surfaces()[f.surface].sides == Sides::Front);
    let plates: Vec<Plate> = facets.map(|f| f.plate).take(MAX_FACETS + 1).collect();
    (plates.len() <= MAX_FACETS).then_some(plates)
}

/// True if a part of zone `i` lies behind the plane of a plate.
fn reaches_behind(scene: &Scene, zones: &Zones, i: usize, plate: &Plate, slack: f64) -> bool {
    let (n, origin) = (plate.normal(), plate.origin);
    let is_behind = |p: Vec3| n.dot(p - origin) < -slack;
    let any_corner = |own: &Plate| {
        let (corners, count) = own.corners();
        corners[..count].iter().any(|p| is_behind(*p))
    };
    let cell = match zones.zone(i) {
        ZoneRef::Patch(p) => return any_corner(&p.plate),
        ZoneRef::Voxel(_, v) => v.cell,
        ZoneRef::Pane(_, p) => return any_corner(&p.plate),
    };
    let Some(grid) = scene.voxel_grid() else { return true };
    let lo = grid.corner(grid.coordinates(cell));
    let hi = lo + grid.cell();
    let pick = |n: f64, l: f64, h: f64| if n > 0.0 { l } else { h };
    is_behind(vec3(pick(n.x, lo.x, hi.x), pick(n.y, lo.y, hi.y), pick(n.z, lo.z, hi.z)))
}
