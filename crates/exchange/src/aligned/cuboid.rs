//! Axis-aligned boxes and rectangles.

use zonal_math::{Vec3, vec3};

/// A voxel (no normal, positive extent on every axis) or an axis-aligned rectangular patch: a box of zero
/// thickness on the axis of its normal. Lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    /// Lower corner, m.
    pub lo: Vec3,
    /// Upper corner, m.
    pub hi: Vec3,
    /// Axis (0, 1, 2) and sign (+1, −1) of a patch's normal; `None` for a voxel.
    pub normal: Option<(usize, i8)>,
}

impl Cuboid {
    /// The voxel between two corners.
    pub const fn voxel(lo: Vec3, hi: Vec3) -> Cuboid {
        Cuboid { lo, hi, normal: None }
    }

    /// The rectangle between two corners that agree on `axis`, facing `sign` (+1 or −1) along it.
    pub const fn patch(lo: Vec3, hi: Vec3, axis: usize, sign: i8) -> Cuboid {
        Cuboid { lo, hi, normal: Some((axis, sign)) }
    }

    /// Extents along the axes, m.
    pub fn extent(&self) -> Vec3 {
        self.hi - self.lo
    }

    /// Volume of a voxel in m³, area of a patch in m².
    pub fn measure(&self) -> f64 {
        let e = self.extent();
        match self.normal {
            None => e.product(),
            Some((0, _)) => e.y * e.z,
            Some((1, _)) => e.z * e.x,
            Some(_) => e.x * e.y,
        }
    }

    /// True when the corners are finite and the extents positive, but for the one across a patch, which is zero.
    pub fn is_valid(&self) -> bool {
        let sound = |k: usize| match self.normal {
            Some((axis, _)) if axis == k => self.lo[k] == self.hi[k],
            _ => self.lo[k] < self.hi[k],
        };
        let named = self.normal.is_none_or(|(axis, sign)| axis < 3 && (sign == 1 || sign == -1));
        named && self.lo.is_finite() && self.hi.is_finite() && (0..3).all(sound)
    }

    /// The six faces of a voxel as patches that look inwards: −x, +x, −y, +y, −z, +z side.
    pub fn walls(&self) -> [Cuboid; 6] {
        [0, 1, 2, 3, 4, 5].map(|f| {
            let (axis, upper) = (f / 2, f % 2 == 1);
            let plane = if upper { self.hi[axis] } else { self.lo[axis] };
            let on_plane = |v: Vec3| {
                let mut c = v.array();
                c[axis] = plane;
                vec3(c[0], c[1], c[2])
            };
            Cuboid::patch(on_plane(self.lo), on_plane(self.hi), axis, if upper { -1 } else { 1 })
        })
    }
}
