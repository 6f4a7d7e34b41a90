//! Subdivision of plates to a size.
//!
//! By edge (`PatchRule::Edge`) a parallelogram becomes an n_u × n_v grid of cells no longer than the size. A triangle becomes n²
//! congruent ones, with n the number of sizes in √(2A), the edge of the square it is half of. A long thin triangle is first halved
//! at its longest edge until its pieces are well shaped (longest edge at most three heights) or short enough.
//!
//! By area (`PatchRule::Area`) a triangle stays whole while its area A is at most size² and its longest edge at most six sizes. A
//! triangle of up to two size², and a thin one, is halved at its longest edge; any other becomes n² congruent ones, with n = √A/size
//! rounded up.
//!
//! A **needle**, whose longest edge exceeds [`MAX_HALVED_ASPECT_RATIO`] heights, is cut across its length only: halving would make
//! its pieces thinner with each step, and their number grows faster than the length. The foot of the height divides it into two
//! right needles, each of which is cut at parameters t of its two long sides into trapezoids of two triangles. A trapezoid is as
//! long as the needle is wide there, or as a size. A needle of length L becomes about 2 L/size pieces.
//!
//! By voxels (`PatchRule::Voxels`) per axis-aligned rectangle is cut by the planes between the cells of the medium.

use zonal_math::Vec3;
use zonal_scene::PatchRule;
use zonal_scene::{Plate, PlateKind, VoxelGrid};

/// Most patches that a scene may be cut into.
pub(super) const MAX_PATCHES: usize = 1 << 22;
/// Longest edge of a well-shaped triangle over its height.
const MAX_ASPECT_RATIO: f64 = 3.0;
/// Longest edge of a triangle under `PatchRule::Area`, in sizes.
const MAX_EDGE_IN_SIZES: f64 = 6.0;
/// Longest edge of a triangle over its height, above which it is cut across its length.
const MAX_HALVED_ASPECT_RATIO: f64 = 32.0;
/// Most halvings of a triangle. Each halves the area, so that rounding alone reaches this number.
const MAX_HALVINGS: usize = 64;

/// The parameters at which a rectangle is cut to `size` (m), except along `axis`, along which it is a piece of an infinitely long strip.
pub(super) fn strip_cuts(p: &Plate, axis: usize, size: f64) -> [Vec<f64>; 2] {
    [p.e1, p.e2].map(|e| {
        let is_along = e[axis].abs() > 0.5 * e.length();
        let n = if is_along { 1.0 } else { step_count(e.length(), size).min(MAX_PATCHES as f64 + 1.0) };
        (0..=n as usize).map(|k| k as f64 / n).collect()
    })
}

/// Number of steps of at most `size` (up to rounding) that cover `length`.
fn step_count(length: f64, size: f64) -> f64 {
    (length / size - 1e-9).ceil().max(1.0)
}

/// Longest edge of a triangle, and the triangle with its corners rotated so that this edge is opposite to its origin.
fn longest_edge(p: &Plate) -> (f64, Plate) {
    let (c, _) = p.corners();
    let edge = |k: usize| (c[(k + 2) % 3] - c[(k + 1) % 3]).length();
    let mut best = 0;
    for k in 1..3 {
        if edge(k) > edge(best) * (1.0 + 1e-12) {
            best = k;
        }
    }
    let turned = Plate::triangle(c[best], c[(best + 1) % 3], c[(best + 2) % 3]);
    (edge(best), turned)
}

/// Estimate of the number of pieces of [`subdivide`]: at most twice their number.
pub(super) fn estimate_count(p: &Plate, size: f64, rule: PatchRule) -> f64 {
    match p.kind {
        PlateKind::Parallelogram if is_skewed(p) => {
            triangles_of(p).iter().map(|t| estimate_count(t, size, rule)).sum()
        }
        _ => count_by_area(p, size, rule).max(1.0),
    }
}

/// The estimate of [`estimate_count`], but for a plate smaller than a piece its share of one.
pub(super) fn count_by_area(p: &Plate, size: f64, rule: PatchRule) -> f64 {
    let (squares, lengths) = match rule {
        PatchRule::Edge | PatchRule::Voxels => (2.0, 1.0),
        PatchRule::Area => (1.0, 1.0 / MAX_EDGE_IN_SIZES),
    };
    let pieces = p.area() / (size * size);
    let count = match p.kind {
        PlateKind::Parallelogram => step_count(p.e1.length(), size) * step_count(p.e2.length(), size),
        PlateKind::Triangle => (squares * pieces).max(lengths * longest_edge(p).0 / size),
    };
    if count > 1.0 { count } else { pieces }
}

