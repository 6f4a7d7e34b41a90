//! Whole files or none: write beside the target, then rename.

use super::FileError;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes `path` by calling `fill` on a temporary file in the same folder, renamed when complete and removed on failure.
pub fn write_atomic(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), FileError> {
    let (temporary, file) = create_beside(path)?;
    let mut out = BufWriter::new(file);
    let done = fill(&mut out).and_then(|()| out.flush()).and_then(|()| fs::rename(&temporary, path));
    done.map_err(|e| {
        let _ = fs::remove_file(&temporary);
        FileError::new(
            path,
            "",
            format!("cannot be written ({e}); check the free space and that no folder has this name"),
        )
    })
}

fn create_beside(path: &Path) -> Result<(PathBuf, File), FileError> {
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    let Some(name) = path.file_name() else {
        return Err(FileError::new(path, "", "is not the name of a file; give one"));
    };
    let mut last = None;
    for n in 0..100 {
        let mut hidden = std::ffi::OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}-{n}.partial", std::process::id()));
        let temporary = folder.join(hidden);
        match File::options().write(true).create_new(true).open(&temporary) {
            Ok(file) => return Ok((temporary, file)),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_leaves_the_old_file_and_nothing_else() {
        let dir = std::env::temp_dir().join(format!("zonal-atomic-{}", std::process::id()));
        fs::create_dir_all(&dir).unwrap();
        let path = dir.join("a.txt");
        write_atomic(&path, |w| w.write_all(b"old")).unwrap();
        let e = write_atomic(&path, |w| {
            w.write_all(b"half")?;
            Err(io::Error::other("disk full"))
        });
        assert!(e.unwrap_err().to_string().contains("disk full"));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(&dir).unwrap().count(), 1);
        let e = write_atomic(&dir.join("no/such/a.txt"), |_| Ok(())).unwrap_err();
        assert!(e.to_string().contains("no/such' cannot be written"), "{e}");
        fs::remove_dir_all(&dir).unwrap();
    }
}
