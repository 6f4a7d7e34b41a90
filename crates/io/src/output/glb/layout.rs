//! The binary chunk: the arrays, and the views and accessors that describe them.

use super::model::GlbMesh;
use serde_json::{Map, Value, json};
use std::io::{self, Write};

/// Arrays to write, with the JSON that describes them.
#[derive(Default)]
pub(super) struct BinaryLayout<'a> {
    pub views: Vec<Value>,
    pub accessors: Vec<Value>,
    pub parts: Vec<ArrayData<'a>>,
    /// Bytes so far.
    pub length: u64,
}

/// One array.
pub(super) enum ArrayData<'a> {
    Bytes(&'a [u8]),
    Floats3(&'a [[f32; 3]]),
    Floats2(&'a [[f32; 2]]),
    Colours(&'a [[f32; 4]]),
    Triangles(&'a [[u32; 3]]),
}

impl ArrayData<'_> {
    pub(super) fn size(&self) -> u64 {
        (match self {
            ArrayData::Bytes(b) => b.len(),
            ArrayData::Floats3(x) => 12 * x.len(),
            ArrayData::Floats2(x) => 8 * x.len(),
            ArrayData::Colours(x) => 8 * x.len(),
            ArrayData::Triangles(x) => 12 * x.len(),
        }) as u64
    }
    pub(super) fn write(&self, out: &mut impl Write) -> io::Result<()> {
        match self {
            ArrayData::Bytes(b) => out.write_all(b),
            ArrayData::Floats3(x) => {
                x.as_flattened().iter().try_for_each(|v| out.write_all(&v.to_le_bytes()))
            }
            ArrayData::Floats2(x) => {
                x.as_flattened().iter().try_for_each(|v| out.write_all(&v.to_le_bytes()))
            }
            ArrayData::Triangles(x) => {
                x.as_flattened().iter().try_for_each(|v| out.write_all(&v.to_le_bytes()))
            }
            ArrayData::Colours(x) => x.as_flattened().iter().try_for_each(|v| {
                out.write_all(&((v.clamp(0.0, 1.0) * 65535.0).round() as u16).to_le_bytes())
            }),
        }
    }
}

/// Component types of glTF.
const COMPONENT_F32: u32 = 5126;
const COMPONENT_U16: u32 = 5123;
const COMPONENT_U32: u32 = 5125;
/// Targets of buffer views.
const TARGET_VERTICES: u32 = 34962;
const TARGET_INDICES: u32 = 34963;

impl<'a> BinaryLayout<'a> {
    /// Appends an array; returns the index of its view.
    pub(super) fn add_view(&mut self, part: ArrayData<'a>, target: Option<u32>) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.length, "byteLength": part.size() });
        if let Some(t) = target {
            view["target"] = t.into();
        }
        self.length += part.size().next_multiple_of(4);
        self.parts.push(part);
        self.views.push(view);
        self.views.len() - 1
    }

    /// Appends an array of vertices or indices; returns the index of its accessor.
    fn add_accessor(
        &mut self,
        part: ArrayData<'a>,
        target: u32,
        kind: &str,
        component: u32,
        count: usize,
    ) -> usize {
        let view = self.add_view(part, Some(target));
        let mut accessor =
            json!({ "bufferView": view, "componentType": component, "count": count, "type": kind });
        if component == COMPONENT_U16 {
            accessor["normalized"] = true.into();
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Appends the arrays of a mesh; returns its JSON.
    pub(super) fn add_mesh(&mut self, m: &'a GlbMesh) -> Value {
        let n = m.positions.len();
        let mut attributes = Map::new();
        let at =
            self.add_accessor(ArrayData::Floats3(&m.positions), TARGET_VERTICES, "VEC3", COMPONENT_F32, n);
        let (lo, hi) = bounds(&m.positions);
        (self.accessors[at]["min"], self.accessors[at]["max"]) = (json!(lo), json!(hi));
        attributes.insert("POSITION".into(), at.into());
        if !m.normals.is_empty() {
            let at =
                self.add_accessor(ArrayData::Floats3(&m.normals), TARGET_VERTICES, "VEC3", COMPONENT_F32, n);
            attributes.insert("NORMAL".into(), at.into());
        }
        for (name, uvs) in [("TEXCOORD_0", &m.uvs), ("TEXCOORD_1", &m.lightmap_uvs)] {
            if !uvs.is_empty() {
                let at =
                    self.add_accessor(ArrayData::Floats2(uvs), TARGET_VERTICES, "VEC2", COMPONENT_F32, n);
                attributes.insert(name.into(), at.into());
            }
        }
        if !m.colours.is_empty() {
            let at =
                self.add_accessor(ArrayData::Colours(&m.colours), TARGET_VERTICES, "VEC4", COMPONENT_U16, n);
            attributes.insert("COLOR_0".into(), at.into());
        }
        for (name, values) in &m.values {
            let at = self.add_accessor(ArrayData::Floats3(values), TARGET_VERTICES, "VEC3", COMPONENT_F32, n);
            attributes.insert(format!("_{name}"), at.into());
        }
        let indices = self.add_accessor(
            ArrayData::Triangles(&m.triangles),
            TARGET_INDICES,
            "SCALAR",
            COMPONENT_U32,
            3 * m.triangles.len(),
        );
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
