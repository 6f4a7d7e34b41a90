//! What fuzzing calls: one function a target, from bytes to nothing. It panics where the program would have been wrong.
//!
//! | module | what |
//! |---|---|
//! | `readers` | every reader, from memory |
//! | `archive` | zip and PNG with lengths and checksums put right, so that mutations reach what lies behind them |
//! | `solving` | a scene solved, drawn, packed, written and read back, at tiny size |
//! | `scenes` | bytes as choices, from which a scene's text is written that is mostly valid |
//!
//! The same functions replay corpora and findings in `crates/zonal/tests/fuzz_replay.rs`.

mod archive;
mod readers;
mod scenes;
mod solving;

pub use readers::{exr, factors, flight, gltf, jpeg, npy, npz, obj, png, request, scene, vdb, vol};
pub use scenes::text as scene_text;
pub use solving::{solve, solve_toml};

/// A fuzz target: its name, and what it does with bytes.
pub type Target = (&'static str, fn(&[u8]));

/// All targets.
pub const TARGETS: [Target; 15] = [
    ("exr", exr),
    ("factors", factors),
    ("flight", flight),
    ("gltf", gltf),
    ("jpeg", jpeg),
    ("npy", npy),
    ("npz", npz),
    ("obj", obj),
    ("png", png),
    ("request", request),
    ("scene", scene),
    ("solve", solve),
    ("solve_toml", solve_toml),
    ("vdb", vdb),
    ("vol", vol),
];
