//! Sample points of the part outside solids of a voxel that walls cut, eight bytes each.
//!
//! A voxel is divided into [`SUBCELLS`]³ sub-cells. Each sub-cell with free space in the part has one sample: a point on a lattice of
//! 2¹⁶ positions along each edge of the sub-cell, and its weight, a fraction of the sub-cell's volume in steps of 2⁻¹⁶. A mask of 64 bits
//! marks the occupied sub-cells. Weights are relative: the volumes of all samples sum to the volume of the part.

use zonal_math::{Vec3, vec3};

/// Number of sub-cells of a voxel along each axis.
pub const SUBCELLS: usize = 4;

/// Lattice positions along an edge of a sub-cell, and steps of a weight.
const LATTICE_STEPS: f64 = 65536.0;

/// A sample point with the volume that it represents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeSample {
    /// A point in free space, m.
    pub point: Vec3,
    /// Free volume represented by the point, m³.
    pub volume: f64,
    /// Sub-cell of the voxel: (i·s + j)·s + k with s = [`SUBCELLS`].
    pub subcell: u8,
}

/// The samples of a cut voxel zone by ascending sub-cell, packed; empty for a whole voxel.
///
/// ```
/// use zonal_math::{Vec3, vec3};
/// use zonal_scene::{VolumeSample, VoxelSamples};
/// let sample = VolumeSample { point: vec3(0.1, 0.1, 0.1), volume: 1.0 / 64.0, subcell: 0 };
/// let samples = VoxelSamples::new(Vec3::ZERO, Vec3::ONE, 0.01, &[sample]);
/// let unpacked: Vec<VolumeSample> = samples.iter().collect();
/// assert!((unpacked[0].point - sample.point).length() < 1e-5);
/// assert!((unpacked[0].volume - 0.01).abs() < 1e-12);
/// assert_eq!(samples.sample_in(0), Some(unpacked[0]));
/// assert_eq!(samples.sample_in(1), None);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VoxelSamples(Option<Box<PackedSamples>>);

#[derive(Clone, Debug, PartialEq)]
struct PackedSamples {
    /// Lower corner of the cell, m.
    lo: Vec3,
    /// Edges of a sub-cell, m.
    edges: Vec3,
    /// Volume of one weight step, m³.
    unit: f64,
    /// Bit k is set if sub-cell k has a sample.
    mask: u64,
    /// Lattice position in the sub-cell and weight.
    samples: Box<[[u16; 4]]>,
}

/// Coordinates of a sub-cell, 0 to SUBCELLS − 1 each.
pub fn subcell_coordinates(subcell: u8) -> Vec3 {
    let (k, s) = (subcell as usize, SUBCELLS);
    vec3((k / (s * s)) as f64, (k / s % s) as f64, (k % s) as f64)
}

/// The sub-cell nearest to `point` in the voxel with lower corner `lo` and edges `cell`, m.
pub fn subcell_at(lo: Vec3, cell: Vec3, point: Vec3) -> u8 {
    let at = |k: usize| ((point[k] - lo[k]) / cell[k] * SUBCELLS as f64).max(0.0) as usize;
    let [x, y, z] = [0, 1, 2].map(|k| at(k).min(SUBCELLS - 1));
    ((x * SUBCELLS + y) * SUBCELLS + z) as u8
}

/// The lattice position of a fraction of an edge.
fn lattice_position(x: f64) -> u16 {
    (x * LATTICE_STEPS).floor().clamp(0.0, LATTICE_STEPS - 1.0) as u16
}

/// The lattice point of `subcell` nearest to `point`, in the cell with lower corner `lo` and edges `cell`.
pub fn packed_point(lo: Vec3, cell: Vec3, subcell: u8, point: Vec3) -> Vec3 {
    let edges = cell * (1.0 / SUBCELLS as f64);
    unpack_point(lo, edges, subcell, pack_point(lo, edges, subcell, point))
}

fn pack_point(lo: Vec3, edges: Vec3, subcell: u8, point: Vec3) -> [u16; 3] {
    let c = subcell_coordinates(subcell);
    [0, 1, 2].map(|k| lattice_position((point[k] - lo[k]) / edges[k] - c[k]))
}

