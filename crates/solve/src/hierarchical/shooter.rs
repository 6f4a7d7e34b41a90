//! Rays: where those of a zone start, where they stop, and many of them together.
//!
//! The zones at the points hit are looked up for some rays at a time: first what a lookup reads is read for all of them, without a branch
//! that waits for it, so that they wait for memory together. (Rays sorted by direction, so that those that follow each other pass the
//! same boxes, were tried: the sorting cost more than the tree gained.)
//!
//! What dims a ray, medium and panes, also stops it: where the mean of its transmittances falls below a number u drawn for it. What
//! it counts in each band, with l what is left there of the light, averages to one over all u:
//!
//! ```text
//! in the medium κ l/⟨κ l⟩      in a pane (l⁻ − l⁺)/⟨l⁻ − l⁺⟩      where it ends l/⟨l⟩      ⟨⟩ the mean of the bands
//! ```
//!
//! Rays from a pane count what the pane takes of them; the rest of what closes its row is its own light.

use crate::surroundings::ray;
use zonal_math::{Vec3, sequence};
use zonal_scene::{Bands, Patch, Plate, Scene, Voxmap, Zones, bands};
use zonal_transport::sheets::Sheets;
use zonal_transport::{Hit, PaneHit, Transport};

/// A ray that leaves the scene, one that ends on a black back, and one that ends where there is no zone.
pub(super) const SKY: u32 = u32::MAX;
pub(super) const BACK: u32 = u32::MAX - 1;
pub(super) const LOST: u32 = u32::MAX - 2;
/// The least of these.
pub(super) const NOWHERE: u32 = LOST;
/// Tells the numbers of these rays from those of others.
pub(super) const SEED: u64 = 0x5bd1_e995_0000_0000;
/// Halvings of the path in which a medium that varies stops a ray.
const HALVINGS: usize = 14;

/// Rays that meet facets before their zones are looked up.
const TOGETHER: usize = 64;

/// Where a ray stopped.
pub(super) struct Stop {
    /// The zone, or nothing.
    pub zone: u32,
    /// What it counts, a band.
    pub worth: [f32; 3],
    /// How far it came, m.
    pub distance: f64,
    /// Position, m.
    pub at: Vec3,
}

/// How far a ray came undisturbed, and what is left of the light there.
struct Reached {
    distance: f64,
    /// Transmittance of the panes before.
    panes: Bands,
    /// The same with the medium.
    left: Bands,
}

