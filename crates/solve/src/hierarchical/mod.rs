//! The hierarchical engine: a tree of clusters over all zones, links where a tolerance on the solution allows.
//!
//! | module | what |
//! |---|---|
//! | [`views`], [`seeing`] | what every zone sees along a few rays, and the operator that this makes |
//! | `shooter` | rays, one and many together |
//! | `onward`, `again`, `kept` | rays that go on, rays shot again where it stays noisy, and views that a vault keeps |
//! | [`build`] | from a scene to an engine that meets its tolerance |
//! | [`budget`], [`trial`] | memory and time beforehand |
//! | [`tree`] | clusters, their moments, flat arrays |
//! | [`kernel`] | the kernel between two clusters to second order |
//! | [`near`] | the mean kernel of clusters close to each other |
//! | [`sight`] | visibility by rays |
//! | [`demand`] | power and tolerance of every node from a rough solution |
//! | [`refine`] | which pairs become links |
//! | [`smooth`], `windows` | light that arrives, smoothed; the zones around over which it is |
//! | [`links`] | links and their application: up, across, down |
//! | [`closure`] | closure restored by clusters |
//! | [`even`] | closure restored for an answer by rays |
//! | [`estimate`] | what the links leave open |
//! | [`joint`] | one answer from links and rays |
//!
//! **Passes.** Rays from every zone give a first solution with an error that is known well. Where that does not meet the tolerance, a tree
//! of clusters is built by it and links are refined by it, the caller solves with the links, and both answers are joined. Rays reach
//! a few per cent at a cost in step with the number of zones; links go on from there, as their errors fall faster than one over the
//! root of the work.

mod again;
pub mod budget;
pub mod build;
pub mod closure;
pub mod demand;
pub mod estimate;
pub mod even;
pub mod joint;
mod kept;
pub mod kernel;
pub mod links;
pub mod near;
mod onward;
pub mod refine;
pub mod seeing;
mod shooter;
pub mod sight;
pub mod smooth;
pub mod tree;
pub mod trial;
pub mod views;
mod windows;

use crate::columns::{times, total};
use crate::dense;
use crate::engine::Site;
use crate::groups;
use crate::krylov::{self, Stop, System};
use crate::operator::{Arriving, Operator};
use crate::pipeline::targets;
use crate::surroundings::Escape;
use demand::Known;
use kernel::Spot;
use links::Links;
use rayon::prelude::*;
use refine::{Refiner, Tally};
use sight::Sight;
use tree::Tree;
use views::Measured;
use zonal_exchange::aligned::FactorCache;
use zonal_exchange::pair::{Exchange, Settings};
use zonal_math::Grade;
use zonal_scene::{Bands, NoVault, bands};

/// Errors told over those of the links and rays of a zone: what arrives was passed on by others, whose errors these leave out.
const TOLD: f64 = 1.3;
/// Where the rough solution stops.
const ROUGH_STOP: Stop = Stop { residual: 1e-2, iterations: 40 };
/// Relative radius of the tables of boxes.
const TABLES: f64 = 1e-6;

/// Strengths of every light group with what arrives, H or G, roughly.
pub type Rough = Vec<(Vec<Bands>, Vec<Bands>)>;

/// How bright every zone is over their mean, the largest over the bands.
fn brightness(site: &Site, known: &Rough) -> Vec<f32> {
    let direct = site.direct.fields(site.zones.len());
    let mut bright: Vec<f32> = direct
        .par_iter()
        .enumerate()
        .map(|(i, d)| {
            let all = known.iter().fold(*d, |a, k| bands(|b| a[b] + k.1[i][b]));
            let unit = if i < site.zones.voxel_offset() { 1.0 } else { 0.25 };
            (unit * all[0].max(all[1]).max(all[2])) as f32
        })
        .collect();
    let sum = bright.iter().map(|x| *x as f64).sum::<f64>();
    let level = (sum / bright.len().max(1) as f64).max(f64::MIN_POSITIVE) as f32;
    bright.iter_mut().for_each(|x| *x /= level);
    bright
}

/// What rays say arrives, in the unit of P.
pub struct Seen {
    /// A group.
    pub columns: Vec<Vec<Bands>>,
    /// Estimated error of their sum.
    pub error: Vec<Bands>,
    /// Their sum before it was smoothed, with its standard error.
    pub raw: Vec<Measured>,
}

