//! Bounded reading of files, on disk or in memory, and arrays in their place.
//!
//! Only regular files are opened: opening a pipe blocks until its writer appears, and a device has no end.

use crate::file_stamps::FileRecord;
use crate::memory_arrays::{ArraysInMemory, MemoryArray};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Files in memory that a scene refers to, by their paths relative to the scene.
pub type FilesInMemory = BTreeMap<PathBuf, Vec<u8>>;

/// Storage of the files that a scene refers to, and the record of those that are read.
#[derive(Clone, Copy)]
pub(crate) struct FileSource<'a> {
    storage: Storage<'a>,
    record: Option<&'a FileRecord>,
}

#[derive(Clone, Copy)]
enum Storage<'a> {
    /// On disk.
    Disk,
    /// In memory.
    Memory(&'a FilesInMemory),
    /// On disk, but for these arrays.
    Arrays(&'a ArraysInMemory<'a>),
}

impl<'a> FileSource<'a> {
    /// Files on disk, without a record.
    pub(crate) const DISK: FileSource<'static> = FileSource { storage: Storage::Disk, record: None };

    /// Files on disk that are recorded.
    pub(crate) fn recorded(record: &'a FileRecord) -> FileSource<'a> {
        FileSource { storage: Storage::Disk, record: Some(record) }
    }
    /// Files in memory.
    pub(crate) fn memory(files: &'a FilesInMemory) -> FileSource<'a> {
        FileSource { storage: Storage::Memory(files), record: None }
    }
    /// Files on disk, but for these arrays.
    pub(crate) fn arrays(arrays: &'a ArraysInMemory<'a>) -> FileSource<'a> {
        FileSource { storage: Storage::Arrays(arrays), record: None }
    }
    /// The array that a path names in place of a file.
    pub(crate) fn array(self, path: &Path) -> Option<MemoryArray<'a>> {
        let Storage::Arrays(arrays) = self.storage else { return None };
        arrays.get(path)
    }
    /// The bytes of a file of at most `limit` bytes; an error states the defect and the remedy.
    pub(crate) fn read(self, path: &Path, limit: u64) -> Result<Vec<u8>, String> {
        let Storage::Memory(files) = self.storage else {
            self.record.iter().for_each(|r| r.add_opening(path));
            return read(path, limit);
        };
        match files.get(path) {
            Some(bytes) if bytes.len() as u64 <= limit => Ok(bytes.clone()),
            Some(_) => Err(too_large(limit)),
            None => Err(unreadable(&std::io::ErrorKind::NotFound.into())),
        }
    }
    /// True if a regular file of that name exists.
    pub(crate) fn contains(self, path: &Path) -> bool {
        match self.storage {
            Storage::Disk | Storage::Arrays(_) => {
                self.record.iter().for_each(|r| r.add(path));
                path.is_file()
            }
            Storage::Memory(files) => files.contains_key(path),
        }
    }
}

/// An open regular file and its length in bytes; an error states the defect and the remedy. Pipes, devices, sockets and folders are
/// refused before they are opened.
pub(crate) fn open(path: &Path) -> Result<(File, u64), String> {
    let failed = |e: std::io::Error| unreadable(&e);
    let check_regular = |m: &std::fs::Metadata| {
        if m.is_file() { Ok(()) } else { Err("this is not a file; give the path of one".to_string()) }
    };
    check_regular(&std::fs::metadata(path).map_err(failed)?)?;
    let file = File::open(path).map_err(failed)?;
    let meta = file.metadata().map_err(failed)?;
    check_regular(&meta)?;
    Ok((file, meta.len()))
}

/// The bytes of a regular file of at most `limit` bytes; an error states the defect and the remedy.
pub(crate) fn read(path: &Path, limit: u64) -> Result<Vec<u8>, String> {
    let (file, length) = open(path)?;
    if length > limit {
        return Err(too_large(limit));
    }
    let mut bytes = Vec::new();
    let reserved = usize::try_from(length).ok().and_then(|n| bytes.try_reserve_exact(n).ok());
    reserved.ok_or_else(|| {
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
