//! The solves behind a live page: direct light as soon as there are zones, then a draft, then the quality wanted, and again after every change of the files.

use super::context::{check_uniform_light, option_failure, with_shown_bands};
use super::init::ModelArgs;
use super::quality::Quality;
use super::solving::{solve_and_hash, with_hash};
use crate::scene_proposal::propose;
use crate::viewer::live::LivePage;
use crate::viewer::notes::ShownStage;
use crate::viewer::package::{PackageDetail, package};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, SystemTime};
use zonal_report::{Failure, note, say};
use zonal_scene::{CheckpointStore, ErrorEstimate, Scene, Solution};
use zonal_solve::{SolveSettings, solve_direct_light};

/// Time between two looks at the files.
const FILE_CHECK_INTERVAL: Duration = Duration::from_millis(300);
/// Vertices of data before the last over those of the last.
const FIRST_VERTEX_SHARE: f64 = 0.3;
/// First words of the names of the stages of a solve that the solution of direct light leaves to the draft.
const DIRECT_LIGHT_STAGES: [&str; 2] = ["light-", "surroundings"];

/// Lights and surroundings of the draft in memory: the solution of direct light computes them, and the draft after it reads them.
#[derive(Default)]
struct DirectLightStages(Mutex<HashMap<String, Vec<u8>>>);

impl CheckpointStore for DirectLightStages {
    fn load(&self, stage: &str) -> Option<Vec<u8>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get(stage).cloned()
    }
    fn save(&self, stage: &str, bytes: &[u8]) {
        if DIRECT_LIGHT_STAGES.iter().any(|s| stage.contains(s)) {
            self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(stage.into(), bytes.into());
        }
    }
    fn keeps(&self) -> bool {
        true
    }
}

/// Input and settings of a live page.
pub(super) struct LiveInput {
    /// Scene or mesh file.
    pub(super) path: PathBuf,
    /// Unit, upward axis and number of patches of a mesh file.
    pub(super) model: ModelArgs,
    /// The last quality.
    pub(super) quality: Quality,
    /// Memory limit, bytes.
    pub(super) memory_limit: u64,
    /// Resolution of the last data.
    pub(super) detail: PackageDetail,
    /// First of the bands shown.
    pub(super) first_band: usize,
    /// Reports as JSON.
    pub(super) json: bool,
}

