//! The phases of a solve, in the order in which they run.
//!
//! [`solve_with_settings`] is the sequence for a scene: zones, boundary conditions, the zonal equations, temperatures, checks, and the
//! discretization error by a second run of the same sequence on other zones. [`solve_equations`] is the sequence of the zonal equations.
//! Long phases are stages of a [`zonal_scene::CheckpointStore`]: each light, the surroundings, the factors of the engine, the state of the
//! iteration. All other phases are cheap and are repeated with the same bits. An observer may interrupt the solve between phases and iterations;
//! stages that are complete by then stay in the store.

use crate::direct_light::emitter_exchange::{self, EmitterExchange};
use crate::direct_light::light_field::{DirectLight, LightField};
use crate::direct_light::{direct_error, illumination};
use crate::engine::{build, selection};
use crate::errors::{consistency, discretization, finite, propagation};
use crate::group_solve::{self, SolvedColumns};
use crate::iteration::IterationResult;
use crate::light_groups;
use crate::mirrors::{self, MirroredSolve};
use crate::ray::ray_sampling::rays_measure_escape;
use crate::report::cost_estimate::problem_size::ProblemSize;
use crate::report::{diagnostics, summary};
use crate::settings::{SolveSettings, check_interrupted};
use crate::solution_fields;
use crate::solve_context::{BuiltEngine, SolveContext};
use crate::surroundings::{self, SurroundingsExchange};
use crate::thermal::{self, TemperatureSolve};
use zonal_exchange::pair::StripImages;
use zonal_scene::{
    Bands, EnergyBalance, Engine, Fields, LightGroup, Progress, Report, Scene, SceneError, Solution, Zones,
};
use zonal_transport::{Transport, build_zones};

/// Solves a scene within a memory limit in bytes.
///
/// # Errors
/// If the scene cannot be solved by the requested engine, exceeds the memory limit, or yields values that are not finite, or if the observer
/// interrupts the solve.
pub fn solve(scene: Scene, memory_limit: u64, progress: &dyn Progress) -> Result<Solution, SceneError> {
    solve_with_settings(scene, &SolveSettings::new(memory_limit, progress))
}

/// Solves a scene with settings.
///
/// # Errors
/// As [`solve`].
pub fn solve_with_settings(scene: Scene, settings: &SolveSettings) -> Result<Solution, SceneError> {
    on_worker_thread(|| solve_scene(scene, settings))
}

/// Runs a function on a thread of the pool. Parallel loops that start there avoid the cost of handing work to another thread, which in small scenes
/// takes as long as the loops.
fn on_worker_thread<T: Send>(run: impl FnOnce() -> T + Send) -> T {
    rayon::scope(|_| run())
}

fn solve_scene(scene: Scene, settings: &SolveSettings) -> Result<Solution, SceneError> {
    // Divide the scene into zones.
    let transport = Transport::new(&scene);
    let zones = build_zones(&scene, &transport)?;
    let excluded = mirrors::excluded_parts_of(&scene, &transport, &zones)?;
    // Solve for the fields.
    let (zones, mut solved) = solve_on_zones(&scene, transport, zones, settings)?;
    solved.report.warnings.splice(0..0, excluded);
    // Estimate the discretization error by the same solve on other zones.
    if discretization::is_requested(&scene) {
        let solve_other = |scene: &Scene, transport: Transport, zones: Zones, settings: &SolveSettings| {
            solve_on_zones(scene, transport, zones, settings).map(|(_, solved)| solved.report)
        };
        let basis = discretization::basis_of(solved.has_slopes);
        let first =
            discretization::FirstSolve { scene: &scene, zones: &zones, fields: &solved.fields, basis };
        discretization::estimate(&first, &mut solved.report, settings, &solve_other);
        // Return an interruption of the second solve as such, not as an unknown error.
        check_interrupted(settings.progress)?;
    }
    let ZonalSolution { fields, groups, report, .. } = solved;
    let version = env!("CARGO_PKG_VERSION").to_string();
    Ok(Solution { zones, fields, groups, report, scene_hash: String::new(), version, scene })
}

/// Applies the boundary conditions to zones, solves the zonal equations, recovers temperatures and checks the result.
fn solve_on_zones(
    scene: &Scene,
    transport: Transport,
    mut zones: Zones,
    settings: &SolveSettings,
) -> Result<(Zones, ZonalSolution), SceneError> {
    thermal::apply_boundary_conditions(scene, &mut zones);
    let mut s = solve_equations(scene, &zones, &transport, settings)?;
    drop(transport);
    thermal::recover_temperatures(scene, &mut zones, &mut s.fields, &mut s.groups, &mut s.report);
    s.report.warnings.extend(diagnostics::heat_balance(scene, &zones, &s.fields, &s.report));
    finite::check_finite(scene, &zones, &mut s.fields, &mut s.groups, &mut s.report)?;
    Ok((zones, s))
}

