//! Bounded reading of text files, with errors as those of scenes.

use super::error::InputError;
use crate::files;
use std::path::Path;

/// A regular file, open for reading. Pipes, devices, sockets, folders and files of more than `max_bytes` bytes are refused.
///
/// # Errors
///
/// The file is refused or cannot be opened.
pub fn open_file(path: &Path, max_bytes: u64) -> Result<std::fs::File, InputError> {
    let refused = |message: String| InputError::new(&path.display().to_string(), None, "", message);
    let (file, length) = files::open(path).map_err(refused)?;
    if length > max_bytes {
        let limit = max_bytes >> 20;
        return Err(refused(format!(
            "this file is larger than the {limit} MiB that are read; make it smaller"
        )));
    }
    Ok(file)
}

/// The text of a file of at most `max_bytes` bytes.
pub(crate) fn read_text(path: &Path, max_bytes: u64) -> Result<String, InputError> {
    let file = path.display().to_string();
    let refused = |message: String| InputError::new(&file, None, "", message);
    decode_utf8(&file, files::read(path, max_bytes).map_err(refused)?)
}

/// The text of UTF-8 bytes; an error names the line of the first byte that is not.
pub(crate) fn decode_utf8(file: &str, bytes: Vec<u8>) -> Result<String, InputError> {
    String::from_utf8(bytes).map_err(|e| {
        let line = e.as_bytes()[..e.utf8_error().valid_up_to()].iter().filter(|b| **b == b'\n').count();
        let message = "this is not UTF-8 text; save the file as UTF-8";
        InputError::new(file, Some((line + 1, 1)), "", message)
    })
}
