//! Output shared by the commands: one-line errors, pages with tables and plots, checks of output paths.
//!
//! | module | contents |
//! |---|---|
//! | `failure` | the error of a command, one line with an exit code; printing to the standard streams |
//! | `output_path` | checks of output paths before a computation |
//! | `page` | folders of pages; tables and numbers in Markdown |
//! | [`plot`] | plots of lines and points, as SVG |

mod failure;
mod output_path;
mod page;
pub mod plot;

pub use failure::{Failure, note, say};
pub use output_path::check_output;
pub use page::{PageFolder, markdown, number, percent};
