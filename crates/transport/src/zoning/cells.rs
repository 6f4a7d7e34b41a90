//! A cell that facets pass through, resolved into its free parts.
//!
//! An 8 × 8 × 8 lattice of fine samples fills the cell, moved by a hair so that no lattice plane is a wall. Along each axis 64 lines
//! join them; where a facet pierces a line between two samples, these two are not linked. The connected components are the parts
//! that walls separate. Those without a medium, inside a solid or outside of everything, are dropped; the others are linked once more where some sample of one sees one of the
//! other.
//!
//! Free space may lie between two samples, or between a sample and the border of the cell, and hold none: beside a solid that fills nearly
//! all of the cell, or between two solids that nearly touch. Such stretches of the lines are nodes of their own, linked to
//! the stretches and samples beside them that they see.
//!
//! **Volumes.** Along the axis that facets pierce most often each sample stands for the stretch of its line that is nearer to it
//! than to its neighbours and not behind a facet; along the two others, where only walls square to them count, the same: lines along the first
//! one cannot meet these. The product of the three lengths is the sample's volume. So walls square to the axes give exact volumes and
//! centroids, and an oblique one is integrated exactly along the lines. Stretches without a sample count with their
//! length times the line's share of the cross-section, h²/64: all on lines along the first axis, on others those between walls that are square to them;
//! where two of them meet in a corner of the cell, one has it.

use crate::Transport;
use crate::meet::{Line, Prepared};
use zonal_math::{Vec3, vec3};
use zonal_scene::part::{SUBCELLS, packed_point};
use zonal_scene::{Sample, Voxmap};

const FINE: usize = 8;
const COUNT: usize = FINE * FINE * FINE;
const GAPS: usize = FINE + 1;
const HAIR: [f64; 3] = [1.372_981e-4, -1.871_413e-4, 1.618_034e-4];
/// Free stretches of a line that are thinner than this share of the cell are left out.
const THINNEST: f64 = 1e-3;
/// Walls whose normal has this cosine or more with an axis are square to it: across a cell such a wall drifts by less than half the distance of
/// two samples.
const SQUARE: f64 = 0.999;
/// Where facets pierce a line between two samples, so many places are kept.
const PLACES: usize = 4;
/// A part needs this many samples.
const LEAST: usize = 2;
/// Samples of each of two parts that try to see each other.
const LOOKS: usize = 6;

/// A free part of a cell.
pub(super) struct Part {
    pub samples: zonal_scene::Part,
    pub centre: Vec3,
    pub volume: f64,
}

/// What a cut cell turns out to be.
pub(super) enum Resolved {
    /// Nothing separates or covers anything worth counting.
    Whole,
    /// The free parts, possibly none.
    Parts(Vec<Part>),
}

/// Where facets pierce a line between two samples: shares of the line, ascending, and whether the facet is square to it.
#[derive(Clone, Copy)]
struct Pierced {
    n: usize,
    at: [(f64, bool); PLACES],
}

impl Pierced {
    const NONE: Pierced = Pierced { n: 0, at: [(0.0, false); PLACES] };

    /// Keeps a place; of more than PLACES the ones in the middle are lost.
    fn add(&mut self, t: f64, square: bool) {
        let k = self.at[..self.n].iter().filter(|x| x.0 <= t).count();
        if self.n < PLACES {
            self.at.copy_within(k..self.n, k + 1);
            self.n += 1;
            self.at[k] = (t, square);
        } else if k == 0 {
            self.at[0] = (t, square);
        } else if k == PLACES {
            self.at[PLACES - 1] = (t, square);
        }
    }
    fn places(&self) -> &[(f64, bool)] {
        &self.at[..self.n]
    }
}

/// Where facets pierce the lines, by axis, line and gap between samples.
pub(super) struct Gaps(Vec<Pierced>);

