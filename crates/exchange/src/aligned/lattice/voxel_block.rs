//! The factors of one voxel with a block of voxels, the timing case of Arquès and Michelin (1996).
//!
//! Only the distinct offsets are computed, on the calling thread and without any cache except the constants of the Gauss rules; then all
//! factors are written out. Offsets may be half integers: the axis of a block with an even
//! number of voxels runs between them.

use super::offset_family::{MethodCounts, OffsetFamily};

/// The factors of one voxel with all voxels of a block, m⁴; the block's last axis runs fastest.
#[derive(Clone, Debug)]
pub struct VoxelBlock {
    /// Values, m⁴.
    pub values: Vec<f64>,
    /// Proved radii, m⁴.
    pub radii: Vec<f64>,
    /// Distinct offsets that were computed.
    pub distinct: usize,
    /// Number of distinct offsets by method.
    pub method_counts: MethodCounts,
}

/// The distinct distances along one axis, and the one of each cell.
struct AxisDistances {
    /// Distances in cells, less `shift`, ascending.
    distances: Vec<u16>,
    of_cell: Vec<u32>,
    shift: f64,
}

impl AxisDistances {
    fn new(first: f64, count: usize) -> AxisDistances {
        let twice = 2.0 * first;
        assert!(
            twice == twice.round() && twice.abs() + 2.0 * count as f64 <= 65_535.0,
            "offset {first} cells"
        );
        let shift = if twice.rem_euclid(2.0) == 1.0 { 0.5 } else { 0.0 };
        let cell = |i: usize| ((first + i as f64).abs() - shift) as u16;
        let mut distances: Vec<u16> = (0..count).map(cell).collect();
        distances.sort_unstable();
        distances.dedup();
        // Distances are consecutive integers.
        let least = distances[0];
        AxisDistances { of_cell: (0..count).map(|i| (cell(i) - least) as u32).collect(), distances, shift }
    }
}

/// The factors of a voxel with `edges` (m) and a block of `counts` voxels like it; `first` is the offset from the voxel to the
/// block's first one in cells, whole or half numbers. Extinction `kappa` 1/m; radii at most `tolerance` · value.
///
/// ```
/// use zonal_exchange::aligned::lattice::voxel_block;
/// let b = voxel_block([1.0; 3], [3.0, -9.5, -9.5], [20, 20, 20], 0.0, 1e-6);
/// assert!(b.values.len() == 8000 && b.distinct < 1400);
/// ```
///
/// # Panics
/// On an edge or tolerance that is not positive and finite, a bad `kappa`, a count of zero, an offset that is no multiple of ½.
pub fn voxel_block(
    edges: [f64; 3],
    first: [f64; 3],
    counts: [usize; 3],
    kappa: f64,
    tolerance: f64,
) -> VoxelBlock {
    assert!(counts.iter().all(|n| *n > 0), "counts {counts:?}");
    let [x, y, z] = [0, 1, 2].map(|k| AxisDistances::new(first[k], counts[k]));
    let family =
        OffsetFamily::new(edges.map(|e| (e, e)), edges, [x.shift, y.shift, z.shift], kappa, tolerance);
    let alike = edges[1] == edges[2] && y.shift == z.shift && y.distances == z.distances;
    let pairs = distance_pairs(&y, &z, alike);
    // With three equal axes, sorted distances recur in other planes.
    let mut sorted = (alike && edges[0] == edges[1] && x.shift == y.shift).then(|| FirstPlaces::new(&x, &y));
    let mut offsets = Vec::with_capacity(x.distances.len() * pairs.len());
    let mut places = Vec::with_capacity(offsets.capacity());
    for &dx in &x.distances {
        for &[dy, dz] in &pairs {
            let offset = [dx, dy, dz];
            let new = offsets.len() as u32;
            let place = sorted.as_mut().map_or(new, |s| s.place(offset, new));
            if place == new {
                offsets.push(offset);
            }
            places.push(place);
        }
    }
    let (mut value, mut radius) = (vec![0.0; offsets.len()], vec![0.0; offsets.len()]);
    let method_counts = family.fill(&offsets, &mut value, &mut radius);
    let lines = line_positions(&y, &z, alike);
    let total = counts.iter().product();
    let (mut values, mut radii) = (Vec::with_capacity(total), Vec::with_capacity(total));
    for &ix in &x.of_cell {
        let plane = &places[ix as usize * pairs.len()..(ix as usize + 1) * pairs.len()];
        write_plane(&mut values, plane, &value, &lines, &y.of_cell);
        write_plane(&mut radii, plane, &radius, &lines, &y.of_cell);
    }
    VoxelBlock { values, radii, distinct: offsets.len(), method_counts }
}

/// The distinct distances across x, y ≥ z where the two axes are alike.
fn distance_pairs(y: &AxisDistances, z: &AxisDistances, alike: bool) -> Vec<[u16; 2]> {
    let last = |j: usize| if alike { j + 1 } else { z.distances.len() };
    let line = |(j, &dy): (usize, &u16)| z.distances[..last(j)].iter().map(move |&dz| [dy, dz]);
    y.distances.iter().enumerate().flat_map(line).collect()
}

/// The first place of each sorted triple of distances.
struct FirstPlaces(Vec<u32>);

impl FirstPlaces {
    fn new(x: &AxisDistances, y: &AxisDistances) -> FirstPlaces {
        let most = x.distances.last().max(y.distances.last()).map_or(0, |d| *d as usize);
        // A block far off along an axis has no triple twice.
        let size = if x.distances[0] > *y.distances.last().expect("a cell") { 0 } else { most + 1 };
        FirstPlaces(vec![u32::MAX; size * (size + 1) * (size + 2) / 6])
    }
    /// The place of an offset with y ≥ z: the one it has already, or `new`.
    #[inline]
    fn place(&mut self, [x, y, z]: [u16; 3], new: u32) -> u32 {
        if self.0.is_empty() {
            return new;
        }
        let (x, y, z) = (x as usize, y as usize, z as usize);
        let (a, rest) = (x.max(y), x.min(y));
        let (b, c) = (rest.max(z), rest.min(z));
        let kept = &mut self.0[a * (a + 1) * (a + 2) / 6 + b * (b + 1) / 2 + c];
        if *kept == u32::MAX {
            *kept = new;
        }
        *kept
    }
}

/// For each distinct distance along y the places of a line of cells in the plane's pairs.
fn line_positions(y: &AxisDistances, z: &AxisDistances, alike: bool) -> Vec<Vec<u32>> {
    let nz = z.distances.len() as u32;
    let pair = |j: u32, k: u32| {
        if alike { j.max(k) * (j.max(k) + 1) / 2 + j.min(k) } else { j * nz + k }
    };
    (0..y.distances.len() as u32).map(|j| z.of_cell.iter().map(|&k| pair(j, k)).collect()).collect()
}

/// One plane of the block: each distinct line is gathered once, then copied.
fn write_plane(out: &mut Vec<f64>, plane: &[u32], from: &[f64], lines: &[Vec<u32>], of_cell: &[u32]) {
    let start = out.len();
    let mut met = [u32::MAX; 64];
    for (line, &j) in of_cell.iter().enumerate() {
        let cells = &lines[j as usize];
        match met.get(j as usize) {
            Some(&l) if l != u32::MAX => {
                let first = start + l as usize * cells.len();
                out.extend_from_within(first..first + cells.len());
            }
            _ => out.extend(cells.iter().map(|&i| from[plane[i as usize] as usize])),
        }
        if let Some(l) = met.get_mut(j as usize) {
            *l = line as u32;
        }
    }
}
