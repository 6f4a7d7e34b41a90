//! View3D's own files, of the shared data beside the checkout; tests of the view factors take this file too.

use std::path::PathBuf;

/// The text of a file below View3D's folder, or None with a line on the standard output.
pub(crate) fn text(name: &str) -> Option<String> {
    let root = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/thermal-view3d"));
    let path = root.join(name);
    match std::fs::read(&path) {
        Ok(bytes) => Some(String::from_utf8_lossy(&bytes).into_owned()),
        Err(_) => {
            println!("skipped: {} is missing", path.display());
            None
        }
    }
}
