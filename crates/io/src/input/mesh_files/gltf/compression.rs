//! Compressed geometry: EXT_meshopt_compression of buffer views, KHR_draco_mesh_compression of primitives.
//!
//! A view that meshopt compresses is decoded as a whole and read as any other. A primitive that Draco compresses brings its points and triangles; its
//! accessors tell how integers stand for coordinates. Uncompressed copies for programs that read neither extension are not used.
//!
//! Reference: the Khronos specifications of both extensions; the decoders are those of the crates `meshoptimizer-rs` and `draco-core`.

use draco_core::{DecodeLimits, DecoderBuffer, Mesh, MeshDecoder};
use gltf::json::Root;
use gltf::json::mesh::Primitive;
use meshoptimizer_rs::codec::{BufferView, Filter, Mode};
use meshoptimizer_rs::{Limits, Workspace};
use serde_json::Value;

/// Name of the extension of buffers and buffer views.
pub(super) const MESHOPT: &str = "EXT_meshopt_compression";
/// Name of the extension of primitives.
pub(super) const DRACO: &str = "KHR_draco_mesh_compression";

/// Largest expansion of meshopt's codecs: 64-fold for constant attributes, and what a small view may have, bytes.
const MAX_MESHOPT_EXPANSION: usize = 64;
const MIN_MESHOPT_ALLOWANCE: usize = 1 << 16;
/// Ceilings on one primitive of Draco: triangles, and bytes of its attributes.
const MAX_DRACO_FACES: u64 = 1 << 26;
const MAX_DRACO_BYTES: u64 = 1 << 30;

/// Most bytes that the compressed views of a file of `size` bytes may hold together.
pub(super) fn max_decoded_bytes(size: usize) -> usize {
    size.saturating_mul(MAX_MESHOPT_EXPANSION).saturating_add(MIN_MESHOPT_ALLOWANCE)
}

/// The extension of this name among the unknown ones.
fn extension<'a>(others: Option<&'a serde_json::Map<String, Value>>, name: &str) -> Option<&'a Value> {
    others?.get(name)
}

/// True if a buffer stands for the decoded views of another one and needs no data.
pub(super) fn is_fallback(buffer: &gltf::json::Buffer) -> bool {
    let meshopt = extension(buffer.extensions.as_ref().map(|e| &e.others), MESHOPT);
    meshopt.is_some_and(|e| e.get("fallback") == Some(&Value::Bool(true)))
}

/// A whole number of an extension; none if it is missing or out of range.
fn whole(extension: &Value, key: &str) -> Option<usize> {
    usize::try_from(extension.get(key)?.as_u64()?).ok()
}

/// The decoded bytes of buffer view `index`; none if it is not compressed. `buffers` has the bytes of all buffers.
pub(super) fn decode_view(
    root: &Root,
    index: usize,
    buffers: &[impl AsRef<[u8]>],
) -> Option<Result<Vec<u8>, String>> {
    let view = root.buffer_views.get(index)?;
    let own = extension(view.extensions.as_ref().map(|e| &e.others), MESHOPT)?;
    Some(decode_meshopt(own, buffers))
}

fn decode_meshopt(own: &Value, buffers: &[impl AsRef<[u8]>]) -> Result<Vec<u8>, String> {
    let wrong = |what: &str| format!("its {MESHOPT} {what}; export the file again");
    let number = |key: &str| whole(own, key).ok_or_else(|| wrong(&format!("has no number {key}")));
    let start = own.get("byteOffset").map_or(Ok(0), |_| number("byteOffset"))?;
    let end = start.checked_add(number("byteLength")?);
    let buffer = buffers.get(number("buffer")?).map(AsRef::as_ref);
    let data = buffer.and_then(|b| b.get(start..end?)).ok_or_else(|| wrong("reaches beyond its buffer"))?;
    let text = |key: &str| own.get(key).and_then(Value::as_str);
    let mode = text("mode").and_then(|m| Mode::parse(m).ok()).ok_or_else(|| wrong("has no known mode"))?;
    let filter = Filter::parse(text("filter").unwrap_or("NONE")).map_err(|_| wrong("has no known filter"))?;
    let view = BufferView::new(mode, filter, number("count")?, number("byteStride")?)
        .map_err(|e| wrong(&format!("has a wrong layout ({e})")))?;
    let most = max_decoded_bytes(data.len());
    if view.byte_length() > most {
        return Err(wrong(&format!(
            "declares {} bytes, more than {} can hold",
            view.byte_length(),
            data.len()
        )));
    }
    let limits = Limits { max_bytes: most.saturating_mul(2), ..Limits::default() };
    let decoded = view.decode(data, &mut Workspace::new(limits));
    decoded.map_err(|e| wrong(&format!("cannot be decoded ({e})")))
}

/// The extension of a primitive that Draco compresses.
pub(super) fn draco_extension(primitive: &Primitive) -> Option<&Value> {
    extension(primitive.extensions.as_ref().map(|e| &e.others), DRACO)
}

/// The buffer view of the extension of a primitive.
pub(super) fn draco_view(extension: &Value) -> Option<usize> {
    whole(extension, "bufferView")
}

/// Points and triangles of a primitive that Draco compresses.
pub(super) struct DracoMesh(Mesh);

impl DracoMesh {
    /// Decodes the bytes of a buffer view.
    pub(super) fn decode(data: &[u8]) -> Result<DracoMesh, String> {
        let limits =
            DecodeLimits::default().with_max_faces(MAX_DRACO_FACES).with_max_decoded_bytes(MAX_DRACO_BYTES);
        let mut mesh = Mesh::new();
        let decoded = MeshDecoder::new().decode(&mut DecoderBuffer::new(data).with_limits(limits), &mut mesh);
        decoded.map_err(|e| {
            let cause: String = e.to_string().chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
            format!("its Draco data cannot be decoded ({cause}); export the file again")
        })?;
        Ok(DracoMesh(mesh))
    }

    /// Corners of all triangles.
    pub(super) fn indices(&self) -> Vec<usize> {
        self.0.faces().iter().flatten().map(|point| point.0 as usize).collect()
    }

    /// The values of an attribute at all points, by the name that the extension gives it; none if the mesh lacks it.
    pub(super) fn attribute<const N: usize>(&self, extension: &Value, name: &str) -> Option<Vec<[f64; N]>> {
        let id = u32::try_from(whole(extension.get("attributes")?, name)?).ok()?;
        let values = self.0.attribute_by_unique_id(id)?.read_f32s(self.0.num_points(), N);
        Some(values.as_chunks::<N>().0.iter().map(|v| v.map(f64::from)).collect())
    }
}
