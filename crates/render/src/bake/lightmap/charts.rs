//! Charts: coplanar sides of facets of one surface that share edges, in coordinates of their plane.
//!
//! A point of the plane has the coordinates (x, y) = ((p − o)·a, (p − o)·b), m, with a along an edge of a facet, the one whose bounding rectangle is smallest,
//! and the long side of the rectangle along a. The rectangle begins at (0, 0).

use std::collections::HashMap;
use zonal_math::Vec3;
use zonal_scene::{Plate, Scene, Solution};
use zonal_transport::patch_locator::{facet_sides, side_of_patch};

/// Largest angle between the normals of coplanar facets, rad.
const MAX_NORMAL_DIFFERENCE: f64 = 1e-6;
/// Distance over the scene's diagonal within which two corners are one.
const CORNER_TOLERANCE: f64 = 1e-8;
/// Most edges that are tried as the direction of a chart.
const MAX_TRIED_EDGES: usize = 64;

/// A chart.
#[derive(Clone, Debug)]
pub(super) struct FlatChart {
    /// The sides of facets, ascending: 2k is the front of facet k, 2k + 1 its back.
    pub sides: Vec<usize>,
    /// Unit normal of the side.
    pub normal: Vec3,
    origin: Vec3,
    axes: [Vec3; 2],
    /// Width and height of the bounding rectangle, m; the width is not the smaller one.
    pub extent: [f64; 2],
}

impl FlatChart {
    /// Coordinates of a point, m.
    pub(super) fn project(&self, p: Vec3) -> [f64; 2] {
        self.axes.map(|a| (p - self.origin).dot(a))
    }
    /// The point of the plane with these coordinates.
    pub(super) fn point(&self, [x, y]: [f64; 2]) -> Vec3 {
        self.origin + self.axes[0] * x + self.axes[1] * y
    }
}

/// The unit normal of a side of a facet.
pub(super) fn side_normal(scene: &Scene, side: usize) -> Vec3 {
    let normal = scene.facets()[side / 2].plate.normal();
    if side.is_multiple_of(2) { normal } else { -normal }
}

/// The charts of all sides of facets that have patches, in the order of their first sides.
pub(super) fn flat_charts(s: &Solution) -> Vec<FlatChart> {
    let plates = facet_sides(&s.scene);
    let mut has_patches = vec![false; plates.len()];
    s.zones.patches.iter().for_each(|p| has_patches[side_of_patch(&s.scene, p)] = true);
    let sides: Vec<usize> = (0..plates.len()).filter(|i| has_patches[*i]).collect();
    let mut parents: Vec<usize> = (0..plates.len()).collect();
    for list in sides_of_edges(&s.scene, &sides, &plates).into_values() {
        for (k, &i) in list.iter().enumerate() {
            for &j in list[k + 1..].iter().filter(|j| are_coplanar(&s.scene, i, **j)) {
                let (a, b) = (root(&mut parents, i), root(&mut parents, j));
                parents[a.max(b)] = a.min(b);
            }
        }
    }
    // The root of a chart is its first side.
    let mut chart_of_root = HashMap::new();
    let mut members: Vec<Vec<usize>> = Vec::new();
    for side in sides {
        let chart = *chart_of_root.entry(root(&mut parents, side)).or_insert(members.len());
        if chart == members.len() {
            members.push(Vec::new());
        }
        members[chart].push(side);
    }
    members.into_iter().map(|sides| flatten(&s.scene, sides)).collect()
}

/// The first side of the chart of side `i`.
fn root(parents: &mut [usize], mut i: usize) -> usize {
    while parents[i] != i {
        parents[i] = parents[parents[i]];
        i = parents[i];
    }
    i
}

/// A corner in steps of the tolerance.
type CornerKey = [i64; 3];

/// The sides at each edge, by its corners.
fn sides_of_edges(scene: &Scene, sides: &[usize], plates: &[Plate]) -> HashMap<[CornerKey; 2], Vec<usize>> {
    let step = (CORNER_TOLERANCE * scene.diagonal()).max(f64::MIN_POSITIVE);
    let key = |p: Vec3| p.array().map(|x| (x / step).round() as i64);
    let mut out: HashMap<[CornerKey; 2], Vec<usize>> = HashMap::new();
    for &side in sides {
        let (corners, n) = plates[side].corners();
        for k in 0..n {
            let mut edge = [key(corners[k]), key(corners[(k + 1) % n])];
            edge.sort_unstable();
            out.entry(edge).or_default().push(side);
        }
    }
    out
}

/// True for sides of one surface with one normal; sides that share an edge then lie in one plane.
fn are_coplanar(scene: &Scene, i: usize, j: usize) -> bool {
    let surface = |side: usize| scene.facets()[side / 2].surface;
    let (n, m) = (side_normal(scene, i), side_normal(scene, j));
    surface(i) == surface(j) && n.dot(m) > 0.0 && n.cross(m).length() < MAX_NORMAL_DIFFERENCE
}

/// The chart of coplanar sides.
fn flatten(scene: &Scene, sides: Vec<usize>) -> FlatChart {
    let normal = side_normal(scene, sides[0]);
    let corners: Vec<Vec3> = sides
        .iter()
        .flat_map(|side| {
            let (c, n) = scene.facets()[side / 2].plate.corners();
            c.into_iter().take(n)
        })
        .collect();
    let edges = sides.iter().flat_map(|side| {
        let plate = &scene.facets()[side / 2].plate;
        [plate.e1, plate.e2, plate.e2 - plate.e1]
    });
    let fits = edges.take(MAX_TRIED_EDGES).filter(|e| e.length2() > 0.0).map(|edge| {
        let a = edge.normalized();
        bounding_rectangle(&corners, [a, normal.cross(a)])
    });
    // The first of the smallest rectangles.
    let area = |r: &BoundingRectangle| r.extent[0] * r.extent[1];
    let best = fits.reduce(|best, r| if area(&r) < area(&best) * (1.0 - 1e-9) { r } else { best });
    let (a, b) = normal.frame();
    let r = best.unwrap_or_else(|| bounding_rectangle(&corners, [a, b]));
    FlatChart { sides, normal, origin: r.origin, axes: r.axes, extent: r.extent }
}

/// A rectangle around points in a plane.
struct BoundingRectangle {
    origin: Vec3,
    axes: [Vec3; 2],
    extent: [f64; 2],
}

/// The bounding rectangle of points along two axes, turned so that it is at least as wide as high.
fn bounding_rectangle(points: &[Vec3], axes: [Vec3; 2]) -> BoundingRectangle {
    let range = |a: Vec3| {
        points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), p| {
            let x = (*p - points[0]).dot(a);
            (lo.min(x), hi.max(x))
        })
    };
    let [(x0, x1), (y0, y1)] = axes.map(range);
    let [a, b] = axes;
    if x1 - x0 >= y1 - y0 {
        let origin = points[0] + a * x0 + b * y0;
        return BoundingRectangle { origin, axes, extent: [x1 - x0, y1 - y0] };
    }
    // A quarter turn: b becomes the first axis, −a the second.
    let origin = points[0] + b * y0 + a * x1;
    BoundingRectangle { origin, axes: [b, -a], extent: [y1 - y0, x1 - x0] }
}
