//! A solution as a page.
//!
//! | module | contents |
//! |---|---|
//! | [`viewer`] | the interactive page, its data and its server |
//! | [`live_solve`] | the solves behind a live page |
//! | [`html_report`] | the page for readers: pictures, tables, provenance |
//! | `base64` | bytes as text |

mod base64;
pub mod html_report;
pub mod live_solve;
pub mod viewer;
