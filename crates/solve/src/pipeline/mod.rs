//! The phases of a solve, in the order in which they run.
//!
//! Bands are solved three at a time. Every phase runs for each triple of bands; temperatures couple the triples in one iteration.
//!
//! [`solve_with_settings`] is the sequence for a scene: zones, boundary conditions, the zonal equations, temperatures, checks, and the
//! discretization error by a second run of the same sequence on other zones. `solve_equations` is the sequence of the zonal equations.
//! Long phases are stages of a [`zonal_scene::CheckpointStore`]: each light, the surroundings, the factors of the engine, the state of the
//! iteration. All other phases are cheap and are repeated with the same bits. An observer may interrupt the solve between phases and iterations;
//! stages that are complete by then stay in the store.
//!
//! | module | content |
//! |---|---|
//! | `direct_solution` | direct light alone, before the exchange is known |
//! | [`mirrors`] | scenes with mirrors on their even extensions |
//! | [`zone_division`] | division of the voxel zones among processes |
//! | `emitter_exchange` | direct light of emitters from exchange areas |
//! | `group_solve`, `solution_fields`, `error_amplification` | the solution of all light groups, its fields, and the reflection of errors |

pub(crate) mod direct_solution;
pub(crate) mod emitter_exchange;
pub(crate) mod error_amplification;
pub(crate) mod group_solve;
pub mod mirrors;
pub(crate) mod solution_fields;
pub mod zone_division;

use self::emitter_exchange::EmitterExchange;
use self::group_solve::SolvedColumns;
use self::mirrors::MirroredSolve;
use crate::context::zonal_solution::ZonalSolution;
use crate::context::{BuiltEngine, SolveContext};
use crate::engines::problem_size::ProblemSize;
use crate::engines::rays::stored_rays::ray_sampling::rays_measure_escape;
use crate::engines::selection::EngineChoice;
use crate::engines::{build, selection};
use crate::errors::discretization::{self, FirstTriple};
use crate::errors::finite;
use crate::report::balanced_report;
use crate::report::{back_faces, diagnostics};
use crate::right_hand_side::direct_light::illumination;
use crate::right_hand_side::direct_light::light_field::{DirectLight, LightField};
use crate::right_hand_side::light_groups::{self, SourceGroup};
use crate::right_hand_side::surroundings::{self, SurroundingsExchange, exact_rows};
use crate::settings::triple_checkpoints::TripleCheckpoints;
use crate::settings::{SolveSettings, check_interrupted};
use crate::thermal::newton::TripleEngine;
use crate::thermal::{self, SolvedTriple, TemperatureSolve, TripleZones};
use zonal_exchange::pair::StripImages;
use zonal_scene::{
    Diagnostic, Engine, Fields, LightGroup, Progress, Report, Scene, SceneError, Solution, Zones,
};
use zonal_transport::Transport;

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
    if scene.thermal().is_some() || scene.bands().triples() == 1 {
        return solve_triples(scene, settings);
    }
    // The bands of light are independent: their triples are solved one after the other.
    let one = |(t, triple): (usize, &Scene)| {
        let checkpoints = TripleCheckpoints { store: settings.checkpoints, triple: t };
        solve_triples(triple.first_triple(), &settings.of_triple(t, &checkpoints))
    };
    let mut solutions = scene.triples().enumerate().map(one).collect::<Result<Vec<_>, _>>()?;
    light_groups::unify_groups(&mut solutions)?;
    let further = solutions.split_off(1);
    let first = solutions.swap_remove(0);
    Ok(Solution { scene, further_triples: further, ..first })
}

