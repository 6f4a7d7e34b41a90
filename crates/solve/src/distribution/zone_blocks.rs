//! Blocks of the voxels and patches of a box, and sums over their zones in an order that depends neither on threads nor on processes.

use super::multivector::VectorEntry;
use super::{Communicator, Message};
use std::ops::Range;
use zonal_math::parallel;

/// The zones of a voxel grid and its walls in blocks.
pub(crate) struct ZoneBlocks {
    /// The block of every patch.
    pub patches: Vec<u32>,
    /// Patches of each block of a wall, openings included; these blocks precede those of voxels.
    pub patch_sizes: Vec<f64>,
    /// Voxels along each axis.
    pub cells: [usize; 3],
    /// Voxels of a block along each axis; they divide `cells`.
    pub lengths: [usize; 3],
    /// The planes of voxels across x that vectors have.
    pub planes: Range<usize>,
}

impl ZoneBlocks {
    /// Number of blocks.
    pub(crate) fn count(&self) -> usize {
        self.patch_sizes.len() + [0, 1, 2].map(|k| self.cells[k] / self.lengths[k]).iter().product::<usize>()
    }

    /// Blocks of voxels in a plane of blocks, and voxels in a plane.
    pub(crate) fn plane_sizes(&self) -> [usize; 2] {
        let [_, n1, n2] = self.cells;
        [n1 / self.lengths[1] * (n2 / self.lengths[2]), n1 * n2]
    }

    /// Blocks of the voxels of row `y` of a plane, within their plane of blocks.
    pub(crate) fn row(&self, y: usize) -> usize {
        y / self.lengths[1] * (self.cells[2] / self.lengths[2])
    }

    /// Σ value(i) over the zones i of each block, in the order of the planes on any number of processes.
    pub(crate) fn sums<T: VectorEntry + Message>(
        &self,
        communicator: Option<&dyn Communicator>,
        value: impl Fn(usize) -> T + Sync,
    ) -> Vec<T> {
        let [of_plane, plane] = self.plane_sizes();
        let patches = self.patches.len();
        let mut out = vec![T::ZERO; self.count()];
        for (i, &block) in self.patches.iter().enumerate() {
            out[block as usize] = out[block as usize].plus(value(i));
        }
        let one = |k: usize| {
            let mut sums = vec![T::ZERO; of_plane];
            for y in 0..self.cells[1] {
                let first = patches + k * plane + y * self.cells[2];
                for (b, sum) in sums[self.row(y)..][..self.cells[2] / self.lengths[2]].iter_mut().enumerate()
                {
                    let voxels = first + b * self.lengths[2]..first + (b + 1) * self.lengths[2];
                    *sum = voxels.fold(*sum, |s, i| s.plus(value(i)));
                }
            }
            sums
        };
        let mut planes = parallel::collect_tasks(self.planes.len(), one).concat();
        if let Some(communicator) = communicator {
            let mut bytes = Vec::with_capacity(planes.len() * T::size());
            planes.iter().for_each(|x| x.put(&mut bytes));
            let all = communicator.all_gather(bytes);
            planes = all.iter().flat_map(|b| b.chunks_exact(T::size()).map(T::get)).collect();
        }
        for (k, sums) in planes.chunks(of_plane.max(1)).enumerate() {
            let to = &mut out[self.patch_sizes.len() + k / self.lengths[0] * of_plane..][..of_plane];
            to.iter_mut().zip(sums).for_each(|(o, s)| *o = o.plus(*s));
        }
        out
    }
}
