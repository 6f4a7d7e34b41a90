//! Random coverage: random valid scenes, each solved by every engine that applies and by the forward Monte Carlo reference; the program's stated
//! errors are compared with the true ones.
//!
//! Sums by name (power absorbed, net power, temperature) are compared with the continuous problem: the stated error is that of the exchange
//! and of the zones' size. Zones are compared with the exact solution of the zonal equations on the same zones: the stated error is that of the
//! exchange. **Covered** means |difference| ≤ stated + 3σ of the reference, of zones 2 stated + 3σ. Each scene is solved once more in an equivalent form
//! (mirrored, turned, scaled …), by one of the engines; both solutions must agree within the errors that they state.
//!
//! A scene of which a sum by name is not covered, or a zone is far off, is walked again, ten times as often: among thousands of sums a few are four or more standard
//! errors off by chance, while true deviations become more significant.
//!
//! With `--zonal`, one scene in five is solved by that program as well, with `--python` by the Python package too: the bytes of both must be equal. One in five
//! becomes a mesh file, if it is one of surfaces alone, and goes through `zonal init`. Each result is a function of seed and index alone.

mod entry_points;
mod generate;
mod invariance;
mod measure;
mod model;
mod ordinary_kinds;
mod page;
mod quantities;
mod rare_kinds;
mod result;
mod summary;

use crate::harness::{Outcome, ScratchFolder};
use entry_points::EntryPoints;
use measure::VARIANTS;
use rayon::prelude::*;
use result::SceneResult;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use summary::CampaignSummary;

/// Scenes between two lines of progress.
const SCENES_PER_PROGRESS: usize = 20;

#[derive(Clone, Debug, Default, clap::Args)]
pub(crate) struct CoverageOptions {
    /// Number of scenes
    #[arg(long, value_name = "N", default_value_t = 100)]
    random: u64,
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Walks for each band of a scene
    #[arg(long, default_value_t = 40_000)]
    walks: usize,
    /// Scenes alone, all of whose quantities are listed
    #[arg(long, value_delimiter = ',')]
    index: Vec<u64>,
    /// Scenes of few zones, each for one engine
    #[arg(long)]
    small: bool,
    /// Folder for the scenes on which something fails
    #[arg(long, value_name = "FOLDER")]
    keep: Option<PathBuf>,
    /// Writes all scenes into a folder and solves none, for another program
    #[arg(long, value_name = "FOLDER")]
    write: Option<PathBuf>,
    /// The page (.md), with a plot beside it
    #[arg(long)]
    page: Option<PathBuf>,
    #[command(flatten)]
    entry_points: EntryPoints,
}

impl CoverageOptions {
    pub(crate) fn run(&self) -> Outcome {
        if let Some(folder) = &self.write {
            for index in self.scenes() {
                let (model, _) = generate::model(self.seed, index, self.small);
                model.write(&self.scene_folder(folder, index))?;
            }
            return Ok(true);
        }
        let done = self.measure_scenes()?;
        if !self.index.is_empty() {
            done.iter().flat_map(|d| &d.quantities).for_each(|q| println!("{q:?}"));
        }
        let summary = CampaignSummary::new(&done);
        print!("{}", page::tables(&summary));
        if let Some(path) = &self.page {
            self.write_page(path, &done, &summary)?;
        }
        Ok(summary.verdicts().iter().all(|v| v.2))
    }

    fn scenes(&self) -> Vec<u64> {
        if self.index.is_empty() { (0..self.random).collect() } else { self.index.clone() }
    }

    /// The folder of a scene that is written.
    fn scene_folder(&self, parent: &Path, index: u64) -> PathBuf {
        parent.join(format!("{}-{index}", self.seed))
    }

    /// Measures all scenes; tells the failures of every finished one.
    fn measure_scenes(&self) -> std::io::Result<Vec<SceneResult>> {
        let (scenes, finished) = (self.scenes(), AtomicUsize::new(0));
        let scratch = ScratchFolder::new(&format!("coverage-{}", self.seed))?;
        let measure = |&index: &u64| {
            let folder = scratch.join(index.to_string());
            std::fs::create_dir_all(&folder)?;
            let done = self.measure_scene(index, &folder);
            std::fs::remove_dir_all(&folder)?;
            done.complaints().iter().for_each(|line| eprintln!("{line}"));
            let count = finished.fetch_add(1, Ordering::Relaxed) + 1;
            if count.is_multiple_of(SCENES_PER_PROGRESS) {
                eprintln!("progress: {count} of {} scenes", scenes.len());
            }
            Ok(done)
        };
        scenes.par_iter().map(measure).collect()
    }

    fn measure_scene(&self, index: u64, folder: &Path) -> SceneResult {
        let (model, mut rng) = generate::model(self.seed, index, self.small);
        let seed = self.seed.wrapping_mul(1_000_003).wrapping_add(index);
        let first = self.small.then(|| (rng.uniform() * VARIANTS.len() as f64) as usize);
        let mut done = SceneResult { index, features: model.features.clone(), ..SceneResult::default() };
        let solutions = measure::measure(&model, &mut done, [seed, self.walks as u64], first, folder);
        if !solutions.is_empty() {
            let chosen = (rng.uniform() * solutions.len() as f64) as usize;
            let (variant, own) = &solutions[chosen.min(solutions.len() - 1)];
            let outcome = invariance::check_invariance(&model, variant, own, &mut rng, folder);
            done.invariance = Some(outcome);
        }
        self.entry_points.try_scene(&model, self.walks, folder, &mut done);
        if let Some(keep) = &self.keep
            && (done.failed() || self.scenes().len() == 1)
            && let Err(e) = model.write(&self.scene_folder(keep, index))
        {
            done.failures.push(format!("the scene could not be kept: {e}"));
        }
        done
    }
}

/// Scenes that take ten times as long as the others; they run with `ZONAL_TEST_CASES=all`.
#[cfg(test)]
const SLOW_SCENES: [u64; 3] = [4, 6, 8];

// Guards (numbers): in random scenes stated errors cover true errors, for every engine and under invariances of the scene; the reference is random
//     walks.
#[test]
fn stated_errors_cover_true_errors_in_random_scenes() {
    let all = zonal_reference::test_cases::run_all_cases();
    let index = (0..15).filter(|i| all || !SLOW_SCENES.contains(i)).collect();
    let options = CoverageOptions { index, seed: 2026, walks: 4000, small: true, ..Default::default() };
    let done = options.measure_scenes().unwrap();
    let verdicts = CampaignSummary::new(&done).verdicts();
    let complaints: Vec<String> = done.iter().flat_map(SceneResult::complaints).collect();
    // Few scenes have few quantities: the shares of unknown errors and the median are those of the whole campaign.
    let kept = verdicts.iter().filter(|v| !v.0.starts_with("unknown") && !v.0.starts_with("median"));
    assert!(kept.clone().all(|v| v.2), "{verdicts:#?}\n{complaints:#?}");
}
