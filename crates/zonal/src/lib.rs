//! The zonal method from a scene to a picture: radiative exchange between surfaces and participating media.
//!
//! This crate is the façade: it gathers the rooms of the house and adds the `zonal` command.
//!
//! ```no_run
//! use zonal::{io, render, scene, solve};
//! let scene = io::input::read_scene("chapel.toml".as_ref())?;
//! let solution = solve::solve(scene, 8 << 30, &scene::Quiet)?;
//! io::output::write_solution("chapel.npz".as_ref(), &solution)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub use zonal_exchange as exchange;
pub use zonal_io as io;
pub use zonal_math as math;
pub use zonal_render as render;
pub use zonal_scene as scene;
pub use zonal_solve as solve;
pub use zonal_transport as transport;

pub mod church;
pub mod commands;
pub mod failure;
pub mod flight;
pub mod legend;
pub mod meter;
pub mod plot;
pub mod scale;
pub mod table;
pub mod viewer;

pub use failure::Failure;
