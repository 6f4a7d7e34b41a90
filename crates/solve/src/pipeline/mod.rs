//! The phases of a solve, in the order in which they run.
//!
//! Bands are solved in blocks of three. A scene is cut into zones once; every other phase runs for each block. Temperatures couple the blocks in one iteration.
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
//! | [`symmetry_planes`] | scenes with symmetry planes on their even extensions |
//! | [`zone_division`] | division of the voxel zones among processes |
//! | `expected_method` | engines and basis of a small scene before it is solved |
//! | `emitter_exchange` | direct light of emitters from exchange areas |
//! | `group_solve`, `solution_fields`, `error_amplification` | the solution of all light groups, its fields, and the reflection of errors |

pub(crate) mod direct_solution;
pub(crate) mod emitter_exchange;
pub(crate) mod error_amplification;
mod expected_method;
pub(crate) mod group_solve;
pub(crate) mod solution_fields;
pub mod symmetry_planes;
pub mod zone_division;

use self::emitter_exchange::EmitterExchange;
use self::group_solve::SolvedColumns;
use self::symmetry_planes::SymmetricSolve;
use crate::context::zonal_solution::ZonalSolution;
use crate::context::{BlockEngine, SolveContext};
use crate::engines::problem_size::ProblemSize;
use crate::engines::rays::stored_rays::ray_sampling::rays_measure_escape;
use crate::engines::rays::zoning_probe;
use crate::engines::selection::EngineChoice;
use crate::engines::{build, selection};
use crate::errors::discretization::{self, DividedScene, InterruptionOnly, SecondSolve, SolveMethod};
use crate::errors::estimate::error_estimate;
use crate::errors::finite;
use crate::report::balanced_report;
use crate::report::{back_faces, diagnostics};
use crate::right_hand_side::direct_light::illumination;
use crate::right_hand_side::direct_light::light_field::{DirectLight, LightField};
use crate::right_hand_side::light_groups::{self, SourceGroup};
use crate::right_hand_side::surroundings::{self, SurroundingsExchange, exact_rows};
use crate::settings::named_stages::{NamedStages, SolvePart};
use crate::settings::{SolveSettings, check_interrupted};
use crate::thermal::{self, TemperatureSolve};
use zonal_exchange::pair::StripImages;
use zonal_math::parallel;
use zonal_scene::{
    Bands, Diagnostic, Engine, ErrorParts, Fields, LightGroup, Progress, Report, Scene, SceneError, Solution,
    Zones, in_stage,
};
use zonal_transport::{Transport, zones_of_bands};

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

/// Cuts a scene into zones once for all bands, and solves its blocks of bands: those that temperatures couple together, others one after the other, which
/// takes the memory of one.
fn solve_scene(scene: Scene, settings: &SolveSettings) -> Result<Solution, SceneError> {
    let (transport, zones) = zone_division::cut(&scene, settings)?;
    if scene.thermal().is_some() || scene.bands().block_count() == 1 {
        let solved = solve_blocks(&scene, transport, zones, settings)?;
        return Ok(Solution::of_blocks(scene, solved));
    }
    let mut solved = Vec::new();
    for (b, block) in scene.blocks().enumerate() {
        let checkpoints = NamedStages { store: settings.checkpoints, part: SolvePart::Block(b) };
        let (transport, zones) = zone_division::of_block(&block, &transport, &zones);
        solved.extend(solve_blocks(&block, transport, zones, &settings.of_block(b, &checkpoints))?);
    }
    light_groups::unify_groups(&mut solved)?;
    Ok(Solution::of_blocks(scene, solved))
}

