//! View factors of all pairs of many convex polygons with obstructions, without a medium: sparse, with an error radius for each factor.
//!
//! ```text
//! A_i F_ij = (1/π) ∬ cosθ_i cosθ_j V/r² dA dA = A_j F_ji        V: visibility;        Σ_j F_ij + F_i,sky + F_i,ground = 1
//! ```
//!
//! | module | content |
//! |---|---|
//! | `batches` | batches of tasks in one parallel loop |
//! | `bounds` | boxes and their trees; occluders that may hide something between two boxes (`shaft`); cells of directions |
//! | `geometry` | facets and occluders with their trees, cones of normals; coplanar facets merged to large convex occluders (`occluders`), one that hides everything (`blocking`), those that adjoin their images (`endless`) |
//! | `facet_set` | surfaces of several polygons, surfaces cut out of others |
//! | `periods`, `image_choice` | periodic geometry: images, and how many |
//! | `sky` | the surroundings, independent of the pairs |
//! | `strings` | geometries extruded along a period: crossed strings in the cross-section, exact |
//! | `script_f` | total exchange factors of grey surfaces |
//! | `parts` | the result as plain lists |
//! | `matrix` | sparse rows; recursion over pairs of nodes (`pairs`), sums over images (`image_sum`), sums of rows restored by the least change relative to the radii (`closing`) |
//!
//! Factors far below the tolerance (τ/500) are left out.
//!
//! **Cost.** Proportional to the number of pairs that see each other, with a logarithm for the recursion. **Memory.** 24 bytes for each pair
//! that exchanges while it is computed, and 32 bytes for both of its entries. Results do not depend on the number of threads.
//!
//! Reference: E. A. Haines and J. R. Wallace, Shaft culling for efficient ray-cast radiosity, 1991 (the shafts).
//!
//! ```
//! use zonal_math::vec3;
//! use zonal_scene::{NoCheckpoints, NoProgress};
//! use zonal_view_factors::{ConvexPolygon, ViewFactorSettings, ViewFactors};
//! // Two unit squares face to face, and the sky around them.
//! let square = |z: f64, turn: [usize; 4]| {
//!     let c = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
//!     ConvexPolygon::new(turn.map(|k| vec3(c[k][0], c[k][1], z)).to_vec()).unwrap()
//! };
//! let facets = [square(0.0, [0, 1, 2, 3]), square(1.0, [3, 2, 1, 0])];
//! let settings = ViewFactorSettings { tolerance: 1e-6, ..Default::default() };
//! let f = ViewFactors::compute(&facets, &[], &settings, &NoProgress, &NoCheckpoints).unwrap();
//! assert!((f.row(0).next().unwrap().1.value - 0.199_824_9).abs() < 1e-6);
//! assert!((f.sky(0).value + f.ground(0).value - 0.800_175_1).abs() < 1e-6);
//! ```

mod batches;
mod bounds;
pub(crate) mod facet_set;
mod geometry;
mod image_choice;
mod matrix;
mod parts;
mod periods;
mod script_f;
mod settings;
mod sky;
mod stages;
mod strings;
mod view_factors;

pub use facet_set::{FacetSet, convex_parts, without};
pub use parts::ViewFactorParts;
pub use script_f::ScriptFactors;
pub use settings::{Openness, RowClosing, ViewFactorSettings};
pub use view_factors::{FactorRows, ViewFactorCounts, ViewFactors};
pub use zonal_exchange::polygon::visible::ConvexPolygon;
