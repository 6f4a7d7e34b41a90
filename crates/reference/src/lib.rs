//! Reference solutions for tests: slow and independent of the engines that they check.
//!
//! No tree, quadrature, grid traversal or cache is shared with the engines. Rays are tested against every facet; integrals over scenes are
//! means over random samples with standard errors, repeatable by their seeds. Only [`path_tracer`] and [`forward_monte_carlo`], for
//! whole scenes, use a tree, their own, which is tested against the search over every facet. Factors of aligned boxes come from
//! closed forms along rays and a tanh–sinh rule, with an error bound of their own.
//!
//! | module | content |
//! |---|---|
//! | [`random_meshes`] | random meshes and cross-sections for view factors |
//! | [`rng`] | random numbers, points and directions |
//! | [`estimate`] | sample means and standard errors |
//! | [`brute_force`] | ray queries by testing every facet, cell plane and pane |
//! | [`exchange`] | g_ij of two bodies: by pairs of points, or by rays from one that score on the other |
//! | [`factors`] | aligned boxes and rectangles, attenuated or not, to thirteen digits |
//! | [`closed_form`] | aligned rectangles without a medium: corner sums in double-double arithmetic |
//! | `numerics` | the quadrature rule and the arithmetic of 106 bits behind them |
//! | [`crossed_strings`] | exact view factors of walls in the plane, with occlusion |
//! | [`radiance`] | H of a plate and G in a box by backward random walks |
//! | [`forward_monte_carlo`] | powers and temperatures by surface and zone, by random walks from the sources |
//! | [`path_tracer`] | H, G and pictures of scenes of any size by backward path tracing |
//! | [`slab`] | layers between walls in any number of bands, by discrete ordinates; radiative equilibrium |
//! | [`visible_views`] | view factors of polygons that hide each other, by exact views from points |
//! | [`test_cases`] | samples of long lists of test cases |

pub mod brute_force;
pub mod closed_form;
pub mod crossed_strings;
pub mod estimate;
pub mod exchange;
pub mod factors;
pub mod forward_monte_carlo;
mod numerics;
pub mod path_tracer;
pub mod radiance;
pub mod random_meshes;
pub mod rng;
pub mod slab;
pub mod test_cases;
pub mod visible_views;

pub use brute_force::BruteForceScene;
pub use estimate::SampleEstimate;
pub use exchange::ExchangeBody;
pub use rng::Rng;
