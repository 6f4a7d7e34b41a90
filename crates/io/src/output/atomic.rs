//! Atomic replacement of files: write a temporary file beside the target (crate tempfile), then rename it.
//!
//! The steps, in this order, leave the old file or the new one after a kill or a power failure at any moment:
//!
//! 1. the target is the end of a chain of symbolic links; the links stay;
//! 2. a temporary file `.NAME.PID-RANDOM.partial` is created in the target's folder and locked for the life of its process;
//! 3. its bytes are written and synchronised (`fsync`), it is renamed, and the folder is synchronised;
//! 4. temporary files of the same target without a lock are removed: their process was killed.
//!
//! A lock ends with its process in every case, so that neither a reused process number nor another machine misleads step 4.
//!
//! The bytes of large files go to the disk while further ones are written ([`FlushedFile`]), so that the synchronisation in step 3 has little left to do.
//!
//! Devices, pipes and sockets (`/dev/stdout`, `/dev/null`, a FIFO) hold no old file: they get the bytes directly, all at once.

use super::error::FileError;
use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io::{self, BufWriter, Cursor, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;
use tempfile::NamedTempFile;

/// Largest number of symbolic links that are followed.
const MAX_SYMBOLIC_LINKS: usize = 40;
/// Number of temporary files created before the folder counts as not writable.
const MAX_CREATE_ATTEMPTS: usize = 100;
/// Random characters in the name of a temporary file.
const RANDOM_CHARS: usize = 6;
/// End of the name of a temporary file.
const SUFFIX: &str = ".partial";

/// Bytes after which a large file is flushed to the disk.
const FLUSH_INTERVAL: u64 = 1 << 26;

/// A temporary file whose bytes go to the disk while it is written.
pub(super) struct FlushedFile {
    file: NamedTempFile,
    /// Bytes since the last flush began.
    since_flush: u64,
    flush: Option<JoinHandle<()>>,
}

impl FlushedFile {
    fn new(file: NamedTempFile) -> FlushedFile {
        FlushedFile { file, since_flush: 0, flush: None }
    }
    /// Flushes what was written so far on a thread of its own, unless an earlier flush still runs.
    fn flush_behind(&mut self) {
        if self.flush.as_ref().is_some_and(|f| !f.is_finished()) {
            return;
        }
        self.since_flush = 0;
        // The synchronisation of the complete file reports errors.
        self.flush = self.file.as_file().try_clone().ok().map(|file| {
            std::thread::spawn(move || {
                let _ = file.sync_data();
            })
        });
    }
    /// The file, when no flush runs any more.
    fn into_file(self) -> NamedTempFile {
        if let Some(flush) = self.flush {
            // A flush does not panic.
            let _ = flush.join();
        }
        self.file
    }
}

impl Write for FlushedFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(bytes)?;
        self.since_flush += written as u64;
        if self.since_flush >= FLUSH_INTERVAL {
            self.flush_behind();
        }
        Ok(written)
    }
    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for FlushedFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

/// Destination of a file's bytes: a temporary file, or memory if the target is a device or a pipe, which cannot seek.
pub(super) enum Sink {
    /// The temporary file.
    File(BufWriter<FlushedFile>),
    /// All bytes, for a device or pipe.
    Memory(Cursor<Vec<u8>>),
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Sink::File(out) => out.write(bytes),
            Sink::Memory(out) => {
                out.get_mut().try_reserve(bytes.len()).map_err(io::Error::other)?;
                out.write(bytes)
            }
        }
    }
    fn flush(&mut self) -> io::Result<()> {
        match self {
            Sink::File(out) => out.flush(),
            Sink::Memory(_) => Ok(()),
        }
    }
}

impl Seek for Sink {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match self {
            Sink::File(out) => out.seek(to),
            Sink::Memory(out) => out.seek(to),
        }
    }
}

