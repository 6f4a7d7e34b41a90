//! Commands that write and check scene files.

pub mod check;
pub mod init;
pub mod keys;
