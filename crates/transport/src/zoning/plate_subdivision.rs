//! Subdivision of plates to a size.
//!
//! By edge (`PatchRule::Edge`) a parallelogram becomes an n_u × n_v grid of cells no longer than the size. A triangle becomes n²
//! congruent ones, with n the number of sizes in √(2A), the edge of the square it is half of. A long thin triangle is first halved
//! at its longest edge until its pieces are well shaped (longest edge at most three heights) or short enough, so a needle of length
//! L becomes about L/size pieces, not (L/size)².
//!
//! By area (`PatchRule::Area`) a triangle stays whole while its area A is at most size² and its longest edge at most six sizes. A
//! triangle of up to two size², and a needle, is halved at its longest edge; any other becomes n² congruent ones, with n = √A/size
//! rounded up.
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

/// Appends the pieces of `p`, of about edge `size`, with the orientation of `p`.
pub(super) fn subdivide(p: &Plate, size: f64, rule: PatchRule, out: &mut Vec<Plate>) {
    let subdivide_triangle = match rule {
        PatchRule::Edge | PatchRule::Voxels => subdivide_by_edge,
        PatchRule::Area => subdivide_by_area,
    };
    match p.kind {
        PlateKind::Triangle => subdivide_triangle(p, size, out),
        PlateKind::Parallelogram if is_skewed(p) && p.diameter() > size => {
            triangles_of(p).iter().for_each(|t| subdivide_triangle(t, size, out));
        }
        PlateKind::Parallelogram => {
            let (nu, nv) =
                (step_count(p.e1.length(), size) as usize, step_count(p.e2.length(), size) as usize);
            let (e1, e2) = (p.e1 / nu as f64, p.e2 / nv as f64);
            for i in 0..nu {
                for j in 0..nv {
                    out.push(Plate::parallelogram(p.at(i as f64 / nu as f64, j as f64 / nv as f64), e1, e2));
                }
            }
        }
    }
}

/// Parameters u and v at which the planes between voxels cut an axis-aligned rectangle, its ends included; `None` for any other
/// plate. Pieces shorter than a voxel are cut further down to the size of the surface, m, if it has one.
pub(super) fn voxel_cuts(p: &Plate, grid: &VoxelGrid, size: Option<f64>) -> Option<[Vec<f64>; 2]> {
    let axis_of = |e: Vec3| (0..3).find(|&k| e.length() - e[k].abs() <= 1e-12 * e.length());
    let (a, b) = (axis_of(p.e1)?, axis_of(p.e2)?);
    let cuts = |e: Vec3, k: usize| {
        let parameter = |i: usize| (grid.min()[k] + i as f64 * grid.cell()[k] - p.origin[k]) / e[k];
        let slack = 1e-6 * grid.cell()[k] / e[k].abs();
        let inside = (0..=grid.dims()[k]).map(parameter).filter(|t| (slack..1.0 - slack).contains(t));
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

fn subdivide_by_edge(p: &Plate, size: f64, out: &mut Vec<Plate>) {
    let (edge, turned) = longest_edge(p);
    let area2 = 2.0 * p.area();
    let n = step_count(area2.sqrt().max(edge * std::f64::consts::FRAC_1_SQRT_2), size);
    if n <= 1.0 {
        out.push(*p);
    } else if edge * edge > MAX_ASPECT_RATIO * area2 {
        halve(&turned).iter().for_each(|t| subdivide_by_edge(t, size, out));
    } else {
        append_congruent(p, n as usize, out);
    }
}

fn subdivide_by_area(p: &Plate, size: f64, out: &mut Vec<Plate>) {
    let (edge, turned) = longest_edge(p);
    let n = step_count(p.area().sqrt(), size);
    if n <= 1.0 && edge <= MAX_EDGE_IN_SIZES * size {
        out.push(*p);
    } else if p.area() <= 2.0 * size * size || edge * edge > 2.0 * MAX_ASPECT_RATIO * p.area() {
        halve(&turned).iter().for_each(|t| subdivide_by_area(t, size, out));
    } else {
        append_congruent(p, n as usize, out);
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