/// The kind of file at a path.
#[derive(Debug, PartialEq)]
enum WriteTarget {
    /// A file that is replaced; the path is no symbolic link.
    Replaced(PathBuf),
    /// A device, a pipe or a socket.
    Direct,
}

/// Writes `path` by calling `fill`; a failure leaves the old file and no temporary one. Devices and pipes are written directly.
pub(super) fn write_atomic(
    path: &Path,
    fill: impl FnOnce(&mut Sink) -> io::Result<()>,
) -> Result<(), FileError> {
    let written = match resolve_target(path)? {
        WriteTarget::Direct => write_directly(path, fill),
        WriteTarget::Replaced(target) => {
            let mut out = Sink::File(BufWriter::new(FlushedFile::new(create_beside(path, &target)?)));
            fill(&mut out).and_then(|()| replace_target(out, &target))
        }
    };
    written.map_err(|e| {
        FileError::new(
            path,
            "",
            format!("cannot be written ({e}); check the free space and that no folder has this name"),
        )
    })
}

/// Checks that a file can be written, by creating a temporary file beside it and removing it.
///
/// # Errors
///
/// The folder is absent or not writable, or the path is no name of a file.
pub fn check_writable(path: &Path) -> Result<(), FileError> {
    match resolve_target(path)? {
        WriteTarget::Direct => Ok(()),
        WriteTarget::Replaced(target) => create_beside(path, &target).map(drop),
    }
}

/// True for a device, a pipe or a socket, whose name implies no format.
pub fn is_stream(path: &Path) -> bool {
    resolve_target(path).is_ok_and(|t| t == WriteTarget::Direct)
}

/// Removes the temporary files in a folder whose process was killed, of all targets.
pub fn remove_stale_temporaries(folder: &Path) {
    remove_unlocked(folder, None);
}

/// Writes a file of these bytes.
///
/// # Errors
///
/// The file cannot be written.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    write_atomic(path, |out| out.write_all(bytes))
}

/// True for the name of a temporary file of this module.
pub(super) fn is_temporary(name: &OsStr) -> bool {
    target_name(name).is_some()
}

/// Synchronises a temporary file and renames it to the target.
fn replace_target(mut out: Sink, target: &Path) -> io::Result<()> {
    out.flush()?;
    let Sink::File(out) = out else { return Ok(()) };
    let temporary = out.into_inner().map_err(|e| e.into_error())?.into_file();
    temporary.as_file().sync_all()?;
    // Hold the lock until the file has its name.
    let _locked = temporary.persist(target).map_err(|e| e.error)?;
    let folder = folder_of(target);
    // Ignore file systems that cannot synchronise a folder.
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
    remove_unlocked(folder, target.file_name());
    Ok(())
}

/// Passes all bytes to a device or pipe.
fn write_directly(path: &Path, fill: impl FnOnce(&mut Sink) -> io::Result<()>) -> io::Result<()> {
    let mut out = Sink::Memory(Cursor::default());
    fill(&mut out)?;
    let Sink::Memory(bytes) = out else { return Ok(()) };
    // Append: standard output may be a file that has text already.
    let written = File::options().append(true).open(path).and_then(|mut f| f.write_all(bytes.get_ref()));
    match written {
        // A reader that closed its pipe is no failure.
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    }
}

/// The file that a path leads to.
fn resolve_target(path: &Path) -> Result<WriteTarget, FileError> {
    let mut here = path.to_path_buf();
    if fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir()) {
        return Ok(WriteTarget::Direct);
    }
    for _ in 0..MAX_SYMBOLIC_LINKS {
        // Open files of a process: nothing can be renamed to such a path.
        if here.starts_with("/proc") || here.starts_with("/dev/fd") {
            return Ok(WriteTarget::Direct);
        }
        match fs::read_link(&here) {
            Ok(next) => here = folder_of(&here).join(next),
            Err(_) => return Ok(WriteTarget::Replaced(here)),
        }
    }
    Err(FileError::new(path, "", "is a chain of symbolic links without an end; name a file"))
}

