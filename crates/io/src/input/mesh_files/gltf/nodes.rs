//! The node tree of a glTF document: its nodes with their transformations to the file's world.

use crate::input::reading::error::FileFault;
use gltf::Document;
use zonal_math::{Vec3, vec3};

/// A node of the scene, and its transformation to the file's world: x ↦ linear x + translation.
pub(super) struct NodeInstance {
    pub(super) node: usize,
    /// The mesh that it shows.
    pub(super) mesh: Option<usize>,
    /// Images of the unit vectors.
    linear: [Vec3; 3],
    translation: Vec3,
}

impl NodeInstance {
    /// The image of a direction.
    pub(super) fn vector(&self, v: Vec3) -> Vec3 {
        self.linear[0] * v.x + self.linear[1] * v.y + self.linear[2] * v.z
    }
    /// The image of a point.
    pub(super) fn point(&self, p: Vec3) -> Vec3 {
        self.vector(p) + self.translation
    }
    /// The image of a normal, of any length.
    pub(super) fn normal(&self, n: Vec3) -> Vec3 {
        let [a, b, c] = self.linear;
        let image = b.cross(c) * n.x + c.cross(a) * n.y + a.cross(b) * n.z;
        if self.is_mirrored() { -image } else { image }
    }
    fn determinant(&self) -> f64 {
        self.linear[0].cross(self.linear[1]).dot(self.linear[2])
    }
    /// True if the transformation reverses the orientation of triangles.
    pub(super) fn is_mirrored(&self) -> bool {
        self.determinant() < 0.0
    }
    /// Geometric mean of the factors of lengths.
    pub(super) fn scale(&self) -> f64 {
        self.determinant().abs().cbrt()
    }
}

/// A node with a light, in the file's world.
pub(super) struct LightInstance {
    pub(super) node: usize,
    /// Index of the light.
    pub(super) light: usize,
    pub(super) position: Vec3,
    /// The way along which it shines, of any length.
    pub(super) direction: Vec3,
}

impl LightInstance {
    /// The light of a node, if it has one.
    pub(super) fn of(document: &Document, at: &NodeInstance) -> Option<LightInstance> {
        let light = light_of(document, at.node)?;
        Some(LightInstance { node: at.node, light, position: at.translation, direction: -at.linear[2] })
    }
}

/// The nodes of the default scene (or the first). Each node is visited at most once, so that cycles end.
pub(super) fn node_instances(file: &str, document: &Document) -> Result<Vec<NodeInstance>, FileFault> {
    let root = document.as_json();
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let is_tree = scene.is_some();
    let roots: Vec<usize> = match scene {
        Some(scene) => scene.nodes().map(|n| n.index()).collect(),
        None => (0..root.nodes.len()).collect(),
    };
    let identity = [vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0)];
    let mut stack: Vec<_> = roots.iter().rev().map(|i| (*i, identity, Vec3::ZERO)).collect();
    let mut visited = vec![false; root.nodes.len()];
    let mut out = Vec::new();
    while let Some((index, pm, pt)) = stack.pop() {
        let Some(node) = document.nodes().nth(index) else {
            continue;
        };
        if std::mem::replace(&mut visited[index], true) {
            if !is_tree {
                continue;
            }
            let message = "this node hangs in two places or in itself; export the file again";
            return Err(FileFault::new(file, format!("node {index}"), message));
        }
        let c = node.transform().matrix().map(|c| c.map(f64::from));
        let parent = NodeInstance { node: index, mesh: None, linear: pm, translation: pt };
        let column = |k: usize| parent.vector(vec3(c[k][0], c[k][1], c[k][2]));
        let m = [column(0), column(1), column(2)];
        let t = column(3) + pt;
        if !(m.iter().all(|v| v.is_finite()) && t.is_finite()) {
            let message = "this node's transformation is not finite; export the file again";
            return Err(FileFault::new(file, format!("node {index}"), message));
        }
        let mesh = node.mesh().map(|mesh| mesh.index());
        out.push(NodeInstance { node: index, mesh, linear: m, translation: t });
        let children: Vec<usize> = node.children().map(|c| c.index()).collect();
        stack.extend(children.iter().rev().map(|c| (*c, m, t)));
    }
    Ok(out)
}

/// The index of the light of a node.
fn light_of(document: &Document, node: usize) -> Option<usize> {
    let extensions = document.as_json().nodes.get(node)?.extensions.as_ref()?;
    Some(extensions.khr_lights_punctual.as_ref()?.light.value())
}
