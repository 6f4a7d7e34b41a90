//! The optical depth of the medium towards a distant light, everywhere: D(x) = ∫ κ ds from x on.
//!
//! D is known at the corners of the voxels, by an exact walk each, and trilinear between. It is the integral of what is constant in a voxel:
//! across one it changes by κ times its width, and that is the most by which the interpolation can be off where κ changes from voxel to
//! voxel; in even parts of the medium it is exact but in voxels that a border's shadow passes. Blocks of voxels are made
//! when first asked for; a block has all corners of its voxels, so that one look finds all eight. In an even medium the walk is shorter
//! than the look.

use crate::lazy::Lazy;
use zonal_math::Vec3;
use zonal_scene::{Bands, Voxmap, bands};
use zonal_transport::Transport;

/// Voxels along a side of a block, and corners.
const SIDE: usize = 4;
const CORNERS: usize = SIDE + 1;

/// D of one direction.
pub(crate) struct Towards<'a> {
    transport: &'a Transport<'a>,
    towards: Vec3,
    /// The voxmap, its blocks along each axis and D at their corners, where it is not even.
    uneven: Option<(&'a Voxmap, [usize; 3], Lazy<Block>)>,
}

/// D at the corners of a block's voxels.
type Block = Vec<[f32; 3]>;

impl<'a> Towards<'a> {
    /// D in the unit direction `towards`.
    pub(crate) fn new(transport: &'a Transport<'a>, towards: Vec3) -> Towards<'a> {
        let map = transport.scene().voxmap().filter(|m| m.uniform_extinction().is_none());
        let uneven = map.map(|m| {
            let blocks = m.dims().map(|n| n.div_ceil(SIDE));
            (m, blocks, Lazy::new(blocks.iter().product()))
        });
        Towards { transport, towards, uneven }
    }

    /// D at `x`.
    pub(crate) fn depth(&self, x: Vec3) -> Bands {
        let Some((map, blocks, made)) = &self.uneven else {
            return self.exactly(x);
        };
        let (mut at, mut f) = ([0; 3], [0.0; 3]);
        for k in 0..3 {
            let place = (x[k] - map.min()[k]) / map.cell()[k];
            if !(place >= 0.0 && place <= map.dims()[k] as f64) {
                return self.exactly(x);
            }
            at[k] = (place as usize).min(map.dims()[k] - 1);
            f[k] = place - at[k] as f64;
        }
        let block = at.map(|i| i / SIDE);
        let number = (block[0] * blocks[1] + block[1]) * blocks[2] + block[2];
        let corners = made.get(number, || self.make(map, block));
        let first = ((at[0] % SIDE) * CORNERS + at[1] % SIDE) * CORNERS + at[2] % SIDE;
        bands(|b| {
            let edge = |k: usize| {
                let (lo, hi) = (corners[first + k][b] as f64, corners[first + k + 1][b] as f64);
                lo + (hi - lo) * f[2]
            };
            let face = |k: usize| {
                let (lo, hi) = (edge(k), edge(k + CORNERS));
                lo + (hi - lo) * f[1]
            };
            let (lo, hi) = (face(0), face(CORNERS * CORNERS));
            lo + (hi - lo) * f[0]
        })
    }

    fn make(&self, map: &Voxmap, block: [usize; 3]) -> Block {
        let place = |k: usize| [k / (CORNERS * CORNERS), k / CORNERS % CORNERS, k % CORNERS];
        let at = |k: usize| {
            let p = place(k);
            [0, 1, 2].map(|i| (block[i] * SIDE + p[i]).min(map.dims()[i]))
        };
        (0..CORNERS * CORNERS * CORNERS).map(|k| self.exactly(map.corner(at(k))).map(|d| d as f32)).collect()
    }

    fn exactly(&self, x: Vec3) -> Bands {
        self.transport.medium_depth(x, self.transport.beyond(x, self.towards))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::{sequence, vec3};
    use zonal_scene::{Scene, SceneParts};

    /// A box of which the lower half is thicker by a factor, with a border oblique to the voxels.
    fn scene(factor: f64) -> Scene {
        let mut map = Voxmap::new(Vec3::ZERO, vec3(0.2, 0.25, 0.3), [21, 18, 13]).unwrap();
        for i in 0..map.len() {
            let c = map.centre(map.coordinates(i));
            let kappa = if c.z + 0.3 * c.x < 2.2 { 0.1 * factor } else { 0.1 };
            map.set(i, [kappa, 0.5 * kappa, 0.0], [0.5; 3], [0.0; 3], [0.0; 3]);
        }
        Scene::new(SceneParts { voxmap: Some(map.seal().unwrap()), ..SceneParts::default() }).unwrap()
    }

    #[test]
    fn the_depth_is_that_of_the_walk() {
        for factor in [1.0, 8.0] {
            let scene = scene(factor);
            let transport = Transport::new(&scene);
            let towards = Towards::new(&transport, vec3(0.3, -0.4, 0.87).normalized());
            let (mut worst, mut sum, n) = (0.0f64, 0.0, 2000);
            for i in 0..n {
                let [x, y, z] = sequence::r3(i, [0.1, 0.2, 0.3]);
                let p = vec3(4.2 * x, 4.5 * y, 3.9 * z);
                let (found, exact) = (towards.depth(p), towards.exactly(p));
                for b in 0..3 {
                    worst = worst.max((found[b] - exact[b]).abs());
                    sum += (found[b] - exact[b]) / (3 * n) as f64;
                }
            }
            // The difference of κ on both sides times the width of a voxel.
            let most = if factor == 1.0 { 1e-12 } else { 0.1 * (factor - 1.0) * 0.3 };
            assert!(worst <= most && sum.abs() < 0.02 * most + 1e-12, "{worst} {sum}");
        }
    }
}
