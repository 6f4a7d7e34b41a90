//! Numbers of rays of every zone for a tolerance.
//!
//! The error of a sampled row falls as 1/√m with m rays, so a patch has
//!
//! ```text
//! m = c/ε²    between min_rays_per_zone and max_rays_per_zone, and at most max_rays_in_total over all zones
//! ```
//!
//! rays for the tolerance ε, and a volume zone a fixed fraction of that, as smoothing averages over more neighbours in a volume.

use zonal_scene::{Scene, Zones};

/// Rays of a patch, and of a volume zone.
pub(crate) type RaysPerZone = [usize; 2];

/// Numbers of rays.
///
/// Errors and times with these values: `cargo run --release --example against_dense -- c0 c9 c8 random1 random2 demo cornell --dense 0.003` (small scenes),
/// `cargo run --release --example against_dense -- scenes/cube.toml c0 --reference spectral --size 64 --tolerances 0.1,0.03` and
/// `cargo run --release --example growth -- scenes/hall.toml --factors 1,2,4,8,16,32,64` (large scenes); tables in `docs/hierarchical.md`.
pub(crate) struct RaySamplingParams {
    /// c, rays of a patch times the square of the tolerance: with links as a second method, and above `max_zones_for_retrace`.
    pub rays_times_tolerance_squared: [f64; 2],
    /// Fewest rays of a patch.
    pub min_rays_per_zone: f64,
    /// Most rays of a patch.
    pub max_rays_per_zone: f64,
    /// Factor on the number of rays that an error estimate requires.
    pub safety_factor: f64,
    /// Rays of a volume zone over those of a patch: with links as a second method, and above `max_zones_for_retrace`, where
    /// adaptive resampling adds rays to noisy zones.
    pub volume_to_patch_ratio: [f64; 2],
    /// Most rays of all zones together. 1.34e8 rays without colour occupy half a gigabyte; a cube of 115³ voxels then just misses
    /// the tolerance 0.03 by its estimate, not by its error.
    pub max_rays_in_total: f64,
    /// Zones above which rays are traced once, are the only method, and continue from close patches. The growth example shows 280
    /// rays per zone below and 45 above at tolerance 0.1.
    pub max_zones_for_retrace: usize,
}

/// The numbers in use.
pub(crate) const RAY_SAMPLING_PARAMS: RaySamplingParams = RaySamplingParams {
    rays_times_tolerance_squared: [1.35, 1.45],
    min_rays_per_zone: 32.0,
    max_rays_per_zone: 2048.0,
    safety_factor: 1.3,
    volume_to_patch_ratio: [0.3, 0.17],
    max_rays_in_total: 1.34e8,
    max_zones_for_retrace: 200_000,
};

/// Response to a demand of more than [`RaySamplingParams::max_rays_per_zone`].
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum AboveMaximum {
    /// Keep the present number: another method takes over.
    KeepPresent,
    /// Use the maximum.
    UseMaximum,
}

/// True above [`RaySamplingParams::max_zones_for_retrace`] zones: rays are the only method and are traced once.
pub(crate) fn uses_rays_only(zones: &Zones) -> bool {
    zones.len() > RAY_SAMPLING_PARAMS.max_zones_for_retrace
}

/// True where the rays of the zones measure the exchange with the surroundings: rays are the only method, and nothing enters.
pub(crate) fn rays_measure_escape(scene: &Scene, zones: &Zones) -> bool {
    uses_rays_only(zones) && !scene.surroundings().has_radiance()
}

/// Rays of a volume zone over those of a patch.
pub(crate) fn volume_to_patch_ratio(zones: &Zones) -> f64 {
    RAY_SAMPLING_PARAMS.volume_to_patch_ratio[usize::from(uses_rays_only(zones))]
}

/// Numbers of rays for a tolerance, at most `max_rays` over all zones.
pub(crate) fn rays_per_zone(zones: &Zones, tolerance: f64, max_rays: f64) -> RaysPerZone {
    let factor = RAY_SAMPLING_PARAMS.rays_times_tolerance_squared[usize::from(uses_rays_only(zones))];
    limited_rays(zones, factor / (tolerance * tolerance), max_rays)
}

/// Numbers of rays that reduce an error by `factor`, at most `max_rays` over all zones; `present` where that is no increase.
pub(crate) fn increased_rays_per_zone(
    zones: &Zones,
    present: RaysPerZone,
    factor: f64,
    max_rays: f64,
    above_maximum: AboveMaximum,
) -> RaysPerZone {
    let safety = RAY_SAMPLING_PARAMS.safety_factor;
    let wanted = present[0] as f64 * (safety * factor * factor).max(safety);
    if wanted > RAY_SAMPLING_PARAMS.max_rays_per_zone && above_maximum == AboveMaximum::KeepPresent {
        present
    } else {
        limited_rays(zones, wanted, max_rays).max(present)
    }
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
    let fits = (max_rays / (patches + ratio * volumes).max(1.0))
        .min(wanted.clamp(p.min_rays_per_zone, p.max_rays_per_zone));
    [fits.max(1.0) as usize, (ratio * fits).max(1.0).ceil() as usize]
}
