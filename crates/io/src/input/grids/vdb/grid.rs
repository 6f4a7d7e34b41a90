//! The table of contents of a file, and the head of one grid.

use super::bytes::{ByteCursor, SAVE_AGAIN};
use super::transform::LinearTransform;
use super::tree::{self, ValueBlock};
use super::values::{StoredPrecision, TreePrecision, ValueCodec};
use crate::input::reading::error::FileFault;

/// First bytes of a file.
pub(crate) const MAGIC: [u8; 8] = [0x20, 0x42, 0x44, 0x56, 0, 0, 0, 0];
/// The format versions that are read.
const VERSIONS: std::ops::RangeInclusive<u32> = 222..=225;
/// Bytes of the identifier in the header.
const UUID_BYTES: usize = 36;
/// Character between a grid's name and its number if several grids have one name.
const NAME_SEPARATOR: char = '\u{1e}';

/// An entry of the file's table of contents.
struct GridEntry {
    name: String,
    kind: String,
    stored: StoredPrecision,
    /// The grid whose tree this one shares; empty if it has its own.
    parent: String,
    start: i64,
    leaves: i64,
}

/// A grid of numbers, not yet read.
pub(crate) struct VdbGrid<'a> {
    /// Distances to a surface, negative inside.
    pub(crate) level_set: bool,
    pub(crate) transform: LinearTransform,
    codec: ValueCodec,
    topology: ByteCursor<'a>,
    leaves: ByteCursor<'a>,
}

impl VdbGrid<'_> {
    /// Calls `visit` on every tile and every leaf.
    pub(crate) fn scan(
        &self,
        visit: &mut dyn FnMut(&ValueBlock<'_>) -> Result<(), FileFault>,
    ) -> Result<(), FileFault> {
        tree::scan(self.topology.clone(), self.leaves.clone(), self.codec, visit)
    }
}

/// The grid of this name; without a name the only grid, or the one called `density`.
pub(crate) fn open_grid<'a>(
    file: &'a str,
    bytes: &'a [u8],
    wanted: Option<&str>,
) -> Result<(String, VdbGrid<'a>), FileFault> {
    let mut c = ByteCursor::new(file, bytes);
    let entries = read_contents(&mut c)?;
    let named = |name: &str| entries.iter().find(|e| e.name == name);
    let entry = match (wanted, entries.as_slice()) {
        (Some(name), _) => named(name),
        (None, [one]) => Some(one),
        (None, _) => named("density"),
    };
    let Some(entry) = entry else {
        let names: Vec<String> = entries.iter().take(20).map(|e| format!("'{:.60}'", e.name)).collect();
        let names = if names.is_empty() { "none".to_string() } else { names.join(", ") };
        let wanted = wanted.unwrap_or("density");
        return Err(FileFault::new(file, "", format!("there is no grid '{wanted}'; its grids are {names}")));
    };
    Ok((entry.name.clone(), entry.open(&c)?))
}

/// Reads the header and the table of contents.
fn read_contents(c: &mut ByteCursor<'_>) -> Result<Vec<GridEntry>, FileFault> {
    c.take(MAGIC.len())?;
    let version = c.u32()?;
    if !VERSIONS.contains(&version) {
        return Err(c.fault(format!(
            "this is version {version} of the format, and {} to {} are read; save it again with another OpenVDB",
            VERSIONS.start(),
            VERSIONS.end()
        )));
    }
    let (_major, _minor) = (c.u32()?, c.u32()?);
    if c.u8()? == 0 {
        return Err(c.fault("this is a stream without a table of contents; save it as a file"));
    }
    c.take(UUID_BYTES)?;
    read_metadata(c)?;
    let count = c.u32()?;
    let mut entries = Vec::new();
    for _ in 0..count {
        let (e, end) = GridEntry::read(c)?;
        // Require ascending offsets, so that the table ends.
        if end <= c.position() as i64 && entries.len() + 1 < count as usize {
            return Err(c.fault(format!("the table of contents runs backward; {SAVE_AGAIN}")));
        }
        *c = c.seek(end.min(c.length() as i64))?;
        entries.push(e);
    }
    Ok(entries)
}

/// Skips metadata; returns the value of `class`.
fn read_metadata(c: &mut ByteCursor<'_>) -> Result<Option<String>, FileFault> {
    let mut class = None;
    for _ in 0..c.u32()? {
        let (name, _kind) = (c.text()?, c.text()?);
        let n = c.u32()? as usize;
        let value = c.take(n)?;
        if name == "class" {
            class = Some(String::from_utf8_lossy(value).into_owned());
        }
    }
    Ok(class)
}

impl GridEntry {
    /// Reads an entry, and the offset of the next one.
    fn read(c: &mut ByteCursor<'_>) -> Result<(GridEntry, i64), FileFault> {
        let name = c.text()?;
        let name = name.split(NAME_SEPARATOR).next().unwrap_or_default().to_string();
        let kind = c.text()?;
        let (kind, stored) = match kind.strip_suffix("_HalfFloat") {
            Some(kind) => (kind.to_string(), StoredPrecision::Half),
            None => (kind, StoredPrecision::Full),
        };
        let parent = c.text()?;
        let (start, leaves, end) = (c.i64()?, c.i64()?, c.i64()?);
        Ok((GridEntry { name, kind, stored, parent, start, leaves }, end))
    }
    /// Reads the head of the grid, up to its tree.
    fn open<'a>(&self, file: &ByteCursor<'a>) -> Result<VdbGrid<'a>, FileFault> {
        let mut c = file.seek(self.start)?;
        let name = &self.name;
        let precision = match self.kind.as_str() {
            "Tree_float_5_4_3" => TreePrecision::Float,
            "Tree_double_5_4_3" => TreePrecision::Double,
            kind => {
                return Err(c.fault(format!(
                    "the grid '{name:.60}' is a {kind:.60}, and only Tree_float_5_4_3 and Tree_double_5_4_3 are read; \
                     name another grid, or convert this one to floats"
                )));
            }
        };
        if !self.parent.is_empty() {
            let parent = self.parent.replace(NAME_SEPARATOR, " ");
            return Err(c.fault(format!(
                "the grid '{name:.60}' has no values of its own; name the one that it repeats, '{parent:.60}'"
            )));
        }
        let codec = ValueCodec::read(&mut c, self.stored, precision)?;
        let class = read_metadata(&mut c)?;
        let transform = LinearTransform::read(&mut c)?;
        let level_set = class.is_some_and(|c| c == "level set");
        Ok(VdbGrid { level_set, transform, codec, leaves: file.seek(self.leaves)?, topology: c })
    }
}
