//! View factors of convex polygons that hide each other: exact views from points, integrated adaptively over each polygon.
//!
//! ```text
//! F_ij = 1/(π A_i) ∫_i ω⊥_j(x) dA,      ω⊥ = ½ Σ_k γ_k n·ν_k over the edges of the visible pieces (Lambert)
//! ```
//!
//! From a point x the pieces of polygon j that are visible are polygon j, cut to the front of i, minus the cone of every other polygon's part between
//! x and the plane of j. The sky (above the horizon) and the ground are the faces of a large cube about x. Facets exchange with their fronts and hide
//! with both sides.
//!
//! The integral divides i into triangles. Each has two rules, of seven points (degree 5) and of six (degree 4). The value of a triangle is the sum of
//! the first rule over its four quarters. Three differences estimate its error, and the largest counts: that sum from the rule on the whole, and
//! the two rules from each other, on the whole and in the quarters. Over a kink one difference may vanish by chance, hardly all three.
//! Large triangles are divided first, then the one with the largest error. All factors of a row share the points. Where another polygon touches
//! or crosses i the view jumps, where one is seen edge-on it bends: i is cut there first.

use crate::numerics::estimate_heap::Largest;
use std::collections::BinaryHeap;
use std::f64::consts::PI;
use zonal_math::{Vec3, vec3};

/// Distance relative to the size of the scene below which points lie in a plane.
const RELATIVE_CONTACT: f64 = 1e-10;
/// Factor on the differences in the error: over a kink rules may agree by chance.
const ERROR_SHARE: f64 = 4.0;
/// Parts of a facet, at most, into which planes cut it.
const MAX_PARTS: usize = 24;
/// Largest triangle, relative to the facet, whose error estimate is trusted: the points of a larger one may all miss a lit part.
const LARGEST_PART: f64 = 1.0 / 32.0;
/// Rules on triangles: weight of the centre; barycentric coordinate, met twice, and weight of each three points. Radon (1948), degree 5.
const RADON_CENTRE: f64 = 9.0 / 40.0;
const RADON_ORBITS: [(f64, f64); 2] = [
    (0.101_286_507_323_456_34, 0.125_939_180_544_827_15),
    (0.470_142_064_105_115_1, 0.132_394_152_788_506_2),
];
/// Six points, degree 4 (Dunavant 1985).
const SIX_POINT_ORBITS: [(f64, f64); 2] =
    [(0.445_948_490_915_965, 0.223_381_589_678_011), (0.091_576_213_509_771, 0.109_951_743_655_322)];
/// Half the edge of the cube of the surroundings, relative to the size of the scene.
const CUBE_SIZE: f64 = 1e6;

/// Polygons with an area, counter-clockwise from their fronts; some of them only hide.
#[derive(Clone, Debug)]
pub struct VisibleScene {
    polygons: Vec<FlatPolygon>,
    /// Polygons that exchange; the others only hide.
    facets: usize,
    size: f64,
}

#[derive(Clone, Debug)]
struct FlatPolygon {
    corners: Vec<Vec3>,
    normal: Vec3,
    area: f64,
    /// The facet of which it is an image.
    facet: usize,
}

/// A factor and an estimate of its error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OracleFactor {
    /// The factor.
    pub value: f64,
    /// Its error.
    pub error: f64,
}

impl OracleFactor {
    /// The error contains a `difference` from another value, of `error`, that the two errors do not explain.
    fn contain(&mut self, difference: f64, error: f64) {
        if difference.abs() > self.error + error {
            self.error = difference.abs() + error;
        }
    }
}

/// The factors of one facet.
#[derive(Clone, Debug)]
pub struct OracleRow {
    /// To each facet.
    pub facets: Vec<OracleFactor>,
    /// To the directions above the horizon (z up) that meet nothing.
    pub sky: OracleFactor,
    /// To those below.
    pub ground: OracleFactor,
}