/// Solves all triples of the bands of a scene together.
fn solve_triples(scene: Scene, settings: &SolveSettings) -> Result<Solution, SceneError> {
    // Divide the scene into zones.
    let transport = Transport::new(&scene);
    let zones = zone_division::known_or_shared_zones(&scene, &transport, settings)?;
    let excluded = mirrors::excluded_parts_of(&scene, &transport, &zones)?;
    let zones = zone_division::divide(&scene, &transport, zones, settings)?;
    // Solve for the fields.
    let mut solved = solve_on_zones(&scene, transport, zones, settings)?;
    solved[0].report.warnings.splice(0..0, excluded);
    // Estimate the discretization error by the same solve on other zones, or that of thick cells without one.
    let basis = discretization::basis_of(solved[0].has_slopes);
    let mut triples = FirstTriple::all(&scene, &mut solved);
    if discretization::is_requested(&scene) {
        let solve_other = |scene: &Scene, transport: Transport, zones: Zones, settings: &SolveSettings| {
            let solved = solve_on_zones(scene, transport, zones, settings)?;
            Ok(solved.into_iter().map(|s| s.report).collect())
        };
        discretization::estimate(&scene, basis, &mut triples, settings, &solve_other);
        // Return an interruption of the second solve as such, not as an unknown error.
        check_interrupted(settings.progress)?;
    } else {
        discretization::state_thick_scattering(&scene, basis, &mut triples, settings.communicator);
    }
    Ok(join_triples(scene, solved))
}

/// The solution of a scene from those of its triples of bands.
fn join_triples(scene: Scene, solved: Vec<ZonalSolution>) -> Solution {
    let scenes: Vec<Scene> = scene.triples().map(Scene::first_triple).collect();
    let of_triple = |(scene, s): (Scene, ZonalSolution)| Solution {
        scene,
        zones: s.zones,
        fields: s.fields,
        groups: s.groups,
        report: s.report,
        further_triples: Vec::new(),
        scene_hash: String::new(),
        version: env!("CARGO_PKG_VERSION").to_string(),
    };
    let mut solutions: Vec<Solution> = scenes.into_iter().zip(solved).map(of_triple).collect();
    let further_triples = solutions.split_off(1);
    Solution { scene, further_triples, ..solutions.swap_remove(0) }
}

/// Applies the boundary conditions to zones, solves the zonal equations, recovers temperatures and checks the result, for every triple of the bands.
fn solve_on_zones(
    scene: &Scene,
    transport: Transport,
    zones: Zones,
    settings: &SolveSettings,
) -> Result<Vec<ZonalSolution>, SceneError> {
    // The zones of the other triples have the same geometry.
    let others: Vec<Transport> = scene.triples().skip(1).map(Transport::new).collect();
    let mut zones = vec![zones];
    for (scene, transport) in scene.triples().skip(1).zip(&others) {
        let merged = zones[0].merged.clone();
        zones.push(Zones { merged, ..zone_division::shared_zones(scene, transport, settings.communicator)? });
    }
    let transports: Vec<&Transport> = std::iter::once(&transport).chain(&others).collect();
    thermal::emissivity::solve(scene, zones, settings, |zones, settings| {
        solve_with_reflectances(scene, &transports, zones, settings)
    })
}

/// The solution on zones that have the reflectances of their temperatures.
fn solve_with_reflectances(
    scene: &Scene,
    transports: &[&Transport],
    mut zones: Vec<Zones>,
    settings: &SolveSettings,
) -> Result<Vec<ZonalSolution>, SceneError> {
    thermal::apply_boundary_conditions(scene, &mut zones);
    let triples: Vec<TripleInput> = scene
        .triples()
        .zip(&zones)
        .zip(transports)
        .map(|((scene, zones), transport)| TripleInput { scene, zones, transport, mirrored: None })
        .collect();
    let mut solved = solve_equations(&triples, settings)?;
    solved.iter_mut().zip(zones).for_each(|(s, zones)| s.zones = zones);
    let explained = thermal::recover_temperatures(&mut solved_triples(scene, &mut solved));
    // Errors of rows that do not close are no explanation where closure can be restored.
    let explained = if scene.restores_closure() { explained } else { 0.0 };
    let backs = back_faces::lost_on_backs(
        scene,
        &solved[0].zones,
        transports[0],
        &solved[0].fields,
        &solved[0].report,
    );
    solved[0].report.warnings.extend(backs);
    for (scene, s) in scene.triples().zip(&mut solved) {
        s.report.warnings.extend(diagnostics::heat_balance(scene, &s.zones, &s.fields, &s.report, explained));
        let checked = finite::check_finite(scene, &s.zones, &mut s.fields, &mut s.groups, &mut s.report);
        finite::agree(checked, &s.zones, settings.communicator)?;
        s.zones.own_reflectances = Vec::new();
    }
    Ok(solved)
}

