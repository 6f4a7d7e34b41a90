//! Writing of arrays into an npz: a zip of npy files, stored uncompressed, so that files are read and written at the speed of memory.
//!
//! Large arrays are gathered by all threads, in pieces of a few megabytes, while one thread writes the piece before: bytes keep their order.

use super::npy::{self, ElementType};
use std::borrow::Cow;
use std::io::{self, Seek, SeekFrom, Write};
use zip::{CompressionMethod, ZipWriter, write::SimpleFileOptions};
use zonal_math::{Vec3, parallel};
use zonal_scene::{BandSet, Bands, Plate, PlateKind, ZoneValues};

/// Bytes of a piece that is gathered before it is written.
const PIECE_BYTES: usize = 1 << 22;
/// Bytes of a piece that one thread gathers at a time.
const TASK_BYTES: usize = 1 << 16;

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
pub(crate) trait ArraySink: Send {
    /// Begins an array whose values take `bytes` bytes.
    fn begin(&mut self, name: &str, bytes: usize) -> io::Result<()>;
    /// Adds bytes to the array.
    fn add(&mut self, bytes: &[u8]) -> io::Result<()>;
}

/// A zip of arrays.
pub(crate) struct Archive<W: Write + Seek> {
    zip: ZipWriter<FailsOnce<W>>,
}

impl<W: Write + Seek + Send> ArraySink for Archive<W> {
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
        self.update_rayon(bytes);
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

impl<W: Write + Seek + Send> NpzWriter<W> {
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

    /// Adds rows of `row_bytes` bytes, which `fill` writes by their number.
    fn rows_of_bytes(
        &mut self,
        rows: usize,
        row_bytes: usize,
        fill: impl Fn(usize, &mut [u8]) + Sync,
    ) -> io::Result<()> {
        if row_bytes == 0 || rows == 0 {
            return Ok(());
        }
        let (rows_of_task, rows_of_piece) =
            ((TASK_BYTES / row_bytes).max(1), (PIECE_BYTES / row_bytes).max(1));
        let gather = |first: usize, mut piece: Vec<u8>| {
            piece.resize(row_bytes * rows_of_piece.min(rows - first), 0);
            parallel::chunks(&mut piece, rows_of_task * row_bytes, |task, chunk| {
                for (k, row) in chunk.chunks_exact_mut(row_bytes).enumerate() {
                    fill(first + task * rows_of_task + k, row);
                }
            });
            piece
        };
        let (mut piece, mut spare) = (gather(0, Vec::new()), Vec::new());
        for next in (rows_of_piece..rows).step_by(rows_of_piece) {
            let sink = &mut self.sink;
            let (written, following) = parallel::join(|| sink.add(&piece), || gather(next, spare));
            written?;
            (spare, piece) = (piece, following);
        }
        self.sink.add(&piece)
    }

    /// Adds elements of `N` bytes by their number.
    fn elements<const N: usize>(
        &mut self,
        count: usize,
        element: impl Fn(usize) -> [u8; N] + Sync,
    ) -> io::Result<()> {
        self.rows_of_bytes(count, N, |i, out| out.copy_from_slice(&element(i)))
    }

    /// Adds the first bands of each row, as many as each block has columns; `value` gives those of block t in row i.
    fn rows_of_bands<const N: usize>(
        &mut self,
        rows: usize,
        columns_of_blocks: &[usize],
        value: impl Fn(usize, usize) -> Bands + Sync,
        to_bytes: impl Fn(f64) -> [u8; N] + Sync,
    ) -> io::Result<()> {
        let columns: usize = columns_of_blocks.iter().sum();
        self.rows_of_bytes(rows, N * columns, |i, mut row| {
            for (t, count) in columns_of_blocks.iter().enumerate() {
                let (own, rest) = row.split_at_mut(N * count);
                let bytes = value(t, i).map(&to_bytes);
                own.as_chunks_mut::<N>().0.iter_mut().zip(&bytes).for_each(|(out, b)| *out = *b);
                row = rest;
            }
        })
    }

    pub(crate) fn bytes(&mut self, name: &str, data: &[u8]) -> io::Result<()> {
        self.begin(name, ElementType::U8, &[data.len()])?;
        self.sink.add(data)
    }

