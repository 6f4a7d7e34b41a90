//! The solves behind a live page: sunlight as soon as there are zones or direct light, then a draft, then the quality wanted, and again after every change of the files.

use super::viewer::live::LivePage;
use super::viewer::notes::ShownStage;
use super::viewer::package::{PackageDetail, encode_textures, package_in_steps};
use crate::quality::Quality;
use crate::scene_proposal::{ModelOptions, propose_recorded};
use crate::shown_solution::{check_uniform_light, with_shown_bands};
use crate::solving::{solve_and_hash, with_hash};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use zonal_io::input::{FileRecord, FilesRead};
use zonal_render::bake::has_separate_suns;
use zonal_report::Failure;
use zonal_scene::{CheckpointStore, ErrorEstimate, NoProgress, Progress, Scene, Solution, Zones};
use zonal_solve::{SolveSettings, solve_direct_light, solve_without_light};

/// Time between two looks at the files.
const FILE_CHECK_INTERVAL: Duration = Duration::from_millis(300);
/// Vertices of the first data of a solution over those of the last.
const FIRST_VERTEX_SHARE: f64 = 0.1;
/// Zones of the draft above which sunlight is sent in place of direct light, and the draft is sent before the last solve begins.
const MIN_ZONES_OF_SUNLIGHT: usize = 20_000;
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

/// What the solutions of one state of the files hand on to those after them.
#[derive(Default)]
struct Published {
    /// Error estimates of the solutions published, the first one first.
    estimates: Vec<ErrorEstimate>,
    /// Textures of the scene as PNG; empty before the first solution is published.
    textures: Vec<Vec<u8>>,
}

/// Input and settings of a live page.
pub struct LiveInput<'a> {
    /// Scene or mesh file.
    pub path: PathBuf,
    /// Unit, upward axis and number of patches of a mesh file.
    pub model: ModelOptions,
    /// The last quality.
    pub quality: Quality,
    /// Memory limit, bytes.
    pub memory_limit: u64,
    /// Resolution of the last data.
    pub detail: PackageDetail,
    /// First of the bands shown.
    pub first_band: usize,
    /// Is called with all data that the page gets. An error ends the solves.
    pub report: &'a (dyn Fn(&PublishedData) -> Result<(), Failure> + Sync),
    /// Is called with the errors of solves that the page shows.
    pub note: &'a (dyn Fn(&str) + Sync),
}

/// Data that the page gets.
#[derive(Clone, Copy, Debug)]
pub struct PublishedData {
    /// Their version, from 1.
    pub version: u64,
    /// Name of the stage: sunlight, direct light, or a quality.
    pub stage: &'static str,
    /// Number of zones.
    pub zones: usize,
    /// Size of the data.
    pub bytes: usize,
    /// Whether the same solution with a coarser mesh came before.
    pub refined: bool,
}

