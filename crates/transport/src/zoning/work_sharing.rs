//! Zoning by several processes: each resolves some blocks of facets and of cells, and all receive the results as words of 64 bits.
//!
//! ```text
//!     cell                             number of parts, or 2⁶⁴ − 1 for a whole cell; then the parts
//!     part                             mask of sub-cells, volume, centre, then a word for each sample
//! ```
//!
//! Results do not depend on the processes: a block never depends on the one that computes it.

use super::cell_parts::{CellPart, ResolvedCell};
use zonal_math::Vec3;
use zonal_scene::{VoxelGrid, VoxelSamples};

/// Processes that share the zoning of a scene.
pub trait WorkSharing: Sync {
    /// The lists of all items, in their order. Each process computes some of them by all of its threads; all processes call it alike.
    fn map_lists(&self, items: usize, list: &(dyn Fn(usize) -> Vec<u64> + Sync)) -> Vec<Vec<u64>>;
}

/// The word of a whole cell in the place of a number of parts.
const WHOLE_CELL: u64 = u64::MAX;

/// Appends the words of a cell.
pub(super) fn encode_cell(cell: &ResolvedCell, out: &mut Vec<u64>) {
    let ResolvedCell::Parts(parts) = cell else {
        out.push(WHOLE_CELL);
        return;
    };
    out.push(parts.len() as u64);
    for part in parts {
        let (mask, samples) = part.samples.packed();
        out.extend([mask, part.volume.to_bits()]);
        out.extend(part.centre.array().map(f64::to_bits));
        out.extend(samples.iter().map(|s| s.iter().fold(0, |word, x| word << 16 | u64::from(*x))));
    }
}

/// The cells of consecutive words; `coordinates` are those of the cells.
pub(super) fn decode_cells(
    grid: &VoxelGrid,
    words: &[u64],
    coordinates: impl Iterator<Item = [usize; 3]>,
) -> Vec<ResolvedCell> {
    let mut words = words.iter().copied();
    let one = |c: [usize; 3]| match words.next().unwrap_or_default() {
        WHOLE_CELL => ResolvedCell::Whole,
        parts => ResolvedCell::Parts((0..parts).map(|_| decode_part(grid, c, &mut words)).collect()),
    };
    coordinates.map(one).collect()
}

fn decode_part(grid: &VoxelGrid, c: [usize; 3], words: &mut impl Iterator<Item = u64>) -> CellPart {
    let mut word = || words.next().unwrap_or_default();
    let (mask, volume) = (word(), f64::from_bits(word()));
    let centre = Vec3::from_array([(); 3].map(|()| f64::from_bits(word())));
    let sample = |w: u64| [48, 32, 16, 0].map(|shift| (w >> shift) as u16);
    let samples = (0..mask.count_ones()).map(|_| sample(word())).collect();
    let samples = VoxelSamples::from_packed(grid.corner(c), grid.cell(), volume, mask, samples);
    CellPart { samples: samples.unwrap_or_default(), centre, volume }
}
