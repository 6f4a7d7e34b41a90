//! Writing of arrays into an npz: a zip of npy files, stored uncompressed, so that files are read and written at the speed of memory.

use super::npy::{self, ElementType};
use std::borrow::Cow;
use std::io::{self, Seek, SeekFrom, Write};
use zip::{CompressionMethod, ZipWriter, write::SimpleFileOptions};
use zonal_math::Vec3;
use zonal_scene::{BandSet, Bands, Plate, PlateKind, ZoneValues};

/// Bytes of a block that is gathered before it is written.
const BLOCK_BYTES: usize = 1 << 16;

/// A file that reports its first error, and after it takes and drops all bytes: the crate zip completes an archive when it is dropped, and would print another error
/// where that fails.
struct FailsOnce<W> {
    out: W,
    has_failed: bool,
    /// Place of the next byte, and the end of the file, also of those that are dropped.
    position: u64,
    end: u64,
}

impl<W> FailsOnce<W> {
    fn new(out: W) -> FailsOnce<W> {
        FailsOnce { out, has_failed: false, position: 0, end: 0 }
    }

    fn call<T>(&mut self, of_failed: T, act: impl FnOnce(&mut W) -> io::Result<T>) -> io::Result<T> {
        if self.has_failed {
            return Ok(of_failed);
        }
        let result = act(&mut self.out);
        self.has_failed = result.as_ref().is_err_and(|e| e.kind() != io::ErrorKind::Interrupted);
        result
    }

    fn move_to(&mut self, position: u64) {
        self.position = position;
        self.end = self.end.max(position);
    }
}

impl<W: Write> Write for FailsOnce<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.call(bytes.len(), |out| out.write(bytes))?;
        self.move_to(self.position + written as u64);
        Ok(written)
    }
    fn flush(&mut self) -> io::Result<()> {
        self.call((), Write::flush)
    }
}

impl<W: Seek> Seek for FailsOnce<W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let of_failed = match to {
            SeekFrom::Start(n) => n,
            SeekFrom::Current(n) => self.position.saturating_add_signed(n),
            SeekFrom::End(n) => self.end.saturating_add_signed(n),
        };
        let position = self.call(of_failed, |out| out.seek(to))?;
        self.move_to(position);
        Ok(position)
    }
}

/// Destination of named arrays, one after the other.
pub(crate) trait ArraySink {
    /// Begins an array whose values take `bytes` bytes.
    fn begin(&mut self, name: &str, bytes: usize) -> io::Result<()>;
    /// Adds bytes to the array.
    fn add(&mut self, bytes: &[u8]) -> io::Result<()>;
}

/// A zip of arrays.
pub(crate) struct Archive<W: Write + Seek> {
    zip: ZipWriter<FailsOnce<W>>,
}

impl<W: Write + Seek> ArraySink for Archive<W> {
    fn begin(&mut self, name: &str, bytes: usize) -> io::Result<()> {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .large_file(bytes > 1 << 31);
        self.zip.start_file(format!("{name}.npy"), options).map_err(io::Error::other)
    }
    fn add(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.zip.write_all(bytes)
    }
}

/// A hash over names and bytes of arrays; its calls do not fail.
impl ArraySink for blake3::Hasher {
    fn begin(&mut self, name: &str, _: usize) -> io::Result<()> {
        self.update(name.as_bytes());
        Ok(())
    }
    fn add(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.update(bytes);
        Ok(())
    }
}

/// An npz that is written entry by entry.
pub(crate) type NpzWriter<W> = ArrayWriter<Archive<W>>;

/// Writes arrays one after the other. Arrays of bands have one column for each band of a scene; their values are given by blocks of bands.
pub(crate) struct ArrayWriter<S> {
    pub(crate) sink: S,
    /// Bands of each block.
    bands_of_blocks: Vec<usize>,
}

impl<W: Write + Seek> NpzWriter<W> {
    /// For arrays of the bands of a scene.
    pub(crate) fn new(out: W, bands: &BandSet) -> NpzWriter<W> {
        ArrayWriter::into_sink(Archive { zip: ZipWriter::new(FailsOnce::new(out)) }, bands)
    }

