//! The hierarchical engine: a tree of clusters over all zones, links where a tolerance on the solution allows.
//!
//! | module | what |
//! |---|---|
//! | [`views`], [`seeing`] | what every zone sees along a few rays, and the operator that this makes |
//! | [`tree`] | clusters, their moments, flat arrays |
//! | [`kernel`] | the kernel between two clusters to second order |
//! | [`near`] | the mean kernel of clusters close to each other |
//! | [`sight`] | visibility by rays |
//! | [`demand`] | power and tolerance of every node from a rough solution |
//! | [`refine`] | which pairs become links |
//! | [`smooth`] | light that arrives, smoothed over the zones around |
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
pub mod seeing;
pub mod sight;
pub mod smooth;
pub mod tree;
pub mod views;

use crate::columns::times;
use crate::dense;
use crate::engine::{Built, Site};
use crate::groups;
use crate::krylov::{self, Stop, System};
use crate::operator::{Arriving, Operator};
use crate::pipeline::targets;
use crate::surroundings::Escape;
use demand::{FLOOR, Known};
use kernel::Spot;
use links::Links;
use rayon::prelude::*;
use refine::{Refiner, Tally};
use seeing::Seeing;
use sight::Sight;
use tree::Tree;
use zonal_exchange::aligned::FactorCache;
use zonal_exchange::pair::{Exchange, Settings};
use zonal_math::Grade;
use zonal_scene::solution::Closure;
use zonal_scene::{Bands, Estimate, Fields, NoVault, SceneError, bands};

/// Where the rough solution stops.
const ROUGH_STOP: Stop = Stop { residual: 1e-2, iterations: 40 };
/// The estimate falls with ε to the power of one over this.
const STEEPNESS: f64 = 1.8;
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

/// Two values with errors that have nothing to do with each other: the share of the first in their mean, and its error.
fn joined(a: Bands, b: Bands) -> (f64, Bands) {
    let (x, y) = (a.iter().map(|e| e * e).sum::<f64>(), b.iter().map(|e| e * e).sum::<f64>());
    let share = if x + y > 0.0 { y / (x + y) } else { 1.0 };
    (share, bands(|k| (share * a[k]).hypot((1.0 - share) * b[k])))
}

fn dbg_t(what: &str) {
    if std::env::var("DBG_T").is_ok() {
        eprintln!(
            "{what} {:.1}",
            std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap().as_secs_f64()
                % 10000.0
        );
    }
}

/// Links over a tree of clusters.
pub struct Hierarchical<'a> {
    tree: Tree,
    spots: Vec<Spot>,
    links: Links,
    group: [usize; 3],
    measure: Vec<f64>,
    scaling: Option<Vec<Bands>>,
    /// ε of the last refinement.
    epsilon: f64,
    /// Strengths of a rough solution of every group, with what arrives.
    known: Rough,
    /// What every zone sees, with the error of what that says arrives, in the unit of P; once it is used.
    seeing: Option<(Seeing<'a>, Vec<Bands>)>,
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
const CONTENT: f64 = 1.0;
/// Refinements at most.
const ROUNDS: usize = 6;
/// ε of the first refinement over the tolerance.
const FIRST: f64 = 0.6;
/// Zones up to which an unmet tolerance is pursued by refining again whatever it costs.
const PURSUED: usize = 60_000;
/// ε is divided by no more than this at a time.
const LEAST_STEP: f64 = 0.2;

/// Builds the engine for all light groups of a scene: what rays from every zone say where that meets the tolerance, else links, refined until
/// their estimate meets it.
pub fn build<'a>(site: &Site<'a>, escape: &mut Escape) -> Result<Built<'a>, SceneError> {
    let (zones, tolerance) = (site.zones, site.scene.options().tolerance);
    if zones.is_empty() {
        return Err(SceneError::new("scene", "the scene has no zones; add a surface or a medium"));
    }
    let seeing = Seeing::new(site);
    dbg_t("views");
    let ended = seeing.solve(site, escape);
    dbg_t("seen");
    let strengths: Vec<Vec<Bands>> = ended.into_iter().map(|e| e.strengths).collect();
    let Arriving { columns, error } = seeing.arriving(&strengths);
    dbg_t("smoothed");
    let over = |v: Vec<Bands>| -> Vec<Bands> {
        let measured = v.into_iter().enumerate();
        measured.map(|(i, x)| x.map(|x| x / groups::response(zones, i).1)).collect()
    };
    let noise = error.unwrap_or_default();
    let known: Rough = strengths.into_iter().zip(columns.into_iter().map(over)).collect();
    let incident = total(zones.len(), &known, |k| &k.1);
    if std::env::var("DBG_V").is_ok() {
        let er = over(noise.clone());
        let v: Vec<u8> = incident
            .iter()
            .zip(&er)
            .flat_map(|(x, e)| [x[0] as f32, e[0] as f32])
            .flat_map(|x| x.to_le_bytes())
            .collect();
        std::fs::write("/tmp/views.bin", v).unwrap();
        if std::env::var("DBG_STOP").is_ok() {
            std::process::exit(0);
        }
    }
    let found = relative(site, &incident, &over(noise.clone()));
    eprintln!("views estimate {found}");
    if found <= tolerance && site.scene.options().sweeps.is_none() {
        let closure = crate::closure::measure(&seeing, zones, escape);
        let counts = vec![("rays of views".to_string(), seeing.rays())];
        let warm = Some(known.into_iter().map(|k| k.0).collect());
        return Ok(Built {
            operator: Box::new(seeing),
            noise: Vec::new(),
            closure,
            counts,
            warnings: Vec::new(),
            warm,
        });
    }
    links(site, escape, seeing, noise, known)
}

