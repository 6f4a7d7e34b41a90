//! Error estimates of a solution.
//!
//! | module | content |
//! |---|---|
//! | `closure_error` | errors from rows that do not close |
//! | `empty_rows` | errors of rows that hold little or nothing |
//! | `propagation` | errors of factors and rows propagated to the incident fields |
//! | `direct_error` | propagation of errors of direct light to reflected light |
//! | `consistency` | errors from negative fluxes, early termination and unbalanced power |
//! | `random_signs` | reflected errors that are independent from zone to zone |
//! | `estimate` | the relative error of a solution |
//! | `finite` | refuses values that are not finite |
//! | [`discretization`] | discretization error by a second solve |

pub(crate) mod closure_error;
pub(crate) mod consistency;
pub(crate) mod direct_error;
pub(crate) mod discretization;
pub(crate) mod empty_rows;
pub(crate) mod estimate;
pub(crate) mod finite;
pub(crate) mod propagation;
pub(crate) mod random_signs;