/// Solves the blocks of bands of a scene together, with their errors. `transport` and `zones` belong to the first.
fn solve_blocks(
    scene: &Scene,
    transport: Transport,
    zones: Zones,
    settings: &SolveSettings,
) -> Result<Vec<Solution>, SceneError> {
    let excluded = symmetry_planes::excluded_parts_of(scene, &transport, &zones)?;
    let zones = zone_division::divide(scene, &transport, zones, settings)?;
    // Solve for the fields, and estimate the discretization error by the same solve on other zones, or that of thick cells without one.
    let mut solved;
    if discretization::is_requested(scene) {
        let second;
        (solved, second) = solve_twice(scene, transport, zones, settings)?;
        discretization::estimate(scene, &mut solved, second);
        // Return an interruption of the second solve as such, not as an unknown error.
        check_interrupted(settings.progress)?;
    } else {
        solved = solve_on_zones(scene, transport, zones, settings)?;
        let basis = discretization::basis_of(solved[0].has_slopes);
        discretization::state_thick_scattering(basis, &mut solved, settings.communicator);
    }
    solved[0].report.warnings.splice(0..0, excluded);
    Ok(solved.into_iter().map(ZonalSolution::into_solution).collect())
}

/// The blocks of bands on the zones of a scene, and the solve on other zones or the reason why there is none.
type TwoSolves = (Vec<ZonalSolution>, Result<SecondSolve, String>);

/// Solves on the zones of a scene and, by the same method, on other zones: in small scenes at the same time by the method that is expected, else, or if
/// the first solve has taken another one, afterwards.
fn solve_twice(
    scene: &Scene,
    transport: Transport,
    zones: Zones,
    settings: &SolveSettings,
) -> Result<TwoSolves, SceneError> {
    let solve_other = |scene: &Scene, transport: Transport, zones: Zones, settings: &SolveSettings| {
        let solved = solve_on_zones(scene, transport, zones, settings)?;
        Ok(solved.into_iter().map(|s| s.report).collect())
    };
    let second = |zones: &Zones, method: &SolveMethod, progress: &dyn Progress| {
        let settings = SolveSettings { progress, ..*settings };
        discretization::second_solve(DividedScene { scene, zones }, method, &settings, &solve_other)
    };
    let Some(expected) = expected_method::expected_method(scene, &transport, &zones, settings) else {
        let solved = solve_on_zones(scene, transport, zones, settings)?;
        let second = second(&solved[0].zones, &SolveMethod::of(&solved), settings.progress);
        return Ok((solved, second));
    };
    let own = zones.clone();
    let (solved, beside) = parallel::join(
        || solve_on_zones(scene, transport, zones, settings),
        || second(&own, &expected, &InterruptionOnly(settings.progress)),
    );
    let solved = solved?;
    let method = SolveMethod::of(&solved);
    let second =
        if method == expected { beside } else { second(&solved[0].zones, &method, settings.progress) };
    Ok((solved, second))
}

/// Applies the boundary conditions to zones, solves the zonal equations, recovers temperatures and checks the result, for every block of bands.
fn solve_on_zones(
    scene: &Scene,
    transport: Transport,
    zones: Zones,
    settings: &SolveSettings,
) -> Result<Vec<ZonalSolution>, SceneError> {
    let blocks: Vec<Scene> = scene.blocks().collect();
    let mut transports = vec![transport];
    let mut zones = vec![zones];
    for block in &blocks[1..] {
        transports.push(transports[0].with_bands(block));
        zones.push(zones_of_bands(block, &zones[0]));
    }
    thermal::emissivity::solve(&blocks, zones, settings, |zones, settings| {
        solve_with_reflectances(&blocks, &transports, zones, settings)
    })
}

/// The solution on zones that have the reflectances of their temperatures.
fn solve_with_reflectances(
    scenes: &[Scene],
    transports: &[Transport],
    mut zones: Vec<Zones>,
    settings: &SolveSettings,
) -> Result<Vec<ZonalSolution>, SceneError> {
    let progress = settings.progress;
    in_stage(progress, "boundary conditions", || thermal::apply_boundary_conditions(scenes, &mut zones));
    let block = |((scene, zones), transport)| BandBlock { scene, zones, transport, mirrored: None };
    let blocks: Vec<BandBlock> = scenes.iter().zip(&zones).zip(transports).map(block).collect();
    let mut solved = solve_equations(&blocks, settings)?;
    solved.iter_mut().zip(zones).for_each(|(s, zones)| s.zones = zones);
    in_stage(progress, "checks", || complete_and_check(scenes, transports, &mut solved, settings))?;
    Ok(solved)
}