/// Shoots rays.
pub(super) struct Shooter<'a> {
    scene: &'a Scene,
    /// Zones.
    pub zones: &'a Zones,
    /// What rays meet.
    pub transport: &'a Transport<'a>,
    sheets: Sheets,
    /// Pieces of panes by the plates of all panes, and the number of each pane's first plate.
    glass: Sheets,
    first_plate: Vec<usize>,
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
    pub(super) fn new(scene: &'a Scene, zones: &'a Zones, transport: &'a Transport<'a>) -> Shooter<'a> {
        let facets = scene.facets();
        let plates: Vec<Plate> = facets.iter().flat_map(|f| [f.plate, f.plate]).collect();
        let sheet = |p: &Patch| 2 * p.facet + usize::from(p.normal.dot(facets[p.facet].plate.normal()) < 0.0);
        let equal = |k: Bands| k[0] == k[1] && k[1] == k[2];
        let grey = |m: &Voxmap| match m.uniform_extinction() {
            Some(k) => equal(k),
            None => (0..m.len()).all(|i| equal(m.extinction(i))),
        };
        let (first_plate, glass) = zonal_transport::sheets::of_panes(scene, zones);
        Shooter {
            scene,
            zones,
            transport,
            glass,
            first_plate,
            sheets: Sheets::new(&plates, zones.patches.iter().map(|p| (&p.plate, sheet(p)))),
            cell: scene.voxmap().map_or(Vec3::ZERO, |v| v.cell()),
            reach: 3.0 * scene.diagonal(),
            eps: 1e-9 * scene.diagonal(),
            grey: scene.voxmap().is_none_or(grey) && scene.panes().is_empty(),
            uniform: scene.voxmap().and_then(|m| m.uniform_extinction()),
        }
    }

    /// Where the `k`-th ray of a zone starts, its direction and what it counts.
    fn ray(&self, i: usize, k: usize) -> (Vec3, Vec3, Bands) {
        ray(self.zones, self.cell, (i, SEED), k)
    }

    /// Where a ray stops; the medium or a pane stops it where the transmittance falls below `u`.
    pub(super) fn shoot(&self, origin: Vec3, dir: Vec3, u: f64) -> Stop {
        self.settle(origin, dir, self.meet(origin, dir), u)
    }

    /// The first facet on a ray.
    fn meet(&self, origin: Vec3, dir: Vec3) -> Option<Hit> {
        self.transport.nearest(origin, dir, self.eps, self.reach)
    }

    /// Where a ray stops that met `hit`.
    fn settle(&self, origin: Vec3, dir: Vec3, hit: Option<Hit>, u: f64) -> Stop {
        let t = hit.map_or(self.reach, |h| h.t);
        let mut panes = [1.0; 3];
        let mut stop = None;
        self.transport.pane_crossings(origin, origin + dir * t, &mut |p| {
            if stop.is_none() {
                stop = self.through(origin, dir, &p, &mut panes, u);
            }
        });
        stop.unwrap_or_else(|| {
            let reached = self.reached(origin, dir, t, panes);
            let through = mean(reached.left);
            if u >= through {
                return self.stopped(origin, dir, &reached, u);
            }
            let zone = hit.map_or(SKY, |hit| {
                let (sheet, uv) = place(&hit);
                self.sheets.find(sheet, uv).unwrap_or(BACK)
            });
            self.stop(zone, origin, dir, t, reached.left)
        })
    }

    /// What is left of a ray at the distance `t`, behind panes that let `panes` through.
    fn reached(&self, origin: Vec3, dir: Vec3, t: f64, panes: Bands) -> Reached {
        let depth = self.transport.medium_depth(origin, origin + dir * t);
        Reached { distance: t, panes, left: bands(|b| panes[b] * (-depth[b]).exp()) }
    }

    /// A stop that counts `light` over its mean.
    fn stop(&self, zone: u32, origin: Vec3, dir: Vec3, distance: f64, light: Bands) -> Stop {
        let whole = mean(light);
        let one = |b: usize| if whole > 0.0 { (light[b] / whole) as f32 } else { 1.0 };
        let worth = if self.grey { [1.0; 3] } else { [0, 1, 2].map(one) };
        Stop { zone, worth, distance, at: origin + dir * distance }
    }

    /// Where a ray stops before a pane or in it, if it does; `panes` lets less through behind it.
    fn through(&self, origin: Vec3, dir: Vec3, hit: &PaneHit, panes: &mut Bands, u: f64) -> Option<Stop> {
        let before = self.reached(origin, dir, hit.t, *panes);
        if u >= mean(before.left) {
            return Some(self.stopped(origin, dir, &before, u));
        }
        let pass = self.transport.slant_depth(hit).map(|d| (-d).exp());
        let after = bands(|b| before.left[b] * pass[b]);
        if u >= mean(after) {
            let uv = self.scene.panes()[hit.pane].plates[hit.plate].parameters(origin + dir * hit.t);
            let piece = self.glass.find(self.first_plate[hit.pane] + hit.plate, uv);
            let zone = piece.map_or(LOST, |p| p + self.zones.pane_offset() as u32);
            let taken = bands(|b| before.left[b] - after[b]);
            return Some(self.stop(zone, origin, dir, hit.t, taken));
        }
        *panes = bands(|b| panes[b] * pass[b]);
        None
    }

    /// The share of the light of pane zone `i` that meets itself, as so many of its rays leave it.
    pub(super) fn within(&self, i: usize, rays: usize) -> Bands {
        let sum = (0..rays).map(|k| self.ray(i, k).2);
        let sum = sum.fold([0.0; 3], |s, v| bands(|b| s[b] + v[b]));
        sum.map(|s| 1.0 - s / rays as f64)
    }

    /// The number by which medium or pane stops the `k`-th ray of a zone: of the sequence of its directions, as one of the sort that its
    /// places are from would keep step with these for thousands of rays.
    fn luck(&self, i: usize, k: usize) -> f64 {
        sequence::third(k as u32, sequence::hash((i as u64 * 8 + 7) ^ SEED) as u32)
    }

    /// Shoots so many rays; `of` names the zone and the number of each among its rays. `stopped` is shown which it was and where it stopped,
    /// in turn.
    pub(super) fn volley(
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
                let (origin, dir, weight) = self.ray(i, k);
                (origin, dir, weight, self.meet(origin, dir))
            }));
            self.sheets.fetch(met.iter().filter_map(|m| m.3.as_ref()).map(place), &mut places);
            for (r, &(origin, dir, weight, hit)) in some.zip(&met) {
                let (i, k) = of(r);
                let mut stop = self.settle(origin, dir, hit, self.luck(i, k));
                (0..3).for_each(|b| stop.worth[b] *= weight[b] as f32);
                stopped(r, stop);
            }
        }
    }

    /// A ray that the medium stops before it has come so far.
    fn stopped(&self, origin: Vec3, dir: Vec3, reached: &Reached, u: f64) -> Stop {
        let Reached { distance: t, panes, .. } = *reached;
        let lost = Stop { zone: LOST, worth: [1.0; 3], distance: t, at: origin + dir * t };
        let Some(map) = self.scene.voxmap() else { return lost };
        let left = |s: f64| self.reached(origin, dir, s, panes).left;
        let s = match self.uniform {
            Some(k) if self.grey && map.cell_at(origin).is_some() => -u.max(1e-300).ln() / k[0],
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
        let Some(cell) = map.cell_at(at).map(|c| map.index(c)) else { return lost };
        let zone = self.transport.zone_in(self.zones, cell, at);
        let zone = zone.map_or(LOST, |z| (z + self.zones.voxel_offset()) as u32);
        let light = if self.grey {
            [1.0; 3]
        } else {
            let (k, l) = (map.extinction(cell), left(s));
            bands(|b| k[b] * l[b])
        };
        self.stop(zone, origin, dir, s.min(t), light)
    }
}
