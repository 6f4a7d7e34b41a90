//! Optical depth of the medium towards a distant light, D(x) = ∫ κ ds from x on, cached on the voxel corners.
//!
//! D is computed at the corners of the voxels by an exact grid traversal each, and interpolated trilinearly between them. D is the
//! integral of a piecewise constant function: across a voxel it changes by κ times its width, which bounds the interpolation error
//! where κ changes from voxel to voxel; in uniform parts of the medium the interpolation is exact except in voxels that a border's
//! shadow crosses. Blocks of voxels are filled on first use; a block holds all corners of its voxels, so that one look-up finds all eight.
//! In a uniform medium the traversal is cheaper than the look-up and replaces it.

use crate::interpolation::lazy_values::LazyValues;
use zonal_math::Vec3;
use zonal_scene::{Bands, PerBand, VoxelGrid};
use zonal_transport::Transport;

/// Voxels along a side of a block.
const BLOCK_VOXELS: usize = 4;
/// Voxel corners along a side of a block.
const BLOCK_CORNERS: usize = BLOCK_VOXELS + 1;

/// D in one direction.
pub(crate) struct SunDepthCache<'a> {
    transport: &'a Transport<'a>,
    towards: Vec3,
    /// The voxel grid with its blocks; `None` where the medium is uniform.
    grid: Option<DepthGrid<'a>>,
}

/// The blocks of a voxel grid, filled on first use.
struct DepthGrid<'a> {
    map: &'a VoxelGrid,
    /// Blocks along each axis.
    blocks: [usize; 3],
    depths: LazyValues<DepthBlock>,
}

/// D at the corners of a block's voxels.
type DepthBlock = Vec<PerBand<f32>>;

impl<'a> SunDepthCache<'a> {
    /// D in the unit direction `towards`.
    pub(crate) fn new(transport: &'a Transport<'a>, towards: Vec3) -> SunDepthCache<'a> {
        let map = transport.scene().voxel_grid().filter(|m| m.uniform_extinction().is_none());
        let grid = map.map(|map| {
            let blocks = map.dims().map(|n| n.div_ceil(BLOCK_VOXELS));
            DepthGrid { map, blocks, depths: LazyValues::new(blocks.iter().product()) }
        });
        SunDepthCache { transport, towards, grid }
    }

    /// D at `x`.
    pub(crate) fn depth(&self, x: Vec3) -> Bands {
        let Some(DepthGrid { map, blocks, depths }) = &self.grid else {
            return self.traversed_depth(x);
        };
        let (mut at, mut f) = ([0; 3], [0.0; 3]);
        for k in 0..3 {
            let place = (x[k] - map.min()[k]) / map.cell()[k];
            if !(place >= 0.0 && place <= map.dims()[k] as f64) {
                return self.traversed_depth(x);
            }
            at[k] = (place as usize).min(map.dims()[k] - 1);
            f[k] = place - at[k] as f64;
        }
        let block = at.map(|i| i / BLOCK_VOXELS);
        let number = (block[0] * blocks[1] + block[1]) * blocks[2] + block[2];
        let corners = depths.get(number, || self.block(map, block));
        let first = ((at[0] % BLOCK_VOXELS) * BLOCK_CORNERS + at[1] % BLOCK_VOXELS) * BLOCK_CORNERS
            + at[2] % BLOCK_VOXELS;
        Bands::from_fn(|b| {
            let edge = |k: usize| {
                let (lo, hi) = (corners[first + k][b] as f64, corners[first + k + 1][b] as f64);
                lo + (hi - lo) * f[2]
            };
            let face = |k: usize| {
                let (lo, hi) = (edge(k), edge(k + BLOCK_CORNERS));
                lo + (hi - lo) * f[1]
            };
            let (lo, hi) = (face(0), face(BLOCK_CORNERS * BLOCK_CORNERS));
            lo + (hi - lo) * f[0]
        })
    }

    /// D at the corners of a block.
    fn block(&self, map: &VoxelGrid, block: [usize; 3]) -> DepthBlock {
        let place = |k: usize| {
            [k / (BLOCK_CORNERS * BLOCK_CORNERS), k / BLOCK_CORNERS % BLOCK_CORNERS, k % BLOCK_CORNERS]
        };
        let at = |k: usize| {
            let p = place(k);
            [0, 1, 2].map(|i| (block[i] * BLOCK_VOXELS + p[i]).min(map.dims()[i]))
        };
        (0..BLOCK_CORNERS * BLOCK_CORNERS * BLOCK_CORNERS)
            .map(|k| self.traversed_depth(map.corner(at(k))).map(|d| d as f32))
            .collect()
    }

    /// D at `x` by a traversal of the grid.
    fn traversed_depth(&self, x: Vec3) -> Bands {
        self.transport.medium_depth(x, self.transport.exterior_point(x, self.towards))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::{low_discrepancy, vec3};
    use zonal_scene::{Band, Scene, SceneParts};

    /// A box whose lower half is denser by a factor, with a border oblique to the voxels.
    fn scene(factor: f64) -> Scene {
        let mut map = VoxelGrid::new(Vec3::ZERO, vec3(0.2, 0.25, 0.3), [21, 18, 13]).unwrap();
        for i in 0..map.len() {
            let c = map.centre(map.coordinates(i));
            let kappa = if c.z + 0.3 * c.x < 2.2 { 0.1 * factor } else { 0.1 };
            map.set(
                i,
                Bands::from_rgb([kappa, 0.5 * kappa, 0.0]),
                Bands::splat(0.5),
                Bands::ZERO,
                Bands::ZERO,
            );
        }
        Scene::new(SceneParts { voxel_grid: Some(map.seal().unwrap()), ..SceneParts::default() }).unwrap()
    }

    // Guards (pictures): approximations of the renderer agree with exact evaluation: depths towards suns.
    #[test]
    fn interpolated_depth_agrees_with_grid_traversal() {
        for factor in [1.0, 8.0] {
            let scene = scene(factor);
            let transport = Transport::new(&scene);
            let cache = SunDepthCache::new(&transport, vec3(0.3, -0.4, 0.87).normalized());
            let (mut worst, mut sum, n) = (0.0f64, 0.0, 2000);
            for i in 0..n {
                let [x, y, z] = low_discrepancy::r3(i, [0.1, 0.2, 0.3]);
                let p = vec3(4.2 * x, 4.5 * y, 3.9 * z);
                let (found, exact) = (cache.depth(p), cache.traversed_depth(p));
                for b in Band::all() {
                    worst = worst.max((found[b] - exact[b]).abs());
                    sum += (found[b] - exact[b]) / (Band::count() * n) as f64;
                }
            }
            // The bound is the difference of κ on both sides times the width of a voxel.
            let bound = if factor == 1.0 { 1e-12 } else { 0.1 * (factor - 1.0) * 0.3 };
            assert!(worst <= bound && sum.abs() < 0.02 * bound + 1e-12, "{worst} {sum}");
        }
    }
}
