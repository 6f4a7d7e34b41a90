//! The exchange area of any two zones of a scene; `pair_methods.rs` selects the formula of each pair.
//!
//! The stored quantity of a pair is g_ij = F_ij/(c_i c_j) with c = κ for volume zones and 1 for patches, so that a band without
//! extinction keeps its factors: the fluence of an empty voxel is G_i = (1/V_i) Σ_j g_ij c_j B_j.
//!
//! | pair | geometry | attenuation |
//! |---|---|---|
//! | axis-aligned, one κ on all paths (`path_media.rs`) | reduced integral, **proved** | inside the integral |
//! | axis-aligned, varying κ | reduced integral at κ = 0 | three moments of the distance × mean extinction along rays |
//! | the same, optically thick | the same | chords of rays through both voxels |
//! | two plates in any position | contours in closed form, Gauss rules, **proved** | moments of the distance, estimated |
//! | a plate in any position and a voxel | closed solid angle inside, Gauss points outside, estimated | the same |
//! | a voxel cut by walls | sums over its samples | the same, ray by ray |
//! | a pane | as a plate with two sides, times (1 − e^{−κt/c})/κ, c the cosine | the same |
//!
//! In a periodic scene an axis-aligned pair in a uniform medium has the sum over the images of one of its zones. Without a medium the images of
//! a patch are an infinitely long strip (`strip_images.rs`).
//!
//! **Visibility** multiplies: the mean over rays between points of both zones, weighted by the kernel. For a pair that carries an
//! important share of a zone's power, rays without weight come first; where they disagree, the mean has more rays. Other pairs have a fixed number. A
//! number that followed from the rays of the mean itself would bias it. The points differ between pairs, so that the errors of neighbouring pairs are independent.
//!
//! ```
//! use zonal_exchange::pair::{Exchange, PairCounts, closure_target, scaled_radiosity_coefficient};
//! use zonal_math::Vec3;
//! use zonal_scene::{Bands, Scene, SceneParts, VoxelGrid};
//! use zonal_transport::{Transport, build_zones};
//! // A cubic voxel of 1 m with extinctions of 1, 2 and 0 1/m in three bands.
//! let mut grid = VoxelGrid::new(Vec3::ZERO, Vec3::splat(1.0), [1, 1, 1]).unwrap();
//! grid.set(0, Bands::from_rgb([1.0, 2.0, 0.0]), Bands::ZERO, Bands::ZERO, Bands::ZERO);
//! let parts = SceneParts { voxel_grid: Some(grid.seal().unwrap()), ..SceneParts::default() };
//! let scene = Scene::new(parts).unwrap();
//! let transport = Transport::new(&scene);
//! let zones = build_zones(&scene, &transport).unwrap();
//! let g = Exchange::new(&scene, &zones, &transport).pair(0, 0, &mut PairCounts::default());
//! let [thin, thick, empty] = g.value.to_rgb();
//! assert!(empty > thin && thin > thick);
//! // The voxel absorbs a part of its emission 4 κ V.
//! assert!(scaled_radiosity_coefficient(&zones, 0).first() * thin < closure_target(&zones, 0));
//! ```

mod cut_voxels;
mod distance_moments;
mod exchange;
mod pair_factor;
mod pair_methods;
mod periodic_images;
mod prepared_zone;
mod ray_average;
mod second_moments;
mod settings;
mod strip_images;
mod subcells;
mod visibility;
mod volume_factors;
mod zone_coefficients;

pub use exchange::Exchange;
pub use pair_factor::{PairCounts, PairFactor};
pub use pair_methods::PairRow;
pub use ray_average::pane_self_exchange;
pub use settings::{PairSettings, sample_seed};
pub use strip_images::StripImages;
pub use visibility::visibility_uncertainty::SUCCESSION_PSEUDO_COUNTS;
pub use volume_factors::{SelfAttenuation, VolumeFactorMethod, VoxelPair};
pub use zone_coefficients::{closure_target, scaled_radiosity_coefficient};
