//! The content of a page during a solve: the newest data, and the progress of the next.
//!
//! The page asks for `progress.json` and loads `scene.bin` again whenever the version there is higher than that of its data:
//!
//! ```text
//!     { "live": true, "version": 1, "stage": "gather", "fraction": 0.4, "quality": "normal", "done": false, "error": null }
//! ```
//!
//! Version 0 means that there are no data yet. A solve that fails leaves the data of the last one in place.

use super::server::RouteBody;
use crate::stage_names::StageNames;
use serde_json::json;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use zonal_scene::Progress;

/// The changing content of a page. Its observer methods are those of the solve in progress.
#[derive(Default)]
pub struct LivePage {
    state: Mutex<LiveState>,
    /// Steps of the stage that are complete, and all of them.
    steps: [AtomicU64; 2],
    /// True if the solve in progress is to end.
    interrupted: AtomicBool,
    /// Observes the solves too.
    observer: Option<Box<dyn Progress + Send>>,
}

#[derive(Default)]
struct LiveState {
    package: Arc<[u8]>,
    version: u64,
    stage: String,
    /// Names of the stages of the solve so far.
    stages: StageNames,
    quality: String,
    is_done: bool,
    error: Option<String>,
}

impl LivePage {
    fn state(&self) -> MutexGuard<'_, LiveState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A page whose solves `observer` observes too.
    #[must_use]
    pub fn with_observer(observer: impl Progress + Send + 'static) -> LivePage {
        LivePage { observer: Some(Box::new(observer)), ..LivePage::default() }
    }

    /// A solve of this quality begins.
    pub fn begin_solve(&self, quality: &str) {
        let mut state = self.state();
        (state.quality, state.is_done, state.error) = (quality.into(), false, None);
        state.stages = StageNames::default();
        self.interrupted.store(false, Ordering::SeqCst);
    }

    /// New data; returns their version.
    pub fn publish(&self, package: Vec<u8>) -> u64 {
        let mut state = self.state();
        state.package = package.into();
        state.version += 1;
        state.version
    }

    /// Nothing is left to do; an error says why the newest input is not shown.
    pub fn finish(&self, error: Option<String>) {
        let mut state = self.state();
        (state.is_done, state.error, state.stage) = (true, error, String::new());
    }

    /// Ends the solve in progress.
    pub fn interrupt(&self) {
        self.interrupted.store(true, Ordering::SeqCst);
    }

    /// The content of `scene.bin`.
    #[must_use]
    pub fn package_body(self: &Arc<Self>) -> RouteBody {
        let page = self.clone();
        RouteBody::Changing(Arc::new(move || page.state().package.clone()))
    }

    /// The content of `progress.json`.
    #[must_use]
    pub fn progress_body(self: &Arc<Self>) -> RouteBody {
        let page = self.clone();
        RouteBody::Changing(Arc::new(move || page.progress().into_bytes().into()))
    }

    fn progress(&self) -> String {
        let [done, total] = [0, 1].map(|k| self.steps[k].load(Ordering::Relaxed) as f64);
        let fraction = if total > 0.0 { (done / total).min(1.0) } else { 0.0 };
        let s = self.state();
        json!({
            "live": true, "version": s.version, "stage": s.stage, "fraction": fraction, "quality": s.quality,
            "done": s.is_done, "error": s.error,
        })
        .to_string()
    }
}

/// The content of `progress.json` of a page whose data do not change.
#[must_use]
pub fn finished_progress() -> Vec<u8> {
    json!({ "live": false, "version": 1, "done": true }).to_string().into_bytes()
}

impl Progress for LivePage {
    fn begin(&self, stage: &str, total: u64) {
        let mut state = self.state();
        state.stage = state.stages.next(stage);
        let stage = format!("{}: {stage}", state.quality);
        drop(state);
        if let Some(observer) = &self.observer {
            observer.begin(&stage, total);
        }
        self.steps[0].store(0, Ordering::Relaxed);
        self.steps[1].store(total, Ordering::Relaxed);
    }
    fn advance(&self, steps: u64) {
        self.steps[0].fetch_add(steps, Ordering::Relaxed);
        if let Some(observer) = &self.observer {
            observer.advance(steps);
        }
    }
    fn end(&self) {
        self.steps[0].store(self.steps[1].load(Ordering::Relaxed), Ordering::Relaxed);
        if let Some(observer) = &self.observer {
            observer.end();
        }
    }
    fn is_interrupted(&self) -> bool {
        self.interrupted.load(Ordering::SeqCst)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_rise_and_failures_keep_the_data() {
        let page = Arc::new(LivePage::default());
        let progress = || serde_json::from_str::<serde_json::Value>(&page.progress()).unwrap();
        page.begin_solve("draft");
        page.begin("gather", 8);
        page.advance(2);
        let p = progress();
        assert_eq!(
            (p["version"].as_u64(), p["stage"].as_str(), p["fraction"].as_f64()),
            (Some(0), Some("gather"), Some(0.25))
        );
        assert_eq!(page.publish(vec![1, 2, 3]), 1);
        page.begin_solve("normal");
        page.interrupt();
        assert!(page.is_interrupted());
        // A stage that is repeated has a new name: its fraction does not fall.
        page.begin("gather", 4);
        assert_eq!(progress()["stage"], "gather");
        page.begin("gather", 4);
        assert_eq!(progress()["stage"], "gather (2)");
        page.finish(Some("the scene is not valid".into()));
        let p = progress();
        assert_eq!((p["version"].as_u64(), p["done"].as_bool()), (Some(1), Some(true)));
        assert_eq!(p["error"], "the scene is not valid");
        let RouteBody::Changing(body) = page.package_body() else { panic!("the data change") };
        assert_eq!(&*body(), [1, 2, 3]);
        page.begin_solve("draft");
        assert!(!page.is_interrupted() && progress()["error"].is_null());
    }
}
