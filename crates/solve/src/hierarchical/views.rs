//! Views: what every zone sees along a few rays, and the light that this passes on.
//!
//! A ray of zone i, of the density of its kernel (cosine on a patch, any direction in a volume), ends in one zone: a voxel zone where the
//! medium stops it, with the probability that it does, else a patch; or nowhere. With m rays that end in the zones j,
//!
//! ```text
//! H_i = ⟨B_j⟩      G_i = 4 ⟨B_j⟩      B_i = B⁰_i + ρ_i ⟨B_j⟩     (Ω_i for ρ_i in a volume)
//! ```
//!
//! Every ray ends once, so closure holds whatever the rays are, and a wall between two zones parts them, however close they are. What is
//! wrong with it is noise, which falls with the number of rays and with that of the zones over which light is alike. Light from panes
//! is left out; they dim.
//!
//! Bands in which the medium differs share the ray by their mean; each counts by its own probability over that of the ray.

use super::kept;
use super::onward::{BLOCK, Lamps, Own, Step, brought, first_of, step_of};
use crate::surroundings::{cosine, voxel_point};
use rayon::prelude::*;
use std::f64::consts::PI;
use zonal_math::{Vec3, sequence, vec3};
use zonal_scene::{Bands, Patch, Plate, Progress, Scene, Vault, Voxmap, Zones, bands};
use zonal_transport::Transport;
use zonal_transport::sheets::Sheets;

/// A ray that ends nowhere.
pub const NOWHERE: u32 = u32::MAX;
/// Tells the numbers of these rays from those of others.
pub const SEED: u64 = 0x5bd1_e995_0000_0000;
/// Halvings of the path in which a medium that varies stops a ray.
const HALVINGS: usize = 14;

/// The zones in which the rays of every zone end.
pub struct Views {
    /// Number of patches.
    first: usize,
    /// Rays of a patch, of a volume zone.
    each: [usize; 2],
    /// The zone met, or the step from which the ray goes on.
    met: Vec<u32>,
    /// What a ray counts in each band; empty where that is 1 for all.
    worth: Vec<[f32; 3]>,
    /// Steps of the rays of so many patches, and volume zones, at a time.
    steps: [Vec<Vec<Step>>; 2],
    /// ρ of the patches, where rays go on.
    reflectance: Vec<[f32; 3]>,
}

/// How far rays are followed.
#[derive(Clone, Copy)]
pub enum Way<'a> {
    /// To the zone that they meet: each ray ends once.
    Ends,
    /// To where they go on to.
    On,
    /// The same, and the own light of the patches from which they go on is added.
    With(&'a Own),
}

/// H or G with its standard error.
#[derive(Clone, Copy, Debug, Default)]
pub struct Measured {
    /// Value, W/m².
    pub value: Bands,
    /// Standard error, by the spread of the rays.
    pub error: Bands,
}

/// Where a ray stopped.
pub struct Stop {
    /// The zone, or nothing.
    pub zone: u32,
    /// What it counts, a band.
    pub worth: [f32; 3],
    /// How far it came, m.
    pub distance: f64,
    /// Position, m.
    pub at: Vec3,
}

/// Shoots rays.
pub struct Shooter<'a> {
    scene: &'a Scene,
    /// Zones.
    pub zones: &'a Zones,
    /// What rays meet.
    pub transport: &'a Transport<'a>,
    sheets: Sheets,
    cell: Vec3,
    reach: f64,
    eps: f64,
    grey: bool,
    uniform: Option<Bands>,
}

fn mean(v: Bands) -> f64 {
    (v[0] + v[1] + v[2]) / 3.0
}