/// Recovers temperatures, adds notes, and checks the fields of all blocks.
fn complete_and_check(
    scenes: &[Scene],
    transports: &[Transport],
    solved: &mut [ZonalSolution],
    settings: &SolveSettings,
) -> Result<(), SceneError> {
    let explained = thermal::recover_temperatures(solved);
    // Errors of rows that do not close are no explanation where closure can be restored.
    let explained = if scenes[0].restores_closure() { explained } else { 0.0 };
    let backs =
        back_faces::lost_on_backs(&solved[0].zones, &transports[0], &solved[0].fields, &solved[0].report);
    solved[0].report.warnings.extend(backs);
    for s in solved {
        s.report
            .warnings
            .extend(diagnostics::heat_balance(&s.scene, &s.zones, &s.fields, &s.report, explained));
        let checked = finite::check_finite(&s.scene, &s.zones, &mut s.fields, &mut s.groups, &mut s.report);
        finite::agree(checked, &s.zones, settings.communicator)?;
        s.zones.own_reflectances = Vec::new();
    }
    Ok(())
}

/// Solves the zonal equations on given zones of a scene of one block of bands, with boundary conditions applied by
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
        solve_equations(&[BandBlock { scene, zones, transport, mirrored: None }], settings)
    });
    let ZonalSolution { fields, groups, report, .. } = solved?.swap_remove(0);
    Ok((fields, groups, report))
}

/// Scene, zones and transport of one block of bands.
#[derive(Clone, Copy)]
pub(crate) struct BandBlock<'a> {
    pub scene: &'a Scene,
    pub zones: &'a Zones,
    pub transport: &'a Transport<'a>,
    /// Set where scene and zones are those of an even extension.
    pub mirrored: Option<&'a SymmetricSolve>,
}

/// Solves the zonal equations of all blocks of bands; those of a scene with symmetry planes on its even extension.
fn solve_equations(blocks: &[BandBlock], settings: &SolveSettings) -> Result<Vec<ZonalSolution>, SceneError> {
    let mut mirrored = Vec::new();
    for b in blocks {
        mirrored.extend(SymmetricSolve::of(b.scene, b.zones)?);
    }
    let Some(first) = mirrored.first() else { return solve_without_symmetry_planes(blocks, settings) };
    symmetry_planes::check_settings(settings)?;
    let initial = settings.initial_groups.iter().map(|g| first.images.extended_group(g));
    let initial_groups: Vec<LightGroup> = initial.collect();
    let settings = &SolveSettings { initial_groups: &initial_groups, ..*settings };
    let transport = Transport::new(&first.extension.scene);
    let transports: Vec<Transport> =
        mirrored.iter().map(|m| transport.with_bands(&m.extension.scene)).collect();
    let extended: Vec<BandBlock> =
        mirrored.iter().zip(&transports).map(|(m, transport)| BandBlock::extended(m, transport)).collect();
    let solved = solve_without_symmetry_planes(&extended, settings)
        .map_err(|e| symmetry_planes::explain(blocks[0].scene, e))?;
    Ok(solved
        .into_iter()
        .zip(&mirrored)
        .zip(blocks)
        .map(|((s, m), b)| m.part_of(s, b.scene, b.zones))
        .collect())
}

/// The phases of the zonal equations for all blocks of bands. Blocks that temperatures couple are solved together; others one after the other,
/// which takes the memory of one.
fn solve_without_symmetry_planes(
    blocks: &[BandBlock],
    settings: &SolveSettings,
) -> Result<Vec<ZonalSolution>, SceneError> {
    if blocks.len() == 1 || blocks[0].scene.couples_bands() {
        return solve_together(blocks, settings);
    }
    let mut out = Vec::new();
    for (b, block) in blocks.iter().enumerate() {
        let checkpoints = NamedStages { store: settings.checkpoints, part: SolvePart::Block(b) };
        let settings = SolveSettings { checkpoints: &checkpoints, ..*settings };
        out.extend(solve_together(std::slice::from_ref(block), &settings)?);
    }
    Ok(out)
}

