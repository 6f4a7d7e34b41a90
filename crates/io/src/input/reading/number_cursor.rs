//! Numbers one after the other in a file: words of a text, or bytes in one order. Every number takes bytes of the file, so that lists grow no faster than
//! the file is read, whatever counts it declares.

use super::error::FileFault;
use super::npy::ElementFormat;

/// Characters of a word that a message quotes.
const MAX_QUOTED_CHARACTERS: usize = 40;
/// Whole numbers up to this one are exact as doubles.
const MAX_WHOLE_NUMBER: f64 = 9_007_199_254_740_992.0;

/// How a file writes its numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NumberEncoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// The type of a number in binary files; texts have words of any type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ScalarType {
    /// `i`, `u` or `f`, as numpy names them.
    pub(crate) kind: char,
    /// Bytes.
    pub(crate) size: usize,
}

/// A place in a file from which numbers are read.
pub(crate) struct NumberCursor<'a> {
    pub(crate) file: &'a str,
    pub(crate) encoding: NumberEncoding,
    bytes: &'a [u8],
    at: usize,
}

impl<'a> NumberCursor<'a> {
    /// A cursor at byte `at`.
    pub(crate) fn new(file: &'a str, bytes: &'a [u8], at: usize, encoding: NumberEncoding) -> Self {
        NumberCursor { file, encoding, bytes, at: at.min(bytes.len()) }
    }

    /// The bytes from here on.
    pub(crate) fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// Moves on by some bytes, to the end of the file at most.
    pub(crate) fn skip(&mut self, bytes: usize) {
        self.at = self.at.saturating_add(bytes).min(self.bytes.len());
    }

    /// An error at this place: the line of a text, the byte of a binary file.
    pub(crate) fn fault(&self, message: impl std::fmt::Display) -> FileFault {
        match self.encoding {
            NumberEncoding::Text => {
                let line = 1 + self.bytes[..self.at].iter().filter(|b| **b == b'\n').count();
                FileFault::new(self.file, line, message)
            }
            _ => FileFault::new(self.file, format!("byte {}", self.at), message),
        }
    }

    /// The rest of the line without its end; none at the end of the file.
    pub(crate) fn line(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest();
        if rest.is_empty() {
            return None;
        }
        let length = rest.iter().position(|b| *b == b'\n');
        self.skip(length.map_or(rest.len(), |n| n + 1));
        let line = &rest[..length.unwrap_or(rest.len())];
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }

    /// The next number.
    pub(crate) fn number(&mut self, of: ScalarType) -> Result<f64, FileFault> {
        let big_endian = match self.encoding {
            NumberEncoding::Text => return self.word(),
            NumberEncoding::LittleEndian => false,
            NumberEncoding::BigEndian => true,
        };
        let Some(bytes) = self.rest().get(..of.size) else { return Err(self.cut_short()) };
        self.skip(of.size);
        Ok(ElementFormat { kind: of.kind, size: of.size, big_endian }.value(bytes))
    }

    /// The next number, which is whole.
    pub(crate) fn integer(&mut self, of: ScalarType) -> Result<i64, FileFault> {
        let x = self.number(of)?;
        if x.fract() == 0.0 && x.abs() <= MAX_WHOLE_NUMBER {
            return Ok(x as i64);
        }
        Err(self.fault(format!("{x} stands where a whole number is expected; export the mesh again")))
    }

    /// The next number, which is whole and not negative.
    pub(crate) fn count(&mut self, of: ScalarType) -> Result<u64, FileFault> {
        let n = self.integer(of)?;
        let wrong =
            |_| self.fault(format!("{n} stands where a number from 0 is expected; export the mesh again"));
        u64::try_from(n).map_err(wrong)
    }

    fn cut_short(&self) -> FileFault {
        self.fault("this file is cut short: numbers are missing; copy it again or export the mesh again")
    }

    /// The next word of a text as a number.
    fn word(&mut self) -> Result<f64, FileFault> {
        let rest = self.rest();
        let blanks = rest.iter().take_while(|b| b.is_ascii_whitespace()).count();
        let word = &rest[blanks..];
        let length = word.iter().position(u8::is_ascii_whitespace).unwrap_or(word.len());
        if length == 0 {
            return Err(self.cut_short());
        }
        self.skip(blanks + length);
        let number = std::str::from_utf8(&word[..length]).ok().and_then(|w| w.parse().ok());
        number.ok_or_else(|| {
            let shown = quoted(&word[..length]);
            self.fault(format!(
                "'{shown}' stands where a number is expected; mend this line or export the mesh again"
            ))
        })
    }
}

/// Bytes as the text of a message, without control characters and of limited length.
pub(crate) fn quoted(bytes: &[u8]) -> String {
    let start = &bytes[..bytes.len().min(4 * MAX_QUOTED_CHARACTERS)];
    let text = String::from_utf8_lossy(start);
    text.chars().take(MAX_QUOTED_CHARACTERS).flat_map(char::escape_debug).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_and_bytes_are_the_same_numbers() {
        let int = ScalarType { kind: 'i', size: 4 };
        let text = b" -7 1e3\n x";
        let mut cursor = NumberCursor::new("f", text, 0, NumberEncoding::Text);
        assert_eq!((cursor.integer(int), cursor.count(int)), (Ok(-7), Ok(1000)));
        let message = cursor.number(int).unwrap_err().to_string();
        assert!(message.starts_with("f:2: 'x' stands where"), "{message}");
        let bytes = [(-7i32).to_be_bytes(), 1000i32.to_be_bytes(), [0xff; 4]].concat();
        let mut cursor = NumberCursor::new("f", &bytes, 0, NumberEncoding::BigEndian);
        assert_eq!((cursor.integer(int), cursor.count(int)), (Ok(-7), Ok(1000)));
        let message = cursor.count(int).unwrap_err().to_string();
        assert!(message.starts_with("f:byte 12: -1 stands where"), "{message}");
        assert!(cursor.number(int).unwrap_err().to_string().contains("cut short"));
    }
}