/// Creates and locks a temporary file beside the target.
fn create_beside(path: &Path, target: &Path) -> Result<NamedTempFile, FileError> {
    let folder = folder_of(target);
    let Some(name) = target.file_name() else {
        return Err(FileError::new(path, "", "is not the name of a file; give one"));
    };
    let mut prefix = OsString::from(".");
    prefix.push(name);
    prefix.push(format!(".{}-", std::process::id()));
    let mut error = None;
    for _ in 0..MAX_CREATE_ATTEMPTS {
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix).suffix(SUFFIX).rand_bytes(RANDOM_CHARS);
        // Permissions of an ordinary new file, before the umask.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        match builder.tempfile_in(folder) {
            Ok(temporary) => {
                // Another process may have locked and removed the file before this lock: then create another one.
                let locked = matches!(temporary.as_file().try_lock(), Err(fs::TryLockError::WouldBlock));
                if !locked && temporary.path().exists() {
                    return Ok(temporary);
                }
            }
            Err(e) => {
                error = Some(e);
                break;
            }
        }
    }
    let reason = error.map(|e| e.to_string()).unwrap_or_default();
    let folder = folder.display();
    Err(FileError::new(
        path,
        "",
        format!("the folder '{folder}' cannot be written ({reason}); create it or choose another"),
    ))
}

/// The target's name, if `name` is that of a temporary file of this module.
fn target_name(name: &OsStr) -> Option<&[u8]> {
    let rest = name.as_encoded_bytes().strip_prefix(b".")?.strip_suffix(SUFFIX.as_bytes())?;
    let dot = rest.iter().rposition(|b| *b == b'.')?;
    let (process, unique) = std::str::from_utf8(&rest[dot + 1..]).ok()?.split_once('-')?;
    let digits = |s: &str| !s.is_empty() && s.bytes().all(|b| b.is_ascii_digit());
    let is_random = unique.len() == RANDOM_CHARS && unique.bytes().all(|b| b.is_ascii_alphanumeric());
    (digits(process) && is_random).then_some(&rest[..dot])
}

