//! Surfaces from mesh files.

use super::build::Builder;
use super::error::InputError;
use super::node::{Node, Table};
use super::surface::Look;

/// `mesh = { file, … }` of a surface.
pub(crate) fn read_mesh_surface(
    _table: &Table<'_>,
    node: &Node<'_>,
    _name: &str,
    _look: Look,
    _b: &mut Builder<'_>,
) -> Result<(), InputError> {
    Err(node.error("meshes are not read yet; use an inline shape"))
}