fn unpack_point(lo: Vec3, edges: Vec3, subcell: u8, q: [u16; 3]) -> Vec3 {
    let at = Vec3::from_array(q.map(|q| (q as f64 + 0.5) / LATTICE_STEPS));
    lo + edges.scale(subcell_coordinates(subcell) + at)
}

impl VoxelSamples {
    /// Those of a whole voxel.
    pub(crate) const fn none() -> VoxelSamples {
        VoxelSamples(None)
    }

    /// Packs samples given by ascending sub-cell; their volumes are scaled to sum to `volume` (m³). `lo` and `cell` are the lower corner
    /// and the edges of the voxel, m. Sub-cells are below SUBCELLS³; a second sample of a sub-cell is ignored.
    pub fn new(lo: Vec3, cell: Vec3, volume: f64, samples: &[VolumeSample]) -> VoxelSamples {
        let edges = cell * (1.0 / SUBCELLS as f64);
        let mut mask = 0u64;
        let mut packed = Vec::with_capacity(samples.len());
        for s in samples {
            if mask >> s.subcell != 0 {
                continue;
            }
            let [x, y, z] = pack_point(lo, edges, s.subcell, s.point);
            mask |= 1 << s.subcell;
            // At least one step, so that weighted means exist.
            packed.push([x, y, z, lattice_position(s.volume / edges.product()).max(1)]);
        }
        VoxelSamples::from_packed(lo, cell, volume, mask, packed.into_boxed_slice()).unwrap_or_default()
    }

    /// The inverse of [`VoxelSamples::packed`]; `None` if mask and samples are inconsistent.
    pub fn from_packed(
        lo: Vec3,
        cell: Vec3,
        volume: f64,
        mask: u64,
        samples: Box<[[u16; 4]]>,
    ) -> Option<VoxelSamples> {
        let total_weight: u64 = samples.iter().map(|s| s[3] as u64).sum();
        if mask.count_ones() as usize != samples.len() || (total_weight == 0 && mask != 0) {
            return None;
        }
        let (edges, unit) = (cell * (1.0 / SUBCELLS as f64), volume / total_weight as f64);
        Some(VoxelSamples((mask != 0).then(|| Box::new(PackedSamples { lo, edges, unit, mask, samples }))))
    }

    /// The mask of occupied sub-cells and, by ascending sub-cell, lattice position (2⁻¹⁶ of its edges) and weight of each sample.
    pub fn packed(&self) -> (u64, &[[u16; 4]]) {
        self.0.as_ref().map_or((0, &[]), |p| (p.mask, &p.samples))
    }

    /// The sample of a sub-cell; `None` without one.
    pub fn sample_in(&self, subcell: u8) -> Option<VolumeSample> {
        let p = self.0.as_ref().filter(|p| p.mask >> subcell & 1 == 1)?;
        let [x, y, z, weight] = p.samples[(p.mask & ((1 << subcell) - 1)).count_ones() as usize];
        let point = unpack_point(p.lo, p.edges, subcell, [x, y, z]);
        Some(VolumeSample { point, volume: weight as f64 * p.unit, subcell })
    }

    /// The samples reflected across some axes, in a cell with lower corner `lo` and edges `cell` (m) and the free volume `volume` (m³).
    #[must_use]
    pub fn reflected(&self, axes: [bool; 3], lo: Vec3, cell: Vec3, volume: f64) -> VoxelSamples {
        let Some(p) = &self.0 else { return VoxelSamples::default() };
        let s = SUBCELLS as u8;
        let mut mask = p.mask;
        let mut moved: Vec<(u8, [u16; 4])> = Vec::with_capacity(p.samples.len());
        for &sample in &p.samples {
            let k = mask.trailing_zeros() as u8;
            mask &= mask - 1;
            let (mut at, mut q) = ([k / (s * s), k / s % s, k % s], sample);
            for a in (0..3).filter(|&a| axes[a]) {
                (at[a], q[a]) = (s - 1 - at[a], u16::MAX - q[a]);
            }
            moved.push(((at[0] * s + at[1]) * s + at[2], q));
        }
        moved.sort_unstable_by_key(|m| m.0);
        let mask = moved.iter().fold(0, |mask, m| mask | 1u64 << m.0);
        let samples = moved.into_iter().map(|m| m.1).collect();
        VoxelSamples::from_packed(lo, cell, volume, mask, samples).unwrap_or_default()
    }