impl FlatPolygon {
    fn new(corners: Vec<Vec3>, facet: usize) -> FlatPolygon {
        let twice = (2..corners.len())
            .fold(Vec3::ZERO, |s, k| s + (corners[k - 1] - corners[0]).cross(corners[k] - corners[0]));
        FlatPolygon { normal: twice.normalized(), area: 0.5 * twice.length(), corners, facet }
    }

    fn height(&self, x: Vec3) -> f64 {
        self.normal.dot(x - self.corners[0])
    }

    /// True if a part of this polygon lies in the plane of `o`, within its outline, and another one in front of it.
    fn meets(&self, o: &FlatPolygon, contact: f64) -> bool {
        let heights: Vec<f64> = self.corners.iter().map(|c| o.height(*c)).collect();
        if heights.iter().all(|h| *h <= contact) || heights.iter().all(|h| *h > contact) {
            return false;
        }
        let n = heights.len();
        let mut common = Vec::new();
        for (k, c) in self.corners.iter().enumerate() {
            let (h, g, d) = (heights[k], heights[(k + 1) % n], self.corners[(k + 1) % n]);
            if h.abs() <= contact {
                common.push(*c);
            }
            if h * g < 0.0 {
                common.push(*c + (d - *c) * (h / (h - g)));
            }
        }
        // Beside an edge of the other one nothing of it is met.
        !common.is_empty()
            && (0..o.corners.len()).all(|k| {
                let (a, b) = (o.corners[k], o.corners[(k + 1) % o.corners.len()]);
                let inward = o.normal.cross(b - a).normalized();
                common.iter().any(|x| inward.dot(*x - a) > contact)
            })
    }
}

impl VisibleScene {
    /// A scene of facets and of polygons that only hide.
    pub fn new(facets: &[Vec<Vec3>], obstructions: &[Vec<Vec3>]) -> VisibleScene {
        let n = facets.len();
        let number = |k: usize| if k < n { k } else { usize::MAX };
        let polygons: Vec<FlatPolygon> = facets
            .iter()
            .chain(obstructions)
            .enumerate()
            .map(|(k, c)| FlatPolygon::new(c.clone(), number(k)))
            .collect();
        let corners = || polygons.iter().flat_map(|p| &p.corners);
        let lo = corners().fold(Vec3::splat(f64::INFINITY), |s, c| s.min(*c));
        let hi = corners().fold(Vec3::splat(f64::NEG_INFINITY), |s, c| s.max(*c));
        VisibleScene { facets: n, size: (hi - lo).length(), polygons }
    }

    /// Area of a facet, m².
    ///
    /// # Panics
    /// On an index out of range.
    pub fn area(&self, i: usize) -> f64 {
        self.polygons[i].area
    }

    /// The factors of all facets, as by [`VisibleScene::row`]. Two rows state each exchange between facets: where they contradict each other, both
    /// errors contain the difference and the other error. So do the errors of the surroundings with the sum of a row.
    pub fn rows(&self, tolerance: f64, triangles: usize) -> Vec<OracleRow> {
        let rows: Vec<OracleRow> = (0..self.facets).map(|i| self.row(i, tolerance, triangles)).collect();
        let mut checked = rows.clone();
        for (i, row) in checked.iter_mut().enumerate() {
            let mut sum = OracleFactor::default();
            for j in (0..self.facets).filter(|j| *j != i) {
                let (back, scale) = (rows[j].facets[i], self.area(j) / self.area(i));
                let difference = row.facets[j].value - back.value * scale;
                sum.value += difference;
                sum.error += back.error * scale;
                row.facets[j].contain(difference, back.error * scale);
            }
            for f in [&mut row.sky, &mut row.ground] {
                f.contain(sum.value, sum.error);
            }
        }
        checked
    }

