//! Tags of an XML text with their attributes; texts between tags are skipped, and read by position.

/// Most attributes of a tag.
const MAX_ATTRIBUTES: usize = 100;

/// An opening, empty or closing tag.
pub(crate) struct Tag {
    pub(crate) name: String,
    /// True for `</name>`.
    pub(crate) closes: bool,
    /// True for `<name/>`.
    pub(crate) is_empty: bool,
    attributes: Vec<(String, String)>,
}

impl Tag {
    /// The value of an attribute.
    pub(crate) fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|a| a.0 == name).map(|a| a.1.as_str())
    }
}

/// Reads tag after tag.
pub(crate) struct TagReader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> TagReader<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> TagReader<'a> {
        TagReader { bytes, at: 0 }
    }

    /// Offset of the byte after the last tag.
    pub(crate) fn position(&self) -> usize {
        self.at
    }

    /// The next tag; none at the end of the file. Declarations and comments are skipped.
    pub(crate) fn next_tag(&mut self) -> Result<Option<Tag>, String> {
        loop {
            let Some(start) = find(self.bytes, self.at, b"<") else { return Ok(None) };
            let rest = &self.bytes[start..];
            let (skipped, end): (bool, &[u8]) = match rest {
                r if r.starts_with(b"<!--") => (true, b"-->"),
                r if r.starts_with(b"<?") || r.starts_with(b"<!") => (true, b">"),
                _ => (false, b">"),
            };
            if skipped {
                self.at = find(self.bytes, start, end).ok_or("a comment has no end; save the file again")?
                    + end.len();
                continue;
            }
            let close = end_of_tag(self.bytes, start)
                .ok_or("a tag has no end: the file is cut short; save it again")?;
            self.at = close + 1;
            return parse_tag(&self.bytes[start + 1..close]).map(Some);
        }
    }
}

/// The first occurrence of `pattern` from `from`.
fn find(bytes: &[u8], from: usize, pattern: &[u8]) -> Option<usize> {
    let rest = bytes.get(from..)?;
    rest.windows(pattern.len()).position(|w| w == pattern).map(|k| from + k)
}

/// The `>` that ends the tag at `start`; quoted values may hold others.
fn end_of_tag(bytes: &[u8], start: usize) -> Option<usize> {
    let mut quote = None;
    for (k, b) in bytes.iter().enumerate().skip(start) {
        match (quote, b) {
            (None, b'>') => return Some(k),
            (None, b'"' | b'\'') => quote = Some(*b),
            (Some(q), b) if q == *b => quote = None,
            _ => {}
        }
    }
    None
}

/// A tag from the bytes between `<` and `>`.
fn parse_tag(inside: &[u8]) -> Result<Tag, String> {
    let text = std::str::from_utf8(inside)
        .map_err(|_| "a tag is not UTF-8 text; save the file again".to_string())?;
    let (closes, text) = text.strip_prefix('/').map_or((false, text), |t| (true, t));
    let (is_empty, text) = text.strip_suffix('/').map_or((false, text), |t| (true, t));
    let (name, mut rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    let mut attributes = Vec::new();
    while let Some((key, after)) = rest.split_once('=') {
        let after = after.trim_start();
        let quote = after.chars().next().filter(|c| matches!(c, '"' | '\''));
        let value = quote.and_then(|q| after[1..].split_once(q));
        let Some((value, left)) = value else {
            return Err(format!(
                "the attribute '{}' has no value in quotes; save the file again",
                key.trim()
            ));
        };
        attributes.push((key.trim().to_string(), unescape(value)));
        if attributes.len() > MAX_ATTRIBUTES {
            return Err(format!("a tag has more than {MAX_ATTRIBUTES} attributes; save the file again"));
        }
        rest = left;
    }
    Ok(Tag { name: name.trim().to_string(), closes, is_empty, attributes })
}

/// The text of an attribute with its five named entities resolved.
fn unescape(text: &str) -> String {
    let pairs = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&apos;", "'"), ("&amp;", "&")];
    pairs.iter().fold(text.to_string(), |t, (from, to)| t.replace(from, to))
}
