//! Rays from zones with the density of the exchange kernel, and their transmittance out of the scene.
//!
//! Origins and directions follow one scrambled Sobol sequence in five dimensions: directions are cosine-distributed on a patch, uniform in
//! a voxel, cosine-distributed on either side of a pane. The mean weight of the rays of a zone is 1, apart from the absorptance of a pane.

use zonal_math::direction_sampling::{cosine_hemisphere, uniform_sphere};
use zonal_math::{Vec3, low_discrepancy, scrambled_sobol};
use zonal_scene::{Bands, PaneZone, Plate, Sides, ZoneRef, Zones};
use zonal_transport::{Hit, Transport};

/// Distance from its origin at which a ray begins to intersect, over the diagonal of the scene.
const RAY_OFFSET: f64 = 1e-9;
/// Random points of a sub-cell that are tried.
const MAX_TRIALS: u64 = 100;

/// A ray of a zone.
#[derive(Clone, Copy)]
pub(crate) struct WeightedRay {
    /// A point of the zone, m.
    pub origin: Vec3,
    /// Unit direction.
    pub dir: Vec3,
    /// Its weight in the mean over the rays of the zone.
    pub weight: Bands,
}

/// The random numbers of a ray: a point of the unit cube for its origin, one of the unit square for its direction.
#[derive(Clone, Copy)]
pub(crate) struct ZoneRaySample {
    pub origin: [f64; 3],
    pub direction: [f64; 2],
}

/// Part of a ray that no zone receives.
pub(crate) struct LostRay {
    /// Transmittance to the end of the ray; 0 if it ends in a zone.
    pub share: Bands,
    /// True if the ray ends on a facet side without zones, such as a black back.
    pub on_back: bool,
}

/// The part of a ray that leaves the scene or ends on a black back.
pub(crate) fn escape_transmittance(transport: &Transport, origin: Vec3, dir: Vec3) -> LostRay {
    let scene = transport.scene();
    let is_black_back =
        |hit: &Hit| !hit.front && scene.surfaces()[scene.facets()[hit.facet].surface].sides == Sides::Front;
    lost_transmittance(transport, origin, dir, &is_black_back)
}

/// The part of a ray that leaves the scene or ends on a facet side without zones.
pub(crate) fn lost_transmittance(
    transport: &Transport,
    origin: Vec3,
    dir: Vec3,
    is_without_zones: &dyn Fn(&Hit) -> bool,
) -> LostRay {
    let scene = transport.scene();
    let reach = 2.0 * scene.diagonal() + (origin - scene.bounds().0).length();
    let share = |length: f64| transport.optical_depth(origin, origin + dir * length).map(|d| (-d).exp());
    match transport.closest_hit(origin, dir, RAY_OFFSET * scene.diagonal(), reach) {
        None => LostRay { share: share(reach), on_back: false },
        Some(hit) if is_without_zones(&hit) => LostRay { share: share(hit.t), on_back: true },
        Some(_) => LostRay { share: Bands::ZERO, on_back: false },
    }
}

/// The `k`-th ray of zone `i`.
pub(crate) fn zone_ray(zones: &Zones, transport: &Transport, i: usize, seed: u64, k: usize) -> WeightedRay {
    ray_from_sample(zones, transport, i, sample_point(zones, i, seed, k))
}

/// The `k`-th sample of zone `i`.
pub(crate) fn sample_point(zones: &Zones, i: usize, seed: u64, k: usize) -> ZoneRaySample {
    sample_of_sequence(zones, i, low_discrepancy::split_mix64(i as u64) ^ seed, k)
}

/// As [`sample_point`], of a sequence. Origins on a patch have two dimensions, and 0 for the third.
pub(crate) fn sample_of_sequence(zones: &Zones, i: usize, sequence: u64, k: usize) -> ZoneRaySample {
    if i < zones.patches.len() {
        let [d0, d1, p0, p1] = scrambled_sobol::first_dimensions_of_blocks(k, sequence);
        return ZoneRaySample { origin: [p0, p1, 0.0], direction: [d0, d1] };
    }
    let [d0, d1, p0, p1, p2, ..] = scrambled_sobol::point_of_blocks(k, sequence);
    ZoneRaySample { origin: [p0, p1, p2], direction: [d0, d1] }
}

