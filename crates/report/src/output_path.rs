//! Checks of output paths before a computation.

use crate::Failure;
use std::path::Path;

/// Checks that an output can be written and has one of the allowed extensions.
///
/// # Errors
/// For another extension, a folder in place of a file, a missing folder, and a folder that cannot be written.
pub fn check_output(path: &Path, extensions: &[&str]) -> Result<(), Failure> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    // A device or pipe has no extension; it is accepted if there is only one format.
    let stream = zonal_io::output::is_stream(path);
    if stream && extensions.len() == 1 {
        return Ok(());
    }
    if !extensions.contains(&extension.as_str()) {
        let list = extensions.iter().map(|e| format!(".{e}")).collect::<Vec<_>>().join(" or ");
        return Err(Failure::new(format!("{}: the name of the output must end in {list}", path.display())));
    }
    if path.is_dir() {
        return Err(Failure::new(format!("{}: is a folder; name a file", path.display())));
    }
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(Failure::new(format!(
            "{}: there is no folder {}; create it first",
            path.display(),
            folder.display()
        )));
    }
    zonal_io::output::check_writable(path).map_err(Failure::from)
}
