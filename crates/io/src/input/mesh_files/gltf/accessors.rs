//! Buffers, buffer views and accessors of a glTF document, with every bound checked.

use super::compression;
use super::container::resolve_uri;
use crate::files::FileSource;
use crate::input::reading::error::FileFault;
use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::{self, Root, validation::Checked};
use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;

/// The buffers of a document.
pub(crate) struct Buffers<'a> {
    pub(crate) file: &'a str,
    pub(crate) root: &'a Root,
    pub(crate) data: Vec<Cow<'a, [u8]>>,
    /// Decoded bytes of compressed buffer views.
    decoded: HashMap<usize, Vec<u8>>,
    /// Bytes of the JSON and of all buffers.
    pub(crate) size: usize,
}

impl<'a> Buffers<'a> {
    pub(crate) fn open(
        files: FileSource<'_>,
        file: &'a str,
        path: &Path,
        root: &'a Root,
        json: usize,
        binary: Option<&'a [u8]>,
    ) -> Result<Buffers<'a>, FileFault> {
        let mut data = Vec::new();
        for (i, b) in root.buffers.iter().enumerate() {
            let place = format!("buffer {i}");
            let bytes = match (&b.uri, binary) {
                _ if compression::is_fallback(b) => Cow::Borrowed(&[][..]),
                (Some(uri), _) => Cow::Owned(resolve_uri(files, file, path, &place, uri)?),
                (None, Some(binary)) if i == 0 => Cow::Borrowed(binary),
                _ => {
                    let message = "this buffer has no data; export the file again, with its .bin beside it";
                    return Err(FileFault::new(file, place, message));
                }
            };
            data.push(bytes);
        }
        let size = json + data.iter().map(|d| d.len()).sum::<usize>();
        let mut buffers = Buffers { file, root, data, decoded: HashMap::new(), size };
        buffers.decode_views()?;
        Ok(buffers)
    }

    /// Decodes the compressed buffer views.
    fn decode_views(&mut self) -> Result<(), FileFault> {
        let mut left = compression::max_decoded_bytes(self.size);
        for index in 0..self.root.buffer_views.len() {
            let fault = |message: String| FileFault::new(self.file, format!("buffer view {index}"), message);
            let Some(decoded) = compression::decode_view(self.root, index, &self.data) else { continue };
            let decoded = decoded.map_err(fault)?;
            let rest = left.checked_sub(decoded.len());
            left = rest.ok_or_else(|| {
                fault(
                    "the buffer views up to this one hold more than the file can; export the file again"
                        .into(),
                )
            })?;
            self.decoded.insert(index, decoded);
        }
        Ok(())
    }

    /// The bytes of a buffer view.
    pub(crate) fn view(
        &self,
        index: json::Index<json::buffer::View>,
        place: &str,
    ) -> Result<&[u8], FileFault> {
        if let Some(decoded) = self.decoded.get(&index.value()) {
            return Ok(decoded);
        }
        let range = || {
            let view = self.root.buffer_views.get(index.value())?;
            let start = view.byte_offset.map_or(0, |o| o.0 as usize);
            let end = start.checked_add(view.byte_length.0 as usize)?;
            self.data.get(view.buffer.value())?.get(start..end)
        };
        range().ok_or_else(|| {
            FileFault::new(
                self.file,
                place,
                format!(
                    "buffer view {} reaches beyond its buffer; copy or export the file again",
                    index.value()
                ),
            )
        })
    }

    /// The integer that stands for 1 in an accessor; 1 if its numbers stand for themselves.
    pub(crate) fn unit(&self, index: json::Index<Accessor>) -> f64 {
        let accessor = self.root.accessors.get(index.value()).filter(|a| a.normalized);
        match accessor.map(|a| a.component_type) {
            Some(Checked::Valid(component)) => ElementLayout::largest(component.0),
            _ => 1.0,
        }
    }

    /// An accessor's elements as numbers, each of `N` components.
    pub(crate) fn numbers<const N: usize>(
        &self,
        index: json::Index<Accessor>,
    ) -> Result<Vec<[f64; N]>, FileFault> {
        let place = format!("accessor {}", index.value());
        let fault = |message: &str| FileFault::new(self.file, &place, message);
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
        let layout = ElementLayout { component: component.0, normalized: accessor.normalized };
        // Read the dense elements.
        let mut out = self.dense_elements::<N>(accessor, layout, &place)?;
        // Replace the sparse elements.
        if let Some(sparse) = &accessor.sparse {
            self.replace_sparse(&mut out, sparse, layout, &place)?;
        }
        if let Some(i) = out.iter().position(|v| v.iter().any(|x| !x.is_finite())) {
            return Err(FileFault::new(
                self.file,
                format!("{place}, element {i}"),
                "this value is not a finite number; export the file again",
            ));
        }
        Ok(out)
    }

    /// The elements of an accessor without its sparse part.
    fn dense_elements<const N: usize>(
        &self,
        accessor: &Accessor,
        layout: ElementLayout,
        place: &str,
    ) -> Result<Vec<[f64; N]>, FileFault> {
        let fault = |message: &str| FileFault::new(self.file, place, message);
        let count = accessor.count.0 as usize;
        match accessor.buffer_view {
            Some(view) => {
                let stride = self.root.buffer_views.get(view.value());
                let stride = stride.and_then(|v| v.byte_stride.as_ref()).map(|s| s.0);
                let offset = accessor.byte_offset.map_or(0, |o| o.0 as usize);
                let data = self.view(view, place)?;
                layout.elements::<N>(data, offset, stride, count).ok_or_else(|| {
                    fault("this accessor reaches beyond its buffer view; copy or export the file again")
                })
            }
            // All zeros: at most as many as the file has bytes.
            None if count <= self.size => Ok(vec![[0.0; N]; count]),
            None => Err(fault("this accessor is too large; export the file again")),
        }
    }

    /// Replaces the elements that the sparse part of an accessor lists.
    fn replace_sparse<const N: usize>(
        &self,
        out: &mut [[f64; N]],
        sparse: &json::accessor::sparse::Sparse,
        layout: ElementLayout,
        place: &str,
    ) -> Result<(), FileFault> {
        let fault = |message: &str| FileFault::new(self.file, place, message);
        let n = sparse.count.0 as usize;
        let Checked::Valid(index_type) = sparse.indices.component_type else {
            return Err(fault("the sparse index type is not known; export the file again"));
        };
        let offset = |o: json::validation::USize64| o.0 as usize;
        let index_layout = ElementLayout { component: index_type.0, normalized: false };
        let index_data = self.view(sparse.indices.buffer_view, place)?;
        let indices = index_layout.elements::<1>(index_data, offset(sparse.indices.byte_offset), None, n);
        let value_data = self.view(sparse.values.buffer_view, place)?;
        let values = layout.elements::<N>(value_data, offset(sparse.values.byte_offset), None, n);
        let beyond = || fault("the sparse part reaches beyond its data; copy or export the file again");
        let (indices, values) = indices.zip(values).ok_or_else(beyond)?;
        for ([i], value) in indices.into_iter().zip(values) {
            *out.get_mut(i as usize).ok_or_else(beyond)? = value;
        }
        Ok(())
    }
}

