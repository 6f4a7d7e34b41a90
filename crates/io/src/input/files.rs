//! Files, read with a limit, from folders or from memory. Only regular files are read: a pipe would be waited for, and a device has no end.

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
            Some(_) => Err(too_large(limit)),
            None => Err(unreadable(&std::io::ErrorKind::NotFound.into())),
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

/// A regular file, open, and its length in bytes; else what is wrong and what to do. Pipes, devices, sockets and folders are refused
/// before they are opened, since opening a pipe waits for the one that writes it.
pub(crate) fn open(path: &Path) -> Result<(File, u64), String> {
    let unreadable = |e: std::io::Error| unreadable(&e);
    let regular = |m: &std::fs::Metadata| match m.is_file() {
        true => Ok(()),
        false => Err("this is not a file; give the path of one".to_string()),
    };
    regular(&std::fs::metadata(path).map_err(unreadable)?)?;
    let file = File::open(path).map_err(unreadable)?;
    let meta = file.metadata().map_err(unreadable)?;
    regular(&meta)?;
    Ok((file, meta.len()))
}

/// The bytes of a regular file of at most `limit` bytes; else what is wrong and what to do.
pub(crate) fn read(path: &Path, limit: u64) -> Result<Vec<u8>, String> {
    let (file, length) = open(path)?;
    if length > limit {
        return Err(too_large(limit));
    }
    let mut bytes = Vec::new();
    let room = usize::try_from(length).ok().and_then(|n| bytes.try_reserve_exact(n).ok());
    room.ok_or_else(|| {
        format!("this file of {} MiB does not fit into memory; make it smaller", length >> 20)
    })?;
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(|e| unreadable(&e))?;
    if bytes.len() as u64 > limit {
        return Err(too_large(limit));
    }
    Ok(bytes)
}

fn too_large(limit: u64) -> String {
    format!("this file is larger than the {} MiB that are read; make it smaller", limit >> 20)
}

fn unreadable(e: &std::io::Error) -> String {
    match e.kind() {
        std::io::ErrorKind::NotFound => "there is no such file; check the path".to_string(),
        _ => format!("this file cannot be read ({e}); check the path and its permissions"),
    }
}