    /// The factors of facet `i`, until the error of each is at most `tolerance` or `triangles` were divided.
    ///
    /// # Panics
    /// On an index out of range.
    pub fn row(&self, i: usize, tolerance: f64, triangles: usize) -> OracleRow {
        let scale = 1.0 / (PI * self.polygons[i].area);
        let mut parts: BinaryHeap<Largest<DividedTriangle>> = BinaryHeap::new();
        let count = self.facets + 2;
        let mut errors = vec![0.0; count];
        let add = |t: [Vec3; 3], whole: Option<[Vec<f64>; 2]>, errors: &mut Vec<f64>| {
            let (is_coarse, item) = self.divided(i, t, whole);
            errors.iter_mut().zip(&item.error).for_each(|(s, e)| *s += e);
            let worst = item.error.iter().fold(0.0f64, |s, e| s.max(*e));
            Largest { key: if is_coarse { f64::INFINITY } else { worst }, item }
        };
        for t in self.smooth_parts(i) {
            parts.push(add(t, None, &mut errors));
        }
        for _ in 0..triangles {
            let is_coarse = parts.peek().is_some_and(|p| p.key == f64::INFINITY);
            if !is_coarse && errors.iter().all(|e| e * scale <= tolerance) {
                break;
            }
            let Some(Largest { item, .. }) = parts.pop() else { break };
            errors.iter_mut().zip(&item.error).for_each(|(s, e)| *s -= e);
            for (q, sum) in item.quarters.into_iter().zip(item.sums) {
                parts.push(add(q, Some(sum), &mut errors));
            }
        }
        // The heap's order is no order of summation.
        let sum = |of: &dyn Fn(&DividedTriangle) -> f64| {
            let mut all: Vec<f64> = parts.iter().map(|p| of(&p.item)).collect();
            all.sort_by(f64::total_cmp);
            all.iter().sum::<f64>() * scale
        };
        let rounding = 1e-12;
        let error = |k: usize| ERROR_SHARE * sum(&|p| p.error[k]) + rounding;
        let factor = |k: usize| OracleFactor { value: sum(&|p| p.value[k]), error: error(k) };
        OracleRow {
            facets: (0..self.facets).map(factor).collect(),
            sky: factor(self.facets),
            ground: factor(self.facets + 1),
        }
    }

    /// A triangle of facet `i` with its integrals, and whether it is larger than those whose error is trusted; `whole` holds the integrals of both rules.
    fn divided(&self, i: usize, t: [Vec3; 3], whole: Option<[Vec<f64>; 2]>) -> (bool, DividedTriangle) {
        let whole = whole.unwrap_or_else(|| self.integral(i, &t));
        let quarters = quarters(&t);
        let sums: Vec<[Vec<f64>; 2]> = quarters.iter().map(|q| self.integral(i, q)).collect();
        let total = |rule: usize, k: usize| sums.iter().map(|s| s[rule][k]).sum::<f64>();
        let value: Vec<f64> = (0..self.facets + 2).map(|k| total(0, k)).collect();
        let error = |k: usize| {
            let of_whole = (value[k] - whole[0][k]).abs().max((whole[0][k] - whole[1][k]).abs());
            of_whole.max((value[k] - total(1, k)).abs())
        };
        let error = (0..value.len()).map(error).collect();
        let area = triangle_area(&t);
        (area > LARGEST_PART * self.polygons[i].area, DividedTriangle { quarters, sums, value, error })
    }

