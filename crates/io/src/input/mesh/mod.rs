//! Mesh files: OBJ and glTF as faces with materials, in the file's own unit and axes.
//!
//! | module | what |
//! |---|---|
//! | `obj`, `mtl` | Wavefront OBJ and its material libraries |
//! | `gltf`, `glb`, `material` | glTF 2.0: nodes and primitives; containers and accessors; materials |
//! | `polygon` | polygons as plates |
//! | `closed` | which parts are closed, and which way they look |
//! | `place`, `overrides`, `part` | the faces moved into the scene; what the scene says about materials; one material's surfaces or panes |
//! | `volume` | the volume materials of a glTF file |

pub(crate) mod closed;
mod glb;
pub(crate) mod gltf;
mod material;
mod mtl;
mod obj;
mod overrides;
mod part;
pub(crate) mod place;
mod polygon;
pub(crate) mod volume;

use super::error::Fault;
use super::files::Files;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use zonal_scene::{Bands, Plate};

/// The largest OBJ file, bytes.
const MAX_OBJ: u64 = 1 << 30;

/// A mesh file as read.
#[derive(Default)]
pub(crate) struct Mesh {
    pub(crate) materials: Vec<Material>,
    pub(crate) faces: Vec<Face>,
    /// What was mended or left aside.
    pub(crate) notes: Vec<String>,
}

/// A plate with its material.
#[derive(Clone, Copy)]
pub(crate) struct Face {
    pub(crate) material: usize,
    pub(crate) plate: Plate,
    pub(crate) uv: [[f64; 2]; 3],
    /// The factor by which its node scales lengths.
    pub(crate) scale: f64,
}

/// A picture that is decoded only where it is used.
#[derive(Clone)]
pub(crate) enum Picture {
    File(PathBuf),
    Bytes { name: String, bytes: Rc<[u8]> },
}

/// A material of a mesh file.
#[derive(Clone)]
pub(crate) struct Material {
    pub(crate) name: String,
    /// None where the file says nothing.
    pub(crate) reflectance: Option<Bands>,
    pub(crate) texture: Option<Picture>,
    /// W/m².
    pub(crate) emission: Bands,
    pub(crate) emission_texture: Option<Picture>,
    /// glTF's doubleSided; none for OBJ.
    pub(crate) both_sides: Option<bool>,
    pub(crate) glass: Option<Glass>,
    /// Where it is used without a reflectance of the scene file: what its own lacks.
    pub(crate) unknown: Option<String>,
    /// What is lost where it is an opaque surface.
    pub(crate) lost_opaque: Option<String>,
    /// What is lost where it is a pane with the extinction of its file.
    pub(crate) lost_pane: Option<String>,
}

impl Material {
    /// A material about which nothing is known but its name.
    pub(crate) fn named(name: &str) -> Material {
        Material {
            name: name.to_string(),
            reflectance: None,
            texture: None,
            emission: [0.0; 3],
            emission_texture: None,
            both_sides: None,
            glass: None,
            unknown: None,
            lost_opaque: None,
            lost_pane: None,
        }
    }
}

/// A material that light goes through.
#[derive(Clone, Copy)]
pub(crate) struct Glass {
    /// In the unit of the node that shows it.
    pub(crate) thickness: Option<f64>,
    pub(crate) loss: Loss,
    pub(crate) albedo: Bands,
}

/// How much a glass takes.
#[derive(Clone, Copy)]
pub(crate) enum Loss {
    /// κ, in 1/(unit of the file).
    PerMetre(Bands),
    /// The share that goes through the whole thickness.
    Passed(Bands),
}

/// Reads a mesh file by its extension; `file` names it in messages.
pub(crate) fn read(files: Files<'_>, path: &Path, file: &str) -> Result<Mesh, Fault> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("glb" | "gltf") => gltf::read(files, path, file),
        Some("obj") => {
            let bytes = files.read(path, MAX_OBJ).map_err(|what| Fault::new(file, "", what))?;
            if bytes.contains(&0) {
                return Err(Fault::new(file, "", "this is not an OBJ text; export the mesh again"));
            }
            obj::parse(files, path, file, &String::from_utf8_lossy(&bytes))
        }
        _ => Err(Fault::new(file, "", "this kind of mesh is not read; convert it to .obj, .glb or .gltf")),
    }
}
