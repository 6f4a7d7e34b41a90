//! The free part of a cut voxel: samples in its sub-cells, eight bytes each.
//!
//! A voxel is divided into [`SUBCELLS`]³ sub-cells. Of each that has free space in this part one sample is kept: a point, on a lattice
//! of 2¹⁶ places along each edge of its sub-cell, and the share of the free volume that it stands for, in 2¹⁶ steps of the sub-cell. The
//! sub-cells are the ones of a mask of 64 bits. Shares are relative: the volumes of a part's samples add up to its volume.

use zonal_math::{Vec3, vec3};

/// A cut voxel is resolved into SUBCELLS³ sub-cells.
pub const SUBCELLS: usize = 4;

/// Places along an edge of a sub-cell, and steps of a share.
const STEPS: f64 = 65536.0;

/// A point that stands for a part of a voxel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// A point in free space, m.
    pub point: Vec3,
    /// The free volume it stands for, m³.
    pub volume: f64,
    /// The sub-cell of the voxel it lies in: (i·s + j)·s + k with s = [`SUBCELLS`].
    pub subcell: u8,
}

/// The samples of a cut voxel zone by ascending sub-cell, packed; empty for a whole voxel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part(Option<Box<Packed>>);

#[derive(Clone, Debug, PartialEq)]
struct Packed {
    /// Lower corner of the cell, m.
    lo: Vec3,
    /// Edges of a sub-cell, m.
    edges: Vec3,
    /// Volume of one step of a share, m³.
    unit: f64,
    /// Bit k: sub-cell k has a sample.
    mask: u64,
    /// Place in the sub-cell and share.
    samples: Box<[[u16; 4]]>,
}

/// Coordinates of a sub-cell, 0 to SUBCELLS − 1 each.
pub fn coordinates(subcell: u8) -> Vec3 {
    let (k, s) = (subcell as usize, SUBCELLS);
    vec3((k / (s * s)) as f64, (k / s % s) as f64, (k % s) as f64)
}

fn place(x: f64) -> u16 {
    (x * STEPS).floor().clamp(0.0, STEPS - 1.0) as u16
}

/// The place nearest to `point` that a sample of `subcell` can have, in the cell with lower corner `lo` and edges `cell`.
pub fn packed_point(lo: Vec3, cell: Vec3, subcell: u8, point: Vec3) -> Vec3 {
    let edges = cell * (1.0 / SUBCELLS as f64);
    unpack(lo, edges, subcell, pack(lo, edges, subcell, point))
}

fn pack(lo: Vec3, edges: Vec3, subcell: u8, point: Vec3) -> [u16; 3] {
    let c = coordinates(subcell);
    [0, 1, 2].map(|k| place((point[k] - lo[k]) / edges[k] - c[k]))
}

fn unpack(lo: Vec3, edges: Vec3, subcell: u8, q: [u16; 3]) -> Vec3 {
    let at = Vec3::from_array(q.map(|q| (q as f64 + 0.5) / STEPS));
    lo + edges.scale(coordinates(subcell) + at)
}

impl Part {
    /// Packs samples by ascending sub-cell; their volumes are shares of `volume` (m³), the part's own. `lo` and `cell` are the lower
    /// corner and the edges of the voxel, m. Sub-cells are below SUBCELLS³; of two samples of one the first is kept.
    pub fn new(lo: Vec3, cell: Vec3, volume: f64, samples: &[Sample]) -> Part {
        let edges = cell * (1.0 / SUBCELLS as f64);
        let mut mask = 0u64;
        let mut packed = Vec::with_capacity(samples.len());
        for s in samples {
            if mask >> s.subcell != 0 {
                continue;
            }
            let [x, y, z] = pack(lo, edges, s.subcell, s.point);
            mask |= 1 << s.subcell;
            // Never nothing, so that means over shares exist.
            packed.push([x, y, z, place(s.volume / edges.product()).max(1)]);
        }
        Part::from_packed(lo, cell, volume, mask, packed.into_boxed_slice()).unwrap_or_default()
    }

