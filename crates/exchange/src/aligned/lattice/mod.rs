//! Tables of a regular grid: each distinct offset once, with a proved radius.
//!
//! The factor of two cells depends on their offset alone, up to the symmetries of the cell: 48 of a cube, where offsets are sorted and
//! n(n+1)(n+2)/6 of n³ are kept (260,130 for 115³); 16 where two edges agree; 8 otherwise. Of a voxel and a patch of the
//! grid's walls (patches are faces of cells), and of two such patches, the offsets across the plane of the walls fold in
//! the same way: n²(n+1)/2 entries (766,935 + … for 115³).
//!
//! | table | pairs | module that fills it |
//! |---|---|---|
//! | [`OffsetTable`] | voxel and voxel | `fill.rs`: batches of eight offsets by the moments' series or by Gauss rules of the density, |
//! | [`WallTable`] | voxel and wall, opposite walls, adjacent walls | near ones by the judge of single pairs |
//! | [`block()`] | one voxel against a block of voxels | |
//!
//! For radiosity that varies within a cell `linear.rs` has tables of its own.
//!
//! Where a grid repeats itself along an axis, an entry is the sum over the images of its offset (`images.rs`, `gaussians.rs`).
//!
//! Work is cut into fixed chunks of whole batches: no value depends on the number of threads.

mod block;
mod fill;
mod gaussians;
mod images;
mod index;
mod linear;
mod walls;

pub use block::{Block, block};
pub use fill::Tally;
pub use images::Images;
pub use linear::{Along, Linear};
pub use walls::WallTable;

use fill::Family;
use index::Index;
use zonal_math::Bounded;

/// Values and radii of a family's distinct offsets.
#[derive(Clone, Debug)]
struct Table {
    index: Index,
    values: Vec<f64>,
    radii: Vec<f64>,
    tally: Tally,
    /// The largest relative radius that counts in a row, where it is not that of an entry.
    relative: Option<f64>,
}

impl Table {
    fn new(index: Index, family: &Family) -> Table {
        let (values, radii, tally) = family.fill_parallel(&index.offsets());
        Table { index, values, radii, tally, relative: None }
    }
    fn get(&self, offset: [i64; 3]) -> Bounded {
        let i = self.index.place(offset);
        Bounded::proved(self.values[i], self.radii[i])
    }
    fn worst(&self) -> f64 {
        if let Some(relative) = self.relative {
            return relative;
        }
        let of = |(v, r): (&f64, &f64)| if *v > 0.0 { r / v } else { 0.0 };
        self.values.iter().zip(&self.radii).map(of).fold(0.0, f64::max)
    }
}

/// Voxel–voxel factors of a regular voxmap (m⁴), by offset.
///
/// ```
/// use zonal_exchange::aligned::lattice::OffsetTable;
/// let table = OffsetTable::new([0.1; 3], [20, 20, 20], 0.0, 1e-10);
/// let f = table.get([3, -1, 2]);
/// assert!(f.radius <= 1e-10 * f.value && f == table.get([-2, 3, 1]));
/// ```
#[derive(Clone, Debug)]
pub struct OffsetTable(Table);

impl OffsetTable {
    /// The table of a voxmap of `counts` voxels with these `edges` (m), for extinction `kappa` ≥ 0 (1/m); every radius is
    /// at most `tolerance` · value, as for [`super::geometric_factor`]. Runs on rayon's threads.
    ///
    /// # Panics
    /// On an edge or tolerance that is not positive and finite, a negative or infinite `kappa`, a count of zero or above 65,535.
    pub fn new(edges: [f64; 3], counts: [usize; 3], kappa: f64, tolerance: f64) -> OffsetTable {
        let family = Family::new(edges.map(|e| (e, e)), edges, [0.0; 3], kappa, tolerance);
        OffsetTable(Table::new(Index::of_edges(edges, counts), &family))
    }

    /// The same of a voxmap that repeats itself: `counts` are the offsets wanted, each value the sum over its `images`, which know edges and
    /// extinction. Relative radii are 2e-13; of offsets more than 30 mean free paths long, which weigh nothing in a row, they grow. Without
    /// extinction the sum has no end where two axes repeat themselves: it is given as 0, which is what such voxels send.
    ///
    /// # Panics
    /// As [`OffsetTable::new`].
    pub fn repeated(counts: [usize; 3], images: &Images) -> OffsetTable {
        OffsetTable(images.table(counts, [Along::Between; 3]))
    }

    /// Largest radius over value; where the grid repeats itself, of what counts in a row.
    pub fn worst(&self) -> f64 {
        self.0.worst()
    }

    /// The factor of two voxels whose indices differ by `offset`, each |component| below its count.
    ///
    /// # Panics
    /// On an offset outside of the voxmap.
    pub fn get(&self, offset: [i64; 3]) -> Bounded {
        self.0.get(offset)
    }

    /// Distinct offsets kept.
    pub fn len(&self) -> usize {
        self.0.values.len()
    }

    /// False: there is the offset zero at least.
    pub fn is_empty(&self) -> bool {
        self.0.values.is_empty()
    }

    /// Which methods served how many entries.
    pub fn tally(&self) -> Tally {
        self.0.tally
    }
}

#[cfg(test)]
mod tests;
