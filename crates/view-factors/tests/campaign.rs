//! A small part of the random campaign of view factors: `coverage --view-factors` of `crates/validation` runs the whole.

#![allow(dead_code)]

#[path = "../../validation/examples/coverage/view_factors/mod.rs"]
mod view_factors;

use view_factors::{CampaignCase, FactorCampaign, Summary, check};
use zonal_reference::test_cases::run_all_cases;

/// Meshes of the whole campaign: ten turns of every kind.
const MESHES: u64 = 340;
/// The meshes of a quick test: those of the first turn whose references cost little.
const QUICK_MESHES: std::ops::Range<u64> = 8..34;
const SEED: u64 = 2026;

// Guards (numbers): radii of view factors cover the errors of random meshes.
#[test]
fn stated_radii_cover_the_errors_of_random_meshes() {
    let checks = if run_all_cases() {
        let tolerances = view_factors::TOLERANCES.to_vec();
        FactorCampaign { meshes: MESHES, seed: SEED, tolerances, only: None }.run(|_| ())
    } else {
        QUICK_MESHES.flat_map(|index| check(&CampaignCase::new(SEED, index), &[1e-3])).collect()
    };
    for c in checks.iter().filter(|c| c.ratio() > 1.0).take(40) {
        println!("{:.2} {c:?}", c.ratio());
    }
    let summary = Summary::new(&checks);
    println!("{}", summary.tables());
    assert!(summary.holds(), "{}", summary.tables());
    assert!(summary.all.factors > 500, "{:?}", summary.all);
}