    /// True for a whole voxel.
    pub fn is_empty(&self) -> bool {
        self.0.is_none()
    }
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.packed().1.len()
    }
    /// Heap memory, bytes.
    pub fn bytes(&self) -> usize {
        self.0.as_ref().map_or(0, |p| size_of::<PackedSamples>() + size_of_val(&*p.samples))
    }

    /// The samples by ascending sub-cell.
    pub fn iter(&self) -> impl Iterator<Item = VolumeSample> + '_ {
        self.0.iter().flat_map(|p| {
            let mut mask = p.mask;
            p.samples.iter().map(move |&[x, y, z, weight]| {
                let subcell = mask.trailing_zeros() as u8;
                mask &= mask - 1;
                let point = unpack_point(p.lo, p.edges, subcell, [x, y, z]);
                VolumeSample { point, volume: weight as f64 * p.unit, subcell }
            })
        })
    }

    /// The sample at the fraction `u` ∈ [0, 1) of the cumulative volume, by ascending sub-cell, m, and the lower corner and the edges of its sub-cell, m; `None` for a
    /// whole voxel.
    pub fn sample_at(&self, u: f64) -> Option<(Vec3, [Vec3; 2])> {
        let p = self.0.as_ref()?;
        let total_weight: u64 = p.samples.iter().map(|s| s[3] as u64).sum();
        let mut remaining = u * total_weight as f64;
        let (mut mask, last) = (p.mask, p.samples.len() - 1);
        for (sample, &[x, y, z, weight]) in p.samples.iter().enumerate() {
            remaining -= weight as f64;
            if remaining <= 0.0 || sample == last {
                let k = mask.trailing_zeros() as u8;
                let lo = p.lo + p.edges.scale(subcell_coordinates(k));
                return Some((unpack_point(p.lo, p.edges, k, [x, y, z]), [lo, p.edges]));
            }
            mask &= mask - 1;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_samples_keep_points_and_total_volume() {
        let (lo, cell) = (vec3(3.0, -2.0, 100.0), vec3(0.2, 0.3, 0.4));
        let sub = cell * 0.25;
        let list: Vec<VolumeSample> = [0u8, 5, 17, 62, 63]
            .map(|k| VolumeSample {
                point: lo + sub.scale(subcell_coordinates(k) + vec3(0.3, 0.5, 0.999_999)),
                volume: sub.product() * (0.1 + 0.9 * k as f64 / 63.0),
                subcell: k,
            })
            .to_vec();
        let volume: f64 = list.iter().map(|s| s.volume).sum();
        let part = VoxelSamples::new(lo, cell, volume, &list);
        assert_eq!(part.len(), 5);
        let unpacked: Vec<VolumeSample> = part.iter().collect();
        for (a, b) in list.iter().zip(&unpacked) {
            assert_eq!(a.subcell, b.subcell);
            assert!(
                (a.point - b.point).max_abs() < 1e-6 && (a.volume - b.volume).abs() < 1e-4 * sub.product()
            );
            assert_eq!(packed_point(lo, cell, b.subcell, b.point), b.point);
        }
        assert!((unpacked.iter().map(|s| s.volume).sum::<f64>() / volume - 1.0).abs() < 1e-12);
        let (mask, packed) = part.packed();
        assert_eq!(VoxelSamples::from_packed(lo, cell, volume, mask, packed.into()), Some(part.clone()));
        assert_eq!(VoxelSamples::from_packed(lo, cell, volume, mask | 2, packed.into()), None);
        assert_eq!(part.sample_at(0.0).map(|s| s.0), Some(unpacked[0].point));
        assert_eq!(part.sample_at(1.0 - 1e-12).map(|s| s.0), Some(unpacked[4].point));
        assert!(VoxelSamples::default().is_empty() && VoxelSamples::default().iter().next().is_none());
    }
}
