//! Interpolated fields on surfaces and panes.
//!
//! | module | contents |
//! |---|---|
//! | `tiles` | patches and pane pieces as tiles of their plates, fields on them |
//! | `curved_facets` | means of patches as a curved surface has them |
//! | `shading` | points of flat and of curved surfaces that receive light |
//! | `patch_field` | a field, smooth across tiles and sharp at creases and walls |

pub(crate) mod curved_facets;
pub(crate) mod patch_field;
pub(crate) mod shading;
pub(crate) mod tiles;
