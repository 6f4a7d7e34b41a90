//! OpenVDB files: sparse grids of floats or doubles, in full or in half precision.
//!
//! | module | what |
//! |---|---|
//! | `bytes` | a place in the file; reads that end with the file |
//! | `blosc`, `values` | packed values of a node |
//! | `tree` | the tree 5-4-3, shown block by block |
//! | `map` | from indices to lengths |
//! | `fill` | onto the cells of the medium, keeping the sum |
//!
//! Read: files with offsets (as `File::write` makes them), format versions 222 (OpenVDB 2.0) to 225. A file is read where
//! it lies in memory; what it unpacks to is at most one node (32³ values) at a time, so a small file cannot take much
//! memory. Its work is bounded too: blocks are disjoint by construction.
//!
//! Reference: the format has no description but its writer, openvdb/io in <https://github.com/AcademySoftwareFoundation/openvdb>.

mod blosc;
mod bytes;
pub(crate) mod fill;
mod map;
mod tree;
mod values;

use super::error::Fault;
use bytes::{Cursor, SAVE_AGAIN};
use map::Map;
use tree::Block;
use values::Coding;

/// How a file begins.
const MAGIC: [u8; 8] = [0x20, 0x42, 0x44, 0x56, 0, 0, 0, 0];
/// The format versions that are read.
const VERSIONS: std::ops::RangeInclusive<u32> = 222..=225;
/// Bytes of the identifier in the header.
const UUID: usize = 36;
/// What stands between a grid's name and its number where several have one name.
const SEPARATOR: char = '\u{1e}';

/// True for the bytes of an OpenVDB file.
pub(crate) fn is_vdb(bytes: &[u8]) -> bool {
    bytes.starts_with(&MAGIC)
}

/// An entry of the file's table of contents.
struct Entry {
    name: String,
    kind: String,
    half: bool,
    /// The grid that has this one's tree, where it has none of its own.
    parent: String,
    start: i64,
    leaves: i64,
}

/// A grid of numbers, not yet read.
pub(crate) struct VdbGrid<'a> {
    /// Distances to a surface, negative inside.
    pub(crate) level_set: bool,
    pub(crate) map: Map,
    coding: Coding,
    topology: Cursor<'a>,
    leaves: Cursor<'a>,
}

impl VdbGrid<'_> {
    /// Shows every tile and every leaf to `visit`.
    pub(crate) fn scan(&self, visit: &mut dyn FnMut(&Block<'_>) -> Result<(), Fault>) -> Result<(), Fault> {
        tree::scan(self.topology.clone(), self.leaves.clone(), self.coding, visit)
    }
}

/// The grid of this name; without one the only grid, or the one called `density`.
pub(crate) fn open<'a>(
    file: &'a str,
    bytes: &'a [u8],
    wanted: Option<&str>,
) -> Result<(String, VdbGrid<'a>), Fault> {
    let mut c = Cursor::new(file, bytes);
    let entries = contents(&mut c)?;
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
        return Err(Fault::new(file, "", format!("there is no grid '{wanted}'; its grids are {names}")));
    };
    Ok((entry.name.clone(), entry.open(&c)?))
}

/// Reads the header and the table of contents.
fn contents(c: &mut Cursor<'_>) -> Result<Vec<Entry>, Fault> {
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
    c.take(UUID)?;
    metadata(c)?;
    let count = c.u32()?;
    let mut entries = Vec::new();
    for _ in 0..count {
        let (e, end) = Entry::read(c)?;
        // Always forward, so that the table has an end.
        if end <= c.position() as i64 && entries.len() + 1 < count as usize {
            return Err(c.fault(format!("the table of contents runs backward; {SAVE_AGAIN}")));
        }
        *c = c.seek(end.min(c.length() as i64))?;
        entries.push(e);
    }
    Ok(entries)
}

/// Skips metadata; gives the value of `class`.
fn metadata(c: &mut Cursor<'_>) -> Result<Option<String>, Fault> {
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

impl Entry {
    /// An entry, and where the next one begins.
    fn read(c: &mut Cursor<'_>) -> Result<(Entry, i64), Fault> {
        let name = c.text()?;
        let name = name.split(SEPARATOR).next().unwrap_or_default().to_string();
        let kind = c.text()?;
        let (kind, half) = match kind.strip_suffix("_HalfFloat") {
            Some(kind) => (kind.to_string(), true),
            None => (kind, false),
        };
        let parent = c.text()?;
        let (start, leaves, end) = (c.i64()?, c.i64()?, c.i64()?);
        Ok((Entry { name, kind, half, parent, start, leaves }, end))
    }
    /// Reads up to the tree.
    fn open<'a>(&self, file: &Cursor<'a>) -> Result<VdbGrid<'a>, Fault> {
        let mut c = file.seek(self.start)?;
        let name = &self.name;
        let double = match self.kind.as_str() {
            "Tree_float_5_4_3" => false,
            "Tree_double_5_4_3" => true,
            kind => {
                return Err(c.fault(format!(
                    "the grid '{name:.60}' is a {kind:.60}, and only Tree_float_5_4_3 and Tree_double_5_4_3 are read; \
                     name another grid, or convert this one to floats"
                )));
            }
        };
        if !self.parent.is_empty() {
            let parent = self.parent.replace(SEPARATOR, " ");
            return Err(c.fault(format!(
                "the grid '{name:.60}' has no values of its own; name the one that it repeats, '{parent:.60}'"
            )));
        }
        let coding = Coding::read(&mut c, self.half, double)?;
        let class = metadata(&mut c)?;
        let map = Map::read(&mut c)?;
        let level_set = class.is_some_and(|c| c == "level set");
        Ok(VdbGrid { level_set, map, coding, leaves: file.seek(self.leaves)?, topology: c })
    }
}