    /// The part with these [`Part::packed`] samples; `None` where mask and samples disagree.
    pub fn from_packed(
        lo: Vec3,
        cell: Vec3,
        volume: f64,
        mask: u64,
        samples: Box<[[u16; 4]]>,
    ) -> Option<Part> {
        let shares: u64 = samples.iter().map(|s| s[3] as u64).sum();
        if mask.count_ones() as usize != samples.len() || (shares == 0 && mask != 0) {
            return None;
        }
        let (edges, unit) = (cell * (1.0 / SUBCELLS as f64), volume / shares as f64);
        Some(Part((mask != 0).then(|| Box::new(Packed { lo, edges, unit, mask, samples }))))
    }

    /// The mask of sub-cells, and of each in it by ascending sub-cell the place, in 2⁻¹⁶ of its edges, and the share.
    pub fn packed(&self) -> (u64, &[[u16; 4]]) {
        self.0.as_ref().map_or((0, &[]), |p| (p.mask, &p.samples))
    }

    /// True for a whole voxel.
    pub fn is_empty(&self) -> bool {
        self.0.is_none()
    }
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.packed().1.len()
    }
    /// Bytes of memory besides the struct itself.
    pub fn bytes(&self) -> usize {
        self.0.as_ref().map_or(0, |p| size_of::<Packed>() + size_of_val(&*p.samples))
    }

    /// The samples by ascending sub-cell.
    pub fn iter(&self) -> impl Iterator<Item = Sample> + '_ {
        self.0.iter().flat_map(|p| {
            let mut left = p.mask;
            p.samples.iter().map(move |&[x, y, z, share]| {
                let subcell = left.trailing_zeros() as u8;
                left &= left - 1;
                let point = unpack(p.lo, p.edges, subcell, [x, y, z]);
                Sample { point, volume: share as f64 * p.unit, subcell }
            })
        })
    }

    /// The point of the sample that stands for the share `u` ∈ [0, 1) of the volume, samples by ascending sub-cell; `None` for a whole
    /// voxel.
    pub fn point_at(&self, u: f64) -> Option<Vec3> {
        let p = self.0.as_ref()?;
        let shares: u64 = p.samples.iter().map(|s| s[3] as u64).sum();
        let mut rest = u * shares as f64;
        let (mut left, last) = (p.mask, p.samples.len() - 1);
        for (k, &[x, y, z, share]) in p.samples.iter().enumerate() {
            rest -= share as f64;
            if rest <= 0.0 || k == last {
                return Some(unpack(p.lo, p.edges, left.trailing_zeros() as u8, [x, y, z]));
            }
            left &= left - 1;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_survive_packing_and_their_volumes_add_up() {
        let (lo, cell) = (vec3(3.0, -2.0, 100.0), vec3(0.2, 0.3, 0.4));
        let sub = cell * 0.25;
        let list: Vec<Sample> = [0u8, 5, 17, 62, 63]
            .map(|k| Sample {
                point: lo + sub.scale(coordinates(k) + vec3(0.3, 0.5, 0.999_999)),
                volume: sub.product() * (0.1 + 0.9 * k as f64 / 63.0),
                subcell: k,
            })
            .to_vec();
        let volume: f64 = list.iter().map(|s| s.volume).sum();
        let part = Part::new(lo, cell, volume, &list);
        assert_eq!(part.len(), 5);
        let back: Vec<Sample> = part.iter().collect();
        for (a, b) in list.iter().zip(&back) {
            assert_eq!(a.subcell, b.subcell);
            assert!(
                (a.point - b.point).max_abs() < 1e-6 && (a.volume - b.volume).abs() < 1e-4 * sub.product()
            );
            assert_eq!(packed_point(lo, cell, b.subcell, b.point), b.point);
        }
        assert!((back.iter().map(|s| s.volume).sum::<f64>() / volume - 1.0).abs() < 1e-12);
        let (mask, packed) = part.packed();
        assert_eq!(Part::from_packed(lo, cell, volume, mask, packed.into()), Some(part.clone()));
        assert_eq!(Part::from_packed(lo, cell, volume, mask | 2, packed.into()), None);
        assert_eq!(part.point_at(0.0), Some(back[0].point));
        assert_eq!(part.point_at(1.0 - 1e-12), Some(back[4].point));
        assert!(Part::default().is_empty() && Part::default().iter().next().is_none());
    }
}
