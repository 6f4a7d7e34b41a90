//! The polygons of a mesh file, one after the other, as faces.

use super::model::{MeshData, MeshFace, MeshMaterial};
use super::polygon::{PolygonCorner, push_smooth_polygon};
use crate::input::reading::error::FileFault;
use std::collections::HashMap;
use zonal_math::Vec3;

/// Largest number of corners of a polygon; it bounds the cost of ear clipping.
const MAX_POLYGON_CORNERS: usize = 1024;

/// A mesh while its polygons are added.
#[derive(Default)]
pub(crate) struct PolygonList {
    mesh: MeshData,
    /// Index of each material by its name.
    material_of_name: HashMap<String, usize>,
    /// Number of polygons that cross themselves.
    crossed: usize,
}

impl PolygonList {
    /// The index of the material of this name; it is added on first use.
    pub(crate) fn material(&mut self, name: &str) -> usize {
        if let Some(index) = self.material_of_name.get(name) {
            return *index;
        }
        let index = self.mesh.materials.len();
        self.mesh.materials.push(MeshMaterial::named(name));
        self.material_of_name.insert(name.to_string(), index);
        index
    }

    /// Adds a note of the file.
    pub(crate) fn note(&mut self, text: String) {
        self.mesh.notes.push(text);
    }

    /// Number of polygons.
    pub(crate) fn len(&self) -> usize {
        self.mesh.face_count
    }

    /// Adds a flat polygon; an error states the defect and the remedy.
    pub(crate) fn push(&mut self, material: usize, corners: &[PolygonCorner]) -> Result<(), String> {
        self.push_smooth(material, corners, &[])
    }

    /// Adds a polygon with the normals of its corners, or none; an error states the defect and the remedy.
    pub(crate) fn push_smooth(
        &mut self,
        material: usize,
        corners: &[PolygonCorner],
        normals: &[Vec3],
    ) -> Result<(), String> {
        match corners.len() {
            3..=MAX_POLYGON_CORNERS => {}
            0..3 => {
                let n = corners.len();
                return Err(format!("a face needs at least three corners, not {n}; mend or remove it"));
            }
            _ => {
                return Err(format!(
                    "this face has more than {MAX_POLYGON_CORNERS} corners; triangulate the mesh"
                ));
            }
        }
        let template = MeshFace::template(material, self.mesh.face_count);
        self.mesh.face_count += 1;
        self.crossed += usize::from(!push_smooth_polygon(&mut self.mesh, &template, corners, normals));
        Ok(())
    }

    /// The mesh of all polygons.
    pub(crate) fn finish(mut self, file: &str) -> Result<MeshData, FileFault> {
        if self.mesh.faces.is_empty() {
            return Err(FileFault::new(file, "", "this mesh has no faces; export it again"));
        }
        if self.crossed > 0 {
            let n = self.crossed;
            self.note(format!("{file}: {n} polygons cross themselves and were cut as fans"));
        }
        Ok(self.mesh)
    }
}