    pub(crate) fn finish(self) -> io::Result<()> {
        self.sink.zip.finish().map_err(io::Error::other)?.flush()
    }
}

impl<S: ArraySink> ArrayWriter<S> {
    /// For arrays of the bands of a scene.
    pub(crate) fn into_sink(sink: S, bands: &BandSet) -> ArrayWriter<S> {
        let bands_of_blocks = (0..bands.block_count()).map(|t| bands.window(t).len()).collect();
        ArrayWriter { sink, bands_of_blocks }
    }

    fn begin(&mut self, name: &str, kind: ElementType, shape: &[usize]) -> io::Result<()> {
        self.sink.begin(name, kind.size() * shape.iter().product::<usize>())?;
        self.sink.add(&npy::header(kind, shape))
    }

    /// Streams elements of `N` bytes, a block at a time.
    fn stream<const N: usize>(&mut self, items: impl Iterator<Item = [u8; N]>) -> io::Result<()> {
        let mut block = vec![[0; N]; BLOCK_BYTES / N];
        let mut filled = 0;
        for item in items {
            block[filled] = item;
            filled += 1;
            if filled == block.len() {
                self.sink.add(block.as_flattened())?;
                filled = 0;
            }
        }
        self.sink.add(block[..filled].as_flattened())
    }

    /// Streams the bands of each row, a block at a time; `value` gives those of block t in row i.
    fn stream_bands<const N: usize>(
        &mut self,
        rows: usize,
        value: impl Fn(usize, usize) -> Bands,
        to_bytes: impl Fn(f64) -> [u8; N],
    ) -> io::Result<()> {
        let row_bytes = N * self.band_count();
        let mut block = Vec::with_capacity(BLOCK_BYTES + row_bytes);
        for i in 0..rows {
            for (t, count) in self.bands_of_blocks.iter().enumerate() {
                let bytes = value(t, i).map(&to_bytes);
                bytes.iter().take(*count).for_each(|b| block.extend_from_slice(b));
            }
            if block.len() >= BLOCK_BYTES {
                self.sink.add(&block)?;
                block.clear();
            }
        }
        self.sink.add(&block)
    }

    pub(crate) fn bytes(&mut self, name: &str, data: &[u8]) -> io::Result<()> {
        self.begin(name, ElementType::U8, &[data.len()])?;
        self.sink.add(data)
    }

    pub(crate) fn ints(&mut self, name: &str, data: impl ExactSizeIterator<Item = usize>) -> io::Result<()> {
        self.begin(name, ElementType::I64, &[data.len()])?;
        self.stream(data.map(|n| (n as i64).to_le_bytes()))
    }

    /// Whole numbers of 32 bits.
    pub(crate) fn short_ints(
        &mut self,
        name: &str,
        data: impl ExactSizeIterator<Item = i32>,
    ) -> io::Result<()> {
        self.begin(name, ElementType::I32, &[data.len()])?;
        self.stream(data.map(i32::to_le_bytes))
    }

    /// One text of ASCII characters, an array without dimensions.
    pub(crate) fn ascii(&mut self, name: &str, text: &str) -> io::Result<()> {
        self.begin(name, ElementType::Ascii(text.len()), &[])?;
        self.sink.add(text.as_bytes())
    }

    /// Texts of at most `max_chars` characters, as `escape` gives them; the rest is cut.
    pub(crate) fn texts(
        &mut self,
        name: &str,
        data: &[String],
        max_chars: usize,
        escape: impl Fn(&str) -> Cow<'_, str>,
    ) -> io::Result<()> {
        let chars = data.iter().map(|text| escape(text).chars().take(max_chars).count()).max();
        let chars = chars.unwrap_or(1).max(1);
        self.begin(name, ElementType::Text(chars), &[data.len()])?;
        let padded = |text: &String| {
            let mut codes: Vec<u32> = escape(text).chars().take(chars).map(u32::from).collect();
            codes.resize(chars, 0);
            codes
        };
        self.stream(data.iter().flat_map(padded).map(u32::to_le_bytes))
    }

