//! The faces of a file of Gmsh, or the boundary of its volumes, as a mesh.

use super::boundary::boundary_sides;
use super::content::{MshContent, MshElement};
use crate::input::mesh::model::MeshData;
use crate::input::mesh::polygon_list::PolygonList;
use crate::input::reading::error::FileFault;
use std::collections::{HashMap, HashSet};
use zonal_math::Vec3;

/// The mesh of all faces.
pub(super) fn mesh(file: &str, content: &MshContent) -> Result<MeshData, FileFault> {
    check_nodes(file, content)?;
    let mut builder = FaceBuilder {
        file,
        content,
        list: PolygonList::default(),
        materials: HashMap::new(),
        curved: 0,
        repeated: 0,
    };
    let faces = content.elements.iter().filter(|e| e.shape.dimension() == 2).count();
    let volumes = content.elements.len() - faces;
    match (faces, volumes) {
        (0, 0) => {
            let message = "this file has no triangles, quadrilaterals or volume elements; mesh the surfaces: gmsh in.geo -2 -o out.msh";
            return Err(FileFault::new(file, "", message));
        }
        (0, _) => builder.add_boundary()?,
        (_, 0) => builder.add_faces()?,
        (_, n) => {
            builder.add_faces()?;
            builder.note(format!("{n} volume elements are not read: the file has faces"));
        }
    }
    builder.finish()
}

/// Refuses elements whose nodes are not there.
fn check_nodes(file: &str, content: &MshContent) -> Result<(), FileFault> {
    for (k, element) in content.elements.iter().enumerate() {
        if let Some(node) = content.corners(element).iter().find(|n| !content.nodes.contains_key(n)) {
            let message = format!(
                "its node {node} is none of the {} nodes; export the mesh again",
                content.nodes.len()
            );
            return Err(FileFault::new(file, format!("face or volume {}", k + 1), message));
        }
    }
    Ok(())
}

/// Adds faces and counts what notes tell.
struct FaceBuilder<'a> {
    file: &'a str,
    content: &'a MshContent,
    list: PolygonList,
    /// Material of each physical group; all are of one dimension.
    materials: HashMap<i64, usize>,
    /// Faces of elements with nodes besides their corners.
    curved: usize,
    /// Faces that the file repeats.
    repeated: usize,
}

impl FaceBuilder<'_> {
    fn note(&mut self, text: String) {
        self.list.note(format!("{}: {text}", self.file));
    }

    fn position(&self, node: u64) -> Vec3 {
        self.content.nodes.get(&node).copied().unwrap_or_default()
    }

    fn push(&mut self, element: &MshElement, nodes: &[u64]) -> Result<(), FileFault> {
        let corners: Vec<_> = nodes.iter().map(|n| (self.position(*n), [0.0; 2])).collect();
        let new_material = || self.list.material(&self.content.group_name(element));
        let material = *self.materials.entry(element.group).or_insert_with(new_material);
        self.curved += usize::from(element.curved);
        let place = self.list.len() + 1;
        let pushed = self.list.push(material, &corners);
        pushed.map_err(|message| FileFault::new(self.file, format!("face {place}"), message))
    }

    /// Adds the triangles and quadrilaterals. An element that belongs to several groups stands once for each in versions 2.x.
    fn add_faces(&mut self) -> Result<(), FileFault> {
        let content = self.content;
        let mut known = HashSet::new();
        for element in content.elements.iter().filter(|e| e.shape.dimension() == 2) {
            let nodes = content.corners(element);
            let mut key = [u64::MAX; 4];
            key.iter_mut().zip(nodes).for_each(|(k, n)| *k = *n);
            // The same face may begin with another node; in reverse it is the other side of a sheet.
            let least = (0..nodes.len()).min_by_key(|k| key[*k]).unwrap_or(0);
            key[..nodes.len()].rotate_left(least);
            if known.insert(key) {
                self.push(element, nodes)?;
            } else {
                self.repeated += 1;
            }
        }
        Ok(())
    }

    fn add_boundary(&mut self) -> Result<(), FileFault> {
        let content = self.content;
        let position = |node: u64| content.nodes.get(&node).copied().unwrap_or_default();
        for (k, nodes) in boundary_sides(content, &position) {
            self.push(&content.elements[k], &nodes)?;
        }
        let (faces, volumes) = (self.list.len(), content.elements.len());
        self.note(format!("its {volumes} volume elements have no faces of their own; the {faces} sides of their boundary were read"));
        Ok(())
    }

    fn finish(mut self) -> Result<MeshData, FileFault> {
        let content = self.content;
        if self.curved > 0 {
            let n = self.curved;
            self.note(format!("{n} faces are of higher order; they were read as flat between their corners"));
        }
        if self.repeated > 0 {
            let n = self.repeated;
            self.note(format!("{n} faces stand in the file twice, as faces of several physical groups do; the first was read"));
        }
        if content.entities_of_several_groups > 0 {
            let n = content.entities_of_several_groups;
            self.note(format!(
                "{n} surfaces or volumes belong to several physical groups; the first is their material"
            ));
        }
        self.list.finish(self.file)
    }
}
