//! The containers of glTF: GLB chunks, buffers from files and data URIs, and accessors read with every bound checked.

use crate::input::error::Fault;
use crate::input::files::Files;
use gltf::json::{self, Root, accessor::ComponentType, accessor::Type, validation::Checked};
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// The largest glTF or buffer file, bytes.
pub(crate) const MAX_FILE: u64 = 2 << 30;

/// A GLB or glTF file, split into its JSON and its binary chunk.
pub(crate) fn split<'a>(file: &str, bytes: &'a [u8]) -> Result<(&'a [u8], Option<&'a [u8]>), Fault> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes, None));
    }
    let word = |at: usize| {
        let b: Option<[u8; 4]> = bytes.get(at..at + 4).and_then(|b| b.try_into().ok());
        b.map(u32::from_le_bytes)
    };
    let cut = |place: &str| Fault::new(file, place, "this GLB is cut short; copy or export it again");
    match word(4) {
        Some(2) => {}
        Some(v) => {
            let what = format!("this is glTF version {v}; export it as glTF 2.0");
            return Err(Fault::new(file, "header", what));
        }
        None => return Err(cut("header")),
    }
    let (mut json, mut binary, mut at) = (None, None, 12usize);
    let total = word(8).ok_or_else(|| cut("header"))? as usize;
    if total > bytes.len() {
        return Err(cut("header"));
    }
    while at < total {
        let place = format!("chunk at byte {at}");
        let (Some(length), Some(kind)) = (word(at), word(at + 4)) else {
            return Err(cut(&place));
        };
        let end = (at + 8).saturating_add(length as usize);
        let data = bytes.get(at + 8..end).ok_or_else(|| cut(&place))?;
        match &kind.to_le_bytes() {
            b"JSON" if json.is_none() => json = Some(data),
            b"BIN\0" if binary.is_none() => binary = Some(data),
            _ => {}
        }
        at = end;
    }
    let json =
        json.ok_or_else(|| Fault::new(file, "header", "this GLB has no JSON chunk; export it again"))?;
    Ok((json, binary))
}

/// The bytes behind a URI: a data URI, or a file beside `path`.
pub(crate) fn resolve(
    files: Files<'_>,
    file: &str,
    path: &Path,
    place: &str,
    uri: &str,
) -> Result<Vec<u8>, Fault> {
    if let Some(data) = uri.strip_prefix("data:") {
        let encoded = data.split_once(";base64,").map(|(_, e)| e);
        return encoded
            .and_then(base64)
            .ok_or_else(|| Fault::new(file, place, "this data URI is not base64; export the file again"));
    }
    let beside = beside(path, uri);
    files
        .read(&beside, MAX_FILE)
        .map_err(|what| Fault::new(file, place, format!("'{}': {what}", beside.display())))
}

/// The file that a relative URI names.
pub(crate) fn beside(path: &Path, uri: &str) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).join(percent(uri))
}

fn percent(uri: &str) -> String {
    let b = uri.as_bytes();
    let mut out = Vec::with_capacity(b.len());
    let mut i = 0;
    while i < b.len() {
        let code = b.get(i + 1..i + 3).and_then(|h| std::str::from_utf8(h).ok());
        match code.and_then(|h| u8::from_str_radix(h, 16).ok()) {
            Some(byte) if b[i] == b'%' => {
                out.push(byte);
                i += 3;
            }
            _ => {
                out.push(b[i]);
                i += 1;
            }
        }
    }
    String::from_utf8_lossy(&out).into_owned()
}

fn base64(text: &str) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut count) = (0u32, 0);
    for c in text.bytes().filter(|c| *c != b'=') {
        let value = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ => return None,
        };
        bits = bits << 6 | value as u32;
        count += 6;
        if count >= 8 {
            count -= 8;
            out.push((bits >> count) as u8);
        }
    }
    Some(out)
}

/// The buffers of a document.
pub(crate) struct Buffers<'a> {
    pub(crate) file: &'a str,
    pub(crate) root: &'a Root,
    pub(crate) data: Vec<Cow<'a, [u8]>>,
    /// Bytes of the JSON, and of all data.
    pub(crate) size: usize,
}

