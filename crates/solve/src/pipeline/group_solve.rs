//! Solution of the zonal equations for all light groups at once.
//!
//! The groups are the columns of a multivector. Higher-order unknowns (slopes of the radiosity) have the weight and target of their zone.

use crate::context::{BlockEngine, SolveContext};
use crate::iteration::coarse_system::CoarseSystem;
use crate::iteration::{
    IterationResult, LinearSystem, StoppingCriterion, bicgstab, conjugate_gradients, neumann_series,
};
use crate::operator::mixed_sides::MixedSides;
use crate::operator::{ErrorModel, IncidentPower, extend_to_slopes};
use crate::right_hand_side::light_groups::SourceGroup;
use crate::right_hand_side::surroundings::SurroundingsExchange;
use crate::settings::SolveSettings;
use crate::settings::zone_power::{closure_targets, reflection_weights};
use zonal_exchange::pair::scaled_radiosity_coefficient;
use zonal_math::parallel;
use zonal_scene::{Band, Bands, Engine, LightGroup, NoCheckpoints, NoProgress, SolveStatus};

/// Residual over the tolerance at which the iteration ends for the rays engine, far below the errors of its rays.
const RESIDUAL_OVER_TOLERANCE: f64 = 1e-4;

/// Results of all groups.
pub(crate) struct SolvedColumns {
    /// The result of each group.
    pub results: Vec<IterationResult>,
    /// The incident power, if the engine determined it.
    pub incident: Option<IncidentPower>,
    /// The incident power of the strengths of each group, where the iteration has it: P = g s.
    pub products: Vec<Vec<Bands>>,
}

/// Solves all groups, from a warm start if the settings have some of them; an engine that solved them already hands over its solution.
pub(crate) fn solve_groups(block: &mut BlockEngine, engine: Engine) -> SolvedColumns {
    match block.built.solved.take() {
        Some((results, incident)) => {
            SolvedColumns { results, incident: Some(incident), products: Vec::new() }
        }
        None => iterate(block, engine),
    }
}

/// Strengths of all unknowns for sources s⁰ of the zones, of as many orders as the scene sets, else to the relative residual `residual`; infinite in bands in which neither conjugate gradients nor the series of reflections converges.
pub(crate) fn respond(
    context: &SolveContext,
    operator: &dyn ErrorModel,
    mut sources: Vec<Bands>,
    residual: f64,
) -> Vec<Bands> {
    let slope_zones = operator.slope_zones();
    let (mut weights, mut targets) = (reflection_weights(context.zones), closure_targets(context.zones));
    extend_to_slopes(&mut weights, &slope_zones);
    extend_to_slopes(&mut targets, &slope_zones);
    sources.resize(targets.len(), Bands::ZERO);
    let mixed = MixedSides { operator, zones: context.zones };
    let transmits = !context.zones.sheets.is_empty();
    let system = LinearSystem {
        operator: if transmits { &mixed } else { operator },
        weights: (&weights).into(),
        targets: &targets,
        sums: context.shared_zones().order(),
    };
    let stop = StoppingCriterion { residual, max_iterations: context.scene.options().max_iterations };
    let settings = SolveSettings { checkpoints: &NoCheckpoints, progress: &NoProgress, ..context.settings };
    let context = SolveContext { settings, ..*context };
    let columns = vec![sources];
    if let Some(orders) = context.scene.options().scattering_orders {
        let series = neumann_series::solve(&system, &columns, orders, &NoCheckpoints, &NoProgress);
        return series.into_iter().next().map_or_else(Vec::new, |sum| sum.strengths);
    }
    let coarse = coarse_system(operator, &system);
    let solved = solve_system(&context, system.clone(), coarse.as_ref(), columns.clone(), None, stop);
    let Some(result) = solved.0.into_iter().next() else {
        return Vec::new();
    };
    let has_converged = |b: Band| result.status[b] == SolveStatus::Converged;
    if Band::all().all(has_converged) {
        return result.strengths;
    }
    // Factors by few rays may have no conjugate gradients where the series converges.
    let series = neumann_series::solve(&system, &columns, RESPONSE_ORDERS, &NoCheckpoints, &NoProgress);
    let Some(sum) = series.into_iter().next() else { return Vec::new() };
    let whole = Bands::from_fn(|b| whole_over_sum(&sum.residuals[b]));
    let of_zone = |i: usize| {
        Bands::from_fn(
            |b| if has_converged(b) { result.strengths[i][b] } else { sum.strengths[i][b] * whole[b] },
        )
    };
    (0..result.strengths.len()).map(of_zone).collect()
}

/// Orders of the series of a response whose conjugate gradients do not converge.
const RESPONSE_ORDERS: usize = 40;
/// Orders over which the ratio of successive orders is measured.
const RATIO_ORDERS: usize = 8;
/// Largest ratio of successive orders whose geometric series is trusted.
const MAX_RATIO: f64 = 0.98;

/// The sum of a series over that of its computed orders, from the power of each order; infinite if it does not converge.
fn whole_over_sum(orders: &[f64]) -> f64 {
    let last = orders.last().copied().unwrap_or(0.0);
    let before = orders.len().checked_sub(1 + RATIO_ORDERS).map_or(0.0, |k| orders[k]);
    if last == 0.0 {
        return 1.0;
    }
    let ratio = (last / before).powf(1.0 / RATIO_ORDERS as f64);
    if ratio < MAX_RATIO {
        1.0 + last * ratio / (1.0 - ratio) / (1.0 + orders.iter().sum::<f64>())
    } else {
        f64::INFINITY
    }
}

