//! VTK's XML files of surfaces: unstructured grids (.vtu) and polygonal data (.vtp), their points, cells and arrays of cell data.
//!
//! Arrays are text (`ascii`), base64 in the element (`binary`), or appended (`raw`, `base64`), each compressed by zlib or not. A file has one piece.
//! Before an array is decoded, its declared size is compared with the number of points or cells and with the size of the file. Whole numbers are exact
//! or refused.
//!
//! | module | contents |
//! |---|---|
//! | `xml` | elements and attributes |
//! | `byte_source` | raw and base64 bytes |
//! | `data_array` | decoding of one array |
//!
//! The reader is written here: no crate of the workspace parses XML, and the subset of VTK is small. Reference: VTK file formats, Kitware.

mod byte_source;
mod data_array;
mod xml;

use crate::input::reading::error::FileFault;
use data_array::{ArrayEntry, Encoding};
use xml::{Tag, TagReader};

/// Largest file, bytes.
pub(crate) const MAX_VTK_FILE_BYTES: u64 = 4 << 30;
/// Most arrays of a file.
const MAX_ARRAYS: usize = 10_000;

/// The kind of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum VtkKind {
    /// `.vtu`.
    UnstructuredGrid,
    /// `.vtp`.
    PolyData,
}

/// A file whose elements are known and whose arrays are decoded on request.
pub(crate) struct VtkFile<'a> {
    pub(crate) kind: VtkKind,
    pub(crate) file: &'a str,
    bytes: &'a [u8],
    encoding: Encoding,
    /// Sections with their arrays: `Points`, `Cells`, `CellData`, `Polys`, ….
    arrays: Vec<(String, ArrayEntry)>,
    pub(crate) points: usize,
    pub(crate) cells: usize,
    /// Cells of a polygonal file that are vertices, lines or strips.
    pub(crate) other_cells: usize,
}

