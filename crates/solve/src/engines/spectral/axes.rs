//! Numbering of the axes.

/// The two other axes of each axis, ascending.
pub(crate) const OTHER_AXES: [[usize; 2]; 3] = [[1, 2], [0, 2], [0, 1]];
