//! Proved intervals of many random pairs against the oracle, or by the additivity law.
//!
//! With `--state` progress goes to the file every few seconds (written beside it and renamed); the same command continues from it, wherever it
//! was killed. Prints a table by stratum, kind and method; fails if an interval misses the oracle, a radius is wider than the tolerance or two
//! oracles disagree. `--only` shows one case. Threads: `RAYON_NUM_THREADS`.

#[path = "../../crates/paper/tests/support/intervals.rs"]
mod pairs;

use crate::harness::{Error, Outcome};
use pairs::{
    KINDS, METHODS, MethodVerdict, STRATA, VerdictCounts, case, check_additivity, compare_with_oracle, oracle,
};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Pairs between two writings of the state.
const PAIRS_PER_CHUNK: u64 = 512;

#[derive(clap::Args)]
pub(crate) struct IntervalCampaign {
    /// Number of pairs; 100,000 by default, a million with --additivity
    #[arg(long)]
    pairs: Option<u64>,
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// File of the progress
    #[arg(long)]
    state: Option<PathBuf>,
    /// Sums of parts in place of an oracle
    #[arg(long)]
    additivity: bool,
    /// Shows one case
    #[arg(long, value_name = "INDEX")]
    only: Option<u64>,
}

/// Counts by stratum, kind and method.
type VerdictTable = BTreeMap<[usize; 3], VerdictCounts>;

impl IntervalCampaign {
    pub(crate) fn run(&self) -> Outcome {
        if let Some(index) = self.only {
            let c = case(self.seed, index);
            println!("{c:#?}\noracle {:?}", oracle(&c, 0.0));
            let both = [compare_with_oracle, check_additivity].map(|ask| ask(self.seed, index));
            both.concat().iter().for_each(|v| println!("{v:?}"));
            return Ok(true);
        }
        let pairs = self.pairs.unwrap_or(if self.additivity { 1_000_000 } else { 100_000 });
        let ask = if self.additivity { check_additivity } else { compare_with_oracle };
        let head = format!("intervals 1 seed {} additivity {}", self.seed, self.additivity);
        let state = self.state.as_deref().filter(|f| f.exists());
        let (mut done, mut table) = state.map(|f| read(f, &head)).transpose()?.unwrap_or_default();
        while done < pairs {
            let to = (done + PAIRS_PER_CHUNK).min(pairs);
            let chunk = (0..(to - done) as usize).into_par_iter().with_max_len(8);
            let verdicts: Vec<MethodVerdict> =
                chunk.flat_map_iter(|i| ask(self.seed, done + i as u64)).collect();
            for v in &verdicts {
                if v.miss || v.quarrel || v.wide && !v.deep {
                    println!("{v:?} {:?}", case(self.seed, v.index));
                }
                table.entry([v.stratum, v.kind, v.method]).or_default().add(v);
            }
            done = to;
            if let Some(file) = &self.state {
                write(file, &head, done, &table)?;
            }
        }
        print!("{}", report(done, &table));
        Ok(table.values().all(|t| t.misses + t.wide + t.quarrels == 0))
    }
}

fn write(file: &Path, head: &str, done: u64, table: &VerdictTable) -> Result<(), Error> {
    let mut text = format!("{head}\n{done}\n");
    for ([s, k, m], t) in table {
        let VerdictCounts { pairs, seen, misses, wide, deep, blunt, quarrels, worst, slowest, seconds } = t;
        let _ = writeln!(
            text,
            "{s} {k} {m} {pairs} {seen} {misses} {wide} {deep} {blunt} {quarrels} {} {} {} {} {} {}",
            worst.0, worst.1, slowest.0, slowest.1, seconds[0], seconds[1]
        );
    }
    let beside = file.with_extension("writing");
    std::fs::write(&beside, text)?;
    Ok(std::fs::rename(&beside, file)?)
}

/// Pairs that are done and their counts, of a state file of the same run.
fn read(file: &Path, head: &str) -> Result<(u64, VerdictTable), Error> {
    let text = std::fs::read_to_string(file)?;
    let mut lines = text.lines();
    if lines.next() != Some(head) {
        return Err(format!("{} belongs to another run", file.display()).into());
    }
    let done = lines.next().unwrap_or("").parse()?;
    let mut table = VerdictTable::new();
    for line in lines {
        let numbers = line.split(' ').map(str::parse).collect::<Result<Vec<f64>, _>>()?;
        let [s, k, m, pairs, seen, misses, wide, deep, blunt, quarrels, w0, w1, s0, s1, slow, fast] =
            numbers[..]
        else {
            return Err(format!("{}: a line has not sixteen numbers", file.display()).into());
        };
        let [pairs, seen, misses, wide, deep, blunt, quarrels] =
            [pairs, seen, misses, wide, deep, blunt, quarrels].map(|x| x as u64);
        let (worst, slowest, seconds) = ((w0, w1 as u64), (s0, s1 as u64), [slow, fast]);
        let counts =
            VerdictCounts { pairs, seen, misses, wide, deep, blunt, quarrels, worst, slowest, seconds };
        table.insert([s, k, m].map(|x| x as usize), counts);
    }
    Ok((done, table))
}

fn report(done: u64, table: &VerdictTable) -> String {
    let mut out = format!("{done} pairs\n\n");
    out += "| stratum | kind | method | pairs | seen | misses | too wide | the same, κr forbids | oracle blunt | oracles disagree | worst diff/radius \
            (index) | oracle ms, slowest (index) | method µs |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
    let counts = |t: &VerdictCounts| [t.pairs, t.seen, t.misses, t.wide, t.deep, t.blunt, t.quarrels];
    let mut all = [0; 7];
    for ([s, k, m], t) in table {
        let mean = |seconds: f64, unit: f64| seconds * unit / t.pairs as f64;
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {:.3} ({}) | {:.1}, {:.0} ({}) | {:.0} |",
            STRATA[*s],
            KINDS[*k],
            METHODS[*m],
            counts(t).map(|n| n.to_string()).join(" | "),
            t.worst.0,
            t.worst.1,
            mean(t.seconds[0], 1e3),
            1e3 * t.slowest.0,
            t.slowest.1,
            mean(t.seconds[1], 1e6)
        );
        (0..7).for_each(|i| all[i] += counts(t)[i]);
    }
    let [pairs, seen, misses, wide, deep, blunt, quarrels] = all;
    let _ = writeln!(
        out,
        "\n{pairs} answers, {seen} seen: {misses} misses, {wide} too wide ({deep} more where κr forbids), {blunt} oracle blunt, {quarrels} oracles disagree"
    );
    out
}
