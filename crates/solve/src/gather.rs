//! Direct light on the zones, with as many shadow rays as each deserves.
//!
//! Each sample joins a point x of the zone with a point of the light. With w its contribution where nothing lies between, τ what the
//! medium and panes let pass (0 behind a facet) and U the light without obstacles (in closed form where it has one, else ⟨w⟩),
//!
//! ```text
//! H or G = ⟨U(x)⟩ R      R = Σ w τ / Σ w
//! ```
//!
//! so that a zone seen whole has no noise but that of τ. Points of a lamp are drawn by solid angle: w is bounded, and the share of them
//! that is seen is that of the light, beside a lamp as well. Points of the light form scrambled (0,2)-nets, those of the zone an R sequence;
//! of m such points the share s that is seen errs by about
//!
//! ```text
//! e = √(s(1−s)) m^(−3/4)     where the samples disagree (the border between seen and not seen runs through few of m strata);
//!                            beyond 256 samples it falls like m^(−5/8): points and directions have four dimensions
//! e = ½/(m+1)                where all agree, m counted over the zone and the 124 cells around it (25 of them for a patch)
//! ```
//!
//! A few samples first, everywhere; then others, so many as these let expect, where U e exceeds a share of the solve's tolerance times the root mean square of the
//! light over the zones of its kind; so many at most that the limits below allow, which grow where the tolerance is small. In open medium the ratios R of a cell and the 26 around it are averaged where the cell's own agrees
//! with that within its error: a penumbra is wider than a cell unless the light is a sun. All numbers are functions of zone and index.

use crate::open::{Open, Row};
use crate::surroundings::voxel_point;
use rayon::prelude::*;
use zonal_math::{Vec3, sequence};
use zonal_scene::{Bands, Light, PaneZone, Progress, Scene, Voxmap, Zones, bands};
use zonal_transport::Transport;
use zonal_transport::direct::{Lamp, Receiver};

/// Samples of every patch, and of every voxel, at first.
const PILOT: [usize; 2] = [8, 4];
/// The fewest samples of a zone that is looked at again; any number is a multiple of it.
const AGAIN: usize = 16;
/// The most samples of a patch and of a voxel: what is left of a voxel's error averages out along any path. More where the tolerance is
/// below [`FINE_TOLERANCE`], as many as that error needs, but no more than [`MOST_OF_ZONE`], nor than [`MAX_RAYS`] of all zones together.
const MOST: [usize; 2] = [256, 128];
const FINE_TOLERANCE: f64 = 0.02;
const MOST_OF_ZONE: usize = 1 << 14;
/// Shadow rays of one light to all zones together that a small tolerance may ask for.
const MAX_RAYS: usize = 1 << 26;
/// Samples beyond which the error of samples that disagree falls like the number to the power of −5/8.
const FOUR_DIMENSIONS: f64 = 256.0;
const RATE_BEYOND: f64 = 0.625;
/// Samples of a voxel whose ratio is averaged with those around it.
const AVERAGED: usize = 16;
/// Wanted error over tolerance and root mean square, of patches and of volume zones, whose errors average out along any path.
pub(crate) const SHARE: [f64; 2] = [0.35, 0.45];
/// The error told over the one above, which holds in the mean: of penumbras sampled often it is up to a third too small.
const TOLD: f64 = 1.5;
/// Where there is less light the error wanted falls with it, to this share.
const DIM: [f64; 2] = [0.25, 0.7];
/// The ratio of a cell may differ from the mean around it by so many of its own errors.
const AGREES: f64 = 3.0;
/// Nor may it change more than this from one side of the 27 cells to the other.
const LEVEL: f64 = 0.12;
/// A mean over 27 cells is taken to err by this share of that change, and by the next one of the cell's own error.
const CURVED: f32 = 0.1;
const CALMED: f32 = 0.25;
/// Points of a pane, and samples of the light at each; the most points over the first ones, and parts whose spread tells the error.
const PANE_POINTS: usize = 48;
const PANE_SAMPLES: usize = 6;
const PANE_MORE: usize = 8;
const PANE_PARTS: usize = 8;
/// First samples are compared over so many cells to each side: a share of the light that all of them miss is too small to count.
const AROUND: usize = 2;
/// Of the zones whose own first samples agree about this share have others around it that do not, for the forecast.
const AGREEING: f64 = 0.5;
/// Zones at a time.
const CHUNK: usize = 256;