/// What links alone say arrives, in the unit of P.
struct ByLinks {
    /// A group.
    columns: Vec<Vec<Bands>>,
    /// Estimated error of their sum, not yet as it is [`told`].
    error: Vec<Bands>,
}

/// An error as it is told.
fn told(error: Bands) -> Bands {
    error.map(|e| TOLD * e)
}

/// Links over a tree of clusters.
pub struct Hierarchical {
    tree: Tree,
    spots: Vec<Spot>,
    links: Links,
    group: [usize; 3],
    measure: Vec<f64>,
    /// Number of patches.
    patches: usize,
    scaling: Option<Vec<Bands>>,
    /// ε of the last refinement.
    epsilon: f64,
    /// Strengths of a rough solution of every group, with what arrives.
    known: Rough,
    /// What the rays say arrives of each group, to be joined in the end, and the error of all; none where light is followed so far only.
    seen: Option<Seen>,
    /// What the last refinement counted.
    pub tally: Tally,
}

/// Factors of pairs, made ready once for all refinements.
pub struct Factors<'a> {
    exchange: Exchange<'a>,
    boxes: FactorCache,
}

impl<'a> Factors<'a> {
    /// For the zones of a site.
    pub fn new(site: &Site<'a>) -> Factors<'a> {
        let settings = Settings { keep_zones: false, ..Settings::default() };
        let exchange = Exchange::with_settings(site.scene, site.zones, site.transport, settings);
        Factors { exchange, boxes: FactorCache::new(TABLES) }
    }
}

impl Hierarchical {
    /// Refines for ε by what is roughly known of all light groups: strengths and what arrives; `None` without zones.
    pub fn new(site: &Site, known: Rough, factors: &Factors, epsilon: f64) -> Option<Hierarchical> {
        let tree = Tree::new(site.scene, site.zones, &brightness(site, &known))?;
        let spots: Vec<Spot> = tree.nodes.iter().map(Spot::of).collect();
        let (group, count) = dense::groups(site.scene, site.transport.has_panes_between());
        let mut measure = vec![0.0; site.zones.len()];
        for slot in 0..tree.leaves() {
            measure[tree.zone[slot] as usize] = tree.nodes[tree.leaf(slot)].weight as f64;
        }
        let mut made = Hierarchical {
            tree,
            spots,
            links: Links { groups: count, ..Links::default() },
            group,
            measure,
            patches: site.zones.voxel_offset(),
            scaling: None,
            epsilon,
            known,
            seen: None,
            tally: Tally::default(),
        };
        made.refine(site, factors);
        Some(made)
    }

    /// Finds the links anew for ε and what is known.
    fn refine(&mut self, site: &Site, factors: &Factors) {
        let count = self.links.groups;
        let lead = dense::leads((self.group, count));
        let known: Vec<Known> = self.known.iter().map(|(s, h)| Known { strengths: s, arriving: h }).collect();
        let demand = demand::demand(&self.tree, site.zones, &known, self.epsilon);
        let sight = Sight::new(site.scene, site.zones, site.transport, &self.tree);
        let refiner = Refiner {
            tree: &self.tree,
            spots: &self.spots,
            sight: &sight,
            exchange: &factors.exchange,
            boxes: &factors.boxes,
            lead: &lead,
        };
        let (pairs, tally) = refiner.refine(&demand, site.progress);
        self.links = Links::new(self.tree.nodes.len(), &pairs, count);
        (self.scaling, self.tally) = (None, tally);
    }

    /// What arrives by the rough solution of the links, and the error of it.
    fn rough(&self) -> ByLinks {
        let strengths: Vec<Vec<Bands>> = self.known.iter().map(|k| k.0.clone()).collect();
        self.by_links(&strengths)
    }

    /// H or G and its error, as told, of what arrives.
    fn measured(&self, columns: &[Vec<Bands>], error: impl Iterator<Item = Bands>) -> Vec<Measured> {
        let value = total(self.len(), columns);
        let both = value.iter().zip(error).zip(&self.measure);
        both.map(|((v, e), m)| Measured { value: v.map(|x| x / m), error: e.map(|x| x / m) }).collect()
    }