/// True for a parallelogram far from a rectangle.
fn is_skewed(p: &Plate) -> bool {
    p.area() * MAX_ASPECT_RATIO < p.e1.length() * p.e2.length()
}

/// A parallelogram as two triangles along its shorter diagonal.
fn triangles_of(p: &Plate) -> [Plate; 2] {
    let (c, _) = p.corners();
    if (c[2] - c[0]).length2() < (c[3] - c[1]).length2() {
        [Plate::triangle(c[0], c[1], c[2]), Plate::triangle(c[0], c[2], c[3])]
    } else {
        [Plate::triangle(c[0], c[1], c[3]), Plate::triangle(c[1], c[2], c[3])]
    }
}

/// Receives the pieces of a plate: each plate stands for the n × n congruent parts that a grid of n steps along its edges makes of it.
type PieceSink<'a> = &'a mut dyn FnMut(&Plate, [f64; 2]);

/// Passes the pieces of `p`, of about edge `size`, to `sink`.
fn visit_pieces(p: &Plate, size: f64, rule: PatchRule, sink: PieceSink<'_>) {
    let cut = TriangleCut { size, by_area: rule == PatchRule::Area };
    match p.kind {
        PlateKind::Triangle => cut.visit(p, MAX_HALVINGS, sink),
        PlateKind::Parallelogram if is_skewed(p) && p.diameter() > size => {
            triangles_of(p).iter().for_each(|t| cut.visit(t, MAX_HALVINGS, sink));
        }
        PlateKind::Parallelogram => sink(p, [p.e1, p.e2].map(|e| step_count(e.length(), size))),
    }
}

/// Number of pieces of [`subdivide`]; above [`MAX_PATCHES`] an estimate within a factor of four, found without cutting.
pub(super) fn piece_count(p: &Plate, size: f64, rule: PatchRule) -> f64 {
    let estimate = estimate_count(p, size, rule);
    if estimate > 2.0 * MAX_PATCHES as f64 {
        return estimate;
    }
    let mut count = 0.0;
    visit_pieces(p, size, rule, &mut |_, [nu, nv]| count += nu * nv);
    count
}

/// Appends the pieces of `p`, of about edge `size`, with the orientation of `p`. The caller has bounded their number by [`piece_count`].
pub(super) fn subdivide(p: &Plate, size: f64, rule: PatchRule, out: &mut Vec<Plate>) {
    visit_pieces(p, size, rule, &mut |q, [nu, nv]| match q.kind {
        _ if nu * nv <= 1.0 => out.push(*q),
        PlateKind::Triangle => append_congruent(q, nu as usize, out),
        PlateKind::Parallelogram => {
            let (e1, e2) = (q.e1 / nu, q.e2 / nv);
            for i in 0..nu as usize {
                for j in 0..nv as usize {
                    out.push(Plate::parallelogram(q.at(i as f64 / nu, j as f64 / nv), e1, e2));
                }
            }
        }
    });
}

/// Parameters u and v at which the planes between voxels cut an axis-aligned rectangle, its ends included; `None` for any other
/// plate. Pieces shorter than a voxel are cut further down to the size of the surface, m, if it has one.
pub(super) fn voxel_cuts(p: &Plate, grid: &VoxelGrid, size: Option<f64>) -> Option<[Vec<f64>; 2]> {
    let axis_of = |e: Vec3| (0..3).find(|&k| e.length() - e[k].abs() <= 1e-12 * e.length());
    let (a, b) = (axis_of(p.e1)?, axis_of(p.e2)?);
    let cuts = |e: Vec3, k: usize| {
        let parameter = |i: usize| (grid.min()[k] + i as f64 * grid.cell()[k] - p.origin[k]) / e[k];
        let slack = 1e-6 * grid.cell()[k] / e[k].abs();
        // The planes between the ends of the edge; the count check refuses more than the largest number of patches.
        let ends = [p.origin[k], p.origin[k] + e[k]].map(|x| (x - grid.min()[k]) / grid.cell()[k]);
        let first = (ends[0].min(ends[1]).floor() - 1.0).max(0.0) as usize;
        let last = ((ends[0].max(ends[1]).ceil() + 1.0).max(0.0) as usize).min(grid.dims()[k]);
        let planes = (first..=last).take(MAX_PATCHES + 2);
        let inside = planes.map(parameter).filter(|t| (slack..1.0 - slack).contains(t));
        let mut all: Vec<f64> = [0.0, 1.0].into_iter().chain(inside).collect();
        all.sort_by(f64::total_cmp);
        let Some(size) = size else { return all };
        let mut out = vec![0.0];
        for w in all.windows(2) {
            let length = (w[1] - w[0]) * e[k].abs();
            let n = if length < grid.cell()[k] * (1.0 - 1e-6) { step_count(length, size) } else { 1.0 };
            // The count check refuses larger numbers.
            let n = n.min(MAX_PATCHES as f64 + 1.0);
            out.extend((1..=n as usize).map(|i| w[0] + (w[1] - w[0]) * (i as f64 / n)));
        }
        out
    };
    (p.kind == PlateKind::Parallelogram && a != b).then(|| [cuts(p.e1, a), cuts(p.e2, b)])
}

