//! Bytes of an array: raw, or base64 with padding inside, as VTK encodes lengths apart from values.

/// Where the bytes of an array begin.
#[derive(Clone, Copy)]
pub(crate) enum ByteSource<'a> {
    Raw(&'a [u8]),
    Base64(&'a [u8]),
}

impl ByteSource<'_> {
    /// Refuses a number of bytes that the source cannot hold.
    pub(crate) fn check(self, count: usize) -> Result<(), String> {
        let most = match self {
            ByteSource::Raw(bytes) => bytes.len(),
            ByteSource::Base64(text) => 3 * (text.len() / 4) + 2,
        };
        if count > most { Err("the data are cut short; save the file again".into()) } else { Ok(()) }
    }

    /// The first `count` bytes.
    pub(crate) fn first(self, count: usize) -> Result<Vec<u8>, String> {
        let short = || "the data are cut short; save the file again".to_string();
        match self {
            ByteSource::Raw(bytes) => bytes.get(..count).map(<[u8]>::to_vec).ok_or_else(short),
            // Four characters hold three bytes.
            ByteSource::Base64(text) if count / 3 > text.len() / 4 => Err(short()),
            ByteSource::Base64(text) => {
                let out = decode(text, count)?;
                if out.len() == count { Ok(out) } else { Err(short()) }
            }
        }
    }
}

/// The first `count` bytes of a base64 text, fewer where it ends or a tag begins; blanks are skipped.
fn decode(text: &[u8], count: usize) -> Result<Vec<u8>, String> {
    let mut out = Vec::with_capacity(count);
    let (mut bits, mut held) = (0u32, 0);
    for &c in text {
        if out.len() >= count || c == b'<' {
            break;
        }
        let six = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            b'=' => {
                // Padding ends a group: bits of the unfinished byte are void.
                (bits, held) = (0, 0);
                continue;
            }
            c if c.is_ascii_whitespace() => continue,
            c => return Err(format!("the byte {c} is not base64; save the file again")),
        };
        (bits, held) = (bits << 6 | u32::from(six), held + 6);
        if held >= 8 {
            held -= 8;
            out.push((bits >> held & 0xff) as u8);
            bits &= (1 << held) - 1;
        }
    }
    Ok(out)
}