/// Estimated relative error, the largest over kinds and bands.
fn relative(site: &Site, incident: &[Bands], error: &[Bands]) -> f64 {
    let fields = Fields { error: error.to_vec(), incident: incident.to_vec(), ..Fields::default() };
    let e = Estimate::of(&fields, site.zones.voxel_offset(), Grade::Estimated);
    e.patches.iter().chain(&e.volumes).fold(0.0, |m, x| m.max(*x))
}

/// A part of what is known, summed over the groups.
fn total(zones: usize, known: &Rough, part: impl Fn(&(Vec<Bands>, Vec<Bands>)) -> &Vec<Bands>) -> Vec<Bands> {
    let mut sum = vec![[0.0; 3]; zones];
    for one in known {
        sum.iter_mut().zip(part(one)).for_each(|(a, x)| *a = bands(|b| a[b] + x[b]));
    }
    sum
}

/// The engine by links, beside what the views say.
fn links<'a>(
    site: &Site<'a>,
    escape: &mut Escape,
    seeing: Seeing<'a>,
    noise: Vec<Bands>,
    known: Rough,
) -> Result<Built<'a>, SceneError> {
    let (zones, tolerance) = (site.zones, site.scene.options().tolerance);
    let factors = Factors::new(site);
    let rays = seeing.rays();
    let mut made = Hierarchical::new(site, known, &factors, FIRST * tolerance)
        .ok_or_else(|| SceneError::new("scene", "the scene has no zones; add a surface or a medium"))?;
    dbg_t("refined");
    made.seeing = Some((seeing, noise));
    let mut warnings = Vec::new();
    for round in 1.. {
        let estimate = made.estimated(site, escape);
        dbg_t("estimated");
        eprintln!(
            "estimate {estimate:.4} eps {:.4} links {} rays {}",
            made.epsilon,
            made.links.len(),
            made.tally.rays
        );
        if estimate <= CONTENT * tolerance {
            break;
        }
        if round >= ROUNDS || zones.len() > PURSUED {
            warnings.push(format!(
                "the estimated error, {estimate:.1e}, is above what the tolerance {tolerance} asks: give a smaller tolerance"
            ));
            break;
        }
        let factor = (CONTENT * tolerance / estimate).powf(STEEPNESS).clamp(LEAST_STEP, 0.7);
        made.epsilon *= factor;
        made.refine(site, &factors);
    }
    made.debug_zone(&total(zones.len(), &made.known, |k| &k.0));
    let closure = crate::closure::measure(&made, zones, escape);
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
        ("rays of views", rays),
    ];
    Ok(Built {
        operator: Box::new(made),
        noise: Vec::new(),
        closure,
        counts: list.into_iter().map(|(k, v)| (k.to_string(), v)).collect(),
        warnings,
        warm: None,
    })
}

