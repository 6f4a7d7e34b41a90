//! A small part of the random campaign of view factors: `coverage --view-factors` of `crates/validation` runs the whole.

#![allow(dead_code)]

#[path = "../../validation/examples/coverage/view_factors/mod.rs"]
mod view_factors;

use view_factors::{FactorCampaign, Summary};
use zonal_reference::test_cases::run_all_cases;

/// Meshes: one turn of every kind.
const MESHES: u64 = 34;
const SEED: u64 = 2026;

#[test]
fn stated_radii_cover_the_errors_of_random_meshes() {
    let (meshes, tolerances) = if run_all_cases() {
        (10 * MESHES, view_factors::TOLERANCES.to_vec())
    } else {
        (MESHES, vec![1e-3, 1e-5])
    };
    let checks = FactorCampaign { meshes, seed: SEED, tolerances }.run();
    for c in checks.iter().filter(|c| c.ratio() > 1.0).take(40) {
        println!("{:.2} {c:?}", c.ratio());
    }
    let summary = Summary::new(&checks);
    println!("{}", summary.tables());
    assert!(summary.holds(), "{}", summary.tables());
    assert!(summary.all.factors > 2_000 && summary.all.proved > 50, "{:?}", summary.all);
}