impl<'a> Shooter<'a> {
    /// Makes ready.
    pub fn new(scene: &'a Scene, zones: &'a Zones, transport: &'a Transport<'a>) -> Shooter<'a> {
        let facets = scene.facets();
        let plates: Vec<Plate> = facets.iter().flat_map(|f| [f.plate, f.plate]).collect();
        let sheet = |p: &Patch| 2 * p.facet + usize::from(p.normal.dot(facets[p.facet].plate.normal()) < 0.0);
        let equal = |k: Bands| k[0] == k[1] && k[1] == k[2];
        let grey = |m: &Voxmap| match m.uniform_extinction() {
            Some(k) => equal(k),
            None => (0..m.len()).all(|i| equal(m.extinction(i))),
        };
        Shooter {
            scene,
            zones,
            transport,
            sheets: Sheets::new(&plates, zones.patches.iter().map(|p| (&p.plate, sheet(p)))),
            cell: scene.voxmap().map_or(Vec3::ZERO, |v| v.cell()),
            reach: 3.0 * scene.diagonal(),
            eps: 1e-9 * scene.diagonal(),
            grey: scene.voxmap().is_none_or(grey) && scene.panes().is_empty(),
            uniform: scene.voxmap().and_then(|m| m.uniform_extinction()),
        }
    }

    /// Where the `k`-th ray of a zone starts, and its direction.
    fn ray(&self, i: usize, k: usize) -> (Vec3, Vec3) {
        let zones = self.zones;
        let seed = |m: u64| (i as u64 * 8 + m) ^ SEED;
        let p = sequence::r3(k, [0, 1, 2].map(|m| sequence::unit(seed(m))));
        let d = sequence::net(k as u32, [sequence::hash(seed(3)) as u32, sequence::hash(seed(4)) as u32]);
        let on = |plate: &Plate| {
            let [u, v] = plate.warp([p[0], p[1]]);
            plate.at(u, v)
        };
        if let Some(z) = zones.patches.get(i) {
            return (on(&z.plate), cosine(z.normal, d));
        }
        let cos = 1.0 - 2.0 * d[0];
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let (s, c) = (2.0 * PI * d[1]).sin_cos();
        let at = match i.checked_sub(zones.pane_offset()) {
            Some(pane) => on(&zones.panes[pane].plate),
            None => voxel_point(&zones.voxels[i - zones.voxel_offset()], self.cell, p),
        };
        (at, vec3(sin * c, sin * s, cos))
    }

    /// Where a ray stops; the medium stops it where its transmittance falls below `u`.
    pub fn shoot(&self, origin: Vec3, dir: Vec3, u: f64) -> Stop {
        let hit = self.transport.nearest(origin, dir, self.eps, self.reach);
        let t = hit.map_or(self.reach, |h| h.t);
        let end = origin + dir * t;
        let depth = self.transport.medium_depth(origin, end);
        let passed = depth.map(|d| (-d).exp());
        let through = mean(passed);
        if u >= through {
            let (zone, worth) = self.stopped(origin, dir, t, u);
            return Stop { zone, worth, distance: t, at: end };
        }
        let Some(hit) = hit else { return Stop { zone: NOWHERE, worth: [1.0; 3], distance: t, at: end } };
        let sheet = 2 * hit.facet + usize::from(!hit.front);
        let zone = self.sheets.find(sheet, [hit.u, hit.v]).unwrap_or(NOWHERE);
        let worth = self.worth(origin, end, bands(|b| passed[b] / through));
        Stop { zone, worth, distance: t, at: end }
    }

    /// The `k`-th ray of a zone.
    pub fn own(&self, i: usize, k: usize) -> Stop {
        let (origin, dir) = self.ray(i, k);
        self.shoot(origin, dir, sequence::r1(k, sequence::unit((i as u64 * 8 + 7) ^ SEED)))
    }

    /// What a ray counts: by band, and dimmed by panes.
    fn worth(&self, a: Vec3, b: Vec3, share: Bands) -> [f32; 3] {
        if self.grey {
            return [1.0; 3];
        }
        let panes = self.transport.pane_depth_inside(a, b);
        [0, 1, 2].map(|x| (share[x] * (-panes[x]).exp()) as f32)
    }

    /// A ray that the medium stops before `t`, where the mean transmittance is `u`.
    fn stopped(&self, origin: Vec3, dir: Vec3, t: f64, u: f64) -> (u32, [f32; 3]) {
        let Some(map) = self.scene.voxmap() else { return (NOWHERE, [1.0; 3]) };
        let left = |s: f64| self.transport.medium_depth(origin, origin + dir * s).map(|d| (-d).exp());
        let inside = map.cell_at(origin).is_some();
        let s = match self.uniform {
            Some(k) if self.grey && inside => -u.max(1e-300).ln() / k[0],
            _ => {
                let (mut lo, mut hi) = (0.0, t);
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (lo + hi);
                    if mean(left(middle)) > u { lo = middle } else { hi = middle }
                }
                0.5 * (lo + hi)
            }
        };
        let at = origin + dir * s.min(t);
        let Some(cell) = map.cell_at(at).map(|c| map.index(c)) else { return (NOWHERE, [1.0; 3]) };
        let zone = self.transport.zone_in(self.zones, cell, at);
        let worth = if self.grey {
            [1.0; 3]
        } else {
            let k = map.extinction(cell);
            let l = left(s);
            let sum = (0..3).map(|b| k[b] * l[b]).sum::<f64>() / 3.0;
            self.worth(origin, at, bands(|b| if sum > 0.0 { k[b] * l[b] / sum } else { 1.0 }))
        };
        (zone.map_or(NOWHERE, |z| (z + self.zones.voxel_offset()) as u32), worth)
    }
}