impl<'a> Hierarchical<'a> {
    /// Refines for ε by what is roughly known of all light groups: strengths and what arrives; `None` without zones.
    pub fn new(site: &Site<'a>, known: Rough, factors: &Factors, epsilon: f64) -> Option<Hierarchical<'a>> {
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
            scaling: None,
            epsilon,
            known,
            seeing: None,
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
        let demand = demand::demand(&self.tree, site.zones, &known, self.epsilon, FLOOR);
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

    /// Solves roughly with the links at hand and returns the estimated relative error.
    fn estimated(&mut self, site: &Site, escape: &Escape) -> f64 {
        self.solve_roughly(site, escape);
        let n = self.measure.len();
        let (sum, arriving) = (total(n, &self.known, |k| &k.0), total(n, &self.known, |k| &k.1));
        let mut errors = estimate::errors(&self.tree, &self.spots, &self.links, self.group, &sum);
        if let Some((_, noise)) = &self.seeing {
            for (i, e) in errors.iter_mut().enumerate() {
                let other = noise[i].map(|x| x / self.measure[i]);
                *e = joined(*e, other).1;
            }
        }
        relative(site, &arriving, &errors)
    }

    /// Closure restored by clusters: what was measured before, with the change.
    fn restore(
        &mut self,
        site: &Site,
        escape: &mut Escape,
        (mut report, defects): (Closure, Vec<Bands>),
    ) -> (Closure, Vec<Bands>) {
        let d = closure::scaling(
            &self.tree,
            self,
            site.zones,
            escape,
            &total(self.measure.len(), &self.known, |k| &k.0),
        );
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

impl Hierarchical<'_> {
    fn debug_zone(&self, strengths: &[Bands]) {
        let Ok(z) = std::env::var("DBG_ZONE") else { return };
        let z: u32 = z.parse().unwrap();
        let slot = self.tree.zone.iter().position(|x| *x == z).unwrap();
        let mut n = self.tree.leaf(slot);
        let mut power = vec![0.0; self.tree.nodes.len()];
        for k in (0..power.len()).rev() {
            let node = &self.tree.nodes[k];
            power[k] = if node.is_leaf() {
                node.weight as f64 * strengths[self.tree.zone[node.first as usize] as usize][0]
            } else {
                self.tree.kids(k as u32).iter().map(|&c| power[c as usize]).sum()
            };
        }
        loop {
            let node = &self.tree.nodes[n];
            let mut list: Vec<(f64, usize)> = self
                .links
                .of(n)
                .map(|l| {
                    (
                        self.links.kernel[l * self.links.groups].abs() as f64
                            * power[self.links.other[l] as usize],
                        l,
                    )
                })
                .collect();
            list.sort_by(|a, b| b.0.total_cmp(&a.0));
            let total: f64 = list.iter().map(|x| x.0).sum();
            let row: f64 = list
                .iter()
                .map(|x| {
                    self.links.kernel[x.1 * self.links.groups].abs() as f64
                        * self.tree.nodes[self.links.other[x.1] as usize].weight as f64
                })
                .sum();
            eprintln!(
                "node {n} leaves {} r {:.2} cone {:.2} c {:?} n {:?}: links {} bring {total:.4} row {row:.4}",
                node.leaves(),
                node.radius(),
                node.cone,
                node.centre,
                node.normal,
                list.len()
            );
            for (v, l) in list.iter().take(6) {
                let j = self.links.other[*l] as usize;
                let o = &self.tree.nodes[j];
                let k = self.links.kernel[*l * self.links.groups];
                eprintln!(
                    "    {v:.4} j {j} {:?} leaves {} r {:.2} cone {:.2} c {:?} W {:.3} k {k:.4} F {:.4} doubt {:.4} n {:?} full {}",
                    o.kind,
                    o.leaves(),
                    o.radius(),
                    o.cone,
                    o.centre,
                    o.weight,
                    k.abs() * o.weight,
                    self.links.doubt[*l] as f64 * power[j],
                    o.normal,
                    o.full
                );
            }
            let up = self.tree.parent[n] as usize;
            if up == n {
                break;
            }
            n = up;
        }
    }
}

impl Operator for Hierarchical<'_> {
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
        let mut all = vec![[0.0; 3]; self.len()];
        for s in columns {
            all.iter_mut().zip(s).for_each(|(a, s)| *a = bands(|b| a[b] + s[b]));
        }
        let (mut out, error) = (self.apply_many(columns), self.error(&all));
        let Some((seeing, _)) = &self.seeing else {
            return Arriving { columns: out, error };
        };
        let mut error = error.unwrap_or_default();
        let seen = seeing.arriving(columns);
        let noise = seen.error.unwrap_or_default();
        for i in 0..self.len() {
            let (share, e) = joined(error[i], noise[i]);
            for (o, s) in out.iter_mut().zip(&seen.columns) {
                o[i] = bands(|b| share * o[i][b] + (1.0 - share) * s[i][b]);
            }
            error[i] = e;
        }
        Arriving { columns: out, error: Some(error) }
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
