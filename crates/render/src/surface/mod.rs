//! Interpolated fields on surfaces and panes.
//!
//! | module | contents |
//! |---|---|
//! | `tiles` | patches and pane pieces as tiles of their plates, fields on them |
//! | `patch_field` | a field, smooth across tiles and sharp at creases and walls |

pub(crate) mod patch_field;
pub(crate) mod tiles;
