//! The chapel: a room of 6 m × 10 m with stained glass and dusty air.

use crate::Size;

/// The scene file, with `PATCH` in the place of the largest edge of a patch in m and `CELLS` in that of the voxels along each axis.
const CHAPEL_TEMPLATE: &str = include_str!("chapel.toml.in");

/// The chapel as a scene file.
pub fn chapel_text(size: Size) -> String {
    let (patch, cells) = match size {
        Size::Small => ("0.9", "[7, 12, 5]"),
        Size::Full => ("0.5", "[14, 24, 10]"),
    };
    CHAPEL_TEMPLATE.replace("PATCH", patch).replace("CELLS", cells)
}
