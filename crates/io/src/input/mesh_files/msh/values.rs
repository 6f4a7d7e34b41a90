//! Values that the sections of all versions share: counts, types of elements, positions of nodes.

use super::content::MshContent;
use super::element_types::MshElementType;
use crate::input::reading::error::FileFault;
use crate::input::reading::number_cursor::{NumberCursor, ScalarType, quoted};
use zonal_math::Vec3;

/// Whole numbers of four bytes.
pub(super) const INT: ScalarType = ScalarType { kind: 'i', size: 4 };
/// Lengths.
pub(super) const SIZE: ScalarType = ScalarType { kind: 'u', size: 8 };
/// Coordinates.
pub(super) const DOUBLE: ScalarType = ScalarType { kind: 'f', size: 8 };
/// The versions that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MshVersion {
    V2,
    V40,
    V41,
}

/// The count on a line of its own, which is text in binary files too.
pub(super) fn line_count(cursor: &mut NumberCursor<'_>) -> Result<u64, FileFault> {
    let line = cursor.line().unwrap_or_default().trim_ascii();
    let count = std::str::from_utf8(line).ok().and_then(|n| n.parse().ok());
    count.ok_or_else(|| {
        cursor.fault(format!("'{}' stands where a count is expected; export the mesh again", quoted(line)))
    })
}

/// The element type of a number.
pub(super) fn element_type(cursor: &NumberCursor<'_>, number: i64) -> Result<MshElementType, FileFault> {
    MshElementType::of_number(number).ok_or_else(|| {
        cursor.fault(format!(
            "elements of type {number} are not read; write the mesh with elements of first order: gmsh in.geo -2 -order 1 -o out.msh"
        ))
    })
}

/// Reads the coordinates of a node and adds it.
pub(super) fn read_position(
    cursor: &mut NumberCursor<'_>,
    tag: u64,
    content: &mut MshContent,
) -> Result<(), FileFault> {
    let position = [cursor.number(DOUBLE)?, cursor.number(DOUBLE)?, cursor.number(DOUBLE)?];
    if position.iter().any(|x| !x.is_finite()) {
        let message =
            format!("node {tag} has a coordinate that is not finite; mend it or export the mesh again");
        return Err(cursor.fault(message));
    }
    match content.nodes.insert(tag, Vec3::from_array(position)) {
        None => Ok(()),
        Some(_) => Err(cursor.fault(format!("node {tag} is given twice; export the mesh again"))),
    }
}