fn solved_triples<'a>(scene: &'a Scene, solved: &'a mut [ZonalSolution]) -> Vec<SolvedTriple<'a>> {
    let of_triple = |(scene, s): (&'a Scene, &'a mut ZonalSolution)| SolvedTriple {
        scene,
        zones: &mut s.zones,
        fields: &mut s.fields,
        groups: &mut s.groups,
        report: &mut s.report,
        emitters: s.emitters,
    };
    scene.triples().zip(solved).map(of_triple).collect()
}

/// Solves the zonal equations on given zones of a scene of one triple of bands, with boundary conditions applied by
/// [`thermal::apply_boundary_conditions`]: the fields of all light, those of each light group, and the report.
///
/// # Errors
/// As [`solve`].
pub fn solve_zones(
    scene: &Scene,
    zones: &Zones,
    transport: &Transport,
    settings: &SolveSettings,
) -> Result<(Fields, Vec<LightGroup>, Report), SceneError> {
    let solved = on_worker_thread(|| {
        solve_equations(&[TripleInput { scene, zones, transport, mirrored: None }], settings)
    });
    let ZonalSolution { fields, groups, report, .. } = solved?.swap_remove(0);
    Ok((fields, groups, report))
}

/// Scene, zones and transport of one triple of bands.
#[derive(Clone, Copy)]
struct TripleInput<'a> {
    scene: &'a Scene,
    zones: &'a Zones,
    transport: &'a Transport<'a>,
    /// Set where scene and zones are those of an even extension.
    mirrored: Option<&'a MirroredSolve>,
}

/// Solves the zonal equations of all triples of the bands; those of a scene with mirrors on its even extension.
fn solve_equations(
    triples: &[TripleInput],
    settings: &SolveSettings,
) -> Result<Vec<ZonalSolution>, SceneError> {
    let mut mirrored = Vec::new();
    for t in triples {
        mirrored.extend(MirroredSolve::of(t.scene, t.zones)?);
    }
    if mirrored.is_empty() {
        return solve_without_mirrors(triples, settings);
    }
    mirrors::check_settings(settings)?;
    let initial = settings.initial_groups.iter().map(|g| mirrored[0].images.extended_group(g));
    let initial_groups: Vec<LightGroup> = initial.collect();
    let settings = &SolveSettings { initial_groups: &initial_groups, ..*settings };
    let transports: Vec<Transport> = mirrored.iter().map(|m| Transport::new(&m.extension.scene)).collect();
    let extended: Vec<TripleInput> = mirrored
        .iter()
        .zip(&transports)
        .map(|(m, transport)| TripleInput {
            scene: &m.extension.scene,
            zones: &m.zones,
            transport,
            mirrored: Some(m),
        })
        .collect();
    let solved =
        solve_without_mirrors(&extended, settings).map_err(|e| mirrors::explain(triples[0].scene, e))?;
    let of_part = |((s, m), t): ((ZonalSolution, &MirroredSolve), &TripleInput)| {
        let fields = m.fields_of_part(s.fields);
        let groups = m.groups_of_part(s.groups);
        let report = m.report_of_part(s.report, t.scene, t.zones, &fields);
        let emitters = s.emitters / m.images.image_count() as f64;
        ZonalSolution { fields, groups, report, emitters, ..s }
    };
    Ok(solved.into_iter().zip(&mirrored).zip(triples).map(of_part).collect())
}

