//! Rays of one zone towards the surroundings: evenly, or to the openings that they leave by.
//!
//! What a zone sees of the sky through a window is a mean over its places and over directions of a function that is 0 almost everywhere
//! and jumps at the window's frame, which lies elsewhere from every place. As a mean over its places and over points y of the opening,
//!
//! ```text
//!     g/A  = ⟨ cosθ cosθ_y τ/(π r²) ⟩ A_y   of a patch,      g/4V = ⟨ cosθ_y τ/(4π r²) ⟩ A_y   of a volume,
//! ```
//!
//! it is smooth. Every ray that leaves does so through the box about the scene; its sides are cut into cells, and a few rays of every zone,
//! which do not count, tell by which of them rays leave at all. For one zone these open cells, but for those near it, are strata of points
//! y; all other rays that leave are one more, of directions. So nothing is missed, and since only rays that do not count decide where rays
//! go, nothing is biased. Of N rays a stratum gets the share of its spread among all spreads, which is best for independent rays (Neyman),
//! by a few first rays. In a stratum rays follow a sequence of their own, and the spread of its batches gives its variance.

use crate::surroundings::{fate, numbers, pane_share, place, ray_at};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::ops::Range;
use zonal_exchange::pair::SUCCESSION;
use zonal_math::{Vec3, sequence};
use zonal_scene::{Bands, Scene, Zones, bands};
use zonal_transport::Transport;

/// Batches whose spread tells the error.
const BATCHES: usize = 8;
/// Cells along the longest side of the box, and cells that may be open: more are not openings but the open.
const CELLS: f64 = 32.0;
const OPEN: usize = 512;
/// Rays that find them, of all zones, and of one at most.
const SEARCH: usize = 1 << 21;
const OWN: usize = 512;
/// A cell is near whose centre is not as many times as far as it and the zone are large (half their diagonals together).
const NEAR: f64 = 1.5;
/// First rays to a cell, and in directions.
const LOOK: usize = 4;
const AROUND: usize = 256;
/// The least spread of what a ray to a cell counts, over what it would if nothing were in its way.
const UNSEEN: f64 = 0.25;
/// The least share of a stratum over the mean one, its fewest rays, and the least share of the rays in directions.
const LEAST: f64 = 0.2;
const FEW: usize = 2;
const REST: f64 = 0.1;
/// Rays that count, of the first round, and rounds after it, each with at most so many times as many.
const BEGIN: usize = 1024;
const ROUNDS: usize = 4;
const MORE: f64 = 8.0;
/// Rays of a zone at most, from which on openings are looked for.
pub(crate) const WORTHWHILE: usize = 4 * BEGIN;

/// Where rays of zones fly.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Room<'a> {
    pub scene: &'a Scene,
    pub zones: &'a Zones,
    pub transport: &'a Transport<'a>,
    /// Of the sample.
    pub seed: u64,
}

/// What rays of one zone met.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Met {
    /// Sums over the rays that went to the sky, and that ended on black backs.
    pub sums: [Bands; 2],
    /// Variance of the first of these sums.
    pub variance: Bands,
    /// Number of these rays.
    pub count: u32,
    /// Number of all rays that count, and of those that only looked.
    pub shot: u32,
    pub looked: u32,
}

impl Met {
    /// What rays `range` met, each with its fate (share of the sky or, if true, of backs), in batches of successive ones.
    fn of(range: Range<usize>, fate: impl Fn(usize) -> (Bands, bool)) -> Met {
        let mut met = Met { shot: range.len() as u32, ..Met::default() };
        // Sums of the batches, with their rays.
        let mut own = Vec::with_capacity(BATCHES);
        for batch in 0..BATCHES {
            let at = |b: usize| range.start + b * range.len() / BATCHES;
            let before = met.sums[0];
            for k in at(batch)..at(batch + 1) {
                let (share, back) = fate(k);
                met.count += u32::from(share != [0.0; 3]);
                let sums = &mut met.sums[back as usize];
                (0..3).for_each(|b| sums[b] += share[b]);
            }
            if at(batch) < at(batch + 1) {
                let sum = bands(|b| met.sums[0][b] - before[b]);
                own.push((sum, (at(batch + 1) - at(batch)) as f64));
            }
        }
        if own.len() > 1 {
            let (mean, n) = (met.sums[0].map(|s| s / range.len() as f64), own.len() as f64);
            let spread =
                |b: usize| own.iter().map(|(sum, rays)| (sum[b] - rays * mean[b]).powi(2)).sum::<f64>();
            met.variance = bands(|b| spread(b) * n / (n - 1.0));
        }
        met
    }