/// Solves the zonal equations on given zones, with boundary conditions applied by [`thermal::apply_boundary_conditions`]: the fields of all light,
/// those of each light group, and the report.
///
/// # Errors
/// As [`solve`].
pub fn solve_zones(
    scene: &Scene,
    zones: &Zones,
    transport: &Transport,
    settings: &SolveSettings,
) -> Result<(Fields, Vec<LightGroup>, Report), SceneError> {
    let solved = on_worker_thread(|| solve_equations(scene, zones, transport, settings));
    let ZonalSolution { fields, groups, report, .. } = solved?;
    Ok((fields, groups, report))
}

/// Solution of the zonal equations on given zones.
struct ZonalSolution {
    fields: Fields,
    groups: Vec<LightGroup>,
    report: Report,
    /// True if the radiosity has slopes inside the zones.
    has_slopes: bool,
}

/// Solves the zonal equations of a scene; those of a scene with mirrors on its even extension.
fn solve_equations(
    scene: &Scene,
    zones: &Zones,
    transport: &Transport,
    settings: &SolveSettings,
) -> Result<ZonalSolution, SceneError> {
    let Some(mirrored) = MirroredSolve::of(scene, zones)? else {
        return solve_without_mirrors(scene, zones, transport, None, settings);
    };
    mirrors::check_settings(settings)?;
    let extension = &mirrored.extension.scene;
    let initial_groups: Vec<LightGroup> =
        settings.initial_groups.iter().map(|g| mirrored.images.extended_group(g)).collect();
    let settings = &SolveSettings { initial_groups: &initial_groups, ..*settings };
    let transport = Transport::new(extension);
    let solved = solve_without_mirrors(extension, &mirrored.zones, &transport, Some(&mirrored), settings)
        .map_err(|e| mirrors::explain(scene, e))?;
    let fields = mirrored.fields_of_part(solved.fields);
    let groups = mirrored.groups_of_part(solved.groups);
    let report = mirrored.report_of_part(solved.report, scene, zones, &fields);
    Ok(ZonalSolution { fields, groups, report, has_slopes: solved.has_slopes })
}

/// The phases of the zonal equations. `mirrored` is set where scene and zones are those of an even extension.
fn solve_without_mirrors(
    scene: &Scene,
    zones: &Zones,
    transport: &Transport,
    mirrored: Option<&MirroredSolve>,
    settings: &SolveSettings,
) -> Result<ZonalSolution, SceneError> {
    check_interrupted(settings.progress)?;
    // Select the engine.
    let images = mirrored.map(|m| &m.images);
    let size = ProblemSize::new(scene, zones, transport).with_images(images);
    let memory_limit = settings.memory_limit.saturating_sub(thermal::memory_bytes(scene, zones));
    let pair_settings = settings.pair_settings;
    let choice = selection::select_engine(scene, zones, transport, &size, (pair_settings, memory_limit))?;
    let (engine, reason) = (choice.engine, choice.reason.clone());
    // Compute the direct light by shadow rays, except for emitters whose light follows from exchange areas.
    let shadow_rays = |l: usize| {
        let light = illuminate_stage(scene, zones, transport, l, settings)?;
        Ok(match mirrored {
            Some(m) => m.even_light(l, light),
            None => light,
        })
    };
    let emitters = EmitterExchange::of(scene, zones, engine, pair_settings);
    let direct = DirectLight { lights: lights_by_shadow_rays(scene, &emitters, shadow_rays)? };
    // Sample the surroundings.
    let mut exterior = measure_surroundings(scene, zones, transport, engine, settings)?;
    if let Some(m) = mirrored {
        exterior = m.even_surroundings(&exterior);
    }
    // Choose the right-hand sides.
    let (sources, merged) = light_groups::select_groups(scene, zones);
    let context = SolveContext {
        scene,
        zones,
        transport,
        images,
        direct: &direct,
        sources: &sources,
        pair_settings,
        memory_limit,
        checkpoints: settings.checkpoints,
        progress: settings.progress,
    };
    // Build the engine, and complete the direct light by its exchange areas.
    let mut built = build::build(choice, &context, &mut exterior)?;
    check_interrupted(settings.progress)?;
    let completed = emitter_exchange::complete(&context, &built, &exterior, &emitters, shadow_rays)?;
    let context = SolveContext { direct: completed.as_ref().unwrap_or(&direct), ..context };
    // Solve the linear system, or iterate on temperatures if they couple the bands.
    let (columns, coupled) = solve_columns(&context, &mut built, &exterior, engine, settings)?;
    let SolvedColumns { mut results, incident } = columns;
    let context = SolveContext { zones: coupled.as_ref().unwrap_or(zones), ..context };
    // Compute the fields of the groups, with errors.
    let (mut fields, groups) =
        solution_fields::assemble(&context, &mut built, &exterior, (&mut results, incident), engine);
    check_interrupted(settings.progress)?;
    if scene.thermal().is_some() {
        let kind = if coupled.is_some() { TemperatureSolve::Newton } else { TemperatureSolve::Direct };
        thermal::propagate_errors(&context, &built, &mut fields, kind);
        check_interrupted(settings.progress)?;
    }
    // Balance the energy and write the report.
    let mut report =
        balance_and_report(&context, &built, &exterior, (&mut fields, &groups), &results, size.thickness);
    (report.engine, report.reason) = (engine.name().into(), reason);
    report.warnings.extend(merged);
    let tolerance = scene.options().tolerance;
    let missed = diagnostics::missed_tolerance(engine, tolerance, &report.estimate, &report.warnings);
    report.warnings.extend(missed);
    Ok(ZonalSolution { fields, groups, report, has_slopes: built.operator.len() > zones.len() })
}

