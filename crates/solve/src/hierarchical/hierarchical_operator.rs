//! The exchange operator of links over a tree of clusters, with its error model.
//!
//! The incident power of a solution is that of the links, blended with that of the rays where these help ([`super::estimator_blend`]).

use super::estimator_blend::{BlendedZone, LinkEstimate, RayEstimate, ZoneEstimate, blend};
use crate::cluster::cluster_visibility::ClusterVisibility;
use crate::cluster::error_budget::{ErrorBudget, GroupSolution};
use crate::cluster::kernel::CompactNode;
use crate::cluster::link_error::estimate_errors;
use crate::cluster::links::{LinkMatrix, Links};
use crate::cluster::pair_kernel::PairKernels;
use crate::cluster::refinement::{RefinementCounts, Refiner};
use crate::cluster::tree::ClusterTree;
use crate::dense::band_groups::{InteriorPanes, band_groups, first_bands};
use crate::iteration::multivector::{times, total};
use crate::iteration::{LinearSystem, StoppingCriterion, conjugate_gradients};
use crate::operator::{ErrorModel, ExchangeOperator, IncidentPower};
use crate::ray::ray_table::IncidentEstimate;
use crate::solve_context::SolveContext;
use crate::surroundings::SurroundingsExchange;
use crate::zone_power::{closure_targets, reflection_weights};
use rayon::prelude::*;
use zonal_exchange::aligned::FactorCache;
use zonal_exchange::pair::{Exchange, PairSettings};
use zonal_math::Grade;
use zonal_scene::{Bands, NoCheckpoints, PerBand};

/// Stated errors over those of the links and rays of a zone: the incident radiation was passed on by other zones, whose errors these do not
/// include.
const STATED_ERROR_FACTOR: f64 = 1.3;
/// End of the iteration of an approximate solution.
const APPROXIMATE_STOP: StoppingCriterion = StoppingCriterion { residual: 1e-2, max_iterations: 40 };
/// Relative radius of the exchange factors of boxes.
const BOX_FACTOR_TOLERANCE: f64 = 1e-6;

/// The approximate solution of a light group.
#[derive(Clone, Debug)]
pub struct ApproximateGroup {
    /// Strengths of all zones, W/m² or W/m³.
    pub strengths: Vec<Bands>,
    /// Incident radiation, H of patches and G of volume zones, W/m².
    pub incident: Vec<Bands>,
}

/// Exchange factors of pairs, prepared once for all refinements.
pub struct PairFactors<'a> {
    exchange: Exchange<'a>,
    boxes: FactorCache,
}

impl<'a> PairFactors<'a> {
    /// For the zones of a solve.
    pub fn new(context: &SolveContext<'a>) -> PairFactors<'a> {
        let settings = PairSettings { keep_zones: false, ..PairSettings::default() };
        let exchange = Exchange::with_settings(context.scene, context.zones, context.transport, settings);
        PairFactors { exchange, boxes: FactorCache::new(BOX_FACTOR_TOLERANCE) }
    }
}

/// Links over a tree of clusters.
pub struct HierarchicalOperator {
    tree: ClusterTree,
    nodes: Vec<CompactNode>,
    links: Links,
    /// Band group of each band.
    band_groups: PerBand<usize>,
    /// Area or volume of every zone.
    measure: Vec<f64>,
    /// Number of patches.
    patches: usize,
    /// d of every zone, where rows are scaled.
    scaling: Option<Vec<Bands>>,
    /// ε of the last refinement.
    epsilon: f64,
    /// The approximate solution for which the links were refined.
    solution: Vec<ApproximateGroup>,
    /// The incident power by rays, for the blend; `None` for links alone.
    rays: Option<RayEstimate>,
    counts: RefinementCounts,
}

/// The stated error for an estimated one.
pub(crate) fn stated_error(error: Bands) -> Bands {
    STATED_ERROR_FACTOR * error
}

/// Brightness of every zone over the mean: direct and incident radiation, the largest of the bands, G at a quarter.
fn brightness(context: &SolveContext, solution: &[ApproximateGroup]) -> Vec<f32> {
    let direct = context.direct.fields(context.zones.len());
    let mut bright: Vec<f32> = direct
        .par_iter()
        .enumerate()
        .map(|(i, d)| {
            let all = solution.iter().fold(*d, |a, k| a + k.incident[i]);
            let unit = if i < context.zones.voxel_offset() { 1.0 } else { 0.25 };
            (unit * all.max_element()) as f32
        })
        .collect();
    let sum = bright.iter().map(|x| *x as f64).sum::<f64>();
    let level = (sum / bright.len().max(1) as f64).max(f64::MIN_POSITIVE) as f32;
    bright.iter_mut().for_each(|x| *x /= level);
    bright
}

impl HierarchicalOperator {
    /// Builds the tree and refines its links for the tolerance `epsilon`, by an approximate solution of all light groups. `None` without
    /// zones.
    pub fn new(
        context: &SolveContext,
        solution: Vec<ApproximateGroup>,
        factors: &PairFactors,
        epsilon: f64,
    ) -> Option<HierarchicalOperator> {
        let tree = ClusterTree::new(context.scene, context.zones, &brightness(context, &solution))?;
        let nodes: Vec<CompactNode> = tree.nodes.iter().map(CompactNode::of).collect();
        let (groups, group_count) = band_groups(context.scene, InteriorPanes::of(context.transport));
        let mut measure = vec![0.0; context.zones.len()];
        for leaf in 0..tree.leaves() {
            measure[tree.leaf_zones[leaf] as usize] = tree.nodes[tree.leaf_node(leaf)].measure as f64;
        }
        let mut operator = HierarchicalOperator {
            tree,
            nodes,
            links: Links { group_count, ..Links::default() },
            band_groups: groups,
            measure,
            patches: context.zones.voxel_offset(),
            scaling: None,
            epsilon,
            solution,
            rays: None,
            counts: RefinementCounts::default(),
        };
        operator.refine(context, factors);
        Some(operator)
    }