    /// Rays `range` of zone `i`, spread evenly.
    pub(crate) fn evenly(room: &Room, i: usize, range: Range<usize>) -> Met {
        Met::of(range, |k| room.shoot(room.ray(i, numbers(i, room.seed, k))))
    }

    /// Adds what other rays met.
    pub(crate) fn add(&mut self, o: &Met) {
        self.sums = [0, 1].map(|k| bands(|b| self.sums[k][b] + o.sums[k][b]));
        self.variance = bands(|b| self.variance[b] + o.variance[b]);
        (self.count, self.shot) = (self.count + o.count, self.shot + o.shot);
    }

    /// The mean share of the sky, and its standard error.
    pub(crate) fn sky(&self) -> Bands {
        self.sums[0].map(|s| s / self.shot.max(1) as f64)
    }
    pub(crate) fn error(&self) -> Bands {
        match self.count {
            0 => [1.0 / (self.shot as f64 + SUCCESSION); 3],
            _ => self.variance.map(|v| v.sqrt() / self.shot.max(1) as f64),
        }
    }

    /// Of strata whose means add up, what one zone's rays met as if they had been spread evenly.
    fn together(strata: &[Met]) -> Met {
        let shot: u32 = strata.iter().map(|s| s.shot).sum();
        let mut all = Met { shot, count: strata.iter().map(|s| s.count).sum(), ..Met::default() };
        for s in strata.iter().filter(|s| s.shot > 0) {
            let weight = shot as f64 / s.shot as f64;
            all.sums = [0, 1].map(|k| bands(|b| all.sums[k][b] + weight * s.sums[k][b]));
            all.variance = bands(|b| all.variance[b] + weight * weight * s.variance[b]);
        }
        all
    }
}

impl Room<'_> {
    fn cell(&self) -> Vec3 {
        self.scene.voxmap().map_or(Vec3::ZERO, |v| v.cell())
    }

    /// What a ray with a weight meets.
    fn shoot(&self, (origin, dir, weight): (Vec3, Vec3, Bands)) -> (Bands, bool) {
        if weight == [0.0; 3] {
            return (weight, false);
        }
        let (share, back) = fate(self.scene, self.transport, origin, dir);
        (bands(|b| share[b] * weight[b]), back)
    }

    /// The ray of zone `i` from its place `p` in the direction `d`.
    fn ray(&self, i: usize, (p, d): ([f64; 3], [f64; 2])) -> (Vec3, Vec3, Bands) {
        ray_at(self.zones, self.cell(), i, p, d)
    }

    /// Centre and half the diagonal of zone `i`.
    fn ball(&self, i: usize) -> (Vec3, f64) {
        let plate = |p: &zonal_scene::Plate| (p.centre(), 0.5 * p.diameter());
        if i < self.zones.voxel_offset() {
            return plate(&self.zones.patches[i].plate);
        }
        match i.checked_sub(self.zones.pane_offset()) {
            Some(k) => plate(&self.zones.panes[k].plate),
            None => (self.zones.voxels[i - self.zones.voxel_offset()].centre, 0.5 * self.cell().length()),
        }
    }
}

/// A cell of a side of the box: one corner, two edges, and the outer normal.
#[derive(Clone, Copy, Debug)]
struct Cell {
    corner: Vec3,
    edges: [Vec3; 2],
    normal: Vec3,
}

impl Cell {
    fn centre(&self) -> Vec3 {
        self.corner + (self.edges[0] + self.edges[1]) * 0.5
    }
    fn area(&self) -> f64 {
        self.edges[0].length() * self.edges[1].length()
    }
}

/// The cells of the box about the scene through which rays leave it.
#[derive(Clone, Debug)]
pub(crate) struct Openings<'a> {
    room: Room<'a>,
    sides: Sides,
    open: Vec<Cell>,
    /// Of every cell, its number among the open ones.
    number: Vec<Option<u16>>,
}

/// The box, and the number of cells along its edges.
#[derive(Clone, Copy, Debug)]
struct Sides {
    low: [f64; 3],
    high: [f64; 3],
    cells: [usize; 3],
}

impl Sides {
    fn of(scene: &Scene) -> Sides {
        let [low, high] = [scene.bounds().0, scene.bounds().1].map(Vec3::array);
        let longest = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
        let along = |k: usize| (CELLS * (high[k] - low[k]) / longest).ceil().max(1.0) as usize;
        Sides { low, high, cells: [0, 1, 2].map(along) }
    }

    /// The two axes along a side.
    fn along(axis: usize) -> [usize; 2] {
        [(axis + 1) % 3, (axis + 2) % 3]
    }

