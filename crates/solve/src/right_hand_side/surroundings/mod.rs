//! Exchange of the zones with the surroundings and with the black backs of one-sided surfaces, sampled by rays.
//!
//! | module | content |
//! |---|---|
//! | `surroundings_exchange` | exchange factors and their standard errors for all zones |
//! | `opening_sampling` | importance sampling of the openings that a zone sees |
//! | `box_cells`, `open_cells` | cells on the sides of the bounding box; those through which groups of zones see out |
//! | `sky_openings` | direct light of a sky through the openings |
//! | `ray_tally` | statistics of the rays of one zone |
//! | `exact_rows` | rays of those zones alone whose losses do not follow from their rows |
//! | `stage` | the exchange as a stage of a checkpoint |
//! | `zone_rays` | origin, direction and weight of the rays of a zone; their transmittance out of the scene |

mod box_cells;
pub(crate) mod exact_rows;
mod open_cells;
mod opening_sampling;
mod ray_tally;
pub(crate) mod sky_openings;
pub(crate) mod stage;
mod surroundings_exchange;
pub(crate) mod zone_rays;

pub use surroundings_exchange::SurroundingsExchange;
