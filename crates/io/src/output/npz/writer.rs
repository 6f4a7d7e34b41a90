//! Writing of arrays into an npz: a zip of npy files, stored uncompressed, so that files are read and written at the speed of memory.

use super::npy::{self, ElementType};
use std::io::{self, Seek, Write};
use zip::{CompressionMethod, ZipWriter, write::SimpleFileOptions};
use zonal_math::Vec3;
use zonal_scene::{Bands, Plate, PlateKind, ZoneValues};

/// Bytes of a block that is gathered before it is written.
const BLOCK_BYTES: usize = 1 << 16;

/// An npz that is written entry by entry.
pub(crate) struct NpzWriter<W: Write + Seek>(ZipWriter<W>);

impl<W: Write + Seek> NpzWriter<W> {
    pub(crate) fn new(out: W) -> NpzWriter<W> {
        NpzWriter(ZipWriter::new(out))
    }

    pub(crate) fn finish(self) -> io::Result<()> {
        self.0.finish().map_err(io::Error::other)?.flush()
    }

    fn begin(&mut self, name: &str, kind: ElementType, shape: &[usize]) -> io::Result<()> {
        let bytes = kind.size() * shape.iter().product::<usize>();
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .large_file(bytes > 1 << 31);
        self.0.start_file(format!("{name}.npy"), options).map_err(io::Error::other)?;
        self.0.write_all(&npy::header(kind, shape))
    }

    /// Streams elements of `N` bytes, a block at a time.
    fn stream<const N: usize>(&mut self, items: impl Iterator<Item = [u8; N]>) -> io::Result<()> {
        let mut block = vec![[0; N]; BLOCK_BYTES / N];
        let mut filled = 0;
        for item in items {
            block[filled] = item;
            filled += 1;
            if filled == block.len() {
                self.0.write_all(block.as_flattened())?;
                filled = 0;
            }
        }
        self.0.write_all(block[..filled].as_flattened())
    }

    pub(crate) fn bytes(&mut self, name: &str, data: &[u8]) -> io::Result<()> {
        self.begin(name, ElementType::U8, &[data.len()])?;
        self.0.write_all(data)
    }

    pub(crate) fn ints(&mut self, name: &str, data: impl ExactSizeIterator<Item = usize>) -> io::Result<()> {
        self.begin(name, ElementType::I64, &[data.len()])?;
        self.stream(data.map(|n| (n as i64).to_le_bytes()))
    }

    pub(crate) fn reals(&mut self, name: &str, data: impl ExactSizeIterator<Item = f64>) -> io::Result<()> {
        self.begin(name, ElementType::F64, &[data.len()])?;
        self.stream(data.map(f64::to_le_bytes))
    }

    /// An array of single precision.
    pub(crate) fn singles(
        &mut self,
        name: &str,
        shape: &[usize],
        data: impl Iterator<Item = f32>,
    ) -> io::Result<()> {
        self.begin(name, ElementType::F32, shape)?;
        self.stream(data.map(f32::to_le_bytes))
    }

    /// An array of shape `[..shape, 3]`.
    pub(crate) fn triples(
        &mut self,
        name: &str,
        shape: &[usize],
        data: impl Iterator<Item = [f64; 3]>,
    ) -> io::Result<()> {
        self.begin(name, ElementType::F64, &[shape, &[3]].concat())?;
        self.stream(data.flatten().map(f64::to_le_bytes))
    }

    /// Bands of zones, an array of shape `[zones, 3]`.
    pub(crate) fn bands(&mut self, name: &str, zones: &[Bands]) -> io::Result<()> {
        self.triples(name, &[zones.len()], zones.iter().map(|x| x.to_rgb()))
    }

    /// As [`NpzWriter::triples`], in one row of shape `[1, …, 3]` if all rows are equal: numpy broadcasts it.
    pub(crate) fn rows(
        &mut self,
        name: &str,
        shape: &[usize],
        data: impl Iterator<Item = [f64; 3]> + Clone,
    ) -> io::Result<()> {
        let mut all = data.clone();
        match all.next() {
            Some(first) if all.all(|x| x.map(f64::to_bits) == first.map(f64::to_bits)) => {
                self.triples(name, &vec![1; shape.len()], std::iter::once(first))
            }
            _ => self.triples(name, shape, data),
        }
    }

    /// As [`NpzWriter::rows`], of bands.
    pub(crate) fn band_rows(
        &mut self,
        name: &str,
        shape: &[usize],
        data: impl Iterator<Item = Bands> + Clone,
    ) -> io::Result<()> {
        self.rows(name, shape, data.map(Bands::to_rgb))
    }

    /// The values of a light group, `[zones, 3]` of f64 or f32; no rows for zeros.
    pub(crate) fn values(&mut self, name: &str, values: &ZoneValues) -> io::Result<()> {
        match values {
            ZoneValues::Double(v) => self.bands(name, v),
            ZoneValues::Single(v) => {
                self.begin(name, ElementType::F32, &[v.len(), 3])?;
                self.stream(v.iter().flatten().map(|x| x.to_le_bytes()))
            }
        }
    }

    pub(crate) fn vectors(
        &mut self,
        name: &str,
        data: impl ExactSizeIterator<Item = Vec3>,
    ) -> io::Result<()> {
        self.triples(name, &[data.len()], data.map(Vec3::array))
    }

    /// An array of shape `[..shape]` of f64.
    pub(crate) fn grid(
        &mut self,
        name: &str,
        shape: &[usize],
        data: impl Iterator<Item = f64>,
    ) -> io::Result<()> {
        self.begin(name, ElementType::F64, shape)?;
        self.stream(data.map(f64::to_le_bytes))
    }

    /// An array of shape `[height, width, 3]` of f32.
    pub(crate) fn picture(
        &mut self,
        name: &str,
        width: usize,
        height: usize,
        data: &[[f32; 3]],
    ) -> io::Result<()> {
        self.begin(name, ElementType::F32, &[height, width, 3])?;
        self.stream(data.iter().flatten().map(|x| x.to_le_bytes()))
    }

    /// `<name>_origin`, `<name>_e1`, `<name>_e2` and `<name>_kind` (0 triangle, 1 parallelogram).
    pub(crate) fn plates<'a, I>(&mut self, name: &str, plates: I) -> io::Result<()>
    where
        I: ExactSizeIterator<Item = &'a Plate> + Clone,
    {
        self.vectors(&format!("{name}_origin"), plates.clone().map(|p| p.origin))?;
        self.vectors(&format!("{name}_e1"), plates.clone().map(|p| p.e1))?;
        self.vectors(&format!("{name}_e2"), plates.clone().map(|p| p.e2))?;
        let kinds: Vec<u8> = plates.map(|p| (p.kind == PlateKind::Parallelogram) as u8).collect();
        self.bytes(&format!("{name}_kind"), &kinds)
    }
}
