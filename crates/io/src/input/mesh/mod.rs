//! Meshes of surfaces and regions, independent of their file format.
//!
//! | module | contents |
//! |---|---|
//! | `model` | faces and materials as a file gives them, in its unit and axes |
//! | `mesh_arrays` | a mesh of arrays in memory |
//! | `rotation` | turns of a mesh |
//! | `polygon`, `polygon_list` | polygons as plates; those of a file one after the other |
//! | `shells` | closed parts and their orientation |
//! | `cut_outs` | faces cut along the alpha of a picture |
//! | `reflectance_limit` | reflectances of files, at most 0.95 |
//! | `missing_values` | materials that lack values, in one error |

pub(crate) mod cut_outs;
pub(crate) mod mesh_arrays;
pub(crate) mod missing_values;
pub(crate) mod model;
pub(crate) mod polygon;
pub(crate) mod polygon_list;
pub(crate) mod reflectance_limit;
pub(crate) mod rotation;
pub(crate) mod shells;
