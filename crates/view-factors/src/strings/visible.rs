//! View factors of a facet of a cross-section: from one point, and integrated along the facet.
//!
//! With s along the facet and τ the sine of the angle from its normal, a wedge between two visible vertices contributes
//!
//! ```text
//! X = ½ ∫ (τ_b − τ_a) ds,      ∫_{s₀}^{s₁} τ_v ds = |v − s₀| − |v − s₁|      (crossed strings)
//! ```
//!
//! exactly, as long as the same vertices bound the view. For one point the wedges are found column by column, a column being one period: rays meet nearer
//! columns first. The range of s with the same wedges ends where the line through two vertices, one that bounds a wedge and one behind it, meets the facet. The rest of
//! the facet is treated in the same way.

use super::section::{Section, SectionPiece};

/// Where ranges are divided: symmetric geometries have their changes at simple fractions.
const DIVISION: f64 = 0.487_123_904_1;
/// Length of a range that is left out, relative to the facet.
const LEAST_RANGE: f64 = 1e-14;
/// Height over the facet's line, relative to the largest distance, below which a vertex lies on the line.
const FLATNESS: f64 = 1e-12;

/// The bound of a wedge.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Boundary {
    Low,
    High,
    /// A vertex, by its number among the local points.
    Vertex(u32),
    /// The horizontal direction.
    Horizontal,
}

/// The end of the rays of a wedge.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Target {
    /// A piece in a column, and its facet on the side that is met.
    Piece {
        piece: u32,
        column: i32,
        facet: Option<u32>,
    },
    Sky,
    Ground,
    /// Images that are not represented, or nothing; above or below the horizon.
    Unresolved {
        above: bool,
    },
}

#[derive(Clone, Copy, Debug)]
struct Wedge {
    tau: [f64; 2],
    bounds: [Boundary; 2],
}

/// X of one facet, m.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub facets: Vec<f64>,
    pub sky: f64,
    pub ground: f64,
    /// Exchange with images that are not represented or with the sky and the ground.
    pub unresolved: [f64; 2],
    /// Length whose view is not known, m.
    pub left_out: f64,
    /// Σ of the moduli of all terms, m.
    pub terms: f64,
}

impl Row {
    pub(crate) fn new(n: usize) -> Row {
        Row { facets: vec![0.0; n], sky: 0.0, ground: 0.0, unresolved: [0.0; 2], left_out: 0.0, terms: 0.0 }
    }

    /// Adds the row of another part of the facet.
    pub(crate) fn add(&mut self, o: &Row) {
        self.facets.iter_mut().zip(&o.facets).for_each(|(x, y)| *x += y);
        self.sky += o.sky;
        self.ground += o.ground;
        (0..2).for_each(|k| self.unresolved[k] += o.unresolved[k]);
        self.left_out += o.left_out;
        self.terms += o.terms;
    }
}

/// A piece with its front upwards in its own frame, x along it, h over it.
pub(crate) struct PieceView<'a> {
    section: &'a Section,
    /// Columns on each side.
    columns: i32,
    /// Places of all vertices in all columns: vertex · stride + column + `columns`; then the corners of the two gates.
    local: Vec<[f64; 2]>,
    stride: usize,
    origin: [f64; 2],
    along: [f64; 2],
    up: [f64; 2],
    length: f64,
    /// The ends of represented columns on both sides, if the section repeats.
    gates: Option<[f64; 2]>,
    heights: [f64; 2],
}

