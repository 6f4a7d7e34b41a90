//! Proved intervals of many random pairs against the oracle, or by the additivity law.
//!
//! ```text
//! cargo run --release -p zonal-paper --example intervals -- [--pairs N] [--seed S] [--state FILE] [--additivity] [--only INDEX]
//! ```
//!
//! Defaults: 100,000 pairs (a million with `--additivity`), seed 1, no state. With `--state` progress goes to the file every few
//! seconds (written beside it and renamed); the same command continues from it, wherever it was killed. Prints a table by stratum,
//! kind and method; ends with 1 if an interval misses the oracle, a radius is wider than the tolerance or two oracles disagree.
//! `--only` shows one case. Threads: `RAYON_NUM_THREADS`.

#[path = "../tests/support/intervals.rs"]
mod intervals;

use intervals::{
    KINDS, METHODS, MethodVerdict, STRATA, VerdictCounts, case, check_additivity, compare_with_oracle, oracle,
};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;

/// Pairs between two writings of the state.
const PAIRS_PER_CHUNK: u64 = 512;

#[derive(Clone, Debug)]
struct Args {
    pairs: Option<u64>,
    seed: u64,
    state: Option<PathBuf>,
    additivity: bool,
    only: Option<u64>,
}

type VerdictTable = BTreeMap<(usize, usize, usize), VerdictCounts>;

fn arguments() -> Args {
    let mut args = Args { pairs: None, seed: 1, state: None, additivity: false, only: None };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut next = || words.next().unwrap_or_else(|| panic!("{word} wants a value"));
        match word.as_str() {
            "--pairs" => args.pairs = Some(next().parse().expect("--pairs wants a number")),
            "--seed" => args.seed = next().parse().expect("--seed wants a number"),
            "--state" => args.state = Some(next().into()),
            "--only" => args.only = Some(next().parse().expect("--only wants an index")),
            "--additivity" => args.additivity = true,
            other => panic!("unknown argument {other}"),
        }
    }
    args
}

fn main() {
    let args = arguments();
    if let Some(index) = args.only {
        return show(args.seed, index);
    }
    let pairs = args.pairs.unwrap_or(if args.additivity { 1_000_000 } else { 100_000 });
    let head = format!("intervals 1 seed {} additivity {}", args.seed, args.additivity);
    let (mut done, mut table) = args.state.as_ref().and_then(|f| read(f, &head)).unwrap_or_default();
    while done < pairs {
        let to = (done + PAIRS_PER_CHUNK).min(pairs);
        let ask = |i: usize| {
            let index = done + i as u64;
            if args.additivity {
                check_additivity(args.seed, index)
            } else {
                compare_with_oracle(args.seed, index)
            }
        };
        let verdicts: Vec<MethodVerdict> =
            (0..(to - done) as usize).into_par_iter().with_max_len(8).flat_map_iter(ask).collect();
        for v in &verdicts {
            if v.miss || v.quarrel || v.wide && !v.deep {
                println!("{v:?} {:?}", case(args.seed, v.index));
            }
            table.entry((v.stratum, v.kind, v.method)).or_default().add(v);
        }
        done = to;
        if let Some(file) = &args.state {
            write(file, &head, done, &table);
        }
    }
    print!("{}", report(done, &table));
    if table.values().any(|t| t.misses + t.wide + t.quarrels > 0) {
        std::process::exit(1);
    }
}

fn show(seed: u64, index: u64) {
    println!("{:#?}", case(seed, index));
    println!("oracle {:?}", oracle(&case(seed, index), 0.0));
    for v in compare_with_oracle(seed, index).into_iter().chain(check_additivity(seed, index)) {
        println!("{v:?}");
    }
}

fn write(file: &PathBuf, head: &str, done: u64, table: &VerdictTable) {
    let mut text = format!("{head}\n{done}\n");
    for ((s, k, m), t) in table {
        let VerdictCounts { pairs, seen, misses, wide, deep, blunt, quarrels, worst, slowest, seconds } = t;
        let _ = writeln!(
            text,
            "{s} {k} {m} {pairs} {seen} {misses} {wide} {deep} {blunt} {quarrels} {} {} {} {} {} {}",
            worst.0, worst.1, slowest.0, slowest.1, seconds[0], seconds[1]
        );
    }
    let beside = file.with_extension("writing");
    std::fs::write(&beside, text)
        .and_then(|()| std::fs::rename(&beside, file))
        .expect("the state is writable");
}

/// Reads a state file; `None` where there is none.
///
/// # Panics
/// On a file of another run.
fn read(file: &PathBuf, head: &str) -> Option<(u64, VerdictTable)> {
    let text = std::fs::read_to_string(file).ok()?;
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(head), "{} belongs to another run", file.display());
    let done = lines.next()?.parse().ok()?;
    let mut table = VerdictTable::new();
    for line in lines {
        let w: Vec<&str> = line.split(' ').collect();
        let (n, x) = (|i: usize| w[i].parse::<u64>().unwrap(), |i: usize| w[i].parse::<f64>().unwrap());
        let tally = VerdictCounts {
            pairs: n(3),
            seen: n(4),
            misses: n(5),
            wide: n(6),
            deep: n(7),
            blunt: n(8),
            quarrels: n(9),
            worst: (x(10), n(11)),
            slowest: (x(12), n(13)),
            seconds: [x(14), x(15)],
        };
        table.insert((n(0) as usize, n(1) as usize, n(2) as usize), tally);
    }
    Some((done, table))
}

fn report(done: u64, table: &VerdictTable) -> String {
    let mut out = format!("{done} pairs\n\n");
    out += "| stratum | kind | method | pairs | seen | misses | too wide | the same, κr forbids | oracle blunt | oracles disagree | worst diff/radius \
            (index) | oracle ms, slowest (index) | method µs |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
    let mut all = VerdictCounts::default();
    for ((s, k, m), t) in table {
        let mean = |x: f64, unit: f64| x * unit / t.pairs as f64;
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {:.3} ({}) | {:.1}, {:.0} ({}) | {:.0} |",
            STRATA[*s],
            KINDS[*k],
            METHODS[*m],
            t.pairs,
            t.seen,
            t.misses,
            t.wide,
            t.deep,
            t.blunt,
            t.quarrels,
            t.worst.0,
            t.worst.1,
            mean(t.seconds[0], 1e3),
            1e3 * t.slowest.0,
            t.slowest.1,
            mean(t.seconds[1], 1e6)
        );
        all.pairs += t.pairs;
        all.seen += t.seen;
        all.misses += t.misses;
        all.wide += t.wide;
        all.deep += t.deep;
        all.blunt += t.blunt;
        all.quarrels += t.quarrels;
    }
    let _ = writeln!(
        out,
        "\n{} answers, {} seen: {} misses, {} too wide ({} more where κr forbids), {} oracle blunt, {} oracles disagree",
        all.pairs, all.seen, all.misses, all.wide, all.deep, all.blunt, all.quarrels
    );
    out
}
