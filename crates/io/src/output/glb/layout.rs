//! The binary chunk: which arrays lie where, and the views and accessors that say so.

use super::Mesh;
use serde_json::{Map, Value, json};
use std::io::{self, Write};

/// Arrays to write, with the JSON that describes them.
#[derive(Default)]
pub(super) struct Layout<'a> {
    pub views: Vec<Value>,
    pub accessors: Vec<Value>,
    pub parts: Vec<Part<'a>>,
    /// Bytes so far.
    pub length: u64,
}

/// One array.
pub(super) enum Part<'a> {
    Bytes(&'a [u8]),
    Floats3(&'a [[f32; 3]]),
    Floats2(&'a [[f32; 2]]),
    Colours(&'a [[f32; 4]]),
    Triangles(&'a [[u32; 3]]),
}

impl Part<'_> {
    pub(super) fn size(&self) -> u64 {
        (match self {
            Part::Bytes(b) => b.len(),
            Part::Floats3(x) => 12 * x.len(),
            Part::Floats2(x) => 8 * x.len(),
            Part::Colours(x) => 8 * x.len(),
            Part::Triangles(x) => 12 * x.len(),
        }) as u64
    }
    pub(super) fn write(&self, out: &mut impl Write) -> io::Result<()> {
        match self {
            Part::Bytes(b) => out.write_all(b),
            Part::Floats3(x) => x.as_flattened().iter().try_for_each(|v| out.write_all(&v.to_le_bytes())),
            Part::Floats2(x) => x.as_flattened().iter().try_for_each(|v| out.write_all(&v.to_le_bytes())),
            Part::Triangles(x) => x.as_flattened().iter().try_for_each(|v| out.write_all(&v.to_le_bytes())),
            Part::Colours(x) => x.as_flattened().iter().try_for_each(|v| {
                out.write_all(&((v.clamp(0.0, 1.0) * 65535.0).round() as u16).to_le_bytes())
            }),
        }
    }
}

const FLOAT: u32 = 5126;
const SHORT: u32 = 5123;
const INT: u32 = 5125;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

impl<'a> Layout<'a> {
    pub(super) fn view(&mut self, part: Part<'a>, target: Option<u32>) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.length, "byteLength": part.size() });
        if let Some(t) = target {
            view["target"] = t.into();
        }
        self.length += part.size().next_multiple_of(4);
        self.parts.push(part);
        self.views.push(view);
        self.views.len() - 1
    }

    fn accessor(&mut self, part: Part<'a>, target: u32, kind: &str, component: u32, count: usize) -> usize {
        let view = self.view(part, Some(target));
        let mut accessor =
            json!({ "bufferView": view, "componentType": component, "count": count, "type": kind });
        if component == SHORT {
            accessor["normalized"] = true.into();
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// The JSON of a mesh, its arrays laid out.
    pub(super) fn mesh(&mut self, m: &'a Mesh) -> Value {
        let n = m.positions.len();
        let mut attributes = Map::new();
        let at = self.accessor(Part::Floats3(&m.positions), VERTICES, "VEC3", FLOAT, n);
        let (lo, hi) = bounds(&m.positions);
        (self.accessors[at]["min"], self.accessors[at]["max"]) = (json!(lo), json!(hi));
        attributes.insert("POSITION".into(), at.into());
        if !m.normals.is_empty() {
            let at = self.accessor(Part::Floats3(&m.normals), VERTICES, "VEC3", FLOAT, n);
            attributes.insert("NORMAL".into(), at.into());
        }
        if !m.uvs.is_empty() {
            let at = self.accessor(Part::Floats2(&m.uvs), VERTICES, "VEC2", FLOAT, n);
            attributes.insert("TEXCOORD_0".into(), at.into());
        }
        if !m.colours.is_empty() {
            let at = self.accessor(Part::Colours(&m.colours), VERTICES, "VEC4", SHORT, n);
            attributes.insert("COLOR_0".into(), at.into());
        }
        for (name, values) in &m.values {
            let at = self.accessor(Part::Floats3(values), VERTICES, "VEC3", FLOAT, n);
            attributes.insert(format!("_{name}"), at.into());
        }
        let indices =
            self.accessor(Part::Triangles(&m.triangles), INDICES, "SCALAR", INT, 3 * m.triangles.len());
        let mut primitive = json!({ "attributes": attributes, "indices": indices, "mode": 4 });
        if let Some(i) = m.material {
            primitive["material"] = i.into();
        }
        json!({ "name": m.name, "primitives": [primitive] })
    }
}

fn bounds(p: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
    p.iter().fold(([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]), |(lo, hi), p| {
        ([0, 1, 2].map(|k| lo[k].min(p[k])), [0, 1, 2].map(|k| hi[k].max(p[k])))
    })
}
