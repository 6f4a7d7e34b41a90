//! Intervals never lie: two thousand stratified pairs against the oracle, four thousand by the additivity law.
//! The long run is the example `intervals`.

#[path = "support/intervals.rs"]
mod intervals;

use intervals::{KINDS, METHODS, STRATA, Tally, Verdict, additive, case, judge};
use rayon::prelude::*;

const SEED: u64 = 20_260;

fn run(pairs: u64, ask: impl Fn(u64) -> Vec<Verdict> + Sync) -> (Tally, [u64; METHODS.len()]) {
    let verdicts: Vec<Verdict> = (0..pairs).into_par_iter().flat_map_iter(&ask).collect();
    let (mut tally, mut asked) = (Tally::default(), [0; METHODS.len()]);
    for v in &verdicts {
        tally.add(v);
        asked[v.method] += 1;
        let told = || format!("{} {}: {v:?} {:?}", STRATA[v.stratum], KINDS[v.kind], case(SEED, v.index));
        assert!(!v.miss, "an interval lies: {}", told());
        assert!(!v.wide || v.deep, "a radius above the tolerance: {}", told());
        assert!(!v.quarrel, "two oracles disagree: {}", told());
    }
    (tally, asked)
}

#[test]
fn two_thousand_pairs_hold_the_oracle_s_value() {
    let (t, asked) = run(2_000, |i| judge(SEED, i));
    assert!(t.seen as f64 > 0.85 * t.pairs as f64, "{t:?}");
    // Every method has its share.
    assert!(asked[0] == 2_000 && asked.iter().all(|&n| n >= 20), "{asked:?}");
    // Cases with a tolerance finer than the oracle's error prove little; there are few.
    assert!(t.blunt * 20 <= t.seen, "{t:?}");
}

#[test]
fn four_thousand_pairs_are_the_sums_of_their_parts() {
    let (t, asked) = run(4_000, |i| additive(SEED, i));
    assert!(asked[0] == 4_000 && t.seen as f64 > 0.85 * t.pairs as f64, "{t:?} {asked:?}");
}
