//! The rays engine: a few stored rays of every zone, the solution by them, and a final gather until the tolerance is met.
//!
//! | module | contents |
//! |---|---|
//! | `build` | from a scene to its solution |
//! | `memory_budget` | memory of rays and samples, estimated beforehand |
//! | `stored_rays` | rays from every zone, and the table of their ends |
//! | [`ray_operator`] | the exchange operator of the table, its solution, and the final gather of it |
//! | `weighted_choice` | one of several items by their weights |
//! | `gather` | incident radiation of every zone by samples of a solution |
//! | `zoning_probe` | the zoning error of the solutions of other engines |
//!
//! The stored rays give radiosities whose noise averages out wherever they light another zone. The gather samples the incident
//! radiation of every zone from these radiosities. A tree over the patches by power aims its connections, hence the name of the engine. Its error
//! falls with the work, from a few tens of per cent down to the tolerance.

pub(crate) mod build;
pub(crate) mod gather;
pub(crate) mod memory_budget;
pub mod ray_operator;
pub(crate) mod stored_rays;
mod weighted_choice;
pub(crate) mod zoning_probe;
