//! Whole files or none: write beside the target, then rename.
//!
//! The steps, in this order, so that a kill or a power cut at any moment leaves the old file or the new one:
//!
//! 1. the target is what a chain of symbolic links ends at; the links stay;
//! 2. a temporary file `.NAME.PID-N.partial` is made in the target's folder and locked for as long as its process lives;
//! 3. its bytes are written and brought to the disk (`fsync`), it is renamed, and the folder is brought to the disk;
//! 4. temporary files of the same target that nobody holds a lock on are removed: their process was killed.
//!
//! A lock ends with its process, however that ends, so that neither a reused process number nor another machine misleads step 4. A
//! file that is locked by the one that removes it, before the one that made it could, is made anew under another number.
//!
//! Devices, pipes and sockets (`/dev/stdout`, `/dev/null`, a FIFO) hold no old file: they get the bytes directly, all at once.

use super::FileError;
use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io::{self, BufWriter, Cursor, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// The most symbolic links that are followed.
const MOST_LINKS: usize = 40;

/// What a file is written into: a temporary file, or memory where the target is a device or a pipe, which cannot seek.
pub(super) enum Sink {
    /// The temporary file.
    File(BufWriter<File>),
    /// All bytes, to be passed on.
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

/// Where the bytes of a path go.
#[derive(Debug, PartialEq)]
enum Target {
    /// Into a file that is replaced; the path is no symbolic link.
    Replaced(PathBuf),
    /// Into a device, a pipe or a socket.
    Direct,
}

/// A temporary file, removed unless it was renamed.
struct Partial {
    path: PathBuf,
    renamed: bool,
}

impl Drop for Partial {
    fn drop(&mut self) {
        if !self.renamed {
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Writes `path` by calling `fill`: whole, or not at all and with no temporary file left. Devices and pipes are written directly.
pub(super) fn write_atomic(
    path: &Path,
    fill: impl FnOnce(&mut Sink) -> io::Result<()>,
) -> Result<(), FileError> {
    let done = match target(path)? {
        Target::Direct => direct(path, fill),
        Target::Replaced(target) => {
            let (mut partial, file) = create_beside(path, &target)?;
            let mut out = Sink::File(BufWriter::new(file));
            fill(&mut out).and_then(|()| finish(out, &target, &mut partial))
        }
    };
    done.map_err(|e| {
        FileError::new(
            path,
            "",
            format!("cannot be written ({e}); check the free space and that no folder has this name"),
        )
    })
}

/// Refuses a path that `write_atomic` could not write, by making a temporary file there and removing it.
pub fn check_writable(path: &Path) -> Result<(), FileError> {
    match target(path)? {
        Target::Direct => Ok(()),
        Target::Replaced(target) => create_beside(path, &target).map(drop),
    }
}

/// True for a path that is a device, a pipe or a socket, whose name says nothing of a format.
pub fn is_stream(path: &Path) -> bool {
    target(path).is_ok_and(|t| t == Target::Direct)
}

/// Removes the temporary files in a folder whose process was killed, whatever their targets.
pub fn remove_stale(folder: &Path) {
    sweep(folder, None);
}

/// True for the name of a temporary file of ours.
pub(super) fn is_partial(name: &OsStr) -> bool {
    target_name(name).is_some()
}

fn finish(mut out: Sink, target: &Path, partial: &mut Partial) -> io::Result<()> {
    out.flush()?;
    let Sink::File(out) = out else { return Ok(()) };
    let file = out.into_inner().map_err(|e| e.into_error())?;
    file.sync_all()?;
    fs::rename(&partial.path, target)?;
    partial.renamed = true;
    let folder = folder_of(target);
    // Not every file system can bring a folder to the disk.
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
    sweep(folder, target.file_name());
    Ok(())
}

fn direct(path: &Path, fill: impl FnOnce(&mut Sink) -> io::Result<()>) -> io::Result<()> {
    let mut out = Sink::Memory(Cursor::default());
    fill(&mut out)?;
    let Sink::Memory(bytes) = out else { return Ok(()) };
    // Appended: standard output may be a file that has text already.
    let written = File::options().append(true).open(path).and_then(|mut f| f.write_all(bytes.get_ref()));
    match written {
        // A reader that has gone away is no failure.
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

/// What a path stands for.
fn target(path: &Path) -> Result<Target, FileError> {
    let mut here = path.to_path_buf();
    if fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir()) {
        return Ok(Target::Direct);
    }
    for _ in 0..MOST_LINKS {
        // Files that a process has open have names of this kind, which nothing can be renamed to.
        if here.starts_with("/proc") || here.starts_with("/dev/fd") {
            return Ok(Target::Direct);
        }
        match fs::read_link(&here) {
            Ok(next) => here = folder_of(&here).join(next),
            Err(_) => return Ok(Target::Replaced(here)),
        }
    }
    Err(FileError::new(path, "", "is a chain of symbolic links without an end; name a file"))
}

/// The temporary file, made and locked.
fn create_beside(path: &Path, target: &Path) -> Result<(Partial, File), FileError> {
    let folder = folder_of(target);
    let Some(name) = target.file_name() else {
        return Err(FileError::new(path, "", "is not the name of a file; give one"));
    };
    let mut last = None;
    for n in 0..100 {
        let mut hidden = OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}-{n}.partial", std::process::id()));
        let temporary = folder.join(hidden);
        match File::options().write(true).create_new(true).open(&temporary) {
            Ok(file) => {
                let taken = matches!(file.try_lock(), Err(fs::TryLockError::WouldBlock));
                if !taken && temporary.exists() {
                    return Ok((Partial { path: temporary, renamed: false }, file));
                }
            }
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => last = Some(e),
            Err(e) => {
                last = Some(e);
                break;
            }
        }
    }
    let why = last.map(|e| e.to_string()).unwrap_or_default();
    let folder = folder.display();
    Err(FileError::new(
        path,
        "",
        format!("the folder '{folder}' cannot be written ({why}); create it or choose another"),
    ))
}

/// The target's name, where `name` is that of a temporary file of ours.
fn target_name(name: &OsStr) -> Option<&[u8]> {
    let rest = name.as_encoded_bytes().strip_prefix(b".")?.strip_suffix(b".partial")?;
    let dot = rest.iter().rposition(|b| *b == b'.')?;
    let (process, number) = std::str::from_utf8(&rest[dot + 1..]).ok()?.split_once('-')?;
    let digits = |s: &str| !s.is_empty() && s.bytes().all(|b| b.is_ascii_digit());
    (digits(process) && digits(number)).then_some(&rest[..dot])
}

/// Removes the temporary files in a folder that nobody holds a lock on: those of one target, or all.
fn sweep(folder: &Path, target: Option<&OsStr>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let Some(of) = target_name(&name) else { continue };
        let wanted = target.is_none_or(|t| t.as_encoded_bytes() == of);
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
        // A panic leaves nothing either.
        let broken = std::panic::catch_unwind(|| write_atomic(&path, |_| panic!("a broken assumption")));
        assert!(broken.is_err());
        assert_eq!((fs::read(&path).unwrap(), count(&dir)), (b"old".to_vec(), 1));
        check_writable(&path).unwrap();
        assert_eq!((fs::read(&path).unwrap(), count(&dir)), (b"old".to_vec(), 1));
        fs::remove_dir_all(&dir).unwrap();
    }

    #[test]
    fn temporary_files_of_the_killed_are_removed_and_those_of_the_living_stay() {
        let dir = folder("stale");
        let path = dir.join("a.txt");
        let (stale, other, mine) = (
            dir.join(".a.txt.123-0.partial"),
            dir.join(".b.txt.7-1.partial"),
            dir.join(".a.txt.x-0.partial"),
        );
        [&stale, &other, &mine].iter().for_each(|p| fs::write(p, "half").unwrap());
        let (living, lock) = create_beside(&path, &path).unwrap();
        write_atomic(&path, |w| w.write_all(b"new")).unwrap();
        assert!(!stale.exists() && other.exists() && mine.exists() && living.path.exists());
        remove_stale(&dir);
        assert!(!other.exists() && mine.exists() && living.path.exists());
        drop((living, lock));
        assert_eq!(count(&dir), 2);
        fs::remove_dir_all(&dir).unwrap();
    }

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

    #[cfg(unix)]
    #[test]
    fn devices_are_written_directly() {
        let null = Path::new("/dev/null");
        assert!(is_stream(null) && is_stream(Path::new("/dev/stdout")) && !is_stream(Path::new("a.txt")));
        write_atomic(null, |w| w.write_all(b"bytes")).unwrap();
        use std::os::unix::fs::FileTypeExt;
        assert!(fs::metadata(null).unwrap().file_type().is_char_device());
        // A device without room.
        if Path::new("/dev/full").exists() {
            let e = write_atomic(Path::new("/dev/full"), |w| w.write_all(b"bytes")).unwrap_err();
            assert!(e.to_string().contains("check the free space"), "{e}");
        }
    }
}
