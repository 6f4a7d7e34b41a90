//! Formats out, and our own solution file back in.
//!
//! | module | what |
//! |---|---|
//! | [`solution`] | a solution as one `.npz` that numpy opens without us, and back |
//! | [`report`] | the report as JSON, for `--json` and for the solution's header |
//! | [`notes`] | notes and warnings as JSON |
//! | [`hash`] | the scene hash: which scene a solution belongs to |
//! | [`tone`] | exposure, contrast, filmic curve, sRGB, dither |
//! | [`colour_map`] | colours of single values |
//! | [`picture`] | pictures as PNG |
//! | [`texture`] | textures as the bytes of a PNG |
//! | [`exr`] | linear pictures and single fields in f32, out and in |
//! | [`csv`] | one line a zone |
//! | [`glb`] | meshes, materials and cameras for other engines |
//! | [`vtu`], [`vti`] | zones for ParaView: surfaces and panes, the medium |
//! | [`vault`] | a folder that keeps the stages of a solve |
//! | [`arrays`] | single arrays and plain bytes |
//!
//! Every file is written to a temporary name beside its target and renamed when it is complete: a failure leaves the old file
//! untouched and nothing behind. Devices and pipes are written directly.

pub mod arrays;
pub mod colour_map;
pub mod csv;
pub mod exr;
pub mod glb;
pub mod hash;
pub mod notes;
pub mod picture;
pub mod report;
pub mod solution;
pub mod texture;
pub mod tone;
pub mod vault;
pub mod vti;
pub mod vtu;

mod atomic;
mod header;
mod heat;
mod npy;
mod reader;
mod vtk;
mod writer;

pub use arrays::{
    Named, NamedSingle, read_array, write_array, write_arrays, write_bytes, write_single_arrays,
};
pub use atomic::{check_writable, is_stream, remove_stale};
pub use colour_map::{ColourMap, NO_VALUE};
pub use csv::{csv_cell, write_zones_csv};
pub use exr::{
    FieldPicture, Picture, read_exr, read_exr_field, read_exr_field_from_bytes, read_exr_from_bytes,
    write_exr, write_exr_field,
};
pub use glb::write_glb;
pub use hash::{factors_hash, scene_hash};
pub use notes::{note_json, notes_json};
pub use picture::{encode_png, png_note, png_note_from, write_png, write_png_bytes, write_png_noted};
pub use report::report_json;
pub use solution::{read_solution, read_solution_from_bytes, solution_bytes, write_solution};
pub use texture::texture_png;
pub use tone::{Curve, Tone, auto_exposure, srgb_byte};
pub use vault::{Folder, Held, Keys};
pub use vti::write_vti;
pub use vtu::write_vtu;

use std::fmt;
use std::path::{Path, PathBuf};

/// What is wrong with a file, where in it, and what to do: one line.
#[derive(Clone, Debug, PartialEq)]
pub struct FileError {
    path: PathBuf,
    entry: String,
    what: String,
}

impl FileError {
    /// An error in `path`, at `entry` (empty for the file as a whole).
    pub fn new(path: &Path, entry: impl Into<String>, what: impl Into<String>) -> FileError {
        FileError { path: path.into(), entry: entry.into(), what: what.into() }
    }
    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }
    /// The part of the file at fault, empty for the whole.
    pub fn entry(&self) -> &str {
        &self.entry
    }
    /// What is wrong and how to mend it.
    pub fn what(&self) -> &str {
        &self.what
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path = self.path.display();
        if self.entry.is_empty() {
            write!(f, "{path}: {}", self.what)
        } else {
            write!(f, "{path}: {}: {}", self.entry, self.what)
        }
    }
}

impl std::error::Error for FileError {}
