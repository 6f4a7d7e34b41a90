//! Proved intervals: stratified pairs against the oracle, and sums by the additivity law.
//! The long run is the campaign `intervals`.

#[path = "support/intervals.rs"]
mod interval_cases;

use interval_cases::{
    KINDS, METHODS, MethodVerdict, STRATA, VerdictCounts, case, check_additivity, compare_with_oracle,
};
use rayon::prelude::*;

const SEED: u64 = 20_260;

fn run(pairs: u64, ask: impl Fn(u64) -> Vec<MethodVerdict> + Sync) -> (VerdictCounts, [u64; METHODS.len()]) {
    let verdicts: Vec<MethodVerdict> = (0..pairs).into_par_iter().flat_map_iter(&ask).collect();
    let (mut tally, mut asked) = (VerdictCounts::default(), [0; METHODS.len()]);
    for v in &verdicts {
        tally.add(v);
        asked[v.method] += 1;
        let describe = || format!("{} {}: {v:?} {:?}", STRATA[v.stratum], KINDS[v.kind], case(SEED, v.index));
        assert!(!v.miss, "the oracle's value is outside the interval: {}", describe());
        assert!(!v.wide || v.deep, "a radius above the tolerance: {}", describe());
        assert!(!v.quarrel, "two oracles disagree: {}", describe());
    }
    (tally, asked)
}

// Guards (numbers): proved intervals contain the values of an independent oracle.
/// A sample of the campaign `cargo run --release -p zonal-campaigns -- intervals --state pairs.state`.
#[test]
fn intervals_contain_the_oracle_value() {
    let (t, asked) = run(300, |i| compare_with_oracle(SEED, i));
    assert!(t.seen as f64 > 0.85 * t.pairs as f64, "{t:?}");
    // Every method has its share.
    assert!(asked[0] == 300 && asked.iter().all(|&n| n >= 4), "{asked:?}");
    // Cases with a tolerance finer than the oracle's error prove little; there are few.
    assert!(t.blunt * 20 <= t.seen, "{t:?}");
}

// Guards (numbers): proved intervals are additive.
/// A sample of the campaign `cargo run --release -p zonal-campaigns -- intervals --additivity --state sums.state`.
#[test]
fn intervals_are_additive() {
    let (t, asked) = run(600, |i| check_additivity(SEED, i));
    assert!(asked[0] == 600 && t.seen as f64 > 0.85 * t.pairs as f64, "{t:?} {asked:?}");
}