    /// The tree of clusters.
    pub(crate) fn tree(&self) -> &ClusterTree {
        &self.tree
    }
    /// Number of directed links.
    pub(crate) fn link_count(&self) -> usize {
        self.links.len()
    }
    /// Includes the incident power by rays in that of the solution.
    pub(crate) fn blend_with(&mut self, rays: Option<RayEstimate>) {
        self.rays = rays;
    }
    /// Strengths of all groups of the approximate solution together.
    pub(crate) fn approximate_strengths(&self) -> Vec<Bands> {
        total(self.len(), self.solution.iter().map(|k| &k.strengths))
    }

    /// Names and values of the counters.
    pub(crate) fn counters(&self) -> [(&'static str, u64); 9] {
        let c = &self.counts;
        [
            ("inner nodes", self.tree.inner_nodes as u64),
            ("links, each direction", self.links.len() as u64),
            ("bytes of links", self.links.bytes()),
            ("pairs of clusters looked at", c.visits),
            ("pairs that nothing can divide", c.unoccluded),
            ("pairs split for what hides them", c.split_by_visibility),
            ("pairs of near zones", c.near_factors),
            ("pairs of zones in full", c.full_factors),
            ("rays between clusters", c.rays),
        ]
    }

    /// Refines the links for the tolerance `factor` times the present one.
    pub(crate) fn refine_further(&mut self, context: &SolveContext, factors: &PairFactors, factor: f64) {
        self.epsilon *= factor;
        self.refine(context, factors);
    }

    /// Refines the links for the present tolerance and approximate solution.
    fn refine(&mut self, context: &SolveContext, factors: &PairFactors) {
        let group_count = self.links.group_count;
        let first_bands = first_bands((self.band_groups, group_count));
        let groups: Vec<GroupSolution> = self
            .solution
            .iter()
            .map(|g| GroupSolution { strengths: &g.strengths, incident: &g.incident })
            .collect();
        let budget = ErrorBudget::new(&self.tree, context.zones, &groups, self.epsilon);
        let visibility = ClusterVisibility::new(context.scene, context.zones, context.transport, &self.tree);
        let pairs = PairKernels {
            tree: &self.tree,
            nodes: &self.nodes,
            visibility: &visibility,
            exchange: &factors.exchange,
            box_factors: &factors.boxes,
            first_bands: &first_bands,
        };
        let (pairs, counts) = Refiner { pairs, budget: &budget }.refine(context.progress);
        self.links = Links::new(self.tree.nodes.len(), &pairs, group_count);
        (self.scaling, self.counts) = (None, counts);
    }

    /// Solves all groups approximately by the links.
    pub(crate) fn solve_approximately(
        &mut self,
        context: &SolveContext,
        surroundings: &SurroundingsExchange,
    ) {
        let (weights, targets) = (reflection_weights(context.zones), closure_targets(context.zones));
        let system = LinearSystem { operator: self, weights: &weights, targets: &targets };
        let columns = context.source_strengths(surroundings);
        let initial: Vec<Vec<Bands>> = self.solution.iter().map(|k| k.strengths.clone()).collect();
        let results = conjugate_gradients::solve(
            &system,
            &columns,
            Some(&initial),
            APPROXIMATE_STOP,
            &NoCheckpoints,
            context.progress,
        );
        self.solution = results
            .into_iter()
            .map(|e| {
                let mut incident = self.apply(&e.strengths);
                incident.iter_mut().zip(&self.measure).for_each(|(h, w)| *h /= *w);
                ApproximateGroup { strengths: e.strengths, incident }
            })
            .collect();
    }

    /// Incident power of the approximate solution by the links.
    pub(crate) fn approximate_incident(&self) -> LinkEstimate {
        let strengths: Vec<Vec<Bands>> = self.solution.iter().map(|k| k.strengths.clone()).collect();
        self.by_links(&strengths)
    }

    /// H or G of all groups together, W/m², for incident powers and the stated error of their sum.
    pub(crate) fn total_incident(
        &self,
        columns: &[Vec<Bands>],
        error: impl Iterator<Item = Bands>,
    ) -> Vec<IncidentEstimate> {
        let value = total(self.len(), columns);
        let both = value.iter().zip(error).zip(&self.measure);
        both.map(|((v, e), m)| IncidentEstimate { value: v / *m, error: e / *m }).collect()
    }

    /// Incident power of strengths by the links, with its error.
    fn by_links(&self, columns: &[Vec<Bands>]) -> LinkEstimate {
        let error = self.error(&total(self.len(), columns)).unwrap_or_default();
        LinkEstimate { columns: self.apply_many(columns), error }
    }

    /// The blend of both estimates, with its stated error.
    pub(crate) fn blend_estimates(&self, rays: &RayEstimate, links: LinkEstimate) -> IncidentPower {
        let n = self.len();
        let LinkEstimate { columns: mut out, error } = links;
        let (link_sum, ray_sum) = (total(n, &out), total(n, &rays.columns));
        let blended = blend(
            &self.tree,
            self.patches,
            ZoneEstimate { value: &link_sum, error: &error },
            &rays.raw,
            ZoneEstimate { value: &ray_sum, error: &rays.error },
        );
        for (o, s) in out.iter_mut().zip(&rays.columns) {
            for (i, &BlendedZone { link_share, .. }) in blended.iter().enumerate() {
                o[i] = link_share * o[i] + (1.0 - link_share) * s[i];
            }
        }
        let error = blended.into_iter().map(|z| stated_error(z.error)).collect();
        IncidentPower { columns: out, error: Some(error) }
    }

    fn matrix(&self) -> LinkMatrix<'_> {
        LinkMatrix { tree: &self.tree, nodes: &self.nodes, links: &self.links, band_groups: self.band_groups }
    }
}

impl ExchangeOperator for HierarchicalOperator {
    fn len(&self) -> usize {
        self.measure.len()
    }
    fn apply(&self, s: &[Bands]) -> Vec<Bands> {
        let scaled = self.scaling.as_ref().map(|d| times(s, d));
        let mut out = self.matrix().apply(scaled.as_deref().unwrap_or(s));
        out.iter_mut().zip(&self.measure).for_each(|(o, w)| *o *= *w);
        match &self.scaling {
            Some(d) => times(&out, d),
            None => out,
        }
    }
    fn scale(&mut self, d: &[Bands]) {
        let old = self.scaling.take();
        self.scaling = Some(match old {
            Some(o) => times(&o, d),
            None => d.to_vec(),
        });
    }
}

impl ErrorModel for HierarchicalOperator {
    fn error(&self, strengths: &[Bands]) -> Option<Vec<Bands>> {
        let mut e = estimate_errors(&self.matrix(), strengths);
        if let Some(d) = &self.scaling {
            let h = self.matrix().apply(strengths);
            e.iter_mut().zip(d.iter().zip(&h)).for_each(|(e, (d, h))| {
                *e += (d * d - 1.0).abs() * h;
            });
        }
        e.iter_mut().zip(&self.measure).for_each(|(e, w)| *e *= *w);
        Some(e)
    }
    fn incident_power(&self, columns: &[Vec<Bands>]) -> IncidentPower {
        let links = self.by_links(columns);
        match &self.rays {
            Some(rays) => self.blend_estimates(rays, links),
            None => {
                let error = links.error.into_iter().map(stated_error).collect();
                IncidentPower { columns: links.columns, error: Some(error) }
            }
        }
    }
    fn grade(&self) -> Grade {
        Grade::Estimated
    }
}
