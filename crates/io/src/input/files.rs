//! Files, read with a limit, from folders or from memory.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// A scene's referenced files in memory, by their paths relative to it.
pub type FilesInMemory = BTreeMap<PathBuf, Vec<u8>>;

/// Where the files that a scene refers to are found.
#[derive(Clone, Copy)]
pub(crate) enum Files<'a> {
    /// On disk.
    Disk,
    /// In memory.
    Memory(&'a FilesInMemory),
}

impl Files<'_> {
    /// The bytes of a file of at most `limit` bytes; else what is wrong and what to do.
    pub(crate) fn read(self, path: &Path, limit: u64) -> Result<Vec<u8>, String> {
        let Files::Memory(files) = self else { return read(path, limit) };
        match files.get(path) {
            Some(bytes) if bytes.len() as u64 <= limit => Ok(bytes.clone()),
            Some(_) => Err(format!(
                "this file is larger than the {} MiB that are read; make it smaller",
                limit >> 20
            )),
            None => Err("there is no such file; check the path".to_string()),
        }
    }
    /// True where there is a regular file of that name.
    pub(crate) fn has(self, path: &Path) -> bool {
        match self {
            Files::Disk => path.is_file(),
            Files::Memory(files) => files.contains_key(path),
        }
    }
}

/// The bytes of a regular file of at most `limit` bytes; else what is wrong and what to do.
pub(crate) fn read(path: &Path, limit: u64) -> Result<Vec<u8>, String> {
    let unreadable = |e: std::io::Error| match e.kind() {
        std::io::ErrorKind::NotFound => "there is no such file; check the path".to_string(),
        _ => format!("this file cannot be read ({e}); check the path and its permissions"),
    };
    let meta = std::fs::metadata(path).map_err(unreadable)?;
    if !meta.is_file() {
        return Err("this is not a file; give the path of one".to_string());
    }
    let too_large =
        || format!("this file is larger than the {} MiB that are read; make it smaller", limit >> 20);
    if meta.len() > limit {
        return Err(too_large());
    }
    let mut bytes = Vec::with_capacity(meta.len() as usize);
    let file = File::open(path).map_err(unreadable)?;
    file.take(limit + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > limit {
        return Err(too_large());
    }
    Ok(bytes)
}
