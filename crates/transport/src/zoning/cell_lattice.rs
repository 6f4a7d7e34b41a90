//! The sample lattice of a cell: samples, the crossings of facets with the lines that join them, and the free stretches between.
//!
//! A lattice of 8 × 8 × 8 samples fills the cell, offset slightly so that no lattice plane coincides with a wall. Along each axis 64
//! lines join the samples; each line has nine gaps, below, between and above its samples. A **sliver** is a free stretch of a line
//! between two facets, or between a facet and the border of the cell, that holds no sample: beside a solid that fills nearly the
//! whole cell, or between two solids that nearly touch.
//!
//! **Volumes.** Along the main axis, the one that facets pierce most often, each sample stands for the stretch of its line that is
//! nearer to it than to its neighbours and not behind a facet; along the two other axes for the same, where only walls
//! perpendicular to the line count: lines along the main axis cannot meet these. The product of the three lengths is the volume of
//! the sample. So axis-aligned walls give exact volumes and centroids, and an oblique one is integrated exactly along the lines. A
//! sliver counts with its length times the line's share of the cross-section, h²/64: along the main axis all slivers, along others
//! those between perpendicular walls; where two slivers meet in a corner of the cell, one of them has the volume.

use crate::intersect::{PreparedLine, PreparedPlate};
use crate::transport::Transport;
use zonal_math::{Vec3, vec3};
use zonal_scene::VoxelGrid;
use zonal_scene::voxel_samples::SUBCELLS;

/// Samples along an edge of the cell.
pub(super) const SAMPLES_PER_EDGE: usize = 8;
/// Samples of the cell.
pub(super) const SAMPLE_COUNT: usize = SAMPLES_PER_EDGE * SAMPLES_PER_EDGE * SAMPLES_PER_EDGE;
/// Samples along an edge of a sub-cell.
pub(super) const SAMPLES_PER_SUBCELL_EDGE: usize = SAMPLES_PER_EDGE / SUBCELLS;
/// Gaps of a line: below, between and above its samples.
const GAPS_PER_LINE: usize = SAMPLES_PER_EDGE + 1;
/// Offset of the lattice along each axis, in units of the distance of two samples.
const LATTICE_OFFSET: [f64; 3] = [1.372_981e-4, -1.871_413e-4, 1.618_034e-4];
/// Slivers shorter than this fraction of the cell are ignored.
const MIN_SLIVER_SHARE: f64 = 1e-3;
/// Walls whose normal has at least this cosine with an axis are perpendicular to it: across a cell such a wall drifts by less than
/// half the distance of two samples.
const PERPENDICULAR_COSINE: f64 = 0.999;
/// Most crossings that a gap stores.
const MAX_CROSSINGS_PER_GAP: usize = 4;
/// Smallest length of a sample's stretch, in units of the distance of two samples, so that means weighted by volume exist.
const MIN_STRETCH: f64 = 1e-9;

/// The crossings of facets with a line in one gap: fractions of the line, ascending, and whether the facet is perpendicular to it.
#[derive(Clone, Copy)]
pub(super) struct GapCrossings {
    count: usize,
    at: [(f64, bool); MAX_CROSSINGS_PER_GAP],
}

impl GapCrossings {
    const NO_CROSSINGS: GapCrossings = GapCrossings { count: 0, at: [(0.0, false); MAX_CROSSINGS_PER_GAP] };

    /// Adds a crossing. When the gap is full, the outermost crossings are kept.
    fn add(&mut self, t: f64, perpendicular: bool) {
        let k = self.at[..self.count].iter().filter(|x| x.0 <= t).count();
        if self.count < MAX_CROSSINGS_PER_GAP {
            self.at.copy_within(k..self.count, k + 1);
            self.count += 1;
            self.at[k] = (t, perpendicular);
        } else if k == 0 {
            self.at[0] = (t, perpendicular);
        } else if k == MAX_CROSSINGS_PER_GAP {
            self.at[MAX_CROSSINGS_PER_GAP - 1] = (t, perpendicular);
        }
    }
    fn list(&self) -> &[(f64, bool)] {
        &self.at[..self.count]
    }
    /// True when a facet pierces the gap.
    pub(super) fn any(&self) -> bool {
        self.count > 0
    }
}