/// A light on all zones.
pub(crate) struct Gathered {
    /// H_dir of patches, G_dir of volume zones, W/m².
    pub fields: Vec<Bands>,
    /// Standard error, W/m².
    pub error: Vec<Bands>,
    /// Shadow rays.
    pub rays: u64,
    /// The largest error of a kind of zones, root mean square over that of the light, and the most samples that a zone could have.
    pub limited: (f64, usize),
}

/// What the samples of one zone said.
#[derive(Clone, Copy, Default)]
struct Tally {
    count: usize,
    /// Σ of U.
    free: Bands,
    /// Σ of the square of its largest band.
    free2: f64,
    /// Σ of w, and of w τ.
    sent: Bands,
    arrived: Bands,
    /// Σ over samples of the largest band of w, its square, and those seen.
    weight: f64,
    square: f64,
    seen: f64,
    /// Σ over those seen of w τ and w τ², τ the largest band.
    through: f64,
    through2: f64,
}

fn largest(v: Bands) -> f64 {
    v[0].max(v[1]).max(v[2])
}

impl Tally {
    /// Share of the light that is seen; unknown where no sample could contribute.
    fn share(&self) -> f64 {
        if self.weight > 0.0 { self.seen / self.weight } else { 0.5 }
    }
    /// Arrived over sent.
    fn ratio(&self) -> Bands {
        bands(|b| if self.sent[b] > 0.0 { self.arrived[b] / self.sent[b] } else { 0.0 })
    }
}

/// One light, ready to be gathered.
struct Gatherer<'a> {
    zones: &'a Zones,
    transport: &'a Transport<'a>,
    lamp: Lamp<'a>,
    /// True where U is had in closed form.
    closed: bool,
    /// True for points of the scene itself.
    inside: bool,
    map: Option<&'a Voxmap>,
    cell: Vec3,
}

/// The outcome for one zone.
#[derive(Clone, Copy, Default)]
struct One {
    /// ⟨U⟩.
    full: Bands,
    ratio: Bands,
    /// Share seen, 0.5 where unknown.
    share: f32,
    /// Error relative to U; at first without what samples that all agree may have missed.
    error: f32,
    count: u16,
}

impl One {
    fn value(&self) -> Bands {
        bands(|b| self.full[b] * self.ratio[b])
    }
    /// Bit 0: some sample was not seen; bit 1: some was.
    fn state(&self) -> u8 {
        u8::from(self.share < 1.0) | u8::from(self.share > 0.0) << 1
    }
    /// Every sample was seen, or none.
    fn agrees(&self) -> bool {
        self.share == 0.0 || self.share == 1.0
    }
}

