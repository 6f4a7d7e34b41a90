//! Light of lamps of many facets, scattered by the medium: candles, chandeliers, lit meshes.
//!
//! Far from a flame its light hardly varies from voxel to voxel; beside it, it goes with 1/r². So the fluence is split, w falling from 1 at
//! a cluster of facets to 0 at the distance R of two voxels:
//!
//! ```text
//! G = Σ_c V_c I_c w(r)/r²  +  Σ_c V_c I_c (1 − w(r))/r²        w = (1 − r²/R²)²
//! ```
//!
//! The second part is bounded and smooth. It is gathered at the centre of every voxel that is asked for, by shadow rays to clusters chosen
//! by what they may send, and interpolated with the indirect light ([`crate::voxel_field`]). The first part is had along each ray in closed form: with d the
//! distance of the ray from the cluster, softened by a third of its radius, and s the way along the ray from the foot,
//!
//! ```text
//! ∫ w/r² ds = atan(s/d)/d − 2 s/R² + (d² s + s³/3)/R⁴
//! ```
//!
//! in each voxel that sees the cluster from its centre: flames do not shine through walls. Where clusters are large beside voxels w is 0.
//! A voxel without a cluster near has no first part: there the solution's own G of the lamp serves, where it keeps the lamp apart.

use crate::path::Piece;
use rayon::prelude::*;
use std::f64::consts::PI;
use zonal_math::{Vec3, sequence};
use zonal_scene::group::{Group, Kind};
use zonal_scene::{Bands, Solution, bands};
use zonal_transport::Transport;
use zonal_transport::direct::{Lamp, Receiver};

/// Shadow rays of a voxel, a lamp.
const SAMPLES: usize = 16;
/// All of them where its light would be more than this share of B.
const ENOUGH: f64 = 0.1;
/// R over the longest side of a voxel.
const REACH: f64 = 2.0;
/// The square of the softening over that of the radius.
const SOFT: f64 = 0.12;
/// The largest radius of a cluster over R.
const SMALL: f64 = 0.25;

/// A cluster of a lamp's facets.
#[derive(Clone, Copy, Debug)]
struct Cluster {
    lamp: usize,
    number: usize,
    centre: Vec3,
    radius: f64,
}

/// All lamps of many facets.
pub(crate) struct Crowds<'a> {
    s: &'a Solution,
    transport: &'a Transport<'a>,
    lamps: Vec<Lamp<'a>>,
    /// The light group of each lamp, where it has one of its own.
    groups: Vec<Option<&'a Group>>,
    clusters: Vec<Cluster>,
    /// R, m; 0 where all is far.
    reach: f64,
    /// The clusters near each voxel zone: those of zone i from `begin[i]` to `begin[i + 1]`.
    begin: Vec<u32>,
    near: Vec<u32>,
}

impl<'a> Crowds<'a> {
    /// The lamps among these, which are all lights of the scene in its order, that have clusters; `None` without one, or without a medium.
    pub(crate) fn new(
        s: &'a Solution,
        transport: &'a Transport<'a>,
        lamps: &[Lamp<'a>],
    ) -> Option<Crowds<'a>> {
        let map = s.scene.voxmap()?;
        let crowds = || lamps.iter().enumerate().filter(|l| l.1.is_crowd());
        let own = |l: usize| s.groups.iter().find(|g| g.kind == Kind::Light(l) && !g.direct.is_empty());
        let groups = crowds().map(|(l, _)| own(l)).collect();
        let lamps: Vec<Lamp> = crowds().map(|l| l.1.clone()).collect();
        let of = |(lamp, l): (usize, &Lamp)| {
            let all = l.clusters().into_iter().enumerate();
            all.map(move |(number, (centre, radius))| Cluster { lamp, number, centre, radius })
                .collect::<Vec<_>>()
        };
        let clusters: Vec<Cluster> = lamps.iter().enumerate().flat_map(of).collect();
        if clusters.is_empty() {
            return None;
        }
        let cell = map.cell();
        let reach = REACH * cell.x.max(cell.y).max(cell.z);
        let small = clusters.iter().all(|c| c.radius <= SMALL * reach);
        let reach = if small { reach } else { 0.0 };
        let mut out =
            Crowds { s, transport, lamps, groups, clusters, reach, begin: Vec::new(), near: Vec::new() };
        out.find_near();
        Some(out)
    }

    /// Fills the lists of clusters near zones.
    fn find_near(&mut self) {
        let pairs: Vec<Vec<(u32, u32)>> =
            (0..self.clusters.len()).into_par_iter().map(|c| self.zones_near(c)).collect();
        let mut pairs: Vec<(u32, u32)> = pairs.into_iter().flatten().collect();
        pairs.sort_unstable();
        let zones = self.s.zones.voxels.len() as u32;
        self.begin = (0..=zones).map(|z| pairs.partition_point(|p| p.0 < z) as u32).collect();
        self.near = pairs.into_iter().map(|p| p.1).collect();
    }