    /// What these strengths send by links, and the error of it.
    fn by_links(&self, columns: &[Vec<Bands>]) -> ByLinks {
        let error = self.error(&total(self.len(), columns)).unwrap_or_default();
        ByLinks { columns: self.apply_many(columns), error }
    }

    /// What arrives by links, joined with what the rays say where they count.
    fn joined(&self, seen: &Seen, links: ByLinks) -> Arriving {
        let n = self.len();
        let ByLinks { columns: mut out, error } = links;
        let smooth = total(n, &seen.columns);
        let both = joint::joint(
            &self.tree,
            self.patches,
            (&total(n, &out), &error),
            &seen.raw,
            (&smooth, &seen.error),
        );
        for (o, s) in out.iter_mut().zip(&seen.columns) {
            for (i, (share, _)) in both.iter().enumerate() {
                o[i] = bands(|b| share * o[i][b] + (1.0 - share) * s[i][b]);
            }
        }
        Arriving { columns: out, error: Some(both.into_iter().map(|b| told(b.1)).collect()) }
    }

    /// The two together where rays were seen to help, else the links alone.
    fn with(&self, seen: Option<&Seen>, columns: &[Vec<Bands>]) -> Arriving {
        let links = self.by_links(columns);
        match seen {
            Some(seen) => self.joined(seen, links),
            None => {
                Arriving { columns: links.columns, error: Some(links.error.into_iter().map(told).collect()) }
            }
        }
    }

    /// A rough solution of every group: strengths and what arrives.
    fn solve_roughly(&mut self, site: &Site, escape: &Escape) {
        let (weights, targets) = (groups::weights(site.zones), targets(site.zones));
        let system = System { operator: self, weights: &weights, targets: &targets };
        let columns = site.columns(escape);
        let warm: Vec<Vec<Bands>> = self.known.iter().map(|k| k.0.clone()).collect();
        let ended = krylov::solve(&system, &columns, Some(&warm), ROUGH_STOP, &NoVault, site.progress);
        self.known = ended
            .into_iter()
            .map(|e| {
                let mut h = self.apply(&e.strengths);
                h.iter_mut().zip(&self.measure).for_each(|(h, w)| *h = h.map(|x| x / w));
                (e.strengths, h)
            })
            .collect();
    }

    /// H of patches, G of volumes by their strengths.
    fn arriving(&self, strengths: &[Bands]) -> Vec<Bands> {
        links::apply(&self.tree, &self.spots, &self.links, self.group, strengths)
    }
}

impl Operator for Hierarchical {
    fn len(&self) -> usize {
        self.measure.len()
    }
    fn apply(&self, s: &[Bands]) -> Vec<Bands> {
        let scaled = self.scaling.as_ref().map(|d| times(s, d));
        let mut out = self.arriving(scaled.as_deref().unwrap_or(s));
        out.iter_mut().zip(&self.measure).for_each(|(o, w)| o.iter_mut().for_each(|x| *x *= w));
        match &self.scaling {
            Some(d) => times(&out, d),
            None => out,
        }
    }
    fn error(&self, strengths: &[Bands]) -> Option<Vec<Bands>> {
        let mut e = estimate::errors(&self.tree, &self.spots, &self.links, self.group, strengths);
        if let Some(d) = &self.scaling {
            let h = self.arriving(strengths);
            e.iter_mut().zip(d.iter().zip(&h)).for_each(|(e, (d, h))| {
                *e = bands(|b| e[b] + (d[b] * d[b] - 1.0).abs() * h[b]);
            });
        }
        e.iter_mut().zip(&self.measure).for_each(|(e, w)| e.iter_mut().for_each(|x| *x *= w));
        Some(e)
    }
    fn arriving(&self, columns: &[Vec<Bands>]) -> Arriving {
        self.with(self.seen.as_ref(), columns)
    }
    fn scale(&mut self, d: &[Bands]) {
        let old = self.scaling.take();
        self.scaling = Some(match old {
            Some(o) => times(&o, d),
            None => d.to_vec(),
        });
    }
    fn grade(&self) -> Grade {
        Grade::Estimated
    }
}
