//! Which clusters exchange as wholes: refinement by the error that a link would leave in the result.
//!
//! **Demand.** From strengths s known roughly, node j sends M_j = Σ W s, and s varies over it by σ_j. Everything is measured against
//! the mean of what arrives, H̄ for patches and Ḡ for volumes, the largest over bands and light groups counting, so that every group is
//! served. A floor of uniform strength keeps links without power. Node i stands
//!
//! ```text
//! tol_i = ε ((1 − α) + α min(1, H_i/H̄)) / √(leaves of i)
//! ```
//!
//! from one link: dark zones ask for more, and errors of links to large clusters, which all their leaves share, for less.
//!
//! **Error of a link** at i, with a = K M_j and q as in [`super::kernel`]:
//!
//! ```text
//! e_i = a (q_i (half at a leaf) + q_j^{3/2}/2 + c²) + 0.3 K W_j σ_j q_j        expanded pairs
//! e_i = a (0.3; 1 for a node with itself; 0.6 where planes cut) · 3/2     flat pairs
//! ```
//!
//! A pair is taken when e ≤ tol at **both** ends, else its larger or more varied end is split. Pairs of two zones are always taken.
//!
//! **Visibility.** A pair that could carry more than its tolerance hidden or not is asked by rays first: where what they see varies so much
//! that a √(v(1 − v)) > γ tol, it is split after all. A pair that is taken is then looked at by other rays, a number fixed by a/tol, so
//! that what it carries is right in the mean. Few rays give the mean of kernel times visibility; many, and boxes, the share that
//! multiplies a mean kernel known better.
//!
//! The pairs to look at are kept in rounds: a round looks at each pair of a list, in parallel, and what is split makes the next list.
//! Results are put together in the order of the list, so they do not depend on threads.

use super::kernel::{Curve, Place, Spot, heights, is_behind};
use super::links::Pairs;
use super::sight::{Look, MOST_RAYS, Seen, Sight};
use super::tree::{Kind, Node, Tree};
use rayon::prelude::*;
use std::f64::consts::PI;
use zonal_exchange::aligned::{Cuboid, FactorCache};
use zonal_exchange::general::Moments;
use zonal_exchange::pair::{Counts, Exchange};
use zonal_math::{Vec3, sequence};
use zonal_scene::{Bands, Progress};

/// β: share of the tolerance that the sampling of visibility may take.
const BETA: f64 = 1.0;
/// γ: share of the tolerance that unresolved variation of visibility may take.
const GAMMA: f64 = 1.0;
/// Relative error of a flat pair of voxel clusters, whose mean kernel is exact.
pub(super) const FLAT: f64 = 0.3;
/// Weight (a/tol) below which no pair is split for what hides it: √(v(1 − v)) is no more than a half.
const SPLITTABLE: f64 = 2.0 * GAMMA;
/// Rays from which on the share that they see is multiplied by the mean kernel.
const RATIO: usize = 8;
/// v(1 − v) of a pair of zones that something may stand between.
const TYPICAL: f64 = 0.1;
/// Share of the source's variation that counts.
pub(super) const VARIED: f64 = 0.3;
/// Relative error where the plane of one end cuts the other, or the mean kernel is a guess.
const CUT: f64 = 0.6;
/// Above this q the second-order mean of two zones does not serve: their exact geometric factor does.
const NEAR_LEAVES: f64 = 0.04;
/// Above this q the mean of two boxes is taken from their exact factor.
const NEAR_BOXES: f64 = 0.01;
/// Relative radius of the geometric factors of zones.
const LEAF_TOLERANCE: f64 = 2e-3;
/// Demanded error of visibility below which a pair of zones is computed as the dense engine does.
const PRECISE: f64 = 0.02;
/// Weight (a/tol) of two near patches, or parts of voxels, above which their factor is computed in full rather than sampled.
const PROVED: f64 = 8.0;
/// Cosine that stands for all directions in a pane's share where a pair has no direction.
const MEAN_COSINE: f64 = 0.5;
/// Weight (a/tol) above which attenuation through a medium that varies is a mean over points, not that of the centres.
const SAMPLED: f64 = 0.1;
/// Points in a voxel for the mean solid angle of a patch near it; up to four times as many where much depends on it.
const NEAR_POINTS: usize = 12;
/// Points of the mean kernel of a pair that the expansion does not serve and that carries what its tolerance allows.
const MOST_POINTS: usize = 8;
/// Demanded error of visibility below which it pays to ask whether anything can stand between.
const WORTH_A_SHAFT: f64 = 0.3;
/// Pairs looked at in one task.
const CHUNK: usize = 512;

