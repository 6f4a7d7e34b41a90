//! The hierarchical engine: a tree of clusters over all zones, links where a tolerance on the solution allows.
//!
//! | module | what |
//! |---|---|
//! | [`tree`] | clusters, their moments, flat arrays |
//! | [`kernel`] | the kernel between two clusters to second order |
//! | [`near`] | the mean kernel of clusters close to each other |
//! | [`sight`] | visibility by rays |
//! | [`demand`] | power and tolerance of every node from a rough solution |
//! | [`refine`] | which pairs become links |
//! | [`links`] | links and their application: up, across, down |
//! | [`closure`] | closure restored by clusters |
//! | [`estimate`] | what the links leave open |
//!
//! **Passes.** A rough refinement with the sources alone, a rough solution with its links, a refinement driven by that solution; the
//! caller solves with it. Cost and memory grow with the number of zones: the number of links per zone falls slowly as zones are refined.

pub mod closure;
pub mod demand;
pub mod estimate;
pub mod kernel;
pub mod links;
pub mod near;
pub mod refine;
pub mod sight;
pub mod tree;

use crate::columns::times;
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
use zonal_scene::solution::Closure;
use zonal_scene::{Bands, Estimate, Fields, NoVault, SceneError, bands};

/// The rough refinement is coarser by this.
const ROUGH: f64 = 10.0;
/// ε of the rough refinement at most.
const ROUGHEST: f64 = 0.2;
/// Where the rough solution stops.
const ROUGH_STOP: Stop = Stop { residual: 1e-2, iterations: 40 };
/// The estimate falls with ε to the power of one over this.
const STEEPNESS: f64 = 1.8;
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
    /// ε of the last refinement.
    epsilon: f64,
    /// Strengths of a rough solution of every group, with what arrives.
    known: Vec<(Vec<Bands>, Vec<Bands>)>,
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

/// Estimate over tolerance at which a refinement is content: errors are smaller than their estimates.
const CONTENT: f64 = 1.3;
/// Refinements at most.
const ROUNDS: usize = 4;
/// ε of the first refinement over the tolerance.
const FIRST: f64 = 0.6;
/// Zones up to which an unmet tolerance is pursued by refining again whatever it costs.
const PURSUED: usize = 60_000;

/// Builds the engine for all light groups of a scene: refines until the estimate of the solution meets the tolerance.
pub fn build(site: &Site, escape: &mut Escape) -> Result<Built, SceneError> {
    let (zones, tolerance) = (site.zones, site.scene.options().tolerance);
    let factors = Factors::new(site);
    let mut made = Hierarchical::new(site, escape, &factors, FIRST * tolerance)
        .ok_or_else(|| SceneError::new("scene", "the scene has no zones; add a surface or a medium"))?;
    let mut warnings = Vec::new();
    for round in 1.. {
        let estimate = made.estimated(site, escape);
        if estimate <= CONTENT * tolerance {
            break;
        }
        if round >= ROUNDS || zones.len() > PURSUED {
            warnings.push(format!(
                "the estimated error, {estimate:.1e}, is above what the tolerance {tolerance} asks: give a smaller tolerance"
            ));
            break;
        }
        let factor = (CONTENT * tolerance / estimate).powf(STEEPNESS).clamp(0.05, 0.7);
        made.epsilon *= factor;
        made.refine(site, &factors);
    }
    made.debug_zone(&made.total(|k| &k.0));
    let closure = crate::closure::measure(&made, zones, escape);
    if std::env::var("DBG_ROWS").is_ok() {
        for kind in 0..3 {
            let mut s = [0.0; 5];
            for i in 0..zones.len() {
                let k = if i < zones.voxel_offset() { 0 } else if zones.voxels[i - zones.voxel_offset()].part.is_empty() { 1 } else { 2 };
                if k != kind { continue }
                let t = zonal_exchange::pair::target(zones, i);
                let d = closure.1[i][0];
                s[0] += t; s[1] += t * d; s[2] += 1.0; s[3] += d; s[4] += d * d;
            }
            eprintln!("kind {kind}: weighted defect {:.4} plain {:.4} rms {:.4} n {}", s[1] / s[0], s[3] / s[2], (s[4] / s[2]).sqrt(), s[2]);
        }
    }
    let closure = match site.scene.options().restore_closure {
        true => made.restore(site, escape, closure),
        false => closure,
    };
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
        warnings,
    })
}

