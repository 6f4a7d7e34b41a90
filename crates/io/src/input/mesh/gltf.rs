//! glTF 2.0: nodes, primitives and materials, as far as a diffuse world can take them.
//!
//! Reference: the Khronos glTF 2.0 specification and KHR_materials_{emissive_strength, transmission, unlit, volume},
//! KHR_texture_transform, KHR_mesh_quantization. The y axis stays up: turn with `rotate_degrees = [90, 0, 0]`.

use super::glb::{self, Buffers};
use super::polygon;
use super::{Face, Mesh, material};
use crate::input::error::Fault;
use crate::input::files::Files;
use gltf::Document;
use gltf::json::{Root, mesh::Mode, mesh::Semantic, validation::Checked};
use std::collections::BTreeSet;
use std::path::Path;
use zonal_math::{Vec3, vec3};
use zonal_scene::Plate;

/// Extensions that a file may require.
const KNOWN: [&str; 3] = ["KHR_texture_transform", "KHR_mesh_quantization", "KHR_lights_punctual"];

/// Positions and corners that nodes may show however small the file is.
const MAX_READ: usize = 1 << 24;

/// Reads the JSON of a document, validated: indices in range, nothing required that is not known here.
pub(crate) fn document(file: &str, json: &[u8]) -> Result<Document, Fault> {
    let mut root: Root = gltf::json::deserialize::from_slice(json).map_err(|e| {
        let place = format!("JSON line {} column {}", e.line(), e.column());
        Fault::new(file, place, format!("{e}; export the file again"))
    })?;
    let readable = |e: &str| e.starts_with("KHR_materials_") || KNOWN.contains(&e);
    if let Some(e) = root.extensions_required.iter().find(|e| !readable(e)) {
        let what = format!("this file needs the extension {e}, which is not read; export it without");
        return Err(Fault::new(file, "extensionsRequired", what));
    }
    root.extensions_required.clear();
    // Attributes of an application's own begin with an underscore; nothing here reads them.
    for primitive in root.meshes.iter_mut().flat_map(|m| &mut m.primitives) {
        primitive.attributes.retain(|name, _| matches!(name, Checked::Valid(_)));
    }
    check_positions(file, &mut root)?;
    Document::from_json(root).map_err(|e| match e {
        gltf::Error::Validation(list) => match list.first() {
            Some((path, what)) => {
                let what = what.to_string().to_lowercase();
                Fault::new(file, path, format!("{what}; export the file again"))
            }
            None => Fault::new(file, "", "this file is not valid glTF; export it again"),
        },
        e => Fault::new(file, "", format!("{e}; export the file again")),
    })
}

/// The crate's validation indexes the accessors of positions unchecked, so they are checked before; and it wants their
/// min and max, which nothing here reads and many files lack.
fn check_positions(file: &str, root: &mut Root) -> Result<(), Fault> {
    let primitives = root.meshes.iter().flat_map(|m| &m.primitives);
    let positions = primitives.filter_map(|p| p.attributes.get(&Checked::Valid(Semantic::Positions)));
    for index in positions.map(|i| i.value()).collect::<BTreeSet<_>>() {
        let Some(accessor) = root.accessors.get_mut(index) else {
            let what = "POSITION names an accessor that is not there; export the file again";
            return Err(Fault::new(file, format!("accessor {index}"), what));
        };
        let any = || Some(gltf::json::Value::from(vec![0.0; 3]));
        (accessor.min, accessor.max) = (any(), any());
    }
    Ok(())
}

/// Reads a GLB or glTF file.
pub(crate) fn read(files: Files<'_>, path: &Path, file: &str) -> Result<Mesh, Fault> {
    let bytes = files.read(path, glb::MAX_FILE).map_err(|what| Fault::new(file, "", what))?;
    let (json, binary) = glb::split(file, &bytes)?;
    let document = document(file, json)?;
    let buffers = Buffers::open(files, file, path, document.as_json(), json.len(), binary)?;
    let mut mesh = Mesh::default();
    let maps = material::read_all(&document, files, path, &buffers, &mut mesh)?;
    let mut reader = Reader { buffers: &buffers, maps, mesh, skipped: 0, read: 0 };
    for instance in instances(file, &document)? {
        reader.node(&document, &instance)?;
    }
    let mut mesh = reader.mesh;
    if reader.skipped > 0 {
        let n = reader.skipped;
        mesh.notes.push(format!("{file}: {n} primitives of points or lines were left out"));
    }
    if mesh.faces.is_empty() {
        return Err(Fault::new(file, "", "this file shows no triangles; export it again with its meshes"));
    }
    Ok(mesh)
}

/// A node that shows a mesh, and its transformation to the file's world: x ↦ m x + t.
pub(crate) struct Instance {
    node: usize,
    mesh: usize,
    m: [Vec3; 3],
    t: Vec3,
}