    /// Facet `i` in triangles, cut along the polygons that touch or cross it, then along the planes of others, which are seen edge-on from there.
    fn smooth_parts(&self, i: usize) -> Vec<[Vec3; 3]> {
        let (own, contact) = (&self.polygons[i], RELATIVE_CONTACT * self.size);
        let mut parts = vec![own.corners.clone()];
        let in_front = |p: &&FlatPolygon| p.corners.iter().any(|c| own.height(*c) > contact);
        let (touching, others): (Vec<_>, Vec<_>) =
            self.polygons.iter().filter(in_front).partition(|p| p.meets(own, contact));
        for p in touching.into_iter().chain(others) {
            if parts.len() >= MAX_PARTS {
                break;
            }
            let level = p.normal.dot(p.corners[0]);
            let sides = |c: &Vec<Vec3>| {
                let heights = || c.iter().map(|x| p.height(*x));
                if heights().all(|h| h >= -contact) || heights().all(|h| h <= contact) {
                    return vec![c.clone()];
                }
                let both = [clipped(c, p.normal, level), clipped(c, -p.normal, -level)];
                both.into_iter().flatten().collect()
            };
            parts = parts.iter().flat_map(sides).collect();
        }
        parts.iter().flat_map(|c| (2..c.len()).map(|k| [c[0], c[k - 1], c[k]])).collect()
    }

    /// ∫ ω⊥ dA over a triangle by both rules, for every facet, the sky and the ground.
    fn integral(&self, i: usize, t: &[Vec3; 3]) -> [Vec<f64>; 2] {
        let area = triangle_area(t);
        let rule = |centre: f64, orbits: [(f64, f64); 2]| {
            let mut sum = vec![0.0; self.facets + 2];
            if centre > 0.0 {
                self.add_views(i, (t[0] + t[1] + t[2]) * (1.0 / 3.0), centre * area, &mut sum);
            }
            for (share, weight) in orbits {
                for k in 0..3 {
                    let x = t[k] * (1.0 - 2.0 * share) + (t[(k + 1) % 3] + t[(k + 2) % 3]) * share;
                    self.add_views(i, x, weight * area, &mut sum);
                }
            }
            sum
        };
        [rule(RADON_CENTRE, RADON_ORBITS), rule(0.0, SIX_POINT_ORBITS)]
    }

    /// Adds weight × ω⊥ from a point of facet `i`.
    fn add_views(&self, i: usize, x: Vec3, weight: f64, sum: &mut [f64]) {
        let n = self.polygons[i].normal;
        let contact = RELATIVE_CONTACT * self.size;
        // All relative to x, in front of i.
        let before: Vec<Option<Vec<Vec3>>> = self
            .polygons
            .iter()
            .enumerate()
            .map(|(k, p)| {
                let corners: Vec<Vec3> = p.corners.iter().map(|c| *c - x).collect();
                let above = corners.iter().any(|c| n.dot(*c) > contact);
                (k != i && above).then(|| clipped(&corners, n, 0.0)).flatten()
            })
            .collect();
        let cones: Vec<Vec<Vec3>> = before.iter().map(|b| b.as_deref().map_or_else(Vec::new, cone)).collect();
        for (j, target) in self.polygons.iter().enumerate().filter(|(_, p)| p.facet != usize::MAX) {
            if target.height(x) <= contact {
                continue;
            }
            let Some(piece) = &before[j] else { continue };
            let plane = (target.normal, target.normal.dot(target.corners[0] - x));
            let visible = visible(piece.clone(), &before, &cones, Some((j, plane)), contact);
            let seen: f64 = visible.iter().map(|p| projected(p, n)).sum();
            sum[target.facet] += weight * seen.abs();
        }
        for (region, direction) in self.surroundings() {
            let Some(piece) = clipped(&direction, n, 0.0) else { continue };
            let visible = visible(piece, &before, &cones, None, contact);
            let seen: f64 = visible.iter().map(|p| projected(p, n)).sum();
            sum[self.facets + region] += weight * seen.abs();
        }
    }

