//! Construction of the hierarchical engine for a tolerance.
//!
//! 1. Trace rays from every zone; solve and smooth; repeat with more rays where few are missing.
//! 2. Return the solution by rays where it meets the tolerance, or where links are too many.
//! 3. Refine links by that solution, solve approximately, and lower ε until the estimated error of both together meets the tolerance.
//! 4. Where links do not converge and every pair fits into memory, return the engine of all pairs.

use super::closure_scaling::{limit_rows, restore_by_clusters};
use super::estimator_blend::RayEstimate;
use super::hierarchical_operator::{ApproximateGroup, HierarchicalOperator, PairFactors, stated_error};
use super::memory_budget::MemoryBudget;
use crate::dense::band_groups::{InteriorPanes, band_groups, matrix_bytes};
use crate::iteration::IterationResult;
use crate::iteration::multivector::total;
use crate::operator::IncidentPower;
use crate::ray::ray_operator::{PathContinuation, RayOperator};
use crate::ray::ray_sampling::{
    AboveMaximum, RaysPerZone, increased_rays_per_zone, rays_measure_escape, rays_per_zone, uses_rays_only,
};
use crate::ray::ray_table::IncidentEstimate;
use crate::report::closure;
use crate::settings::check_interrupted;
use crate::solve_context::{BuiltEngine, SolveContext};
use crate::surroundings::SurroundingsExchange;
use crate::thermal::newton;
use zonal_math::Grade;
use zonal_scene::{Bands, Diagnostic, ErrorEstimate, Fields, SceneError, Zones};

/// Passes and limits of the construction.
///
/// Numbers of zones, links and rays with these values: `cargo run --release --example growth -- scenes/hall.toml --factors 1,2,4,8,16,32,64` and
/// `cargo run --release --example against_dense -- c0 c9 c8 random1 random2 demo cornell --dense 0.003` (`docs/hierarchical.md`).
struct BuildParams {
    /// Most passes of rays.
    max_ray_passes: usize,
    /// Most refinements of links.
    max_refinements: usize,
    /// ε of the first refinement over the tolerance.
    first_epsilon: f64,
    /// Zones above which links better than rays cost too much time; the maximum of rays is traced instead. Links that were not refined
    /// further were worse: 25 % too bright in places of the small church, where rays err by 2 %.
    max_zones_with_links: usize,
    /// The estimate of links falls as ε to the power of one over this.
    epsilon_exponent: f64,
    /// Range of the factor on ε of one refinement.
    epsilon_step: [f64; 2],
    /// Smallest reduction of the estimate, as a factor, that continues the refinement: above it the errors of single pairs dominate.
    max_stagnation_ratio: f64,
    /// Links over all pairs of zones above which the engine of all pairs costs less. Reached by `random1` and `random2` below 0.03.
    max_links_over_pairs: f64,
    /// Estimate of the rays over that of the links above which the rays neither test nor improve the links.
    max_ray_error_over_links: f64,
}

const BUILD_PARAMS: BuildParams = BuildParams {
    max_ray_passes: 3,
    max_refinements: 6,
    first_epsilon: 0.6,
    max_zones_with_links: 60_000,
    epsilon_exponent: 1.8,
    epsilon_step: [0.2, 0.7],
    max_stagnation_ratio: 0.9,
    max_links_over_pairs: 0.3,
    max_ray_error_over_links: 6.0,
};

/// Warning where memory allows too few links.
pub(crate) const LINKS_EXCEED_MEMORY: &str =
    "memory does not allow the links that would meet the tolerance: allow more (--max-memory)";

/// Builds the engine of all pairs of zones.
pub(crate) type BuildAllPairs = for<'a> fn(&SolveContext<'a>, &mut SurroundingsExchange) -> BuiltEngine<'a>;

/// True where links follow rays that miss the tolerance.
pub(crate) fn allows_links(zones: &Zones) -> bool {
    zones.len() <= BUILD_PARAMS.max_zones_with_links
}

fn no_zones() -> SceneError {
    SceneError::new("scene", "the scene has no zones; add a surface or a medium")
}

