//! The free parts of a cell that facets intersect.
//!
//! The nodes of the cell's lattice (`cell_lattice`) are linked along its lines where no facet pierces them. The connected components
//! are the parts that walls separate. Parts without medium, inside a solid or outside of everything, are dropped. The others are
//! merged where some sample of one sees a sample of the other.

use super::cell_lattice::{
    CellLattice, LineCrossings, SAMPLE_COUNT, SAMPLES_PER_EDGE, SAMPLES_PER_SUBCELL_EDGE, find_root,
    sample_coordinates,
};
use crate::transport::Transport;
use zonal_math::Vec3;
use zonal_scene::voxel_samples::{SUBCELLS, packed_point};
use zonal_scene::{VolumeSample, VoxelGrid, VoxelSamples};

/// Fewest nodes of a part.
const MIN_PART_NODES: usize = 2;
/// Nodes of each of two parts that are tested for seeing each other.
const VISIBILITY_TESTS_PER_PART: usize = 6;
/// In a cell of more parts than this only pairs with a large part are tested for merging.
const MAX_PARTS_TESTED_IN_FULL: usize = 16;
/// Nodes of a large part.
const LARGE_PART_NODES: usize = 32;

/// A free part of a cell.
pub(super) struct CellPart {
    pub samples: VoxelSamples,
    pub centre: Vec3,
    pub volume: f64,
}

/// The result for a cell that facets intersect.
pub(super) enum ResolvedCell {
    /// No facet separates or covers a relevant part.
    Whole,
    /// The free parts, possibly none.
    Parts(Vec<CellPart>),
}

/// The connected components of the nodes.
fn components(lattice: &CellLattice, crossings: &LineCrossings) -> Vec<Vec<usize>> {
    let nodes = lattice.node_count();
    let mut parent: Vec<u16> = (0..nodes as u16).collect();
    let stride = [SAMPLES_PER_EDGE * SAMPLES_PER_EDGE, SAMPLES_PER_EDGE, 1];
    for s in 0..SAMPLE_COUNT {
        let c = sample_coordinates(s);
        for axis in 0..3 {
            if c[axis] > 0 && !crossings.below(axis, c).any() {
                let (a, b) = (find_root(&mut parent, s), find_root(&mut parent, s - stride[axis]));
                parent[a.max(b)] = a.min(b) as u16;
            }
        }
    }
    lattice.link_slivers(&mut parent);
    group_by_label(nodes, |s| find_root(&mut parent, s))
}

/// Groups 0..n by label, in the order in which the labels appear.
fn group_by_label(n: usize, mut label: impl FnMut(usize) -> usize) -> Vec<Vec<usize>> {
    let mut group_of = vec![usize::MAX; n];
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for s in 0..n {
        let l = label(s);
        if group_of[l] == usize::MAX {
            group_of[l] = groups.len();
            groups.push(Vec::with_capacity(if groups.is_empty() { n } else { 0 }));
        }
        groups[group_of[l]].push(s);
    }
    groups
}

/// Merges parts of which some nodes see each other.
fn merge_visible_parts(lattice: &CellLattice, parts: Vec<Vec<usize>>) -> Vec<Vec<usize>> {
    if parts.len() < 2 {
        return parts;
    }
    let mut parent: Vec<u16> = (0..parts.len() as u16).collect();
    let picks: Vec<Vec<Vec3>> = parts
        .iter()
        .map(|p| {
            let n = p.len().min(VISIBILITY_TESTS_PER_PART);
            (0..n).map(|i| lattice.point(p[(2 * i + 1) * p.len() / (2 * n)])).collect()
        })
        .collect();
    for i in 0..parts.len() {
        for j in 0..i {
            if parts.len() > MAX_PARTS_TESTED_IN_FULL && parts[j].len().max(parts[i].len()) < LARGE_PART_NODES
            {
                continue;
            }
            let (a, b) = (find_root(&mut parent, i), find_root(&mut parent, j));
            if a != b && picks[i].iter().any(|x| picks[j].iter().any(|y| lattice.visible(*x, *y))) {
                parent[a.max(b)] = a.min(b) as u16;
            }
        }
    }
    let groups = group_by_label(parts.len(), |i| find_root(&mut parent, i));
    let merged = groups.into_iter().map(|l| {
        let mut all: Vec<usize> = l.into_iter().flat_map(|i| parts[i].iter().copied()).collect();
        all.sort_unstable();
        all
    });
    merged.collect()
}