    pub(crate) fn reals(&mut self, name: &str, data: impl ExactSizeIterator<Item = f64>) -> io::Result<()> {
        self.grid(name, &[data.len()], data)
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
        self.grid(name, &[shape, &[3]].concat(), data.flatten())
    }

    /// Number of bands.
    fn band_count(&self) -> usize {
        self.bands_of_blocks.iter().sum()
    }

    /// Bands of zones, an array of shape `[zones, bands]` with at least `least` rows, from those of each block; an empty block stands for zeros.
    pub(crate) fn bands(&mut self, name: &str, blocks: &[&[Bands]], least: usize) -> io::Result<()> {
        let zones = blocks.iter().map(|t| t.len()).fold(least, usize::max);
        self.begin(name, ElementType::F64, &[zones, self.band_count()])?;
        let value = |t: usize, i: usize| if blocks[t].is_empty() { Bands::ZERO } else { blocks[t][i] };
        self.stream_bands(zones, value, f64::to_le_bytes)
    }

    /// As [`ArrayWriter::triples`], in one row of shape `[1, …, 3]` if all rows are equal: numpy broadcasts it.
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

    /// As [`ArrayWriter::rows`], of the bands of row `i` of block `t`, which `value` gives.
    pub(crate) fn band_rows(
        &mut self,
        name: &str,
        shape: &[usize],
        value: impl Fn(usize, usize) -> Bands,
    ) -> io::Result<()> {
        let rows: usize = shape.iter().product();
        let bits = |t: usize, i: usize| value(t, i).map(f64::to_bits);
        let is_constant = |t: usize| {
            let first = bits(t, 0);
            (1..rows).all(|i| bits(t, i) == first)
        };
        let is_uniform = rows > 0 && (0..self.bands_of_blocks.len()).all(is_constant);
        let (shape, rows) = if is_uniform { (vec![1; shape.len()], 1) } else { (shape.to_vec(), rows) };
        self.begin(name, ElementType::F64, &[shape, vec![self.band_count()]].concat())?;
        self.stream_bands(rows, value, f64::to_le_bytes)
    }

    /// The values of a light group, `[zones, bands]` of f64, or of f32 if every block has single precision; no rows for zeros.
    pub(crate) fn values(&mut self, name: &str, blocks: &[&ZoneValues]) -> io::Result<()> {
        let zones = blocks.iter().map(|v| v.len()).max().unwrap_or(0);
        let is_single = blocks.iter().all(|v| matches!(v, ZoneValues::Single(_)));
        let kind = if is_single { ElementType::F32 } else { ElementType::F64 };
        self.begin(name, kind, &[zones, self.band_count()])?;
        let value = |t: usize, i: usize| blocks[t].at(i);
        if is_single {
            self.stream_bands(zones, value, |x| (x as f32).to_le_bytes())
        } else {
            self.stream_bands(zones, value, f64::to_le_bytes)
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
        self.singles(name, &[height, width, 3], data.iter().flatten().copied())
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A file with room for some bytes.
    struct FullDisk {
        file: io::Cursor<Vec<u8>>,
        room: usize,
    }

    impl Write for FullDisk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let end = self.file.position() as usize + bytes.len();
            if end > self.room { Err(io::ErrorKind::StorageFull.into()) } else { self.file.write(bytes) }
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    impl Seek for FullDisk {
        fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
            self.file.seek(to)
        }
    }

    #[test]
    fn an_archive_that_failed_completes_without_another_error() {
        let write = |npz: &mut NpzWriter<FullDisk>| {
            npz.reals("a", [1.0; 40].into_iter())?;
            npz.bytes("b", &[7; 90])
        };
        let (mut failures, mut complete) = (0, 0);
        for room in 0..1200 {
            let disk = FullDisk { file: io::Cursor::default(), room };
            let mut npz = NpzWriter::new(disk, &BandSet::default());
            if write(&mut npz).is_err() {
                failures += 1;
                // The archive finishes when it is dropped.
                let dropped = npz.sink.zip.finish().map(|_| ()).map_err(|e| e.to_string());
                assert_eq!(dropped, Ok(()), "{room}");
            } else {
                complete += usize::from(npz.finish().is_ok());
            }
        }
        assert!(failures > 400 && complete > 100, "{failures} {complete}");
    }
}