impl Views {
    /// Shoots so many rays from every patch, and from every volume zone; with `lamps` those that end close by go on. What is done is kept
    /// in `vault` in stages (`kept`).
    pub fn new(
        scene: &Scene,
        zones: &Zones,
        transport: &Transport,
        each: [usize; 2],
        lamps: Option<&Lamps>,
        vault: &dyn Vault,
        progress: &dyn Progress,
    ) -> Views {
        let shooter = Shooter::new(scene, zones, transport);
        let first = zones.voxel_offset();
        let total = each[0] * first + each[1] * (zones.len() - first);
        progress.begin("views", zones.len() as u64);
        let single = |p: &Patch| p.reflectance.map(|r| r as f32);
        let mut views = Views {
            first,
            each,
            met: vec![NOWHERE; total],
            worth: Vec::new(),
            steps: Default::default(),
            reflectance: if lamps.is_some() {
                zones.patches.iter().map(single).collect()
            } else {
                Vec::new()
            },
        };
        if !shooter.grey {
            views.worth = vec![[1.0; 3]; total];
        }
        let (patches, volumes) = views.met.split_at_mut(each[0] * first);
        let (mut none, grey) = (Vec::new(), shooter.grey);
        let worth = if grey { &mut none } else { &mut views.worth };
        let (pw, vw) = worth.split_at_mut(if grey { 0 } else { each[0] * first });
        for (kind, from, met, worth) in [(0, 0, patches, pw), (1, first, volumes, vw)] {
            let stage = |number: usize| kept::name(views.each, kind, number);
            let each = each[kind];
            let blocks = kept::blocks(each);
            // Of every ray in turn; `worth` is empty where all count 1.
            let block = |(z, met): (usize, &mut [u32]), worth: &mut [[f32; 3]]| {
                let mut steps = Vec::new();
                for (r, m) in met.iter_mut().enumerate() {
                    let (i, k) = (z + r / each, r % each);
                    let stop = shooter.own(i, k);
                    if let Some(w) = worth.get_mut(r) {
                        *w = stop.worth;
                    }
                    *m = lamps.map_or(stop.zone, |l| shooter.follow(l, i, k, stop, &mut steps));
                }
                progress.advance(met.len() as u64 / each.max(1) as u64);
                steps.shrink_to_fit();
                steps
            };
            let mut worth = worth.chunks_mut(each * BLOCK * blocks);
            for (number, met) in met.chunks_mut(each * BLOCK * blocks).enumerate() {
                let (stage, worth) = (stage(number), worth.next().unwrap_or_default());
                let held = vault.load(&stage);
                let size = (first, zones.len());
                if let Some(steps) = held.and_then(|b| kept::restored(&b, met, worth, each * BLOCK, size)) {
                    progress.advance(met.len() as u64 / each.max(1) as u64);
                    views.steps[kind].extend(steps);
                    continue;
                }
                let at = |b: usize| from + (number * blocks + b) * BLOCK;
                let chunks = met.par_chunks_mut(each * BLOCK).enumerate().map(|(b, m)| (at(b), m));
                let steps: Vec<Vec<Step>> = if grey {
                    chunks.map(|m| block(m, &mut [])).collect()
                } else {
                    chunks.zip(worth.par_chunks_mut(each * BLOCK)).map(|(m, w)| block(m, w)).collect()
                };
                if vault.keeps() {
                    vault.save(&stage, &kept::stage(met, worth, &steps));
                }
                views.steps[kind].extend(steps);
            }
        }
        progress.end();
        views
    }

