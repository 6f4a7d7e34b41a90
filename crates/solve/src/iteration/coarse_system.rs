//! The zonal equations on blocks of zones, as a correction of the iteration on the zones themselves.
//!
//! Exchange factors smooth: the incident field of a box varies little within a few voxels, and so does y/√w, where √w y is the reflected strength of a zone
//! ([`super::conjugate_gradients`]). Let block C have the zones i, W_C = Σ_i w_i, and
//!
//! ```text
//!     φ_iC = √w_i / √W_C,      ΦᵀΦ = I,      K = √w g √w.
//! ```
//!
//! The equations (I − K) y = b have the Galerkin equations (I − ΦᵀKΦ) y_C = Φᵀb on the blocks. Exchange factors per unit strength add up: for equal weights in
//! each block, ΦᵀKΦ has the entries √w_C g_CD √w_D with w_C = W_C/m_C², where g_CD = Σ_i Σ_j g_ij is the exchange factor of the
//! blocks as zones and m_C the number of zones of a full block. So the coarse equations are again zonal equations, on cells of longer edges.
//!
//! **Correction.** The preconditioner
//!
//! ```text
//!     M⁻¹ = I − ΦΦᵀ + Φ (I − ΦᵀKΦ)⁻¹ Φᵀ
//! ```
//!
//! is symmetric and positive definite, and M⁻¹ (I − K) = I up to what K has outside the blocks' constants, O(κℓ) for blocks of edge ℓ (two-grid methods for
//! integral equations of the second kind: Hackbusch, Multi-Grid Methods and Applications, ch. 16). A product of blocks of 4³ voxels costs 1/64 of one of
//! voxels, and the iteration needs about half of the steps.
//!
//! Zones without weight have no part in a block, and slopes of a linear basis none at all: there M⁻¹ is the identity.

use super::linear_system::LinearSystem;
use crate::distribution::Communicator;
use crate::distribution::sum_order::SumOrder;
use crate::distribution::zone_blocks::ZoneBlocks;
use crate::operator::ExchangeOperator;
use zonal_math::parallel;
use zonal_scene::Bands;

/// The equations on blocks of zones.
pub(crate) struct CoarseSystem<'a> {
    /// g of the blocks.
    operator: Box<dyn ExchangeOperator + 'a>,
    blocks: ZoneBlocks,
    /// w_C.
    weights: Vec<Bands>,
    /// Σ t of the zones of a block.
    targets: Vec<f64>,
    /// 1/√W_C; 0 for a block without weight.
    norms: Vec<Bands>,
    /// The processes, where each has some planes alone.
    communicator: Option<&'a dyn Communicator>,
}

impl<'a> CoarseSystem<'a> {
    /// The equations on `blocks` with the exchange factors `operator` of the blocks, for the equations of all unknowns; with the
    /// processes, where each has some planes alone.
    pub(crate) fn new(
        blocks: ZoneBlocks,
        operator: Box<dyn ExchangeOperator + 'a>,
        system: &LinearSystem,
        communicator: Option<&'a dyn Communicator>,
    ) -> CoarseSystem<'a> {
        let totals = blocks.sums(communicator, |i| system.weights[i]);
        let norms = totals.iter().map(|w| w.map(|w| if w > 0.0 { 1.0 / w.sqrt() } else { 0.0 })).collect();
        let of_voxels = blocks.lengths.iter().product::<usize>() as f64;
        let size = |block: usize| blocks.patch_sizes.get(block).copied().unwrap_or(of_voxels);
        let weights = totals.iter().enumerate().map(|(c, w)| *w / (size(c) * size(c))).collect();
        let targets = blocks.sums(communicator, |i| system.targets[i]);
        CoarseSystem { operator, blocks, weights, targets, norms, communicator }
    }

    /// The equations.
    pub(crate) fn system(&self) -> LinearSystem<'_> {
        LinearSystem {
            operator: self.operator.as_ref(),
            weights: (&self.weights).into(),
            targets: &self.targets,
            sums: SumOrder::plain(),
        }
    }

    /// Φᵀ r, from √w r of every zone.
    pub(crate) fn restrict<const N: usize>(&self, value: impl Fn(usize) -> [f64; N] + Sync) -> Vec<[f64; N]> {
        let mut out = self.blocks.sums(self.communicator, value);
        out.iter_mut().zip(&self.norms).for_each(|(x, norm)| *x = times_lanes(*x, *norm));
        out
    }

    /// Adds Φ c to p: `add` adds a multiple of √w to an entry.
    pub(crate) fn prolong<T: Send, const N: usize>(
        &self,
        mut c: Vec<[f64; N]>,
        p: &mut [T],
        add: impl Fn(usize, &mut T, [f64; N]) + Sync,
    ) {
        c.iter_mut().zip(&self.norms).for_each(|(x, norm)| *x = times_lanes(*x, *norm));
        let blocks = &self.blocks;
        let [of_plane, _] = blocks.plane_sizes();
        let (patches, voxels) = p.split_at_mut(blocks.patches.len());
        for (i, (p, &block)) in patches.iter_mut().zip(&blocks.patches).enumerate() {
            add(i, p, c[block as usize]);
        }
        let (first, length) = (blocks.patches.len(), blocks.cells[2]);
        let rows = blocks.planes.len() * blocks.cells[1];
        parallel::chunks(&mut voxels[..rows * length], length, |row, p| {
            let (x, y) = (blocks.planes.start + row / blocks.cells[1], row % blocks.cells[1]);
            let at = blocks.patch_sizes.len() + x / blocks.lengths[0] * of_plane + blocks.row(y);
            for (z, p) in p.iter_mut().enumerate() {
                add(first + row * length + z, p, c[at + z / blocks.lengths[2]]);
            }
        });
    }
}

/// The product of each number with that of a band.
fn times_lanes<const N: usize>(x: [f64; N], by: Bands) -> [f64; N] {
    std::array::from_fn(|b| x[b] * by.as_slice()[b])
}

#[cfg(test)]
mod tests;
