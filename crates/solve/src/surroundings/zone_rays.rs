//! Rays from zones with the density of the exchange kernel, and their transmittance out of the scene.
//!
//! Origins follow a low-discrepancy R₃ sequence over the zone, directions a scrambled Sobol sequence: cosine-distributed on a patch, uniform in
//! a voxel, cosine-distributed on either side of a pane. The mean weight of the rays of a zone is 1, apart from the absorptance of a pane.

use zonal_math::direction_sampling::{cosine_hemisphere, uniform_sphere};
use zonal_math::{Vec3, low_discrepancy};
use zonal_scene::{Bands, PaneZone, Plate, Scene, Sides, VoxelZone, Zones};
use zonal_transport::{Hit, Transport};

/// Distance from its origin at which a ray begins to intersect, over the diagonal of the scene.
const RAY_OFFSET: f64 = 1e-9;

/// Origin, unit direction and weight of a ray.
pub(crate) type WeightedRay = (Vec3, Vec3, Bands);

/// Transmittance of a ray that leaves the scene, or that ends on a black back (`true`); zero if it ends on a zone.
pub(crate) fn escape_transmittance(
    scene: &Scene,
    transport: &Transport,
    origin: Vec3,
    dir: Vec3,
) -> (Bands, bool) {
    let is_black_back =
        |hit: &Hit| !hit.front && scene.surfaces()[scene.facets()[hit.facet].surface].sides == Sides::Front;
    lost_transmittance((scene, transport), (origin, dir), &is_black_back)
}

/// Transmittance of a ray out of the scene, or up to a facet side without zones, for which the second value is `true`; 0 for a ray that ends in a zone.
pub(crate) fn lost_transmittance(
    (scene, transport): (&Scene, &Transport),
    (origin, dir): (Vec3, Vec3),
    is_without_zones: &dyn Fn(&Hit) -> bool,
) -> (Bands, bool) {
    let reach = 2.0 * scene.diagonal() + (origin - scene.bounds().0).length();
    let eps = RAY_OFFSET * scene.diagonal();
    match transport.closest_hit(origin, dir, eps, reach) {
        None => (transport.optical_depth(origin, origin + dir * reach).map(|d| (-d).exp()), false),
        Some(hit) if is_without_zones(&hit) => {
            (transport.optical_depth(origin, origin + dir * hit.t).map(|d| (-d).exp()), true)
        }
        Some(_) => (Bands::ZERO, false),
    }
}

/// The `k`-th ray of zone `i`; `cell` holds the edges of a voxel, m.
pub(crate) fn zone_ray(zones: &Zones, cell: Vec3, (i, seed): (usize, u64), k: usize) -> WeightedRay {
    let (p, d) = sample_point(i, seed, k);
    ray_from_sample(zones, cell, i, p, d)
}

/// The `k`-th sample of zone `i`: a point of the unit cube for the origin, one of the unit square for the direction.
pub(crate) fn sample_point(i: usize, seed: u64, k: usize) -> ([f64; 3], [f64; 2]) {
    let hash = |m: u64| low_discrepancy::split_mix64((i as u64 * 8 + m) ^ seed);
    let shift = [0, 1, 2].map(|m| low_discrepancy::hash_to_unit((i as u64 * 8 + m) ^ seed));
    // Two R sequences would be correlated over thousands of rays, hence a Sobol sequence for the directions.
    (low_discrepancy::r3(k, shift), low_discrepancy::sobol_2d(k as u32, [hash(3) as u32, hash(4) as u32]))
}

/// The ray of zone `i` whose origin is the point `p` of the unit cube and whose direction is the point `d` of the unit square.
pub(crate) fn ray_from_sample(zones: &Zones, cell: Vec3, i: usize, p: [f64; 3], d: [f64; 2]) -> WeightedRay {
    let origin = point_in_zone(zones, cell, i, p);
    if i < zones.voxel_offset() {
        return (origin, cosine_hemisphere(zones.patches[i].normal, d), Bands::ONE);
    }
    if i >= zones.pane_offset() {
        let z = &zones.panes[i - zones.pane_offset()];
        // Cosine-distributed, on one of the two sides.
        let w = cosine_hemisphere(if p[2] < 0.5 { z.normal } else { -z.normal }, d);
        return (origin, w, pane_ray_weight(z, w));
    }
    (origin, uniform_sphere(d), Bands::ONE)
}

/// The point of zone `i` for the point `p` of the unit cube, uniform over the zone.
pub(crate) fn point_in_zone(zones: &Zones, cell: Vec3, i: usize, p: [f64; 3]) -> Vec3 {
    let on = |plate: &Plate| {
        let [u, v] = plate.warp([p[0], p[1]]);
        plate.at(u, v)
    };
    if i < zones.voxel_offset() {
        return on(&zones.patches[i].plate);
    }
    match i.checked_sub(zones.pane_offset()) {
        Some(k) => on(&zones.panes[k].plate),
        None => voxel_point(zones.voxels.at(i - zones.voxel_offset()), cell, p),
    }
}

/// Weight of a cosine-distributed ray of a pane: 2 A ⟨(1 − e^{−κt/c})/κ⟩ with c the cosine, relative to 4 A t.
pub(crate) fn pane_ray_weight(z: &PaneZone, dir: Vec3) -> Bands {
    z.effective_path(dir) / (2.0 * z.thickness)
}

/// A point of a voxel zone with cell edges `cell`: uniform in a whole voxel, one of the stored samples of a cut one.
pub(crate) fn voxel_point(z: VoxelZone, cell: Vec3, u: [f64; 3]) -> Vec3 {
    let whole = || z.centre + cell.scale(Vec3::from_array(u) - Vec3::splat(0.5));
    z.samples.point_at(u[0]).unwrap_or_else(whole)
}
