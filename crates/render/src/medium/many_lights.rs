//! In-scattered light of emitters of many facets: candles, chandeliers, lit meshes.
//!
//! Far from a cluster of facets its light hardly varies from voxel to voxel; beside it, it falls as 1/r². The fluence is split by a window w
//! that falls from 1 at the cluster to 0 at the distance R of two voxels:
//!
//! ```text
//! G = Σ_c V_c I_c w(r)/r²  +  Σ_c V_c I_c (1 − w(r))/r²        w = (1 − r²/R²)²
//! ```
//!
//! The second, far part is bounded and smooth. It is gathered at the centre of every voxel that a ray needs, by shadow rays to clusters
//! sampled by their estimated contribution (light tree), and interpolated with the indirect light ([`super::radiosity_field`]). The first,
//! near part is integrated along each ray in closed form: with d the distance of the ray from the cluster, softened by a third of its
//! radius, and s the distance along the ray from the foot of the perpendicular,
//!
//! ```text
//! ∫ w/r² ds = atan(s/d)/d − 2 s/R² + (d² s + s³/3)/R⁴
//! ```
//!
//! in each voxel that sees the cluster from its centre, so that no light passes walls. Where clusters are large beside voxels, w is 0.
//! A voxel without a cluster nearby has no near part; there the solution's own G of the emitter serves, where it keeps the light
//! apart. Cost: up to 16 shadow rays a voxel and emitter, and the near clusters of each segment of a ray.

use super::ray_path::VoxelSegment;
use crate::lights::shadow_ray::trace_shadow_ray;
use crate::view_ray::ViewRay;
use std::f64::consts::PI;
use zonal_math::parallel;
use zonal_math::{Vec3, low_discrepancy};
use zonal_scene::{Band, Bands, LightGroup, Solution};
use zonal_transport::Transport;
use zonal_transport::lights::{LightSampler, Receiver};

// Split and sampling of the light of many facets.

/// Largest number of shadow rays of a voxel to an emitter.
const MAX_SHADOW_RAYS: usize = 16;
/// Share of B above which an emitter has all shadow rays; below, their number is proportional to its share.
const FULL_SAMPLING_SHARE: f64 = 0.1;
/// R over the longest edge of a voxel.
const WINDOW_RADIUS: f64 = 2.0;
/// The square of the softening length over the square of the cluster's radius.
const SOFTENING: f64 = 0.12;
/// Largest radius of a cluster, over R, for which there is a near part.
const MAX_CLUSTER_RADIUS: f64 = 0.25;

/// A cluster of an emitter's facets.
#[derive(Clone, Copy, Debug)]
struct FacetCluster {
    /// Index of the emitter among those of many facets.
    emitter: usize,
    number: usize,
    centre: Vec3,
    radius: f64,
}

/// All emitters of many facets.
pub(crate) struct ManyLights<'a> {
    s: &'a Solution,
    transport: &'a Transport<'a>,
    emitters: Vec<LightSampler<'a>>,
    /// The light group of each emitter, where it has one of its own.
    groups: Vec<Option<&'a LightGroup>>,
    clusters: Vec<FacetCluster>,
    /// R, m; 0 where there is no near part.
    window_radius: f64,
    /// The clusters near each voxel zone: those of zone i from `begin[i]` to `begin[i + 1]`.
    begin: Vec<u32>,
    near: Vec<u32>,
}

impl<'a> ManyLights<'a> {
    /// The emitters with clusters among `light_samplers`, all lights of the scene in its order; `None` without one, or without a medium.
    pub(crate) fn new(
        s: &'a Solution,
        transport: &'a Transport<'a>,
        light_samplers: &[LightSampler<'a>],
    ) -> Option<ManyLights<'a>> {
        let map = s.scene.voxel_grid()?;
        let clustered = || light_samplers.iter().enumerate().filter(|l| l.1.is_clustered());
        let groups = clustered().map(|(l, _)| s.group_with_direct_light(l)).collect();
        let emitters: Vec<LightSampler> = clustered().map(|l| l.1.clone()).collect();
        let clusters_of = |(emitter, l): (usize, &LightSampler)| {
            let all = l.clusters().into_iter().enumerate();
            all.map(move |(number, (centre, radius))| FacetCluster { emitter, number, centre, radius })
                .collect::<Vec<_>>()
        };
        let clusters: Vec<FacetCluster> = emitters.iter().enumerate().flat_map(clusters_of).collect();
        if clusters.is_empty() {
            return None;
        }
        let cell = map.cell();
        let window_radius = WINDOW_RADIUS * cell.x.max(cell.y).max(cell.z);
        let small = clusters.iter().all(|c| c.radius <= MAX_CLUSTER_RADIUS * window_radius);
        let window_radius = if small { window_radius } else { 0.0 };
        let (begin, near) = (Vec::new(), Vec::new());
        let mut out = ManyLights { s, transport, emitters, groups, clusters, window_radius, begin, near };
        out.find_near_clusters();
        Some(out)
    }

    /// Fills the lists of clusters near zones.
    fn find_near_clusters(&mut self) {
        let pairs: Vec<Vec<(u32, u32)>> =
            parallel::collect(self.clusters.len(), |c| self.zones_near_cluster(c));
        let mut pairs: Vec<(u32, u32)> = pairs.into_iter().flatten().collect();
        pairs.sort_unstable();
        let zones = self.s.zones.voxels.len() as u32;
        self.begin = (0..=zones).map(|z| pairs.partition_point(|p| p.0 < z) as u32).collect();
        self.near = pairs.into_iter().map(|p| p.1).collect();
    }