impl LiveInput {
    /// True for a file that is solved before it is shown.
    pub(super) fn is_solved_first(path: &Path) -> bool {
        path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("npz"))
    }

    /// The scene of the input.
    pub(super) fn read(&self) -> Result<Scene, Failure> {
        match self.path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) {
            true => Ok(zonal_io::input::read_scene(&self.path)?),
            false => Ok(propose(&self.path, Path::new(""), &self.model.options())?.scene),
        }
    }

    /// Solves `scene` with rising quality and publishes each result, then waits for changes of the file, until `stop`.
    pub(super) fn keep_solving(&self, scene: Scene, page: &LivePage, stop: &AtomicBool) {
        let mut scene = Ok(scene);
        loop {
            let seen = self.modified();
            let ended = AtomicBool::new(false);
            let outcome = std::thread::scope(|scope| {
                scope.spawn(|| self.interrupt_on_change(page, stop, &ended, seen));
                let outcome = scene.and_then(|scene| self.solve_stages(&scene, page));
                ended.store(true, Ordering::SeqCst);
                outcome
            });
            if stop.load(Ordering::SeqCst) {
                return;
            }
            // An interrupted solve makes way for the changed file.
            if self.modified() == seen {
                let error = outcome.err().map(|e| e.to_string());
                if let Some(e) = &error {
                    note(e);
                }
                page.finish(error);
                while self.modified() == seen {
                    if stop.load(Ordering::SeqCst) {
                        return;
                    }
                    std::thread::sleep(FILE_CHECK_INTERVAL);
                }
            }
            page.begin_solve(Quality::Draft.name());
            scene = self.read();
        }
    }

    /// The time of the last change of the file.
    fn modified(&self) -> Option<SystemTime> {
        std::fs::metadata(&self.path).and_then(|m| m.modified()).ok()
    }

    /// Interrupts the solve when the file changes or the program is to stop.
    fn interrupt_on_change(
        &self,
        page: &LivePage,
        stop: &AtomicBool,
        ended: &AtomicBool,
        seen: Option<SystemTime>,
    ) {
        while !ended.load(Ordering::SeqCst) {
            if stop.load(Ordering::SeqCst) || self.modified() != seen {
                page.interrupt();
            }
            std::thread::sleep(FILE_CHECK_INTERVAL);
        }
    }

    /// Solves for direct light, then with each quality up to the wanted one, and publishes each result.
    fn solve_stages(&self, scene: &Scene, page: &LivePage) -> Result<(), Failure> {
        let is_draft_last = self.quality == Quality::Draft;
        let of_quality = |quality: Quality| {
            scene.clone().with_options(quality.of_solve(scene)).map_err(|e| option_failure(&e))
        };
        let draft = of_quality(Quality::Draft)?;
        // Direct light and draft have the same zones and the same shadow rays.
        let (stages, mut earlier) = (DirectLightStages::default(), Vec::new());
        let settings = SolveSettings { checkpoints: &stages, ..SolveSettings::new(self.memory_limit, page) };
        if scene.thermal().is_none() {
            page.begin_solve(ShownStage::DirectLight.name());
            let solution = with_hash(solve_direct_light(draft.clone(), &settings)?);
            self.publish(page, solution, ShownStage::DirectLight, &mut earlier)?;
        }
        page.begin_solve(Quality::Draft.name());
        let stage = if is_draft_last { ShownStage::Last(Quality::Draft.name()) } else { ShownStage::Draft };
        self.publish(page, solve_and_hash(draft, &settings)?, stage, &mut earlier)?;
        if is_draft_last {
            return Ok(());
        }
        drop(stages);
        page.begin_solve(self.quality.name());
        let settings = SolveSettings::new(self.memory_limit, page);
        let solution = solve_and_hash(of_quality(self.quality)?, &settings)?;
        self.publish(page, solution, ShownStage::Last(self.quality.name()), &mut earlier)
    }

    /// Publishes a solution, and reports it; `earlier` has the error estimates of those before, and gets its own.
    fn publish(
        &self,
        page: &LivePage,
        solution: Solution,
        stage: ShownStage,
        earlier: &mut Vec<ErrorEstimate>,
    ) -> Result<(), Failure> {
        let solution = with_shown_bands(solution, self.first_band)?;
        check_uniform_light(&self.path, &solution)?;
        let vertex_share = if stage.is_last() { 1.0 } else { FIRST_VERTEX_SHARE };
        let max_vertices = (vertex_share * self.detail.max_vertices as f64) as usize;
        let detail = PackageDetail { max_vertices, stage, earlier: earlier.clone() };
        let bytes = package(&solution, &detail, page)?;
        earlier.push(solution.report.estimate.clone());
        let (size, zones) = (bytes.len(), solution.zones.len());
        let version = page.publish(bytes);
        if self.json {
            let line = serde_json::json!({ "version": version, "quality": stage.name(), "zones": zones, "bytes": size });
            say(&line.to_string())?;
        } else {
            say(&format!("{}: {zones} zones, {:.1} MB", stage.name(), size as f64 / 1e6))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use zonal_scene::{Medium, Mesh, NoProgress, Sun};

    #[test]
    fn direct_light_leaves_its_shadow_rays_to_the_draft() {
        let scene = Scene::builder()
            .surface(
                Mesh::rectangle([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]).name("floor").reflectance(0.5),
            )
            .medium(Medium::grid([0.0; 3], [1.0; 3], [2; 3]).extinction(0.1))
            .light(Sun::new([0.3, 0.0, -1.0]).irradiance(1.0))
            .build()
            .unwrap();
        let stages = DirectLightStages::default();
        let settings = SolveSettings { checkpoints: &stages, ..SolveSettings::new(1 << 30, &NoProgress) };
        let first = solve_direct_light(scene.clone(), &settings).unwrap();
        let names = || stages.0.lock().unwrap().keys().cloned().collect::<BTreeSet<String>>();
        assert!(names().iter().eq(["light-0"]), "{:?}", names());
        let draft = solve_and_hash(scene.clone(), &settings).unwrap();
        assert!(
            names().iter().eq(["light-0", "surroundings"]),
            "no stage of an engine takes memory: {:?}",
            names()
        );
        let alone = solve_and_hash(scene, &SolveSettings::new(1 << 30, &NoProgress)).unwrap();
        assert_eq!(draft.fields, alone.fields);
        assert_eq!(first.fields.direct, draft.fields.direct);
    }
}