/// Builds the engine for all light groups of a scene. `all_pairs` builds the alternative to links.
pub(crate) fn build<'a>(
    context: &SolveContext<'a>,
    surroundings: &mut SurroundingsExchange,
    all_pairs: BuildAllPairs,
) -> Result<BuiltEngine<'a>, SceneError> {
    let (zones, tolerance) = (context.zones, context.scene.options().tolerance);
    if zones.is_empty() {
        return Err(no_zones());
    }
    let budget = MemoryBudget::new(context.scene, zones, context.transport, context.memory_limit);
    let (rays, rays_per_zone) = solve_by_rays(context, surroundings, &budget)?;
    let ray_warning = budget.ray_warning(zones, tolerance, rays_per_zone);
    let met = rays.error <= tolerance;
    let links_fit = budget.holds_links(zones, tolerance);
    // Infinite radiation cannot be refined: the solve ends with its diagnostics.
    let is_finite = |k: &ApproximateGroup| k.incident.iter().flatten().all(|x| x.is_finite());
    if met || !allows_links(zones) || !links_fit || !rays.solution.iter().all(is_finite) {
        let mut warnings: Vec<Diagnostic> = ray_warning.into_iter().collect();
        if !met {
            // True where no tolerance requires more rays.
            let maximum = rays_per_zone == self::rays_per_zone(zones, f64::MIN_POSITIVE, f64::INFINITY);
            let remedy = if maximum && !allows_links(zones) { Remedy::FewerZones } else { Remedy::Tolerance };
            warnings.push(tolerance_missed(rays.error, tolerance, remedy));
            let barred = allows_links(zones) && !links_fit;
            warnings.extend(barred.then(|| Diagnostic::warning("memory", LINKS_EXCEED_MEMORY)));
        }
        return Ok(rays.into_engine(zones, surroundings, warnings));
    }
    let mut built = build_links(context, surroundings, rays, &budget, all_pairs)?;
    built.warnings.extend(ray_warning);
    Ok(built)
}

/// The solution by rays from every zone.
struct RaySolution<'a> {
    operator: RayOperator<'a>,
    /// Results of the iteration without the strengths, which are in `solution`.
    results: Vec<IterationResult>,
    incident: RayEstimate,
    solution: Vec<ApproximateGroup>,
    /// Estimated relative error.
    error: f64,
    resampled_rays: u64,
}

/// Traces rays and solves, with more rays where the estimated error exceeds the tolerance and more are allowed.
fn solve_by_rays<'a>(
    context: &SolveContext<'a>,
    surroundings: &mut SurroundingsExchange,
    budget: &MemoryBudget,
) -> Result<(RaySolution<'a>, RaysPerZone), SceneError> {
    let (zones, tolerance) = (context.zones, context.scene.options().tolerance);
    let mut rays = budget.affordable_rays(zones, tolerance).ok_or_else(|| {
        SceneError::out_of_memory("solve.patch_size", "memory allows too few rays; allow more (--max-memory)")
    })?;
    let mut solution = RaySolution::new(context, surroundings, rays);
    check_interrupted(context.progress)?;
    let above_maximum =
        if allows_links(zones) { AboveMaximum::KeepPresent } else { AboveMaximum::UseMaximum };
    for _ in 1..if uses_rays_only(zones) { 1 } else { BUILD_PARAMS.max_ray_passes } {
        let factor = solution.error / tolerance;
        let more = increased_rays_per_zone(zones, rays, factor, budget.max_rays, above_maximum);
        if solution.error <= tolerance || more == rays {
            break;
        }
        rays = more;
        // Release the old rays first: both tables may not fit.
        drop(solution);
        solution = RaySolution::new(context, surroundings, rays);
        check_interrupted(context.progress)?;
    }
    Ok((solution, rays))
}

impl<'a> RaySolution<'a> {
    fn new(
        context: &SolveContext<'a>,
        surroundings: &mut SurroundingsExchange,
        rays: RaysPerZone,
    ) -> RaySolution<'a> {
        let zones = context.zones;
        // Small scenes have constant zones as in the dense engine; a fixed scattering order counts exchanges between zones.
        let continues = uses_rays_only(zones) && context.scene.options().scattering_orders.is_none();
        let continuation = if continues { PathContinuation::On } else { PathContinuation::Off };
        let mut operator = RayOperator::new(context, rays, continuation);
        if rays_measure_escape(context.scene, zones) {
            operator.measure_escape(surroundings);
        }
        // Solve, and estimate the incident radiation of the solution.
        let mut results = operator.solve_groups(context, surroundings);
        let strengths: Vec<Vec<Bands>> =
            results.iter_mut().map(|e| std::mem::take(&mut e.strengths)).collect();
        let estimated = operator.estimate_incident(&strengths);
        let unsmoothed = estimated.unsmoothed.into_iter().zip(estimated.unsmoothed_error);
        let raw = unsmoothed.map(|(value, error)| IncidentEstimate { value, error }).collect();
        let incident = RayEstimate { columns: estimated.columns, error: estimated.error, raw };
        // H and G of every group, and of all groups together with the error.
        let over_measure = |i: usize, v: Bands| v / zones.response(i).1;
        let field = |p: &Vec<Bands>| p.iter().enumerate().map(|(i, v)| over_measure(i, *v)).collect();
        let fields = incident.columns.iter().map(field);
        let solution: Vec<ApproximateGroup> = strengths
            .into_iter()
            .zip(fields)
            .map(|(strengths, incident)| ApproximateGroup { strengths, incident })
            .collect();
        let value = total(zones.len(), solution.iter().map(|k| &k.incident));
        let error = incident.error.iter().enumerate().map(|(i, e)| over_measure(i, *e));
        let estimate: Vec<IncidentEstimate> =
            value.into_iter().zip(error).map(|(value, error)| IncidentEstimate { value, error }).collect();
        // A relit scene has other weights of the groups: each group meets the tolerance.
        let error = relative_error(context, surroundings, &estimate).max(estimated.equal_weight_error);
        RaySolution { operator, results, incident, solution, error, resampled_rays: estimated.resampled_rays }
    }

    /// The engine whose solution is that of the rays.
    fn into_engine(
        self,
        zones: &Zones,
        surroundings: &SurroundingsExchange,
        warnings: Vec<Diagnostic>,
    ) -> BuiltEngine<'a> {
        let closure = closure::measure(&self.operator, zones, surroundings);
        let [rays, vertices] = self.operator.rays_and_vertices();
        let counts = [
            ("transport_rays", rays),
            ("rays that went on", vertices),
            ("rays shot again", self.resampled_rays),
        ];
        let counts = counts.map(|(k, v)| (k.to_string(), v)).to_vec();
        let incident = IncidentPower { columns: self.incident.columns, error: Some(self.incident.error) };
        let mut results = self.results;
        results.iter_mut().zip(self.solution).for_each(|(e, k)| e.strengths = k.strengths);
        let (operator, solved) = (Box::new(self.operator), Some((results, incident)));
        BuiltEngine { operator, closure, counts, warnings, solved }
    }
}

