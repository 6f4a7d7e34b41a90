//! Primitives of glTF meshes as faces.

use super::accessors::Buffers;
use super::compression::{self, DracoMesh};
use super::materials::MaterialTable;
use super::nodes::NodeInstance;
use crate::input::mesh::model::{MeshData, MeshFace};
use crate::input::mesh::polygon::push_smooth_polygon;
use crate::input::reading::error::FileFault;
use gltf::Document;
use gltf::json::Index;
use gltf::json::accessor::Accessor;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use serde_json::Value;
use std::collections::{BTreeSet, HashMap};
use std::rc::Rc;
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
    /// Materials of primitives with colours of vertices.
    pub(super) coloured: BTreeSet<usize>,
    /// Primitives that Draco compresses, by their buffer view.
    pub(super) draco: HashMap<usize, Rc<DracoMesh>>,
}

/// The decoded data of a primitive, and the extension that names its attributes.
struct DracoPrimitive<'a> {
    mesh: Rc<DracoMesh>,
    extension: &'a Value,
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

    /// The notes about contents that were not read.
    pub(super) fn notes(&self, document: &Document, instances: &[NodeInstance]) -> Vec<String> {
        let file = self.buffers.file;
        let coloured = self.coloured.iter().map(|m| {
            let name = &self.mesh.materials[*m].name;
            format!("{file}: material '{name}': the colours of its vertices are not read")
        });
        let mut out: Vec<String> = coloured.collect();
        let json = document.as_json();
        let shown = |node: usize| json.nodes.get(node).filter(|n| n.mesh.is_some());
        let skinned = instances.iter().filter_map(|n| shown(n.node)).filter(|n| n.skin.is_some()).count();
        let has_targets = |mesh: usize| {
            json.meshes.get(mesh).is_some_and(|m| m.primitives.iter().any(|p| p.targets.is_some()))
        };
        let morphed = instances.iter().filter_map(|n| n.mesh).filter(|m| has_targets(*m)).count();
        let counted = [
            (skinned, "meshes with a skeleton were read in the pose in which they are stored"),
            (morphed, "meshes with morph targets were read without them"),
            (self.skipped, "primitives of points or lines were left out"),
        ];
        out.extend(counted.iter().filter(|c| c.0 > 0).map(|(n, what)| format!("{file}: {n} {what}")));
        out
    }

    /// The data of a primitive that Draco compresses; each buffer view is decoded once.
    fn draco_primitive<'p>(
        &mut self,
        primitive: &'p Primitive,
        place: &str,
    ) -> Result<Option<DracoPrimitive<'p>>, FileFault> {
        let Some(extension) = compression::draco_extension(primitive) else { return Ok(None) };
        let fault = |message: String| FileFault::new(self.buffers.file, place, message);
        let Some(view) = compression::draco_view(extension) else {
            return Err(fault("its Draco data name no buffer view; export the file again".into()));
        };
        if let Some(mesh) = self.draco.get(&view) {
            return Ok(Some(DracoPrimitive { mesh: mesh.clone(), extension }));
        }
        let index = u32::try_from(view).map(Index::new).unwrap_or(Index::new(u32::MAX));
        let data = self.buffers.view(index, place)?;
        let mesh = Rc::new(DracoMesh::decode(data).map_err(fault)?);
        self.draco.insert(view, mesh.clone());
        Ok(Some(DracoPrimitive { mesh, extension }))
    }

    /// The values of an attribute, out of Draco's data where there are any.
    fn attribute<const N: usize>(
        &self,
        accessor: Index<Accessor>,
        name: &str,
        draco: Option<&DracoPrimitive<'_>>,
        place: &str,
    ) -> Result<Vec<[f64; N]>, FileFault> {
        let Some(DracoPrimitive { mesh, extension }) = draco else { return self.buffers.numbers(accessor) };
        let fault = |message: String| FileFault::new(self.buffers.file, place, message);
        let values = mesh.attribute::<N>(extension, name);
        let mut values = values.ok_or_else(|| {
            fault(format!("its Draco data have no attribute {name}; export the file again"))
        })?;
        let unit = self.buffers.unit(accessor);
        if unit != 1.0 {
            values.iter_mut().flatten().for_each(|x| *x = (*x / unit).max(-1.0));
        }
        if values.iter().flatten().all(|x| x.is_finite()) {
            Ok(values)
        } else {
            Err(fault(format!("a value of {name} is not a finite number; export the file again")))
        }
    }

    /// The positions of a primitive, and its indices, checked.
    fn read_positions(
        &mut self,
        primitive: &Primitive,
        draco: Option<&DracoPrimitive<'_>>,
        place: &str,
    ) -> Result<(Vec<[f64; 3]>, Vec<usize>), FileFault> {
        let fault = |message: String| FileFault::new(self.buffers.file, place, message);
        let attribute = primitive.attributes.get(&Checked::Valid(Semantic::Positions)).copied();
        let Some(positions) = attribute else {
            return Err(fault("this primitive has no positions; export the file again".into()));
        };
        let positions = self.attribute::<3>(positions, "POSITION", draco, place)?;
        let indices: Vec<usize> = match (draco, primitive.indices) {
            (Some(draco), _) => draco.mesh.indices(),
            (None, Some(i)) => {
                let read = self.buffers.numbers::<1>(i)?;
                read.iter().map(|[i]| *i as usize).collect()
            }
            (None, None) => (0..positions.len()).collect(),
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
        let draco = self.draco_primitive(primitive, place)?;
        let (positions, indices) = self.read_positions(primitive, draco.as_ref(), place)?;
        let mode = if draco.is_some() { Mode::Triangles } else { mode };
        // Read texture coordinates.
        let material = self.materials.index_of(primitive.material.map(|m| m.value()), &mut self.mesh);
        let mapping = self.materials.mapping(material);
        if attribute(Semantic::Colors(0)).is_some() {
            self.coloured.insert(material);
        }
        let uvs = match attribute(Semantic::TexCoords(mapping.set)).filter(|_| mapping.used) {
            Some(a) => self.attribute::<2>(a, &format!("TEXCOORD_{}", mapping.set), draco.as_ref(), place)?,
            None => Vec::new(),
        };
        let normals =
            attribute(Semantic::Normals).map(|a| self.attribute::<3>(a, "NORMAL", draco.as_ref(), place));
        let normals = normals.unwrap_or(Ok(Vec::new())).unwrap_or_else(|e| {
            self.mesh
                .notes
                .push(format!("the vertex normals of {place} are not read ({e}); pictures show flat faces"));
            Vec::new()
        });
        // Add the triangles.
        let normal = |i: usize| Some(at.normal(Vec3::from_array(*normals.get(i)?)));
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
            let own = [a, b, c].into_iter().filter_map(normal).collect::<Vec<_>>();
            push_smooth_polygon(&mut self.mesh, &template, &corners, &own);
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