impl<'a> Buffers<'a> {
    pub(crate) fn open(
        files: Files<'_>,
        file: &'a str,
        path: &Path,
        root: &'a Root,
        json: usize,
        binary: Option<&'a [u8]>,
    ) -> Result<Buffers<'a>, Fault> {
        let mut data = Vec::new();
        for (i, b) in root.buffers.iter().enumerate() {
            let place = format!("buffer {i}");
            let bytes = match (&b.uri, binary) {
                (Some(uri), _) => Cow::Owned(resolve(files, file, path, &place, uri)?),
                (None, Some(binary)) if i == 0 => Cow::Borrowed(binary),
                _ => {
                    let what = "this buffer has no data; export the file again, with its .bin beside it";
                    return Err(Fault::new(file, place, what));
                }
            };
            data.push(bytes);
        }
        let size = json + data.iter().map(|d| d.len()).sum::<usize>();
        Ok(Buffers { file, root, data, size })
    }

    /// The bytes of a buffer view.
    pub(crate) fn view(&self, index: json::Index<json::buffer::View>, place: &str) -> Result<&[u8], Fault> {
        let range = || {
            let view = self.root.buffer_views.get(index.value())?;
            let start = view.byte_offset.map_or(0, |o| o.0 as usize);
            let end = start.checked_add(view.byte_length.0 as usize)?;
            self.data.get(view.buffer.value())?.get(start..end)
        };
        range().ok_or_else(|| {
            Fault::new(
                self.file,
                place,
                format!(
                    "buffer view {} reaches beyond its buffer; copy or export the file again",
                    index.value()
                ),
            )
        })
    }

    /// An accessor's elements, each of `N` components, as numbers.
    pub(crate) fn numbers<const N: usize>(
        &self,
        index: json::Index<json::accessor::Accessor>,
    ) -> Result<Vec<[f64; N]>, Fault> {
        let place = format!("accessor {}", index.value());
        let fault = |what: &str| Fault::new(self.file, &place, what);
        let accessor = self
            .root
            .accessors
            .get(index.value())
            .ok_or_else(|| fault("there is no such accessor; export the file again"))?;
        let wanted = match N {
            1 => Type::Scalar,
            2 => Type::Vec2,
            _ => Type::Vec3,
        };
        if accessor.type_ != Checked::Valid(wanted) {
            return Err(fault(
                "this accessor has another number of components than its use needs; export the file again",
            ));
        }
        let Checked::Valid(component) = accessor.component_type else {
            return Err(fault("this component type is not known; export the file again"));
        };
        let count = accessor.count.0 as usize;
        let mut out = match accessor.buffer_view {
            Some(view) => {
                let stride = self.root.buffer_views.get(view.value());
                let stride = stride.and_then(|v| v.byte_stride.as_ref()).map(|s| s.0);
                let offset = accessor.byte_offset.map_or(0, |o| o.0 as usize);
                let data = self.view(view, &place)?;
                elements::<N>(data, offset, stride, count, component.0, accessor.normalized).ok_or_else(
                    || fault("this accessor reaches beyond its buffer view; copy or export the file again"),
                )?
            }
            // All zeros: no more of them than the file has bytes.
            None if count <= self.size => vec![[0.0; N]; count],
            None => return Err(fault("this accessor is too large; export the file again")),
        };
        if let Some(sparse) = &accessor.sparse {
            let n = sparse.count.0 as usize;
            let Checked::Valid(index_type) = sparse.indices.component_type else {
                return Err(fault("the sparse index type is not known; export the file again"));
            };
            let offset = |o: json::validation::USize64| o.0 as usize;
            let indices = elements::<1>(
                self.view(sparse.indices.buffer_view, &place)?,
                offset(sparse.indices.byte_offset),
                None,
                n,
                index_type.0,
                false,
            );
            let values = elements::<N>(
                self.view(sparse.values.buffer_view, &place)?,
                offset(sparse.values.byte_offset),
                None,
                n,
                component.0,
                accessor.normalized,
            );
            let beyond = || fault("the sparse part reaches beyond its data; copy or export the file again");
            let (indices, values) = indices.zip(values).ok_or_else(beyond)?;
            for ([i], value) in indices.into_iter().zip(values) {
                *out.get_mut(i as usize).ok_or_else(beyond)? = value;
            }
        }
        if let Some(i) = out.iter().position(|v| v.iter().any(|x| !x.is_finite())) {
            return Err(Fault::new(
                self.file,
                format!("{place}, element {i}"),
                "this value is not a finite number; export the file again",
            ));
        }
        Ok(out)
    }
}

/// `count` elements from `offset` on; none where they reach beyond `data`.
fn elements<const N: usize>(
    data: &[u8],
    offset: usize,
    stride: Option<usize>,
    count: usize,
    component: ComponentType,
    normalized: bool,
) -> Option<Vec<[f64; N]>> {
    let size = component.size();
    let step = stride.unwrap_or(size * N);
    if count == 0 {
        return Some(Vec::new());
    }
    let last = step.checked_mul(count - 1)?.checked_add(offset)?;
    if step == 0 || last.checked_add(size * N)? > data.len() {
        return None;
    }
    let element = |i: usize| -> [f64; N] {
        std::array::from_fn(|k| {
            let at = offset + i * step + k * size;
            component_value(&data[at..at + size], component, normalized)
        })
    };
    Some((0..count).map(element).collect())
}

fn component_value(b: &[u8], component: ComponentType, normalized: bool) -> f64 {
    let bits = b.iter().rev().fold(0u32, |n, x| n << 8 | *x as u32);
    let (value, unit) = match component {
        ComponentType::I8 => (bits as u8 as i8 as f64, 127.0),
        ComponentType::U8 => (bits as f64, 255.0),
        ComponentType::I16 => (bits as u16 as i16 as f64, 32767.0),
        ComponentType::U16 => (bits as f64, 65535.0),
        ComponentType::U32 => (bits as f64, 1.0),
        ComponentType::F32 => (f32::from_bits(bits) as f64, 1.0),
    };
    if normalized { (value / unit).max(-1.0) } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_and_percent_signs() {
        assert_eq!(base64("aGVsbG8=").as_deref(), Some(&b"hello"[..]));
        assert_eq!(base64("a b"), None);
        assert_eq!(percent("a%20b%"), "a b%");
    }
}
