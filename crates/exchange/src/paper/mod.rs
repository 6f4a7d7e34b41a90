//! Every method of the paper (Arquès and Michelin), one file each, restated and corrected.

pub mod gauss6;
pub mod hemicube;
mod kernel;
mod nodes;
pub mod point;
pub mod series;
pub mod strip;
mod trapezoid;