/// Appends the pieces of the rectangle `p` between these parameters.
pub(super) fn cut_at(p: &Plate, [u, v]: &[Vec<f64>; 2], out: &mut Vec<Plate>) {
    for s in u.windows(2) {
        for t in v.windows(2) {
            out.push(Plate::parallelogram(p.at(s[0], t[0]), p.e1 * (s[1] - s[0]), p.e2 * (t[1] - t[0])));
        }
    }
}

/// The cut of triangles to a size, m.
struct TriangleCut {
    size: f64,
    by_area: bool,
}

impl TriangleCut {
    /// Number of congruent parts along an edge of a well-shaped triangle of longest edge `edge`.
    fn steps(&self, p: &Plate, edge: f64) -> f64 {
        let side = if self.by_area {
            p.area().sqrt()
        } else {
            (2.0 * p.area()).sqrt().max(edge * std::f64::consts::FRAC_1_SQRT_2)
        };
        step_count(side, self.size)
    }

    /// True for a triangle that is one piece.
    fn is_small(&self, steps: f64, edge: f64) -> bool {
        steps <= 1.0 && (!self.by_area || edge <= MAX_EDGE_IN_SIZES * self.size)
    }

    /// Passes on the pieces of a triangle, with at most this number of halvings one after the other.
    fn visit(&self, p: &Plate, halvings: usize, sink: PieceSink<'_>) {
        let (edge, turned) = longest_edge(p);
        let (area2, steps) = (2.0 * p.area(), self.steps(p, edge));
        let thin = edge * edge > MAX_ASPECT_RATIO * area2;
        let barely_large = self.by_area && p.area() <= 2.0 * self.size * self.size;
        if self.is_small(steps, edge) || halvings == 0 {
            sink(p, [1.0; 2]);
        } else if edge * edge > MAX_HALVED_ASPECT_RATIO * area2 {
            self.visit_needle(&turned, sink);
        } else if thin || barely_large {
            halve(&turned).iter().for_each(|t| self.visit(t, halvings - 1, sink));
        } else {
            sink(p, [steps; 2]);
        }
    }

    /// The parts of a needle whose longest edge is opposite to its origin.
    fn visit_needle(&self, turned: &Plate, sink: PieceSink<'_>) {
        let (c, _) = turned.corners();
        let base = c[2] - c[1];
        let length = base.length();
        let height = 2.0 * turned.area() / length;
        let share = ((c[0] - c[1]).dot(base) / (length * length)).clamp(0.0, 1.0);
        // A foot near an end cuts off nothing: the whole is one needle with the other end as its tip.
        if share * length <= height {
            return self.visit_tapered(c[2], [c[0] - c[2], c[1] - c[2]], sink);
        }
        if (1.0 - share) * length <= height {
            return self.visit_tapered(c[1], [c[2] - c[1], c[0] - c[1]], sink);
        }
        self.visit_tapered(c[1], [base * share, c[0] - c[1]], sink);
        self.visit_tapered(c[2], [c[0] - c[2], base * (share - 1.0)], sink);
    }

