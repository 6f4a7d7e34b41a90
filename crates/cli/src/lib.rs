//! The command `zonal`, as a library for its binary, its tests and the fuzz targets.
//!
//! | module | contents |
//! |---|---|
//! | [`commands`] | arguments and execution of the subcommands |
//! | [`camera_animation`] | cameras, exposure and lights between key frames |
//! | [`colour_scale`], [`legend`] | false colours and their legend |
//! | [`table`] | reports as text tables |
//! | [`progress`] | progress bars |
//! | [`viewer`] | a solution as a web page, and its server |

pub mod camera_animation;
pub mod colour_scale;
pub mod commands;
pub mod legend;
pub mod progress;
pub mod table;
pub mod viewer;
