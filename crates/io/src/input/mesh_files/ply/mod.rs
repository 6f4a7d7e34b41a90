//! PLY: polygons of any number of corners, as text or in binary form of either byte order.
//!
//! | element | read | passed over |
//! |---|---|---|
//! | `vertex` | `x`, `y`, `z` of any type; texture coordinates `s`, `t` or `u`, `v` or `texture_u`, `texture_v` | other properties; of colours a note tells |
//! | `face` | the list `vertex_indices` or `vertex_index`; texture coordinates by corner, the list `texcoord` | as above |
//! | any other | | all properties, lists too |
//!
//! The mesh has one material, `default`. A PLY file has no agreed place for reflectances: its colours are those of a picture, and are not read.
//! The second texture coordinate runs up, as in OBJ.
//!
//! Reference: G. Turk, The PLY Polygon File Format (Stanford Graphics Lab, 1994); `texcoord` and `comment TextureFile` as MeshLab writes them.

mod header;
mod read;

pub(super) use read::read_mesh_file;