/// Estimated relative error with the radiation from the surroundings, the largest over kinds of zones and bands.
fn relative_error(
    context: &SolveContext,
    surroundings: &SurroundingsExchange,
    all: &[IncidentEstimate],
) -> f64 {
    let sky = context.scene.surroundings().radiosity();
    let with_sky = |(i, m): (usize, &IncidentEstimate)| {
        let ([value, error], measure) = (surroundings.incoming(i, sky), context.zones.response(i).1);
        let error = m.error.hypot(error / measure);
        (error, m.value + value / measure)
    };
    let (error, incident) = all.iter().enumerate().map(with_sky).unzip();
    let fields = Fields { error, incident, ..Fields::default() };
    let e = ErrorEstimate::of(&fields, context.zones.voxel_offset(), Grade::Estimated);
    e.patches.iter().chain(&e.volumes).fold(0.0, |m, x| m.max(*x))
}

/// Advice where the tolerance is missed.
#[derive(Clone, Copy)]
enum Remedy {
    /// The number of rays is at its maximum.
    FewerZones,
    /// A smaller tolerance gives more rays or links.
    Tolerance,
}

fn tolerance_missed(estimate: f64, tolerance: f64, remedy: Remedy) -> Diagnostic {
    let advice = match remedy {
        Remedy::FewerZones => {
            "the number of rays is at its maximum; use fewer zones (patch_size, cells), or a larger tolerance"
        }
        Remedy::Tolerance => "give a smaller tolerance",
    };
    let text = format!("the estimated error, {estimate:.1e}, is above the tolerance {tolerance}: {advice}");
    Diagnostic::warning("tolerance", text)
}

/// The refinement of links for a tolerance.
struct LinkRefinement<'a, 'b> {
    context: &'a SolveContext<'b>,
    surroundings: &'a SurroundingsExchange,
    factors: &'a PairFactors<'b>,
    budget: &'a MemoryBudget,
    rays: &'a RayEstimate,
    /// Estimated relative error of the rays.
    ray_error: f64,
}

/// End of the refinement of links.
enum RefinementEnd {
    /// The links are used.
    Links {
        /// True if the rays are blended in.
        blended: bool,
        /// Rows scaled down to their target.
        limited_rows: usize,
        /// Why the tolerance is missed, if it is.
        warnings: Vec<Diagnostic>,
    },
    /// All pairs cost less.
    AllPairs,
}