/// The phases of the zonal equations for all triples of the bands. Triples that temperatures couple are solved together; others one after the other,
/// which takes the memory of one.
fn solve_without_mirrors(
    triples: &[TripleInput],
    settings: &SolveSettings,
) -> Result<Vec<ZonalSolution>, SceneError> {
    if triples.len() == 1 || triples[0].scene.couples_bands() {
        return solve_together(triples, settings);
    }
    let mut out = Vec::new();
    for (t, triple) in triples.iter().enumerate() {
        let checkpoints = TripleCheckpoints { store: settings.checkpoints, triple: t };
        let settings = SolveSettings { checkpoints: &checkpoints, ..*settings };
        out.extend(solve_together(std::slice::from_ref(triple), &settings)?);
    }
    Ok(out)
}

/// What precedes the engine of one triple of bands.
struct Preparation {
    choice: EngineChoice,
    engine: Engine,
    reason: String,
    thickness: f64,
    emitters: EmitterExchange,
    direct: DirectLight,
    sources: Vec<SourceGroup>,
    merged: Option<Diagnostic>,
}

/// Selects the engine, and computes direct light and surroundings.
fn prepare(
    triple: &TripleInput,
    settings: &SolveSettings,
) -> Result<(Preparation, SurroundingsExchange), SceneError> {
    let TripleInput { scene, zones, transport, mirrored } = *triple;
    check_interrupted(settings.progress)?;
    // Select the engine.
    let size = ProblemSize::new(scene, zones, transport).with_images(mirrored.map(|m| &m.images));
    let (limits, ranks) = ((settings.pair_settings, settings.memory_limit), settings.communicator.size());
    let choice = selection::select_engine(scene, zones, transport, &size, limits, ranks)?;
    let (engine, reason) = (choice.engine, choice.reason.clone());
    // Compute the direct light by shadow rays, except for emitters whose light follows from exchange areas.
    let shadow_rays = |l: usize| illuminate_triple(triple, l, settings);
    let emitters = EmitterExchange::of(scene, zones, engine, settings.pair_settings);
    let direct = DirectLight { lights: lights_by_shadow_rays(scene, &emitters, shadow_rays)? };
    // Sample the surroundings.
    let is_completed = engine == Engine::Dense && mirrored.is_none();
    let completed_later = || exact_rows::are_known_later(scene, zones, &settings.pair_settings);
    let mut exterior = match is_completed && completed_later() {
        true => surroundings::stage::pilot(scene, zones, transport, settings),
        false => measure_surroundings(scene, zones, transport, engine, settings)?,
    };
    if let Some(m) = mirrored {
        exterior = m.even_surroundings(&exterior);
    }
    // Choose the right-hand sides.
    let (sources, merged) = light_groups::select_groups(scene, zones);
    let thickness = size.thickness;
    Ok((Preparation { choice, engine, reason, thickness, emitters, direct, sources, merged }, exterior))
}

/// Solves triples of bands whose operators are in memory at the same time.
fn solve_together(
    triples: &[TripleInput],
    settings: &SolveSettings,
) -> Result<Vec<ZonalSolution>, SceneError> {
    let first = &triples[0];
    let other_memory = thermal::memory_bytes(first.scene, first.zones);
    let memory_limit = settings.memory_limit.saturating_sub(other_memory * triples.len() as u64);
    let memory_limit = memory_limit / triples.len() as u64;
    let stores = (0..triples.len()).map(|triple| TripleCheckpoints { store: settings.checkpoints, triple });
    let stores: Vec<TripleCheckpoints> = stores.collect();
    let own_settings = |t: usize| SolveSettings { memory_limit, checkpoints: &stores[t], ..*settings };
    // Prepare each triple, and build its engine.
    let mut prepared = Vec::new();
    let mut exterior = Vec::new();
    for (t, triple) in triples.iter().enumerate() {
        let (preparation, outside) = prepare(triple, &own_settings(t))?;
        prepared.push(preparation);
        exterior.push(outside);
    }
    let contexts: Vec<SolveContext> =
        (0..triples.len()).map(|t| context_of(&triples[t], &prepared[t], own_settings(t))).collect();
    let mut built = Vec::new();
    for ((context, preparation), outside) in contexts.iter().zip(&prepared).zip(&mut exterior) {
        built.push(build::build(preparation.choice.clone(), context, outside)?);
        check_interrupted(settings.progress)?;
    }
    let completed = complete_direct_light(triples, &contexts, &built, &exterior, &prepared)?;
    let contexts: Vec<SolveContext> = contexts
        .into_iter()
        .zip(&completed)
        .map(|(context, completed)| SolveContext {
            direct: completed.as_ref().unwrap_or(context.direct),
            ..context
        })
        .collect();
    // Solve the linear systems, or iterate on temperatures if they couple the bands.
    let (columns, coupled) = solve_columns(&contexts, &mut built, &exterior, &prepared, settings)?;
    let contexts: Vec<SolveContext> = contexts
        .into_iter()
        .enumerate()
        .map(|(t, context)| SolveContext {
            zones: coupled.as_ref().map_or(context.zones, |z| &z[t]),
            ..context
        })
        .collect();
    finish(&contexts, built, &exterior, &prepared, columns)
}