    /// The parts of the needle with the given tip and the vectors from there to its other corners, counter-clockwise.
    fn visit_tapered(&self, tip: Vec3, [a, b]: [Vec3; 2], sink: PieceSink<'_>) {
        let (length, width) = (a.length().max(b.length()), (b - a).length());
        // Width up to which, and length of which, a part is one piece.
        let (narrow, step) =
            if self.by_area { (0.05 * self.size, 5.9 * self.size) } else { (self.size, self.size) };
        let least = if self.by_area { 1.9 * self.size } else { self.size };
        let mut part = |from: f64, to: f64, whole: bool| {
            let triangle =
                |e1: Vec3, e2: Vec3| Plate { origin: tip + a * from, e1, e2, kind: PlateKind::Triangle };
            let diagonal = b * to - a * from;
            let mut pass = |t: Plate| {
                let steps = if whole { 1.0 } else { self.steps(&t, longest_edge(&t).0) };
                sink(&t, [steps; 2]);
            };
            pass(triangle(a * (to - from), diagonal));
            if from > 0.0 {
                pass(triangle(diagonal, (b - a) * from));
            }
        };
        // Parts as long as they are wide, from the wide end.
        let mut end = 1.0;
        while width * end > narrow {
            let begin = (end - (width * end).max(least) / length).max(0.0);
            part(begin, end, false);
            end = begin;
        }
        // Parts of equal length to the tip.
        let count = step_count(end * length, step);
        for k in (0..if end > 0.0 { count as usize } else { 0 }).rev() {
            part(end * (k as f64 / count), end * ((k + 1) as f64 / count), true);
        }
    }
}

/// The halves of a triangle whose longest edge is opposite to its origin.
fn halve(turned: &Plate) -> [Plate; 2] {
    let (c, _) = turned.corners();
    let middle = (c[1] + c[2]) * 0.5;
    [Plate::triangle(c[0], c[1], middle), Plate::triangle(c[0], middle, c[2])]
}

/// Appends the n² congruent parts of a triangle.
fn append_congruent(p: &Plate, n: usize, out: &mut Vec<Plate>) {
    let (e1, e2) = (p.e1 / n as f64, p.e2 / n as f64);
    let mut push = |origin: Vec3, e1: Vec3, e2: Vec3| {
        out.push(Plate { origin, e1, e2, kind: PlateKind::Triangle });
    };
    for i in 0..n {
        for j in 0..n - i {
            let at = |i: usize, j: usize| p.at(i as f64 / n as f64, j as f64 / n as f64);
            push(at(i, j), e1, e2);
            if i + j + 1 < n {
                push(at(i + 1, j + 1), -e1, -e2);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    fn subdivided(p: &Plate, size: f64) -> Vec<Plate> {
        subdivided_by(p, size, PatchRule::Edge)
    }

    fn subdivided_by(p: &Plate, size: f64, rule: PatchRule) -> Vec<Plate> {
        let mut out = Vec::new();
        subdivide(p, size, rule, &mut out);
        let area: f64 = out.iter().map(Plate::area).sum();
        assert!((area / p.area() - 1.0).abs() < 1e-12);
        assert!(out.iter().all(|q| (q.normal() - p.normal()).length() < 1e-9));
        let guess = estimate_count(p, size, rule);
        assert!(
            guess <= 2.0 * out.len() as f64 && out.len() as f64 <= 4.0 * guess,
            "{guess} for {}",
            out.len()
        );
        out
    }

    #[test]
    fn plates_are_subdivided_to_the_size() {
        let square = Plate::parallelogram(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        assert_eq!(subdivided(&square, 0.1).len(), 100);
        assert_eq!(subdivided(&square, 3.0).len(), 1);
        let half = Plate::triangle(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        assert_eq!(subdivided(&half, 0.1).len(), 100);
        assert_eq!(subdivided(&half, 1.0).len(), 1);
    }

    #[test]
    fn needles_are_subdivided_along_their_length() {
        for apex in [0.0, 0.2, 5.0, 10.0] {
            let needle = Plate::triangle(Vec3::ZERO, vec3(10.0, 0.0, 0.0), vec3(apex, 0.01, 0.0));
            let pieces = subdivided(&needle, 1.0);
            assert!((8..=32).contains(&pieces.len()), "{}", pieces.len());
            assert!(pieces.iter().all(|p| p.diameter() < 1.5));
        }
    }

    #[test]
    fn area_rule_keeps_triangles_up_to_size_squared_and_six_sizes() {
        let corner = |x: f64, y: f64| Plate::triangle(Vec3::ZERO, vec3(x, 0.0, 0.0), vec3(0.0, y, 0.0));
        for (x, y, n) in [(1.4, 1.4, 1), (1.9, 1.9, 2), (3.0, 3.0, 9), (2.8, 0.1, 1), (11.0, 0.01, 3)] {
            let pieces = subdivided_by(&corner(x, y), 1.0, PatchRule::Area);
            assert_eq!(pieces.len(), n, "{x} {y}");
            assert!(pieces.iter().all(|p| p.area() <= 1.0 + 1e-9 && p.diameter() <= MAX_EDGE_IN_SIZES));
        }
    }
}
