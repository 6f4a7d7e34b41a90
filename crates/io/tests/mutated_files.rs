//! Random changes of small files of several formats (`fuzz/src`): no reader panics, and a refusal names the scene.
//!
//! `ZONAL_FUZZ_RUNS=300000 cargo test -p zonal-io --test all mutated_files::vtk` runs one target as often.
//!
//! Guards (files): no file makes the program panic.

#[allow(dead_code, unreachable_pub, missing_docs)]
#[path = "../../../fuzz/src/files.rs"]
mod files;
#[allow(dead_code, unreachable_pub, missing_docs)]
#[path = "../../../fuzz/src/mutation.rs"]
mod mutation;

use std::path::Path;

fn run(name: &str, target: fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus").join(name);
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.sort();
    let seeds: Vec<Vec<u8>> = paths.iter().map(|path| std::fs::read(path).unwrap()).collect();
    // The seeds themselves are read without a panic.
    seeds.iter().for_each(|seed| target(seed));
    let failed = mutation::run_mutated(name, target, &seeds, 300);
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

macro_rules! mutated {
    ($($name:ident),*) => { $(#[test] fn $name() { run(stringify!($name), files::$name); })* };
}

mutated!(vtk, stl, ply, msh, obj, face_table, gas_array, luminaire, hdr);
