//! The command `zonal`, as a library for its binary, its tests and the fuzz targets.
//!
//! | module | contents |
//! |---|---|
//! | [`command_line`] | a command line from its words to its exit code |
//! | [`commands`] | arguments and execution of the subcommands |
//! | [`camera_animation`] | cameras, exposure and lights between key frames |
//! | [`base64`] | bytes as text |
//! | [`colour_scale`], [`legend`] | false colours and their legend |
//! | [`html_report`] | a solution as a page for readers: pictures, tables, provenance |
//! | [`table`] | reports as text tables |
//! | [`scene_proposal`] | a scene for a mesh file |
//! | [`progress`] | progress bars |
//! | [`viewer`] | a solution as a web page, and its server |

pub mod base64;
pub mod camera_animation;
pub mod colour_scale;
pub mod command_line;
pub mod commands;
pub mod html_report;
pub mod legend;
pub mod progress;
pub mod scene_proposal;
pub mod table;
pub mod viewer;