/// Choice of the engine, direct light and right-hand sides of one block of bands.
struct Prepared {
    choice: EngineChoice,
    thickness: f64,
    emitters: EmitterExchange,
    direct: DirectLight,
    sources: Vec<SourceGroup>,
    merged: Option<Diagnostic>,
}

impl<'a> BandBlock<'a> {
    /// The even extension of a block with symmetry planes, in which `transport` traces rays.
    pub(crate) fn extended(m: &'a SymmetricSolve, transport: &'a Transport<'a>) -> BandBlock<'a> {
        BandBlock { scene: &m.extension.scene, zones: &m.zones, transport, mirrored: Some(m) }
    }

    /// Selects the engine, and computes direct light and surroundings.
    fn prepare(&self, settings: &SolveSettings) -> Result<(Prepared, SurroundingsExchange), SceneError> {
        let BandBlock { scene, zones, transport, mirrored } = *self;
        check_interrupted(settings.progress)?;
        // Select the engine.
        let size = ProblemSize::new(scene, zones, transport).with_images(mirrored.map(|m| &m.images));
        let SolveSettings { pair_settings, memory_limit, .. } = *settings;
        let ranks = settings.communicator.size();
        let choice =
            selection::select_engine(scene, zones, transport, &size, pair_settings, memory_limit, ranks)?;
        // Compute the direct light by shadow rays, except for emitters whose light follows from exchange areas.
        let emitters = EmitterExchange::of(scene, zones, choice.engine, settings.pair_settings);
        let light = |l: usize| match emitters.surface(l) {
            Some(_) => Ok(LightField::default()),
            None => self.light(l, settings),
        };
        let lights = (0..scene.lights().len()).map(light).collect::<Result<_, _>>()?;
        // Sample the surroundings.
        let is_completed = choice.engine == Engine::Dense && mirrored.is_none();
        let completed_later = || exact_rows::are_known_later(scene, zones, &settings.pair_settings);
        let mut exterior = if is_completed && completed_later() {
            surroundings::stage::pilot(zones, transport, settings)
        } else {
            self.measure_surroundings(choice.engine, settings)?
        };
        if let Some(m) = mirrored {
            exterior = m.even_surroundings(&exterior);
        }
        // Choose the right-hand sides.
        let (sources, merged) = light_groups::select_groups(scene, zones);
        let thickness = size.thickness;
        let direct = DirectLight { lights };
        Ok((Prepared { choice, thickness, emitters, direct, sources, merged }, exterior))
    }

    /// Direct light of light number `l` by shadow rays, with its mirror images.
    fn light(&self, l: usize, settings: &SolveSettings) -> Result<LightField, SceneError> {
        let light = self.illuminate(l, settings)?;
        Ok(match self.mirrored {
            Some(m) => m.even_light(l, light),
            None => light,
        })
    }

    /// The exchange with the surroundings by rays; zeros if the engine determines it.
    pub(crate) fn measure_surroundings(
        &self,
        engine: Engine,
        settings: &SolveSettings,
    ) -> Result<SurroundingsExchange, SceneError> {
        let BandBlock { scene, zones, transport, .. } = *self;
        let exterior = if let Some(strips) = StripImages::of(scene, zones) {
            SurroundingsExchange::of_strips(&strips, zones)
        } else if selection::knows_escaping_power(engine, scene) {
            SurroundingsExchange::default()
        } else if engine == Engine::Rays && rays_measure_escape(scene, zones) {
            SurroundingsExchange::unmeasured(zones)
        } else {
            surroundings::stage::measure(zones, transport, settings)
        };
        check_interrupted(settings.progress)?;
        Ok(exterior)
    }

    /// Direct light of light number `l` by shadow rays: the stage `light-…`, or computed and saved.
    pub(crate) fn illuminate(&self, l: usize, settings: &SolveSettings) -> Result<LightField, SceneError> {
        let BandBlock { scene, zones, transport, .. } = *self;
        let stage = format!("light-{l}");
        if let Some(light) =
            settings.checkpoints.load(&stage).and_then(|b| LightField::decode(&b, zones.len()))
        {
            return Ok(light);
        }
        let normalization = illumination::PowerNormalization::of(scene);
        let light = illumination::illuminate_by(zones, transport, l, normalization, settings.execution());
        if settings.checkpoints.keeps() {
            settings.checkpoints.save(&stage, &light.encode());
        }
        check_interrupted(settings.progress)?;
        Ok(light)
    }
}

/// Solves blocks of bands whose operators are in memory at the same time.
fn solve_together(blocks: &[BandBlock], settings: &SolveSettings) -> Result<Vec<ZonalSolution>, SceneError> {
    let first = &blocks[0];
    let count = blocks.len() as u64;
    let other_memory = thermal::memory_bytes(first.scene, first.zones);
    let memory_limit = settings.memory_limit.saturating_sub(other_memory * count) / count;
    let store = |b| NamedStages { store: settings.checkpoints, part: SolvePart::Block(b) };
    let stores: Vec<NamedStages> = (0..blocks.len()).map(store).collect();
    let own_settings = |checkpoints| SolveSettings { memory_limit, checkpoints, ..*settings };
    let progress = settings.progress;
    // Prepare each block, and build its engine.
    let (mut prepared, mut exterior) = (Vec::new(), Vec::new());
    for (block, store) in blocks.iter().zip(&stores) {
        let prepare = || block.prepare(&own_settings(store));
        let (own, outside) = in_stage(progress, "preparation", prepare)?;
        prepared.push(own);
        exterior.push(outside);
    }
    // Direct light and zones that replace others in the contexts live longer than the engines.
    let (completed, coupled);
    let mut engines = Vec::new();
    for (((block, store), own), mut surroundings) in blocks.iter().zip(&stores).zip(&prepared).zip(exterior) {
        let context = SolveContext {
            scene: block.scene,
            zones: block.zones,
            transport: block.transport,
            images: block.mirrored.map(|m| &m.images),
            direct: &own.direct,
            sources: &own.sources,
            settings: own_settings(store),
        };
        let build = || build::build(own.choice.clone(), &context, &mut surroundings);
        let built = in_stage(progress, "engine", build)?;
        engines.push(BlockEngine { context, built, surroundings });
        check_interrupted(settings.progress)?;
    }
    // Complete the direct light by the exchange areas of the engines.
    let complete = || complete_direct_light(blocks, &prepared, &engines);
    completed = in_stage(progress, "direct light of emitters", complete)?;
    for (engine, direct) in engines.iter_mut().zip(&completed) {
        engine.context.direct = direct.as_ref().unwrap_or(engine.context.direct);
    }
    // Solve the linear systems, or iterate on temperatures if they couple the bands.
    let columns;
    (columns, coupled) = in_stage(progress, "linear systems", || solve_columns(&mut engines, &prepared))?;
    for (engine, zones) in engines.iter_mut().zip(&coupled) {
        engine.context.zones = zones;
    }
    in_stage(progress, "fields and errors", || finish(engines, &prepared, columns))
}

/// The direct light of each block, completed by the exchange areas of its engine; `None` where shadow rays give all of it.
fn complete_direct_light(
    blocks: &[BandBlock],
    prepared: &[Prepared],
    engines: &[BlockEngine],
) -> Result<Vec<Option<DirectLight>>, SceneError> {
    let complete = |((block, own), engine): ((&BandBlock, &Prepared), &BlockEngine)| {
        let BlockEngine { context, built, surroundings } = engine;
        let shadow_rays = |l: usize| block.light(l, &context.settings);
        emitter_exchange::complete(context, built, surroundings, &own.emitters, shadow_rays)
    };
    blocks.iter().zip(prepared).zip(engines).map(complete).collect()
}

/// Computes fields with errors, balances the energy and writes the reports of all blocks.
fn finish(
    mut engines: Vec<BlockEngine>,
    prepared: &[Prepared],
    columns: Vec<SolvedColumns>,
) -> Result<Vec<ZonalSolution>, SceneError> {
    let (scene, progress) = (engines[0].context.scene, engines[0].context.settings.progress);
    // The errors of a final gather contain those of the powers that zones send out.
    let contain_sources = columns.iter().all(|c| c.incident.is_some());
    let (mut fields, mut others) = (Vec::new(), Vec::new());
    for ((engine, prepared), mut columns) in engines.iter_mut().zip(prepared).zip(columns) {
        let (mut own, mut groups) = solution_fields::assemble(engine, &mut columns, prepared.choice.engine);
        add_zoning_error(engine, prepared.choice.engine, &mut own, &mut groups);
        fields.push(own);
        others.push((groups, columns.results));
        check_interrupted(progress)?;
    }
    let purpose = engines[0].context.settings.purpose;
    if let Some(kind) = TemperatureSolve::to_propagate(scene, contain_sources, purpose) {
        thermal::propagate_errors(&engines, &mut fields, kind);
        check_interrupted(progress)?;
    }
    let mut out = Vec::new();
    for (((engine, prepared), mut fields), (groups, results)) in
        engines.iter().zip(prepared).zip(fields).zip(others)
    {
        let mut report = in_stage(progress, "balance", || {
            balanced_report::balance_and_report(engine, &mut fields, &groups, &results, prepared.thickness)
        });
        report.estimate.parts = engine.built.error_parts;
        describe_engine(&mut report, prepared, engine.context.scene);
        out.push(ZonalSolution {
            scene: engine.context.scene.clone(),
            zones: Zones::default(),
            fields,
            groups,
            report,
            emitters: engine.context.direct.emitted_power(),
            has_slopes: engine.built.operator.len() > engine.context.zones.len(),
        });
    }
    Ok(out)
}

/// Adds the error of zones that send and receive as wholes to the errors of the fields, where a probe measures it.
fn add_zoning_error(block: &mut BlockEngine, engine: Engine, fields: &mut Fields, groups: &mut [LightGroup]) {
    let BlockEngine { context, built, surroundings } = block;
    let Some(zoning) = zoning_probe::measure(context, surroundings, engine, fields) else { return };
    let before = error_estimate(context.shared_zones(), fields, built.operator.grade());
    let parts = |kind: usize, sampling: Bands| ErrorParts {
        sampling: sampling.max_element(),
        zoning: zoning[kind].max_element(),
        ..ErrorParts::default()
    };
    built.error_parts = Some([parts(0, before.patches), parts(1, before.volumes)]);
    solution_fields::widen_by_zoning(zoning, fields, groups, context.zones.patches.len());
}

/// Adds to a report the engine, merged light groups and a missed tolerance.
fn describe_engine(report: &mut Report, prepared: &Prepared, scene: &Scene) {
    let engine = prepared.choice.engine;
    (report.engine, report.reason) = (engine.name().into(), prepared.choice.reason.clone());
    report.warnings.extend(prepared.merged.clone());
    let tolerance = scene.options().tolerance;
    let missed =
        diagnostics::missed_tolerance(&prepared.choice, tolerance, &report.estimate, &report.warnings);
    report.warnings.extend(missed);
}

/// Solves the linear system of all groups, or iterates on temperatures if they couple the bands; then the zones of each block with the emission of the
/// temperatures found follow, else none.
fn solve_columns(
    engines: &mut [BlockEngine],
    prepared: &[Prepared],
) -> Result<(Vec<SolvedColumns>, Vec<Zones>), SceneError> {
    thermal::check_temperature_level(engines)?;
    if engines[0].context.scene.couples_bands() {
        let coupled = thermal::newton::solve(engines)?;
        engines[0].built.counts.push(("products with all bands".into(), coupled.products as u64));
        let columns = coupled.results.into_iter().map(|r| SolvedColumns {
            results: vec![r],
            incident: None,
            products: Vec::new(),
        });
        return Ok((columns.collect(), coupled.zones));
    }
    let mut columns = Vec::new();
    for (engine, prepared) in engines.iter_mut().zip(prepared) {
        columns.push(group_solve::solve_groups(engine, prepared.choice.engine));
        check_interrupted(engine.context.settings.progress)?;
    }
    Ok((columns, Vec::new()))
}