/// Resolves cell `c`, which these facets intersect, into its free parts; `crossings` is scratch.
pub(super) fn resolve_cell(
    transport: &Transport,
    grid: &VoxelGrid,
    c: [usize; 3],
    facets: &[u32],
    crossings: &mut LineCrossings,
) -> ResolvedCell {
    let lattice = CellLattice::new(transport, grid, c, facets, crossings);
    let mut parts = components(&lattice, crossings);
    if transport.may_lack_medium() {
        parts.retain(|p| transport.has_medium_at(lattice.point(p[p.len() / 2])));
    }
    let mut parts = merge_visible_parts(&lattice, parts);
    parts.retain(|p| p.len() >= MIN_PART_NODES);
    let parts: Vec<CellPart> = parts.iter().map(|p| cell_part(&lattice, crossings, p)).collect();
    // One part that lacks less than one sample is the whole cell.
    let whole = lattice.h.product();
    let is_whole = parts.len() == 1 && parts[0].volume >= whole * (1.0 - 1.0 / SAMPLE_COUNT as f64);
    if is_whole { ResolvedCell::Whole } else { ResolvedCell::Parts(parts) }
}

/// The share of a sub-cell in a part.
struct SubcellShare<'a> {
    nodes: &'a [usize],
    volume: f64,
    /// ∫ x dV, m⁴.
    moment: Vec3,
}

/// The part of these nodes, with one sample per sub-cell.
fn cell_part(lattice: &CellLattice, crossings: &LineCrossings, nodes: &[usize]) -> CellPart {
    const COUNT: usize = SUBCELLS * SUBCELLS * SUBCELLS;
    // Order the nodes by sub-cell.
    let subcells: Vec<u8> = nodes.iter().map(|n| lattice.subcell_of(*n) as u8).collect();
    let mut starts = [0; COUNT + 1];
    subcells.iter().for_each(|k| starts[usize::from(*k) + 1] += 1);
    (0..COUNT).for_each(|k| starts[k + 1] += starts[k]);
    let (mut next, mut ordered) = (starts, vec![0; nodes.len()]);
    for (node, k) in nodes.iter().zip(&subcells) {
        let place = &mut next[usize::from(*k)];
        ordered[*place] = *node;
        *place += 1;
    }
    let (mut volume, mut moment) = (0.0, Vec3::ZERO);
    let mut samples = Vec::with_capacity(COUNT.min(nodes.len()));
    for k in (0..COUNT).filter(|k| starts[*k] < starts[k + 1]) {
        let mut share =
            SubcellShare { nodes: &ordered[starts[k]..starts[k + 1]], volume: 0.0, moment: Vec3::ZERO };
        for node in share.nodes {
            let (w, middle) = lattice.node_volume(crossings, *node);
            share.volume += w;
            share.moment += middle * w;
        }
        volume += share.volume;
        moment += share.moment;
        let point = sample_point(lattice, crossings, k, &share);
        samples.push(VolumeSample { point, volume: share.volume, subcell: k as u8 });
    }
    let centre = lattice.nearest_node(nodes, moment / volume);
    CellPart { samples: VoxelSamples::new(lattice.lo, lattice.h, volume, &samples), centre, volume }
}

/// The position of the sample of a sub-cell: the centroid of its share, or the nearest node when the centroid does not see it;
/// rounded to the packed representation.
fn sample_point(
    lattice: &CellLattice,
    crossings: &LineCrossings,
    subcell: usize,
    share: &SubcellShare,
) -> Vec3 {
    let packed = |x: Vec3| packed_point(lattice.lo, lattice.h, subcell as u8, x);
    let centroid = packed(share.moment / share.volume);
    let is_full = share.nodes.len() == SAMPLES_PER_SUBCELL_EDGE.pow(3);
    if is_full && share.nodes.iter().all(|s| is_unobstructed(crossings, *s)) {
        return centroid;
    }
    let near = lattice.nearest_node(share.nodes, centroid);
    // A facet through the centroid does not separate it, so test a point slightly beyond.
    let past_centroid = near + (centroid - near) * 1.001;
    if lattice.visible(near, past_centroid) { centroid } else { packed(near) }
}

/// True for a sample whose lines to the other samples of its sub-cell are not pierced.
fn is_unobstructed(crossings: &LineCrossings, node: usize) -> bool {
    let c = sample_coordinates(node.min(SAMPLE_COUNT - 1));
    let free =
        |axis: usize| c[axis].is_multiple_of(SAMPLES_PER_SUBCELL_EDGE) || !crossings.below(axis, c).any();
    node < SAMPLE_COUNT && (0..3).all(free)
}
