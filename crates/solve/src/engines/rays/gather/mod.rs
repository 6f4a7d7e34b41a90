//! The final gather: the incident radiation of every zone from known radiosities, sampled until it meets the tolerance.
//!
//! A solution by few stored rays (`ray`) gives radiosities whose noise matters little, since every zone averages over many others. The incident
//! radiation of a zone itself is as noisy as its own rays. The gather samples it afresh, with radiosities known: nothing is stored, so the number of
//! samples is not limited by memory, and the error falls with the work down to any tolerance.
//!
//! | module | contents |
//! |---|---|
//! | `zone_gather` | one sample: a ray and a connection to a bright patch, joined by multiple importance sampling |
//! | `expected_path` | what a ray collects from medium and panes, by expected values |
//! | `point_light` | direct light and textures at the points that samples meet |
//! | `point_zoning` | the zoning error of direct light, and how samples read it |
//! | `patch_lights` | the tree of patches that connections are aimed by |
//! | `pane_openings` | connections to the surroundings through panes |
//! | `escape_rays` | rays that only find out whether they leave the scene |
//! | `gather_sums` | sums of the samples of all zones |
//! | `single_precision` | bands in single precision, for sums and means of all zones |
//! | `gather_task` | the inputs of a gather |
//! | `final_gather` | rounds of samples, allocated by need |
//! | `gathered_fields` | H or G of every zone from the samples so far, with errors |
//! | `half_smoothing` | smoothing over neighbouring zones, as far as the two halves show that it helps |
//! | `regression_windows` | windows of neighbouring zones, and a linear fit over them |
//! | `zone_groups` | groups of neighbouring zones |
//! | `unmet_light` | errors of zones whose samples met no light |
//! | `gather_error` | errors from two independent halves of the samples |

mod escape_rays;
mod expected_path;
pub(crate) mod final_gather;
pub(crate) mod gather_error;
mod gather_sums;
pub(crate) mod gather_task;
mod gathered_fields;
mod half_smoothing;
mod pane_openings;
mod patch_lights;
pub(crate) mod point_light;
mod point_zoning;
pub(crate) mod regression_windows;
mod single_precision;
mod unmet_light;
pub(crate) mod zone_gather;
pub(crate) mod zone_groups;
