//! Containers of glTF: the chunks of a GLB file, and the bytes behind a URI.

use crate::files::FileSource;
use crate::input::reading::error::FileFault;
use std::path::{Path, PathBuf};

/// Largest glTF or buffer file, bytes.
pub(super) const MAX_GLTF_FILE_BYTES: u64 = 2 << 30;

/// The JSON and the binary chunk of a GLB or glTF file.
pub(super) fn split_chunks<'a>(
    file: &str,
    bytes: &'a [u8],
) -> Result<(&'a [u8], Option<&'a [u8]>), FileFault> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes, None));
    }
    let word = |at: usize| {
        let b: Option<[u8; 4]> = bytes.get(at..at + 4).and_then(|b| b.try_into().ok());
        b.map(u32::from_le_bytes)
    };
    let cut = |place: &str| FileFault::new(file, place, "this GLB is cut short; copy or export it again");
    match word(4) {
        Some(2) => {}
        Some(v) => {
            let message = format!("this is glTF version {v}; export it as glTF 2.0");
            return Err(FileFault::new(file, "header", message));
        }
        None => return Err(cut("header")),
    }
    let (mut json, mut binary, mut at) = (None, None, 12usize);
    let total = word(8).ok_or_else(|| cut("header"))? as usize;
    if total > bytes.len() {
        return Err(cut("header"));
    }
    // Fewer bytes than a chunk's header are padding.
    while at + CHUNK_HEADER_BYTES <= total {
        let place = format!("chunk at byte {at}");
        let (Some(length), Some(kind)) = (word(at), word(at + 4)) else {
            return Err(cut(&place));
        };
        let end = (at + 8).saturating_add(length as usize);
        let data = bytes.get(at + 8..end).ok_or_else(|| cut(&place))?;
        match &kind.to_le_bytes() {
            b"JSON" if json.is_none() => json = Some(data),
            b"BIN\0" if binary.is_none() => binary = Some(data),
            _ => {}
        }
        at = end;
    }
    let json =
        json.ok_or_else(|| FileFault::new(file, "header", "this GLB has no JSON chunk; export it again"))?;
    Ok((json, binary))
}

/// Bytes of the header of a chunk.
const CHUNK_HEADER_BYTES: usize = 8;

/// A note about bytes behind the declared end of a GLB.
pub(super) fn trailing_note(file: &str, bytes: &[u8]) -> Option<String> {
    let total = bytes.get(8..12).filter(|_| bytes.starts_with(b"glTF"))?;
    let total = u32::from_le_bytes([total[0], total[1], total[2], total[3]]) as usize;
    let excess = bytes.len().checked_sub(total).filter(|n| *n > 0)?;
    Some(format!("{file}: {excess} byte(s) behind the declared end of the GLB were not read"))
}

/// The bytes behind a URI: a data URI, or a file beside `path`.
pub(super) fn resolve_uri(
    files: FileSource<'_>,
    file: &str,
    path: &Path,
    place: &str,
    uri: &str,
) -> Result<Vec<u8>, FileFault> {
    if let Some(data) = uri.strip_prefix("data:") {
        let encoded = data.split_once(";base64,").map(|(_, e)| e);
        return encoded.and_then(decode_base64).ok_or_else(|| {
            FileFault::new(file, place, "this data URI is not base64; export the file again")
        });
    }
    let beside = path_beside(path, uri);
    files
        .read(&beside, MAX_GLTF_FILE_BYTES)
        .map_err(|e| FileFault::new(file, place, format!("'{}': {e}", beside.display())))
}

/// The file that a relative URI names.
pub(super) fn path_beside(path: &Path, uri: &str) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).join(decode_percent(uri))
}

fn decode_percent(uri: &str) -> String {
    let b = uri.as_bytes();
    let mut out = Vec::with_capacity(b.len());
    let mut i = 0;
    while i < b.len() {
        let code = b.get(i + 1..i + 3).and_then(|h| std::str::from_utf8(h).ok());
        match code.and_then(|h| u8::from_str_radix(h, 16).ok()) {
            Some(byte) if b[i] == b'%' => {
                out.push(byte);
                i += 3;
            }
            _ => {
                out.push(b[i]);
                i += 1;
            }
        }
    }
    String::from_utf8_lossy(&out).into_owned()
}

fn decode_base64(text: &str) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut count) = (0u32, 0);
    for c in text.bytes().filter(|c| *c != b'=') {
        let value = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ => return None,
        };
        bits = bits << 6 | value as u32;
        count += 6;
        if count >= 8 {
            count -= 8;
            out.push((bits >> count) as u8);
        }
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_and_percent_encoding_are_decoded() {
        assert_eq!(decode_base64("aGVsbG8=").as_deref(), Some(&b"hello"[..]));
        assert_eq!(decode_base64("a b"), None);
        assert_eq!(decode_percent("a%20b%"), "a b%");
    }
}
