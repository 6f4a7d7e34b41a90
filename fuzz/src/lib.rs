//! Fuzz targets: one function each, which takes bytes and panics where a property of the program is violated.
//!
//! | module | content |
//! |---|---|
//! | `readers` | every reader, from memory |
//! | `files` | readers of the files of scenes, which need no other crates |
//! | `mutation` | random changes of inputs without libFuzzer |
//! | `archive` | repair of lengths and checksums of zip and PNG, so that mutations reach the code behind them |
//! | `solving` | small scenes solved, drawn, packed, written and read back |
//! | `drawing` | pictures, packages and relighting of a solution |
//! | `scenes` | generator of mostly valid scene texts from bytes |
//!
//! The same functions replay corpora and findings in `crates/app/tests/fuzz_replay.rs`.

mod archive;
mod drawing;
mod files;
mod mutation;
mod readers;
mod scenes;
mod solving;

pub use files::{face_table, gas_array, hdr, luminaire, msh, obj, ply, stl, vtk};
pub use mutation::run_mutated;
pub use readers::{exr, factors, flight, gltf, init, jpeg, npy, npz, png, request, scene, vdb, view3d, vol};
pub use scenes::scene_text;
pub use solving::{solve, solve_toml};

/// A fuzz target: its name and its function.
pub type FuzzTarget = (&'static str, fn(&[u8]));

/// All targets.
pub const FUZZ_TARGETS: [FuzzTarget; 25] = [
    ("exr", exr),
    ("face_table", face_table),
    ("factors", factors),
    ("flight", flight),
    ("gas_array", gas_array),
    ("gltf", gltf),
    ("hdr", hdr),
    ("init", init),
    ("jpeg", jpeg),
    ("luminaire", luminaire),
    ("msh", msh),
    ("npy", npy),
    ("npz", npz),
    ("obj", obj),
    ("ply", ply),
    ("png", png),
    ("request", request),
    ("scene", scene),
    ("solve", solve),
    ("solve_toml", solve_toml),
    ("stl", stl),
    ("vdb", vdb),
    ("view3d", view3d),
    ("vol", vol),
    ("vtk", vtk),
];
