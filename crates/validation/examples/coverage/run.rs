//! Scenes of a seed, measured in parallel; each result is a function of seed and index alone.

use super::entry_points::EntryPoints;
use super::generate;
use super::invariance::{self, InvarianceOutcome, SolvedVariant};
use super::measure::{Quantity, SceneMeasurement, VARIANT_NAMES, VARIANTS, measure};
use super::model::{CampaignSize, SceneModel};
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// The scenes of a campaign.
#[derive(Clone, Debug)]
pub(crate) struct CampaignPlan {
    /// Scenes.
    pub scenes: Vec<u64>,
    pub seed: u64,
    /// Walks for each band of a scene.
    pub walks: usize,
    pub size: CampaignSize,
    /// Where scenes that fail are written.
    pub keep: Option<PathBuf>,
    /// Programs that some of the scenes go through.
    pub entry_points: EntryPoints,
}

/// A scene and what was found.
pub(crate) struct SceneResult {
    pub index: u64,
    pub features: Vec<&'static str>,
    pub engines: Vec<&'static str>,
    pub quantities: Vec<Quantity>,
    pub invariance: Option<(&'static str, InvarianceOutcome)>,
    /// Engines that refused the scene, with their words.
    pub failures: Vec<String>,
}

impl SceneResult {
    /// Sums by name that are not covered, and zones that are not by twice their error.
    pub(crate) fn missed(&self) -> impl Iterator<Item = &Quantity> {
        self.quantities.iter().filter(|q| !q.is_unknown() && !q.is_covered())
    }
    /// True where something is wrong.
    pub(crate) fn failed(&self) -> bool {
        self.missed().next().is_some()
            || !self.failures.is_empty()
            || self.invariance.as_ref().is_some_and(|(_, o)| !o.broken.is_empty() || o.failure.is_some())
    }
}

/// Runs a plan; calls `told` with every finished scene.
pub(crate) fn run(plan: &CampaignPlan, told: impl Fn(&SceneResult) + Sync) -> Vec<SceneResult> {
    let root = std::env::temp_dir().join(format!("zonal-coverage-{}-{}", std::process::id(), plan.seed));
    let done = (plan.scenes.par_iter())
        .map(|&index| {
            let folder = root.join(index.to_string());
            let done = run_scene(plan, index, &folder);
            let _ = std::fs::remove_dir_all(&folder);
            told(&done);
            done
        })
        .collect();
    let _ = std::fs::remove_dir_all(&root);
    done
}

fn run_scene(plan: &CampaignPlan, index: u64, folder: &Path) -> SceneResult {
    let (model, mut rng) = generate::model(plan.seed, index, plan.size);
    let mut done = SceneResult {
        index,
        features: model.features.clone(),
        engines: Vec::new(),
        quantities: Vec::new(),
        invariance: None,
        failures: Vec::new(),
    };
    if let Err(e) = std::fs::create_dir_all(folder) {
        done.failures.push(format!("{}: {e}", folder.display()));
        return done;
    }
    let seed = plan.seed.wrapping_mul(1_000_003).wrapping_add(index);
    let first = (plan.size == CampaignSize::Small).then(|| (rng.uniform() * VARIANTS.len() as f64) as usize);
    let SceneMeasurement { quantities, engines, failures, solutions } =
        measure(&model, index, seed, plan.walks, first, folder);
    (done.quantities, done.engines, done.failures) = (quantities, engines, failures);
    if !solutions.is_empty() {
        let (k, own) =
            &solutions[((rng.uniform() * solutions.len() as f64) as usize).min(solutions.len() - 1)];
        let (engine, basis) = VARIANTS[*k];
        let variant = (VARIANT_NAMES[*k], engine, basis);
        let own = SolvedVariant { scene: index, variant, solution: own };
        done.invariance = Some(invariance::check_invariance(&model, &own, &mut rng, folder));
    }
    let trial = plan.entry_points.try_scene(&model, index, plan.walks, folder);
    if !trial.quantities.is_empty() {
        done.engines.push("init, auto");
    }
    done.quantities.extend(trial.quantities);
    done.failures.extend(trial.failures);
    if let Some(keep) = &plan.keep
        && (done.failed() || plan.scenes.len() == 1)
        && let Err(e) = write(&model, &scene_folder(keep, plan.seed, index))
    {
        done.failures.push(format!("the scene could not be kept: {e}"));
    }
    done
}

/// The folder of a scene that is written.
fn scene_folder(parent: &Path, seed: u64, index: u64) -> PathBuf {
    parent.join(format!("{seed}-{index}"))
}

/// Writes all scenes.
pub(crate) fn write_scenes(plan: &CampaignPlan, folder: &Path) -> std::io::Result<()> {
    plan.scenes.iter().try_for_each(|index| {
        let (model, _) = generate::model(plan.seed, *index, plan.size);
        write(&model, &scene_folder(folder, plan.seed, *index))
    })
}

/// Writes a scene with its meshes.
pub(crate) fn write(model: &SceneModel, folder: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)?;
    let (text, files) = model.texts("");
    for (name, text) in files {
        std::fs::write(folder.join(name), text)?;
    }
    std::fs::write(folder.join("scene.toml"), text)
}
