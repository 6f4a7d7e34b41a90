//! The hierarchical engine: rays from every zone, links between clusters, and the blend of both.
//!
//! | module | contents |
//! |---|---|
//! | `build` | from a scene to an engine that meets its tolerance |
//! | `memory_budget` | memory of rays and links, estimated beforehand |
//! | `hierarchical_operator` | the exchange operator of the links, with its error model |
//! | `closure_scaling` | closure restored cluster by cluster |
//! | `estimator_blend` | one estimate from links and rays |
//!
//! **Passes.** Rays from every zone (`ray`) give a first solution of known error. Where that misses the tolerance, a tree of
//! clusters is built from it and links are refined by it (`cluster`), the caller solves with the links, and both estimates are
//! blended. Rays reach an error of a few per cent at a cost proportional to the number of zones; links continue from there, as their
//! errors fall faster than the inverse square root of the work.

pub(crate) mod build;
mod closure_scaling;
mod estimator_blend;
mod hierarchical_operator;
pub(crate) mod memory_budget;

pub use hierarchical_operator::{ApproximateGroup, HierarchicalOperator, PairFactors};