impl Hierarchical {
    /// Refines for the sources of all light groups to ε; `None` without zones.
    pub fn new(site: &Site, escape: &Escape, factors: &Factors, epsilon: f64) -> Option<Hierarchical> {
        let tree = Tree::new(site.scene, site.zones)?;
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
            scaling: None,
            epsilon: (ROUGH * epsilon).min(ROUGHEST).max(epsilon),
            known: site.columns(escape).into_iter().map(|s| (s, Vec::new())).collect(),
            tally: Tally::default(),
        };
        made.refine(site, factors);
        made.solve_roughly(site, escape);
        made.epsilon = epsilon;
        made.refine(site, factors);
        Some(made)
    }

    /// Finds the links anew for ε and what is known.
    fn refine(&mut self, site: &Site, factors: &Factors) {
        let count = self.links.groups;
        let lead = dense::leads((self.group, count));
        let known: Vec<Known> = self.known.iter().map(|(s, h)| Known { strengths: s, arriving: h }).collect();
        let floor = if known.iter().all(|k| k.arriving.is_empty()) { 1.0 } else { FLOOR };
        let demand = demand::demand(&self.tree, site.zones, &known, self.epsilon, floor);
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
        self.tally = tally;
    }

    /// Solves roughly with the links at hand and returns the estimated relative error, the largest over kinds and bands.
    fn estimated(&mut self, site: &Site, escape: &Escape) -> f64 {
        self.solve_roughly(site, escape);
        let (sum, arriving) = (self.total(|k| &k.0), self.total(|k| &k.1));
        let errors = estimate::errors(&self.tree, &self.spots, &self.links, self.group, &sum);
        let first = site.zones.voxel_offset();
        let fields = Fields { error: errors, incident: arriving, ..Fields::default() };
        let e = Estimate::of(&fields, first, Grade::Estimated);
        e.patches.iter().chain(&e.volumes).fold(0.0, |m, x| m.max(*x))
    }

    /// Closure restored by clusters: what was measured before, with the change.
    fn restore(
        &mut self,
        site: &Site,
        escape: &mut Escape,
        (mut report, defects): (Closure, Vec<Bands>),
    ) -> (Closure, Vec<Bands>) {
        let d = closure::scaling(&self.tree, self, site.zones, escape, &self.total(|k| &k.0));
        for (i, d) in d.iter().enumerate() {
            for b in 0..3 {
                escape.sky[i][b] *= d[b];
                escape.backs[i][b] *= d[b];
                report.largest_change[b] = report.largest_change[b].max((d[b] * d[b] - 1.0).abs());
            }
        }
        self.scale(&d);
        report.after = crate::closure::measure(self, site.zones, escape).0.worst;
        report.restored = true;
        (report, defects)
    }

    /// A part of what is known, summed over the groups.
    fn total(&self, part: impl Fn(&(Vec<Bands>, Vec<Bands>)) -> &Vec<Bands>) -> Vec<Bands> {
        let mut sum = vec![[0.0; 3]; self.measure.len()];
        for one in &self.known {
            sum.iter_mut().zip(part(one)).for_each(|(a, x)| *a = bands(|b| a[b] + x[b]));
        }
        sum
    }

    /// A rough solution of every group: strengths and what arrives.
    fn solve_roughly(&mut self, site: &Site, escape: &Escape) {
        let (weights, targets) = (groups::weights(site.zones), targets(site.zones));
        let system = System { operator: self, weights: &weights, targets: &targets };
        let columns = site.columns(escape);
        let warm: Option<Vec<Vec<Bands>>> = match self.known.iter().all(|k| k.1.is_empty()) {
            true => None,
            false => Some(self.known.iter().map(|k| k.0.clone()).collect()),
        };
        let ended = krylov::solve(&system, &columns, warm.as_deref(), ROUGH_STOP, &NoVault, site.progress);
        self.known = ended
            .into_iter()
            .map(|e| {
                let h = self.arriving(&e.strengths);
                (e.strengths, h)
            })
            .collect();
    }

    /// H of patches, G of volumes by their strengths.
    fn arriving(&self, strengths: &[Bands]) -> Vec<Bands> {
        links::apply(&self.tree, &self.spots, &self.links, self.group, strengths)
    }
}

impl Hierarchical {
    fn debug_zone(&self, strengths: &[Bands]) {
        let Ok(z) = std::env::var("DBG_ZONE") else { return };
        let z: u32 = z.parse().unwrap();
        let slot = self.tree.zone.iter().position(|x| *x == z).unwrap();
        let mut n = self.tree.leaf(slot);
        let mut power = vec![0.0; self.tree.nodes.len()];
        for k in (0..power.len()).rev() {
            let node = &self.tree.nodes[k];
            power[k] = if node.is_leaf() { node.weight as f64 * strengths[self.tree.zone[node.first as usize] as usize][0] } else { self.tree.kids(k as u32).iter().map(|&c| power[c as usize]).sum() };
        }
        loop {
            let node = &self.tree.nodes[n];
            let mut list: Vec<(f64, usize)> = self.links.of(n).map(|l| (self.links.kernel[l * self.links.groups].abs() as f64 * power[self.links.other[l] as usize], l)).collect();
            list.sort_by(|a, b| b.0.total_cmp(&a.0));
            let total: f64 = list.iter().map(|x| x.0).sum();
            let row: f64 = list.iter().map(|x| self.links.kernel[x.1 * self.links.groups].abs() as f64 * self.tree.nodes[self.links.other[x.1] as usize].weight as f64).sum();
            eprintln!("node {n} leaves {} r {:.2} cone {:.2} c {:?} n {:?}: links {} bring {total:.4} row {row:.4}", node.leaves(), node.radius(), node.cone, node.centre, node.normal, list.len());
            for (v, l) in list.iter().take(6) {
                let j = self.links.other[*l] as usize;
                let o = &self.tree.nodes[j];
                let k = self.links.kernel[*l * self.links.groups];
                eprintln!("    {v:.4} j {j} {:?} leaves {} r {:.2} cone {:.2} c {:?} W {:.3} k {k:.4} F {:.4} doubt {:.4} n {:?} full {}", o.kind, o.leaves(), o.radius(), o.cone, o.centre, o.weight, k.abs() * o.weight, self.links.doubt[*l] as f64 * power[j], o.normal, o.full);
            }
            let up = self.tree.parent[n] as usize;
            if up == n { break }
            n = up;
        }
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
