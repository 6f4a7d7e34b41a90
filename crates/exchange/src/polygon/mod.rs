//! Plates in any position: contour integrals in closed form, and Gauss rules with proved error bounds.

mod cell_rules;
mod contour;
mod edge_closed_form;
mod edge_integral;
mod mapped_zone;
mod plate_geometry;
mod plate_pair;
mod prepared_plates;
mod prepared_polygon;
mod segment;
mod tensor_rules;
pub mod visible;

pub use cell_rules::plate_cuboid;
pub use plate_pair::plate_plate;
pub use prepared_plates::PreparedPlates;
pub use prepared_polygon::PreparedPolygon;