/// The direct light of each triple, completed by the exchange areas of its engine; `None` where shadow rays give all of it.
fn complete_direct_light(
    triples: &[TripleInput],
    contexts: &[SolveContext],
    built: &[BuiltEngine],
    exterior: &[SurroundingsExchange],
    prepared: &[Preparation],
) -> Result<Vec<Option<DirectLight>>, SceneError> {
    let complete = |t: usize| {
        let context = &contexts[t];
        let settings = SolveSettings {
            checkpoints: context.checkpoints,
            pair_settings: context.pair_settings,
            communicator: context.communicator,
            ..SolveSettings::new(context.memory_limit, context.progress)
        };
        let shadow_rays = |l: usize| illuminate_triple(&triples[t], l, &settings);
        emitter_exchange::complete(context, &built[t], &exterior[t], &prepared[t].emitters, shadow_rays)
    };
    (0..triples.len()).map(complete).collect()
}

/// The context of a triple before its direct light is complete.
fn context_of<'a>(
    triple: &TripleInput<'a>,
    preparation: &'a Preparation,
    settings: SolveSettings<'a>,
) -> SolveContext<'a> {
    SolveContext {
        scene: triple.scene,
        zones: triple.zones,
        transport: triple.transport,
        images: triple.mirrored.map(|m| &m.images),
        direct: &preparation.direct,
        sources: &preparation.sources,
        pair_settings: settings.pair_settings,
        memory_limit: settings.memory_limit,
        checkpoints: settings.checkpoints,
        progress: settings.progress,
        communicator: settings.communicator,
        final_gather: settings.final_gather,
    }
}

/// Computes fields with errors, balances the energy and writes the reports of all triples.
fn finish(
    contexts: &[SolveContext],
    mut built: Vec<BuiltEngine>,
    exterior: &[SurroundingsExchange],
    prepared: &[Preparation],
    columns: Vec<SolvedColumns>,
) -> Result<Vec<ZonalSolution>, SceneError> {
    let progress = contexts[0].progress;
    let mut assembled = Vec::new();
    // The errors of a final gather contain those of the powers that zones send out.
    let contain_sources = columns.iter().all(|c| c.incident.is_some());
    for (t, columns) in columns.into_iter().enumerate() {
        let SolvedColumns { mut results, incident, spare } = columns;
        let (fields, groups) = solution_fields::assemble(
            &contexts[t],
            &mut built[t],
            &exterior[t],
            (&mut results, incident, spare),
            prepared[t].engine,
        );
        assembled.push((fields, groups, results));
        check_interrupted(progress)?;
    }
    if let Some(kind) = TemperatureSolve::to_propagate(contexts[0].scene, contain_sources) {
        let engines = triple_engines(contexts, &built, exterior);
        let mut fields: Vec<&mut Fields> = assembled.iter_mut().map(|a| &mut a.0).collect();
        thermal::propagate_errors(&engines, &mut fields, kind);
        check_interrupted(progress)?;
    }
    let mut out = Vec::new();
    for (t, ((mut fields, groups, results), preparation)) in assembled.into_iter().zip(prepared).enumerate() {
        let mut report = balanced_report::balance_and_report(
            &contexts[t],
            &built[t],
            &exterior[t],
            (&mut fields, &groups),
            &results,
            preparation.thickness,
        );
        describe_engine(&mut report, preparation, contexts[t].scene);
        let has_slopes = built[t].operator.len() > contexts[t].zones.len();
        let emitters = contexts[t].direct.emitted_power();
        out.push(ZonalSolution { zones: Zones::default(), fields, groups, report, emitters, has_slopes });
    }
    Ok(out)
}

