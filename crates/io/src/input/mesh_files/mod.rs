//! Mesh formats, read by extension (`load`) into the model of [`crate::input::mesh`].
//!
//! | module | format |
//! |---|---|
//! | `obj`, `stl`, `ply`, `gltf`, `msh` | Wavefront OBJ with MTL, STL, PLY, glTF 2.0, Gmsh |
//! | `vtk_mesh` | surfaces of VTK's XML files |
//! | `converters` | formats that are not read, with commands that convert them |

pub(crate) mod converters;
pub(crate) mod gltf;
pub(crate) mod load;
pub(crate) mod msh;
pub(crate) mod obj;
pub(crate) mod ply;
pub(crate) mod stl;
pub(crate) mod vtk_mesh;
