//! A model solved by every applicable engine, its quantities compared with forward Monte Carlo.

use super::model::{ModelShape, SceneModel};
use super::quantities::{names, warned, zone_problem, zones};
use super::result::{Quantity, SceneResult};
use std::path::Path;
use zonal_io::input;
use zonal_reference::forward_monte_carlo::{ClosedSurfaces, ForwardProblem, ForwardSolution, trace_forward};
use zonal_scene::{NoProgress, Scene, Severity, Solution};

/// The largest memory of a solve, bytes.
pub(super) const MAX_MEMORY: u64 = 2 << 30;
/// Factor of the number of walks in the second run of a scene with an uncovered sum or a zone that is far off.
const EXTRA_WALKS_FACTOR: u64 = 10;
/// Phrases of errors by which an engine declines a scene.
const REFUSALS: [&str; 4] = ["does not apply", "images", "periodic", "is for the spectral engine"];

/// An engine with its zone basis.
#[derive(Clone, Copy, Debug)]
pub(super) struct EngineVariant {
    /// Name in tables.
    pub name: &'static str,
    engine: &'static str,
    basis: &'static str,
}

/// Engines with their zone basis.
pub(super) const VARIANTS: [EngineVariant; 4] = [
    EngineVariant { name: "dense", engine: "dense", basis: "constant" },
    EngineVariant { name: "rays", engine: "rays", basis: "constant" },
    EngineVariant { name: "spectral", engine: "spectral", basis: "constant" },
    EngineVariant { name: "spectral, slopes", engine: "spectral", basis: "linear" },
];

