//! Random coverage.
mod generate;
mod measure;
mod model;
mod stated;

use rayon::prelude::*;
use std::time::Instant;

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let get = |k: &str, d: u64| args.iter().position(|a| a == k).and_then(|i| args.get(i + 1)).and_then(|x| x.parse().ok()).unwrap_or(d);
    let (n, seed, walks, only) = (get("--random", 20), get("--seed", 1), get("--walks", 100_000), get("--index", u64::MAX));
    let root = std::env::temp_dir().join(format!("zonal-coverage-{}", std::process::id()));
    let list: Vec<u64> = if only < u64::MAX { vec![only] } else { (0..n).collect() };
    let done: Vec<_> = list.into_par_iter().map(|k| {
        let folder = root.join(k.to_string());
        let _ = std::fs::create_dir_all(&folder);
        let (m, _) = generate::model(seed, k);
        let start = Instant::now();
        let r = measure::measure(&m, k, seed.wrapping_mul(1_000_003).wrapping_add(k), walks as usize, &folder);
        eprintln!("{k}: {:?} {:?} {:.2} s {:?}", m.features, r.engines, start.elapsed().as_secs_f64(), r.failures);
        if only < u64::MAX { println!("{}", m.texts("").0); for f in m.texts("").1 { println!("# {}\n{}", f.0, f.1); } }
        r
    }).collect();
    let _ = std::fs::remove_dir_all(&root);
    let all: Vec<&measure::Quantity> = done.iter().flat_map(|r| &r.quantities).collect();
    for kind in [measure::Kind::Name, measure::Kind::Zone] {
        let list: Vec<_> = all.iter().filter(|q| q.kind == kind).collect();
        let times = if kind == measure::Kind::Name { 1.0 } else { 2.0 };
        let covered = list.iter().filter(|q| q.covered(times)).count();
        let unknown = list.iter().filter(|q| q.unknown()).count();
        println!("{kind:?}: {} quantities, covered {covered}, unknown {unknown}", list.len());
        let mut shown = 0;
        for q in &list {
            if !q.covered(times) && !q.unknown() && (kind == measure::Kind::Name || shown < 40) {
                shown += 1;
                println!("  {} {} {}: {:.6e} stated {:.1e} truth {:.6e} sigma {:.1e}", q.scene, q.engine, q.what, q.value, q.stated, q.truth, q.sigma);
            }
        }
    }
}