impl LinkRefinement<'_, '_> {
    /// Refines the links until their estimated error, blended with that of the rays, meets the tolerance, or until refinement stops to help.
    fn run(&self, operator: &mut HierarchicalOperator) -> Result<RefinementEnd, SceneError> {
        let tolerance = self.context.scene.options().tolerance;
        let pairs = (self.context.zones.len() as f64).powi(2);
        let mut before = f64::INFINITY;
        for round in 1.. {
            let limited_rows = limit_rows(operator, self.context.zones, self.surroundings);
            operator.solve_approximately(self.context, self.surroundings);
            check_interrupted(self.context.progress)?;
            let (estimate, blended) = self.estimate(operator);
            let end = |warnings| RefinementEnd::Links { blended, limited_rows, warnings };
            let missed = || tolerance_missed(estimate, tolerance, Remedy::Tolerance);
            if estimate <= tolerance {
                return Ok(end(Vec::new()));
            }
            // Stop where the links cost more than all pairs, stagnate or exceed the memory.
            let links = operator.link_count() as f64;
            if links > BUILD_PARAMS.max_links_over_pairs * pairs && self.all_pairs_fit() {
                return Ok(RefinementEnd::AllPairs);
            }
            if round >= BUILD_PARAMS.max_refinements || estimate > BUILD_PARAMS.max_stagnation_ratio * before
            {
                return Ok(end(vec![missed()]));
            }
            before = estimate;
            let [least, most] = BUILD_PARAMS.epsilon_step;
            let step = (tolerance / estimate).powf(BUILD_PARAMS.epsilon_exponent).clamp(least, most);
            if links / step * self.budget.link > self.budget.link_memory {
                return Ok(end(vec![missed(), Diagnostic::warning("memory", LINKS_EXCEED_MEMORY)]));
            }
            operator.refine_further(self.context, self.factors, step);
        }
        Ok(RefinementEnd::AllPairs)
    }

    /// Estimated relative error of the links, blended with the rays where these are accurate enough, and whether they are.
    fn estimate(&self, operator: &HierarchicalOperator) -> (f64, bool) {
        let relative = |columns: &[Vec<Bands>], errors: &mut dyn Iterator<Item = Bands>| {
            relative_error(self.context, self.surroundings, &operator.total_incident(columns, errors))
        };
        let links = operator.approximate_incident();
        let alone = relative(&links.columns, &mut links.error.iter().map(|e| stated_error(*e)));
        // Rays follow the radiation to its end, so they suit no fixed scattering order. Where temperatures couple the bands, they follow other
        // radiation: a zone of known power gives off in each band what it absorbs in that band.
        let scene = self.context.scene;
        let follows_all = scene.options().scattering_orders.is_none() && !newton::is_needed(scene);
        if !(follows_all && self.ray_error < BUILD_PARAMS.max_ray_error_over_links * alone) {
            return (alone, false);
        }
        let both = operator.blend_estimates(self.rays, links);
        (relative(&both.columns, &mut both.error.unwrap_or_default().into_iter()), true)
    }

    /// True where memory holds a factor of every pair.
    fn all_pairs_fit(&self) -> bool {
        let (context, zones) = (self.context, self.context.zones);
        let (_, groups) = band_groups(context.scene, InteriorPanes::of(context.transport));
        matrix_bytes(zones.len(), zones.panes.len(), groups) <= context.memory_limit
    }
}

/// The engine by links, blended with the solution by rays.
fn build_links<'a>(
    context: &SolveContext<'a>,
    surroundings: &mut SurroundingsExchange,
    rays: RaySolution,
    budget: &MemoryBudget,
    all_pairs: BuildAllPairs,
) -> Result<BuiltEngine<'a>, SceneError> {
    let (zones, tolerance) = (context.zones, context.scene.options().tolerance);
    let RaySolution { operator: ray_operator, incident, solution, error: ray_error, .. } = rays;
    let factors = PairFactors::new(context);
    let [ray_count, _] = ray_operator.rays_and_vertices();
    drop(ray_operator);
    let first_epsilon = BUILD_PARAMS.first_epsilon * tolerance;
    let mut operator =
        HierarchicalOperator::new(context, solution, &factors, first_epsilon).ok_or_else(no_zones)?;
    let rays = &incident;
    let refinement = LinkRefinement { context, surroundings, factors: &factors, budget, rays, ray_error };
    let (blended, limited_rows, warnings) = match refinement.run(&mut operator)? {
        RefinementEnd::Links { blended, limited_rows, warnings } => (blended, limited_rows, warnings),
        RefinementEnd::AllPairs => {
            drop(operator);
            let mut built = all_pairs(context, surroundings);
            let n = zones.len() as u64;
            let counts =
                [("pairs of zones, all".into(), n * (n + 1) / 2), ("transport_rays".into(), ray_count)];
            built.counts.extend(counts);
            return Ok(built);
        }
    };
    operator.blend_with(blended.then_some(incident));
    let measured = closure::measure(&operator, zones, surroundings);
    let closure = match context.scene.restores_closure() {
        true => restore_by_clusters(&mut operator, context, surroundings, measured),
        false => measured,
    };
    let more = [("rows of links held to closure", limited_rows as u64), ("transport_rays", ray_count)];
    let counts = operator.counters().into_iter().chain(more).map(|(k, v)| (k.to_string(), v)).collect();
    Ok(BuiltEngine { operator: Box::new(operator), closure, counts, warnings, solved: None })
}