impl Gaps {
    pub(super) fn new() -> Gaps {
        Gaps(vec![Pierced::NONE; 3 * FINE * FINE * GAPS])
    }
    fn clear(&mut self) {
        self.0.fill(Pierced::NONE);
    }
    /// The gap below sample c along the axis; `up` for the one above.
    fn at(&self, axis: usize, c: [usize; 3], up: usize) -> &Pierced {
        &self.0[slot(axis, c[(axis + 1) % 3], c[(axis + 2) % 3], c[axis] + up)]
    }
    /// The share of the line between the sample, where it is the first or the last, and the border of the cell that a wall square to the line cuts off.
    fn sliver_at_border(&self, axis: usize, sample: [usize; 3]) -> f64 {
        match sample[axis] {
            0 => self.at(axis, sample, 0).places().first().filter(|p| p.1).map_or(0.0, |p| p.0),
            c if c + 1 == FINE => {
                self.at(axis, sample, 1).places().last().filter(|p| p.1).map_or(0.0, |p| 1.0 - p.0)
            }
            _ => 0.0,
        }
    }
    fn pierced(&self, axis: usize) -> usize {
        let n = FINE * FINE * GAPS;
        self.0[axis * n..(axis + 1) * n].iter().filter(|g| g.n > 0).count()
    }
}

fn slot(axis: usize, i: usize, j: usize, gap: usize) -> usize {
    ((axis * FINE + i) * FINE + j) * GAPS + gap
}

struct Cell<'a> {
    lo: Vec3,
    h: Vec3,
    facets: Vec<Prepared>,
    transport: &'a Transport<'a>,
    slivers: Vec<Sliver>,
}

/// A free stretch of a line that holds no sample.
struct Sliver {
    axis: usize,
    /// The line: numbers of its samples along the two other axes, in cyclic order.
    line: [usize; 2],
    gap: usize,
    middle: Vec3,
    /// The volume that it stands for, m³.
    volume: f64,
}

impl Sliver {
    /// Where its gap stands among all; slivers are listed by it.
    fn slot(&self) -> usize {
        slot(self.axis, self.line[0], self.line[1], self.gap)
    }
}

fn coordinates(sample: usize) -> [usize; 3] {
    [sample / (FINE * FINE), sample / FINE % FINE, sample % FINE]
}

/// Position of the i-th sample along an axis as a share of the cell.
fn share(axis: usize, i: usize) -> f64 {
    (i as f64 + 0.5 + HAIR[axis]) / FINE as f64
}