/// Removes the temporary files in a folder without a lock: those of one target, or all.
fn remove_unlocked(folder: &Path, target: Option<&OsStr>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let Some(target_of_file) = target_name(&name) else { continue };
        let wanted = target.is_none_or(|t| t.as_encoded_bytes() == target_of_file);
        if !wanted || !entry.file_type().is_ok_and(|t| t.is_file()) {
            continue;
        }
        let path = entry.path();
        if let Ok(file) = File::options().write(true).open(&path)
            && file.try_lock().is_ok()
        {
            let _ = fs::remove_file(&path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let dir = std::env::temp_dir().join(format!("zonal-atomic-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&dir);
        fs::create_dir_all(&dir).unwrap();
        dir
    }

    fn count(dir: &Path) -> usize {
        fs::read_dir(dir).unwrap().count()
    }

    // Guards (files): every file is written beside its target and renamed when complete; a failure leaves the old file and nothing else.
    #[test]
    fn a_failure_leaves_the_old_file_and_nothing_else() {
        let dir = folder("failure");
        let path = dir.join("a.txt");
        write_atomic(&path, |w| w.write_all(b"old")).unwrap();
        let e = write_atomic(&path, |w| {
            w.write_all(b"half")?;
            Err(io::Error::other("disk full"))
        });
        assert!(e.unwrap_err().to_string().contains("disk full"));
        assert_eq!((fs::read(&path).unwrap(), count(&dir)), (b"old".to_vec(), 1));
        let e = write_atomic(&dir.join("no/such/a.txt"), |_| Ok(())).unwrap_err();
        assert!(e.to_string().contains("no/such' cannot be written"), "{e}");
        // A panic leaves nothing behind.
        let broken = std::panic::catch_unwind(|| write_atomic(&path, |_| panic!("a broken assumption")));
        assert!(broken.is_err());
        assert_eq!((fs::read(&path).unwrap(), count(&dir)), (b"old".to_vec(), 1));
        check_writable(&path).unwrap();
        assert_eq!((fs::read(&path).unwrap(), count(&dir)), (b"old".to_vec(), 1));
        fs::remove_dir_all(&dir).unwrap();
    }

    // Guards (files): abandoned temporary files are removed by the next success.
    #[test]
    fn temporary_files_without_a_lock_are_removed_and_locked_ones_stay() {
        let dir = folder("stale");
        let path = dir.join("a.txt");
        let (stale, other, foreign) = (
            dir.join(".a.txt.123-4aZ09b.partial"),
            dir.join(".b.txt.7-000001.partial"),
            dir.join(".a.txt.x-000000.partial"),
        );
        [&stale, &other, &foreign].iter().for_each(|p| fs::write(p, "half").unwrap());
        let living = create_beside(&path, &path).unwrap();
        write_atomic(&path, |w| w.write_all(b"new")).unwrap();
        assert!(!stale.exists() && other.exists() && foreign.exists() && living.path().exists());
        remove_stale_temporaries(&dir);
        assert!(!other.exists() && foreign.exists() && living.path().exists());
        drop(living);
        assert_eq!(count(&dir), 2);
        fs::remove_dir_all(&dir).unwrap();
    }

    #[test]
    fn a_large_file_is_complete_when_it_was_flushed_behind() {
        let dir = folder("large");
        let path = dir.join("a.bin");
        let piece: Vec<u8> = (0..1 << 20).map(|i| i as u8).collect();
        let pieces = FLUSH_INTERVAL as usize / piece.len() * 2 + 1;
        write_atomic(&path, |w| (0..pieces).try_for_each(|_| w.write_all(&piece))).unwrap();
        let read = fs::read(&path).unwrap();
        assert_eq!((read.len(), count(&dir)), (pieces * piece.len(), 1));
        assert!(read.chunks(piece.len()).all(|part| part == piece));
        fs::remove_dir_all(&dir).unwrap();
    }

    // Guards (files): a symbolic link stays and its target is replaced.
    #[cfg(unix)]
    #[test]
    fn a_link_stays_and_its_target_is_replaced() {
        use std::os::unix::fs::symlink;
        let dir = folder("link");
        fs::create_dir_all(dir.join("real")).unwrap();
        symlink("real/a.txt", dir.join("one")).unwrap();
        symlink("one", dir.join("two")).unwrap();
        // First a dangling link, then one to a file.
        for text in ["new", "newer"] {
            write_atomic(&dir.join("two"), |w| w.write_all(text.as_bytes())).unwrap();
            assert_eq!(fs::read_to_string(dir.join("real/a.txt")).unwrap(), text);
        }
        assert!(fs::read_link(dir.join("two")).is_ok() && fs::read_link(dir.join("one")).is_ok());
        assert_eq!((count(&dir), count(&dir.join("real"))), (3, 1));
        symlink("round", dir.join("round")).unwrap();
        let e = write_atomic(&dir.join("round"), |_| Ok(())).unwrap_err();
        assert!(e.to_string().contains("without an end"), "{e}");
        fs::remove_dir_all(&dir).unwrap();
    }

    // Guards (files): devices and pipes are written directly.
    #[cfg(unix)]
    #[test]
    fn devices_are_written_directly() {
        let null = Path::new("/dev/null");
        assert!(is_stream(null) && is_stream(Path::new("/dev/stdout")) && !is_stream(Path::new("a.txt")));
        write_atomic(null, |w| w.write_all(b"bytes")).unwrap();
        use std::os::unix::fs::FileTypeExt;
        assert!(fs::metadata(null).unwrap().file_type().is_char_device());
        // A full device.
        if Path::new("/dev/full").exists() {
            let e = write_atomic(Path::new("/dev/full"), |w| w.write_all(b"bytes")).unwrap_err();
            assert!(e.to_string().contains("check the free space"), "{e}");
        }
    }
}
