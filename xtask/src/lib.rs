//! Developer tasks of the workspace: the steps of CI ([`steps`]), counts of the structure of the code ([`counts`]), messages of commits
//! ([`commits`]), the register of invariants ([`guards`]), the shape of documents ([`documents`]) and the version of a release ([`versions`]).
//!
//! The counts parse every Rust source of the workspace with `syn`. [`source`] loads the files, [`modules`] resolves paths between modules and
//! finds import cycles, [`surface`] measures the public items, [`shape`] measures functions, constants and type names,
//! [`idioms`] finds tuples in signatures, matches on booleans, thread-local state and arithmetic on ranges of zones.

#![forbid(unsafe_code)]

pub mod commits;
pub mod counts;
pub mod documents;
pub mod guards;
pub mod idioms;
pub mod modules;
pub mod shape;
pub mod source;
pub mod steps;
pub mod surface;
pub mod versions;
