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
//! wrong with it is noise, which falls with the number of rays and with that of the zones over which light is alike. Panes stop rays as
//! the medium does, and send their own: what of its light meets a pane itself closes its row.
//!
//! Bands in which the medium differs share the ray by their mean; each counts by its own probability over that of the ray.

use super::kept;
use super::onward::{BLOCK, Lamps, Own, Step, brought, first_of, step_of};
use super::shooter::{BACK, LOST, NOWHERE, SKY, Shooter};
use crate::surroundings::Escape;
use rayon::prelude::*;
use zonal_exchange::pair::target;
use zonal_scene::{Bands, Progress, Scene, Vault, Zones, bands};
use zonal_transport::Transport;

/// Radiosities, or what else belongs to bands, W/m²; the fourth is nought, so that one load brings all.
pub type Shine = [f32; 4];

/// Three bands as [`Shine`].
pub fn shine(v: Bands) -> Shine {
    [v[0] as f32, v[1] as f32, v[2] as f32, 0.0]
}

/// What a ray counts as [`Shine`].
fn wide([a, b, c]: [f32; 3]) -> Shine {
    [a, b, c, 0.0]
}

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
    reflectance: Vec<Shine>,
    /// Of each pane zone: what of its own light meets itself, a share.
    within: Vec<Bands>,
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
        let mut views = Views {
            first,
            each,
            met: vec![LOST; total],
            worth: Vec::new(),
            steps: Default::default(),
            reflectance: if lamps.is_some() {
                zones.patches.iter().map(|p| shine(p.reflectance)).collect()
            } else {
                Vec::new()
            },
            within: (zones.pane_offset()..zones.len()).map(|i| shooter.within(i, each[1])).collect(),
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
            // `worth` is empty where all count 1.
            let block = |(z, met): (usize, &mut [u32]), worth: &mut [[f32; 3]]| {
                let mut steps = Vec::new();
                let of = |r: usize| (z + r / each, r % each);
                shooter.volley(met.len(), of, |r, stop| {
                    if let Some(w) = worth.get_mut(r) {
                        *w = stop.worth;
                    }
                    met[r] = lamps.map_or(stop.zone, |l| shooter.follow(l, of(r), stop, &mut steps));
                });
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

    /// What leaves the zones for good, put into `escape`.
    pub fn escape(&self, zones: &Zones, escape: &mut Escape) {
        let one = |i: usize| {
            let (mut found, range) = ([[0.0; 3]; 2], self.of(i));
            let over = target(zones, i) / range.len() as f64;
            for r in range.filter(|&r| self.met[r] == SKY || self.met[r] == BACK) {
                let worth = self.worth.get(r).copied().unwrap_or([1.0; 3]);
                let sum = &mut found[usize::from(self.met[r] == BACK)];
                (0..3).for_each(|b| sum[b] += over * worth[b] as f64);
            }
            found
        };
        let each = escape.sky.par_iter_mut().zip(&mut escape.backs).enumerate();
        each.for_each(|(i, (sky, backs))| [*sky, *backs] = one(i));
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

    /// Shows `each` what every ray of `range`, of a zone of these steps, brings where zones shine with radiosities `b`.
    #[inline(always)]
    fn bring(
        &self,
        range: std::ops::Range<usize>,
        steps: &[Step],
        b: &[Shine],
        way: Way,
        mut each: impl FnMut(Shine),
    ) {
        if self.worth.is_empty() {
            for &met in &self.met[range] {
                each(match b.get(met as usize) {
                    Some(b) => *b,
                    None => self.brings(steps, met, [1.0; 3], b, way),
                });
            }
        } else {
            for (met, worth) in self.met[range.clone()].iter().zip(&self.worth[range]) {
                each(self.brings(steps, *met, *worth, b, way));
            }
        }
    }

    /// What a ray brings that met a zone, or goes on from a step, and counts `worth`.
    #[inline]
    pub fn brings(&self, steps: &[Step], met: u32, worth: [f32; 3], b: &[Shine], way: Way) -> Shine {
        let worth = wide(worth);
        let bright = |zone: u32| {
            let b = b[zone as usize];
            [0, 1, 2, 3].map(|k| worth[k] * b[k])
        };
        let on = |at: usize, own| brought(steps, at, worth, &self.reflectance, b, own);
        match (step_of(met), way) {
            _ if met >= NOWHERE => [0.0; 4],
            (None, _) => bright(met),
            (Some(_), Way::Ends) => bright(first_of(met, steps)),
            (Some(at), Way::On) => on(at, None),
            (Some(at), Way::With(own)) => on(at, Some(own)),
        }
    }

    /// What arrives, H or G, where zones shine with radiosities `b`, by the first of so many rays.
    pub fn arriving(&self, b: &[Shine], way: Way, of: usize) -> Vec<Bands> {
        let one = |i: usize| {
            let (range, unit) = (self.of(i), self.unit(i));
            let count = range.len().div_ceil(of);
            let mut sum = [0.0; 4];
            self.bring(range.start..range.start + count, self.steps(i), b, way, |v| {
                (0..4).for_each(|x| sum[x] += v[x]);
            });
            let within = self.within(i, b);
            bands(|x| unit * ((sum[x] / count as f32) as f64 + within[x]))
        };
        (0..b.len()).into_par_iter().with_min_len(256).map(one).collect()
    }

    /// The same with standard errors.
    pub fn measured(&self, b: &[Shine], way: Way) -> Vec<Measured> {
        let one = |i: usize| {
            let range = self.of(i);
            let (m, unit) = (range.len() as f64, self.unit(i));
            let (mut sum, mut square) = ([0.0; 4], [0.0; 4]);
            self.bring(range, self.steps(i), b, way, |v| {
                let v = v.map(f64::from);
                (0..4).for_each(|x| sum[x] += v[x]);
                (0..4).for_each(|x| square[x] += v[x] * v[x]);
            });
            let h = sum.map(|s| s / m);
            let e = bands(|x| ((square[x] / m - h[x] * h[x]).max(0.0) / m).sqrt());
            let within = self.within(i, b);
            Measured { value: bands(|x| (h[x] + within[x]) * unit), error: e.map(|x| x * unit) }
        };
        (0..b.len()).into_par_iter().with_min_len(256).map(one).collect()
    }

    /// What zone `i` brings itself besides its rays where zones shine with radiosities `b`: nought but for a pane.
    pub fn within(&self, i: usize, b: &[Shine]) -> Bands {
        let pane = (i + self.within.len()).checked_sub(b.len());
        pane.map_or([0.0; 3], |p| bands(|x| self.within[p][x] * b[i][x] as f64))
    }

    /// H is ⟨B⟩, G four times that.
    pub fn unit(&self, i: usize) -> f64 {
        if i < self.first { 1.0 } else { 4.0 }
    }
}
