//! Plates cut to a size.
//!
//! A parallelogram becomes an n_u × n_v grid of cells no longer than the size. A triangle becomes n² congruent ones, n = size's
//! share of √(2A), the edge of the square it is half of. A long thin triangle is first halved at its longest edge until its pieces are
//! fair (longest edge at most three heights) or short enough, so a needle of length L becomes about L/size pieces, not (L/size)².
//!
//! By area (`PatchRule::Area`) a triangle stays whole while its area A is at most size² and its longest edge at most six sizes; one
//! of up to two size², and a needle, is halved at its longest edge, another becomes n² congruent ones, n = √A/size rounded up.
//!
//! By voxels (`PatchRule::Voxels`) a rectangle along the axes is cut by the planes between the cells of the medium.

use zonal_math::Vec3;
use zonal_scene::scene::PatchRule;
use zonal_scene::{Plate, PlateKind, Voxmap};

const FAIR: f64 = 3.0;
/// Longest edge of a triangle cut by area, in sizes.
const LONG: f64 = 6.0;

/// Number of steps of at most `size` (up to rounding) that cover `length`.
fn steps(length: f64, size: f64) -> f64 {
    (length / size - 1e-9).ceil().max(1.0)
}

/// Longest edge of a triangle, and the triangle turned so that this edge is opposite to its origin.
fn longest(p: &Plate) -> (f64, Plate) {
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

/// About how many pieces [`pieces`] makes: never more than twice as many as it does.
pub(super) fn estimate(p: &Plate, size: f64, rule: PatchRule) -> f64 {
    let (squares, lengths) = match rule {
        PatchRule::Edge | PatchRule::Voxels => (2.0, 1.0),
        PatchRule::Area => (1.0, 1.0 / LONG),
    };
    let half = |p: &Plate| (squares * p.area() / (size * size)).max(lengths * longest(p).0 / size).max(1.0);
    match p.kind {
        PlateKind::Parallelogram if !skewed(p) => steps(p.e1.length(), size) * steps(p.e2.length(), size),
        PlateKind::Parallelogram => halves(p).iter().map(half).sum(),
        PlateKind::Triangle => half(p),
    }
}

fn skewed(p: &Plate) -> bool {
    p.area() * FAIR < p.e1.length() * p.e2.length()
}

fn halves(p: &Plate) -> [Plate; 2] {
    let (c, _) = p.corners();
    if (c[2] - c[0]).length2() < (c[3] - c[1]).length2() {
        [Plate::triangle(c[0], c[1], c[2]), Plate::triangle(c[0], c[2], c[3])]
    } else {
        [Plate::triangle(c[0], c[1], c[3]), Plate::triangle(c[1], c[2], c[3])]
    }
}

/// Appends the pieces of `p`, of about edge `size`, with the orientation of `p`.
pub(super) fn pieces(p: &Plate, size: f64, rule: PatchRule, out: &mut Vec<Plate>) {
    let triangle = match rule {
        PatchRule::Edge | PatchRule::Voxels => triangle,
        PatchRule::Area => triangle_by_area,
    };
    match p.kind {
        PlateKind::Triangle => triangle(p, size, out),
        PlateKind::Parallelogram if skewed(p) && p.diameter() > size => {
            halves(p).iter().for_each(|t| triangle(t, size, out));
        }
        PlateKind::Parallelogram => {
            let (nu, nv) = (steps(p.e1.length(), size) as usize, steps(p.e2.length(), size) as usize);
            let (e1, e2) = (p.e1 / nu as f64, p.e2 / nv as f64);
            for i in 0..nu {
                for j in 0..nv {
                    out.push(Plate::parallelogram(p.at(i as f64 / nu as f64, j as f64 / nv as f64), e1, e2));
                }
            }
        }
    }
}

/// Parameters u and v at which the planes between voxels cut a rectangle along the axes, its ends included; `None` for any other plate. Pieces that
/// are shorter than a voxel are cut further down to the size of the surface, m, if it has one.
pub(super) fn by_voxels(p: &Plate, map: &Voxmap, size: Option<f64>) -> Option<[Vec<f64>; 2]> {
    let along = |e: Vec3| (0..3).find(|&k| e.length() - e[k].abs() <= 1e-12 * e.length());
    let (a, b) = (along(p.e1)?, along(p.e2)?);
    let cuts = |e: Vec3, k: usize| {
        let parameter = |i: usize| (map.min()[k] + i as f64 * map.cell()[k] - p.origin[k]) / e[k];
        let slack = 1e-6 * map.cell()[k] / e[k].abs();
        let inside = (0..=map.dims()[k]).map(parameter).filter(|t| (slack..1.0 - slack).contains(t));
        let mut all: Vec<f64> = [0.0, 1.0].into_iter().chain(inside).collect();
        all.sort_by(f64::total_cmp);
        let Some(size) = size else { return all };
        let mut out = vec![0.0];
        for w in all.windows(2) {
            let length = (w[1] - w[0]) * e[k].abs();
            let n = if length < map.cell()[k] * (1.0 - 1e-6) { steps(length, size) } else { 1.0 };
            // More are refused by their number.
            let n = n.min(super::MAX_PATCHES as f64 + 1.0);
            out.extend((1..=n as usize).map(|i| w[0] + (w[1] - w[0]) * (i as f64 / n)));
        }
        out
    };
    (p.kind == PlateKind::Parallelogram && a != b).then(|| [cuts(p.e1, a), cuts(p.e2, b)])
}

/// Appends the pieces of `p` between these parameters.
pub(super) fn between(p: &Plate, [u, v]: &[Vec<f64>; 2], out: &mut Vec<Plate>) {
    for s in u.windows(2) {
        for t in v.windows(2) {
            out.push(Plate::parallelogram(p.at(s[0], t[0]), p.e1 * (s[1] - s[0]), p.e2 * (t[1] - t[0])));
        }
    }
}

fn triangle(p: &Plate, size: f64, out: &mut Vec<Plate>) {
    let (edge, turned) = longest(p);
    let area2 = 2.0 * p.area();
    let n = steps(area2.sqrt().max(edge * std::f64::consts::FRAC_1_SQRT_2), size);
    if n <= 1.0 {
        out.push(*p);
    } else if edge * edge > FAIR * area2 {
        halved(&turned).iter().for_each(|t| triangle(t, size, out));
    } else {
        congruent(p, n as usize, out);
    }
}

fn triangle_by_area(p: &Plate, size: f64, out: &mut Vec<Plate>) {
    let (edge, turned) = longest(p);
    let n = steps(p.area().sqrt(), size);
    if n <= 1.0 && edge <= LONG * size {
        out.push(*p);
    } else if p.area() <= 2.0 * size * size || edge * edge > 2.0 * FAIR * p.area() {
        halved(&turned).iter().for_each(|t| triangle_by_area(t, size, out));
    } else {
        congruent(p, n as usize, out);
    }
}

/// The halves of a triangle whose longest edge is opposite to its origin.
fn halved(turned: &Plate) -> [Plate; 2] {
    let (c, _) = turned.corners();
    let middle = (c[1] + c[2]) * 0.5;
    [Plate::triangle(c[0], c[1], middle), Plate::triangle(c[0], middle, c[2])]
}

fn congruent(p: &Plate, n: usize, out: &mut Vec<Plate>) {
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

    fn cut(p: &Plate, size: f64) -> Vec<Plate> {
        cut_by(p, size, PatchRule::Edge)
    }

    fn cut_by(p: &Plate, size: f64, rule: PatchRule) -> Vec<Plate> {
        let mut out = Vec::new();
        pieces(p, size, rule, &mut out);
        let area: f64 = out.iter().map(Plate::area).sum();
        assert!((area / p.area() - 1.0).abs() < 1e-12);
        assert!(out.iter().all(|q| (q.normal() - p.normal()).length() < 1e-9));
        let guess = estimate(p, size, rule);
        assert!(
            guess <= 2.0 * out.len() as f64 && out.len() as f64 <= 4.0 * guess,
            "{guess} for {}",
            out.len()
        );
        out
    }

    #[test]
    fn plates_are_cut_no_finer_than_asked() {
        let square = Plate::parallelogram(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        assert_eq!(cut(&square, 0.1).len(), 100);
        assert_eq!(cut(&square, 3.0).len(), 1);
        let half = Plate::triangle(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        assert_eq!(cut(&half, 0.1).len(), 100);
        assert_eq!(cut(&half, 1.0).len(), 1);
    }

    #[test]
    fn needles_are_cut_along_their_length() {
        for apex in [0.0, 0.2, 5.0, 10.0] {
            let needle = Plate::triangle(Vec3::ZERO, vec3(10.0, 0.0, 0.0), vec3(apex, 0.01, 0.0));
            let cut = cut(&needle, 1.0);
            assert!((8..=32).contains(&cut.len()), "{}", cut.len());
            assert!(cut.iter().all(|p| p.diameter() < 1.5));
        }
    }

    #[test]
    fn by_area_triangles_stay_whole_up_to_their_area_and_six_sizes() {
        let corner = |x: f64, y: f64| Plate::triangle(Vec3::ZERO, vec3(x, 0.0, 0.0), vec3(0.0, y, 0.0));
        for (x, y, n) in [(1.4, 1.4, 1), (1.9, 1.9, 2), (3.0, 3.0, 9), (2.8, 0.1, 1), (11.0, 0.01, 3)] {
            let cut = cut_by(&corner(x, y), 1.0, PatchRule::Area);
            assert_eq!(cut.len(), n, "{x} {y}");
            assert!(cut.iter().all(|p| p.area() <= 1.0 + 1e-9 && p.diameter() <= LONG));
        }
    }
}
