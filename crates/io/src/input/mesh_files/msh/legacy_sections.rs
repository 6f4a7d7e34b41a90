//! Nodes and elements of versions 2.x: each element has its own type and tags, of which the first is its physical group.
//!
//! In a binary file elements of one type follow a header of three numbers: type, number of elements, number of tags.

use super::content::{MshContent, NO_GROUP};
use super::values::{DOUBLE, INT, element_type, line_count, read_position};
use crate::input::reading::error::FileFault;
use crate::input::reading::number_cursor::{NumberCursor, NumberEncoding};

/// Reads `$Nodes`.
pub(super) fn read_nodes(cursor: &mut NumberCursor<'_>, content: &mut MshContent) -> Result<(), FileFault> {
    for _ in 0..line_count(cursor)? {
        let tag = cursor.count(INT)?;
        read_position(cursor, tag, content)?;
    }
    Ok(())
}

/// Reads `$ParametricNodes`: dimension and number of the entity of each node, and its parameters there.
pub(super) fn read_parametric_nodes(
    cursor: &mut NumberCursor<'_>,
    content: &mut MshContent,
) -> Result<(), FileFault> {
    for _ in 0..line_count(cursor)? {
        let tag = cursor.count(INT)?;
        read_position(cursor, tag, content)?;
        let dimension = cursor.integer(INT)?;
        cursor.integer(INT)?;
        let parameters = if matches!(dimension, 1 | 2) { dimension } else { 0 };
        for _ in 0..parameters {
            cursor.number(DOUBLE)?;
        }
    }
    Ok(())
}

/// Reads `$Elements`.
pub(super) fn read_elements(
    cursor: &mut NumberCursor<'_>,
    content: &mut MshContent,
) -> Result<(), FileFault> {
    let count = line_count(cursor)?;
    let is_text = cursor.encoding == NumberEncoding::Text;
    let mut nodes = Vec::new();
    let mut read = 0;
    while read < count {
        if is_text {
            cursor.integer(INT)?;
        }
        let kind = cursor.integer(INT)?;
        let kind = element_type(cursor, kind)?;
        let elements = if is_text { 1 } else { cursor.count(INT)? };
        let tags = cursor.count(INT)?;
        for _ in 0..elements {
            if !is_text {
                cursor.integer(INT)?;
            }
            let mut group = NO_GROUP;
            for k in 0..tags {
                let tag = cursor.integer(INT)?;
                group = if k == 0 { tag.saturating_abs() } else { group };
            }
            nodes.clear();
            for _ in 0..kind.nodes {
                nodes.push(cursor.count(INT)?);
            }
            content.push(kind, group, &nodes);
        }
        read = read.saturating_add(elements);
    }
    Ok(())
}
