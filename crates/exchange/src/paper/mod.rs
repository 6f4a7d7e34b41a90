//! Every method of the paper (Arquès and Michelin), one file each, restated and corrected.

mod nodes;
pub mod series;
pub mod strip;
mod trapezoid;
