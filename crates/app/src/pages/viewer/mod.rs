//! The viewer: a baked solution as a web page, served on the loopback address or written as one file.
//!
//! ```text
//!     Solution ──render::bake──► mesh, fields ──package──► scene.bin ──server──► http://127.0.0.1:…/
//!                                                              └───────page────► page.html
//! ```
//!
//! | module | contents |
//! |---|---|
//! | [`package`] | the data of the page from a solution, as one compressed file |
//! | [`notes`] | notes of a report, with advice by cause |
//! | [`pack`] | the format of that file: a JSON header and named arrays |
//! | [`page`] | the page, built by npm from `viewer/` and embedded; page and data in one file |
//! | [`live`] | the newest data and the progress of the solve behind a page |
//! | [`server`] | an HTTP server for few, short connections from this machine |
//! | [`request`] | parsing of requests, and reasons to refuse them |
//!
//! The page depends on no solver. The server reads no files: its targets are a list of routes that is fixed before it listens.

pub mod live;
pub mod notes;
pub mod pack;
pub mod package;
pub mod page;
pub mod request;
pub mod server;
