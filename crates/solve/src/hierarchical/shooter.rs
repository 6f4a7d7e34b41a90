//! Rays: where those of a zone start, where they stop, and many of them together.
//!
//! The zones at the points hit are looked up for some rays at a time: first what a lookup reads is read for all of them, without a branch
//! that waits for it, so that they wait for memory together. (Rays sorted by direction, so that those that follow each other pass the
//! same boxes, were tried: the sorting cost more than the tree gained.)

use crate::surroundings::voxel_point;
use zonal_math::directions::{cosine, sphere};
use zonal_math::{Vec3, sequence};
use zonal_scene::{Bands, Patch, Plate, Scene, Voxmap, Zones, bands};
use zonal_transport::sheets::Sheets;
use zonal_transport::{Hit, Transport};

/// A ray that leaves the scene, one that ends on a black back, and one that ends where there is no zone.
pub const SKY: u32 = u32::MAX;
pub const BACK: u32 = u32::MAX - 1;
pub const LOST: u32 = u32::MAX - 2;
/// The least of these.
pub const NOWHERE: u32 = LOST;
/// Tells the numbers of these rays from those of others.
pub const SEED: u64 = 0x5bd1_e995_0000_0000;
/// Halvings of the path in which a medium that varies stops a ray.
const HALVINGS: usize = 14;

/// Rays that meet facets before their zones are looked up.
const TOGETHER: usize = 64;

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
    /// True where every ray counts 1.
    pub grey: bool,
    uniform: Option<Bands>,
}

/// The side of a facet that was hit, and where.
fn place(hit: &Hit) -> (usize, [f64; 2]) {
    (2 * hit.facet + usize::from(!hit.front), [hit.u, hit.v])
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
        let at = match i.checked_sub(zones.pane_offset()) {
            Some(pane) => on(&zones.panes[pane].plate),
            None => voxel_point(&zones.voxels[i - zones.voxel_offset()], self.cell, p),
        };
        (at, sphere(d))
    }

    /// Where a ray stops; the medium stops it where its transmittance falls below `u`.
    pub fn shoot(&self, origin: Vec3, dir: Vec3, u: f64) -> Stop {
        self.settle(origin, dir, self.meet(origin, dir), u)
    }

    /// The first facet on a ray.
    fn meet(&self, origin: Vec3, dir: Vec3) -> Option<Hit> {
        self.transport.nearest(origin, dir, self.eps, self.reach)
    }

    /// Where a ray stops that met `hit`.
    fn settle(&self, origin: Vec3, dir: Vec3, hit: Option<Hit>, u: f64) -> Stop {
        let t = hit.map_or(self.reach, |h| h.t);
        let end = origin + dir * t;
        let depth = self.transport.medium_depth(origin, end);
        let passed = depth.map(|d| (-d).exp());
        let through = mean(passed);
        if u >= through {
            let (zone, worth) = self.stopped(origin, dir, t, u);
            return Stop { zone, worth, distance: t, at: end };
        }
        let zone = hit.map_or(SKY, |hit| {
            let (sheet, uv) = place(&hit);
            self.sheets.find(sheet, uv).unwrap_or(BACK)
        });
        let worth = self.worth(origin, end, bands(|b| passed[b] / through));
        Stop { zone, worth, distance: t, at: end }
    }

    /// The number by which the medium stops the `k`-th ray of a zone.
    fn luck(&self, i: usize, k: usize) -> f64 {
        sequence::r1(k, sequence::unit((i as u64 * 8 + 7) ^ SEED))
    }

    /// Shoots so many rays; `of` names the zone and the number of each among its rays. `stopped` is shown which it was and where it stopped,
    /// in turn.
    pub fn volley(
        &self,
        rays: usize,
        of: impl Fn(usize) -> (usize, usize),
        mut stopped: impl FnMut(usize, Stop),
    ) {
        let mut met = Vec::with_capacity(TOGETHER);
        let mut places = Vec::with_capacity(TOGETHER);
        for start in (0..rays).step_by(TOGETHER) {
            let some = start..(start + TOGETHER).min(rays);
            met.clear();
            met.extend(some.clone().map(|r| {
                let (i, k) = of(r);
                let (origin, dir) = self.ray(i, k);
                (origin, dir, self.meet(origin, dir))
            }));
            self.sheets.fetch(met.iter().filter_map(|m| m.2.as_ref()).map(place), &mut places);
            for (r, &(origin, dir, hit)) in some.zip(&met) {
                let (i, k) = of(r);
                stopped(r, self.settle(origin, dir, hit, self.luck(i, k)));
            }
        }
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
        let Some(map) = self.scene.voxmap() else { return (LOST, [1.0; 3]) };
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
        let Some(cell) = map.cell_at(at).map(|c| map.index(c)) else { return (LOST, [1.0; 3]) };
        let zone = self.transport.zone_in(self.zones, cell, at);
        let worth = if self.grey {
            [1.0; 3]
        } else {
            let k = map.extinction(cell);
            let l = left(s);
            let sum = (0..3).map(|b| k[b] * l[b]).sum::<f64>() / 3.0;
            self.worth(origin, at, bands(|b| if sum > 0.0 { k[b] * l[b] / sum } else { 1.0 }))
        };
        (zone.map_or(LOST, |z| (z + self.zones.voxel_offset()) as u32), worth)
    }
}
