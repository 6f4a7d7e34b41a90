//! Powers by name and by zone, and temperatures, by walks that start at the sources.
//!
//! A walk begins at a point of what emits, or on its way in from sun, sky and surroundings, with the weight P/N of P watts and N walks. It
//! flies straight until it meets a facet or an exponential optical depth is spent, is weakened by reflectance or albedo, and goes on in a new
//! direction. What it leaves is counted everywhere at once:
//!
//! ```text
//!     surface:  absorbed += w (1 − ρ)        A H += w          volume:  absorbed += w κ(1 − Ω) ℓ        V G += w ℓ     over lengths ℓ
//! ```
//!
//! **Two questions.** From where it was met a walk goes on for the *continuous* problem. For the *zones' own* equations it begins again at
//! a uniformly random point of the zone that it met: these are walks on the zones, of which the mean of what arrives is the exact solution of
//! the zonal equations, with exact exchange areas. A pane has no depth in either: walks begin again at any height in it.
//!
//! **Heat.** What has a known temperature emits a_b(1 − ρ_b)σT⁴ in band b (4κ_b(1 − Ω_b) a_b σT⁴ of a volume). What has a known net power q
//! takes what it absorbs and sends it out again in bands drawn by a_b(1 − ρ_b), beside q, which may be negative: a weight below 0. Then
//!
//! ```text
//!     Σ_b a_b (1 − ρ_b) ∫σT⁴ dA = absorbed + ∫q dA          Σ_b 4 κ_b (1 − Ω_b) a_b ∫σT⁴ dV = absorbed + ∫q dV
//! ```
//!
//! What solids that touch it cover of a surface is no part of it: a known power is that of the rest.
//!
//! Shares that depend on the temperature are for scenes of given temperatures alone.
//!
//! Every number is a mean over [`BATCHES`] independent batches, their spread its standard error; all of it is a function of the seed.

mod grazing;
pub mod ground;
mod sources;
mod tally;

pub use ground::Closed;

use crate::judge::hash;
use crate::judge::space::around;
use crate::{Dice, Estimate, Tally};
use ground::{End, Ground, Place, Start};
use rayon::prelude::*;
use sources::{Sources, Take};
use tally::{Known3, Optics, Slots};
use zonal_math::Vec3;
use zonal_scene::{Plate, Scene, Sides, Zones};

/// Independent batches of a mean.
pub const BATCHES: usize = 32;
/// A walk that has less than this share of its first weight lives on by chance.
const SMALL: f64 = 0.1;
/// Events after which a walk is given up.
const EVENTS: usize = 2_000_000;

/// Temperature and heat of a name or a zone.
#[derive(Clone, Copy, Debug, Default)]
pub struct HeatAnswer {
    /// Mean of σT⁴, W/m²; none where there is no temperature.
    pub emissive: Option<Estimate>,
    /// Net power that it gives, W.
    pub power: Estimate,
}

/// What walks find.
#[derive(Clone, Debug, Default)]
pub struct Answer {
    /// Absorbed by each surface, W a band; in thermal mode where temperatures are known.
    pub surfaces: Vec<[Estimate; 3]>,
    /// Absorbed by the medium, W a band; in thermal mode where temperatures are known.
    pub medium: [Estimate; 3],
    /// Absorbed by all panes, W a band.
    pub panes: [Estimate; 3],
    /// Gone to the surroundings after it met something, W a band.
    pub escaped: [Estimate; 3],
    /// Lost on black backs, W a band.
    pub backs: [Estimate; 3],
    /// Surfaces, the medium if there is one, each pane: temperatures and net powers. Empty in light mode.
    pub heat: Vec<HeatAnswer>,
    /// H or G of each zone, W/m² a band; empty for the continuous problem.
    pub zones: Vec<[Estimate; 3]>,
    /// Temperature and net power of each zone; empty in light mode and for the continuous problem.
    pub zone_heat: Vec<HeatAnswer>,
}