/// The ray of zone `i` of these random numbers.
pub(crate) fn ray_from_sample(
    zones: &Zones,
    transport: &Transport,
    i: usize,
    sample: ZoneRaySample,
) -> WeightedRay {
    let origin = point_in_zone(zones, transport, i, sample.origin);
    ray_from_point(zones, i, origin, sample.origin[2], sample.direction)
}

/// The ray of zone `i` from the point `origin` in the direction of the point `d` of the unit square; of a pane on one side where `side` is below 1/2.
pub(crate) fn ray_from_point(zones: &Zones, i: usize, origin: Vec3, side: f64, d: [f64; 2]) -> WeightedRay {
    let (dir, weight) = match zones.zone(i) {
        ZoneRef::Patch(p) => (cosine_hemisphere(p.normal, d), Bands::ONE),
        ZoneRef::Voxel(..) => (uniform_sphere(d), Bands::ONE),
        ZoneRef::Pane(_, z) => {
            // Cosine-distributed, on one of the two sides.
            let w = cosine_hemisphere(if side < 0.5 { z.normal } else { -z.normal }, d);
            (w, pane_ray_weight(z, w))
        }
    };
    WeightedRay { origin, dir, weight }
}

/// The point of zone `i` for the point `p` of the unit cube, uniform over the zone.
pub(crate) fn point_in_zone(zones: &Zones, transport: &Transport, i: usize, p: [f64; 3]) -> Vec3 {
    let on = |plate: &Plate| {
        let [u, v] = plate.warp([p[0], p[1]]);
        plate.at(u, v)
    };
    match zones.zone(i) {
        ZoneRef::Patch(z) => on(&z.plate),
        ZoneRef::Voxel(k, _) => voxel_point(transport, zones, k, p),
        ZoneRef::Pane(_, z) => on(&z.plate),
    }
}

/// Weight of a cosine-distributed ray of a pane: 2 A ⟨(1 − e^{−κt/c})/κ⟩ with c the cosine, relative to 4 A t.
pub(crate) fn pane_ray_weight(z: &PaneZone, dir: Vec3) -> Bands {
    z.effective_path(dir) / (2.0 * z.thickness)
}