impl<'a> VtkFile<'a> {
    /// Reads the elements of a file.
    pub(crate) fn parse(file: &'a str, bytes: &'a [u8]) -> Result<VtkFile<'a>, FileFault> {
        let fault = |message: &str| FileFault::new(file, "", message);
        let mut out = VtkFile {
            kind: VtkKind::UnstructuredGrid,
            file,
            bytes,
            encoding: Encoding::default(),
            arrays: Vec::new(),
            points: 0,
            cells: 0,
            other_cells: 0,
        };
        let mut reader = TagReader::new(bytes);
        let (mut section, mut pieces, mut root) = (String::new(), 0, false);
        while let Some(tag) = reader.next_tag().map_err(|e| FileFault::new(file, "", e))? {
            match tag.name.as_str() {
                "VTKFile" if !tag.closes => {
                    out.read_root(&tag)?;
                    root = true;
                }
                "Piece" if !tag.closes => {
                    pieces += 1;
                    out.read_piece(&tag)?;
                }
                "DataArray" if !tag.closes && !section.is_empty() => {
                    let text_start = reader.position();
                    out.arrays.push((section.clone(), ArrayEntry::of(&tag, text_start)));
                }
                "AppendedData" if !tag.closes => {
                    out.encoding.find_appended(&tag, bytes, reader.position());
                    break;
                }
                "Points" | "Cells" | "CellData" | "Polys" => {
                    section = if tag.closes || tag.is_empty { String::new() } else { tag.name };
                }
                // Arrays of points and of other cells are not read.
                "PointData" | "Verts" | "Lines" | "Strips" | "FieldData" => section.clear(),
                _ => {}
            }
            if out.arrays.len() > MAX_ARRAYS {
                return Err(fault("this file has more arrays than are read; save the ones you need"));
            }
        }
        match (root, pieces) {
            (false, _) => Err(fault("this is not an XML file of VTK; save it as .vtu or .vtp")),
            (_, 1) => Ok(out),
            (_, n) => Err(FileFault::new(
                file,
                "",
                format!("the file has {n} pieces; merge them into one (ParaView: Merge Blocks)"),
            )),
        }
    }

    fn read_root(&mut self, tag: &Tag) -> Result<(), FileFault> {
        self.kind = match tag.attribute("type") {
            Some("UnstructuredGrid") => VtkKind::UnstructuredGrid,
            Some("PolyData") => VtkKind::PolyData,
            other => {
                let kind = other.unwrap_or("nothing");
                let message = format!(
                    "data of type {kind} are not read; save an UnstructuredGrid (.vtu) or PolyData (.vtp)"
                );
                return Err(FileFault::new(self.file, "", message));
            }
        };
        self.encoding.read(tag).map_err(|e| FileFault::new(self.file, "", e))
    }

    fn read_piece(&mut self, tag: &Tag) -> Result<(), FileFault> {
        let count = |name: &str| match tag.attribute(name).map(|t| t.trim().parse::<usize>()) {
            None => Ok(0),
            Some(Ok(n)) => Ok(n),
            Some(Err(_)) => Err(FileFault::new(
                self.file,
                "Piece",
                format!("{name} is no whole number; save the file again"),
            )),
        };
        self.points = count("NumberOfPoints")?;
        self.cells = count("NumberOfCells")?.max(count("NumberOfPolys")?);
        self.other_cells = ["NumberOfVerts", "NumberOfLines", "NumberOfStrips"]
            .into_iter()
            .try_fold(0usize, |n, name| Ok(n.saturating_add(count(name)?)))?;
        Ok(())
    }

    /// Names of the arrays of cell data.
    pub(crate) fn cell_array_names(&self) -> Vec<&str> {
        self.arrays.iter().filter(|a| a.0 == "CellData").map(|a| a.1.name.as_str()).collect()
    }

    /// The values of an array of cell data, one for each cell.
    pub(crate) fn cell_values(&self, name: &str) -> Result<Vec<f64>, FileFault> {
        self.array("CellData", name, 1, self.cells)
    }

    /// The values of `rows` rows of an array with this number of components; an empty `name` takes the first of the section.
    pub(crate) fn array(
        &self,
        section: &str,
        name: &str,
        components: usize,
        rows: usize,
    ) -> Result<Vec<f64>, FileFault> {
        let found = self.arrays.iter().find(|a| a.0 == section && (name.is_empty() || a.1.name == name));
        let Some((_, entry)) = found else {
            let message = format!("{section} has no array '{name}'; save the file again");
            return Err(FileFault::new(self.file, "", message));
        };
        let place = || format!("array '{}'", entry.name);
        if entry.components != components {
            let message = format!(
                "the array has {} components where {components} is read; give a scalar array, or split it (ParaView: Calculator)",
                entry.components
            );
            return Err(FileFault::new(self.file, place(), message));
        }
        let wanted = rows.saturating_mul(components);
        entry.decode(self.bytes, &self.encoding, wanted).map_err(|e| FileFault::new(self.file, place(), e))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of one triangle and one array `T` of two forms.
    fn grid(attributes: &str, array: &str, appended: &str) -> Vec<u8> {
        format!(
            "<?xml version=\"1.0\"?>\n<!-- a > b --><VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\" {attributes}><UnstructuredGrid><Piece NumberOfPoints=\"3\" NumberOfCells=\"2\"><CellData Scalars='T'>{array}</CellData></Piece></UnstructuredGrid>{appended}</VTKFile>"
        )
        .into_bytes()
    }

    fn read(bytes: &[u8]) -> Result<Vec<f64>, String> {
        let file = VtkFile::parse("t.vtu", bytes).map_err(|e| e.to_string())?;
        assert_eq!(
            (file.kind, file.cells, file.cell_array_names()),
            (VtkKind::UnstructuredGrid, 2, vec!["T"])
        );
        file.cell_values("T").map_err(|e| e.to_string())
    }

    const T: &str = "<DataArray type=\"Float32\" Name=\"T\"";

    #[test]
    fn every_encoding_has_the_same_values() {
        let (wanted, header64) = (vec![300.5, 400.25], "header_type=\"UInt64\"");
        assert_eq!(
            read(&grid("", &format!("{T} format=\"ascii\">\n300.5 4.0025e2 </DataArray>"), "")),
            Ok(wanted.clone())
        );
        // Length and values together, and apart.
        for text in ["CAAAAABAlkMAIMhD", "CAAAAA==AECWQwAgyEM="] {
            assert_eq!(
                read(&grid("", &format!("{T} format=\"binary\">\n {text}\n</DataArray>"), "")),
                Ok(wanted.clone())
            );
        }
        let appended = |encoding: &str, data: &[u8]| {
            let array = format!("{T} format=\"appended\" offset=\"0\"/>");
            let text = grid(
                header64,
                &array,
                &format!("<AppendedData encoding=\"{encoding}\">\n _@</AppendedData>"),
            );
            let at = text.iter().position(|b| *b == b'@').unwrap();
            [&text[..at], data, &text[at + 1..]].concat()
        };
        let mut raw = 8u64.to_le_bytes().to_vec();
        raw.extend([300.5f32, 400.25].iter().flat_map(|x| x.to_le_bytes()));
        assert_eq!(read(&appended("raw", &raw)), Ok(wanted.clone()));
        assert_eq!(read(&appended("base64", b"CAAAAAAAAAAAQJZDACDIQw==")), Ok(wanted.clone()));
        // Two blocks of zlib.
        let zipped: Vec<Vec<u8>> = [300.5f32, 400.25].iter().map(|x| zlib(&x.to_le_bytes())).collect();
        let mut packed: Vec<u8> = [2, 4, 4, zipped[0].len(), zipped[1].len()]
            .iter()
            .flat_map(|n| (*n as u64).to_le_bytes())
            .collect();
        packed.extend(zipped.concat());
        let mut file = appended("raw", &packed);
        let at = file.windows(11).position(|w| w == b"header_type").unwrap();
        file.splice(at..at, b"compressor=\"vtkZLibDataCompressor\" ".iter().copied());
        assert_eq!(read(&file), Ok(wanted));
        // A partial last block is declared by its size.
        let cut = file.len() - 30;
        assert!(read(&file[..cut]).is_err());
    }

    fn zlib(bytes: &[u8]) -> Vec<u8> {
        use std::io::Write;
        let mut out = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        out.write_all(bytes).unwrap();
        out.finish().unwrap()
    }

    #[test]
    fn wrong_files_are_refused_with_a_place() {
        let array = |text: &str| format!("{T} format=\"ascii\">{text}</DataArray>");
        for (bytes, wanted) in [
            (b"solid".to_vec(), "is not an XML file"),
            (grid("", &array("300.5"), ""), "array 'T': the array has 1 values where 2"),
            (grid("", &array("300.5 x"), ""), "'x' is no number"),
            (
                grid("", &format!("{T} NumberOfComponents=\"3\" format=\"ascii\">1</DataArray>"), ""),
                "3 components",
            ),
            (grid("", &format!("{T} format=\"appended\" offset=\"0\"/>"), ""), "no appended data"),
            (grid("", &format!("{T} format=\"binary\">/////w==</DataArray>"), ""), "cut short"),
            (grid("compressor=\"vtkLZ4DataCompressor\"", &array("1 2"), ""), "zlib"),
            (
                grid("", "<DataArray type=\"String\" Name=\"T\" format=\"ascii\">1 2</DataArray>", ""),
                "type String",
            ),
        ] {
            let error = read(&bytes).unwrap_err();
            assert!(error.contains(wanted) && error.starts_with("t.vtu"), "{error}");
        }
    }

    #[test]
    fn altered_files_do_not_panic() {
        let whole = grid("", &format!("{T} format=\"binary\">CAAAAABAlkMAIMhD</DataArray>"), "");
        for cut in 0..whole.len() {
            let _ = VtkFile::parse("t.vtu", &whole[..cut]).map(|f| f.cell_values("T").is_ok());
            let mut altered = whole.clone();
            altered[cut] ^= 0x15;
            let _ = VtkFile::parse("t.vtu", &altered).map(|f| f.cell_values("T").is_ok());
        }
    }
}
