//! The sections of a file of Gmsh: `$Name`, its contents, `$EndName`.

use super::content::MshContent;
use super::values::{MshVersion, line_count};
use super::{entity_sections, legacy_sections};
use crate::input::reading::error::FileFault;
use crate::input::reading::number_cursor::{NumberCursor, NumberEncoding, quoted};

/// Command that writes a file in a version that is read.
const CONVERSION: &str = "gmsh in.msh -save -format msh41 -o out.msh";
/// Command that joins the partitions of a file.
const JOINING: &str = "gmsh in.msh -save -format msh22 -o out.msh";
/// Command that converts a mesh of another program with the same extension.
const FLUENT_CONVERSION: &str = "meshio convert --input-format ansys --output-format gmsh22 in.msh out.msh";

/// Reads all sections.
pub(super) fn read(file: &str, bytes: &[u8]) -> Result<MshContent, FileFault> {
    let mut cursor = NumberCursor::new(file, bytes, 0, NumberEncoding::Text);
    if bytes.trim_ascii_start().starts_with(b"(") {
        return Err(not_gmsh(&cursor, "("));
    }
    let mut content = MshContent::default();
    let mut version = None;
    let mut has_elements = false;
    while let Some(name) = next_section(&mut cursor)? {
        match (name, version) {
            ("MeshFormat", None) => version = Some(read_format(&mut cursor)?),
            (other, None) => return Err(not_gmsh(&cursor, other)),
            ("ParametricNodes", Some(MshVersion::V2)) => {
                legacy_sections::read_parametric_nodes(&mut cursor, &mut content)?;
            }
            ("PhysicalNames", Some(_)) => read_names(&mut cursor, &mut content)?,
            ("Nodes", Some(MshVersion::V2)) => legacy_sections::read_nodes(&mut cursor, &mut content)?,
            ("Elements", Some(MshVersion::V2)) => legacy_sections::read_elements(&mut cursor, &mut content)?,
            ("Entities" | "Nodes" | "Elements", Some(v)) => {
                entity_sections::read(name, v, &mut cursor, &mut content)?;
            }
            ("PartitionedEntities", Some(_)) => {
                return Err(cursor.fault(format!("meshes in partitions are not read; join them: {JOINING}")));
            }
            (other, Some(_)) => {
                skip_section(&mut cursor, other)?;
                continue;
            }
        }
        has_elements |= name == "Elements";
        expect_end(&mut cursor, name)?;
    }
    match (version, has_elements && !content.nodes.is_empty()) {
        (Some(_), true) => Ok(content),
        (None, _) => {
            Err(cursor.fault("this is no file of Gmsh: $MeshFormat is missing; export the mesh again"))
        }
        _ => {
            let message = "this file has no nodes or no $Elements; it is cut short, or has no mesh: gmsh in.geo -2 -o out.msh";
            Err(cursor.fault(message))
        }
    }
}

/// Why a file is refused whose first section has this name.
fn not_gmsh(cursor: &NumberCursor<'_>, first: &str) -> FileFault {
    cursor.fault(match first {
        "(" => format!("this is a mesh of Ansys Fluent, which is not read; convert it: {FLUENT_CONVERSION}"),
        "NOD" | "NOE" => format!("this is a file of version 1, which is not read; convert it: {CONVERSION}"),
        _ => "this is no file of Gmsh: it does not begin with $MeshFormat; export the mesh again".into(),
    })
}

/// The name of the next section; none at the end of the file.
fn next_section<'a>(cursor: &mut NumberCursor<'a>) -> Result<Option<&'a str>, FileFault> {
    while let Some(line) = cursor.line() {
        let line = line.trim_ascii();
        if line.is_empty() {
            continue;
        }
        let name = line.strip_prefix(b"$").and_then(|n| std::str::from_utf8(n).ok());
        return match name {
            Some(name) => Ok(Some(name)),
            None => Err(cursor.fault(format!(
                "'{}' stands where a section begins, as $Nodes; export the mesh again",
                quoted(line)
            ))),
        };
    }
    Ok(None)
}