/// A point of voxel zone `i`, an index into `zones.voxels`, uniform over it.
///
/// A zone that walls cut has one stored point for each of its sub-cells; the points of the sub-cell that see it belong to the zone, where no other zone of the cell
/// holds them. A random one replaces the stored point, whose own radiation may be another where the part is narrow, such as between a beam and the edge of the
/// medium. The stored point remains where no trial finds one.
pub(crate) fn voxel_point(transport: &Transport, zones: &Zones, i: usize, u: [f64; 3]) -> Vec3 {
    let z = zones.voxels.at(i);
    let Some((stored, [lo, edges])) = z.samples.sample_at(u[0]) else {
        let cell = transport.scene().voxel_grid().map_or(Vec3::ZERO, |grid| grid.cell());
        return z.centre + cell.scale(Vec3::from_array(u) - Vec3::splat(0.5));
    };
    let seed = u[0].to_bits() ^ u[1].to_bits().rotate_left(21) ^ u[2].to_bits().rotate_left(42);
    let random = |k: u64| low_discrepancy::hash_to_unit(seed.wrapping_add(k));
    let trial = |t: u64| match t {
        0 => [random(0), u[1], u[2]],
        _ => [0, 1, 2].map(|k| random(3 * t + k)),
    };
    let is_inside =
        |x: Vec3| !transport.occluded_inside(stored, x) && transport.volume_zone_holds(zones, i, stored, x);
    let mut points = (0..MAX_TRIALS).map(|t| lo + edges.scale(Vec3::from_array(trial(t))));
    points.find(|x| is_inside(*x)).unwrap_or(stored)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_transport::build_zones;

    /// A room of one voxel that a sheet divides 7 cm before a wall.
    const DIVIDED: &str = "name = \"divided\"\n[solve]\npatch_size = 1\n\
        [[surface]]\nname = \"room\"\nroom = { min = [0, 0, 0], max = [2, 2, 2] }\n\
        [[surface]]\nname = \"sheet\"\nrectangle = { origin = [1.93, 0, 0], edge1 = [0, 2, 0], edge2 = [0, 0, 2] }\nsides = \"both\"\n\
        [medium]\nmin = [0, 0, 0]\nmax = [2, 2, 2]\ncells = [1, 1, 1]\nextinction = 0.2\nalbedo = 0.5\n";

    #[test]
    fn points_are_uniform_over_the_parts_of_a_divided_voxel() {
        let scene = zonal_io::input::parse_scene(DIVIDED, None, "divided").unwrap();
        let transport = Transport::new(&scene);
        let zones = build_zones(&scene, &transport).unwrap();
        assert_eq!(zones.voxels.len(), 2);
        for z in 0..2 {
            let (lo, hi) = if zones.voxels.at(z).centre.x < 1.93 { (0.0, 1.93) } else { (1.93, 2.0) };
            let n = 4000;
            let x: Vec<f64> = (0..n)
                .map(|k| voxel_point(&transport, &zones, z, low_discrepancy::r3(k, [0.3, 0.1, 0.7])).x)
                .collect();
            assert!(x.iter().all(|x| (lo..hi).contains(x)));
            let mean = x.iter().sum::<f64>() / n as f64;
            let variance = x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n as f64;
            let of_uniform = (hi - lo) / 12f64.sqrt();
            assert!((mean - 0.5 * (lo + hi)).abs() < 0.05 * (hi - lo), "{mean} between {lo} and {hi}");
            assert!((variance.sqrt() / of_uniform - 1.0).abs() < 0.05, "{} {of_uniform}", variance.sqrt());
        }
    }

    /// A lamp across a quarter of the voxel, 7 mm above its lower face.
    const LAYER: &str = "name = \"layer\"\n[solve]\npatch_size = 1\n\
        [[surface]]\nname = \"room\"\nroom = { min = [0, 0, 0], max = [0.6, 0.5, 0.4] }\n\
        [[surface]]\nname = \"lamp\"\nrectangle = { origin = [0.141, 0.1691, 0.007], edge1 = [0, 0.287, 0], edge2 = [0.3, 0, 0] }\n\
        sides = \"both\"\n\
        [medium]\nmin = [0, 0, 0]\nmax = [0.6, 0.5, 0.4]\ncells = [2, 1, 1]\nextinction = 0.4\nalbedo = 0\n";

    #[test]
    fn a_layer_behind_a_wall_ends_at_the_edge_of_the_wall() {
        let scene = zonal_io::input::parse_scene(LAYER, None, "layer").unwrap();
        let transport = Transport::new(&scene);
        let zones = build_zones(&scene, &transport).unwrap();
        let layers: Vec<usize> =
            (0..zones.voxels.len()).filter(|z| zones.voxels.at(*z).volume < 1e-3).collect();
        assert!(!layers.is_empty() && layers.len() < zones.voxels.len());
        let is_behind =
            |x: Vec3| x.z < 0.007 && (0.141..0.441).contains(&x.x) && (0.1691..0.4561).contains(&x.y);
        for &z in &layers {
            let n = 2000;
            let point =
                |k: usize| voxel_point(&transport, &zones, z, low_discrepancy::r3(k, [0.3, 0.1, 0.7]));
            let outside = (0..n).filter(|k| !is_behind(point(*k))).count();
            assert!(outside * 100 < n, "{outside} of {n} points beside the lamp");
            assert!(
                (0..n)
                    .all(|k| transport.volume_zone_at(&zones, zones.voxels.at(z).cell, point(k)) == Some(z))
            );
        }
    }
}
