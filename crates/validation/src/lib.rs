//! Cases with known answers (`zonal validate`) and the reproduction of the 1996 paper (`zonal reproduce`).

pub mod reproduce;
pub mod validate;