impl<'a> PieceView<'a> {
    pub(crate) fn new(
        section: &'a Section,
        piece: &SectionPiece,
        side: usize,
        columns: i32,
    ) -> PieceView<'a> {
        let [a, b] =
            if side == 0 { piece.ends } else { [piece.ends[1], piece.ends[0]] }.map(|v| section.at(v));
        let e = [b[0] - a[0], b[1] - a[1]];
        let length = e[0].hypot(e[1]);
        let along = e.map(|x| x / length);
        let up = [-along[1], along[0]];
        let columns = if section.period.is_some() { columns } else { 0 };
        let stride = 2 * columns as usize + 2;
        let mut view = PieceView {
            section,
            columns,
            local: Vec::with_capacity(section.vertices.len() * stride + 4),
            stride,
            origin: a,
            along,
            up,
            length,
            gates: None,
            heights: section.heights(),
        };
        for vertex in 0..section.vertices.len() as u32 {
            for image in -columns..=columns + 1 {
                let p = section.at(super::section::VertexImage { vertex, image });
                view.local.push(view.to_local(p));
            }
        }
        let gates = section
            .period
            .map(|q| [f64::from(-columns), f64::from(columns + 1)].map(|n| section.start + n * q));
        view.gates = gates;
        for u in gates.into_iter().flatten() {
            for z in view.heights {
                view.local.push(view.to_local([u, z]));
            }
        }
        let largest = view.local.iter().flatten().fold(length, |s, x| s.max(x.abs()));
        let near = view.local.iter_mut().filter(|p| p[1].abs() <= FLATNESS * largest);
        near.for_each(|p| p[1] = 0.0);
        view
    }

    fn to_local(&self, p: [f64; 2]) -> [f64; 2] {
        let d = [p[0] - self.origin[0], p[1] - self.origin[1]];
        [d[0] * self.along[0] + d[1] * self.along[1], d[0] * self.up[0] + d[1] * self.up[1]]
    }

    /// Number of local points.
    fn size(&self) -> u64 {
        self.local.len() as u64
    }

    fn number(&self, v: super::section::VertexImage, column: i32) -> u32 {
        (v.vertex as usize * self.stride) as u32 + (v.image + column + self.columns) as u32
    }

    fn first_gate(&self) -> usize {
        self.section.vertices.len() * self.stride
    }

    /// The column in which a vertex begins, and the next one.
    fn column_of(&self, number: u32) -> i32 {
        (number as usize % self.stride) as i32 - self.columns
    }

    /// The horizontal direction over the facet, along and up.
    fn horizontal(&self) -> [f64; 2] {
        let sign = self.up[0].signum();
        [sign * self.along[0], sign * self.up[0]]
    }

    fn tau(&self, b: Boundary, s: f64) -> f64 {
        match b {
            Boundary::Low => -1.0,
            Boundary::High => 1.0,
            Boundary::Vertex(v) => {
                let [x, h] = self.local[v as usize];
                (x - s) / (x - s).hypot(h)
            }
            Boundary::Horizontal => self.horizontal()[0],
        }
    }

    /// ∫ τ ds, and the modulus of its terms.
    fn integral(&self, b: Boundary, [from, to]: [f64; 2]) -> [f64; 2] {
        match b {
            Boundary::Vertex(v) => {
                let [x, h] = self.local[v as usize];
                let (p, q) = ((x - from).hypot(h), (x - to).hypot(h));
                // (p − q) without cancellation.
                let value = if p + q > 0.0 { (to - from) * (2.0 * x - from - to) / (p + q) } else { 0.0 };
                [value, value.abs()]
            }
            _ => [self.tau(b, from) * (to - from), to - from],
        }
    }

    /// Adds X of the piece to a row. `work` is what is left of the number of points to visit.
    pub(crate) fn add_to(&self, row: &mut Row, work: &mut u64) {
        let mut ranges = vec![[0.0, self.length]];
        while let Some([from, to]) = ranges.pop() {
            if to - from <= LEAST_RANGE * self.length || *work < self.size() {
                row.left_out += to - from;
                continue;
            }
            let s = from + DIVISION * (to - from);
            let wedges = self.wedges(s, work);
            let [low, high] = self.valid_range(s, &wedges, work);
            let range = [low.max(from), high.min(to)];
            for (wedge, target) in &wedges {
                let [a, b] = wedge.bounds.map(|b| self.integral(b, range));
                let x = 0.5 * (b[0] - a[0]);
                row.terms += a[1] + b[1];
                match *target {
                    Target::Piece { facet: Some(f), .. } => row.facets[f as usize] += x,
                    Target::Piece { facet: None, .. } => {}
                    Target::Sky => row.sky += x,
                    Target::Ground => row.ground += x,
                    Target::Unresolved { above } => row.unresolved[usize::from(above)] += x,
                }
            }
            ranges.push([range[1], to]);
            ranges.push([from, range[0]]);
        }
    }

    /// The view from one point.
    fn wedges(&self, s: f64, work: &mut u64) -> Vec<(Wedge, Target)> {
        let mut open = vec![Wedge { tau: [-1.0, 1.0], bounds: [Boundary::Low, Boundary::High] }];
        let mut made = Vec::new();
        for distance in 0..=self.columns {
            for column in [distance, -distance] {
                if open.is_empty() || (distance == 0 && column != distance) {
                    continue;
                }
                *work = work.saturating_sub(self.section.vertices.len() as u64 + 1);
                open = self.column(s, column, open, &mut made);
                if distance == 0 {
                    break;
                }
            }
        }
        for wedge in open {
            self.leave(s, wedge, &mut made);
        }
        made
    }

    /// Divides open wedges by the pieces of a column.
    fn column(&self, s: f64, column: i32, open: Vec<Wedge>, made: &mut Vec<(Wedge, Target)>) -> Vec<Wedge> {
        let mut near: Vec<NearPiece> = Vec::new();
        for (k, piece) in self.section.pieces.iter().enumerate() {
            let numbers = piece.ends.map(|v| self.number(v, column));
            let [p, q] = numbers.map(|v| self.local[v as usize]);
            if let Some(tau) = range_of(s, p, q)
                && open.iter().any(|w| w.tau[0] < tau[1] && tau[0] < w.tau[1])
            {
                near.push(NearPiece {
                    piece: k as u32,
                    numbers,
                    tau,
                    from: [p[0] - s, p[1]],
                    to: [q[0] - s, q[1]],
                });
            }
        }
        if near.is_empty() {
            return open;
        }
        let mut still = Vec::with_capacity(open.len());
        for wedge in open {
            let corners = near.iter().flat_map(|p| p.numbers).filter(|v| self.local[*v as usize][1] > 0.0);
            let parts = self.divided(s, wedge, corners.map(Boundary::Vertex).collect());
            let mut before: Option<(Wedge, Option<usize>)> = None;
            for part in parts {
                let hit = first_hit(&near, 0.5 * (part.tau[0] + part.tau[1]));
                match &mut before {
                    Some((sum, same)) if *same == hit => {
                        (sum.tau[1], sum.bounds[1]) = (part.tau[1], part.bounds[1]);
                    }
                    _ => {
                        self.keep(before.take(), &near, column, &mut still, made);
                        before = Some((part, hit));
                    }
                }
            }
            self.keep(before, &near, column, &mut still, made);
        }
        still
    }

    fn keep(
        &self,
        part: Option<(Wedge, Option<usize>)>,
        near: &[NearPiece],
        column: i32,
        open: &mut Vec<Wedge>,
        made: &mut Vec<(Wedge, Target)>,
    ) {
        match part {
            None => {}
            Some((wedge, None)) => open.push(wedge),
            Some((wedge, Some(k))) => {
                let met = &near[k];
                let piece = &self.section.pieces[met.piece as usize];
                // The left of the piece is met if the point lies there.
                let left =
                    met.from[0] * (met.to[1] - met.from[1]) - met.from[1] * (met.to[0] - met.from[0]) > 0.0;
                let facet = piece.facets[usize::from(!left)];
                made.push((wedge, Target::Piece { piece: met.piece, column, facet }));
            }
        }
    }

    /// The parts of a wedge between some of its directions.
    fn divided(&self, s: f64, wedge: Wedge, at: Vec<Boundary>) -> Vec<Wedge> {
        let mut ends: Vec<(f64, Boundary)> = at.into_iter().map(|b| (self.tau(b, s), b)).collect();
        ends.retain(|(t, b)| {
            wedge.tau[0] < *t && *t < wedge.tau[1] && *b != wedge.bounds[0] && *b != wedge.bounds[1]
        });
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        ends.dedup_by(|a, b| a.1 == b.1);
        ends.insert(0, (wedge.tau[0], wedge.bounds[0]));
        ends.push((wedge.tau[1], wedge.bounds[1]));
        ends.windows(2).map(|w| Wedge { tau: [w[0].0, w[1].0], bounds: [w[0].1, w[1].1] }).collect()
    }

    /// A wedge that meets nothing in all columns.
    fn leave(&self, s: f64, wedge: Wedge, made: &mut Vec<(Wedge, Target)>) {
        let gates = (self.first_gate()..self.local.len()).filter(|v| self.local[*v][1] > 0.0);
        let mut at: Vec<Boundary> = gates.map(|v| Boundary::Vertex(v as u32)).collect();
        if self.horizontal()[1] > 0.0 {
            at.push(Boundary::Horizontal);
        }
        let from = [0, 1].map(|k| self.origin[k] + s * self.along[k]);
        for part in self.divided(s, wedge, at) {
            let tau = 0.5 * (part.tau[0] + part.tau[1]);
            let h = (1.0 - tau * tau).max(0.0).sqrt();
            let d = [0, 1].map(|k| tau * self.along[k] + h * self.up[k]);
            let above = d[1] > 0.0;
            let is_unresolved = self.gates.is_some_and(|gates| {
                let z = from[1] + d[1] / d[0] * (gates[usize::from(d[0] > 0.0)] - from[0]);
                d[0] != 0.0 && self.heights[0] <= z && z <= self.heights[1]
            });
            let target = if is_unresolved {
                Target::Unresolved { above }
            } else if above {
                Target::Sky
            } else {
                Target::Ground
            };
            made.push((part, target));
        }
    }

    /// The points around s from which the same wedges are seen.
    fn valid_range(&self, s: f64, wedges: &[(Wedge, Target)], work: &mut u64) -> [f64; 2] {
        let mut range = [f64::NEG_INFINITY, f64::INFINITY];
        let mut limit = |at: Option<f64>| match at {
            Some(x) if x < s => range[0] = range[0].max(x),
            Some(x) => range[1] = range[1].min(x),
            None => {}
        };
        for (wedge, target) in wedges {
            let [a, b] = wedge.bounds;
            limit(self.alignment(a, b));
            for bound in [a, b] {
                let Boundary::Vertex(v) = bound else { continue };
                if v as usize >= self.first_gate() {
                    continue;
                }
                for other in self.behind(s, v, target, work) {
                    limit(self.alignment(bound, Boundary::Vertex(other)));
                }
            }
        }
        range
    }

    /// Vertices that may appear behind a vertex, before the target.
    fn behind(&self, s: f64, v: u32, target: &Target, work: &mut u64) -> Vec<u32> {
        let own = self.column_of(v);
        let (columns, line) = match *target {
            Target::Piece { piece, column, .. } => {
                let ends = self.section.pieces[piece as usize].ends.map(|e| self.number(e, column));
                if ends.contains(&v) {
                    return Vec::new();
                }
                ([own.min(column) - 1, own.max(column) + 1], Some(ends.map(|e| self.local[e as usize])))
            }
            _ => {
                let [x, h] = self.local[v as usize];
                let to_right = (x - s) * self.along[0] + h * self.up[0] > 0.0;
                (if to_right { [own - 1, self.columns + 1] } else { [-self.columns, own + 1] }, None)
            }
        };
        let [first, last] = [columns[0].max(-self.columns), columns[1].min(self.columns + 1)];
        *work = work.saturating_sub((last - first + 1).max(0) as u64 * self.section.vertices.len() as u64);
        let height = self.local[v as usize][1];
        let side = |line: &[[f64; 2]; 2], p: [f64; 2]| {
            let [a, b] = line;
            (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
        };
        let is_before = |p: [f64; 2]| {
            line.as_ref().is_none_or(|l| {
                // Zero within rounding: an end of the line, or a vertex on it.
                let (size, here) = ((l[1][0] - l[0][0]).hypot(l[1][1] - l[0][1]), side(l, [s, 0.0]));
                side(l, p) * here.signum() >= -FLATNESS * size * (size + height)
            })
        };
        let mut found = Vec::new();
        let gates = if line.is_none() { self.first_gate()..self.local.len() } else { 0..0 };
        let all = (0..self.section.vertices.len())
            .flat_map(|k| (first..=last).map(move |c| k * self.stride + (c + self.columns) as usize));
        for k in all.chain(gates) {
            let p = self.local[k];
            if p[1] > height && is_before(p) {
                found.push(k as u32);
            }
        }
        found
    }

    /// The point of the facet from which two boundaries are in line.
    fn alignment(&self, a: Boundary, b: Boundary) -> Option<f64> {
        let at = match (a, b) {
            (Boundary::Vertex(v), Boundary::Vertex(w)) => {
                let ([x, h], [y, g]) = (self.local[v as usize], self.local[w as usize]);
                x - h * ((y - x) / (g - h))
            }
            (Boundary::Vertex(v), Boundary::Horizontal) | (Boundary::Horizontal, Boundary::Vertex(v)) => {
                let ([x, h], d) = (self.local[v as usize], self.horizontal());
                x - h * (d[0] / d[1])
            }
            _ => return None,
        };
        at.is_finite().then_some(at)
    }
}