impl<'a> Gatherer<'a> {
    fn new(
        scene: &'a Scene,
        zones: &'a Zones,
        transport: &'a Transport<'a>,
        light: &'a Light,
    ) -> Gatherer<'a> {
        let lamp = Lamp::new(scene, light);
        Gatherer {
            zones,
            transport,
            closed: lamp.has_closed_form(),
            inside: matches!(light, Light::Emitter { .. }),
            map: scene.voxmap(),
            cell: scene.voxmap().map_or(Vec3::ZERO, |v| v.cell()),
            lamp,
        }
    }

    /// Adds samples `first..last` of zone `i`.
    fn add(&self, t: &mut Tally, i: usize, first: usize, last: usize) {
        let seed = |m: u64| sequence::hash((i as u64) << 3 | m);
        let shift = [0, 1, 2].map(|m| sequence::unit((i as u64) << 3 | m));
        let (scramble, turn) = ([seed(3) as u32, seed(4) as u32], seed(5) as u32);
        let patch = self.zones.patches.get(i);
        for k in first..last {
            let [u, v, w] = sequence::r3(k, shift);
            let (x, receiver) = match patch {
                Some(p) => {
                    let [u, v] = p.plate.warp([u, v]);
                    (p.plate.at(u, v), Receiver::Surface(p.normal))
                }
                None => {
                    let z = &self.zones.voxels[i - self.zones.voxel_offset()];
                    (voxel_point(z, self.cell, [u, v, w]), Receiver::Free)
                }
            };
            let [p, q] = sequence::net(k as u32, scramble);
            self.sample(t, x, receiver, [p, q, sequence::third(k as u32, turn)]);
        }
    }

    fn sample(&self, t: &mut Tally, x: Vec3, receiver: Receiver, s: [f64; 3]) {
        t.count += 1;
        let (free, beam) = self.lamp.beam_of_all(self.transport, x, receiver, s);
        let Some(beam) = beam else {
            return;
        };
        t.free = bands(|b| t.free[b] + free[b]);
        t.free2 += largest(free).powi(2);
        let w = largest(beam.flux);
        t.weight += w;
        t.square += w * w;
        t.sent = bands(|b| t.sent[b] + beam.flux[b]);
        let tau = match self.inside {
            true => self.transport.transmittance_inside(x, beam.end),
            false => self.transport.transmittance(x, beam.end),
        };
        if let Some(tau) = tau {
            t.seen += w;
            t.arrived = bands(|b| t.arrived[b] + tau[b] * beam.flux[b]);
            let tau = largest(tau);
            (t.through, t.through2) = (t.through + w * tau, t.through2 + w * tau * tau);
        }
    }

    fn one(&self, t: &Tally) -> One {
        let m = t.count as f64;
        let full = if self.closed { t.free } else { t.sent }.map(|x| x / m);
        let s = t.share();
        let equal = if t.weight > 0.0 { t.weight * t.weight / (m * t.square) } else { 1.0 };
        // Without a closed form the flux itself is a mean over samples; with one a few strong samples say which share is seen.
        let (flux, effective) = if self.closed {
            let square = largest(t.free).powi(2);
            (if square > 0.0 { m * t.free2 / square - 1.0 } else { 0.0 }, m * equal)
        } else {
            (1.0 / equal - 1.0, m)
        };
        // The medium dims the samples that are seen unequally.
        let dim = if t.seen > 0.0 { t.through2 / t.seen - (t.through / t.seen).powi(2) } else { 0.0 };
        let slow = (effective / FOUR_DIMENSIONS).max(1.0).powf(0.75 - RATE_BEYOND);
        let error =
            (s * (1.0 - s + dim.max(0.0)) + s * s * flux.max(0.0)).sqrt() * effective.powf(-0.75) * slow;
        One {
            full,
            ratio: t.ratio(),
            share: s as f32,
            error: error as f32,
            count: t.count.min(u16::MAX as usize) as u16,
        }
    }

    /// Zone `i` from the samples of a range.
    fn look(&self, i: usize, samples: std::ops::Range<usize>) -> One {
        let mut t = Tally::default();
        self.add(&mut t, i, samples.start, samples.end);
        if t.weight == 0.0 && self.closed {
            return self.one_of_none(i, t.count);
        }
        self.one(&t)
    }

    /// Zone `i` where the light faces none of `count` points: nothing arrives, but a plane of the light may cut off a corner.
    fn one_of_none(&self, i: usize, count: usize) -> One {
        let mut full = [0.0; 3];
        let mut corner = |x: Vec3, receiver| {
            let free = self.lamp.unhindered(x, receiver);
            full = bands(|b| free[b].max(full[b]));
        };
        if let Some(p) = self.zones.patches.get(i) {
            let (corners, n) = p.plate.corners();
            corners[..n].iter().for_each(|&x| corner(x, Receiver::Surface(p.normal)));
        } else if let Some(map) = self.map {
            let [x, y, z] = map.coordinates(self.zones.voxels[i - self.zones.voxel_offset()].cell);
            (0..8).for_each(|k| {
                corner(map.corner([x + (k & 1), y + (k >> 1 & 1), z + (k >> 2)]), Receiver::Free)
            });
        }
        let share = if full == [0.0; 3] { 0.5 } else { 0.0 };
        One { full, share, count: count.min(u16::MAX as usize) as u16, ..One::default() }
    }

    /// Zone `i` from samples of its own choosing, so many that after what `first` said its error is `wanted` (W/m²), but no more than
    /// `most`. They are fresh ones: a number that depends on samples must not depend on those that are averaged, or zones that see little
    /// would come out too dark.
    fn again(&self, i: usize, first: &One, most: usize, wanted: f64) -> One {
        let (m, e) = (first.count as f64, largest(first.full) * error(first, 0));
        // e falls like m^(−3/4), or like 1/m where all agree.
        let power = if first.agrees() { 1.0 } else { 4.0 / 3.0 };
        let mut wish = m * (e / wanted).powf(power);
        if !first.agrees() && wish > FOUR_DIMENSIONS {
            wish = FOUR_DIMENSIONS * (wish / FOUR_DIMENSIONS).powf(0.75 / RATE_BEYOND);
        }
        let wish = wish.min(most as f64).ceil() as usize;
        let samples = wish.next_multiple_of(AGAIN).clamp(AGAIN, most);
        let one = self.look(i, MOST[0]..MOST[0] + samples);
        One { error: error(&one, 0) as f32, ..one }
    }

    /// `f` of the first `n` zones.
    fn all(&self, n: usize, progress: &dyn Progress, f: impl Fn(usize) -> One + Sync) -> Vec<One> {
        let mut out = vec![One::default(); n];
        out.par_chunks_mut(CHUNK).enumerate().for_each(|(c, list)| {
            list.iter_mut().enumerate().for_each(|(k, one)| *one = f(c * CHUNK + k));
            progress.advance(list.len() as u64);
        });
        out
    }

    /// G_dir of pane zone `k` and its standard error from the spread of parts of `count` points.
    fn pane(&self, k: usize, count: usize) -> [Bands; 2] {
        let (p, i) = (&self.zones.panes[k], self.zones.pane_offset() + k);
        let shift = [0, 1].map(|m| sequence::unit((i as u64) << 3 | m));
        let mut parts = [[0.0; 3]; PANE_PARTS];
        for n in 0..count {
            let [u, v] = p.plate.warp(sequence::r2(n, shift));
            let seed = match n < PANE_POINTS {
                true => (i * PANE_POINTS + n) as u64,
                false => sequence::hash((i as u64) << 20 | n as u64),
            };
            let g = self.pane_fluence(p, p.plate.at(u, v), seed);
            let part = &mut parts[n % PANE_PARTS];
            *part = bands(|b| part[b] + g[b] / (count / PANE_PARTS) as f64);
        }
        const N: f64 = PANE_PARTS as f64;
        let mean = bands(|b| parts.iter().map(|p| p[b]).sum::<f64>() / N);
        let square = bands(|b| parts.iter().map(|p| (p[b] - mean[b]).powi(2)).sum::<f64>());
        [mean, square.map(|s| (s / (N * (N - 1.0))).sqrt())]
    }

    /// G_dir of all pane zones with their errors and rays: first points everywhere, more where the error exceeds a share of the tolerance. A spread of few
    /// parts is itself uncertain: the error told is the mean square of a zone's own and of the relative one of all panes.
    fn panes(&self, tolerance: f64) -> (Vec<[Bands; 2]>, u64) {
        let n = self.zones.panes.len();
        let mut found: Vec<[Bands; 2]> = (0..n).into_par_iter().map(|k| self.pane(k, PANE_POINTS)).collect();
        let square =
            |of: usize, found: &[[Bands; 2]]| found.iter().map(|f| largest(f[of]).powi(2)).sum::<f64>();
        let level = (square(0, &found) / n.max(1) as f64).sqrt();
        let more: Vec<u64> = found
            .par_iter_mut()
            .enumerate()
            .map(|(k, f)| {
                let wanted = SHARE[1] * tolerance * largest(f[0]).clamp(DIM[1] * level, level);
                let off = largest(f[1]) / wanted;
                if level <= 0.0 || off <= 1.0 {
                    return 0;
                }
                let finer = (FINE_TOLERANCE / tolerance).max(1.0);
                let most = (PANE_MORE as f64 * finer * finer).min((MOST_OF_ZONE / PANE_POINTS) as f64);
                let count = PANE_POINTS * (off * off).min(most).ceil() as usize;
                *f = self.pane(k, count);
                count as u64
            })
            .collect();
        let pooled = square(1, &found) / square(0, &found).max(f64::MIN_POSITIVE);
        for [g, e] in &mut found {
            *e = bands(|b| (0.5 * (e[b] * e[b] + pooled * g[b] * g[b])).sqrt());
        }
        let points = more.iter().sum::<u64>() + (n * PANE_POINTS) as u64;
        (found, 3 * points * PANE_SAMPLES as u64)
    }

    /// Fluence inside a pane that stands for what it takes from the light: κ G t = Σ E c (1 − e^{−κt/c}), c the cosine.
    fn pane_fluence(&self, p: &PaneZone, at: Vec3, seed: u64) -> Bands {
        let source = |r: Receiver| self.lamp.gather(self.transport, at, r, PANE_SAMPLES, seed);
        let front = source(Receiver::Surface(p.normal));
        let back = source(Receiver::Surface(-p.normal));
        let fluence = source(Receiver::Free);
        bands(|b| {
            let flux = front[b] + back[b];
            if flux <= 0.0 || fluence[b] <= 0.0 {
                return 0.0;
            }
            let cos = (flux / fluence[b]).clamp(1e-6, 1.0);
            let depth = p.extinction[b] * p.thickness;
            let share = if depth > 1e-12 { -(-depth / cos).exp_m1() / depth } else { 1.0 / cos };
            flux * share
        })
    }

    /// The cell of a voxel zone, or before a patch.
    fn cell_of(&self, map: &Voxmap, i: usize) -> Option<usize> {
        let Some(p) = self.zones.patches.get(i) else {
            return Some(self.zones.voxels[i - self.zones.voxel_offset()].cell);
        };
        let before = p.plate.centre() + p.normal * (0.25 * largest(map.cell().array()));
        map.cell_at(before).map(|c| map.index(c))
    }
}

