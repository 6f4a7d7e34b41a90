//! OpenVDB files: sparse grids of floats or doubles, in full or in half precision.
//!
//! | module | contents |
//! |---|---|
//! | `bytes` | reads with checked bounds |
//! | `grid` | the table of contents, and the head of a grid |
//! | `blosc`, `values` | packed values of a node |
//! | `tree` | the tree 5-4-3, block by block |
//! | `transform` | from indices to positions |
//!
//! Read: files with offsets (as `File::write` makes them), format versions 222 (OpenVDB 2.0) to 225. At most one node (32³ values) is
//! unpacked at a time, so that a small file cannot take much memory. The work is bounded too: blocks are disjoint by construction.
//!
//! Reference: the format has no description but its writer, openvdb/io in <https://github.com/AcademySoftwareFoundation/openvdb>.

mod blosc;
pub(crate) mod bytes;
pub(crate) mod grid;
mod transform;
pub(crate) mod tree;
mod values;

/// True for the bytes of an OpenVDB file.
pub(crate) fn is_vdb(bytes: &[u8]) -> bool {
    bytes.starts_with(&grid::MAGIC)
}