/// What the refinement is driven by, a node.
pub struct Demand {
    /// M_j relative to H̄: largest over bands and groups.
    pub power: Vec<f32>,
    /// W_j σ_j relative to H̄.
    pub varied: Vec<f32>,
    /// tol_i.
    pub tolerance: Vec<f32>,
    /// H̄/Ḡ: what arrives at volumes counts by this.
    pub volume: f64,
}

/// What was counted.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    /// Pairs looked at.
    pub visits: u64,
    /// Rays between clusters.
    pub rays: u64,
    /// Pairs that no facet can divide.
    pub clear: u64,
    /// Pairs split because of what hides them in part.
    pub split_by_sight: u64,
    /// Pairs of zones by an exact geometric factor.
    pub near: u64,
    /// Pairs of zones as the dense engine has them.
    pub exact: u64,
}

impl Tally {
    fn merge(&mut self, o: Tally) {
        self.visits += o.visits;
        self.rays += o.rays;
        self.clear += o.clear;
        self.split_by_sight += o.split_by_sight;
        self.near += o.near;
        self.exact += o.exact;
    }
}

/// All that a look at a pair needs.
pub struct Refiner<'a> {
    pub(super) tree: &'a Tree,
    pub(super) spots: &'a [Spot],
    pub(super) sight: &'a Sight<'a>,
    pub(super) exchange: &'a Exchange<'a>,
    pub(super) boxes: &'a FactorCache,
    /// The first band of each group.
    pub(super) lead: &'a [usize],
}

/// A pair to look at; `clear` where nothing can stand between.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    ends: [u32; 2],
    clear: bool,
}

enum Outcome {
    Unseen,
    Split { which: usize, clear: bool },
    Link { kernel: [f64; 3], doubt: f64 },
}

/// A kernel with its relative errors at both ends, before visibility.
struct Judged {
    kernel: [f64; 3],
    relative: [f64; 2],
    source: [f64; 2],
    q: [f64; 2],
    flat: bool,
}

