//! VTK's XML files with appended raw data, for ParaView and other programs that use its library.
//!
//! ```text
//! <VTKFile type=… byte_order="LittleEndian" header_type="UInt64">
//!   … one <DataArray format="appended" offset=…> an array …
//!   <AppendedData encoding="raw">_ then, one array after the other: its length in bytes (u64), its values
//! ```
//!
//! Values are computed while they are written; no array is held in memory. Names of arrays include the unit, `radiosity [W/m2]`; arrays of
//! bands have one component for each band, with its name. Names of surfaces, panes and groups are string arrays of the field data.

use crate::output::atomic::write_atomic;
use crate::output::error::FileError;
use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::Path;
use zonal_scene::{BandSet, Bands};

/// Type of the written values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::output) enum NumberType {
    Float64,
    Int64,
    UInt8,
}

impl NumberType {
    fn size(self) -> usize {
        if self == NumberType::UInt8 { 1 } else { 8 }
    }
}

/// Up to three components of a tuple.
type Components<'a> = Box<dyn Fn(usize) -> [f64; 3] + 'a>;

/// An array of numbers.
pub(in crate::output) struct DataArray<'a> {
    name: String,
    number: NumberType,
    tuples: usize,
    /// Up to three components each, with their number.
    parts: Vec<(usize, Components<'a>)>,
    /// Names of the components of bands; empty for other arrays.
    bands: Vec<String>,
}

/// The name of the array of a field, in W/m².
pub(super) fn name_with_unit(field: &str) -> String {
    format!("{} [W/m2]", field.replace('_', " "))
}

impl<'a> DataArray<'a> {
    /// One value for each tuple.
    pub(in crate::output) fn scalar(
        name: &str,
        number: NumberType,
        tuples: usize,
        value: impl Fn(usize) -> f64 + 'a,
    ) -> DataArray<'a> {
        let value = Box::new(move |i| [value(i), 0.0, 0.0]);
        DataArray { name: name.into(), number, tuples, parts: vec![(1, value)], bands: Vec::new() }
    }
    /// Three doubles for each tuple.
    pub(in crate::output) fn vectors(
        name: &str,
        tuples: usize,
        value: impl Fn(usize) -> [f64; 3] + 'a,
    ) -> DataArray<'a> {
        DataArray {
            name: name.into(),
            number: NumberType::Float64,
            tuples,
            parts: vec![(3, Box::new(value))],
            bands: Vec::new(),
        }
    }
    /// The bands of each tuple.
    pub(in crate::output) fn bands(
        name: &str,
        tuples: usize,
        value: impl Fn(usize) -> Bands + 'a,
    ) -> DataArray<'a> {
        let bands = BandSet::default();
        let names = (0..bands.count()).map(|b| bands.name(b)).collect();
        DataArray { bands: names, ..DataArray::vectors(name, tuples, move |i| value(i).to_rgb()) }
    }
    /// The arrays of all blocks of bands, each a list with the same names: arrays of bands with one component for each band, and all others of the
    /// first block.
    pub(in crate::output) fn joined(
        bands: &BandSet,
        mut blocks: Vec<Vec<DataArray<'a>>>,
    ) -> Vec<DataArray<'a>> {
        if bands.is_rgb() {
            return blocks.swap_remove(0);
        }
        let names: Vec<String> = (0..bands.count()).map(|b| bands.name(b)).collect();
        let further = blocks.split_off(1);
        let mut arrays = blocks.swap_remove(0);
        for array in arrays.iter_mut().filter(|a| !a.bands.is_empty()) {
            array.bands = names.clone();
            array.parts[0].0 = bands.window(0).len();
        }
        for (t, list) in further.into_iter().enumerate() {
            for other in list.into_iter().filter(|a| !a.bands.is_empty()) {
                let Some(array) = arrays.iter_mut().find(|a| a.name == other.name) else { continue };
                array.parts.extend(other.parts.into_iter().map(|p| (bands.window(t + 1).len(), p.1)));
            }
        }
        arrays
    }

    fn components(&self) -> usize {
        self.parts.iter().map(|p| p.0).sum()
    }

    fn bytes(&self) -> u64 {
        (self.number.size() * self.components() * self.tuples) as u64
    }

    fn write(&self, out: &mut impl Write) -> io::Result<()> {
        out.write_all(&self.bytes().to_le_bytes())?;
        for i in 0..self.tuples {
            for x in self.parts.iter().flat_map(|(n, value)| value(i).into_iter().take(*n)) {
                match self.number {
                    NumberType::Float64 => out.write_all(&x.to_le_bytes())?,
                    NumberType::Int64 => out.write_all(&(x as i64).to_le_bytes())?,
                    NumberType::UInt8 => out.write_all(&[x as u8])?,
                }
            }
        }
        Ok(())
    }
}

