//! What a ray meets: visibility, optical depth, free space, and the zones that follow from them.
//!
//! One question runs through everything: what lies between two points? Opaque facets block, panes and the voxmap dim:
//!
//! ```text
//! τ(a, b) = 0 where a facet crosses the open segment, else exp(−∫ κ ds − Σ_panes κ t/|cosθ|)
//! ```
//!
//! | module | what |
//! |---|---|
//! | [`transport`] | [`Transport`]: the questions, answered |
//! | [`zoning`] | [`build_zones`]: patches, free parts of voxels, pieces of panes |
//! | [`direct`] | sun, sky and small emitters at a point |
//! | `cluster` | which of many shining facets to ask |
//! | `emitter` | points of a lamp, by area and by solid angle |
//! | [`solid_angle`] | a plate seen from a point, in closed form |
//! | [`sheets`] | which patch of a facet holds a point |
//! | `meet` | a line and a plate, watertight, in double precision |
//! | `bvh` | the tree that finds the plates worth asking |
//! | `hull` | facets that can never block: the walls of a convex room |
//! | `shaft` | facets that can block no segment between two zones |
//! | `walk` | a segment through the voxmap, cell by cell |
//! | `solid` | which points lie in solid material, and which outside every closed room |
//!
//! This room knows no radiosity and no form factor. It reads the scene and never changes it.

mod bvh;
mod cluster;
pub mod direct;
mod emitter;
mod hull;
mod meet;
mod shaft;
pub mod sheets;
mod solid;
pub mod solid_angle;
pub mod transport;
mod walk;
pub mod zoning;

pub use shaft::End;
pub use transport::{Hit, PaneHit, Transport};
pub use zoning::build_zones;
