//! Exchange areas of pairs of zones (Hottel and Sarofim 1967), usable independently of the solver.
//!
//! For two voxels, a voxel and a patch, two patches, with extinction κ in 1/m between them,
//!
//! ```text
//! 𝓕 = (1/π) ∬ e^{−κr} [cosθ_a]⁺ [cosθ_b]⁺ / r²          m⁴, m³, m²          F = κ_i κ_j 𝓕, κ_k 𝓕, 𝓕   in m²
//! ```
//!
//! is returned as a [`Factor`]: value, error radius and grade, method, number of evaluations. **Proved** means that the radius bounds truncation,
//! quadrature and rounding by the proof in the header of the module that computes it.
//!
//! | module | content | grade |
//! |---|---|---|
//! | [`factor()`] | any two shapes without obstructions, by the cheapest method that is proved to meet the requested accuracy | proved |
//! | [`aligned`] | boxes and rectangles along the axes: moments, closed forms, Gauss rules of the densities, the reduced integral; [`aligned::lattice`] tables of a grid's distinct offsets | proved |
//! | [`polygon`] | plates in any position: tensor rules, contours in closed form, rules on cells; [`polygon::visible`] behind other polygons | proved; estimated with obstructions |
//! | [`layers`] | infinite parallel layers of any extinction, and the planes at their ends | proved |
//! | [`pair`] | any two zones of a scene, with visibility, attenuation that varies, cut voxels and panes | as its parts |
//! | `strips` | infinitely long strips with obstructions: crossed strings | exact to rounding |
//! | [`solid_angle_quadrature`] | plates and boxes in any position with the moments of their distance | estimated |
//! | [`solid_angle`] | a plate seen from a point, in closed form | exact to rounding |
//!
//! ```
//! use zonal_exchange::aligned::{Cuboid, geometric_factor, lattice::GridTables};
//! use zonal_math::vec3;
//! // Two voxels a little apart in a medium, to nine digits.
//! let a = Cuboid::voxel(vec3(0.0, 0.0, 0.0), vec3(1.0, 1.0, 1.0));
//! let b = Cuboid::voxel(vec3(1.5, 0.0, 0.0), vec3(2.0, 1.0, 1.0));
//! let f = geometric_factor(&a, &b, 0.5, 1e-9);
//! println!("{} ± {:.1e} by {}", f.bounded.value, f.bounded.radius, f.method.name());
//! // All distinct offsets of a grid of 20³ cubes with edges of 10 cm.
//! let table = GridTables::new([0.1; 3], [20, 20, 20], 0.0, 1e-10).voxels();
//! assert!(table.get([3, 0, 1]).radius <= 1e-10 * table.get([3, 0, 1]).value);
//! ```

pub mod aligned;
mod dispatch;
mod factor;
pub mod layers;
pub mod pair;
pub mod polygon;
pub mod solid_angle_quadrature;
mod strips;

pub use dispatch::{ZoneShape, factor};
pub use factor::{AccuracyRequest, Factor, Method};

pub use zonal_transport::solid_angle;