/// A file: XML that refers to arrays, then the arrays.
pub(in crate::output) struct VtkDocument<'a> {
    kind: &'static str,
    xml: String,
    arrays: Vec<DataArray<'a>>,
    offset: u64,
}

impl<'a> VtkDocument<'a> {
    /// An empty document of VTK's type `kind`, whose element has these attributes.
    pub(in crate::output) fn new(kind: &'static str, attributes: &str) -> VtkDocument<'a> {
        let xml = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"{kind}\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<{kind}{attributes}>\n"
        );
        VtkDocument { kind, xml, arrays: Vec::new(), offset: 0 }
    }

    /// Field data: lists of names.
    pub(in crate::output) fn names(&mut self, lists: &[(&str, Vec<&str>)]) {
        self.xml.push_str("<FieldData>\n");
        for (name, list) in lists.iter().filter(|l| !l.1.is_empty()) {
            let n = list.len();
            let _ = write!(
                self.xml,
                "<Array type=\"String\" Name=\"{}\" NumberOfTuples=\"{n}\" format=\"ascii\">",
                escape(name)
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
    pub(in crate::output) fn open(&mut self, element: &str) {
        let _ = writeln!(self.xml, "<{element}>");
    }

    /// Closes an element.
    pub(in crate::output) fn close(&mut self, element: &str) {
        let _ = writeln!(self.xml, "</{element}>");
    }

    /// An element with these arrays.
    pub(in crate::output) fn section(&mut self, element: &str, arrays: Vec<DataArray<'a>>) {
        self.open(element);
        for a in arrays {
            let bands = match a.bands.len() {
                0 => String::new(),
                n => {
                    let names = a.bands.iter().enumerate();
                    let names: String =
                        names.map(|(k, name)| format!(" ComponentName{k}=\"{}\"", escape(name))).collect();
                    format!(" NumberOfComponents=\"{n}\"{names}")
                }
            };
            let bands = if element == "Points" { " NumberOfComponents=\"3\"" } else { bands.as_str() };
            let _ = writeln!(
                self.xml,
                "<DataArray type=\"{:?}\" Name=\"{}\"{bands} format=\"appended\" offset=\"{}\"/>",
                a.number,
                escape(&a.name),
                self.offset
            );
            self.offset += 8 + a.bytes();
            self.arrays.push(a);
        }
        self.close(element);
    }

    /// Writes the file.
    pub(in crate::output) fn write(&self, path: &Path) -> Result<(), FileError> {
        write_atomic(path, |out| {
            out.write_all(self.xml.as_bytes())?;
            write!(out, "</{}>\n<AppendedData encoding=\"raw\">\n_", self.kind)?;
            self.arrays.iter().try_for_each(|a| a.write(out))?;
            write!(out, "\n</AppendedData>\n</VTKFile>\n")
        })
    }
}

/// Text for an attribute; characters that XML cannot hold become blanks.
fn escape(text: &str) -> String {
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
    fn arrays_lie_at_the_offsets_of_the_text() {
        let path = std::env::temp_dir().join(format!("zonal-vtk-{}.vti", std::process::id()));
        let mut d = VtkDocument::new("ImageData", " WholeExtent=\"0 1 0 1 0 2\"");
        d.names(&[("names <&>", vec!["a\0b", "ü"])]);
        let first = DataArray::bands("B \"[W/m2]\"\n", 2, |i| Bands::from_rgb([i as f64, 0.5, -1.0]));
        d.section(
            "CellData",
            vec![first, DataArray::scalar("zone", NumberType::Int64, 2, |i| 7.0 - i as f64)],
        );
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