/// The crossings of all lines, by axis, line and gap.
pub(super) struct LineCrossings(Vec<GapCrossings>);

impl LineCrossings {
    pub(super) fn new() -> LineCrossings {
        let gaps = 3 * SAMPLES_PER_EDGE * SAMPLES_PER_EDGE * GAPS_PER_LINE;
        LineCrossings(vec![GapCrossings::NO_CROSSINGS; gaps])
    }
    fn clear(&mut self) {
        self.0.fill(GapCrossings::NO_CROSSINGS);
    }
    /// The gap below sample `c` along the axis.
    pub(super) fn below(&self, axis: usize, c: [usize; 3]) -> &GapCrossings {
        &self.0[gap_index(axis, c[(axis + 1) % 3], c[(axis + 2) % 3], c[axis])]
    }
    /// The gap above sample `c` along the axis.
    fn above(&self, axis: usize, c: [usize; 3]) -> &GapCrossings {
        &self.0[gap_index(axis, c[(axis + 1) % 3], c[(axis + 2) % 3], c[axis] + 1)]
    }
    /// The fraction of the line between an outermost sample and the border of the cell that a perpendicular wall cuts off.
    fn sliver_at_border(&self, axis: usize, sample: [usize; 3]) -> f64 {
        match sample[axis] {
            0 => self.below(axis, sample).list().first().filter(|p| p.1).map_or(0.0, |p| p.0),
            c if c + 1 == SAMPLES_PER_EDGE => {
                self.above(axis, sample).list().last().filter(|p| p.1).map_or(0.0, |p| 1.0 - p.0)
            }
            _ => 0.0,
        }
    }
    /// Number of pierced gaps along an axis.
    fn pierced_count(&self, axis: usize) -> usize {
        let n = SAMPLES_PER_EDGE * SAMPLES_PER_EDGE * GAPS_PER_LINE;
        self.0[axis * n..(axis + 1) * n].iter().filter(|g| g.any()).count()
    }
}

/// Index of a gap among all, for the line (i, j) along an axis.
fn gap_index(axis: usize, i: usize, j: usize, gap: usize) -> usize {
    ((axis * SAMPLES_PER_EDGE + i) * SAMPLES_PER_EDGE + j) * GAPS_PER_LINE + gap
}

/// A free stretch of a line that holds no sample.
struct Sliver {
    axis: usize,
    /// The line: indices of its samples along the two other axes, in cyclic order.
    line: [usize; 2],
    gap: usize,
    middle: Vec3,
    /// Volume of the sliver, m³.
    volume: f64,
}

impl Sliver {
    /// Index of its gap among all; slivers are sorted by it.
    fn gap_index(&self) -> usize {
        gap_index(self.axis, self.line[0], self.line[1], self.gap)
    }
}

/// Coordinates of a sample in the lattice.
pub(super) fn sample_coordinates(sample: usize) -> [usize; 3] {
    [
        sample / (SAMPLES_PER_EDGE * SAMPLES_PER_EDGE),
        sample / SAMPLES_PER_EDGE % SAMPLES_PER_EDGE,
        sample % SAMPLES_PER_EDGE,
    ]
}

/// Position of the i-th sample along an axis, as a fraction of the cell.
fn lattice_position(axis: usize, i: usize) -> f64 {
    (i as f64 + 0.5 + LATTICE_OFFSET[axis]) / SAMPLES_PER_EDGE as f64
}

/// The root of a node in a union–find forest, with path halving.
pub(super) fn find_root(parent: &mut [u16], mut i: usize) -> usize {
    while parent[i] as usize != i {
        parent[i] = parent[parent[i] as usize];
        i = parent[i] as usize;
    }
    i
}

