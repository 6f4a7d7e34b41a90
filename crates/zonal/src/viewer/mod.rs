//! The viewer: a baked solution as a web page, served on the loopback address or written as one file.
//!
//! ```text
//!     Solution ──render::bake──► mesh, fields ──package──► scene.bin ──server──► http://127.0.0.1:…/
//!                                                              └───────page────► page.html
//! ```
//!
//! | module | what |
//! |---|---|
//! | [`package`] | everything that the page needs of a solution, as one compressed blob |
//! | [`pack`] | the blob: a JSON header and named arrays |
//! | [`page`] | the page itself, built by npm from `viewer/` and embedded; the page and its data in one file |
//! | [`server`] | connections: a few, short, from this machine only |
//! | [`request`] | what may be asked, and what is answered otherwise |
//!
//! The page reads the blob and knows no solver; the server knows no file system: what it may answer is a list made before it listens.

pub mod pack;
pub mod package;
pub mod page;
pub mod request;
pub mod server;
