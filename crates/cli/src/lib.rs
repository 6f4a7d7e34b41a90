//! The command `zonal`, as a library for its binary, its tests, the Python package and `zonal-mpi`.
//!
//! | module | contents |
//! |---|---|
//! | [`command_line`] | a command line from its words to its exit code |
//! | [`commands`] | arguments and execution of the subcommands |
//! | [`table`] | reports as text tables |
//! | [`progress`] | progress bars |

pub mod command_line;
pub mod commands;
pub mod progress;
pub mod table;