    /// The zones within R of a cluster that see it.
    fn zones_near(&self, c: usize) -> Vec<(u32, u32)> {
        let Some(map) = self.s.scene.voxmap().filter(|_| self.reach > 0.0) else {
            return Vec::new();
        };
        let Cluster { centre, radius, .. } = self.clusters[c];
        let (zones, cell, half) = (&self.s.zones, map.cell(), 0.5 * map.cell().length());
        let side = |k: usize, reach: f64| {
            let place = (centre[k] + reach - map.min()[k]) / cell[k];
            place.floor().clamp(0.0, map.dims()[k] as f64) as usize
        };
        let range = |k: usize| side(k, -self.reach)..(side(k, self.reach) + 1).min(map.dims()[k]);
        let mut out = Vec::new();
        for (x, y, z) in range(0).flat_map(|x| range(1).flat_map(move |y| range(2).map(move |z| (x, y, z)))) {
            if (map.centre([x, y, z]) - centre).length() > self.reach + half {
                continue;
            }
            for zone in zones.of_cell(map.index([x, y, z])) {
                let way = zones.voxels[zone].centre - centre;
                let r = way.length();
                // The cluster's own facets stand about its centre.
                let end = centre + way * (1.01 * radius / r.max(1e-12));
                if r <= 1.01 * radius || !self.transport.blocked(zones.voxels[zone].centre, end) {
                    out.push((zone as u32, c as u32));
                }
            }
        }
        out
    }

    /// What the smooth part of the light adds to B of a voxel zone, W/m²: Ω G/4 at its centre. Fewer rays ask where it hardly shows beside
    /// the rest of B.
    pub(crate) fn far(&self, zone: usize, rest: Bands) -> Bands {
        let z = &self.s.zones.voxels[zone];
        if z.albedo == [0.0; 3] || z.extinction == [0.0; 3] {
            return [0.0; 3];
        }
        let shift = [0, 1, 2].map(|k| sequence::unit((zone as u64).wrapping_mul(3).wrapping_add(k)));
        let mut g = [0.0; 3];
        for (k, lamp) in self.lamps.iter().enumerate() {
            if let Some(group) = self.groups[k].filter(|_| !self.is_near(k, zone)) {
                let (own, scale) = (group.direct.at(self.s.zones.voxel_offset() + zone), group.direct_scale);
                g = bands(|b| g[b] + scale[b] * own[b]);
                continue;
            }
            let most = lamp.estimate(z.centre, Receiver::Free);
            let share = |b: usize| most[b] * z.albedo[b] / (4.0 * ENOUGH * rest[b]).max(1e-300);
            let share = (0..3).fold(0.0, |s: f64, b| s.max(share(b)));
            let n = ((SAMPLES as f64 * share).ceil() as usize).clamp(1, SAMPLES);
            for i in 0..n {
                let [u, v] = sequence::r2(i, [shift[0], shift[1]]);
                let s = [u, v, (i as f64 + shift[2]) / n as f64];
                let beam = lamp.rough_beam(self.transport, z.centre, Receiver::Free, s);
                let Some((beam, r)) = beam else { continue };
                let share = 1.0 - self.window(r * r);
                if share > 0.0
                    && let Some(light) = lamp.lit(self.transport, z.centre, &beam)
                {
                    g = bands(|b| g[b] + share * light[b] / n as f64);
                }
            }
        }
        bands(|b| z.albedo[b] * g[b] / 4.0)
    }

    /// The clusters near a zone.
    fn near_of(&self, zone: usize) -> impl Iterator<Item = &Cluster> {
        let all = self.begin[zone] as usize..self.begin[zone + 1] as usize;
        self.near[all].iter().map(|&c| &self.clusters[c as usize])
    }

    /// True where clusters of lamp `k` are near a zone.
    fn is_near(&self, k: usize, zone: usize) -> bool {
        self.near_of(zone).any(|c| c.lamp == k)
    }

    /// w at the square of a distance.
    fn window(&self, r2: f64) -> f64 {
        let rest = 1.0 - r2 / (self.reach * self.reach);
        if rest > 0.0 { rest * rest } else { 0.0 }
    }

    /// Radiance, W/(m² sr), that clusters nearby add along a piece of a ray.
    pub(crate) fn near(&self, origin: Vec3, dir: Vec3, piece: &Piece) -> Bands {
        let mut out = [0.0; 3];
        for c in self.near_of(piece.zone) {
            let foot = (c.centre - origin).dot(dir);
            let d2 = (origin + dir * foot - c.centre).length2() + SOFT * c.radius * c.radius;
            let (r2, d) = (self.reach * self.reach, d2.sqrt());
            let half = (r2 - d2).max(0.0).sqrt();
            let (a, b) = ((piece.t0 - foot).max(-half), (piece.t1 - foot).min(half));
            if a >= b {
                continue;
            }
            let whole = |s: f64| (s / d).atan() / d - 2.0 * s / r2 + (d2 * s + s * s * s / 3.0) / (r2 * r2);
            let weight = (whole(b) - whole(a)) / (4.0 * PI);
            let middle = foot + 0.5 * (a + b);
            let way = origin + dir * middle - c.centre;
            let (r, tau) = (way.length(), piece.tau_at(middle));
            let power = self.lamps[c.lamp].cluster_intensity(c.number, way / r.max(1e-12));
            for i in 0..3 {
                out[i] += piece.scatter[i] * tau[i] * power[i] * weight * (-piece.kappa[i] * r).exp();
            }
        }
        out
    }
}
