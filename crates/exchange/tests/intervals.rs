//! Intervals never lie: two thousand stratified pairs against the oracle, four thousand by the additivity law.
//! The long run is the example `intervals`.

#[path = "support/intervals.rs"]
mod intervals;

use intervals::{Tally, Verdict, additive, case, judge};
use rayon::prelude::*;

const SEED: u64 = 20_260;

fn run(pairs: u64, ask: impl Fn(u64) -> Vec<Verdict> + Sync) -> Tally {
    let verdicts: Vec<Verdict> = (0..pairs).into_par_iter().flat_map_iter(&ask).collect();
    let mut tally = Tally::default();
    for v in &verdicts {
        tally.add(v);
        let told = || format!("{v:?} {:?}", case(SEED, v.index));
        assert!(!v.miss, "an interval lies: {}", told());
        assert!(!v.wide || v.deep, "a radius above the tolerance: {}", told());
        assert!(!v.quarrel, "two oracles disagree: {}", told());
    }
    tally
}

#[test]
fn two_thousand_pairs_hold_the_oracle_s_value() {
    let t = run(2_000, |i| judge(SEED, i));
    assert!(t.pairs >= 2_200 && t.seen >= 1_900, "{t:?}");
    // Cases with a tolerance finer than the oracle's error prove little; there are few.
    assert!(t.blunt * 20 <= t.seen, "{t:?}");
}

#[test]
fn four_thousand_pairs_are_the_sums_of_their_parts() {
    let t = run(4_000, |i| additive(SEED, i));
    assert!(t.seen >= 3_200, "{t:?}");
}
