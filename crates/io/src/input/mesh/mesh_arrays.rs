//! A mesh of arrays in memory.

use super::model::{MeshData, MeshFace, MeshMaterial};
use super::polygon::push_polygon;
use crate::input::memory_arrays::mismatch;
use crate::input::reading::error::FileFault;
use crate::memory_arrays::{MemoryArray, MeshArrays};
use zonal_math::Vec3;

/// Largest number of corners of a polygon; it bounds the cost of ear clipping.
const MAX_POLYGON_CORNERS: usize = 1024;

/// A mesh with its faces in the order of the array.
pub(crate) fn mesh(array: &MemoryArray<'_>, name: &str) -> Result<MeshData, FileFault> {
    match array {
        MemoryArray::Mesh(arrays) => MeshBuilder { name, arrays }.build(),
        _ => mismatch(array, name, "a mesh: an array of vertices and an array of faces"),
    }
}

/// Makes a mesh of arrays.
struct MeshBuilder<'a> {
    name: &'a str,
    arrays: &'a MeshArrays<'a>,
}

impl MeshBuilder<'_> {
    fn fault(&self, place: String, message: impl std::fmt::Display) -> FileFault {
        FileFault::new(self.name, place, message)
    }

    fn build(&self) -> Result<MeshData, FileFault> {
        let a = self.arrays;
        let faces =
            if a.starts.is_empty() { a.corners.len() / a.corners_of_face.max(1) } else { a.starts.len() - 1 };
        if faces == 0 {
            return Err(self.fault(String::new(), "this mesh has no faces; give an array of faces"));
        }
        if let Some(v) = a.vertices.iter().position(|x| !x.is_finite()) {
            let message = "this coordinate is not a finite number; mend the array of vertices";
            return Err(self.fault(format!("vertex {}", v / 3), message));
        }
        if !a.material_of_face.is_empty() && a.material_of_face.len() != faces {
            let message = format!(
                "there are {faces} faces and {} materials of faces; give one material for each face",
                a.material_of_face.len()
            );
            return Err(self.fault(String::new(), message));
        }
        let names: Vec<&str> = match a.materials {
            [] => vec!["default"],
            list => list.iter().map(String::as_str).collect(),
        };
        let mut mesh = MeshData {
            materials: names.into_iter().map(MeshMaterial::named).collect(),
            face_count: faces,
            ..MeshData::default()
        };
        let mut crossed = 0;
        for face in 0..faces {
            let template = MeshFace::template(self.material(face, mesh.materials.len())?, face);
            let corners = self.corners(face)?.iter().map(|v| Ok((self.vertex(face, *v)?, [0.0; 2])));
            let corners = corners.collect::<Result<Vec<_>, FileFault>>()?;
            crossed += usize::from(!push_polygon(&mut mesh.faces, &template, &corners));
        }
        if crossed > 0 {
            let note = format!("{}: {crossed} polygons cross themselves and were cut as fans", self.name);
            mesh.notes.push(note);
        }
        Ok(mesh)
    }

    fn material(&self, face: usize, count: usize) -> Result<usize, FileFault> {
        let Some(m) = self.arrays.material_of_face.get(face) else { return Ok(0) };
        let index = usize::try_from(*m).ok().filter(|m| *m < count);
        index.ok_or_else(|| {
            let message = format!("material {m} is out of range: there are {count}; mend the index");
            self.fault(format!("face {face}"), message)
        })
    }

    /// The corners of a polygon as indices of vertices.
    fn corners(&self, face: usize) -> Result<&[i64], FileFault> {
        let a = self.arrays;
        let range = match a.starts {
            [] => Some(face * a.corners_of_face..(face + 1) * a.corners_of_face),
            starts => usize::try_from(starts[face])
                .ok()
                .zip(usize::try_from(starts[face + 1]).ok())
                .map(|(first, end)| first..end),
        };
        let corners = range.and_then(|r| a.corners.get(r)).unwrap_or_default();
        if (3..=MAX_POLYGON_CORNERS).contains(&corners.len()) {
            return Ok(corners);
        }
        let message = format!(
            "this face has {} corners; give polygons of 3 to {MAX_POLYGON_CORNERS} corners",
            corners.len()
        );
        Err(self.fault(format!("face {face}"), message))
    }

    fn vertex(&self, face: usize, index: i64) -> Result<Vec3, FileFault> {
        let vertices = self.arrays.vertices.as_chunks::<3>().0;
        let found = usize::try_from(index).ok().and_then(|i| vertices.get(i));
        found.map(|v| Vec3::from_array(*v)).ok_or_else(|| {
            let message = format!(
                "vertex index {index} is out of range: there are {} vertices; mend the index",
                vertices.len()
            );
            self.fault(format!("face {face}"), message)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_of_arrays_are_checked() {
        let vertices = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0];
        let mesh = |corners: &[i64], starts: &[i64], materials: &[i64]| {
            let arrays = MeshArrays {
                vertices: &vertices,
                corners,
                starts,
                corners_of_face: 3,
                material_of_face: materials,
                materials: &[],
            };
            super::mesh(&MemoryArray::Mesh(arrays), "m").map_err(|e| e.to_string())
        };
        let two = mesh(&[0, 1, 2, 0, 2, 3], &[], &[]).map(|m| (m.faces.len(), m.face_count));
        assert_eq!(two.unwrap(), (2, 2));
        let quad = mesh(&[0, 1, 2, 3], &[0, 4], &[]).unwrap();
        assert_eq!((quad.face_count, quad.faces[0].face), (1, 0));
        for (corners, starts, materials, message) in [
            (&[0, 1, 4][..], &[][..], &[][..], "face 0: vertex index 4 is out of range"),
            (&[0, 1, -1], &[], &[], "face 0: vertex index -1 is out of range"),
            (&[0, 1], &[0, 2], &[], "face 0: this face has 2 corners"),
            (&[0, 1, 2], &[0, 9], &[], "face 0: this face has 0 corners"),
            (&[0, 1, 2], &[], &[1], "face 0: material 1 is out of range"),
            (&[0, 1, 2], &[], &[0, 0], "there are 1 faces and 2 materials"),
            (&[], &[], &[], "this mesh has no faces"),
        ] {
            let Err(error) = mesh(corners, starts, materials) else { panic!("{message}") };
            assert!(error.contains(message), "{error}");
        }
    }
}