    /// Whole numbers by their index.
    pub(crate) fn ints(
        &mut self,
        name: &str,
        count: usize,
        value: impl Fn(usize) -> usize + Sync,
    ) -> io::Result<()> {
        self.begin(name, ElementType::I64, &[count])?;
        self.elements(count, |i| (value(i) as i64).to_le_bytes())
    }

    /// Whole numbers of 32 bits by their index.
    pub(crate) fn short_ints(
        &mut self,
        name: &str,
        count: usize,
        value: impl Fn(usize) -> i32 + Sync,
    ) -> io::Result<()> {
        self.begin(name, ElementType::I32, &[count])?;
        self.elements(count, |i| value(i).to_le_bytes())
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
        escape: impl Fn(&str) -> Cow<'_, str> + Sync,
    ) -> io::Result<()> {
        let chars = data.iter().map(|text| escape(text).chars().take(max_chars).count()).max();
        let chars = chars.unwrap_or(1).max(1);
        self.begin(name, ElementType::Text(chars), &[data.len()])?;
        self.rows_of_bytes(data.len(), 4 * chars, |i, row| {
            let text = escape(&data[i]);
            let codes = text.chars().map(u32::from).chain(std::iter::repeat(0));
            row.as_chunks_mut::<4>().0.iter_mut().zip(codes).for_each(|(out, c)| *out = c.to_le_bytes());
        })
    }

    /// As [`ArrayWriter::reals`], of shape `[1]` if all are equal.
    pub(crate) fn reals_or_one(
        &mut self,
        name: &str,
        count: usize,
        value: impl Fn(usize) -> f64 + Sync,
    ) -> io::Result<()> {
        let shape = broadcast_shape(&[count], |i| value(i).to_bits());
        self.grid(name, &shape, value)
    }

    /// Real numbers by their index.
    pub(crate) fn reals(
        &mut self,
        name: &str,
        count: usize,
        value: impl Fn(usize) -> f64 + Sync,
    ) -> io::Result<()> {
        self.grid(name, &[count], value)
    }

    /// An array of single precision, by the index in C order.
    pub(crate) fn singles(
        &mut self,
        name: &str,
        shape: &[usize],
        value: impl Fn(usize) -> f32 + Sync,
    ) -> io::Result<()> {
        self.begin(name, ElementType::F32, shape)?;
        self.elements(shape.iter().product(), |i| value(i).to_le_bytes())
    }

    /// An array of shape `[..shape, 3]`, by the index of the row.
    pub(crate) fn triples(
        &mut self,
        name: &str,
        shape: &[usize],
        row: impl Fn(usize) -> [f64; 3] + Sync,
    ) -> io::Result<()> {
        self.begin(name, ElementType::F64, &[shape, &[3]].concat())?;
        self.rows_of_bytes(shape.iter().product(), 24, |i, out| {
            let bytes = row(i).map(f64::to_le_bytes);
            out.copy_from_slice(bytes.as_flattened());
        })
    }

    /// Number of bands.
    fn band_count(&self) -> usize {
        self.bands_of_blocks.iter().sum()
    }

    /// Bands of zones, an array of shape `[zones, bands]` with at least `least` rows, from those of each block; an empty block stands for zeros. One column if
    /// all bands are equal.
    pub(crate) fn bands(&mut self, name: &str, blocks: &[&[Bands]], least: usize) -> io::Result<()> {
        let zones = blocks.iter().map(|t| t.len()).fold(least, usize::max);
        let value = |t: usize, i: usize| if blocks[t].is_empty() { Bands::ZERO } else { blocks[t][i] };
        self.band_array(name, ElementType::F64, &[zones], value)
    }

    /// An array of shape `[..shape, bands]`, or `[..shape, 1]` if the bands of each row are equal: numpy broadcasts it.
    fn band_array(
        &mut self,
        name: &str,
        kind: ElementType,
        shape: &[usize],
        value: impl Fn(usize, usize) -> Bands + Sync,
    ) -> io::Result<()> {
        let rows: usize = shape.iter().product();
        let is_grey = self.bands_of_blocks == [3]
            && rows > 0
            && !parallel::any(rows, |i| value(0, i).any(|x| x.to_bits() != value(0, i).first().to_bits()));
        let columns = if is_grey { 1 } else { self.band_count() };
        self.begin(name, kind, &[shape, &[columns]].concat())?;
        let columns_of_blocks = if is_grey { vec![1] } else { self.bands_of_blocks.clone() };
        match kind {
            ElementType::F32 => {
                self.rows_of_bands(rows, &columns_of_blocks, value, |x| (x as f32).to_le_bytes())
            }
            _ => self.rows_of_bands(rows, &columns_of_blocks, value, f64::to_le_bytes),
        }
    }

