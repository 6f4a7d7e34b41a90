//! The solves behind a live page: a draft first, then the quality wanted, and again after every change of the files.

use super::context::{check_uniform_light, option_failure, with_shown_bands};
use super::init::ModelArgs;
use super::quality::Quality;
use super::solving::solve_and_hash;
use crate::scene_proposal::propose;
use crate::viewer::live::LivePage;
use crate::viewer::package::{PackageDetail, package};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, SystemTime};
use zonal_report::{Failure, note, say};
use zonal_scene::Scene;
use zonal_solve::SolveSettings;

/// Time between two looks at the files.
const FILE_CHECK_INTERVAL: Duration = Duration::from_millis(300);
/// Vertices of the first data over those of the last.
const FIRST_VERTEX_SHARE: f64 = 0.3;

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

    /// Solves with each quality up to the wanted one.
    fn solve_stages(&self, scene: &Scene, page: &LivePage) -> Result<(), Failure> {
        let draft = (Quality::Draft, FIRST_VERTEX_SHARE);
        let last = (self.quality, 1.0);
        let stages =
            if self.quality == Quality::Draft { vec![(Quality::Draft, 1.0)] } else { vec![draft, last] };
        for (quality, vertex_share) in stages {
            page.begin_solve(quality.name());
            let options = quality.of_solve(scene);
            let staged = scene.clone().with_options(options).map_err(|e| option_failure(&e))?;
            let solution = solve_and_hash(staged, &SolveSettings::new(self.memory_limit, page))?;
            let solution = with_shown_bands(solution, self.first_band)?;
            check_uniform_light(&self.path, &solution)?;
            let max_vertices = (vertex_share * self.detail.max_vertices as f64) as usize;
            let bytes = package(&solution, &PackageDetail { max_vertices }, page)?;
            let (size, zones) = (bytes.len(), solution.zones.len());
            let version = page.publish(bytes);
            if self.json {
                let line = serde_json::json!({ "version": version, "quality": quality.name(), "zones": zones, "bytes": size });
                say(&line.to_string())?;
            } else {
                say(&format!("{}: {zones} zones, {:.1} MB", quality.name(), size as f64 / 1e6))?;
            }
        }
        Ok(())
    }
}
