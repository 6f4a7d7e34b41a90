//! Primitives of glTF meshes as faces.

use super::accessors::Buffers;
use super::materials::MaterialTable;
use super::nodes::NodeInstance;
use crate::input::error::FileFault;
use crate::input::mesh::model::{MeshData, MeshFace};
use crate::input::mesh::polygon::push_polygon;
use gltf::Document;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use zonal_math::Vec3;

/// Number of positions and corners that nodes may show, however small the file is.
const MAX_SHOWN_VERTICES: usize = 1 << 24;

/// Reads the primitives of one node after the other.
pub(super) struct PrimitiveReader<'a> {
    pub(super) buffers: &'a Buffers<'a>,
    pub(super) materials: MaterialTable,
    pub(super) mesh: MeshData,
    /// Number of primitives of points or lines.
    pub(super) skipped: usize,
    /// Number of positions and corners read, counted at every node that shows them.
    pub(super) shown: usize,
}

impl PrimitiveReader<'_> {
    /// Adds the mesh of a node that shows one.
    pub(super) fn read_node(&mut self, document: &Document, at: &NodeInstance) -> Result<(), FileFault> {
        let meshes = &document.as_json().meshes;
        let Some((index, mesh)) = at.mesh.and_then(|i| Some((i, meshes.get(i)?))) else {
            return Ok(());
        };
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let place = format!("mesh {index} primitive {p} of node {}", at.node);
            match primitive.mode {
                Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => {
                    self.read_primitive(primitive, mode, at, &place)?;
                }
                _ => self.skipped += 1,
            }
        }
        Ok(())
    }

    /// The positions of a primitive, and its indices, checked.
    fn read_positions(
        &mut self,
        primitive: &Primitive,
        place: &str,
    ) -> Result<(Vec<[f64; 3]>, Vec<usize>), FileFault> {
        let fault = |message: String| FileFault::new(self.buffers.file, place, message);
        let attribute = primitive.attributes.get(&Checked::Valid(Semantic::Positions)).copied();
        let Some(positions) = attribute else {
            return Err(fault("this primitive has no positions; export the file again".into()));
        };
        let positions = self.buffers.numbers::<3>(positions)?;
        let indices: Vec<usize> = match primitive.indices {
            Some(i) => {
                let read = self.buffers.numbers::<1>(i)?;
                read.iter().map(|[i]| *i as usize).collect()
            }
            None => (0..positions.len()).collect(),
        };
        self.shown = self.shown.saturating_add(positions.len()).saturating_add(indices.len());
        if self.shown > MAX_SHOWN_VERTICES.max(4 * self.buffers.size) {
            return Err(fault(format!(
                "the nodes up to this one show {} positions and corners, more than are read; show meshes less often",
                self.shown
            )));
        }
        match indices.iter().find(|i| **i >= positions.len()) {
            Some(i) => Err(fault(format!(
                "index {i} is out of range: there are {} positions; export the file again",
                positions.len()
            ))),
            None => Ok((positions, indices)),
        }
    }

    /// Adds the triangles of a primitive.
    fn read_primitive(
        &mut self,
        primitive: &Primitive,
        mode: Mode,
        at: &NodeInstance,
        place: &str,
    ) -> Result<(), FileFault> {
        let fault = |message: String| FileFault::new(self.buffers.file, place, message);
        let attribute = |s: Semantic| primitive.attributes.get(&Checked::Valid(s)).copied();
        let (positions, indices) = self.read_positions(primitive, place)?;
        // Read texture coordinates.
        let material = self.materials.index_of(primitive.material.map(|m| m.value()), &mut self.mesh);
        let mapping = self.materials.mapping(material);
        let uvs = match attribute(Semantic::TexCoords(mapping.set)).filter(|_| mapping.used) {
            Some(a) => self.buffers.numbers::<2>(a)?,
            None => Vec::new(),
        };
        // Add the triangles.
        let corner = |i: usize| {
            let p = at.point(Vec3::from_array(positions[i]));
            (p, uvs.get(i).map_or([0.0; 2], |uv| mapping.apply(*uv)))
        };
        for [a, b, c] in triangles(mode, &indices) {
            let (b, c) = if at.is_mirrored() { (c, b) } else { (b, c) };
            let corners = [corner(a), corner(b), corner(c)];
            if corners.iter().any(|c| !c.0.is_finite()) {
                return Err(fault("a corner lies beyond all numbers; export the file again".into()));
            }
            let template =
                MeshFace { scale: at.scale(), ..MeshFace::template(material, self.mesh.face_count) };
            push_polygon(&mut self.mesh.faces, &template, &corners);
            self.mesh.face_count += 1;
        }
        Ok(())
    }
}

/// The triangles of a list of indices.
fn triangles(mode: Mode, i: &[usize]) -> Vec<[usize; 3]> {
    let n = i.len().saturating_sub(2);
    match mode {
        Mode::TriangleStrip => (0..n)
            .map(|k| match k % 2 {
                0 => [i[k], i[k + 1], i[k + 2]],
                _ => [i[k + 1], i[k], i[k + 2]],
            })
            .collect(),
        Mode::TriangleFan => (0..n).map(|k| [i[0], i[k + 1], i[k + 2]]).collect(),
        _ => i.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    }
}