/// A piece of a column seen from a point, which is the origin of `from` and `to`.
struct NearPiece {
    piece: u32,
    numbers: [u32; 2],
    tau: [f64; 2],
    from: [f64; 2],
    to: [f64; 2],
}

/// The range of τ of a segment seen from s; None if nothing of it is over the facet.
fn range_of(s: f64, p: [f64; 2], q: [f64; 2]) -> Option<[f64; 2]> {
    if p[1] <= 0.0 && q[1] <= 0.0 {
        return None;
    }
    let tau = |p: [f64; 2], q: [f64; 2]| {
        if p[1] > 0.0 {
            return (p[0] - s) / (p[0] - s).hypot(p[1]);
        }
        let x = if p[1] == 0.0 { p[0] } else { p[0] - p[1] * ((q[0] - p[0]) / (q[1] - p[1])) };
        (x - s).signum()
    };
    let (a, b) = (tau(p, q), tau(q, p));
    Some([a.min(b), a.max(b)])
}

/// The nearest piece in a direction.
fn first_hit(near: &[NearPiece], tau: f64) -> Option<usize> {
    let d = [tau, (1.0 - tau * tau).max(0.0).sqrt()];
    let mut first: Option<(f64, usize)> = None;
    for (k, p) in near.iter().enumerate() {
        if p.tau[0] < tau && tau < p.tau[1] {
            let e = [p.to[0] - p.from[0], p.to[1] - p.from[1]];
            let distance = (p.from[0] * e[1] - p.from[1] * e[0]) / (d[0] * e[1] - d[1] * e[0]);
            if distance > 0.0 && first.is_none_or(|f| distance < f.0) {
                first = Some((distance, k));
            }
        }
    }
    first.map(|f| f.1)
}
