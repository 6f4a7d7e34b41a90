//! A node's eight boxes, and the slab test of all of them at once.

use zonal_math::Vec3;

pub(super) const LANES: usize = 8;
pub(super) const LEAF_BITS: u32 = 27;
/// Eight boxes: lower x, y, z, upper x, y, z; a child is a node, or a run of plates when its top bit is set.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Node {
    pub bounds: [[f32; LANES]; 6],
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
    child: [1 << 31; LANES],
};

pub(super) fn leaf(child: u32) -> Option<std::ops::Range<usize>> {
    (child >> 31 == 1).then(|| {
        let first = (child & ((1 << LEAF_BITS) - 1)) as usize;
        first..first + (child >> LEAF_BITS & 15) as usize
    })
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
    pub fn new(a: Vec3, d: Vec3) -> Ray {
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

    /// The lanes whose boxes the segment meets before `t_max`, and where it enters each. Kept out of line, or the loops are
    /// unrolled into their callers before they become vectors.
    #[inline(never)]
    pub fn enter(&self, node: &Node, t_max: f32, entry: &mut [f32; LANES]) -> u32 {
        let [nx, ny, nz] = self.near.map(|k| &node.bounds[k]);
        let [fx, fy, fz] = self.far.map(|k| &node.bounds[k]);
        let ([ox, oy, oz], [ix, iy, iz]) = (self.origin, self.inverse);
        let max = |a: f32, b: f32| if a > b { a } else { b };
        let min = |a: f32, b: f32| if a < b { a } else { b };
        let mut hit = [0u32; LANES];
        for l in 0..LANES {
            let (x0, y0, z0) = ((nx[l] - ox) * ix, (ny[l] - oy) * iy, (nz[l] - oz) * iz);
            let (x1, y1, z1) = ((fx[l] - ox) * ix, (fy[l] - oy) * iy, (fz[l] - oz) * iz);
            let t0 = max(max(x0, y0), max(z0, 0.0));
            let t1 = min(min(x1, y1), min(z1, t_max));
            entry[l] = t0;
            hit[l] = if t0 <= t1 { 1 << l } else { 0 };
        }
        hit.iter().fold(0, |m, h| m | h)
    }
}