impl Instance {
    fn vector(&self, v: Vec3) -> Vec3 {
        self.m[0] * v.x + self.m[1] * v.y + self.m[2] * v.z
    }
    fn determinant(&self) -> f64 {
        self.m[0].cross(self.m[1]).dot(self.m[2])
    }
    /// The mean factor by which lengths grow.
    pub(crate) fn scale(&self) -> f64 {
        self.determinant().abs().cbrt()
    }
    pub(crate) fn mesh(&self) -> usize {
        self.mesh
    }
}

/// The nodes of the default scene (or the first) that show a mesh. Each node is met at most once, so that cycles end.
pub(crate) fn instances(file: &str, document: &Document) -> Result<Vec<Instance>, Fault> {
    let root = document.as_json();
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let tree = scene.is_some();
    let roots: Vec<usize> = match scene {
        Some(scene) => scene.nodes().map(|n| n.index()).collect(),
        None => (0..root.nodes.len()).collect(),
    };
    let identity = [vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0)];
    let mut stack: Vec<_> = roots.iter().rev().map(|i| (*i, identity, Vec3::ZERO)).collect();
    let mut met = vec![false; root.nodes.len()];
    let mut out = Vec::new();
    while let Some((index, pm, pt)) = stack.pop() {
        let Some(node) = document.nodes().nth(index) else {
            continue;
        };
        if std::mem::replace(&mut met[index], true) {
            if !tree {
                continue;
            }
            let what = "this node hangs in two places or in itself; export the file again";
            return Err(Fault::new(file, format!("node {index}"), what));
        }
        let c = node.transform().matrix().map(|c| c.map(f64::from));
        let parent = Instance { node: index, mesh: 0, m: pm, t: pt };
        let column = |k: usize| parent.vector(vec3(c[k][0], c[k][1], c[k][2]));
        let m = [column(0), column(1), column(2)];
        let t = column(3) + pt;
        if !(m.iter().all(|v| v.is_finite()) && t.is_finite()) {
            let what = "this node's transformation is not finite; export the file again";
            return Err(Fault::new(file, format!("node {index}"), what));
        }
        if let Some(mesh) = node.mesh() {
            out.push(Instance { node: index, mesh: mesh.index(), m, t });
        }
        let children: Vec<usize> = node.children().map(|c| c.index()).collect();
        stack.extend(children.iter().rev().map(|c| (*c, m, t)));
    }
    Ok(out)
}

struct Reader<'a> {
    buffers: &'a Buffers<'a>,
    maps: material::Maps,
    mesh: Mesh,
    skipped: usize,
    /// Positions and corners read so far, each time that a node shows them.
    read: usize,
}

impl Reader<'_> {
    fn node(&mut self, document: &Document, at: &Instance) -> Result<(), Fault> {
        let Some(mesh) = document.as_json().meshes.get(at.mesh) else {
            return Ok(());
        };
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let place = format!("mesh {} primitive {p} of node {}", at.mesh, at.node);
            let fault = |what: String| Fault::new(self.buffers.file, &place, what);
            let mode = match primitive.mode {
                Checked::Valid(m @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => m,
                _ => {
                    self.skipped += 1;
                    continue;
                }
            };
            let attribute = |s: Semantic| primitive.attributes.get(&Checked::Valid(s)).copied();
            let Some(positions) = attribute(Semantic::Positions) else {
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
            self.read = self.read.saturating_add(positions.len()).saturating_add(indices.len());
            if self.read > MAX_READ.max(4 * self.buffers.size) {
                return Err(fault(format!(
                    "the nodes up to this one show {} positions and corners, more than are read; show meshes less often",
                    self.read
                )));
            }
            if let Some(i) = indices.iter().find(|i| **i >= positions.len()) {
                return Err(fault(format!(
                    "index {i} is out of range: there are {} positions; export the file again",
                    positions.len()
                )));
            }
            let material = self.maps.of(primitive.material.map(|m| m.value()), &mut self.mesh);
            let map = self.maps.map(material);
            let uvs = match attribute(Semantic::TexCoords(map.set)).filter(|_| map.used) {
                Some(a) => self.buffers.numbers::<2>(a)?,
                None => Vec::new(),
            };
            let corner = |i: usize| {
                let p = at.vector(Vec3::from_array(positions[i])) + at.t;
                (p, uvs.get(i).map_or([0.0; 2], |uv| map.apply(*uv)))
            };
            let template = Face {
                material,
                plate: Plate::triangle(Vec3::ZERO, Vec3::ZERO, Vec3::ZERO),
                uv: [[0.0; 2]; 3],
                scale: at.scale(),
            };
            let mirrored = at.determinant() < 0.0;
            for [a, b, c] in triangles(mode, &indices) {
                let (b, c) = if mirrored { (c, b) } else { (b, c) };
                let corners = [corner(a), corner(b), corner(c)];
                if corners.iter().any(|c| !c.0.is_finite()) {
                    return Err(fault("a corner lies beyond all numbers; export the file again".into()));
                }
                polygon::push(&mut self.mesh.faces, &template, &corners);
            }
        }
        Ok(())
    }
}

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
