//! VTK's XML files, for ParaView and all that reads with its library.
//!
//! ```text
//! <VTKFile type=… byte_order="LittleEndian" header_type="UInt64">
//!   … one <DataArray format="appended" offset=…> an array …
//!   <AppendedData encoding="raw">_ then, one array after the other: its length in bytes (u64), its values
//! ```
//!
//! Values are computed while they are written: no array is held whole. Every array says its unit in its name, `radiosity [W/m2]`; of three
//! bands it has three components, named red, green and blue. Names of surfaces, panes and groups are string arrays of the field data.

use super::FileError;
use super::atomic::write_atomic;
use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::Path;
use zonal_scene::Bands;

/// How values are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    Float64,
    Int64,
    UInt8,
}

impl Number {
    fn size(self) -> usize {
        if self == Number::UInt8 { 1 } else { 8 }
    }
}

/// An array: one value or three a tuple.
pub(super) struct Array<'a> {
    name: String,
    number: Number,
    parts: usize,
    tuples: usize,
    value: Box<dyn Fn(usize) -> Bands + 'a>,
}

impl<'a> Array<'a> {
    /// One value a tuple.
    pub(super) fn one(
        name: &str,
        number: Number,
        tuples: usize,
        value: impl Fn(usize) -> f64 + 'a,
    ) -> Array<'a> {
        let value = Box::new(move |i| [value(i), 0.0, 0.0]);
        Array { name: name.into(), number, parts: 1, tuples, value }
    }
    /// Three reals a tuple.
    pub(super) fn three(name: &str, tuples: usize, value: impl Fn(usize) -> Bands + 'a) -> Array<'a> {
        Array { name: name.into(), number: Number::Float64, parts: 3, tuples, value: Box::new(value) }
    }

    fn bytes(&self) -> u64 {
        (self.number.size() * self.parts * self.tuples) as u64
    }

    fn write(&self, out: &mut impl Write) -> io::Result<()> {
        out.write_all(&self.bytes().to_le_bytes())?;
        for i in 0..self.tuples {
            for x in &(self.value)(i)[..self.parts] {
                match self.number {
                    Number::Float64 => out.write_all(&x.to_le_bytes())?,
                    Number::Int64 => out.write_all(&(*x as i64).to_le_bytes())?,
                    Number::UInt8 => out.write_all(&[*x as u8])?,
                }
            }
        }
        Ok(())
    }
}

/// A file: XML with places for arrays, then the arrays.
pub(super) struct Document<'a> {
    kind: &'static str,
    xml: String,
    arrays: Vec<Array<'a>>,
    offset: u64,
}

impl<'a> Document<'a> {
    /// An empty document of VTK's type `kind`, whose element has these attributes.
    pub(super) fn new(kind: &'static str, attributes: &str) -> Document<'a> {
        let xml = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"{kind}\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<{kind}{attributes}>\n"
        );
        Document { kind, xml, arrays: Vec::new(), offset: 0 }
    }

    /// Field data: lists of names.
    pub(super) fn names(&mut self, lists: &[(&str, Vec<&str>)]) {
        self.xml.push_str("<FieldData>\n");
        for (name, list) in lists.iter().filter(|l| !l.1.is_empty()) {
            let n = list.len();
            let _ = write!(
                self.xml,
                "<Array type=\"String\" Name=\"{}\" NumberOfTuples=\"{n}\" format=\"ascii\">",
                escaped(name)
            );
            for text in list {
                text.bytes().filter(|b| *b != 0).for_each(|b| {
                    let _ = write!(self.xml, "{b} ");
                });
                self.xml.push_str("0 ");
            }
            self.xml.push_str("</Array>\n");
        }
        self.xml.push_str("</FieldData>\n");
    }

    /// Opens an element.
    pub(super) fn open(&mut self, element: &str) {
        let _ = writeln!(self.xml, "<{element}>");
    }

    /// Closes an element.
    pub(super) fn close(&mut self, element: &str) {
        let _ = writeln!(self.xml, "</{element}>");
    }

    /// An element with these arrays.
    pub(super) fn section(&mut self, element: &str, arrays: Vec<Array<'a>>) {
        self.open(element);
        for a in arrays {
            let bands = match a.parts {
                1 => String::new(),
                n => format!(
                    " NumberOfComponents=\"{n}\" ComponentName0=\"red\" ComponentName1=\"green\" ComponentName2=\"blue\""
                ),
            };
            let bands = if element == "Points" { " NumberOfComponents=\"3\"" } else { bands.as_str() };
            let _ = writeln!(
                self.xml,
                "<DataArray type=\"{:?}\" Name=\"{}\"{bands} format=\"appended\" offset=\"{}\"/>",
                a.number,
                escaped(&a.name),
                self.offset
            );
            self.offset += 8 + a.bytes();
            self.arrays.push(a);
        }
        self.close(element);
    }

    /// Writes it.
    pub(super) fn write(&self, path: &Path) -> Result<(), FileError> {
        write_atomic(path, |out| {
            out.write_all(self.xml.as_bytes())?;
            write!(out, "</{}>\n<AppendedData encoding=\"raw\">\n_", self.kind)?;
            self.arrays.iter().try_for_each(|a| a.write(out))?;
            write!(out, "\n</AppendedData>\n</VTKFile>\n")
        })
    }
}

/// Text for an attribute; what XML cannot hold becomes a blank.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_lie_where_the_text_says() {
        let path = std::env::temp_dir().join(format!("zonal-vtk-{}.vti", std::process::id()));
        let mut d = Document::new("ImageData", " WholeExtent=\"0 1 0 1 0 2\"");
        d.names(&[("names <&>", vec!["a\0b", "ü"])]);
        let first = Array::three("B \"[W/m2]\"\n", 2, |i| [i as f64, 0.5, -1.0]);
        d.section("CellData", vec![first, Array::one("zone", Number::Int64, 2, |i| 7.0 - i as f64)]);
        d.write(&path).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        assert!(text.contains("Name=\"B &quot;[W/m2]&quot; \" NumberOfComponents=\"3\""));
        assert!(text.contains(
            "Name=\"names &lt;&amp;&gt;\" NumberOfTuples=\"2\" format=\"ascii\">97 98 0 195 188 0 "
        ));
        assert!(text.contains("type=\"Int64\" Name=\"zone\" format=\"appended\" offset=\"56\""));
        let start = bytes.windows(2).position(|w| w == b"\n_").unwrap() + 2;
        let word = |at: usize| <[u8; 8]>::try_from(&bytes[start + at..start + at + 8]).unwrap();
        assert_eq!(u64::from_le_bytes(word(0)), 48);
        assert_eq!(f64::from_le_bytes(word(8 + 24)), 1.0);
        assert_eq!((u64::from_le_bytes(word(56)), i64::from_le_bytes(word(72))), (16, 6));
        std::fs::remove_file(&path).unwrap();
    }
}