/// Adds to a report the engine, merged light groups and a missed tolerance.
fn describe_engine(report: &mut Report, preparation: &Preparation, scene: &Scene) {
    let engine = preparation.engine;
    (report.engine, report.reason) = (engine.name().into(), preparation.reason.clone());
    report.warnings.extend(preparation.merged.clone());
    let tolerance = scene.options().tolerance;
    let samples =
        preparation.choice.has_patches_outside() || !matches!(engine, Engine::Spectral | Engine::Layered);
    let missed = diagnostics::missed_tolerance(engine, tolerance, &report.estimate, &report.warnings);
    let missed = missed.filter(|_| samples);
    report.warnings.extend(missed);
}

fn triple_engines<'a>(
    contexts: &'a [SolveContext<'a>],
    built: &'a [BuiltEngine<'a>],
    exterior: &'a [SurroundingsExchange],
) -> Vec<TripleEngine<'a>> {
    let all = contexts.iter().zip(built).zip(exterior);
    all.map(|((context, built), surroundings)| TripleEngine { context, built, surroundings }).collect()
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
pub(crate) fn measure_surroundings(
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
    contexts: &[SolveContext],
    built: &mut [BuiltEngine],
    exterior: &[SurroundingsExchange],
    prepared: &[Preparation],
    settings: &SolveSettings,
) -> Result<(Vec<SolvedColumns>, Option<Vec<Zones>>), SceneError> {
    let triples: Vec<TripleZones> =
        contexts.iter().map(|c| TripleZones { scene: c.scene, zones: c.zones }).collect();
    thermal::check_temperature_level(&triples, exterior)?;
    if contexts[0].scene.couples_bands() {
        let coupled = thermal::newton::solve(&triple_engines(contexts, built, exterior))?;
        built[0].counts.push(("products with all bands".into(), coupled.products as u64));
        let columns = coupled.results.into_iter().map(|r| SolvedColumns {
            results: vec![r],
            incident: None,
            spare: Default::default(),
        });
        return Ok((columns.collect(), Some(coupled.zones)));
    }
    let mut columns = Vec::new();
    for (t, context) in contexts.iter().enumerate() {
        let engine = prepared[t].engine;
        let initial = settings.initial_groups;
        columns.push(group_solve::solve_groups(context, &mut built[t], &exterior[t], engine, initial));
        check_interrupted(settings.progress)?;
    }
    Ok((columns, None))
}

/// Direct light of light number `l` by shadow rays, with its mirror images.
fn illuminate_triple(
    triple: &TripleInput,
    l: usize,
    settings: &SolveSettings,
) -> Result<LightField, SceneError> {
    let light = illuminate_stage(triple.scene, triple.zones, triple.transport, l, settings)?;
    Ok(match triple.mirrored {
        Some(m) => m.even_light(l, light),
        None => light,
    })
}

/// Direct light of light number `l` by shadow rays: the stage `light-…`, or computed and saved.
pub(crate) fn illuminate_stage(
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
    let light =
        illumination::illuminate_by(scene, zones, transport, (l, normalization), settings.execution());
    if settings.checkpoints.keeps() {
        settings.checkpoints.save(&stage, &light.encode());
    }
    check_interrupted(settings.progress)?;
    Ok(light)
}