impl LiveInput<'_> {
    /// True for a file that is solved before it is shown.
    #[must_use]
    pub fn is_solved_first(path: &Path) -> bool {
        path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("npz"))
    }

    /// The scene of the input, and the files that it was read from, each as it was before the reading.
    pub fn read(&self) -> (Result<Scene, Failure>, FilesRead) {
        let record = FileRecord::default();
        let scene = if self.path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) {
            record.read_scene(&self.path).map_err(Failure::from)
        } else {
            propose_recorded(&self.path, Path::new(""), &self.model, &record).map(|p| p.scene)
        };
        (scene, record.into_files())
    }

    /// Solves `scene`, read from `files`, with rising quality and publishes each result, then waits for changes of the files, until `stop`.
    pub fn keep_solving(&self, scene: Scene, mut files: FilesRead, page: &LivePage, stop: &AtomicBool) {
        let mut scene = Ok(scene);
        loop {
            let ended = AtomicBool::new(false);
            let outcome = std::thread::scope(|scope| {
                scope.spawn(|| interrupt_on_change(page, stop, &ended, &files));
                let outcome = scene.and_then(|scene| self.solve_stages(&scene, page));
                ended.store(true, Ordering::SeqCst);
                outcome
            });
            if stop.load(Ordering::SeqCst) {
                return;
            }
            // An interrupted solve makes way for the changed files.
            if !files.have_changed() {
                let error = outcome.err().map(|e| e.to_string());
                if let Some(e) = &error {
                    (self.note)(e);
                }
                page.finish(error);
                while !files.have_changed() {
                    if stop.load(Ordering::SeqCst) {
                        return;
                    }
                    std::thread::sleep(FILE_CHECK_INTERVAL);
                }
            }
            page.begin_solve(Quality::Draft.name());
            (scene, files) = self.read();
        }
    }

    /// Solves for sunlight or direct light, then with each quality up to the wanted one, and publishes each result.
    fn solve_stages(&self, scene: &Scene, page: &LivePage) -> Result<(), Failure> {
        let is_draft_last = self.quality == Quality::Draft;
        let of_quality = |quality: Quality| scene.clone().with_options(quality.of_solve(scene));
        let draft = of_quality(Quality::Draft)?;
        // Direct light and draft have the same zones and the same shadow rays.
        let (stages, mut published, mut zones) = (DirectLightStages::default(), Published::default(), None);
        let settings = SolveSettings { checkpoints: &stages, ..SolveSettings::new(self.memory_limit, page) };
        if scene.thermal().is_none() {
            zones = Some(self.solve_first_light(&draft, page, &settings, &mut published)?);
        }
        // A draft that another solution follows shows its stored rays without a gather.
        page.begin_solve(Quality::Draft.name());
        let settings = SolveSettings { final_gather: is_draft_last, zones: zones.as_ref(), ..settings };
        let draft = solve_and_hash(draft, &settings)?;
        if is_draft_last {
            return self.publish(page, draft, ShownStage::Last(self.quality.name()), &mut published, page);
        }
        drop((stages, zones));
        let solve_last = || {
            page.begin_solve(self.quality.name());
            let settings = SolveSettings::new(self.memory_limit, page);
            of_quality(self.quality).and_then(|scene| solve_and_hash(scene, &settings))
        };
        let solution = if draft.zones.len() > MIN_ZONES_OF_SUNLIGHT {
            self.publish(page, draft, ShownStage::Draft, &mut published, page)?;
            solve_last()?
        } else {
            // The bake of a small draft leaves cores idle: the last solve begins beside it. The bake has threads of its own, as those of the solve would keep it waiting.
            let own_threads = rayon::ThreadPoolBuilder::new().num_threads(rayon::current_num_threads());
            let own_threads =
                own_threads.build().map_err(|e| Failure::new(format!("no more threads ({e})")))?;
            let (outcome, solution) = std::thread::scope(|scope| {
                let publish = || self.publish(page, draft, ShownStage::Draft, &mut published, &NoProgress);
                let publishing = scope.spawn(|| own_threads.install(publish));
                let solution = solve_last();
                (publishing.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)), solution)
            });
            outcome?;
            solution?
        };
        self.publish(page, solution, ShownStage::Last(self.quality.name()), &mut published, page)
    }

    /// Publishes sunlight where the page draws it and the zones of the draft are many, otherwise direct light; returns the zones.
    fn solve_first_light(
        &self,
        draft: &Scene,
        page: &LivePage,
        settings: &SolveSettings,
        published: &mut Published,
    ) -> Result<Zones, Failure> {
        page.begin_solve(ShownStage::DirectLight.name());
        let mut zones = None;
        // Suns that the page draws need no shadow rays. The draft that follows brings all other direct light.
        if has_separate_suns(draft) && draft.voxel_grid().is_none() {
            let solution = with_hash(solve_without_light(draft.clone(), settings)?, settings.progress);
            if solution.zones.len() > MIN_ZONES_OF_SUNLIGHT {
                let zones = solution.zones.clone();
                self.publish(page, solution, ShownStage::Sunlight, published, page)?;
                return Ok(zones);
            }
            zones = Some(solution.zones);
        }
        let settings = SolveSettings { zones: zones.as_ref(), ..*settings };
        let solution = with_hash(solve_direct_light(draft.clone(), &settings)?, settings.progress);
        let zones = solution.zones.clone();
        self.publish(page, solution, ShownStage::DirectLight, published, page)?;
        Ok(zones)
    }

    /// Publishes a solution, and reports it; `published` has the error estimates of those before and the textures, and gets its own estimate.
    fn publish(
        &self,
        page: &LivePage,
        solution: Solution,
        stage: ShownStage,
        published: &mut Published,
        progress: &dyn Progress,
    ) -> Result<(), Failure> {
        let solution = with_shown_bands(solution, self.first_band)?;
        check_uniform_light(&self.path, &solution)?;
        let all = self.detail.max_vertices;
        let few = (FIRST_VERTEX_SHARE * all as f64) as usize;
        let max_vertices = if stage.is_last() { all } else { few };
        let detail = PackageDetail { max_vertices, stage, earlier: published.estimates.clone() };
        if published.textures.is_empty() {
            published.textures = encode_textures(&solution)?;
        }
        let mut refined = false;
        // The last solution is sent before its mesh is refined, too.
        package_in_steps(&solution, &detail, &published.textures, &[few], progress, |bytes| {
            let (size, zones) = (bytes.len(), solution.zones.len());
            let version = page.publish(bytes);
            (self.report)(&PublishedData { version, stage: stage.name(), zones, bytes: size, refined })?;
            refined = true;
            Ok(())
        })?;
        // Sunlight states no error.
        if stage != ShownStage::Sunlight {
            published.estimates.push(solution.report.estimate.clone());
        }
        Ok(())
    }
}

/// Interrupts the solve when a file changes or the program is to stop.
fn interrupt_on_change(page: &LivePage, stop: &AtomicBool, ended: &AtomicBool, files: &FilesRead) {
    while !ended.load(Ordering::SeqCst) {
        if stop.load(Ordering::SeqCst) || files.have_changed() {
            page.interrupt();
        }
        std::thread::sleep(FILE_CHECK_INTERVAL);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use zonal_scene::{Medium, Mesh, Sun};

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
        // Rows in closed form have no rays to the surroundings.
        let kept = ["light-0", "surroundings"];
        let names = names();
        assert!(names.contains("light-0"), "{names:?}");
        assert!(
            names.iter().all(|n| kept.contains(&n.as_str())),
            "no stage of an engine takes memory: {names:?}"
        );
        let alone = solve_and_hash(scene, &SolveSettings::new(1 << 30, &NoProgress)).unwrap();
        assert_eq!(draft.fields, alone.fields);
        assert_eq!(first.fields.direct, draft.fields.direct);
    }
}
