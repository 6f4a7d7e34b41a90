//! A cell that facets pass through, resolved into its free parts.
//!
//! An 8 × 8 × 8 lattice of fine samples fills the cell, moved by a hair so that no lattice plane is a wall. Along each axis 64 lines
//! join them; where a facet pierces a line between two samples, these two are not linked. The connected components are the parts
//! that walls separate. Those without a medium, inside a solid or outside of everything, are dropped; the others are linked once more where some sample of one sees one of the
//! other.
//!
//! **Volumes.** Along the axis that facets pierce most often each sample stands for the stretch of its line that is nearer to it
//! than to its neighbours and not behind a facet, times the line's share h²/64 of the cross-section. So a wall square to an axis
//! gives exact volumes and centroids, and an oblique one is integrated exactly along the lines.

use crate::Transport;
use crate::meet::{Line, Prepared};
use zonal_math::{Vec3, vec3};
use zonal_scene::part::{SUBCELLS, packed_point};
use zonal_scene::{Sample, Voxmap};

const FINE: usize = 8;
const COUNT: usize = FINE * FINE * FINE;
const GAPS: usize = FINE + 1;
const HAIR: [f64; 3] = [1.372_981e-4, -1.871_413e-4, 1.618_034e-4];
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

/// Where facets pierce the lines: first and last share of the line in each gap, by axis, line and gap.
pub(super) struct Gaps(Vec<[f64; 2]>);