/// What the first samples around each cell said.
struct Calm<'a> {
    map: &'a Voxmap,
    /// Over the cells up to [`AROUND`] away along each axis: bit 0, some sample was not seen; bit 1, some was.
    states: Vec<u8>,
}

impl<'a> Calm<'a> {
    fn new(g: &Gatherer, map: &'a Voxmap, first: &[One]) -> Calm<'a> {
        let offset = g.zones.voxel_offset();
        let cell = |c: usize| g.zones.of_cell(c).fold(0, |s, z| s | first[z + offset].state());
        let mut states: Vec<u8> = (0..map.len()).map(cell).collect();
        let dims = map.dims();
        for (axis, stride) in [dims[1] * dims[2], dims[2], 1].into_iter().enumerate() {
            let spread = |c: usize| {
                let at = c / stride % dims[axis];
                let (back, ahead) = (at.min(AROUND), (dims[axis] - 1 - at).min(AROUND));
                (c - back * stride..=c + ahead * stride).step_by(stride).fold(0, |s, d| s | states[d])
            };
            states = (0..map.len()).into_par_iter().map(spread).collect();
        }
        Calm { map, states }
    }

    /// Samples around zone `i` that all agree with its own; none where some do not.
    fn agreeing(&self, g: &Gatherer, one: &One, i: usize) -> usize {
        let around = g.cell_of(self.map, i).map(|c| self.states[c]);
        let side: usize = 2 * AROUND + 1;
        // Of the creases of a surface the cells before it say less than of themselves.
        let count = side.pow(if i < g.zones.voxel_offset() { 2 } else { 3 });
        if around == Some(one.state()) && one.agrees() { PILOT[1] * count } else { 0 }
    }
}

/// Error relative to U with `more` samples around that agree.
fn error(one: &One, more: usize) -> f64 {
    let prior = if one.agrees() { 0.5 / (one.count as f64 + more as f64 + 1.0) } else { 0.0 };
    (one.error as f64).hypot(prior)
}

/// The most samples of each patch and each voxel of `n` zones together.
fn most(scene: &Scene, n: usize) -> [usize; 2] {
    let finer = (FINE_TOLERANCE / scene.options().tolerance).max(1.0).powf(1.0 / RATE_BEYOND);
    let all = (MAX_RAYS / n.max(1)).min(MOST_OF_ZONE);
    MOST.map(|m| ((m as f64 * finer) as usize).min(all).max(m).next_multiple_of(AGAIN))
}

/// The error wanted of the zones of a kind, W/m².
struct Wanted {
    /// Root mean square of the light.
    level: f64,
    share: f64,
    dim: f64,
}

impl Wanted {
    fn new(scene: &Scene, first: &[One], kind: usize) -> Wanted {
        Wanted {
            level: root_mean_square(first),
            share: SHARE[kind] * scene.options().tolerance,
            dim: DIM[kind],
        }
    }

