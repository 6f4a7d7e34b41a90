//! Solutions, tables, pictures and meshes out; solutions and pictures back in.
//!
//! | module | contents |
//! |---|---|
//! | `solution` | a solution as one `.npz` that numpy opens, and back |
//! | `npz` | arrays in npz and npy files |
//! | `report` | the report as JSON, for `--json` and for the header of a solution |
//! | `scene_hash` | the identity of the scene that a solution belongs to |
//! | `images` | tone mapping and colour maps; PNG and OpenEXR |
//! | `csv` | one line for each zone |
//! | `face_table` | one line for each face of a mesh file |
//! | [`glb`] | meshes, materials and cameras for other programs |
//! | `vtk` | zones for ParaView: surfaces and panes, the medium |
//! | `view_factors` | view factors of a mesh: formats of View3D, npz, CSV, MatrixMarket |
//! | `matrix` | symmetric matrices as MatrixMarket files and tables of pairs |
//! | `checkpoint` | a folder with the stages of a solve |
//! | `atomic` | whole files or none |
//!
//! Every file is written to a temporary name beside its target and renamed when it is complete: a failure leaves the old file
//! untouched and nothing behind. Devices and pipes are written directly.

mod atomic;
mod checkpoint;
mod csv;
mod error;
mod face_table;
pub mod glb;
mod images;
mod matrix;
mod npz;
mod report;
mod scene_hash;
mod solution;
mod view_factors;
mod vtk;

pub use atomic::{check_writable, is_stream, remove_stale_temporaries, write_bytes};
pub use checkpoint::{CheckpointFolder, CheckpointKeys, CheckpointState};
pub use csv::{csv_cell, csv_name, write_photometric_csv, write_zones_csv};
pub use error::FileError;
pub use face_table::{FaceColumns, write_faces_csv, write_faces_npy, write_faces_vtu};
pub use glb::write_glb;
pub use images::colour_map::{ColourMap, NO_VALUE_COLOUR};
pub use images::exr::{RgbImage, ScalarImage, read_exr, read_exr_from_bytes, write_exr, write_exr_field};
pub use images::png::{
    encode_picture_png, encode_png, encode_png_bytes, read_png_text, read_png_text_from, write_png,
    write_png_bytes, write_png_with_text,
};
pub use images::texture::encode_texture_png;
pub use images::tone::{ToneCurve, ToneMapping, auto_exposure, srgb_to_byte};
pub use matrix::{PairColumn, write_matrix_market, write_pairs_csv};
pub use npz::arrays::{
    ArrayFile, NamedArray, NamedSingleArray, read_array, write_array, write_arrays, write_single_arrays,
};
pub use report::notes::notes_json;
pub use report::report_json;
pub use scene_hash::scene_hash;
pub use solution::{
    CollectZones, collect_solution, read_solution, read_solution_from_bytes, solution_bytes,
    write_divided_solution, write_solution,
};
pub use view_factors::{ViewFactorFormat, ViewFactorTable, write_view_factors};
pub use vtk::vti::write_vti;
pub use vtk::vtu::{CornerArray, write_vtu, write_vtu_with_points};