impl Refiner<'_> {
    /// From the root down to links that meet the demand.
    pub fn refine(&self, demand: &Demand, progress: &dyn Progress) -> (Pairs, Tally) {
        let root = self.tree.root();
        let mut list = vec![Candidate { ends: [root, root], clear: self.sight.open() }];
        let (mut pairs, mut tally) = (Pairs::default(), Tally::default());
        progress.begin("links", 0);
        while !list.is_empty() {
            let parts: Vec<(Pairs, Vec<Candidate>, Tally)> =
                list.par_chunks(CHUNK).map(|chunk| self.round(chunk, demand)).collect();
            progress.advance(list.len() as u64);
            let mut next = Vec::with_capacity(parts.iter().map(|p| p.1.len()).sum());
            for (mut found, more, counts) in parts {
                pairs.append(&mut found);
                next.extend(more);
                tally.merge(counts);
            }
            list = next;
        }
        progress.end();
        (pairs, tally)
    }

    fn round(&self, chunk: &[Candidate], demand: &Demand) -> (Pairs, Vec<Candidate>, Tally) {
        let (mut pairs, mut next, mut tally) = (Pairs::default(), Vec::new(), Tally::default());
        for c in chunk {
            tally.visits += 1;
            match self.look(c, demand, &mut tally) {
                Outcome::Unseen => {}
                Outcome::Link { kernel, doubt } => {
                    pairs.ends.push(c.ends);
                    (0..self.lead.len()).for_each(|g| pairs.kernel.push(kernel[g] as f32));
                    pairs.doubt.push(doubt as f32);
                }
                Outcome::Split { which, clear } => self.split(c.ends, which, clear, &mut next),
            }
        }
        (pairs, next, tally)
    }

    fn split(&self, ends: [u32; 2], which: usize, clear: bool, next: &mut Vec<Candidate>) {
        let kids = self.tree.kids(ends[which]);
        if ends[0] == ends[1] {
            for (m, &a) in kids.iter().enumerate() {
                next.extend(kids[..=m].iter().map(|&b| Candidate { ends: [b.min(a), a.max(b)], clear }));
            }
            return;
        }
        let other = ends[1 - which];
        next.extend(kids.iter().map(|&k| Candidate { ends: [k.min(other), k.max(other)], clear }));
    }

    fn look(&self, c: &Candidate, demand: &Demand, tally: &mut Tally) -> Outcome {
        let [i, j] = c.ends.map(|x| x as usize);
        let (a, b) = (&self.tree.nodes[i], &self.tree.nodes[j]);
        let leaves = a.is_leaf() && b.is_leaf();
        if i == j && a.is_leaf() {
            return self.own(i, tally);
        }
        let Some(judged) = self.judge(i, j) else {
            return Outcome::Unseen;
        };
        let k = judged.kernel.iter().fold(0.0f64, |m, k| m.max(*k));
        let unit = |n: &Node| if n.kind == Kind::Patch { 1.0 } else { demand.volume };
        let units = [unit(a), unit(b)];
        let power = [demand.power[j] as f64, demand.power[i] as f64];
        let varied = [demand.varied[j] as f64, demand.varied[i] as f64];
        let tolerance = [demand.tolerance[i] as f64, demand.tolerance[j] as f64];
        let mut excess = [0.0; 2];
        for e in 0..2 {
            let arriving = k * power[e] * units[e];
            let error = arriving * judged.relative[e]
                + arriving * judged.source[e]
                + VARIED * k * varied[e] * units[e] * judged.q[1 - e];
            excess[e] = error / tolerance[e];
        }
        let panes = [a, b].iter().any(|n| n.kind == Kind::Pane && !n.is_leaf());
        if !leaves && (panes || excess[0] > 1.0 || excess[1] > 1.0) {
            return Outcome::Split { which: self.larger(a, b, &judged), clear: c.clear };
        }
        let weight = (0..2).fold(0.0f64, |m, e| m.max(k * power[e] * units[e] / tolerance[e]));
        self.linked(c, (i, j), leaves, judged, weight, tally)
    }

    /// Which end to split: the one over which the kernel varies more, the larger where that says nothing.
    fn larger(&self, a: &Node, b: &Node, judged: &Judged) -> usize {
        if a.is_leaf() {
            return 1;
        }
        if b.is_leaf() {
            return 0;
        }
        if a.kind == Kind::Mixed {
            return 0;
        }
        if b.kind == Kind::Mixed {
            return 1;
        }
        if a.kind == Kind::Pane || b.kind == Kind::Pane {
            return (a.kind != Kind::Pane) as usize;
        }
        let (ra, rb) = (a.radius(), b.radius());
        if judged.flat || ra > 2.0 * rb || rb > 2.0 * ra {
            return (rb > ra) as usize;
        }
        (judged.q[1] > judged.q[0]) as usize
    }

    /// Visibility, and the link unless that asks for a split. `weight` is the larger of a/tol.
    fn linked(
        &self,
        c: &Candidate,
        (i, j): (usize, usize),
        leaves: bool,
        judged: Judged,
        weight: f64,
        tally: &mut Tally,
    ) -> Outcome {
        let (a, b) = (&self.tree.nodes[i], &self.tree.nodes[j]);
        let q = judged.q[0] + judged.q[1];
        let (panes, want) = (self.has_pane(a, b), BETA / weight.max(1e-30));
        let close = judged.flat || q > NEAR_LEAVES;
        let parts = a.kind == Kind::Voxel && b.kind == Kind::Voxel && !(a.full && b.full);
        let touching = judged.flat && parts && weight > 1.0;
        if leaves && (want < PRECISE || touching || close && (panes || parts && weight > PROVED)) {
            return self.exact(i, j, tally);
        }
        let clear = c.clear || self.sight.open() || want < WORTH_A_SHAFT && self.sight.is_clear(a, b);
        tally.clear += u64::from(clear);
        let boxes = a.full && b.full;
        let sampled = self.sight.varied() && weight > SAMPLED;
        let points = match judged.flat && !boxes || sampled {
            true => ((MOST_POINTS as f64 * weight).ceil() as usize).clamp(1, MOST_POINTS),
            false => 1,
        };
        let seed = sequence::hash((i as u64) << 32 | j as u64);
        let mut look = Look { clear, through: sampled, by_number: true, tamed: true };
        if !leaves && weight > SPLITTABLE && (!clear || sampled) {
            let rays = (weight.ceil() as usize).clamp(points, MOST_RAYS);
            let asked = self.sight.look(a, b, sequence::hash(seed), rays, look);
            tally.rays += asked.rays as u64;
            if asked.mixed * weight > GAMMA {
                tally.split_by_sight += 1;
                return Outcome::Split { which: self.larger(a, b, &judged), clear: false };
            }
        }
        look.by_number = false;
        let rays = self.rays(weight, leaves).max(points);
        // Few rays tell the mean of kernel times visibility; the mean kernel times the share that they see would be too low.
        let together =
            !panes && (judged.flat && !boxes && !(leaves && weight > 1.0) || !clear && rays < RATIO);
        let mut kernel = judged.kernel;
        let mut seen = Seen::CLEAR;
        if together {
            let rays = if clear { points } else { rays };
            look = Look { through: true, tamed: false, ..look };
            seen = match judged.flat {
                true => self.sight.near(a, b, seed, rays, clear),
                false => self.sight.look(a, b, seed, rays, look),
            };
            (0..self.lead.len()).for_each(|g| kernel[g] = seen.kernel * seen.medium[self.lead[g]]);
        } else {
            if !clear || sampled || judged.flat && !boxes {
                seen = self.sight.look(a, b, seed, if clear { points } else { rays }, look);
            }
            self.mean_kernel((i, j), &judged, weight, leaves, sampled.then_some(&seen), &mut kernel, tally);
            if judged.flat && panes {
                let share = [a, b].map(|n| self.sheet(n, MEAN_COSINE));
                let medium = self.medium(a, b);
                for (g, &band) in self.lead.iter().enumerate() {
                    kernel[g] = seen.kernel * medium[band] * share[0][band] * share[1][band];
                }
            }
        }
        tally.rays += seen.rays as u64;
        let mut doubt = 0.0f64;
        let sign = if judged.flat { -1.0 } else { 1.0 };
        for g in 0..self.lead.len() {
            let open = if leaves { seen.error } else { seen.error.max(seen.mixed) };
            doubt = doubt.max(kernel[g] * open);
            kernel[g] *= sign * seen.share[self.lead[g]];
        }
        Outcome::Link { kernel, doubt }
    }

    /// What the medium lets pass between two centres.
    fn medium(&self, a: &Node, b: &Node) -> Bands {
        self.sight.depth(a.centre(), b.centre()).map(|d| (-d).exp())
    }

    /// The mean kernel without what stands between: exact for boxes, by points for zones near each other, else as judged; with what was
    /// `seen` of a medium that varies.
    #[allow(clippy::too_many_arguments)]
    fn mean_kernel(
        &self,
        (i, j): (usize, usize),
        judged: &Judged,
        weight: f64,
        leaves: bool,
        seen: Option<&Seen>,
        kernel: &mut [f64; 3],
        tally: &mut Tally,
    ) {
        let (a, b) = (&self.tree.nodes[i], &self.tree.nodes[j]);
        let q = judged.q[0] + judged.q[1];
        // The solid angle of a patch serves a pair that has one; between volumes apart the second order does.
        let patch = a.kind == Kind::Patch || b.kind == Kind::Patch;
        let medium = |g: usize| match seen {
            Some(s) => s.medium[self.lead[g]],
            None => self.medium(a, b)[self.lead[g]],
        };
        if a.full && b.full && (judged.flat || q > NEAR_BOXES) {
            *kernel = self.box_kernel(a, b, seen.map(|s| s.medium));
        } else if leaves && patch && (judged.flat || q > NEAR_LEAVES) && weight > 1.0 {
            tally.near += 1;
            let geometry = self.near((i, j), a, b, weight);
            (0..self.lead.len()).for_each(|g| kernel[g] = geometry * medium(g));
        } else if seen.is_some() && !judged.flat {
            let centre = self.medium(a, b);
            (0..self.lead.len()).for_each(|g| kernel[g] *= medium(g) / centre[self.lead[g]].max(1e-30));
        }
    }

    /// Rays of a link of this weight: enough for √(v(1 − v)/m) where a pair of zones may be seen in part; one that was found to agree needs
    /// no more than would have shown otherwise.
    fn rays(&self, weight: f64, leaves: bool) -> usize {
        let w = (weight / BETA).min(MOST_RAYS as f64);
        let m = if leaves { w.max(TYPICAL * w * w) } else { w };
        (m.ceil() as usize).clamp(1, MOST_RAYS)
    }

    fn has_pane(&self, a: &Node, b: &Node) -> bool {
        a.kind == Kind::Pane || b.kind == Kind::Pane
    }

    /// The pair of zones as the dense engine has it.
    fn exact(&self, i: usize, j: usize, tally: &mut Tally) -> Outcome {
        tally.exact += 1;
        let zone = |n: usize| self.tree.zone[n - self.tree.inner] as usize;
        let mut counts = Counts::default();
        let f = self.exchange.pair(zone(i), zone(j), &mut counts);
        tally.rays += counts.rays;
        let measure = self.measure(i) * self.measure(j);
        let mut kernel = [0.0; 3];
        let mut doubt = 0.0f64;
        for (g, &b) in self.lead.iter().enumerate() {
            kernel[g] = f.value[b] / measure;
            doubt = doubt.max(f.radius[b] / measure);
        }
        Outcome::Link { kernel, doubt }
    }

    /// (1 − e^{−κt/c})/(κt/c) of a piece of pane at cosine c: its kernel relative to that of a thin sheet of its volume.
    fn sheet(&self, n: &Node, cos: f64) -> Bands {
        self.sight.pane(n).map_or([1.0; 3], |(kappa, t)| {
            kappa.map(|k| {
                let depth = k * t / cos.max(1e-6);
                // A sheet of volume A t sends κ A t · this; its projected area is counted already.
                if depth > 1e-9 { -(-depth).exp_m1() / depth / cos.max(1e-6) } else { 1.0 / cos.max(1e-6) }
            })
        })
    }

    fn measure(&self, leaf: usize) -> f64 {
        self.tree.nodes[leaf].weight as f64
    }

    fn own(&self, i: usize, tally: &mut Tally) -> Outcome {
        if self.tree.nodes[i].kind == Kind::Patch { Outcome::Unseen } else { self.exact(i, i, tally) }
    }

    /// Two zones near each other: the geometric factor of two patches, the mean solid angle of a patch from a voxel, with as many
    /// points as the pair deserves.
    fn near(&self, (i, j): (usize, usize), a: &Node, b: &Node, weight: f64) -> f64 {
        let points =
            ((NEAR_POINTS as f64 * weight.sqrt()).ceil() as usize).clamp(NEAR_POINTS, 4 * NEAR_POINTS);
        let seed = sequence::hash((j as u64) << 32 | i as u64);
        match (a.kind, b.kind) {
            (Kind::Voxel, _) => self.sight.solid_mean(a, b, seed, points),
            (_, Kind::Voxel) => self.sight.solid_mean(b, a, seed, points),
            _ if weight < PROVED => {
                let (small, large) = if a.weight < b.weight { (a, b) } else { (b, a) };
                self.sight.solid_mean(small, large, seed, points)
            }
            _ => {
                let zone = |n: usize| self.tree.zone[n - self.tree.inner] as usize;
                let factor = self.exchange.plates(zone(i), zone(j), LEAF_TOLERANCE);
                factor.value / (self.measure(i) * self.measure(j))
            }
        }
    }

    fn attenuated(&self, m: &Moments, a: &Node, b: &Node, measure: f64) -> [f64; 3] {
        let (x, y) = (a.centre(), b.centre());
        let r = (x - y).length();
        let kappa: Bands =
            if r > 1e-6 * a.radius() { self.sight.depth(x, y).map(|d| d / r) } else { [a.kappa as f64; 3] };
        let mut kernel = [0.0; 3];
        for (g, &band) in self.lead.iter().enumerate() {
            kernel[g] = m.factor.value * m.transmittance(kappa[band]) / measure;
        }
        kernel
    }

    /// The exact mean kernel of two boxes, or rectangles, along the axes.
    fn box_kernel(&self, a: &Node, b: &Node, medium: Option<Bands>) -> [f64; 3] {
        let (p, q) = (cuboid(a), cuboid(b));
        let c = self.boxes.get_cumulants(&p, &q);
        let m = Moments { factor: c.factor, mean: c.mean_distance, variance: c.variance, third: c.third };
        let measures = measure(&p) * measure(&q);
        if let Some(medium) = medium {
            let mut kernel = [0.0; 3];
            (0..self.lead.len()).for_each(|g| kernel[g] = m.factor.value * medium[self.lead[g]] / measures);
            return kernel;
        }
        self.attenuated(&m, a, b, measures)
    }

    /// The kernel of two nodes before visibility and what it leaves open; `None` where they face away.
    fn judge(&self, i: usize, j: usize) -> Option<Judged> {
        let (a, b) = (&self.tree.nodes[i], &self.tree.nodes[j]);
        let (sa, sb) = (&self.spots[i], &self.spots[j]);
        let mut cut = a.kind == Kind::Mixed || b.kind == Kind::Mixed;
        for (p, q) in [(a, b), (b, a)] {
            if p.kind == Kind::Patch {
                let [low, high] = heights(p, q);
                if is_behind(p, q, high) {
                    return None;
                }
                cut |= low < -1e-6 * q.radius();
            }
        }
        let place = Place::new(sa, sb);
        let depth = self.sight.depth(a.centre(), b.centre());
        let mut kernel = [0.0; 3];
        for (g, &band) in self.lead.iter().enumerate() {
            kernel[g] = (-depth[band]).exp();
        }
        if place.flat || cut {
            // A guess, for the decision alone; boxes that are taken get their exact mean, others a mean over points.
            let floor = 0.1 * (a.radius() + b.radius()).powi(2);
            let geometry = 1.0 / (PI * (place.r * place.r).max(floor));
            let mut share = 1.0;
            for (n, h) in [(a, place.along[0]), (b, place.along[1])] {
                if n.kind == Kind::Patch {
                    let reach = (place.r + a.radius() + b.radius()).max(1e-300);
                    share *=
                        ((h / reach).max(0.0) + 0.25 * (1.0 - (place.r / reach).min(1.0))).clamp(0.02, 1.0);
                }
            }
            (0..self.lead.len()).for_each(|g| kernel[g] *= geometry * share);
            let relative = if i == j {
                1.0
            } else if a.full && b.full {
                FLAT
            } else {
                CUT
            };
            return Some(Judged {
                kernel,
                relative: [relative; 2],
                source: [0.5 * relative; 2],
                q: [1.0; 2],
                flat: true,
            });
        }
        let kappa = 0.5 * (sa.kappa + sb.kappa) as f64;
        let l = place.gradient(sa, sb, kappa);
        let curve = Curve::new(&place, a, b, l, kappa);
        for (g, &band) in self.lead.iter().enumerate() {
            kernel[g] *= place.geometry * curve.mean;
            for (n, h) in [(a, place.along[0]), (b, place.along[1])] {
                if n.kind == Kind::Pane {
                    kernel[g] *= self.sheet(n, h / place.r)[band];
                }
            }
        }
        let q = curve.q;
        let exact = a.full && b.full;
        let bias = if exact { 0.0 } else { curve.curvature * curve.curvature };
        let at = |e: usize, leaf: bool| bias + if leaf { 0.5 * q[e] } else { q[e] };
        let half = |e: usize, leaf: bool| if leaf { 0.0 } else { 0.5 * q[e] * q[e].sqrt() };
        Some(Judged {
            kernel,
            relative: [at(0, a.is_leaf()), at(1, b.is_leaf())],
            source: [half(1, b.is_leaf()), half(0, a.is_leaf())],
            q,
            flat: false,
        })
    }
}

fn cuboid(n: &Node) -> Cuboid {
    let axis = (0..3).find(|&x| n.kind == Kind::Patch && n.normal[x].abs() > 0.5);
    let mut hi = n.hi;
    if let Some(x) = axis {
        let mut h = hi.array();
        h[x] = n.lo[x];
        hi = Vec3::from_array(h);
    }
    Cuboid { lo: n.lo, hi, normal: axis.map(|x| (x, if n.normal[x] > 0.0 { 1 } else { -1 })) }
}

fn measure(c: &Cuboid) -> f64 {
    let e = c.hi - c.lo;
    c.normal.map_or(e.product(), |(x, _)| e[(x + 1) % 3] * e[(x + 2) % 3])
}