    fn of(&self, one: &One) -> f64 {
        self.share * largest(one.value()).clamp(self.dim * self.level, self.level)
    }
}

/// Root mean square of the largest band over some zones.
fn root_mean_square(list: &[One]) -> f64 {
    let square = |c: &[One]| c.iter().map(|o| largest(o.value()).powi(2)).sum::<f64>();
    let parts: Vec<f64> = list.par_chunks(CHUNK).map(square).collect();
    (parts.iter().sum::<f64>() / list.len().max(1) as f64).sqrt()
}

/// About how many shadow rays [`gather`] will take, from `sample` zones.
pub(crate) fn rays(scene: &Scene, zones: &Zones, transport: &Transport, light: &Light, sample: usize) -> f64 {
    let g = Gatherer::new(scene, zones, transport, light);
    let (n, patches) = (zones.pane_offset(), zones.voxel_offset());
    let sharp = matches!(light, Light::Sun { .. });
    let most = most(scene, n);
    let of = |range: std::ops::Range<usize>, kind: usize| {
        let step = (range.len() / sample.max(1)).max(1);
        let list: Vec<usize> = range.step_by(step).collect();
        let first: Vec<One> = list.par_iter().map(|&i| g.look(i, 0..PILOT[kind])).collect();
        let wanted = Wanted::new(scene, &first, kind);
        let more = |(o, &i): (&One, &usize)| {
            let wanted = wanted.of(o);
            if largest(o.full) * error(o, 0) <= wanted {
                return 0.0;
            }
            let calm = !sharp && i >= patches && zones.voxels[i - patches].part.is_empty();
            let share = if o.agrees() { AGREEING } else { 1.0 };
            share * g.again(i, o, if calm { AVERAGED } else { most[kind] }, wanted).count as f64
        };
        let again: Vec<f64> = first.par_iter().zip(&list).map(more).collect();
        step as f64 * (again.iter().sum::<f64>() + (list.len() * PILOT[kind]) as f64)
    };
    let panes = 3 * zones.panes.len() * PANE_POINTS * PANE_SAMPLES;
    of(0..patches, 0) + of(patches..n, 1) + panes as f64
}

/// Gathers one light on all zones.
pub(crate) fn gather(
    scene: &Scene,
    zones: &Zones,
    transport: &Transport,
    light: &Light,
    progress: &dyn Progress,
) -> Gathered {
    let g = Gatherer::new(scene, zones, transport, light);
    let (n, patches) = (zones.pane_offset(), zones.voxel_offset());
    let limit = most(scene, n);
    progress.begin("direct light", 2 * n as u64);
    let first = g.all(n, progress, |i| g.look(i, 0..PILOT[usize::from(i >= patches)]));
    let limits = [Wanted::new(scene, &first[..patches], 0), Wanted::new(scene, &first[patches..], 1)];
    let wanted = |i: usize, one: &One| limits[usize::from(i >= patches)].of(one);
    let calm = scene.voxmap().map(|m| Calm::new(&g, m, &first));
    let open = scene
        .voxmap()
        .filter(|_| !matches!(light, Light::Sun { .. }))
        .map(|m| Open::new(m, zones, transport));
    let open = |i: usize| open.as_ref().filter(|_| i >= patches).and_then(|o| o.cube(i - patches, 1));
    let second = g.all(n, progress, |i| {
        let more = calm.as_ref().map_or(0, |c| c.agreeing(&g, &first[i], i));
        if largest(first[i].full) * error(&first[i], more) <= wanted(i, &first[i]) {
            return One { error: error(&first[i], more) as f32, ..first[i] };
        }
        let most = if open(i).is_some() { AVERAGED } else { limit[usize::from(i >= patches)] };
        g.again(i, &first[i], most, wanted(i, &first[i]))
    });
    let counted = |list: &[One]| list.iter().map(|o| o.count as u64).sum::<u64>();
    let rays = counted(&first) + counted(&second);
    drop(first);
    let settled = |i: usize| -> (Bands, Bands, u64) {
        let own = &second[i];
        let spread = |o: &One| o.full.map(|x| TOLD * x * o.error as f64);
        let told = |o: &One| (o.value(), spread(o), 0);
        let Some(rows) = open(i).filter(|_| largest(own.full) * own.error as f64 > wanted(i, own)) else {
            return told(own);
        };
        let (mean, slope) = mean(rows, &second[patches..]);
        let off = (0..3).map(|b| (own.ratio[b] - mean[b]).abs()).fold(0.0, f64::max);
        if off <= AGREES * own.error as f64 && slope <= LEVEL {
            let error = (CALMED * own.error).hypot(CURVED * slope as f32);
            let calm = One { ratio: mean, error, ..*own };
            return told(&calm);
        }
        let again = g.again(i, own, limit[1], wanted(i, own));
        (again.value(), spread(&again), again.count as u64)
    };
    let settled: Vec<(Bands, Bands, u64)> = (0..n).into_par_iter().map(settled).collect();
    let (panes, pane_rays) = g.panes(scene.options().tolerance);
    progress.end();
    let fields: Vec<Bands> = settled.iter().map(|s| s.0).chain(panes.iter().map(|p| p[0])).collect();
    let error: Vec<Bands> = settled.iter().map(|s| s.1).chain(panes.iter().map(|p| p[1])).collect();
    let relative = |range: std::ops::Range<usize>| {
        let [e, f]: [f64; 2] = crate::columns::sum(range.len(), |k| {
            [&error, &fields].map(|list| largest(list[range.start + k]).powi(2))
        });
        if e > 0.0 { (e / f).sqrt() } else { 0.0 }
    };
    let worst = relative(0..patches).max(relative(patches..n)).max(relative(n..zones.len()));
    let rays = rays + settled.iter().map(|s| s.2).sum::<u64>() + pane_rays;
    Gathered { fields, error, rays, limited: (worst, limit[0].max(limit[1])) }
}

/// Mean ratio over the rows of 27 cells, and its largest change from one side to the other.
fn mean(rows: impl Iterator<Item = Row>, list: &[One]) -> (Bands, f64) {
    let (mut sum, mut change) = ([0.0; 3], [[0.0; 3]; 3]);
    for row in rows {
        for (z, away) in row.zones.zip([-1.0, 0.0, 1.0]) {
            let one = &list[z];
            let d = [row.steps[0] as f64, row.steps[1] as f64, away];
            for b in 0..3 {
                sum[b] += one.ratio[b] / 27.0;
                (0..3).for_each(|k| change[k][b] += d[k] * one.ratio[b] / 9.0);
            }
        }
    }
    (sum, change.iter().flatten().fold(0.0, |m, c| c.abs().max(m)))
}

#[cfg(test)]
mod coverage;
#[cfg(test)]
mod tests;