    /// As [`ArrayWriter::triples`], in one row of shape `[1, …, 3]` if all rows are equal: numpy broadcasts it.
    pub(crate) fn rows(
        &mut self,
        name: &str,
        shape: &[usize],
        row: impl Fn(usize) -> [f64; 3] + Sync,
    ) -> io::Result<()> {
        let shape = broadcast_shape(shape, |i| row(i).map(f64::to_bits));
        self.triples(name, &shape, row)
    }

    /// As [`ArrayWriter::rows`], of the bands of row `i` of block `t`, which `value` gives.
    pub(crate) fn band_rows(
        &mut self,
        name: &str,
        shape: &[usize],
        value: impl Fn(usize, usize) -> Bands + Sync,
    ) -> io::Result<()> {
        let blocks = self.bands_of_blocks.len();
        let shape = (0..blocks).fold(vec![1; shape.len()], |found, t| {
            if found == shape { found } else { broadcast_shape(shape, |i| value(t, i).map(f64::to_bits)) }
        });
        self.band_array(name, ElementType::F64, &shape, value)
    }

    /// The values of a light group, `[zones, bands]` of f64, or of f32 if every block has single precision; no rows for zeros.
    pub(crate) fn values(&mut self, name: &str, blocks: &[&ZoneValues]) -> io::Result<()> {
        let zones = blocks.iter().map(|v| v.len()).max().unwrap_or(0);
        let is_single = blocks.iter().all(|v| matches!(v, ZoneValues::Single(_)));
        let kind = if is_single { ElementType::F32 } else { ElementType::F64 };
        self.band_array(name, kind, &[zones], |t, i| blocks[t].at(i))
    }

    /// Vectors by their index.
    pub(crate) fn vectors(
        &mut self,
        name: &str,
        count: usize,
        vector: impl Fn(usize) -> Vec3 + Sync,
    ) -> io::Result<()> {
        self.triples(name, &[count], |i| vector(i).array())
    }

    /// An array of f64, by the index in C order.
    pub(crate) fn grid(
        &mut self,
        name: &str,
        shape: &[usize],
        value: impl Fn(usize) -> f64 + Sync,
    ) -> io::Result<()> {
        self.begin(name, ElementType::F64, shape)?;
        self.elements(shape.iter().product(), |i| value(i).to_le_bytes())
    }

    /// An array of shape `[height, width, 3]` of f32.
    pub(crate) fn picture(
        &mut self,
        name: &str,
        width: usize,
        height: usize,
        data: &[[f32; 3]],
    ) -> io::Result<()> {
        let data = data.as_flattened();
        self.singles(name, &[height, width, 3], |i| data[i])
    }

    /// `<name>_origin`, `<name>_e1`, `<name>_e2` and `<name>_kind` (0 triangle, 1 parallelogram).
    pub(crate) fn plates<'a>(
        &mut self,
        name: &str,
        count: usize,
        plate: impl Fn(usize) -> &'a Plate + Sync,
    ) -> io::Result<()> {
        self.vectors(&format!("{name}_origin"), count, |i| plate(i).origin)?;
        self.vectors(&format!("{name}_e1"), count, |i| plate(i).e1)?;
        self.vectors(&format!("{name}_e2"), count, |i| plate(i).e2)?;
        self.begin(&format!("{name}_kind"), ElementType::U8, &[count])?;
        self.elements(count, |i| [u8::from(plate(i).kind == PlateKind::Parallelogram)])
    }
}

/// The shape of an array, or `[1, …]` if it has rows and all of them are equal.
fn broadcast_shape<T: PartialEq + Sync>(shape: &[usize], row: impl Fn(usize) -> T + Sync) -> Vec<usize> {
    let rows: usize = shape.iter().product();
    if rows == 0 {
        return shape.to_vec();
    }
    let first = row(0);
    // Rows that differ do so early, as a rule.
    let differs = row(rows - 1) != first || parallel::any(rows, |i| row(i) != first);
    if differs { shape.to_vec() } else { vec![1; shape.len()] }
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
            npz.reals("a", 40, |_| 1.0)?;
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
