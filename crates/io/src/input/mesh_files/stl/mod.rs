//! STL: triangles in text or in binary form, in parts named by `solid`.
//!
//! A binary file has 80 bytes of header, the number n of facets (32 bits), and 50 bytes for each: a normal and three corners in single precision, and
//! two bytes that are not read. It is recognised by its length 84 + 50 n, so that its header may begin with `solid` as a text does; bytes behind the last facet are left out with a note. Corners are
//! counter-clockwise from the front; stored normals are compared with them and not used. Facets without area are dropped and counted in a note.
//!
//! Reference: M. Burns, Automated Fabrication (1993), section 6.5.

mod ascii;
mod binary;
mod facets;
mod read;

pub use facets::{StlFacet, StlFile};
pub(super) use read::read_mesh_file;
pub use read::read_stl;
