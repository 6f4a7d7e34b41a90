//! Commands that show a solution in a browser.

pub mod report;
pub mod view;