/// The results of all groups by iteration.
fn iterate(block: &BlockEngine, engine: Engine) -> SolvedColumns {
    let BlockEngine { context, built, surroundings } = block;
    // Extend weights, targets, sources and the warm start to the higher-order unknowns.
    let slope_zones = built.operator.slope_zones();
    let (mut weights, mut targets) = (reflection_weights(context.zones), closure_targets(context.zones));
    extend_to_slopes(&mut weights, &slope_zones);
    extend_to_slopes(&mut targets, &slope_zones);
    let mut columns = context.source_strengths(surroundings);
    let initial = warm_start(context, &columns, context.settings.initial_groups).map(|mut columns| {
        columns.iter_mut().for_each(|c| c.resize(targets.len(), Bands::ZERO));
        columns
    });
    for (source, column) in context.sources.iter().zip(&mut columns) {
        let slopes = slope_sources(context, surroundings, source, &weights);
        column.reserve_exact(slopes.len());
        column.extend(slopes);
    }
    // Iterate.
    let mixed = MixedSides { operator: built.operator.as_ref(), zones: context.zones };
    let transmits = !context.zones.sheets.is_empty();
    let system = LinearSystem {
        operator: if transmits { &mixed } else { built.operator.as_ref() },
        weights: weights.into(),
        targets: &targets,
        sums: context.shared_zones().order(),
    };
    let options = context.scene.options();
    if let Some(n) = options.scattering_orders {
        let results = neumann_series::solve(
            &system,
            &columns,
            n,
            context.settings.checkpoints,
            context.settings.progress,
        );
        return SolvedColumns { results, incident: None, products: Vec::new() };
    }
    let floor = if engine == Engine::Rays { RESIDUAL_OVER_TOLERANCE * options.tolerance } else { 0.0 };
    let stop =
        StoppingCriterion { residual: options.residual.max(floor), max_iterations: options.max_iterations };
    let coarse = coarse_system(built.operator.as_ref(), &system);
    let (results, products) = solve_system(context, system, coarse.as_ref(), columns, initial, stop);
    SolvedColumns { results, incident: None, products }
}

/// The equations on blocks of zones, where the operator has blocks and some zone reflects.
fn coarse_system<'a>(operator: &'a dyn ErrorModel, system: &LinearSystem<'a>) -> Option<CoarseSystem<'a>> {
    let reflects = parallel::any(system.targets.len(), |i| system.weights[i] != Bands::ZERO);
    let reflects = system.sums.over_processes(reflects, |a, b| a || b);
    let (blocks, exchange) = reflects.then(|| operator.in_blocks()).flatten()?;
    Some(CoarseSystem::new(blocks, exchange, system, system.sums.shared_by()))
}

/// Stabilised bi-conjugate gradients where sheets transmit, else conjugate gradients; the results, and the incident power if the iteration has it.
fn solve_system(
    context: &SolveContext,
    system: LinearSystem,
    coarse: Option<&CoarseSystem>,
    columns: Vec<Vec<Bands>>,
    initial: Option<Vec<Vec<Bands>>>,
    stop: StoppingCriterion,
) -> (Vec<IterationResult>, Vec<Vec<Bands>>) {
    let (checkpoints, progress) = (context.settings.checkpoints, context.settings.progress);
    if context.zones.sheets.is_empty() {
        let initial = initial.as_deref();
        return conjugate_gradients::solve(system, coarse, columns, initial, stop, checkpoints, progress);
    }
    (bicgstab::solve(&system, &columns, initial, stop, progress), Vec::new())
}

/// Source strengths of a group for the higher-order unknowns, from the surroundings and from direct light.
fn slope_sources(
    context: &SolveContext,
    surroundings: &SurroundingsExchange,
    source: &SourceGroup,
    weights: &[Bands],
) -> Vec<Bands> {
    let zones = context.zones.len();
    let sky = source.sky(context.scene);
    let of_slope = |k: usize| {
        let ([arrives, _], w) = (surroundings.incoming(k, sky), weights[k]);
        let lights = context.direct.lights.iter().enumerate().filter(|(l, _)| source.has_light(*l));
        let direct = lights.filter_map(|(_, l)| l.slope_power.get(k - zones));
        let arrives = direct.fold(arrives, |a, d| a + d);
        w * arrives
    };
    (zones..weights.len()).map(of_slope).collect()
}

/// Strengths of earlier groups of the same names, and the sources of the others; `None` if there is no earlier group.
fn warm_start(
    context: &SolveContext,
    columns: &[Vec<Bands>],
    earlier: &[LightGroup],
) -> Option<Vec<Vec<Bands>>> {
    let zones = context.zones;
    let fits = |g: &&LightGroup| g.incident.len() == zones.len();
    let earlier_group = |name: &str| earlier.iter().find(|g| g.name == name).filter(fits);
    if !context.sources.iter().any(|s| earlier_group(&s.name).is_some()) {
        return None;
    }
    let one = |(source, column): (&SourceGroup, &Vec<Bands>)| {
        let mut out = column.clone();
        if let Some(g) = earlier_group(&source.name) {
            let mut incident = vec![Bands::ZERO; zones.len()];
            g.incident.add_to(&mut incident, g.incident_scale);
            for (i, o) in out.iter_mut().enumerate() {
                *o += scaled_radiosity_coefficient(zones, i) * zones.scattered(i, |k| incident[k]);
            }
        }
        out
    };
    Some(context.sources.iter().zip(columns).map(one).collect())
}