    /// Cells before the side at the upper or lower end of `axis`; with (3, false), all of them.
    fn first(&self, axis: usize, upper: bool) -> usize {
        let of = |axis: usize| Sides::along(axis).iter().map(|&k| self.cells[k]).product::<usize>();
        (0..axis).map(|k| 2 * of(k)).sum::<usize>() + if upper { of(axis) } else { 0 }
    }

    /// The cell through which a ray from inside leaves.
    fn exit(&self, origin: Vec3, dir: Vec3) -> usize {
        let (o, d) = (origin.array(), dir.array());
        let far = |k: usize| match d[k] {
            0.0 => f64::INFINITY,
            _ => ((if d[k] > 0.0 { self.high[k] } else { self.low[k] }) - o[k]) / d[k],
        };
        let axis = (1..3).fold(0, |least, k| if far(k) < far(least) { k } else { least });
        let at = Sides::along(axis).map(|k| {
            let y = (o[k] + d[k] * far(axis) - self.low[k]) / (self.high[k] - self.low[k]);
            ((y * self.cells[k] as f64) as usize).min(self.cells[k] - 1)
        });
        self.first(axis, d[axis] > 0.0) + at[0] * self.cells[Sides::along(axis)[1]] + at[1]
    }

    /// All cells in the order of their numbers.
    fn all(&self) -> Vec<Cell> {
        let mut all = Vec::with_capacity(self.first(3, false));
        for (axis, upper) in (0..6).map(|s| (s / 2, s % 2 == 1)) {
            let along = Sides::along(axis);
            let edge = |k: usize| (self.high[k] - self.low[k]) / self.cells[k] as f64;
            let unit =
                |k: usize, x: f64| Vec3::from_array(std::array::from_fn(|m| if m == k { x } else { 0.0 }));
            for (m, n) in
                (0..self.cells[along[0]]).flat_map(|m| (0..self.cells[along[1]]).map(move |n| (m, n)))
            {
                let mut corner = self.low;
                corner[axis] = if upper { self.high[axis] } else { self.low[axis] };
                corner[along[0]] += m as f64 * edge(along[0]);
                corner[along[1]] += n as f64 * edge(along[1]);
                let normal = unit(axis, if upper { 1.0 } else { -1.0 });
                all.push(Cell {
                    corner: Vec3::from_array(corner),
                    edges: along.map(|k| unit(k, edge(k))),
                    normal,
                });
            }
        }
        all
    }
}