/// Finds powers and temperatures by `walks` walks for each band: those of the continuous problem, or of the equations of `zones`.
pub fn answer(scene: &Scene, closed: &Closed, zones: Option<&Zones>, walks: usize, seed: u64) -> Answer {
    let ground = Ground::new(scene, closed);
    let (areas, volumes) = match zones {
        None => (ground.areas(hash(seed, 4)), ground.volumes(hash(seed, 3))),
        Some(z) => {
            let mut areas = vec![0.0; scene.surfaces().len()];
            z.patches.iter().for_each(|p| areas[p.surface] += p.area);
            (areas, Vec::new())
        }
    };
    let optics = Optics::new(scene, &areas);
    let slots = Slots::new(scene, zones);
    let bands: &[usize] = if optics.one_band { &[0] } else { &[0, 1, 2] };
    let sources: Vec<Sources> = bands.iter().map(|&b| Sources::new(&ground, &optics, zones, b)).collect();
    let walker = Walker { ground, optics, zones, slots, patches: zones.map(by_facet) };
    let sums: Vec<Vec<f64>> = (0..BATCHES)
        .into_par_iter()
        .map(|k| {
            let mut sums = vec![0.0; 4 * walker.slots.len];
            for (n, &b) in bands.iter().enumerate() {
                walker.batch(
                    &sources[n],
                    b,
                    walks.div_ceil(BATCHES),
                    hash(hash(seed, k as u64), b as u64),
                    &mut sums,
                );
            }
            sums
        })
        .collect();
    // What one walk carries: sums that hardly any walk reaches are known no better.
    let one = zonal_scene::bands(|b| {
        let of = sources.get(if walker.optics.one_band { 0 } else { b });
        of.map_or(0.0, |s| s.power.abs() / walks.max(1) as f64)
    });
    let mut answer = walker.slots.read(scene, zones, &walker.optics, (&areas, &volumes), (&sums, one));
    grazing::widen(&mut answer, grazing::unsampled(scene, &sources, walks), scene, zones);
    answer
}

/// The patches of each facet.
fn by_facet(zones: &Zones) -> Vec<Vec<usize>> {
    let mut out = vec![Vec::new(); zones.patches.iter().map(|p| p.facet + 1).max().unwrap_or(0)];
    zones.patches.iter().enumerate().for_each(|(i, p)| out[p.facet].push(i));
    out
}

struct Walker<'a> {
    ground: Ground<'a>,
    optics: Optics,
    zones: Option<&'a Zones>,
    slots: Slots,
    patches: Option<Vec<Vec<usize>>>,
}

/// A walk under way.
struct Walk {
    start: Start,
    direction: Vec3,
    weight: f64,
    band: usize,
    /// True once it has met something, or began on something.
    counted: bool,
}

