//! The header of a PLY file: its encoding, and the properties of its elements.

use crate::input::reading::error::FileFault;
use crate::input::reading::number_cursor::{NumberEncoding, ScalarType, quoted};

/// The header.
pub(super) struct PlyHeader {
    pub(super) encoding: NumberEncoding,
    /// In the order of the file.
    pub(super) elements: Vec<PlyElement>,
    /// Pictures that comments name.
    pub(super) textures: Vec<String>,
    /// First byte behind the header.
    pub(super) end: usize,
}

/// An element: a table of `count` rows.
pub(super) struct PlyElement {
    pub(super) name: String,
    pub(super) count: usize,
    pub(super) properties: Vec<PlyProperty>,
}

/// A column of an element.
pub(super) struct PlyProperty {
    pub(super) name: String,
    /// Type of the value, or of the values of a list.
    pub(super) value: ScalarType,
    /// Type of the length of a list; none for one value.
    pub(super) length: Option<ScalarType>,
}

impl PlyElement {
    /// The index of the property of one of these names.
    pub(super) fn position(&self, names: &[&str]) -> Option<usize> {
        self.properties.iter().position(|p| names.contains(&p.name.as_str()))
    }

    /// Fewest bytes of a row: lists may be empty, words of a text have one character and a blank.
    pub(super) fn min_row_bytes(&self, encoding: NumberEncoding) -> usize {
        let of = |p: &PlyProperty| match encoding {
            NumberEncoding::Text => 2,
            _ => p.length.unwrap_or(p.value).size,
        };
        self.properties.iter().map(of).sum()
    }
}

impl PlyHeader {
    /// Reads the header at the beginning of a file.
    pub(super) fn parse(file: &str, bytes: &[u8]) -> Result<PlyHeader, FileFault> {
        let mut lines = HeaderLines::new(bytes);
        if lines.next_line() != Some(b"ply") {
            let message = "this is no PLY: its first line is not ply; export the mesh again";
            return Err(FileFault::new(file, "", message));
        }
        let mut header =
            PlyHeader { encoding: NumberEncoding::Text, elements: Vec::new(), textures: Vec::new(), end: 0 };
        let mut has_format = false;
        while let Some(line) = lines.next_line() {
            let text = String::from_utf8_lossy(line);
            let words: Vec<&str> = text.split_whitespace().collect();
            if words == ["end_header"] {
                header.end = lines.at;
                return if has_format {
                    Ok(header)
                } else {
                    Err(FileFault::new(
                        file,
                        lines.number,
                        "the line format is missing; export the mesh again",
                    ))
                };
            }
            has_format |= words.first() == Some(&"format");
            header.line(&words).map_err(|message| FileFault::new(file, lines.number, message))?;
        }
        let message = "this file is cut short: end_header is missing; copy it again or export the mesh again";
        Err(FileFault::new(file, lines.number, message))
    }

    /// Reads one line between the first and the last.
    fn line(&mut self, words: &[&str]) -> Result<(), String> {
        match words {
            [] | ["obj_info", ..] => {}
            ["comment", "TextureFile", name @ ..] => self.textures.push(name.join(" ")),
            ["comment", ..] => {}
            ["format", name, "1.0"] => {
                self.encoding = match *name {
                    "ascii" => NumberEncoding::Text,
                    "binary_little_endian" => NumberEncoding::LittleEndian,
                    "binary_big_endian" => NumberEncoding::BigEndian,
                    other => {
                        return Err(format!(
                            "the format '{}' is not read; export as ascii or binary_little_endian",
                            quoted(other.as_bytes())
                        ));
                    }
                };
            }
            ["element", name, count] => {
                let parsed = count.parse().map_err(|_| {
                    format!("'{}' is no number of rows; export the mesh again", quoted(count.as_bytes()))
                })?;
                if self.elements.iter().any(|e| e.name == *name) {
                    let name = quoted(name.as_bytes());
                    return Err(format!("the element {name} is declared twice; export the mesh again"));
                }
                let element = PlyElement { name: name.to_string(), count: parsed, properties: Vec::new() };
                self.elements.push(element);
            }
            ["property", "list", length, value, name] => {
                self.property(name, number_type(value)?, Some(number_type(length)?))?;
            }
            ["property", value, name] => self.property(name, number_type(value)?, None)?,
            other => {
                let line = quoted(other.join(" ").as_bytes());
                return Err(format!("'{line}' is no line of a PLY 1.0 header; export the mesh again"));
            }
        }
        Ok(())
    }

    fn property(&mut self, name: &str, value: ScalarType, length: Option<ScalarType>) -> Result<(), String> {
        let element = self.elements.last_mut();
        let element = element.ok_or("a property stands before any element; export the mesh again")?;
        element.properties.push(PlyProperty { name: name.to_string(), value, length });
        Ok(())
    }
}

/// The type of a name, of the first PLY programs or with the number of bits.
fn number_type(name: &str) -> Result<ScalarType, String> {
    let (kind, size) = match name {
        "char" | "int8" => ('i', 1),
        "uchar" | "uint8" => ('u', 1),
        "short" | "int16" => ('i', 2),
        "ushort" | "uint16" => ('u', 2),
        "int" | "int32" => ('i', 4),
        "uint" | "uint32" => ('u', 4),
        "int64" => ('i', 8),
        "uint64" => ('u', 8),
        "float" | "float32" => ('f', 4),
        "double" | "float64" => ('f', 8),
        other => {
            let name = quoted(other.as_bytes());
            return Err(format!("'{name}' is no type of PLY; export the mesh again"));
        }
    };
    Ok(ScalarType { kind, size })
}

/// The lines of a header. All end as the first does, so that the first byte of binary data is not taken for a line end.
struct HeaderLines<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Number of the line that was read last.
    number: usize,
    ending: &'static [u8],
}

impl<'a> HeaderLines<'a> {
    fn new(bytes: &'a [u8]) -> HeaderLines<'a> {
        let first = bytes.iter().position(|b| matches!(b, b'\r' | b'\n')).unwrap_or(bytes.len());
        let ending: &[u8] = match &bytes[first..] {
            [b'\r', b'\n', ..] => b"\r\n",
            [b'\r', ..] => b"\r",
            _ => b"\n",
        };
        HeaderLines { bytes, at: 0, number: 0, ending }
    }

    fn next_line(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        let length = rest.windows(self.ending.len()).position(|w| w == self.ending)?;
        self.at += length + self.ending.len();
        self.number += 1;
        Some(&rest[..length])
    }
}
