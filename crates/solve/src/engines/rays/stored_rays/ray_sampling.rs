//! Numbers of stored rays of every zone for a tolerance.
//!
//! The noise of the stored rays reaches the result only through the radiosities that a gather reads, where it averages out over many zones. It need
//! not fall as fast as the tolerance ε; a patch has
//!
//! ```text
//! m = c/ε    between min_rays_per_zone and max_rays_per_zone, and at most max_rays_in_total over all zones
//! ```
//!
//! rays, and a volume zone a fixed fraction of that; more where a realization of the noise shows that too much of it reaches the result
//! (`rays/build.rs`).

use zonal_scene::{Scene, Zones};

/// Rays of a patch, and of a volume zone.
pub(crate) type RaysPerZone = [usize; 2];

// Numbers of rays.

/// c, rays of a patch times the tolerance: up to `MAX_ZONES_FOR_ESCAPE`, and above.
const RAYS_TIMES_TOLERANCE: [f64; 2] = [10.0, 6.0];
/// Fewest rays of a patch; fewer above `COARSE_TOLERANCE`, inversely to the tolerance.
const MIN_RAYS_PER_ZONE: f64 = 32.0;
/// Tolerance above which a patch may have fewer rays.
pub(crate) const COARSE_TOLERANCE: f64 = 0.3;
/// Most rays of a patch.
const MAX_RAYS_PER_ZONE: f64 = 2048.0;
/// Rays of a volume zone over those of a patch: up to `MAX_ZONES_FOR_ESCAPE`, and above.
const VOLUME_TO_PATCH_RATIO: [f64; 2] = [0.3, 0.17];
/// Rays of a patch where no gather follows over those before a gather: their noise alone may be as large as the tolerance.
const SHARE_WITHOUT_GATHER: f64 = 0.7;
/// Most rays of all zones together: half a gigabyte without colour.
const MAX_RAYS_IN_TOTAL: f64 = 1.34e8;
/// Zones above which these rays also measure the exchange with the surroundings.
const MAX_ZONES_FOR_ESCAPE: usize = 200_000;

/// True above [`MAX_ZONES_FOR_ESCAPE`] zones.
pub(crate) fn is_large(zones: &Zones) -> bool {
    zones.len() > MAX_ZONES_FOR_ESCAPE
}

/// True where the rays of the zones measure the exchange with the surroundings: zones are many, and either nothing enters, or a gather measures again what
/// enters.
pub(crate) fn rays_measure_escape(scene: &Scene, zones: &Zones) -> bool {
    is_large(zones) && (!scene.surroundings().has_radiance() || !scene.couples_bands())
}

/// Rays of a volume zone over those of a patch.
pub(crate) fn volume_to_patch_ratio(zones: &Zones) -> f64 {
    VOLUME_TO_PATCH_RATIO[usize::from(is_large(zones))]
}

/// Numbers of rays for a tolerance, at most `max_rays` over all zones.
pub(crate) fn rays_per_zone(zones: &Zones, tolerance: f64, max_rays: f64) -> RaysPerZone {
    let least = MIN_RAYS_PER_ZONE * (COARSE_TOLERANCE / tolerance).min(1.0);
    let wanted = (RAYS_TIMES_TOLERANCE[usize::from(is_large(zones))] / tolerance).max(least);
    limited_rays(zones, wanted, max_rays)
}

/// Numbers of rays of a solution without a gather, from those of one with it.
pub(crate) fn rays_without_gather([of_patch, of_volume]: RaysPerZone) -> RaysPerZone {
    [((SHARE_WITHOUT_GATHER * of_patch as f64) as usize).max(1), of_volume]
}

/// Rays of all zones together.
pub(crate) fn total_rays(zones: &Zones, rays: RaysPerZone) -> u64 {
    (rays[0] * zones.patches.len() + rays[1] * (zones.len() - zones.patches.len())) as u64
}

/// `wanted` rays of a patch within all limits, with those of a volume zone.
fn limited_rays(zones: &Zones, wanted: f64, max_rays: f64) -> RaysPerZone {
    let (patches, volumes) = (zones.patches.len() as f64, (zones.len() - zones.patches.len()) as f64);
    let ratio = volume_to_patch_ratio(zones);
    // The number of a volume zone is rounded up: one ray for each is set aside.
    let max_rays = (max_rays - volumes).min(MAX_RAYS_IN_TOTAL);
    let fits = (max_rays / (patches + ratio * volumes).max(1.0)).min(wanted.min(MAX_RAYS_PER_ZONE));
    [fits.max(1.0) as usize, (ratio * fits).max(1.0).ceil() as usize]
}
