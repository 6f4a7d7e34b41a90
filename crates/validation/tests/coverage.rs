//! Small scenes of the random coverage campaign: stated errors cover the true ones. The example `coverage` runs the whole campaign.
//!
//! Guards (numbers): in random scenes stated errors cover true errors, for every engine and under invariances of the scene; the reference is random
//!     walks.

#![allow(dead_code)]

#[path = "../examples/coverage/entry_points.rs"]
mod entry_points;
#[path = "../examples/coverage/generate.rs"]
mod generate;
#[path = "../examples/coverage/invariance.rs"]
mod invariance;
#[path = "../examples/coverage/measure.rs"]
mod measure;
#[path = "../examples/coverage/model.rs"]
mod model;
#[path = "../examples/coverage/ordinary_kinds.rs"]
mod ordinary_kinds;
#[path = "../examples/coverage/rare_kinds.rs"]
mod rare_kinds;
#[path = "../examples/coverage/run.rs"]
mod run;
#[path = "../examples/coverage/stated.rs"]
mod stated;
#[path = "../examples/coverage/summary.rs"]
mod summary;

use entry_points::EntryPoints;
use model::CampaignSize;
use run::CampaignPlan;
use summary::{CampaignSummary, CoverageCounts};
use zonal_reference::test_cases::run_all_cases;

const SCENES: u64 = 15;
/// Scenes that take ten times as long as the others; they run with `ZONAL_TEST_CASES=all`.
const SLOW_SCENES: [u64; 3] = [4, 6, 8];
const SEED: u64 = 2026;
const WALKS: usize = 4000;

#[test]
fn stated_errors_cover_true_errors_in_random_scenes() {
    let plan = CampaignPlan {
        scenes: (0..SCENES).filter(|i| run_all_cases() || !SLOW_SCENES.contains(i)).collect(),
        seed: SEED,
        walks: WALKS,
        size: CampaignSize::Small,
        keep: None,
        entry_points: EntryPoints::default(),
    };
    let done = run::run(&plan, |_| {});
    let s = CampaignSummary::new(&done);
    let missed: Vec<_> = done.iter().flat_map(|d| d.missed()).collect();
    let failures: Vec<_> = done.iter().flat_map(|d| &d.failures).collect();
    let broken: Vec<_> =
        done.iter().filter_map(|d| d.invariance.as_ref()).flat_map(|i| &i.1.broken).collect();
    assert!(failures.is_empty(), "{failures:#?}");
    assert!(broken.is_empty(), "{broken:#?}");
    assert_eq!(s.all.far[0], 0, "beyond ten times the stated error without a warning: {missed:#?}");
    assert!(CoverageCounts::percent(s.all.names_covered, s.all.names) >= 99.0, "{missed:#?}");
    assert!(CoverageCounts::percent(s.all.zones_covered, s.all.zones) >= 97.0, "{missed:#?}");
}
