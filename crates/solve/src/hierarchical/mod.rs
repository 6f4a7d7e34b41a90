//! The hierarchical engine: a tree of clusters over all zones, links where a tolerance on the solution allows.
//!
//! | module | what |
//! |---|---|
//! | [`tree`] | clusters, their moments, flat arrays |
//! | [`kernel`] | the kernel between two clusters to second order |
//! | [`sight`] | visibility by rays |
//! | [`demand`] | power and tolerance of every node from a rough solution |
//! | [`refine`] | which pairs become links |
//! | [`links`] | links and their application: up, across, down |
//! | [`estimate`] | what the links leave open |
//!
//! **Passes.** A rough refinement with the sources alone, a rough solution with its links, a refinement driven by that solution; the
//! caller solves with it. Cost and memory grow with the number of zones: the number of links per zone falls slowly as zones are refined.

pub mod demand;
pub mod estimate;
pub mod kernel;
pub mod links;
pub mod refine;
pub mod sight;
pub mod tree;

use crate::closure;
use crate::dense;
use crate::engine::{Built, Site};
use crate::groups;
use crate::krylov::{self, Stop, System};
use crate::operator::Operator;
use crate::pipeline::targets;
use crate::surroundings::Escape;
use demand::{FLOOR, Known};
use kernel::Spot;
use links::Links;
use refine::{Refiner, Tally};
use sight::Sight;
use tree::Tree;
use zonal_exchange::aligned::FactorCache;
use zonal_exchange::pair::{Exchange, Settings};
use zonal_math::Grade;
use zonal_scene::{Bands, NoVault, SceneError, bands};

/// The rough refinement is coarser by this.
const ROUGH: f64 = 10.0;
/// ε of the rough refinement at most.
const ROUGHEST: f64 = 0.2;
/// Where the rough solution stops.
const ROUGH_STOP: Stop = Stop { residual: 1e-2, iterations: 40 };
/// Relative radius of the tables of boxes.
const TABLES: f64 = 1e-6;

/// Links over a tree of clusters.
pub struct Hierarchical {
    tree: Tree,
    spots: Vec<Spot>,
    links: Links,
    group: [usize; 3],
    measure: Vec<f64>,
    scaling: Option<Vec<Bands>>,
    /// What the last refinement counted.
    pub tally: Tally,
}

/// Builds the engine for all light groups of a scene.
pub fn build(site: &Site, escape: &mut Escape) -> Result<Built, SceneError> {
    let made = Hierarchical::new(site, escape, site.scene.options().tolerance)
        .ok_or_else(|| SceneError::new("scene", "the scene has no zones; add a surface or a medium"))?;
    let zones = site.zones;
    let closure = closure::measure(&made, zones, escape);
    let t = &made.tally;
    let list = [
        ("inner nodes", made.tree.inner as u64),
        ("links, each direction", made.links.len() as u64),
        ("bytes of links", made.links.bytes()),
        ("pairs of clusters looked at", t.visits),
        ("pairs that nothing can divide", t.clear),
        ("pairs split for what hides them", t.split_by_sight),
        ("pairs of near zones", t.near),
        ("pairs of zones in full", t.exact),
        ("rays between clusters", t.rays),
    ];
    Ok(Built {
        operator: Box::new(made),
        noise: Vec::new(),
        closure,
        counts: list.into_iter().map(|(k, v)| (k.to_string(), v)).collect(),
        warnings: Vec::new(),
    })
}

impl Hierarchical {
    /// Refines for the sources of all light groups to ε; `None` without zones.
    pub fn new(site: &Site, escape: &Escape, epsilon: f64) -> Option<Hierarchical> {
        let (scene, zones, progress) = (site.scene, site.zones, site.progress);
        let tree = Tree::new(scene, zones)?;
        let spots: Vec<Spot> = tree.nodes.iter().map(Spot::of).collect();
        let (group, count) = dense::groups(scene, site.transport.has_panes_between());
        let lead: Vec<usize> = (0..count).map(|g| group.iter().position(|&x| x == g).unwrap_or(0)).collect();
        let settings = Settings { keep_zones: false, ..Settings::default() };
        let exchange = Exchange::with_settings(scene, zones, site.transport, settings);
        let boxes = FactorCache::new(TABLES);
        let mut measure = vec![0.0; zones.len()];
        for slot in 0..tree.leaves() {
            measure[tree.zone[slot] as usize] = tree.nodes[tree.leaf(slot)].weight as f64;
        }
        let tally = Tally::default();
        let mut made =
            Hierarchical { tree, spots, links: Links::default(), group, measure, scaling: None, tally };
        let columns = site.columns(escape);
        let rough = (ROUGH * epsilon).min(ROUGHEST).max(epsilon);
        for (epsilon, first) in [(rough, true), (epsilon, false)] {
            let solved: Vec<(Vec<Bands>, Vec<Bands>)> = if first {
                columns.iter().map(|s| (s.clone(), Vec::new())).collect()
            } else {
                made.rough(site, &columns)
            };
            let known: Vec<Known> = solved.iter().map(|(s, h)| Known { strengths: s, arriving: h }).collect();
            let demand = demand::demand(&made.tree, zones, &known, epsilon, if first { 1.0 } else { FLOOR });
            let sight = Sight::new(scene, zones, site.transport, &made.tree);
            let refiner = Refiner {
                tree: &made.tree,
                spots: &made.spots,
                sight: &sight,
                exchange: &exchange,
                boxes: &boxes,
                lead: &lead,
            };
            let (pairs, tally) = refiner.refine(&demand, progress);
            made.links = Links::new(made.tree.nodes.len(), &pairs, count);
            made.tally = tally;
        }
        Some(made)
    }

    /// A rough solution of every group: strengths and what arrives.
    fn rough(&self, site: &Site, columns: &[Vec<Bands>]) -> Vec<(Vec<Bands>, Vec<Bands>)> {
        let (weights, targets) = (groups::weights(site.zones), targets(site.zones));
        let system = System { operator: self, weights: &weights, targets: &targets };
        let ended = krylov::solve(&system, columns, None, ROUGH_STOP, &NoVault, site.progress);
        ended
            .into_iter()
            .map(|e| {
                let h = self.arriving(&e.strengths);
                (e.strengths, h)
            })
            .collect()
    }

    /// H of patches, G of volumes by their strengths.
    pub fn arriving(&self, strengths: &[Bands]) -> Vec<Bands> {
        links::apply(&self.tree, &self.spots, &self.links, self.group, strengths)
    }

    /// Directed links and bytes that they take.
    pub fn size(&self) -> (usize, u64) {
        (self.links.len(), self.links.bytes())
    }
}

impl Operator for Hierarchical {
    fn len(&self) -> usize {
        self.measure.len()
    }
    fn apply(&self, s: &[Bands]) -> Vec<Bands> {
        let times = |v: &[Bands], d: &[Bands]| {
            v.iter().zip(d).map(|(v, d)| bands(|b| v[b] * d[b])).collect::<Vec<_>>()
        };
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
        e.iter_mut().zip(&self.measure).for_each(|(e, w)| e.iter_mut().for_each(|x| *x *= w));
        Some(e)
    }
    fn scale(&mut self, d: &[Bands]) {
        let old = self.scaling.take();
        self.scaling = Some(match old {
            Some(o) => o.iter().zip(d).map(|(o, d)| bands(|b| o[b] * d[b])).collect(),
            None => d.to_vec(),
        });
    }
    fn grade(&self) -> Grade {
        Grade::Estimated
    }
}
