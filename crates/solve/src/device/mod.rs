//! The interface of a device that computes products of the spectral engine: transform, multiply by the spectra of the kernels, transform back.
//!
//! In a box on a regular grid the exchange factor of two zones depends on their offset alone. The power that arrives at voxel x is
//!
//! ```text
//!     P(x) = Σ_x' K(x − x') s(x'),      0 ≤ x, x' < n  along each axis.
//! ```
//!
//! **Zero padding.** Let s be continued by zeros to a period N ≥ 2n − 1, and K(−d) stand at N − d. Offsets d and N − d′ of cells differ, since
//! d + d′ ≤ 2n − 2 < N, so that the circular sum over N is the sum above for x < n; what it has beyond n is not read. By the convolution theorem
//!
//! ```text
//!     P̂(f) = K̂(f) ŝ(f),      ŝ(f) = Σ_x s(x) e^{−2πi f·x/N}.
//! ```
//!
//! A periodic axis needs no padding: N = n.
//!
//! **Symmetry.** s is real: ŝ(−f) = ŝ(f)*, and half of the frequencies along one axis is sufficient. K is real and even in every axis: K̂ is
//! real and even, and one octant of (N/2 + 1)³ real numbers is stored. With slopes K is odd in some axes, and its spectrum imaginary there
//! ([`basis`]).
//!
//! **Cost** of one product for n³ voxels, N = 2n, a constant basis. Direct sums cost 2 n⁶ operations. Lines of zeros are not transformed: both directions
//! have n² real lines along z, n² complex ones along y and 2n² along x, at 5 N log₂N operations for a complex line and half of that for a real one.
//!
//! | part | operations | bytes |
//! |---|---|---|
//! | transforms of voxels, both directions | 70 n³ log₂2n | 16 n³ for values, 128 n³ for spectra between them |
//! | product with V | 16 n³ | 16 n³: each number of the octant serves four frequencies in two reads |
//! | voxels and walls | 32 n³ across x, about 200 n³ across y and z | 48 n³ |
//! | adjacent walls | 96 n³ | 24 n³ |
//! | transforms of walls | 280 n² log₂2n | order n² |
//!
//! | module | content |
//! |---|---|
//! | [`grid`] | cells, and lengths of the transforms |
//! | [`basis`] | components of the radiosity in a zone, and the kernels between them |
//! | [`spectra`] | the spectra of the kernels |
//! | [`slabs`] | the part of a grid that each process has |
//!
//! The engine (`engines/spectral/spectral_operator.rs`) knows bands, zones and errors; a device knows real numbers on a grid. The three steps are
//! one call, so that a device is free to fuse them and to keep spectra in its own memory. Without another device
//! ([`crate::SolveSettings::device`]) the processor computes the products (`engines/spectral/cpu/`).

pub mod basis;
pub mod grid;
pub mod slabs;
pub mod spectra;

use crate::distribution::Communicator;
use basis::BasisOrder;
use grid::BoxGrid;
use slabs::Slabs;
use spectra::GridSpectra;
use zonal_exchange::aligned::lattice::TableAccuracy;

/// Values on the patches of the six walls, low and high across each axis, by `[component][i_b][i_c]`; empty across periodic axes.
pub type WallValues = [[Vec<f64>; 2]; 3];

/// A device on which products of the spectral engine are computed.
pub trait Device: Sync {
    /// Prepares the products of a grid: plans, and memory that does not depend on the extinction.
    fn convolution<'a>(&self, part: GridPart<'a>) -> Box<dyn GridConvolution + 'a>;
}

/// The products of a grid on a device, for some extinctions. In a run of several processes all make the same calls in the same order.
pub trait GridConvolution: Send + Sync {
    /// Takes the spectra of a further extinction; they have the numbers 0, 1, … in the order of the calls.
    fn load(&mut self, spectra: GridSpectra);

    /// Transforms, multiplies by the spectra of extinction number `extinction`, and transforms back: `voxels`, the strengths of the voxels of this
    /// process by `[component][x][y][z]`, become their incident power. Returns the incident power of all patches, for the strengths `walls`. Two
    /// calls with equal arguments return the same bits.
    fn exchange(&self, extinction: usize, voxels: &mut [f64], walls: &WallValues) -> WallValues;

    /// Frees the memory of products; the next product allocates it again.
    fn free_buffers(&self);
}

/// Description of a grid for a device.
#[derive(Clone, Copy)]
pub struct GridPart<'a> {
    /// The whole grid.
    pub grid: BoxGrid,
    /// The components of voxels and patches.
    pub order: BasisOrder,
    /// The part of this process.
    pub slabs: Slabs<'a>,
    /// Accuracy of its factors with slopes.
    pub accuracy: TableAccuracy,
}

impl<'a> GridPart<'a> {
    /// The part of this process in a grid that `communicator` shares.
    pub(crate) fn new(grid: BoxGrid, order: BasisOrder, communicator: &'a dyn Communicator) -> GridPart<'a> {
        GridPart { grid, order, slabs: Slabs::new(&grid, communicator), accuracy: TableAccuracy::Full }
    }

    /// Number of voxels of this process.
    pub fn own_voxels(&self) -> usize {
        self.slabs.planes().len() * self.grid.cells[1] * self.grid.cells[2]
    }

    /// Zero values on all walls.
    pub fn zero_walls(&self) -> WallValues {
        [0, 1, 2].map(|a| {
            let size =
                if self.grid.periodic[a] { 0 } else { self.order.patch_components() * self.grid.patches(a) };
            [vec![0.0; size], vec![0.0; size]]
        })
    }
}
