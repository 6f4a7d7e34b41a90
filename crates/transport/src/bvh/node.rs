//! A node's eight boxes, and the slab test of all of them at once.

use zonal_math::Vec3;
use zonal_math::wide::{Lanes, Wide};

pub(super) const LANES: usize = 8;
/// The bit of a child that is a leaf.
pub(super) const LEAF: u32 = 1 << 31;
/// Eight boxes: lower x, y, z, upper x, y, z; a child is a node, or a block of plates when its top bit is set.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Node {
    pub bounds: [Lanes; 6],
    pub child: [u32; LANES],
}

pub(super) const EMPTY: Node = Node {
    bounds: [
        [f32::INFINITY; LANES],
        [f32::INFINITY; LANES],
        [f32::INFINITY; LANES],
        [f32::NEG_INFINITY; LANES],
        [f32::NEG_INFINITY; LANES],
        [f32::NEG_INFINITY; LANES],
    ],
    child: [LEAF; LANES],
};

/// The block of a child that is a leaf.
#[inline(always)]
pub(super) fn leaf(child: u32) -> Option<usize> {
    (child & LEAF != 0).then_some((child & !LEAF) as usize)
}

/// A segment as the boxes see it.
pub(super) struct Ray {
    origin: [f32; 3],
    inverse: [f32; 3],
    near: [usize; 3],
    far: [usize; 3],
}

impl Ray {
    #[inline(always)]
    pub(super) fn new(a: Vec3, d: Vec3) -> Ray {
        let inverse = d.array().map(|x| {
            let x = x as f32;
            1.0 / if x.abs() < 1e-20 { 1e-20f32.copysign(x) } else { x }
        });
        Ray {
            origin: a.array().map(|x| x as f32),
            inverse,
            near: std::array::from_fn(|k| if inverse[k] < 0.0 { k + 3 } else { k }),
            far: std::array::from_fn(|k| if inverse[k] < 0.0 { k } else { k + 3 }),
        }
    }

    /// The lanes whose boxes the segment meets before `t_max`, and where it enters each.
    #[inline(always)]
    pub(super) fn enter<W: Wide>(&self, w: W, node: &Node, t_max: f32) -> (u32, W::F) {
        let ([nx, ny, nz], [fx, fy, fz]) = (self.near, self.far);
        let (x0, x1) = (self.plane(w, node, nx, 0), self.plane(w, node, fx, 0));
        let (y0, y1) = (self.plane(w, node, ny, 1), self.plane(w, node, fy, 1));
        let (z0, z1) = (self.plane(w, node, nz, 2), self.plane(w, node, fz, 2));
        let t0 = w.max(w.max(x0, y0), w.max(z0, w.splat(0.0)));
        let t1 = w.min(w.min(x1, y1), w.min(z1, w.splat(t_max)));
        (w.le(t0, t1), t0)
    }

    /// Where the segment's line meets a side of all boxes. Functions, not closures: these would miss the wide instructions.
    #[inline(always)]
    fn plane<W: Wide>(&self, w: W, node: &Node, side: usize, axis: usize) -> W::F {
        let x = w.load(&node.bounds[side]);
        w.mul(w.sub(x, w.splat(self.origin[axis])), w.splat(self.inverse[axis]))
    }
}