/// Reads a model, its meshes written into `folder`.
fn read(model: &SceneModel, lines: &str, folder: &Path) -> Result<Scene, String> {
    let text = model.write_meshes(lines, folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    input::parse_scene(&text, Some(folder), "scene.toml").map_err(|e| e.to_string())
}

/// The scene that the reference traces, where it is not the scene of the solution: without flaws, or of the model `truth`.
fn reference_scene(model: &SceneModel, folder: &Path) -> Result<Option<Scene>, String> {
    if model.flaws.is_empty() && model.truth.is_none() {
        return Ok(None);
    }
    let mut clean = model.truth.as_deref().unwrap_or(model).clone();
    clean.flaws.clear();
    let folder = folder.join("reference");
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    read(&clean, "", &folder).map(Some)
}

/// Reads and solves a model; `Ok(None)` where the engine does not apply.
pub(super) fn solved(
    model: &SceneModel,
    variant: &EngineVariant,
    folder: &Path,
) -> Result<Option<Solution>, String> {
    let lines = format!("engine = \"{}\"\nzone_basis = \"{}\"", variant.engine, variant.basis);
    match zonal_solve::solve(read(model, &lines, folder)?, MAX_MEMORY, &NoProgress) {
        Ok(s) => Ok(Some(s)),
        Err(e) => {
            let said = e.to_string();
            if REFUSALS.iter().any(|k| said.contains(k)) { Ok(None) } else { Err(said) }
        }
    }
}

/// Which surfaces of a scene are closed parts.
fn closed(model: &SceneModel, scene: &Scene) -> ClosedSurfaces {
    let meshes = || model.surfaces.iter().filter(|s| matches!(s.shape, ModelShape::Mesh { .. }));
    let whole = |name: &str| meshes().any(|s| name.starts_with(&s.name));
    ClosedSurfaces {
        surfaces: scene.surfaces().iter().map(|s| whole(&s.name)).collect(),
        room: model.closed_room,
    }
}

/// A Monte Carlo result, run where it is needed, and once more and longer where a solution differs from it.
#[derive(Default)]
struct Truth(Option<(ForwardSolution, bool)>);

impl Truth {
    /// Quantities by `compare` beside the walks of `walk`, which takes the factor of their number.
    fn compared(
        &mut self,
        walk: impl Fn(u64) -> ForwardSolution,
        compare: impl Fn(&ForwardSolution) -> Vec<Quantity>,
        differs: fn(&Quantity) -> bool,
    ) -> Vec<Quantity> {
        let (walked, again) = self.0.get_or_insert_with(|| (walk(1), false));
        let list = compare(walked);
        if *again || !list.iter().any(differs) {
            return list;
        }
        (*walked, *again) = (walk(EXTRA_WALKS_FACTOR), true);
        compare(walked)
    }
}

/// The Monte Carlo results of a scene.
#[derive(Default)]
struct Truths {
    named: Truth,
    /// On the zones of the first engine.
    by_zone: Truth,
    /// The same with rays that go on from patches close by.
    by_ray: Truth,
}

/// Quantities of a solution by name, and by zone without slopes. `traced` is another scene for the reference.
fn compare_with_reference(
    model: &SceneModel,
    s: &Solution,
    variant: &EngineVariant,
    [seed, walks]: [u64; 2],
    traced: Option<&Scene>,
    truths: &mut Truths,
) -> Vec<Quantity> {
    let scene = traced.unwrap_or(&s.scene);
    let enclosing = closed(model.truth.as_deref().unwrap_or(model), scene);
    // A longer run has other random numbers.
    let seed_of = |factor: u64| if factor > 1 { 2 * seed + factor } else { 2 * seed };
    let by_name = |factor: u64| {
        let walks = (factor * walks) as usize;
        trace_forward(scene, &enclosing, ForwardProblem::Continuous, walks, seed_of(factor))
    };
    let mut list =
        truths.named.compared(by_name, |walked| names(s, walked), |q| !q.is_unknown() && !q.is_covered());
    // Walks are not reflected by symmetry planes, and the zones of another model are others.
    if variant.basis == "constant" && !s.scene.has_symmetry_planes() {
        let (problem, enclosing) = (zone_problem(s), closed(model, &s.scene));
        let truth = match problem {
            ForwardProblem::ContinuedRays(_) => &mut truths.by_ray,
            _ => &mut truths.by_zone,
        };
        let walk = |factor: u64| {
            let walks = (factor * walks) as usize;
            trace_forward(&s.scene, &enclosing, problem, walks, seed_of(factor) + 1)
        };
        // Walks use the zones of the first engine.
        let same = |walked: &ForwardSolution| walked.zones.len() == s.zones.len();
        let on_zones = |walked: &ForwardSolution| if same(walked) { zones(s, walked) } else { Vec::new() };
        list.extend(truth.compared(walk, on_zones, Quantity::is_far));
    }
    list
}

/// Solves a model by every applicable engine, or by the first one from number `first` on, and compares; `random` has the seed and the number of walks.
pub(super) fn measure(
    model: &SceneModel,
    out: &mut SceneResult,
    random: [u64; 2],
    first: Option<usize>,
    folder: &Path,
) -> Vec<(EngineVariant, Solution)> {
    let mut solutions = Vec::new();
    let traced = match reference_scene(model, folder) {
        Ok(scene) => scene,
        Err(e) => {
            out.failures.push(format!("the scene of the reference: {e}"));
            return solutions;
        }
    };
    let mut truths = Truths::default();
    for k in 0..VARIANTS.len() {
        if first.is_some() && !solutions.is_empty() {
            break;
        }
        let variant = VARIANTS[(k + first.unwrap_or(0)) % VARIANTS.len()];
        let s = match solved(model, &variant, folder) {
            Ok(Some(s)) => s,
            Ok(None) => continue,
            Err(e) => {
                out.failures.push(format!("{}: {e}", variant.name));
                continue;
            }
        };
        out.engines.push(variant.name);
        let warnings = || s.report.warnings.iter().filter(|w| w.severity == Severity::Warning);
        match model.expected_warning {
            Some(words) if warnings().any(|w| w.text.contains(words)) => {}
            Some(words) => {
                out.failures.push(format!("{}: no warning says that the scene is {words}", variant.name));
            }
            None => {
                let list = compare_with_reference(model, &s, &variant, random, traced.as_ref(), &mut truths);
                let (warned, proved) = (warned(&s.report), s.report.grade == zonal_math::Grade::Proved);
                let own = |q| Quantity { engine: variant.name, warned, proved, ..q };
                out.quantities.extend(list.into_iter().map(own));
                solutions.push((variant, s));
            }
        }
    }
    solutions
}