/// Reads `$EndName`.
fn expect_end(cursor: &mut NumberCursor<'_>, name: &str) -> Result<(), FileFault> {
    let ends = |found: &str| found.strip_prefix("End") == Some(name);
    match next_section(cursor) {
        Ok(Some(found)) if ends(found) => Ok(()),
        _ => Err(cursor.fault(format!(
            "the section ${name} does not end where its count says; it is cut short: export the mesh again"
        ))),
    }
}

/// Goes to the end of a section that is not read, text or not.
fn skip_section(cursor: &mut NumberCursor<'_>, name: &str) -> Result<(), FileFault> {
    let end = format!("$End{name}");
    let rest = cursor.rest();
    match rest.windows(end.len()).position(|w| w == end.as_bytes()) {
        Some(at) => {
            cursor.skip(at + end.len());
            Ok(())
        }
        None => {
            let name = quoted(name.as_bytes());
            Err(cursor.fault(format!(
                "the section ${name} has no end; the file is cut short: export the mesh again"
            )))
        }
    }
}

/// Reads version, kind and size of lengths, and in a binary file the number 1 in its byte order.
fn read_format(cursor: &mut NumberCursor<'_>) -> Result<MshVersion, FileFault> {
    let line = cursor.line().unwrap_or_default();
    let text = String::from_utf8_lossy(line);
    let words: Vec<&str> = text.split_whitespace().collect();
    let version = match words.first() {
        Some(&"4" | &"4.0") => MshVersion::V40,
        Some(&"4.1") => MshVersion::V41,
        Some(&v) if v == "2" || v.starts_with("2.") => MshVersion::V2,
        other => {
            let shown = quoted(other.unwrap_or(&"").as_bytes());
            return Err(cursor.fault(format!(
                "version '{shown}' is not read, only 2.x, 4.0 and 4.1; convert it: {CONVERSION}"
            )));
        }
    };
    match words[1..] {
        ["0", ..] => {}
        ["1", "8"] => {
            cursor.encoding = match cursor.rest().get(..4) {
                Some([1, 0, 0, 0]) => NumberEncoding::LittleEndian,
                Some([0, 0, 0, 1]) => NumberEncoding::BigEndian,
                _ => {
                    return Err(cursor
                        .fault("the byte order of this binary file is not known; export the mesh again"));
                }
            };
            cursor.skip(4);
        }
        _ => {
            let message =
                format!("the line of the format is not VERSION 0 8 or VERSION 1 8; convert it: {CONVERSION}");
            return Err(cursor.fault(message));
        }
    }
    Ok(version)
}

/// Reads the names of physical groups, which are text in binary files too: dimension, number, name.
fn read_names(cursor: &mut NumberCursor<'_>, content: &mut MshContent) -> Result<(), FileFault> {
    let count = line_count(cursor)?;
    for _ in 0..count {
        let fault = "the names of physical groups are cut short; export the mesh again";
        let line = cursor.line().ok_or_else(|| cursor.fault(fault))?;
        let text = String::from_utf8_lossy(line);
        let text = text.trim();
        let (numbers, name) = text.split_once('"').unwrap_or((text, ""));
        let name = name.strip_suffix('"').unwrap_or(name).trim();
        let numbers: Option<Vec<i64>> = numbers.split_whitespace().map(|n| n.parse().ok()).collect();
        // Version 2.0 has no dimension.
        let (dimensions, group) = match numbers.as_deref() {
            Some([dimension, group]) => ([*dimension; 2], *group),
            Some([group]) => ([2, 3], *group),
            _ => {
                let shown = quoted(text.as_bytes());
                return Err(cursor.fault(format!(
                    "'{shown}' is no name of a physical group (dimension, number, \"name\"); mend this line"
                )));
            }
        };
        for dimension in dimensions {
            if let (Ok(dimension), false) = (u8::try_from(dimension), name.is_empty()) {
                content.group_names.insert((dimension, group), name.to_string());
            }
        }
    }
    Ok(())
}
