//! Content of the report: diagnostics and summary, the report of a solution whose power is balanced, power that reaches black backs.

pub(crate) mod back_faces;
pub(crate) mod balanced_report;
pub(crate) mod diagnostics;
pub(crate) mod summary;
