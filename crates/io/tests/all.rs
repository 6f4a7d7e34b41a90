//! The integration tests of the crate as one program, which is linked once.
#![allow(missing_docs)]

mod altered_files;
mod compressed_meshes;
mod cut_outs;
mod density_arrays;
mod error_kinds;
mod face_values;
mod ineffective_keys;
mod inline_scenes;
mod invalid_meshes;
mod invalid_scenes;
mod memory_limits;
mod mesh_files;
mod mesh_topology;
mod models_as_they_come;
mod msh_files;
mod mutated_files;
mod openvdb_files;
mod ply_files;
mod point_lights;
mod shared_meshes;
mod skies;
mod spectra;
mod stl_files;
mod support;
mod thermal_scenes;
mod vertex_normals;
mod view3d_files;
mod view_factor_files;
