//! Exchange sampled by rays from every zone (Monte Carlo estimate of every row of the exchange matrix).
//!
//! | module | contents |
//! |---|---|
//! | `ray_sampling` | numbers of rays: `RaySamplingParams` |
//! | `ray_tracer` | one ray, and batches of rays |
//! | `path_continuation` | rays continued from patches that they hit close by |
//! | `ray_table` | the zones in which the rays of every zone end |
//! | `ray_checkpoint` | the table as stages of a checkpoint |
//! | `power_normalization` | scaling that restores the power of a light group |
//! | `cost_probe` | the time of the rays of a scene, by a short sample |

pub(crate) mod cost_probe;
pub(crate) mod padded_bands;
pub(crate) mod path_continuation;
pub(crate) mod power_normalization;
mod ray_checkpoint;
pub(crate) mod ray_sampling;
pub(crate) mod ray_table;
pub(crate) mod ray_tracer;
