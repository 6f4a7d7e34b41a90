//! The check of a picture's size.

use crate::output::error::FileError;
use std::path::Path;

/// Refuses pictures without pixels, too large ones, and lists of another length.
pub(super) fn check_size(path: &Path, width: usize, height: usize, pixels: usize) -> Result<(), FileError> {
    let fits = width.checked_mul(height) == Some(pixels);
    if pixels == 0 || !fits || width.max(height) > i32::MAX as usize {
        return Err(FileError::new(
            path,
            "",
            format!("{pixels} pixels do not make a picture of {width} × {height}"),
        ));
    }
    Ok(())
}