/// Component type of an accessor's elements.
#[derive(Clone, Copy)]
struct ElementLayout {
    component: ComponentType,
    /// Integers stand for fractions of their largest value.
    normalized: bool,
}

impl ElementLayout {
    /// `count` elements from `offset` on; none if they reach beyond `data`.
    fn elements<const N: usize>(
        self,
        data: &[u8],
        offset: usize,
        stride: Option<usize>,
        count: usize,
    ) -> Option<Vec<[f64; N]>> {
        let size = self.component.size();
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
                self.value(&data[at..at + size])
            })
        };
        Some((0..count).map(element).collect())
    }

    /// The integer that stands for 1.
    fn largest(component: ComponentType) -> f64 {
        match component {
            ComponentType::I8 => 127.0,
            ComponentType::U8 => 255.0,
            ComponentType::I16 => 32767.0,
            ComponentType::U16 => 65535.0,
            ComponentType::U32 | ComponentType::F32 => 1.0,
        }
    }

    /// The value of a component's little-endian bytes.
    fn value(self, b: &[u8]) -> f64 {
        let bits = b.iter().rev().fold(0u32, |n, x| n << 8 | *x as u32);
        let value = match self.component {
            ComponentType::I8 => bits as u8 as i8 as f64,
            ComponentType::I16 => bits as u16 as i16 as f64,
            ComponentType::U8 | ComponentType::U16 | ComponentType::U32 => bits as f64,
            ComponentType::F32 => f32::from_bits(bits) as f64,
        };
        if self.normalized { (value / ElementLayout::largest(self.component)).max(-1.0) } else { value }
    }
}