impl Walker<'_> {
    fn batch(&self, sources: &Sources, band: usize, walks: usize, seed: u64, sums: &mut [f64]) {
        if sources.power == 0.0 {
            return;
        }
        let mut dice = Dice::new(hash(seed, u64::MAX));
        let shift = dice.roll();
        for j in 0..walks {
            let u = (j as f64 + shift) / walks as f64;
            let (source, sign) = sources.at(u);
            let weight = sign * sources.power / walks as f64;
            if let Some((start, direction, counted)) = self.begin(source, &mut dice) {
                self.run(Walk { start, direction, weight, band, counted }, &mut dice, sums);
            }
        }
    }

    /// A point and a direction of a source; none where it does not lie in free space.
    fn begin(&self, take: Take, dice: &mut Dice) -> Option<(Start, Vec3, bool)> {
        let scene = self.ground.scene;
        match take {
            Take::Facet(f, front) => {
                let p = &scene.facets()[f as usize].plate;
                let normal = if front { p.normal() } else { -p.normal() };
                let at = dice.on_plate(p);
                Some((Start { at, facet: Some(f), pane: None }, dice.cosine(normal), true))
            }
            Take::Zone(i) => {
                let zones = self.zones?;
                if i < zones.voxel_offset() {
                    let p = &zones.patches[i];
                    let start =
                        Start { at: dice.on_plate(&p.plate), facet: Some(p.facet as u32), pane: None };
                    return Some((start, dice.cosine(p.normal), true));
                }
                Some((self.within(i, dice)?, dice.direction(), true))
            }
            Take::Cell(c) => {
                let map = scene.voxmap()?;
                let lo = map.corner(map.coordinates(c));
                let at = dice.in_box(lo, lo + map.cell());
                self.ground
                    .free(at, dice)
                    .then(|| (Start { at, facet: None, pane: None }, dice.direction(), true))
            }
            Take::Plate(k) => Some((self.in_pane(k, None, dice), dice.direction(), true)),
            Take::Sun(towards, cos) => {
                let d = -around(towards, 1.0 - dice.roll() * (1.0 - cos), dice.roll());
                let (centre, r) = self.ground.ball();
                let (a, b) = d.frame();
                let (radius, turn) = (r * dice.roll().sqrt(), dice.between(0.0, std::f64::consts::TAU));
                let at = centre - d * (2.0 * r) + (a * turn.cos() + b * turn.sin()) * radius;
                Some((Start { at, facet: None, pane: None }, d, false))
            }
            Take::Around => {
                let (centre, r) = self.ground.ball();
                let n = dice.direction();
                Some((Start { at: centre + n * r, facet: None, pane: None }, dice.cosine(-n), false))
            }
        }
    }

    /// A point of a plate of panes, at any height.
    fn in_pane(&self, plate: usize, at: Option<Vec3>, dice: &mut Dice) -> Start {
        let (pane, q) = &self.ground.plates[plate];
        let at = at.unwrap_or_else(|| dice.on_plate(q));
        Start {
            at,
            facet: None,
            pane: Some((plate, dice.roll() * self.ground.scene.panes()[*pane].thickness)),
        }
    }

    /// A point of volume zone `i`.
    fn within(&self, i: usize, dice: &mut Dice) -> Option<Start> {
        let zones = self.zones?;
        if i >= zones.pane_offset() {
            let z = &zones.panes[i - zones.pane_offset()];
            let at = dice.on_plate(&z.plate);
            let own = |p: &(usize, Plate)| p.0 == z.pane;
            let candidates = self.ground.plates.iter().enumerate().filter(|(_, p)| own(p));
            let plate = candidates.min_by(|a, b| outside(&a.1.1, at).total_cmp(&outside(&b.1.1, at)))?.0;
            return Some(self.in_pane(plate, Some(at), dice));
        }
        let z = &zones.voxels[i - zones.voxel_offset()];
        let map = self.ground.scene.voxmap()?;
        let lo = map.corner(map.coordinates(z.cell));
        let at = tally::point_of(&self.ground, z, lo, map.cell(), dice);
        Some(Start { at, facet: None, pane: None })
    }

    fn run(&self, mut w: Walk, dice: &mut Dice, sums: &mut [f64]) {
        let first = w.weight.abs();
        let scene = self.ground.scene;
        let slots = &self.slots;
        if let Some(f) = w.start.facet
            && self.ground.covered(w.start.at, w.direction_side(scene, f), f)
        {
            // What is covered is not there; a patch that is covered in part loses what it sends.
            if self.zones.is_some() {
                sums[4 * slots.backs + w.band] += w.weight;
            }
            return;
        }
        for _ in 0..EVENTS {
            let tau = -(1.0 - dice.roll()).ln();
            let (band, weight) = (w.band, w.weight);
            let end = self.ground.fly(&w.start, w.direction, band, tau, &mut |place, way| {
                self.count(place, weight * way, band, sums);
            });
            match end {
                End::Escaped => {
                    if w.counted {
                        sums[4 * slots.escaped + w.band] += w.weight;
                    }
                    return;
                }
                End::Facet(met, at) => {
                    let facet = &scene.facets()[met.id as usize];
                    let both = scene.surfaces()[facet.surface].sides == Sides::Both;
                    let normal = if met.front { facet.plate.normal() } else { -facet.plate.normal() };
                    if (!met.front && !both) || self.ground.covered(at, normal, met.id) {
                        sums[4 * slots.backs + w.band] += w.weight;
                        return;
                    }
                    let zone = self.patch(met.id, normal, at);
                    let k = self.optics.surface(facet.surface);
                    self.arrive(k, facet.surface, zone, w.weight, w.band, sums);
                    if !self.turn(k, &mut w, dice) {
                        return;
                    }
                    let at = match (self.zones, zone) {
                        (Some(z), Some(i)) => dice.on_plate(&z.patches[i].plate),
                        _ => at,
                    };
                    w.start = Start { at, facet: Some(met.id), pane: None };
                    w.direction = dice.cosine(normal);
                }
                End::Cell(cell, at) => {
                    if !self.turn(self.optics.cell(cell), &mut w, dice) {
                        return;
                    }
                    w.start = match self.zone_of(cell, at).and_then(|i| self.within(i, dice)) {
                        Some(start) => start,
                        None => Start { at, facet: None, pane: None },
                    };
                    w.direction = dice.direction();
                }
                End::Pane(pane, plate, at) => {
                    if !self.turn(self.optics.pane(pane), &mut w, dice) {
                        return;
                    }
                    let zone = self.pane_zone(pane, at);
                    w.start = match zone.and_then(|i| self.within(i, dice)) {
                        Some(start) => start,
                        None => self.in_pane(plate, Some(at), dice),
                    };
                    w.direction = dice.direction();
                }
            }
            w.counted = true;
            if let Some(f) = w.start.facet
                && self.zones.is_some()
                && self.ground.covered(w.start.at, w.direction_side(scene, f), f)
            {
                sums[4 * slots.backs + w.band] += w.weight;
                return;
            }
            if w.weight.abs() < SMALL * first {
                let chance = w.weight.abs() / (SMALL * first);
                if dice.roll() >= chance {
                    return;
                }
                w.weight /= chance;
            }
        }
    }

    /// Counts what a surface or a zone of it takes.
    fn arrive(
        &self,
        k: &Known3,
        surface: usize,
        zone: Option<usize>,
        weight: f64,
        band: usize,
        sums: &mut [f64],
    ) {
        self.add(k, surface, zone, [weight, weight * k.absorb[band]], band, sums);
    }

    /// Counts a length, times its weight, in the medium or in a pane.
    fn count(&self, place: Place, length: f64, band: usize, sums: &mut [f64]) {
        let (k, name, zone) = match place {
            Place::Cell(c, at) => (self.optics.cell(c), self.slots.medium, self.zone_of(c, at)),
            Place::Pane(p, _, at) => (self.optics.pane(p), self.slots.panes + p, self.pane_zone(p, at)),
        };
        self.add(k, name, zone, [length, length * k.absorb[band] * k.extinction[band]], band, sums);
    }

    /// Adds what is met to the sums of a zone, and what is taken of it to those of a name and of the zone.
    fn add(
        &self,
        k: &Known3,
        name: usize,
        zone: Option<usize>,
        [met, taken]: [f64; 2],
        band: usize,
        sums: &mut [f64],
    ) {
        let again = taken / k.emits;
        sums[4 * name + if k.again { 3 } else { band }] += if k.again { again } else { taken };
        if let Some(i) = zone {
            let at = 4 * (self.slots.zones + i);
            sums[at + band] += met;
            if k.again {
                sums[at + 3] += again;
            }
        }
    }

    /// What becomes of a walk where it met something; false where it ends.
    fn turn(&self, k: &Known3, w: &mut Walk, dice: &mut Dice) -> bool {
        let reflect = 1.0 - k.absorb[w.band];
        if !k.again {
            w.weight *= reflect;
            return w.weight != 0.0;
        }
        if dice.roll() >= reflect {
            // Absorbed, and sent out again.
            let u = dice.roll() * k.shares.iter().sum::<f64>();
            w.band = if u < k.shares[0] {
                0
            } else if u < k.shares[0] + k.shares[1] {
                1
            } else {
                2
            };
            if k.shares[w.band] == 0.0 {
                return false;
            }
        }
        true
    }

    fn patch(&self, facet: u32, normal: Vec3, at: Vec3) -> Option<usize> {
        let (zones, lists) = (self.zones?, self.patches.as_ref()?);
        let own = lists.get(facet as usize)?.iter().filter(|&&i| zones.patches[i].normal.dot(normal) > 0.0);
        own.min_by(|&&a, &&b| {
            outside(&zones.patches[a].plate, at).total_cmp(&outside(&zones.patches[b].plate, at))
        })
        .copied()
    }

    fn zone_of(&self, cell: usize, at: Vec3) -> Option<usize> {
        let zones = self.zones?;
        let range = zones.of_cell(cell);
        let k = match range.len() {
            0 => return None,
            1 => range.start,
            _ => tally::part_of(&self.ground, zones, range, at)?,
        };
        Some(zones.voxel_offset() + k)
    }

    fn pane_zone(&self, pane: usize, at: Vec3) -> Option<usize> {
        let zones = self.zones?;
        let own = (0..zones.panes.len()).filter(|&k| zones.panes[k].pane == pane);
        let k = own.min_by(|&a, &b| {
            outside(&zones.panes[a].plate, at).total_cmp(&outside(&zones.panes[b].plate, at))
        })?;
        Some(zones.pane_offset() + k)
    }
}

impl Walk {
    /// The normal of the side of its facet that it starts from.
    fn direction_side(&self, scene: &Scene, facet: u32) -> Vec3 {
        let n = scene.facets()[facet as usize].plate.normal();
        if n.dot(self.direction) >= 0.0 { n } else { -n }
    }
}

/// How far the parameters of a point lie outside a plate; negative within.
fn outside(p: &Plate, at: Vec3) -> f64 {
    let [u, v] = p.parameters(at);
    let far = if p.kind == zonal_scene::PlateKind::Triangle { u + v - 1.0 } else { u.max(v) - 1.0 };
    far.max(-u).max(-v)
}

/// A mean over batches.
fn estimate(sums: &[Vec<f64>], of: impl Fn(&[f64]) -> f64) -> Estimate {
    let mut tally = Tally::default();
    sums.iter().for_each(|s| tally.add(of(s)));
    tally.estimate(1.0)
}