impl Gaps {
    pub fn new() -> Gaps {
        Gaps(vec![[f64::INFINITY, f64::NEG_INFINITY]; 3 * FINE * FINE * GAPS])
    }
    fn clear(&mut self) {
        self.0.fill([f64::INFINITY, f64::NEG_INFINITY]);
    }
    /// The gap below sample c along the axis; `up` for the one above.
    fn at(&self, axis: usize, c: [usize; 3], up: usize) -> [f64; 2] {
        self.0[slot(axis, c[(axis + 1) % 3], c[(axis + 2) % 3], c[axis] + up)]
    }
    fn pierced(&self, axis: usize) -> usize {
        let n = FINE * FINE * GAPS;
        self.0[axis * n..(axis + 1) * n].iter().filter(|g| g[0] <= g[1]).count()
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
}

fn coordinates(sample: usize) -> [usize; 3] {
    [sample / (FINE * FINE), sample / FINE % FINE, sample % FINE]
}

/// Position of the i-th sample along an axis as a share of the cell.
fn share(axis: usize, i: usize) -> f64 {
    (i as f64 + 0.5 + HAIR[axis]) / FINE as f64
}

impl Cell<'_> {
    fn point(&self, sample: usize) -> Vec3 {
        let c = coordinates(sample);
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
                        let g = &mut gaps.0[slot(axis, i, j, above.clamp(0.0, FINE as f64) as usize)];
                        *g = [g[0].min(t), g[1].max(t)];
                    }
                }
            }
        }
    }

    /// The free volume that a sample stands for, by lines along `axis`, and its middle.
    fn stretch(&self, gaps: &Gaps, axis: usize, sample: usize) -> (f64, Vec3) {
        let c = coordinates(sample);
        let (below, above) = (gaps.at(axis, c, 0), gaps.at(axis, c, 1));
        let n = FINE as f64;
        let from = if below[0] <= below[1] { below[1] } else { c[axis] as f64 / n };
        let to = if above[0] <= above[1] { above[0] } else { (c[axis] + 1) as f64 / n };
        let mut middle = self.point(sample).array();
        middle[axis] = self.lo[axis] + 0.5 * (from + to) * self.h[axis];
        // Never quite nothing, so that means over weights exist.
        let volume = (to - from).max(1e-9 / n) / (n * n) * self.h.product();
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

fn components(gaps: &Gaps) -> Vec<Vec<usize>> {
    let mut parent: [u16; COUNT] = std::array::from_fn(|i| i as u16);
    let stride = [FINE * FINE, FINE, 1];
    for s in 0..COUNT {
        let c = coordinates(s);
        for axis in 0..3 {
            let g = gaps.at(axis, c, 0);
            if c[axis] > 0 && g[0] > g[1] {
                let (a, b) = (root(&mut parent, s), root(&mut parent, s - stride[axis]));
                parent[a.max(b)] = a.min(b) as u16;
            }
        }
    }
    gather(COUNT, |s| root(&mut parent, s))
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
    let cell = Cell {
        lo: map.corner(c),
        h: map.cell(),
        facets: facets.iter().map(|f| Prepared::new(&all[*f as usize].plate)).collect(),
        transport,
    };
    cell.pierce(gaps);
    let axis = (0..3).fold(0, |b, k| if gaps.pierced(k) > gaps.pierced(b) { k } else { b });
    let mut parts = components(gaps);
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

/// What one sub-cell has of a part: the mask of its eight fine samples, free volume and first moment.
#[derive(Clone, Copy)]
struct Sub {
    members: u8,
    volume: f64,
    moment: Vec3,
}

/// Fine samples along an edge of a sub-cell.
const WITHIN: usize = FINE / SUBCELLS;

/// The sub-cell of a fine sample, and its number there.
fn place(s: usize) -> (usize, usize) {
    let c = coordinates(s);
    let [a, b] = [c.map(|i| i / WITHIN), c.map(|i| i % WITHIN)];
    ((a[0] * SUBCELLS + a[1]) * SUBCELLS + a[2], (b[0] * WITHIN + b[1]) * WITHIN + b[2])
}

/// The fine sample with this number in a sub-cell.
fn fine(subcell: usize, member: usize) -> usize {
    let at = |k: usize, n: usize| [k / (n * n), k / n % n, k % n];
    let (a, b) = (at(subcell, SUBCELLS), at(member, WITHIN));
    let c = [0, 1, 2].map(|x| a[x] * WITHIN + b[x]);
    (c[0] * FINE + c[1]) * FINE + c[2]
}

fn part(cell: &Cell, gaps: &Gaps, axis: usize, samples: &[usize]) -> Part {
    let mut subs = [Sub { members: 0, volume: 0.0, moment: Vec3::ZERO }; SUBCELLS * SUBCELLS * SUBCELLS];
    for &s in samples {
        let ((k, member), (w, middle)) = (place(s), cell.stretch(gaps, axis, s));
        let sub = &mut subs[k];
        sub.members |= 1 << member;
        sub.volume += w;
        sub.moment += middle * w;
    }
    let (mut volume, mut moment) = (0.0, Vec3::ZERO);
    let mut out = Vec::with_capacity(subs.len());
    for (k, sub) in subs.iter().enumerate().filter(|x| x.1.members != 0) {
        volume += sub.volume;
        moment += sub.moment;
        let point = cell.seen_mean(gaps, k, sub);
        out.push(Sample { point, volume: sub.volume, subcell: k as u8 });
    }
    let mean = moment / volume;
    let centre = cell.nearest(samples.iter().copied(), mean);
    Part { samples: zonal_scene::Part::new(cell.lo, cell.h, volume, &out), centre, volume }
}

impl Cell<'_> {
    /// The fine sample nearest to `x`.
    fn nearest(&self, samples: impl Iterator<Item = usize>, x: Vec3) -> Vec3 {
        let mut best = (f64::INFINITY, x);
        for p in samples.map(|s| self.point(s)) {
            let d = (p - x).length2();
            best = if d < best.0 { (d, p) } else { best };
        }
        best.1
    }

    /// Where the sample of a sub-cell lies: at the mean of its part there, or at the fine sample nearest to that when this does not
    /// see it; as near as it can be packed.
    fn seen_mean(&self, gaps: &Gaps, subcell: usize, sub: &Sub) -> Vec3 {
        let mean = packed_point(self.lo, self.h, subcell as u8, sub.moment / sub.volume);
        if sub.members == u8::MAX && self.untouched(gaps, subcell) {
            return mean;
        }
        let members = (0..8).filter(|m| sub.members >> m & 1 == 1).map(|m| fine(subcell, m));
        let near = self.nearest(members, mean);
        // A mean that lies in a facet is seen from everywhere: look a little past it.
        let past = near + (mean - near) * 1.001;
        if self.sees(near, past) { mean } else { packed_point(self.lo, self.h, subcell as u8, near) }
    }

    /// True when no line is pierced between the fine samples of a sub-cell.
    fn untouched(&self, gaps: &Gaps, subcell: usize) -> bool {
        (0..8).all(|m| {
            let c = coordinates(fine(subcell, m));
            (0..3).all(|axis| {
                let g = gaps.at(axis, c, 0);
                c[axis].is_multiple_of(WITHIN) || g[0] > g[1]
            })
        })
    }
}