impl Cell<'_> {
    /// The position of a node: a fine sample, or behind these a sliver.
    fn point(&self, node: usize) -> Vec3 {
        if let Some(sliver) = node.checked_sub(COUNT) {
            return self.slivers[sliver].middle;
        }
        let c = coordinates(node);
        self.lo + self.h.scale(vec3(share(0, c[0]), share(1, c[1]), share(2, c[2])))
    }

    fn sees(&self, a: Vec3, b: Vec3) -> bool {
        let line = Line::new(a, b - a, self.transport.tolerance());
        !self.facets.iter().any(|f| f.crosses(&line))
    }

    /// Records where the facets pierce the lines.
    fn pierce(&self, gaps: &mut Gaps) {
        gaps.clear();
        for f in &self.facets {
            let (c, n) = f.corners();
            let (lo, hi) = c[..n].iter().fold((c[0], c[0]), |(lo, hi), x| (lo.min(*x), hi.max(*x)));
            let normal = (c[1] - c[0]).cross(c[2] - c[0]).normalized();
            // Lines that pass the facet's box.
            let range = |k: usize| {
                let index = |x: f64| (x - self.lo[k]) / self.h[k] * FINE as f64 - 0.5 - HAIR[k];
                let first = (index(lo[k]) - 1e-6).ceil().max(0.0) as usize;
                let end = ((index(hi[k]) + 1e-6).floor() + 1.0).clamp(0.0, FINE as f64) as usize;
                first..end
            };
            for axis in 0..3 {
                let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
                let mut along = [0.0; 3];
                along[axis] = self.h[axis];
                for i in range(p) {
                    for j in range(q) {
                        let mut at = [0.0; 3];
                        (at[p], at[q]) = (share(p, i) * self.h[p], share(q, j) * self.h[q]);
                        let a = self.lo + Vec3::from_array(at);
                        let line = Line::new(a, Vec3::from_array(along), self.transport.tolerance());
                        let Some(t) = f.pierced(&line).filter(|t| *t > 0.0 && *t < 1.0) else {
                            continue;
                        };
                        let above = (t * FINE as f64 - 0.5 - HAIR[axis]).floor() + 1.0;
                        gaps.0[slot(axis, i, j, above.clamp(0.0, FINE as f64) as usize)]
                            .add(t, normal[axis].abs() >= SQUARE);
                    }
                }
            }
        }
    }

    /// The stretches that hold no sample, where the volumes are taken along `main`.
    fn find_slivers(&mut self, gaps: &Gaps, main: usize) {
        let share_of_line = self.h.product() / (FINE * FINE) as f64;
        for (k, g) in gaps.0.iter().enumerate().filter(|(_, g)| g.n > 0) {
            let (axis, i, j, gap) =
                (k / GAPS / FINE / FINE, k / GAPS / FINE % FINE, k / GAPS % FINE, k % GAPS);
            // The border of the cell is square to the line.
            let below = (gap == 0).then_some((0.0, true));
            let above = (gap == FINE).then_some((1.0, true));
            let ends: Vec<(f64, bool)> =
                below.into_iter().chain(g.places().iter().copied()).chain(above).collect();
            for w in ends.windows(2).filter(|w| w[1].0 - w[0].0 >= THINNEST) {
                if axis != main && !(w[0].1 && w[1].1) {
                    continue;
                }
                let mut at = [0.0; 3];
                let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
                (at[axis], at[p], at[q]) = (0.5 * (w[0].0 + w[1].0), share(p, i), share(q, j));
                let mut beside = [gap.min(FINE - 1); 3];
                (beside[p], beside[q]) = (i, j);
                let own: f64 =
                    (0..axis).map(|k| 1.0 - FINE as f64 * gaps.sliver_at_border(k, beside)).product();
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

    /// Links slivers to what they see of the lines beside them: slivers in the same gap, the samples at its ends, slivers around a corner
    /// of the cell.
    fn link_slivers(&self, parent: &mut [u16]) {
        let mut link = |a: usize, b: usize, by: Option<Vec3>| {
            let (ra, rb) = (root(parent, a), root(parent, b));
            let by = by.unwrap_or(self.point(b));
            if ra != rb && self.sees(self.point(a), by) && self.sees(by, self.point(b)) {
                parent[ra.max(rb)] = ra.min(rb) as u16;
            }
        };
        for (n, s) in self.slivers.iter().enumerate() {
            for (k, beside) in [(0, s.slot() + FINE * GAPS), (1, s.slot() + GAPS)] {
                if s.line[k] + 1 < FINE {
                    self.slivers_at(beside).for_each(|m| link(COUNT + n, COUNT + m, None));
                }
            }
            let (p, q) = ((s.axis + 1) % 3, (s.axis + 2) % 3);
            let sample = |along: usize, line: [usize; 2]| {
                let mut c = [along; 3];
                (c[p], c[q]) = (line[0], line[1]);
                c
            };
            for (k, up) in [(0, false), (0, true), (1, false), (1, true)] {
                let mut line = s.line;
                line[k] = if up { line[k] + 1 } else { line[k].wrapping_sub(1) };
                if line[k] >= FINE {
                    continue;
                }
                for along in [s.gap.wrapping_sub(1), s.gap].into_iter().filter(|a| *a < FINE) {
                    let c = sample(along, line);
                    link(COUNT + n, (c[0] * FINE + c[1]) * FINE + c[2], None);
                }
            }
            if s.gap == 0 || s.gap == FINE {
                let c = sample(s.gap.min(FINE - 1), s.line);
                for axis in (0..s.axis).filter(|a| c[*a] == 0 || c[*a] + 1 == FINE) {
                    let gap = if c[axis] == 0 { 0 } else { FINE };
                    for m in self.slivers_at(slot(axis, c[(axis + 1) % 3], c[(axis + 2) % 3], gap)) {
                        let mut corner = s.middle.array();
                        corner[axis] = self.slivers[m].middle[axis];
                        link(COUNT + n, COUNT + m, Some(Vec3::from_array(corner)));
                    }
                }
            }
        }
    }

    /// The slivers of a gap.
    fn slivers_at(&self, slot: usize) -> std::ops::Range<usize> {
        let first = self.slivers.partition_point(|t| t.slot() < slot);
        first..first + self.slivers[first..].partition_point(|t| t.slot() == slot)
    }

    /// The volume that a node stands for, and its middle.
    fn held(&self, gaps: &Gaps, axis: usize, node: usize) -> (f64, Vec3) {
        match node.checked_sub(COUNT) {
            Some(sliver) => (self.slivers[sliver].volume, self.slivers[sliver].middle),
            None => self.stretch(gaps, axis, node),
        }
    }

    /// The sub-cell that a node lies in.
    fn place(&self, node: usize) -> usize {
        let of = |c: [usize; 3]| (c[0] * SUBCELLS + c[1]) * SUBCELLS + c[2];
        if node < COUNT {
            return of(coordinates(node).map(|i| i / WITHIN));
        }
        let x = self.point(node) - self.lo;
        of([0, 1, 2].map(|k| ((x[k] / self.h[k] * SUBCELLS as f64) as usize).min(SUBCELLS - 1)))
    }

    /// The free volume that a sample stands for, and its middle: between walls along `main`, between those square to them along the other axes.
    fn stretch(&self, gaps: &Gaps, main: usize, sample: usize) -> (f64, Vec3) {
        let c = coordinates(sample);
        let n = FINE as f64;
        let (mut volume, mut middle) = (self.h.product(), [0.0; 3]);
        for axis in 0..3 {
            let counts = |p: &&(f64, bool)| axis == main || p.1;
            let below = gaps.at(axis, c, 0).places().iter().rfind(counts);
            let above = gaps.at(axis, c, 1).places().iter().find(counts);
            let from = below.map_or(c[axis] as f64 / n, |p| p.0);
            let to = above.map_or((c[axis] + 1) as f64 / n, |p| p.0);
            middle[axis] = self.lo[axis] + 0.5 * (from + to) * self.h[axis];
            // Never quite nothing, so that means over weights exist.
            volume *= (to - from).max(1e-9 / n);
        }
        (volume, Vec3::from_array(middle))
    }
}

fn root(parent: &mut [u16], mut i: usize) -> usize {
    while parent[i] as usize != i {
        parent[i] = parent[parent[i] as usize];
        i = parent[i] as usize;
    }
    i
}

fn components(cell: &Cell, gaps: &Gaps) -> Vec<Vec<usize>> {
    let nodes = COUNT + cell.slivers.len();
    let mut parent: Vec<u16> = (0..nodes as u16).collect();
    let stride = [FINE * FINE, FINE, 1];
    for s in 0..COUNT {
        let c = coordinates(s);
        for axis in 0..3 {
            let g = gaps.at(axis, c, 0);
            if c[axis] > 0 && g.n == 0 {
                let (a, b) = (root(&mut parent, s), root(&mut parent, s - stride[axis]));
                parent[a.max(b)] = a.min(b) as u16;
            }
        }
    }
    cell.link_slivers(&mut parent);
    gather(nodes, |s| root(&mut parent, s))
}

/// Lists 0..n by label, in the order in which the labels appear.
fn gather(n: usize, mut label: impl FnMut(usize) -> usize) -> Vec<Vec<usize>> {
    let mut place = vec![usize::MAX; n];
    let mut lists: Vec<Vec<usize>> = Vec::new();
    for s in 0..n {
        let l = label(s);
        if place[l] == usize::MAX {
            place[l] = lists.len();
            lists.push(Vec::new());
        }
        lists[place[l]].push(s);
    }
    lists
}

/// Joins the parts of which some samples see each other; small parts first look at large ones.
fn join(cell: &Cell, parts: Vec<Vec<usize>>) -> Vec<Vec<usize>> {
    if parts.len() < 2 {
        return parts;
    }
    let mut parent: Vec<u16> = (0..parts.len() as u16).collect();
    let picks: Vec<Vec<Vec3>> = parts
        .iter()
        .map(|p| {
            let n = p.len().min(LOOKS);
            (0..n).map(|i| cell.point(p[(2 * i + 1) * p.len() / (2 * n)])).collect()
        })
        .collect();
    for i in 0..parts.len() {
        for j in 0..i {
            // In a thicket only the larger parts are worth a look.
            if parts.len() > 16 && parts[j].len().max(parts[i].len()) < 32 {
                continue;
            }
            let (a, b) = (root(&mut parent, i), root(&mut parent, j));
            if a != b && picks[i].iter().any(|x| picks[j].iter().any(|y| cell.sees(*x, *y))) {
                parent[a.max(b)] = a.min(b) as u16;
            }
        }
    }
    let lists = gather(parts.len(), |i| root(&mut parent, i));
    let merged = lists.into_iter().map(|l| {
        let mut all: Vec<usize> = l.into_iter().flat_map(|i| parts[i].iter().copied()).collect();
        all.sort_unstable();
        all
    });
    merged.collect()
}

/// Resolves cell `c`, through which these facets pass.
pub(super) fn resolve(
    transport: &Transport,
    map: &Voxmap,
    c: [usize; 3],
    facets: &[u32],
    gaps: &mut Gaps,
) -> Resolved {
    let all = transport.scene().facets();
    let mut cell = Cell {
        lo: map.corner(c),
        h: map.cell(),
        facets: facets.iter().map(|f| Prepared::new(&all[*f as usize].plate)).collect(),
        transport,
        slivers: Vec::new(),
    };
    cell.pierce(gaps);
    let axis = (0..3).fold(0, |b, k| if gaps.pierced(k) > gaps.pierced(b) { k } else { b });
    cell.find_slivers(gaps, axis);
    let mut parts = components(&cell, gaps);
    if transport.has_places_without_medium() {
        parts.retain(|p| transport.holds_medium(cell.point(p[p.len() / 2])));
    }
    let mut parts = join(&cell, parts);
    parts.retain(|p| p.len() >= LEAST);
    let parts: Vec<Part> = parts.iter().map(|p| part(&cell, gaps, axis, p)).collect();
    let whole = cell.h.product();
    let samples_in_one = parts.len() == 1 && parts[0].volume >= whole * (1.0 - 1.0 / COUNT as f64);
    if samples_in_one { Resolved::Whole } else { Resolved::Parts(parts) }
}

/// What one sub-cell has of a part.
#[derive(Clone, Default)]
struct Sub {
    nodes: Vec<usize>,
    volume: f64,
    moment: Vec3,
}

/// Fine samples along an edge of a sub-cell.
const WITHIN: usize = FINE / SUBCELLS;

fn part(cell: &Cell, gaps: &Gaps, axis: usize, nodes: &[usize]) -> Part {
    let mut subs = vec![Sub::default(); SUBCELLS * SUBCELLS * SUBCELLS];
    for &node in nodes {
        let (w, middle) = cell.held(gaps, axis, node);
        let sub = &mut subs[cell.place(node)];
        sub.nodes.push(node);
        sub.volume += w;
        sub.moment += middle * w;
    }
    let (mut volume, mut moment) = (0.0, Vec3::ZERO);
    let mut out = Vec::with_capacity(subs.len());
    for (k, sub) in subs.iter().enumerate().filter(|x| !x.1.nodes.is_empty()) {
        volume += sub.volume;
        moment += sub.moment;
        let point = cell.seen_mean(gaps, k, sub);
        out.push(Sample { point, volume: sub.volume, subcell: k as u8 });
    }
    let mean = moment / volume;
    let centre = cell.nearest(nodes, mean);
    Part { samples: zonal_scene::Part::new(cell.lo, cell.h, volume, &out), centre, volume }
}

impl Cell<'_> {
    /// The node nearest to `x`.
    fn nearest(&self, nodes: &[usize], x: Vec3) -> Vec3 {
        let mut best = (f64::INFINITY, x);
        for p in nodes.iter().map(|s| self.point(*s)) {
            let d = (p - x).length2();
            best = if d < best.0 { (d, p) } else { best };
        }
        best.1
    }

    /// Where the sample of a sub-cell lies: at the mean of its part there, or at the node nearest to that when this does not
    /// see it; as near as it can be packed.
    fn seen_mean(&self, gaps: &Gaps, subcell: usize, sub: &Sub) -> Vec3 {
        let mean = packed_point(self.lo, self.h, subcell as u8, sub.moment / sub.volume);
        if sub.nodes.len() == WITHIN.pow(3) && sub.nodes.iter().all(|s| self.unpierced(gaps, *s)) {
            return mean;
        }
        let near = self.nearest(&sub.nodes, mean);
        // A mean that lies in a facet is seen from everywhere: look a little past it.
        let past = near + (mean - near) * 1.001;
        if self.sees(near, past) { mean } else { packed_point(self.lo, self.h, subcell as u8, near) }
    }

    /// True for a fine sample between which and the other ones of its sub-cell no line is pierced.
    fn unpierced(&self, gaps: &Gaps, node: usize) -> bool {
        let sample = node < COUNT;
        let c = coordinates(node.min(COUNT - 1));
        sample && (0..3).all(|axis| c[axis].is_multiple_of(WITHIN) || gaps.at(axis, c, 0).n == 0)
    }
}
