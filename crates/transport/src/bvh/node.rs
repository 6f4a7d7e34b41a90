//! Inner nodes of the hierarchy: eight boxes, and the slab test of all of them at once.

use zonal_math::Vec3;
use zonal_math::simd::f32x8::{F32x8, F32x8Ops};

/// Boxes of a node.
pub(super) const NODE_WIDTH: usize = 8;
/// Bit of a child index that marks a leaf.
pub(super) const LEAF_FLAG: u32 = 1 << 31;
/// Bit of a child index that marks a lane whose plates have a common plane.
pub(super) const FLAT_FLAG: u32 = 1 << 30;

/// Eight boxes: lower x, y, z, upper x, y, z. A child is the index of a node, or of a leaf block when its top bit is set; `plane` is the
/// index of the common plane of the plates below it, where `FLAT_FLAG` is set.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct WideNode {
    pub bounds: [F32x8; 6],
    pub child: [u32; NODE_WIDTH],
    pub plane: [u32; NODE_WIDTH],
}

impl WideNode {
    /// Starts to load the node: the lines of the lower and of the upper bounds, and that of the children.
    #[inline(always)]
    pub(super) fn prefetch<W: F32x8Ops>(&self, w: W) {
        w.prefetch(&self.bounds[0]);
        w.prefetch(&self.bounds[2]);
        w.prefetch(&self.bounds[4]);
        w.prefetch(&self.child);
    }
    /// Number of lanes in use, which come first.
    pub(super) fn lane_count(&self) -> usize {
        (0..NODE_WIDTH).take_while(|&lane| self.bounds[0][lane] <= self.bounds[3][lane]).count()
    }
}

/// A node of empty boxes, which no segment meets.
pub(super) const EMPTY_NODE: WideNode = WideNode {
    bounds: [
        [f32::INFINITY; NODE_WIDTH],
        [f32::INFINITY; NODE_WIDTH],
        [f32::INFINITY; NODE_WIDTH],
        [f32::NEG_INFINITY; NODE_WIDTH],
        [f32::NEG_INFINITY; NODE_WIDTH],
        [f32::NEG_INFINITY; NODE_WIDTH],
    ],
    child: [LEAF_FLAG; NODE_WIDTH],
    plane: [0; NODE_WIDTH],
};

/// The node or leaf block that a child stands for.
#[derive(Clone, Copy)]
pub(super) enum Child {
    Node(usize),
    Leaf(usize),
}

impl Child {
    #[inline(always)]
    pub(super) fn of(child: u32) -> Child {
        let index = (child & !(LEAF_FLAG | FLAT_FLAG)) as usize;
        if child & LEAF_FLAG != 0 { Child::Leaf(index) } else { Child::Node(index) }
    }
}

/// A segment in single precision, prepared for slab tests.
pub(super) struct BoxRay {
    origin: [f32; 3],
    inverse: [f32; 3],
    near: [usize; 3],
    far: [usize; 3],
}

impl BoxRay {
    #[inline(always)]
    pub(super) fn new(a: Vec3, d: Vec3) -> BoxRay {
        let inverse = d.array().map(|x| {
            let x = x as f32;
            1.0 / if x.abs() < 1e-20 { 1e-20f32.copysign(x) } else { x }
        });
        BoxRay {
            origin: a.array().map(|x| x as f32),
            inverse,
            near: std::array::from_fn(|k| if inverse[k] < 0.0 { k + 3 } else { k }),
            far: std::array::from_fn(|k| if inverse[k] < 0.0 { k } else { k + 3 }),
        }
    }

    /// The lanes whose boxes the segment meets before `t_max`, as a bit mask, and the parameter of entry of each.
    #[inline(always)]
    pub(super) fn enter<W: F32x8Ops>(&self, w: W, node: &WideNode, t_max: f32) -> (u32, W::Vector) {
        let ([nx, ny, nz], [fx, fy, fz]) = (self.near, self.far);
        let (x0, x1) = (self.plane(w, node, nx, 0), self.plane(w, node, fx, 0));
        let (y0, y1) = (self.plane(w, node, ny, 1), self.plane(w, node, fy, 1));
        let (z0, z1) = (self.plane(w, node, nz, 2), self.plane(w, node, fz, 2));
        let t0 = w.max(w.max(x0, y0), w.max(z0, w.splat(0.0)));
        let t1 = w.min(w.min(x1, y1), w.min(z1, w.splat(t_max)));
        (w.le(t0, t1), t0)
    }

    /// The lanes whose boxes the segment meets, as a bit mask, and in the next eight bits the lanes whose boxes hold an end of it.
    #[inline(always)]
    pub(super) fn enter_segment<W: F32x8Ops>(&self, w: W, node: &WideNode) -> u32 {
        let ([nx, ny, nz], [fx, fy, fz]) = (self.near, self.far);
        let (x0, x1) = (self.plane(w, node, nx, 0), self.plane(w, node, fx, 0));
        let (y0, y1) = (self.plane(w, node, ny, 1), self.plane(w, node, fy, 1));
        let (z0, z1) = (self.plane(w, node, nz, 2), self.plane(w, node, fz, 2));
        let (zero, one) = (w.splat(0.0), w.splat(1.0));
        let t0 = w.max(w.max(x0, y0), w.max(z0, zero));
        let t1 = w.min(w.min(x1, y1), w.min(z1, one));
        let ends = w.le(t0, zero) | w.le(one, t1);
        // The lanes without an end, and above them those with one.
        (w.le(t0, t1) * 0x101) & (ends * 0xFF + 0xFF)
    }

    /// Parameters at which the line meets one side of all boxes. A function because closures do not inherit the target features of
    /// the SIMD kernel.
    #[inline(always)]
    fn plane<W: F32x8Ops>(&self, w: W, node: &WideNode, side: usize, axis: usize) -> W::Vector {
        let x = w.load(&node.bounds[side]);
        w.mul(w.sub(x, w.splat(self.origin[axis])), w.splat(self.inverse[axis]))
    }
}
