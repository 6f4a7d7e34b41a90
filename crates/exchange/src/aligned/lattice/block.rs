//! One voxel against a block of voxels: the situation that the paper measures.
//!
//! Only the distinct offsets of the situation are computed, on this thread, with nothing kept beforehand (the constants of the Gauss
//! rules apart, which are the program's); then all factors are written out. Offsets may be half integers: the axis of a block with an even
//! number of voxels runs between them.

use super::fill::{Family, Tally};

/// The factors of one voxel with all voxels of a block, m⁴; the block's last axis runs fastest.
#[derive(Clone, Debug)]
pub struct Block {
    /// Values, m⁴.
    pub values: Vec<f64>,
    /// Proved radii, m⁴.
    pub radii: Vec<f64>,
    /// Distinct offsets that were computed.
    pub distinct: usize,
    /// Which methods served them.
    pub tally: Tally,
}

/// The distinct distances along one axis, and the one of each cell.
struct Axis {
    /// Distances in cells, less `shift`, ascending.
    distances: Vec<u16>,
    of_cell: Vec<u32>,
    shift: f64,
}

impl Axis {
    fn new(first: f64, count: usize) -> Axis {
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
        Axis { of_cell: (0..count).map(|i| (cell(i) - least) as u32).collect(), distances, shift }
    }
}

/// The factors of a voxel with `edges` (m) and a block of `counts` voxels like it; `first` is the offset from the voxel to the
/// block's first one in cells, whole or half numbers. Extinction `kappa` 1/m; radii at most `tolerance` · value.
///
/// ```
/// use zonal_exchange::aligned::lattice::block;
/// let b = block([1.0; 3], [3.0, -9.5, -9.5], [20, 20, 20], 0.0, 1e-6);
/// assert!(b.values.len() == 8000 && b.distinct < 1400);
/// ```
///
/// # Panics
/// On an edge or tolerance that is not positive and finite, a bad `kappa`, a count of zero, an offset that is no multiple of ½.
pub fn block(edges: [f64; 3], first: [f64; 3], counts: [usize; 3], kappa: f64, tolerance: f64) -> Block {
    assert!(counts.iter().all(|n| *n > 0), "counts {counts:?}");
    let [x, y, z] = [0, 1, 2].map(|k| Axis::new(first[k], counts[k]));
    let family = Family::new(edges.map(|e| (e, e)), edges, [x.shift, y.shift, z.shift], kappa, tolerance);
    let alike = edges[1] == edges[2] && y.shift == z.shift && y.distances == z.distances;
    let (ny, nz) = (y.distances.len(), z.distances.len());
    let per_plane = if alike { ny * (ny + 1) / 2 } else { ny * nz };
    let mut offsets = Vec::with_capacity(x.distances.len() * per_plane);
    for &dx in &x.distances {
        for (j, &dy) in y.distances.iter().enumerate() {
            let last = if alike { j + 1 } else { nz };
            offsets.extend(z.distances[..last].iter().map(|&dz| [dx, dy, dz]));
        }
    }
    let (mut value, mut radius) = (vec![0.0; offsets.len()], vec![0.0; offsets.len()]);
    let tally = family.fill(&offsets, &mut value, &mut radius);
    let place = place_in_plane(&y, &z, alike);
    let total = counts[0] * place.len();
    let (mut values, mut radii) = (Vec::with_capacity(total), Vec::with_capacity(total));
    for &ix in &x.of_cell {
        let plane = ix as usize * per_plane..(ix as usize + 1) * per_plane;
        let (v, r) = (&value[plane.clone()], &radius[plane]);
        values.extend(place.iter().map(|&i| v[i as usize]));
        radii.extend(place.iter().map(|&i| r[i as usize]));
    }
    Block { values, radii, distinct: offsets.len(), tally }
}

/// For each cell of a plane across x the place of its factor.
fn place_in_plane(y: &Axis, z: &Axis, alike: bool) -> Vec<u32> {
    let nz = z.distances.len() as u32;
    let pair = |j: u32, k: u32| match alike {
        true => j.max(k) * (j.max(k) + 1) / 2 + j.min(k),
        false => j * nz + k,
    };
    y.of_cell.iter().flat_map(|&j| z.of_cell.iter().map(move |&k| pair(j, k))).collect()
}
