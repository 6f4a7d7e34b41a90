//! Pictures from a solution.
