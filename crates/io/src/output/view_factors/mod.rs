//! View factors of the surfaces of a mesh as files: View3D's three formats, npz, CSV and MatrixMarket.
//!
//! F_ij is the fraction of the diffuse power of surface i that arrives at surface j. A row of F, the factor to the sky and that to directions below the
//! horizon that meet nothing sum to one where factors are complete. All formats are written row by row: their memory is that of one row.
//!
//! | module | contents |
//! |---|---|
//! | `table` | factors by rows |
//! | `write` | choice of the format |
//! | `view3d` | View3D's text, binary and sparse text |
//! | `npz` | a sparse matrix for `scipy.sparse.load_npz`, with radii, areas and names |
//! | `text` | CSV and MatrixMarket |
//!
//! References: View3D 4 (NISTIR 6925); uDALES, which reads sparse text; scipy.sparse.save_npz; NISTIR 5935 (MatrixMarket).

mod npz;
mod table;
#[cfg(test)]
mod tests;
mod text;
mod view3d;
mod write;

pub use table::ViewFactorTable;
pub use write::{ViewFactorFormat, write_view_factors};
