//! Operations of the command, the Python package and distributed solves on scenes and solutions: typed options in, typed results out.
//!
//! The crate parses no arguments and prints nothing. Options are plain structures; results are structures, JSON or files. Notes go to a function that the caller
//! gives.
//!
//! | module | contents |
//! |---|---|
//! | [`quality`] | one word for tolerance, patch size and sampling |
//! | [`solving`] | solves with changed options, with checkpoints, and on several processes |
//! | [`relight`] | other lights, reflectances and albedos of a solution |
//! | [`scene_check`] | zones, cost and diagnostics of a scene |
//! | [`scene_proposal`] | a scene for a mesh file |
//! | [`dataset`] | many solves of one scene with sampled numbers |
//! | [`pairs`] | exchange areas, view factors, factors of tables of pairs, states from stored areas |
//! | [`gas`] | grey gases and emissivity of a gas model |
//! | [`shown_solution`] | which solutions an output can show |
//! | [`pictures`] | pictures of light, false colours, frames of an animation |
//! | [`export`] | a solution for other programs |
//! | [`report_values`] | numbers of a report, with errors, as rows and text |
//! | [`pages`] | a solution as a page: the viewer with its server, and the report |
//! | [`stage_names`] | names of stages in a display of progress |
//! | [`timeline`] | wall time and processor time by phase |
//! | [`Error`] | an error with its cause |

pub mod dataset;
mod error;
pub mod export;
pub mod gas;
pub mod pages;
pub mod pairs;
pub mod pictures;
pub mod quality;
pub mod relight;
pub mod report_values;
pub mod scene_check;
pub mod scene_proposal;
pub mod shown_solution;
pub mod solving;
pub mod stage_names;
pub mod timeline;

pub use error::Error;
