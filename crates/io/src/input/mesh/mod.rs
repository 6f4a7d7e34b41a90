//! Meshes of surfaces and regions, independent of their file format.
//!
//! | module | contents |
//! |---|---|
//! | `model` | faces and materials as a file gives them, in its unit and axes |
//! | `load`, `placement` | reading by file extension; the mesh placed in the scene |
//! | `mesh_arrays` | a mesh of arrays in memory |
//! | `polygon`, `polygon_list` | polygons as plates; those of a file one after the other |
//! | `face_values` | values by face or by material from files |
//! | `repeated_faces` | the second of two faces with the same corners is dropped |
//! | `shells` | closed parts and their orientation |
//! | `mesh_lights` | lights of a mesh file as lights of the scene |
//! | `mesh_surface`, `material_overrides`, `material_part` | a mesh as surfaces, panes and regions, with the scene's overrides |
//! | `alpha_map`, `cut_outs`, `transparent_materials` | faces cut along the alpha of a picture |
//! | `reflectance_limit` | reflectances of files, at most 0.95 |
//! | `missing_values` | materials that lack values, in one error |

pub(crate) mod alpha_map;
mod cut_outs;
mod face_values;
mod load;
mod material_overrides;
mod material_part;
pub(crate) mod mesh_arrays;
mod mesh_lights;
pub(crate) mod mesh_surface;
mod missing_values;
pub(crate) mod model;
pub(crate) mod placement;
pub(crate) mod polygon;
pub(crate) mod polygon_list;
pub(crate) mod reflectance_limit;
pub(crate) mod repeated_faces;
pub(crate) mod shells;
mod transparent_materials;

pub(crate) use load::read_mesh_file;
