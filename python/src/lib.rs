//! The native module `zonal._zonal` of the Python package `zonal`.
//!
//! The typed package in `python/zonal` is the interface of users; this module gives it the scene format, the solvers and the command.
//!
//! | module | content |
//! |---|---|
//! | `errors` | errors of the library as exceptions of the package |
//! | `threads` | the pool of threads, also after a fork |
//! | `long_call` | long computations: without the interpreter's lock, observed, and interrupted at once |
//! | `arrays` | arrays of numpy as arrays of a scene, and results as arrays of numpy |
//! | `scene` | scenes from files and from documents with arrays; their forecast |
//! | `solution`, `zone_arrays` | solutions, their fields and zones |
//! | `picture` | pictures of solutions |
//! | `exchange`, `state` | exchange areas, and thermal states of one geometry |
//! | `view_factors` | view factors of the faces of a mesh |
//! | `dataset` | many solves of one scene |
//! | `tools` | gas models, validation, scene keys |
//! | `command` | the command line, the only module that knows the command |
//!
//! **Unsafe code.** The workspace forbids it; the macros of pyo3 expand to it. Nothing else here is unsafe: arrays of numpy are borrowed by safe functions,
//! and results are handed over to numpy with their memory.

mod arrays;
mod command;
mod dataset;
mod errors;
mod exchange;
mod long_call;
mod picture;
mod scene;
mod solution;
mod state;
mod threads;
mod tools;
mod view_factors;
mod zone_arrays;

use pyo3::prelude::*;

/// Native part of the package `zonal`.
#[pymodule(gil_used = false)]
mod _zonal {
    #[pymodule_export]
    use super::command::run_command;
    #[pymodule_export]
    use super::dataset::write_dataset;
    #[pymodule_export]
    use super::exchange::{ExchangeAreas, exchange};
    #[pymodule_export]
    use super::picture::{encode_png, page, preview, render};
    #[pymodule_export]
    use super::scene::{Scene, check};
    #[pymodule_export]
    use super::solution::{Solution, solve};
    #[pymodule_export]
    use super::state::StateSolver;
    #[pymodule_export]
    use super::tools::{gas, keys, validate, version};
    #[pymodule_export]
    use super::view_factors::{combined_view_factors, script_factors, view_factors, write_view_factors};
}
