//! Commands that show a solution in a browser.

pub(crate) mod live_view;
pub mod report;
pub mod view;