/// A cell, the facets that intersect it, and its lattice. Its nodes are the samples, then the slivers.
pub(super) struct CellLattice<'a> {
    pub lo: Vec3,
    pub h: Vec3,
    facets: Vec<PreparedPlate>,
    transport: &'a Transport<'a>,
    slivers: Vec<Sliver>,
    /// The axis along which volumes are taken.
    main_axis: usize,
}

impl CellLattice<'_> {
    /// The lattice of cell `c` with its slivers; fills `crossings`.
    pub(super) fn new<'a>(
        transport: &'a Transport<'a>,
        grid: &VoxelGrid,
        c: [usize; 3],
        facets: &[u32],
        crossings: &mut LineCrossings,
    ) -> CellLattice<'a> {
        let all = transport.scene().facets();
        let mut lattice = CellLattice {
            lo: grid.corner(c),
            h: grid.cell(),
            facets: facets.iter().map(|f| PreparedPlate::new(&all[*f as usize].plate)).collect(),
            transport,
            slivers: Vec::new(),
            main_axis: 0,
        };
        lattice.find_crossings(crossings);
        let pierced = |k: usize| crossings.pierced_count(k);
        lattice.main_axis = (0..3).fold(0, |b, k| if pierced(k) > pierced(b) { k } else { b });
        lattice.find_slivers(crossings);
        lattice
    }

    /// Number of samples and slivers.
    pub(super) fn node_count(&self) -> usize {
        SAMPLE_COUNT + self.slivers.len()
    }

    /// The position of a node.
    pub(super) fn point(&self, node: usize) -> Vec3 {
        if let Some(sliver) = node.checked_sub(SAMPLE_COUNT) {
            return self.slivers[sliver].middle;
        }
        let c = sample_coordinates(node);
        let position = vec3(lattice_position(0, c[0]), lattice_position(1, c[1]), lattice_position(2, c[2]));
        self.lo + self.h.scale(position)
    }

    /// True when no facet of the cell crosses the segment a–b.
    pub(super) fn visible(&self, a: Vec3, b: Vec3) -> bool {
        let line = PreparedLine::new(a, b - a, self.transport.tolerance());
        !self.facets.iter().any(|f| f.crosses(&line))
    }

    /// Records the crossings of the facets with the lines.
    fn find_crossings(&self, crossings: &mut LineCrossings) {
        crossings.clear();
        for f in &self.facets {
            let (c, n) = f.corners();
            let (lo, hi) = c[..n].iter().fold((c[0], c[0]), |(lo, hi), x| (lo.min(*x), hi.max(*x)));
            let normal = (c[1] - c[0]).cross(c[2] - c[0]).normalized();
            // Indices of the lines that pass the facet's box.
            let range = |k: usize| {
                let index =
                    |x: f64| (x - self.lo[k]) / self.h[k] * SAMPLES_PER_EDGE as f64 - 0.5 - LATTICE_OFFSET[k];
                let first = (index(lo[k]) - 1e-6).ceil().max(0.0) as usize;
                let end = ((index(hi[k]) + 1e-6).floor() + 1.0).clamp(0.0, SAMPLES_PER_EDGE as f64) as usize;
                first..end
            };
            for axis in 0..3 {
                let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
                let mut along = [0.0; 3];
                along[axis] = self.h[axis];
                for i in range(p) {
                    for j in range(q) {
                        let mut at = [0.0; 3];
                        (at[p], at[q]) =
                            (lattice_position(p, i) * self.h[p], lattice_position(q, j) * self.h[q]);
                        let a = self.lo + Vec3::from_array(at);
                        let line = PreparedLine::new(a, Vec3::from_array(along), self.transport.tolerance());
                        let Some(t) = f.pierce(&line).filter(|t| *t > 0.0 && *t < 1.0) else {
                            continue;
                        };
                        let above = (t * SAMPLES_PER_EDGE as f64 - 0.5 - LATTICE_OFFSET[axis]).floor() + 1.0;
                        let gap = above.clamp(0.0, SAMPLES_PER_EDGE as f64) as usize;
                        crossings.0[gap_index(axis, i, j, gap)]
                            .add(t, normal[axis].abs() >= PERPENDICULAR_COSINE);
                    }
                }
            }
        }
    }

    /// Lists the slivers that have a volume.
    fn find_slivers(&mut self, crossings: &LineCrossings) {
        let n = SAMPLES_PER_EDGE;
        let share_of_line = self.h.product() / (n * n) as f64;
        for (k, g) in crossings.0.iter().enumerate().filter(|(_, g)| g.any()) {
            let line_index = k / GAPS_PER_LINE;
            let (axis, i, j, gap) =
                (line_index / n / n, line_index / n % n, line_index % n, k % GAPS_PER_LINE);
            // The border of the cell counts as a perpendicular wall.
            let below = (gap == 0).then_some((0.0, true));
            let above = (gap == n).then_some((1.0, true));
            let ends: Vec<(f64, bool)> =
                below.into_iter().chain(g.list().iter().copied()).chain(above).collect();
            for w in ends.windows(2).filter(|w| w[1].0 - w[0].0 >= MIN_SLIVER_SHARE) {
                if axis != self.main_axis && !(w[0].1 && w[1].1) {
                    continue;
                }
                let mut at = [0.0; 3];
                let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
                (at[axis], at[p], at[q]) =
                    (0.5 * (w[0].0 + w[1].0), lattice_position(p, i), lattice_position(q, j));
                // In a corner of the cell slivers along smaller axes have the volume.
                let mut beside = [gap.min(n - 1); 3];
                (beside[p], beside[q]) = (i, j);
                let own: f64 =
                    (0..axis).map(|k| 1.0 - n as f64 * crossings.sliver_at_border(k, beside)).product();
                self.slivers.push(Sliver {
                    axis,
                    line: [i, j],
                    gap,
                    middle: self.lo + self.h.scale(Vec3::from_array(at)),
                    volume: (w[1].0 - w[0].0) * share_of_line * own,
                });
            }
        }
    }

    /// Links each sliver to the nodes of neighbouring lines that it sees: slivers in the same gap, the samples at the gap's ends, and
    /// slivers around a corner of the cell.
    pub(super) fn link_slivers(&self, parent: &mut [u16]) {
        let mut link = |a: usize, b: usize, by: Option<Vec3>| {
            let (ra, rb) = (find_root(parent, a), find_root(parent, b));
            let by = by.unwrap_or(self.point(b));
            if ra != rb && self.visible(self.point(a), by) && self.visible(by, self.point(b)) {
                parent[ra.max(rb)] = ra.min(rb) as u16;
            }
        };
        for (n, s) in self.slivers.iter().enumerate() {
            // Slivers in the same gap of the next lines.
            let next_lines =
                [(0, s.gap_index() + SAMPLES_PER_EDGE * GAPS_PER_LINE), (1, s.gap_index() + GAPS_PER_LINE)];
            for (k, beside) in next_lines {
                if s.line[k] + 1 < SAMPLES_PER_EDGE {
                    self.slivers_in(beside).for_each(|m| link(SAMPLE_COUNT + n, SAMPLE_COUNT + m, None));
                }
            }
            // Samples at the ends of the gap on the four neighbouring lines.
            let (p, q) = ((s.axis + 1) % 3, (s.axis + 2) % 3);
            let sample = |along: usize, line: [usize; 2]| {
                let mut c = [along; 3];
                (c[p], c[q]) = (line[0], line[1]);
                c
            };
            for (k, up) in [(0, false), (0, true), (1, false), (1, true)] {
                let mut line = s.line;
                line[k] = if up { line[k] + 1 } else { line[k].wrapping_sub(1) };
                if line[k] >= SAMPLES_PER_EDGE {
                    continue;
                }
                for along in [s.gap.wrapping_sub(1), s.gap].into_iter().filter(|a| *a < SAMPLES_PER_EDGE) {
                    let c = sample(along, line);
                    let node = (c[0] * SAMPLES_PER_EDGE + c[1]) * SAMPLES_PER_EDGE + c[2];
                    link(SAMPLE_COUNT + n, node, None);
                }
            }
            // Slivers of other axes around a corner of the cell, by way of the corner.
            if s.gap == 0 || s.gap == SAMPLES_PER_EDGE {
                let c = sample(s.gap.min(SAMPLES_PER_EDGE - 1), s.line);
                for axis in (0..s.axis).filter(|a| c[*a] == 0 || c[*a] + 1 == SAMPLES_PER_EDGE) {
                    let gap = if c[axis] == 0 { 0 } else { SAMPLES_PER_EDGE };
                    for m in self.slivers_in(gap_index(axis, c[(axis + 1) % 3], c[(axis + 2) % 3], gap)) {
                        let mut corner = s.middle.array();
                        corner[axis] = self.slivers[m].middle[axis];
                        link(SAMPLE_COUNT + n, SAMPLE_COUNT + m, Some(Vec3::from_array(corner)));
                    }
                }
            }
        }
    }

    /// The slivers in a gap.
    fn slivers_in(&self, gap_index: usize) -> std::ops::Range<usize> {
        let first = self.slivers.partition_point(|t| t.gap_index() < gap_index);
        first..first + self.slivers[first..].partition_point(|t| t.gap_index() == gap_index)
    }

    /// The volume of a node, m³, and its centre.
    pub(super) fn node_volume(&self, crossings: &LineCrossings, node: usize) -> (f64, Vec3) {
        match node.checked_sub(SAMPLE_COUNT) {
            Some(sliver) => (self.slivers[sliver].volume, self.slivers[sliver].middle),
            None => self.sample_volume(crossings, node),
        }
    }

    /// The free volume of a sample, m³, and its centre: between walls along the main axis, between perpendicular ones along the others.
    fn sample_volume(&self, crossings: &LineCrossings, sample: usize) -> (f64, Vec3) {
        let c = sample_coordinates(sample);
        let n = SAMPLES_PER_EDGE as f64;
        let (mut volume, mut middle) = (self.h.product(), [0.0; 3]);
        for axis in 0..3 {
            let counts = |p: &&(f64, bool)| axis == self.main_axis || p.1;
            let below = crossings.below(axis, c).list().iter().rfind(counts);
            let above = crossings.above(axis, c).list().iter().find(counts);
            let from = below.map_or(c[axis] as f64 / n, |p| p.0);
            let to = above.map_or((c[axis] + 1) as f64 / n, |p| p.0);
            middle[axis] = self.lo[axis] + 0.5 * (from + to) * self.h[axis];
            volume *= (to - from).max(MIN_STRETCH / n);
        }
        (volume, Vec3::from_array(middle))
    }

    /// The sub-cell that holds a node.
    pub(super) fn subcell_of(&self, node: usize) -> usize {
        let index = |c: [usize; 3]| (c[0] * SUBCELLS + c[1]) * SUBCELLS + c[2];
        if node < SAMPLE_COUNT {
            return index(sample_coordinates(node).map(|i| i / SAMPLES_PER_SUBCELL_EDGE));
        }
        let x = self.point(node) - self.lo;
        index([0, 1, 2].map(|k| ((x[k] / self.h[k] * SUBCELLS as f64) as usize).min(SUBCELLS - 1)))
    }

    /// The node nearest to `x`.
    pub(super) fn nearest_node(&self, nodes: &[usize], x: Vec3) -> Vec3 {
        let mut best = (f64::INFINITY, x);
        for p in nodes.iter().map(|s| self.point(*s)) {
            let d = (p - x).length2();
            best = if d < best.0 { (d, p) } else { best };
        }
        best.1
    }
}