    /// Faces of a large cube as directions: 0 the sky, 1 the ground.
    fn surroundings(&self) -> Vec<(usize, Vec<Vec3>)> {
        let r = CUBE_SIZE * self.size;
        let corner = |x: f64, y: f64, z: f64| vec3(x, y, z) * r;
        let mut all = vec![
            (
                0,
                [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].map(|(x, y)| corner(x, y, 1.0)).to_vec(),
            ),
            (
                1,
                [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)]
                    .map(|(x, y)| corner(x, y, -1.0))
                    .to_vec(),
            ),
        ];
        let sides = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
        for k in 0..4 {
            let (p, q) = (sides[k], sides[(k + 1) % 4]);
            for (region, low, high) in [(0, 0.0, 1.0), (1, -1.0, 0.0)] {
                let corners = [(p, low), (q, low), (q, high), (p, high)];
                all.push((region, corners.map(|((x, y), z)| corner(x, y, z)).to_vec()));
            }
        }
        all
    }
}

/// The pieces of a polygon (relative to the point of view) that no other one, with its cone, hides.
fn visible(
    whole: Vec<Vec3>,
    before: &[Option<Vec<Vec3>>],
    cones: &[Vec<Vec3>],
    target: Option<(usize, (Vec3, f64))>,
    contact: f64,
) -> Vec<Vec<Vec3>> {
    let mut pieces = vec![whole];
    for (k, o) in before.iter().enumerate() {
        let Some(o) = o else { continue };
        // No piece is larger than the whole: a cone beside it hides nothing.
        let is_beside = |planes: &[Vec3]| {
            planes.is_empty() || planes.iter().any(|n| pieces.iter().flatten().all(|p| n.dot(*p) <= 0.0))
        };
        if pieces.is_empty() || is_beside(&cones[k]) {
            continue;
        }
        let own;
        let planes = match target {
            None => &cones[k],
            Some((j, _)) if j == k => continue,
            // The origin lies on the side of n·y = c of which it is in front: c < 0.
            Some((_, (normal, c))) => {
                let heights = || o.iter().map(|y| normal.dot(*y) - c);
                if heights().all(|h| h <= contact) {
                    continue;
                }
                if heights().all(|h| h >= 0.0) {
                    &cones[k]
                } else {
                    let Some(part) = clipped(o, normal, c) else { continue };
                    own = cone(&part);
                    &own
                }
            }
        };
        if !planes.is_empty() {
            pieces = pieces.into_iter().flat_map(|p| outside(p, planes)).collect();
        }
    }
    pieces
}

struct DividedTriangle {
    quarters: [[Vec3; 3]; 4],
    sums: Vec<[Vec<f64>; 2]>,
    value: Vec<f64>,
    error: Vec<f64>,
}

fn triangle_area([a, b, c]: &[Vec3; 3]) -> f64 {
    0.5 * (*b - *a).cross(*c - *a).length()
}

fn quarters([a, b, c]: &[Vec3; 3]) -> [[Vec3; 3]; 4] {
    let (p, q, r) = ((*a + *b) * 0.5, (*b + *c) * 0.5, (*c + *a) * 0.5);
    [[*a, p, r], [p, *b, q], [r, q, *c], [p, q, r]]
}

/// The part of a convex polygon with n·y ≥ c.
fn clipped(polygon: &[Vec3], n: Vec3, c: f64) -> Option<Vec<Vec3>> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, p) in polygon.iter().enumerate() {
        let q = polygon[(k + 1) % polygon.len()];
        let (h, g) = (n.dot(*p) - c, n.dot(q) - c);
        if h >= 0.0 {
            kept.push(*p);
        }
        if h * g < 0.0 {
            kept.push(*p + (q - *p) * (h / (h - g)));
        }
    }
    (kept.len() >= 3).then_some(kept)
}

/// The planes through the origin and the edges of a convex polygon, with the polygon on the positive side; none for one seen edge-on.
fn cone(polygon: &[Vec3]) -> Vec<Vec3> {
    let middle = polygon.iter().fold(Vec3::ZERO, |s, p| s + *p) / polygon.len() as f64;
    let edges = (0..polygon.len()).map(|k| polygon[k].cross(polygon[(k + 1) % polygon.len()]));
    let planes: Vec<Vec3> = edges.map(Vec3::normalized).filter(|n| n.length2() > 0.5).collect();
    let distance = middle.length();
    let inside = |n: &Vec3| n.dot(middle) / distance;
    let sign = if planes.iter().map(inside).sum::<f64>() >= 0.0 { 1.0 } else { -1.0 };
    let planes: Vec<Vec3> = planes.into_iter().map(|n| n * sign).collect();
    let is_edge_on = planes.iter().all(|n| inside(n).abs() < 1e-13);
    if is_edge_on || planes.len() < 3 { Vec::new() } else { planes }
}

