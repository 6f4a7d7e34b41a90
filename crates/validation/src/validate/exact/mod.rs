//! Cases with exact answers: closed forms, series, laws.

pub(crate) mod conduction;
pub(crate) mod cube;
pub(crate) mod factors;
pub(crate) mod laws;
pub(crate) mod series;
pub(crate) mod slabs;
pub(crate) mod sphere;
pub(crate) mod square;
pub(crate) mod textbook;