    /// The zones within R of a cluster that see it.
    fn zones_near_cluster(&self, c: usize) -> Vec<(u32, u32)> {
        let Some(map) = self.s.scene.voxel_grid().filter(|_| self.window_radius > 0.0) else {
            return Vec::new();
        };
        let FacetCluster { centre, radius, .. } = self.clusters[c];
        let (zones, cell, half) = (&self.s.zones, map.cell(), 0.5 * map.cell().length());
        let side = |k: usize, reach: f64| {
            let place = (centre[k] + reach - map.min()[k]) / cell[k];
            place.floor().clamp(0.0, map.dims()[k] as f64) as usize
        };
        let range =
            |k: usize| side(k, -self.window_radius)..(side(k, self.window_radius) + 1).min(map.dims()[k]);
        let mut out = Vec::new();
        for (x, y, z) in range(0).flat_map(|x| range(1).flat_map(move |y| range(2).map(move |z| (x, y, z)))) {
            if (map.centre([x, y, z]) - centre).length() > self.window_radius + half {
                continue;
            }
            for zone in zones.voxel_zones_of_cell(map.index([x, y, z])) {
                let from_cluster = zones.voxels.at(zone).centre - centre;
                let r = from_cluster.length();
                // End the shadow ray before the cluster's own facets.
                let end = centre + from_cluster * (1.01 * radius / r.max(1e-12));
                if r <= 1.01 * radius || trace_shadow_ray(self.transport, zones.voxels.at(zone).centre, end) {
                    out.push((zone as u32, c as u32));
                }
            }
        }
        out
    }

    /// Contribution of the far part to B of a voxel zone, W/m²: Ω G/4 at its centre. The number of shadow rays falls with the share of the
    /// emitter in B, of which `indirect` is the rest.
    pub(crate) fn far_radiosity(&self, zone: usize, indirect: Bands) -> Bands {
        let z = self.s.zones.voxels.at(zone);
        if z.albedo == Bands::ZERO || z.extinction == Bands::ZERO {
            return Bands::ZERO;
        }
        let shift =
            [0, 1, 2].map(|k| low_discrepancy::hash_to_unit((zone as u64).wrapping_mul(3).wrapping_add(k)));
        let mut g = Bands::ZERO;
        for (k, emitter) in self.emitters.iter().enumerate() {
            if let Some(group) = self.groups[k].filter(|_| !self.near_clusters(zone).any(|c| c.emitter == k))
            {
                g += group.direct_at(self.s.zones.voxel_index(zone));
                continue;
            }
            let unoccluded = emitter.estimate_unoccluded(z.centre, Receiver::Free);
            let scale = 4.0 * FULL_SAMPLING_SHARE;
            let share = |b: Band| unoccluded[b] * z.albedo[b] / (scale * indirect[b]).max(1e-300);
            let share = Band::all().fold(0.0, |s: f64, b| s.max(share(b)));
            let n = ((MAX_SHADOW_RAYS as f64 * share).ceil() as usize).clamp(1, MAX_SHADOW_RAYS);
            for i in 0..n {
                let [u, v] = low_discrepancy::r2(i, [shift[0], shift[1]]);
                let s = [u, v, (i as f64 + shift[2]) / n as f64];
                let sample = emitter.sample_approximate(self.transport, z.centre, Receiver::Free, s);
                let Some((sample, r)) = sample else { continue };
                let far = 1.0 - self.window(r * r);
                // Trace the shadow ray, through medium and panes.
                if far > 0.0
                    && let Some(light) = emitter.attenuated(self.transport, z.centre, &sample)
                {
                    g += far * light / n as f64;
                }
            }
        }
        z.albedo * g / 4.0
    }

    /// The clusters near a zone.
    fn near_clusters(&self, zone: usize) -> impl Iterator<Item = &FacetCluster> {
        let all = self.begin[zone] as usize..self.begin[zone + 1] as usize;
        self.near[all].iter().map(|&c| &self.clusters[c as usize])
    }

    /// w at the square of a distance.
    fn window(&self, r2: f64) -> f64 {
        let rest = 1.0 - r2 / (self.window_radius * self.window_radius);
        if rest > 0.0 { rest * rest } else { 0.0 }
    }

    /// Radiance, W/(m² sr), that the near part adds along a segment of a ray.
    pub(crate) fn near_inscattered(&self, ray: ViewRay, segment: &VoxelSegment) -> Bands {
        let ViewRay { origin, dir } = ray;
        let mut out = Bands::ZERO;
        for c in self.near_clusters(segment.zone) {
            let foot = (c.centre - origin).dot(dir);
            let d2 = (origin + dir * foot - c.centre).length2() + SOFTENING * c.radius * c.radius;
            let (r2, d) = (self.window_radius * self.window_radius, d2.sqrt());
            let half = (r2 - d2).max(0.0).sqrt();
            let (a, b) = ((segment.t0 - foot).max(-half), (segment.t1 - foot).min(half));
            if a >= b {
                continue;
            }
            let integral =
                |s: f64| (s / d).atan() / d - 2.0 * s / r2 + (d2 * s + s * s * s / 3.0) / (r2 * r2);
            let weight = (integral(b) - integral(a)) / (4.0 * PI);
            let middle = foot + 0.5 * (a + b);
            let from_cluster = origin + dir * middle - c.centre;
            let (r, tau) = (from_cluster.length(), segment.transmittance_at(middle));
            let dir = from_cluster / r.max(1e-12);
            let power = self.emitters[c.emitter].cluster_intensity(c.number, dir);
            out += segment.scattering * tau * power * weight * (-segment.extinction * r).exp();
        }
        out
    }
}
