//! Replay of the fuzz corpora and of earlier findings through the functions of the fuzz targets (`fuzz/src`).

#[allow(unreachable_pub)]
#[path = "../../../fuzz/src/lib.rs"]
#[allow(missing_docs)]
mod harness;

use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz")
}

/// The files in a folder of `fuzz/`, sorted; none if the folder is missing.
fn files(folder: &str) -> Vec<PathBuf> {
    let list = std::fs::read_dir(root().join(folder)).into_iter().flatten();
    let mut files: Vec<PathBuf> = list.map(|e| e.unwrap().path()).filter(|p| p.is_file()).collect();
    files.sort();
    files
}

/// Runs a target on its corpus and its findings; returns the files on which it panics.
fn replay(target: &str) -> Vec<String> {
    let (_, run) = *harness::FUZZ_TARGETS.iter().find(|t| t.0 == target).unwrap();
    let mut failed = Vec::new();
    for path in [files(&format!("corpus/{target}")), files(&format!("findings/{target}"))].concat() {
        let bytes = std::fs::read(&path).unwrap();
        if std::panic::catch_unwind(|| run(&bytes)).is_err() {
            failed.push(path.display().to_string());
        }
    }
    failed
}

macro_rules! replays {
    ($($name:ident: $($target:literal),+;)*) => {
        $(#[test]
        fn $name() {
            let failed: Vec<String> = [$($target),+].into_iter().flat_map(replay).collect();
            assert!(failed.is_empty(), "\n{}\n", failed.join("\n"));
        })*

        const REPLAYED: &[&str] = &[$($($target),+),*];
    };
}

replays! {
    scenes_camera_paths_and_requests: "scene", "flight", "request";
    mesh_files: "obj", "gltf", "stl", "ply", "msh", "view3d", "vtk";
    proposed_scenes: "init";
    light_files: "luminaire", "hdr";
    tables_and_arrays: "face_table", "gas_array";
    volume_files: "vdb", "npy", "vol";
    image_files: "png", "jpeg", "exr";
    solution_files: "npz";
    pair_tables: "factors";
    scenes_are_solved_and_drawn: "solve", "solve_toml";
}

// Guards (files): findings of fuzzing are replayed (`fuzz/`), and most random scenes of the fuzz targets are valid.
#[test]
fn every_target_has_a_corpus_and_is_replayed() {
    for (target, _) in harness::FUZZ_TARGETS {
        assert!(REPLAYED.contains(&target), "{target} is not replayed");
        assert!(!files(&format!("corpus/{target}")).is_empty(), "{target} has no corpus");
        assert!(root().join(format!("fuzz_targets/{target}.rs")).is_file(), "{target} has no target");
    }
    for folder in ["corpus", "findings"] {
        for entry in std::fs::read_dir(root().join(folder)).into_iter().flatten() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            assert!(
                harness::FUZZ_TARGETS.iter().any(|t| t.0 == name),
                "{folder}/{name} belongs to no target"
            );
        }
    }
}

/// A file of another version of the format is refused before its arrays are read, and tests nothing else.
#[test]
fn solution_files_are_of_the_current_version() {
    for path in files("corpus/npz").into_iter().chain([root().join("findings/npz/negative.npz")]) {
        let read = zonal_io::output::read_solution(&path);
        assert!(read.is_ok(), "{:?}", read.err());
    }
}

// Guards (files): findings of fuzzing are replayed (`fuzz/`), and most random scenes of the fuzz targets are valid.
/// A refused scene tests only the refusal; most scenes from random bytes must be valid.
#[test]
fn most_random_scenes_are_valid() {
    let mut state = 0x9e37_79b9_7f4a_7c15u64;
    let mut byte = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 32) as u8
    };
    let mut read = 0;
    let mut refused = std::collections::BTreeMap::<String, usize>::new();
    for _ in 0..500 {
        let data: Vec<u8> = (0..200).map(|_| byte()).collect();
        let (text, files) = harness::scene_text(&data);
        match zonal_io::input::read_scene_from_bytes(text.as_bytes(), &files, "random.toml", 1 << 12) {
            Ok(_) => read += 1,
            Err(e) => *refused.entry(e.to_string().chars().skip(12).take(90).collect()).or_default() += 1,
        }
    }
    assert!(read >= 350, "{read} of 500 are read; refused: {refused:#?}");
}

/// The proposals of `zonal init` for altered mesh files; `crates/io/tests/mutated_files.rs` alters the files of the readers.
#[test]
fn altered_models_are_proposed_or_refused() {
    let list = files("corpus/init");
    let seeds: Vec<Vec<u8>> = list.iter().map(|path| std::fs::read(path).unwrap()).collect();
    let failed = harness::run_mutated("init", harness::init, &seeds, 60);
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}