/// Direct light of all lights by shadow rays; empty for emitters whose light follows from exchange areas.
fn lights_by_shadow_rays(
    scene: &Scene,
    emitters: &EmitterExchange,
    shadow_rays: impl Fn(usize) -> Result<LightField, SceneError>,
) -> Result<Vec<LightField>, SceneError> {
    let light = |l: usize| match emitters.surface(l) {
        Some(_) => Ok(LightField::default()),
        None => shadow_rays(l),
    };
    (0..scene.lights().len()).map(light).collect()
}

/// The exchange with the surroundings by rays; zeros if the engine determines it.
fn measure_surroundings(
    scene: &Scene,
    zones: &Zones,
    transport: &Transport,
    engine: Engine,
    settings: &SolveSettings,
) -> Result<SurroundingsExchange, SceneError> {
    let exterior = if let Some(strips) = StripImages::of(scene, zones) {
        SurroundingsExchange::of_strips(&strips, zones)
    } else if selection::knows_escaping_power(engine, scene) {
        SurroundingsExchange::default()
    } else if engine == Engine::Hierarchical && rays_measure_escape(scene, zones) {
        SurroundingsExchange::unmeasured(zones)
    } else {
        surroundings::stage::measure(scene, zones, transport, settings)
    };
    check_interrupted(settings.progress)?;
    Ok(exterior)
}

/// Solves the linear system of all groups, or iterates on temperatures if they couple the bands; then the zones with the emission of the
/// temperatures found follow.
fn solve_columns(
    context: &SolveContext,
    built: &mut BuiltEngine,
    exterior: &SurroundingsExchange,
    engine: Engine,
    settings: &SolveSettings,
) -> Result<(SolvedColumns, Option<Zones>), SceneError> {
    thermal::check_temperature_level(context.scene, context.zones, exterior)?;
    if thermal::newton::is_needed(context.scene) {
        let coupled = thermal::newton::solve(context, built, exterior)?;
        built.counts.push(("products with all bands".into(), coupled.products as u64));
        let columns = SolvedColumns { results: vec![coupled.result], incident: None };
        return Ok((columns, Some(coupled.zones)));
    }
    let columns = group_solve::solve_groups(context, built, exterior, engine, settings.initial_groups);
    check_interrupted(settings.progress)?;
    Ok((columns, None))
}

/// Balances the energy of a solution, widens its errors by the residual of the balance, and writes the report with the errors of all powers.
fn balance_and_report(
    context: &SolveContext,
    built: &BuiltEngine,
    exterior: &SurroundingsExchange,
    (fields, groups): (&mut Fields, &[LightGroup]),
    results: &[IterationResult],
    thickness: f64,
) -> Report {
    let (scene, zones, direct) = (context.scene, context.zones, context.direct);
    let mut energy = EnergyBalance::default();
    groups.iter().for_each(|g| energy.add(&g.energy));
    let mut lost = propagation::escaped_power_error(zones, exterior, results);
    lost = direct_error::light_power_errors(direct).into_iter().fold(lost, Bands::hypot);
    // Heat is balanced after the temperatures are recovered.
    if scene.thermal().is_none() && scene.options().scattering_orders.is_none() {
        consistency::widen_by_balance(zones, &energy, lost, fields);
    }
    let mut report = summary::summarize(context, built, exterior, (fields, energy), results, thickness);
    report.energy_error = match scene.thermal() {
        Some(_) => EnergyBalance { escaped: lost, ..EnergyBalance::default() },
        None => {
            let mut error = consistency::power_errors(zones, &report.energy, fields, |i| fields.error[i]);
            direct_error::add_to_power_errors(zones, &report.energy, direct, &mut error);
            error
        }
    };
    report
}

/// Direct light of light number `l` by shadow rays: the stage `light-…`, or computed and saved.
fn illuminate_stage(
    scene: &Scene,
    zones: &Zones,
    transport: &Transport,
    l: usize,
    settings: &SolveSettings,
) -> Result<LightField, SceneError> {
    let stage = format!("light-{l}");
    if let Some(light) = settings.checkpoints.load(&stage).and_then(|b| LightField::decode(&b, zones.len())) {
        return Ok(light);
    }
    let normalization = illumination::PowerNormalization::of(scene);
    let light = illumination::illuminate_by(scene, zones, transport, (l, normalization), settings.progress);
    if settings.checkpoints.keeps() {
        settings.checkpoints.save(&stage, &light.encode());
    }
    check_interrupted(settings.progress)?;
    Ok(light)
}
