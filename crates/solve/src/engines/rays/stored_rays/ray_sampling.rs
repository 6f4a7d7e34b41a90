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

/// Numbers of rays.
pub(crate) struct RaySamplingParams {
    /// c, rays of a patch times the tolerance: up to `max_zones_for_escape`, and above.
    pub rays_times_tolerance: [f64; 2],
    /// Fewest rays of a patch; fewer above `coarse_tolerance`, inversely to the tolerance.
    pub min_rays_per_zone: f64,
    /// Tolerance above which a patch may have fewer rays.
    pub coarse_tolerance: f64,
    /// Most rays of a patch.
    pub max_rays_per_zone: f64,
    /// Rays of a volume zone over those of a patch: up to `max_zones_for_escape`, and above.
    pub volume_to_patch_ratio: [f64; 2],
    /// Rays of a patch where no gather follows over those before a gather: their noise alone may be as large as the tolerance.
    pub share_without_gather: f64,
    /// Most rays of all zones together: half a gigabyte without colour.
    pub max_rays_in_total: f64,
    /// Zones above which these rays also measure the exchange with the surroundings.
    pub max_zones_for_escape: usize,
}

/// The numbers in use.
pub(crate) const RAY_SAMPLING_PARAMS: RaySamplingParams = RaySamplingParams {
    rays_times_tolerance: [10.0, 6.0],
    min_rays_per_zone: 32.0,
    coarse_tolerance: 0.3,
    max_rays_per_zone: 2048.0,
    volume_to_patch_ratio: [0.3, 0.17],
    share_without_gather: 0.7,
    max_rays_in_total: 1.34e8,
    max_zones_for_escape: 200_000,
};

/// True above [`RaySamplingParams::max_zones_for_escape`] zones.
pub(crate) fn is_large(zones: &Zones) -> bool {
    zones.len() > RAY_SAMPLING_PARAMS.max_zones_for_escape
}

/// True where the rays of the zones measure the exchange with the surroundings: zones are many, and either nothing enters, or a gather measures again what
/// enters.
pub(crate) fn rays_measure_escape(scene: &Scene, zones: &Zones) -> bool {
    is_large(zones) && (!scene.surroundings().has_radiance() || !scene.couples_bands())
}

/// Rays of a volume zone over those of a patch.
pub(crate) fn volume_to_patch_ratio(zones: &Zones) -> f64 {
    RAY_SAMPLING_PARAMS.volume_to_patch_ratio[usize::from(is_large(zones))]
}

/// Numbers of rays for a tolerance, at most `max_rays` over all zones.
pub(crate) fn rays_per_zone(zones: &Zones, tolerance: f64, max_rays: f64) -> RaysPerZone {
    let p = &RAY_SAMPLING_PARAMS;
    let least = p.min_rays_per_zone * (p.coarse_tolerance / tolerance).min(1.0);
    let wanted = (p.rays_times_tolerance[usize::from(is_large(zones))] / tolerance).max(least);
    limited_rays(zones, wanted, max_rays)
}

/// Numbers of rays of a solution without a gather, from those of one with it.
pub(crate) fn rays_without_gather([of_patch, of_volume]: RaysPerZone) -> RaysPerZone {
    [((RAY_SAMPLING_PARAMS.share_without_gather * of_patch as f64) as usize).max(1), of_volume]
}

/// Rays of all zones together.
pub(crate) fn total_rays(zones: &Zones, rays: RaysPerZone) -> u64 {
    (rays[0] * zones.voxel_offset() + rays[1] * (zones.len() - zones.voxel_offset())) as u64
}

/// `wanted` rays of a patch within all limits, with those of a volume zone.
fn limited_rays(zones: &Zones, wanted: f64, max_rays: f64) -> RaysPerZone {
    let (patches, volumes) = (zones.voxel_offset() as f64, (zones.len() - zones.voxel_offset()) as f64);
    let (p, ratio) = (&RAY_SAMPLING_PARAMS, volume_to_patch_ratio(zones));
    // The number of a volume zone is rounded up: one ray for each is set aside.
    let max_rays = (max_rays - volumes).min(p.max_rays_in_total);
    let fits = (max_rays / (patches + ratio * volumes).max(1.0)).min(wanted.min(p.max_rays_per_zone));
    [fits.max(1.0) as usize, (ratio * fits).max(1.0).ceil() as usize]
}