    /// Number of rays, and of those that went on.
    pub fn rays(&self) -> [u64; 2] {
        [self.met.len() as u64, self.steps.iter().flatten().map(|s| s.len() as u64).sum()]
    }

    /// Number of patches.
    pub fn patches(&self) -> usize {
        self.first
    }

    /// Rays of zone `i`.
    pub fn of(&self, i: usize) -> std::ops::Range<usize> {
        let [p, v] = self.each;
        if i < self.first {
            p * i..p * (i + 1)
        } else {
            let start = p * self.first + v * (i - self.first);
            start..start + v
        }
    }

    /// Steps of the rays of zone `i`.
    fn steps(&self, i: usize) -> &[Step] {
        let (kind, z) = if i < self.first { (0, i) } else { (1, i - self.first) };
        &self.steps[kind][z / BLOCK]
    }

    /// What ray `r` brings where zones shine with radiosities `b`.
    #[inline]
    fn ray(&self, steps: &[Step], r: usize, b: &[[f32; 3]], way: Way) -> [f32; 3] {
        let worth = self.worth.get(r).copied().unwrap_or([1.0; 3]);
        self.brings(steps, self.met[r], worth, b, way)
    }

    /// What a ray brings that met a zone, or goes on from a step, and counts `worth`.
    #[inline]
    pub fn brings(&self, steps: &[Step], met: u32, worth: [f32; 3], b: &[[f32; 3]], way: Way) -> [f32; 3] {
        let bright = |zone: u32| {
            let b = b[zone as usize];
            [worth[0] * b[0], worth[1] * b[1], worth[2] * b[2]]
        };
        let on = |at: usize, own| brought(steps, at, worth, &self.reflectance, b, own);
        match (step_of(met), way) {
            _ if met == NOWHERE => [0.0; 3],
            (None, _) => bright(met),
            (Some(_), Way::Ends) => bright(first_of(met, steps)),
            (Some(at), Way::On) => on(at, None),
            (Some(at), Way::With(own)) => on(at, Some(own)),
        }
    }

    /// What arrives, H or G, where zones shine with radiosities `b`, by the first of so many rays.
    pub fn arriving(&self, b: &[[f32; 3]], way: Way, of: usize) -> Vec<Bands> {
        let one = |i: usize| {
            let (range, unit, steps) = (self.of(i), self.unit(i), self.steps(i));
            let count = range.len().div_ceil(of);
            let m = count as f32;
            let mut sum = [0.0; 3];
            for r in range.take(count) {
                let v = self.ray(steps, r, b, way);
                (0..3).for_each(|x| sum[x] += v[x]);
            }
            sum.map(|s| unit * (s / m) as f64)
        };
        (0..b.len()).into_par_iter().with_min_len(256).map(one).collect()
    }

    /// The same with standard errors.
    pub fn measured(&self, b: &[[f32; 3]], way: Way) -> Vec<Measured> {
        let one = |i: usize| {
            let (range, steps) = (self.of(i), self.steps(i));
            let (m, unit) = (range.len() as f64, self.unit(i));
            let (mut sum, mut square) = ([0.0; 3], [0.0; 3]);
            for r in range {
                let v = self.ray(steps, r, b, way).map(f64::from);
                for x in 0..3 {
                    sum[x] += v[x];
                    square[x] += v[x] * v[x];
                }
            }
            let h = sum.map(|s| s / m);
            let e = bands(|x| ((square[x] / m - h[x] * h[x]).max(0.0) / m).sqrt());
            Measured { value: h.map(|x| x * unit), error: e.map(|x| x * unit) }
        };
        (0..b.len()).into_par_iter().with_min_len(256).map(one).collect()
    }

    /// H is ⟨B⟩, G four times that.
    pub fn unit(&self, i: usize) -> f64 {
        if i < self.first { 1.0 } else { 4.0 }
    }
}
