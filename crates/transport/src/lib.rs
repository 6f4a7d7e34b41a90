//! Ray queries on a scene: visibility, optical depth, direct light, and the cut of the scene into zones.
//!
//! The transmittance between two points a and b is
//!
//! ```text
//! τ(a, b) = 0 where a facet crosses the open segment, else exp(−∫ κ ds − Σ_panes κ t/|cosθ|)
//! ```
//!
//! with the extinction κ of the medium and the panes (1/m), the thickness t of a pane (m) and the angle θ between segment and pane
//! normal.
//!
//! | module | content |
//! |---|---|
//! | `transport` | [`Transport`]: visibility and closest-hit queries |
//! | `optical_depth` | optical depths and transmittances of [`Transport`] |
//! | [`zoning`] | [`build_zones`]: patches, free parts of voxels, pieces of panes |
//! | [`lights`] | direct light of suns, skies and emitters at a point |
//! | [`solid_angle`] | solid angle of a plate in closed form |
//! | [`patch_locator`] | the patch of a facet that holds a point |
//! | [`plate_boxes`] | plates whose bounds hold a point |
//! | [`point_grids`] | points near a place, by sorted cells of several sizes |
//! | `intersect` | watertight ray–plate intersection in double precision |
//! | `bvh` | bounding volume hierarchy over plates |
//! | `occluder_culling` | facets that never occlude: the walls of a convex room |
//! | `shaft_culling` | facets that occlude no segment between two zones |
//! | `grid_traversal` | cells of the voxel grid along a segment |
//! | `uniform_blocks` | blocks of cells of equal extinction |
//! | `solids` | points in solid material and points outside every closed room |
//!
//! The crate reads the scene and never changes it; it does not depend on radiosities or exchange factors.

mod bvh;
mod grid_traversal;
mod intersect;
pub mod lights;
mod occluder_culling;
mod optical_depth;
pub mod patch_locator;
pub mod plate_boxes;
pub mod point_grids;
mod shaft_culling;
pub mod solid_angle;
mod solids;
mod transport;
mod uniform_blocks;
pub mod zoning;

pub use shaft_culling::ShaftEnd;
pub use transport::{Hit, PaneHit, Transport};
pub use zoning::{WorkSharing, build_shared_zones, build_zones, zones_of_bands};
