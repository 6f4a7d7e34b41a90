//! Where the time of a computation goes: wall time and processor time of its stages.
//!
//! A stage of [`Progress`] is a phase. A stage inside another is a phase of its own, and the time of the outer one is what is left; time outside all stages
//! belongs to the phase [`BETWEEN_STAGES`]. A phase that repeats adds up. The phases therefore add up to the whole:
//!
//! ```text
//! Σ wall time of the phases = time since the beginning
//! threads at work           = processor time / wall time
//! ```
//!
//! Threads at work of about 1 show a serial phase. Processor time is that of the whole process: computations that run at the same time share it.

use cpu_time::ProcessTime;
use serde_json::{Value, json};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};
use zonal_scene::Progress;

/// The phase of time outside all stages.
pub const BETWEEN_STAGES: &str = "other";
/// The stage in which input is read.
pub const READING: &str = "reading";
/// The stage in which output is written.
pub const WRITING: &str = "writing";
/// The stage in which the identity of a scene is computed.
pub(crate) const HASH: &str = "hash of the scene";

/// Times of a phase.
#[derive(Clone, Debug, PartialEq)]
pub struct Phase {
    /// Name of the stage.
    pub name: String,
    /// How often the stage began.
    pub count: u64,
    /// Wall time.
    pub wall: Duration,
    /// Processor time of all threads; `None` where the system does not tell.
    pub processor: Option<Duration>,
}

impl Phase {
    fn new(name: &str, count: u64) -> Phase {
        Phase { name: name.into(), count, wall: Duration::ZERO, processor: Some(Duration::ZERO) }
    }
    /// Processor time, s.
    #[must_use]
    pub fn processor_seconds(&self) -> Option<f64> {
        self.processor.map(|t| t.as_secs_f64())
    }
    /// Processor time over wall time: the mean number of threads at work. `None` if it is unknown.
    #[must_use]
    pub fn threads_at_work(&self) -> Option<f64> {
        self.processor_seconds().map(|t| t / self.wall.as_secs_f64()).filter(|t| t.is_finite())
    }
    fn json(&self) -> Value {
        let (wall, processor) = (self.wall.as_secs_f64(), self.processor_seconds());
        json!({ "name": self.name, "count": self.count, "wall_s": wall, "processor_s": processor,
            "threads": self.threads_at_work() })
    }
}

/// The phases of a computation so far.
pub struct Timeline {
    record: Mutex<Record>,
}

struct Record {
    phases: Vec<Phase>,
    /// Indices of the stages that have begun and not ended, the innermost last.
    open: Vec<usize>,
    /// When the last phase began or went on.
    since: Moment,
}

#[derive(Clone, Copy)]
struct Moment {
    wall: Instant,
    processor: Option<ProcessTime>,
}

impl Moment {
    fn now() -> Moment {
        Moment { wall: Instant::now(), processor: ProcessTime::try_now().ok() }
    }
}

impl Record {
    /// Adds the time since the last change to the phase that is open.
    fn settle(&mut self) {
        let now = Moment::now();
        let phase = &mut self.phases[*self.open.last().unwrap_or(&0)];
        phase.wall += now.wall - self.since.wall;
        let processor = now.processor.zip(self.since.processor).map(|(to, from)| to.duration_since(from));
        phase.processor = phase.processor.zip(processor).map(|(sum, more)| sum + more);
        self.since = now;
    }
}

impl Default for Timeline {
    /// A timeline that begins now.
    fn default() -> Timeline {
        let phases = vec![Phase::new(BETWEEN_STAGES, 1)];
        Timeline { record: Mutex::new(Record { phases, open: Vec::new(), since: Moment::now() }) }
    }
}

impl Timeline {
    fn with_record<T>(&self, f: impl FnOnce(&mut Record) -> T) -> T {
        f(&mut self.record.lock().unwrap_or_else(PoisonError::into_inner))
    }
    /// The stage `name` begins.
    pub fn begin(&self, name: &str) {
        self.with_record(|r| {
            r.settle();
            let known = r.phases.iter().position(|p| p.name == name);
            let phase = known.unwrap_or(r.phases.len());
            if known.is_none() {
                r.phases.push(Phase::new(name, 0));
            }
            r.phases[phase].count += 1;
            r.open.push(phase);
        });
    }
    /// The innermost stage ends.
    pub fn end(&self) {
        self.with_record(|r| {
            r.settle();
            r.open.pop();
        });
    }
    /// The phases until now, in the order in which they began first; [`BETWEEN_STAGES`] is the last.
    #[must_use]
    pub fn phases(&self) -> Vec<Phase> {
        self.with_record(|r| {
            r.settle();
            let mut phases = r.phases.clone();
            phases.rotate_left(1);
            phases
        })
    }
    /// The total as JSON, and the phases as its list `phases`: `name`, `count`, `wall_s`, `processor_s` and `threads` (null if unknown).
    #[must_use]
    pub fn json(&self) -> Value {
        let phases = self.phases();
        let mut out = total(&phases).json();
        out["phases"] = phases.iter().map(Phase::json).collect();
        out
    }
}

/// The sum of phases.
#[must_use]
pub fn total(phases: &[Phase]) -> Phase {
    let (wall, processor) = (phases.iter().map(|p| p.wall).sum(), phases.iter().map(|p| p.processor).sum());
    Phase { wall, processor, ..Phase::new("total", 1) }
}

/// An observer that keeps the timeline of what it observes.
pub struct Timed<'a, P> {
    /// The observer that receives all reports.
    pub observer: P,
    /// The timeline, if one is kept.
    pub timeline: Option<&'a Timeline>,
}

impl<P: Progress> Progress for Timed<'_, P> {
    fn begin(&self, stage: &str, total: u64) {
        self.observer.begin(stage, total);
        if let Some(timeline) = self.timeline {
            timeline.begin(stage);
        }
    }
    fn advance(&self, steps: u64) {
        self.observer.advance(steps);
    }
    fn end(&self) {
        if let Some(timeline) = self.timeline {
            timeline.end();
        }
        self.observer.end();
    }
    fn is_interrupted(&self) -> bool {
        self.observer.is_interrupted()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_scene::NoProgress;

    #[test]
    fn phases_of_nested_and_repeated_stages_add_up() {
        let begin = Instant::now();
        let timeline = Timeline::default();
        let observer = Timed { observer: NoProgress, timeline: Some(&timeline) };
        for _ in 0..2 {
            observer.begin("outer", 1);
            std::thread::sleep(Duration::from_millis(2));
            observer.begin("inner", 1);
            std::thread::sleep(Duration::from_millis(20));
            observer.end();
            observer.end();
        }
        // An end without a beginning changes nothing.
        observer.end();
        let phases = timeline.phases();
        let names: Vec<(&str, u64)> = phases.iter().map(|p| (p.name.as_str(), p.count)).collect();
        assert_eq!(names, [("outer", 2), ("inner", 2), (BETWEEN_STAGES, 1)]);
        assert!(phases[0].wall >= Duration::from_millis(4) && phases[1].wall >= Duration::from_millis(40));
        let sum: Duration = phases.iter().map(|p| p.wall).sum();
        assert!(sum <= begin.elapsed() && sum >= Duration::from_millis(44), "{sum:?}");
        // Sleeping takes no processor time, work does.
        let work = |t: &Timeline| t.json()["processor_s"].as_f64().unwrap();
        let before = work(&timeline);
        let mut x = 1.0_f64;
        while work(&timeline) < before + 0.01 {
            x = (x + 1.0).sqrt();
        }
        assert!(x > 1.0);
        assert_eq!(timeline.json()["phases"][1]["name"], "inner");
    }
}