/// A convex polygon minus a cone.
fn outside(polygon: Vec<Vec3>, planes: &[Vec3]) -> Vec<Vec<Vec3>> {
    if planes.iter().any(|n| polygon.iter().all(|p| n.dot(*p) <= 0.0)) {
        return vec![polygon];
    }
    let (mut out, mut rest) = (Vec::new(), polygon);
    for n in planes {
        out.extend(clipped(&rest, -*n, 0.0).filter(|p| p.iter().any(|x| n.dot(*x) < 0.0)));
        match clipped(&rest, *n, 0.0) {
            Some(inside) => rest = inside,
            None => break,
        }
    }
    out
}

/// ω⊥ of a convex polygon from the origin for the normal n; its sign is that of the orientation.
fn projected(polygon: &[Vec3], n: Vec3) -> f64 {
    let edge = |k: usize| {
        let (a, b) = (polygon[k], polygon[(k + 1) % polygon.len()]);
        let c = a.cross(b);
        let sine = c.length();
        if sine > 0.0 { sine.atan2(a.dot(b)) * n.dot(c) / sine } else { 0.0 }
    };
    0.5 * (0..polygon.len()).map(edge).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(z: f64, up: bool) -> Vec<Vec3> {
        let mut c = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| vec3(x, y, z)).to_vec();
        if !up {
            c.reverse();
        }
        c
    }

    #[test]
    fn opposite_squares_have_the_factor_of_the_catalogue_and_rows_close() {
        let scene = VisibleScene::new(&[square(0.0, true), square(1.0, false)], &[]);
        let row = scene.row(0, 1e-8, 2000);
        assert!((row.facets[1].value - 0.199_824_895_698_387_4).abs() < 1e-7, "{row:?}");
        assert!((row.facets[1].value + row.sky.value + row.ground.value - 1.0).abs() < 1e-7, "{row:?}");
        assert!(row.ground.value < 1e-9);
    }

    #[test]
    fn a_lit_part_that_one_row_misses_widens_the_errors_of_both() {
        // Plate 2 is close to a corner of plate 0. Row 2 alone is wrong by ten of its own errors; both rows at 1e-8 give 8.33528e-4.
        let mut rng = crate::Rng::new(6_120_937 * 1_000_003 + 580);
        let mesh = crate::random_meshes::RandomMesh::new(2, &mut rng);
        let scene = VisibleScene::new(&mesh.facets, &mesh.covers);
        let rows = scene.rows(2e-6, 625);
        let scale = scene.area(0) / scene.area(2);
        for (value, error) in [
            (rows[2].facets[0].value, rows[2].facets[0].error),
            (rows[0].facets[2].value * scale, rows[0].facets[2].error * scale),
        ] {
            assert!((value - 8.335_28e-4).abs() <= error, "{value:e} ± {error:e}");
            assert!(error > 1e-5, "{error:e}");
        }
    }

    #[test]
    fn a_screen_over_everything_leaves_the_sky_beside_it() {
        let screen =
            [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]].map(|[x, y]| vec3(x, y, 0.5)).to_vec();
        let scene = VisibleScene::new(&[square(0.0, true), square(1.0, false)], &[screen]);
        let row = scene.row(0, 1e-6, 500);
        assert!(row.facets[1].value < 1e-12 && row.sky.value < 0.01 && row.sky.value > 1e-4, "{row:?}");
    }
}