impl<'a> Openings<'a> {
    /// Looks for openings; none where rays leave nearly everywhere.
    pub(crate) fn find(room: Room<'a>) -> Option<Openings<'a>> {
        let n = room.zones.len();
        let sides = Sides::of(room.scene);
        let cells = sides.all();
        let own = (SEARCH / n.max(1)).clamp(1, OWN);
        // Rays that do not count later, for they are of another sample.
        let seed = sequence::hash(room.seed ^ u64::MAX);
        let leaves = |i: usize, k: usize| {
            let ray = room.ray(i, numbers(i, seed, k));
            let (share, back) = room.shoot(ray);
            (!back && share != [0.0; 3]).then(|| sides.exit(ray.0, ray.1))
        };
        let seen = |mut seen: Vec<bool>, i: usize| {
            (0..own).filter_map(|k| leaves(i, k)).for_each(|c| seen[c] = true);
            seen
        };
        let none = || vec![false; cells.len()];
        let either = |a: Vec<bool>, b: Vec<bool>| a.iter().zip(b).map(|(a, b)| *a || b).collect();
        let seen = (0..n).into_par_iter().fold(none, seen).reduce(none, either);
        let open: Vec<Cell> = cells.iter().zip(&seen).filter(|c| *c.1).map(|c| *c.0).collect();
        let mut count = 0..;
        let number = seen.iter().map(|s| if *s { count.next() } else { None }).collect();
        (open.len() <= OPEN).then_some(Openings { room, sides, open, number })
    }

    /// Rays of zone `i`, until errors (root of the sum of squares over bands) are `wanted`, or at most so many.
    pub(crate) fn measure(&self, i: usize, wanted: f64, most: usize) -> Met {
        let room = &self.room;
        let (centre, radius) = room.ball(i);
        let far = |c: &Cell| {
            let size = radius + 0.5 * (c.edges[0] + c.edges[1]).length();
            (c.centre() - centre).length() > NEAR * size
        };
        let far: Vec<bool> = self.open.iter().map(far).collect();
        let aims: Vec<&Cell> = self.open.iter().zip(&far).filter(|c| *c.1).map(|c| c.0).collect();
        let rest = aims.len();
        // What sets the sequence of a stratum apart from others; of its first rays, or of those that count.
        let apart = |c: usize, counts: bool| -> ([f64; 3], [u32; 2]) {
            let seed = (((i << 10) + c) as u64 * 2 + u64::from(counts)) ^ room.seed.rotate_left(32);
            let hash = sequence::hash(seed);
            (sequence::shift(hash), [hash as u32, (hash >> 32) as u32])
        };
        let ray = |c: usize, (shift, scramble), k: usize| {
            let (p, d) = (sequence::r3(k, shift), sequence::net(k as u32, scramble));
            if c < rest {
                return self.aim(i, p, aims[c], d);
            }
            let (origin, dir, weight) = room.ray(i, (p, d));
            let aimed = self.number[self.sides.exit(origin, dir)].is_some_and(|c| far[c as usize]);
            (origin, dir, if aimed { [0.0; 3] } else { weight })
        };
        let spread = |c: usize| {
            let apart = apart(c, false);
            let rays = (0..if c < rest { LOOK } else { AROUND }).map(|k| ray(c, apart, k));
            let (weights, met): (Vec<Bands>, Vec<Bands>) = rays.map(|r| (r.2, room.shoot(r).0)).unzip();
            if c < rest { spread(&met).max(UNSEEN * mean(&weights)) } else { spread(&met) }
        };
        let shares = shares((0..=rest).map(spread).collect());
        let mut strata = vec![Met::default(); rest + 1];
        let (mut all, mut rays) = (Met::default(), BEGIN.max(FEW * rest));
        for _ in 0..=ROUNDS {
            for (c, met) in strata.iter_mut().enumerate() {
                let upto = whole((rays as f64 * shares[c]) as usize).max(met.shot as usize);
                let apart = apart(c, true);
                met.add(&Met::of(met.shot as usize..upto, |k| room.shoot(ray(c, apart, k))));
            }
            all = Met::together(&strata);
            let off = all.error().iter().map(|e| e * e).sum::<f64>().sqrt() / wanted;
            if off <= 1.0 || rays >= most {
                break;
            }
            rays = ((rays as f64 * off.powf(4.0 / 3.0).min(MORE)) as usize).min(most);
        }
        Met { looked: (AROUND + LOOK * rest) as u32, ..all }
    }

    /// The ray of zone `i` from its place `p` to the point `d` of a cell.
    fn aim(&self, i: usize, p: [f64; 3], cell: &Cell, d: [f64; 2]) -> (Vec3, Vec3, Bands) {
        let zones = self.room.zones;
        let origin = place(zones, self.room.cell(), i, p);
        let r = cell.corner + cell.edges[0] * d[0] + cell.edges[1] * d[1] - origin;
        let dir = r.normalized();
        let solid = cell.normal.dot(dir).max(0.0) * cell.area() / r.length2();
        // The density of the zone's own rays in this direction, times their weight.
        let own = match i.checked_sub(zones.pane_offset()) {
            Some(k) => {
                let pane = &zones.panes[k];
                pane_share(pane, dir).map(|x| x * pane.normal.dot(dir).abs() / (2.0 * PI))
            }
            None if i < zones.voxel_offset() => [zones.patches[i].normal.dot(dir).max(0.0) / PI; 3],
            None => [0.25 / PI; 3],
        };
        (origin, dir, own.map(|x| x * solid))
    }
}

/// So many rays, or a few more, that make batches of one size.
fn whole(rays: usize) -> usize {
    if rays < BATCHES { rays.max(FEW) } else { rays.next_multiple_of(BATCHES) }
}

/// Mean of values, in the band where it is largest.
fn mean(values: &[Bands]) -> f64 {
    let sum = |b: usize| values.iter().map(|x| x[b]).sum::<f64>();
    sum(0).max(sum(1)).max(sum(2)) / values.len() as f64
}

/// Standard deviation of values, in the band where it is largest.
fn spread(values: &[Bands]) -> f64 {
    let n = values.len() as f64;
    let of = |b: usize| {
        let mean = values.iter().map(|x| x[b]).sum::<f64>() / n;
        values.iter().map(|x| (x[b] - mean).powi(2)).sum::<f64>() / n
    };
    of(0).max(of(1)).max(of(2)).sqrt()
}

/// What share of the rays each stratum gets, by spreads of which the last is that of directions.
fn shares(mut spreads: Vec<f64>) -> Vec<f64> {
    let Some(rest) = spreads.pop() else { return Vec::new() };
    let sum: f64 = spreads.iter().sum();
    let least = LEAST * sum / spreads.len().max(1) as f64;
    spreads.iter_mut().for_each(|s| *s = s.max(least));
    let sum: f64 = spreads.iter().sum();
    spreads.push(if sum > 0.0 { rest.max(REST * sum / (1.0 - REST)) } else { 1.0 });
    let sum: f64 = spreads.iter().sum();
    spreads.iter().map(|s| s / sum).collect()
}
