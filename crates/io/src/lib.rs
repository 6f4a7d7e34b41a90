//! File formats of zonal: scenes in, solutions, tables, pictures and meshes out.
//!
//! [`input`] reads a scene from TOML and the meshes, images and grids that it names. [`output`] writes a solution as npz, CSV, PNG, EXR,
//! GLB and VTK, and reads npz and EXR back. No file format is known to any crate below this one.
//!
//! ```
//! let scene = zonal_io::input::parse_scene("[[surface]]\nroom = { min = [0, 0, 0], max = [1, 1, 1] }", None, "room.toml")?;
//! assert_eq!(scene.surfaces().len(), 6);
//! # Ok::<(), zonal_io::input::InputError>(())
//! ```

mod error;
mod file_stamps;
mod files;
pub mod input;
mod memory_arrays;
pub mod output;

pub use error::Error;
