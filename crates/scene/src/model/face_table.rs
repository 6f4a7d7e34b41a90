//! Faces of mesh files, and values by face.
//!
//! A *face* is a polygon of a mesh file, in the order of the file. It becomes one facet, several (a polygon that is triangulated), or none (a face
//! without area, a face of a pane, or one of a material that is left out). A value by face holds for all facets of the face and precedes the value of
//! their surface. Faces of several meshes are numbered through: face f of mesh m has the index `first_face(m) + f`.

use crate::bands::Bands;
use crate::thermal::ThermalCondition;

/// A mesh file of a scene.
#[derive(Clone, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
pub struct FaceMesh {
    /// Name of the surface that shows the mesh.
    pub name: String,
    /// Number of faces in the file.
    pub faces: usize,
}

/// Values of one facet that precede those of its surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FacetValues {
    /// Thermal condition; a power is that of the whole face, W.
    pub condition: Option<ThermalCondition>,
    /// Diffuse reflectance ρ.
    pub reflectance: Option<Bands>,
    /// Emitted flux E, W/m².
    pub emission: Option<Bands>,
}

/// The faces of all mesh files of a scene, and the values by face.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FaceTable {
    /// Mesh files, in the order of the scene.
    pub meshes: Vec<FaceMesh>,
    /// Index of the face of each facet; facets beyond the end belong to no mesh file.
    pub face_of_facet: Vec<Option<usize>>,
    /// Values of each facet; facets beyond the end have none.
    pub values: Vec<FacetValues>,
}

impl FaceTable {
    /// Number of faces of all meshes.
    #[must_use]
    pub fn len(&self) -> usize {
        self.meshes.iter().map(|m| m.faces).sum()
    }
    /// True if there are no faces.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Index of the first face of mesh `mesh`.
    #[must_use]
    pub fn first_face(&self, mesh: usize) -> usize {
        self.meshes[..mesh].iter().map(|m| m.faces).sum()
    }
    /// The face of a facet, if it belongs to a mesh file.
    #[must_use]
    pub fn face_of(&self, facet: usize) -> Option<usize> {
        self.face_of_facet.get(facet).copied().flatten()
    }
    /// The values of a facet that precede those of its surface.
    #[must_use]
    pub fn values_of(&self, facet: usize) -> FacetValues {
        self.values.get(facet).copied().unwrap_or_default()
    }
    /// Records face and values of facet number `facet`, which follows all recorded ones.
    pub fn push(&mut self, facet: usize, face: usize, values: FacetValues) {
        self.face_of_facet.resize(facet, None);
        self.face_of_facet.push(Some(face));
        if values != FacetValues::default() {
            self.values.resize(facet, FacetValues::default());
            self.values.push(values);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn facets_without_face_or_value_have_none() {
        let mut table = FaceTable {
            meshes: vec![FaceMesh { name: "a".into(), faces: 2 }, FaceMesh { name: "b".into(), faces: 3 }],
            ..FaceTable::default()
        };
        let hot =
            FacetValues { condition: Some(ThermalCondition::Temperature(400.0)), ..FacetValues::default() };
        table.push(1, 0, FacetValues::default());
        assert!(table.values.is_empty());
        table.push(2, 4, hot);
        assert_eq!((table.len(), table.first_face(1)), (5, 2));
        assert_eq!([0, 1, 2, 3].map(|k| table.face_of(k)), [None, Some(0), Some(4), None]);
        assert_eq!([1, 2, 3].map(|k| table.values_of(k) == hot), [false, true, false]);
    }
}
