//! The polygons of a computation, prepared: facets, their tree with cones of normals, occluders with theirs.

pub(crate) mod blocking;
pub(crate) mod endless;
pub(crate) mod occluder_list;
pub(crate) mod occluders;

use crate::bounds::{Bounds, BoundsTree, TreeNode, ball_about_middle};
use crate::geometry::blocking::{Hull, Occluder};
use crate::geometry::endless::stretched;
use crate::geometry::occluders::{MergedOccluder, merged_occluders};
use crate::periods::PeriodicImages;
use zonal_exchange::polygon::PreparedPolygon;
use zonal_exchange::polygon::visible::ConvexPolygon;
use zonal_math::Vec3;

/// Facets in a leaf of the tree.
const FACETS_PER_LEAF: usize = 4;
/// Half-angle of a cone of normals, rad, below which its facets are parallel.
const PARALLEL_HALF_ANGLE: f64 = 1e-9;
/// Unit roundoff of a coordinate in single precision, relative.
const SINGLE_PRECISION: f64 = 1.2e-7;
/// Distance in m below which a coordinate counts as stored in single precision: six decimals in text.
const SINGLE_PRECISION_TEXT: f64 = 6e-7;
/// Contact distance of coordinates in double precision, relative to the extent.
const DOUBLE_PRECISION_CONTACT: f64 = 1e-11;

/// A facet ready for pairs.
#[derive(Clone, Debug)]
pub(crate) struct PreparedFacet {
    pub prepared: PreparedPolygon,
    pub bounds: Bounds,
    pub centre: Vec3,
    pub radius: f64,
}

impl PreparedFacet {
    fn new(polygon: ConvexPolygon) -> PreparedFacet {
        let c = polygon.corners();
        let (centre, radius) = ball_about_middle(c);
        PreparedFacet { bounds: Bounds::of(c), centre, radius, prepared: PreparedPolygon::new(polygon) }
    }

    pub(crate) fn polygon(&self) -> &ConvexPolygon {
        self.prepared.polygon()
    }

    pub(crate) fn hull(&self) -> Hull<'_> {
        Hull { middle: self.centre, corners: self.polygon().corners() }
    }
}

/// The normals of a node's facets: all within `half_angle` of `axis`; the facets lie at n·x ≥ `offset` along the axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NormalCone {
    axis: Vec3,
    half_angle: f64,
    offset: f64,
}

/// Facets and occluders with their trees.
#[derive(Debug)]
pub(crate) struct Geometry {
    pub facets: Vec<PreparedFacet>,
    pub tree: BoundsTree,
    pub cones: Vec<NormalCone>,
    /// The occluders of one image.
    merged: Vec<MergedOccluder>,
    /// The occluders of all images.
    pub occluders: Vec<Occluder>,
    /// Their trees, by the axes along which they are endless, as bits.
    pub occluder_trees: [BoundsTree; 4],
    /// Distance below which polygons count as touching, m.
    pub contact: f64,
}

impl Geometry {
    /// Prepares facets, and obstructions that only hide, in the images of [`Geometry::set_images`].
    pub(crate) fn new(facets: &[ConvexPolygon], obstructions: &[ConvexPolygon]) -> Geometry {
        let all: Vec<&ConvexPolygon> = facets.iter().chain(obstructions).collect();
        let contact = contact_distance(&all);
        let merged = merged_occluders(&all, contact);
        let facets: Vec<PreparedFacet> = facets.iter().cloned().map(PreparedFacet::new).collect();
        let boxes: Vec<Bounds> = facets.iter().map(|f| f.bounds).collect();
        let groups: Vec<u8> = facets.iter().map(|f| face_of_cube(f.polygon().normal())).collect();
        let tree = BoundsTree::new(&boxes, &groups, FACETS_PER_LEAF);
        let cones = tree.nodes.iter().map(|n| NormalCone::of(&facets, items(&tree, n))).collect();
        let empty = || BoundsTree { nodes: Vec::new(), order: Vec::new() };
        let occluder_trees = [empty(), empty(), empty(), empty()];
        Geometry { facets, tree, cones, merged, occluders: Vec::new(), occluder_trees, contact }
    }

    /// The axes along which the images of every occluder adjoin.
    pub(crate) fn endless_axes(&self, images: &PeriodicImages) -> [bool; 2] {
        let all = self.merged.iter().fold(3, |all, o| all & stretched(o, images, self.contact).1);
        [all & 1 != 0, all & 2 != 0]
    }

    /// Makes the occluders those of all images.
    pub(crate) fn set_images(&mut self, images: &PeriodicImages) {
        let made: Vec<(MergedOccluder, u8)> =
            self.merged.iter().map(|o| stretched(o, images, self.contact)).collect();
        let trees: Vec<u8> = made.iter().map(|m| m.1).collect();
        self.occluders = made.into_iter().map(|m| Occluder::new(m.0)).collect();
        self.occluder_trees = std::array::from_fn(|k| {
            let members: Vec<u32> =
                (0..trees.len() as u32).filter(|o| usize::from(trees[*o as usize]) == k).collect();
            let boxes: Vec<Bounds> = members.iter().map(|o| self.occluders[*o as usize].bounds).collect();
            let mut tree = BoundsTree::new(&boxes, &vec![0; boxes.len()], 1);
            tree.order.iter_mut().for_each(|o| *o = members[*o as usize]);
            tree
        });
    }

    /// The facets of a node.
    pub(crate) fn facets_of(&self, node: u32) -> &[u32] {
        items(&self.tree, &self.tree.nodes[node as usize])
    }

    pub(crate) fn node(&self, node: u32) -> &TreeNode {
        &self.tree.nodes[node as usize]
    }

    /// True if occluder `k`, displaced by `shift`, hides all points of `to` (weight 1) or all its directions (weight 0) from all points of
    /// `from`.
    pub(crate) fn hides(&self, k: usize, from: Hull, to: Hull, weight: f64, shift: Vec3) -> bool {
        self.occluders[k].hides(from, to, weight, shift, self.contact)
    }

    /// False if no facet of node `a` can see any point of `b`.
    pub(crate) fn may_face(&self, a: u32, b: &Bounds) -> bool {
        let (cone, from) = (&self.cones[a as usize], self.node(a).bounds);
        if cone.half_angle <= PARALLEL_HALF_ANGLE {
            return b.support(cone.axis) > cone.offset + self.contact;
        }
        let (d, reach) = (b.centre() - from.centre(), b.radius() + from.radius());
        let distance = d.length();
        if distance <= reach {
            return true;
        }
        let angle = (cone.axis.dot(d) / distance).clamp(-1.0, 1.0).acos();
        angle - cone.half_angle - (reach / distance).asin() < std::f64::consts::FRAC_PI_2
    }

    /// False if no facet of node `a` can see any of the directions.
    pub(crate) fn may_face_directions(&self, a: u32, directions: &[Vec3]) -> bool {
        let cone = &self.cones[a as usize];
        let widest = |d: &Vec3| (cone.axis.dot(*d) / d.length()).clamp(-1.0, 1.0).acos() - cone.half_angle;
        // A cell of a quarter of a cube's face spans less than its corners' angle: corners decide for parallel facets, a margin for others.
        let margin = if cone.half_angle <= PARALLEL_HALF_ANGLE { 0.0 } else { CELL_MARGIN };
        directions.iter().any(|d| widest(d) - margin < std::f64::consts::FRAC_PI_2)
    }
}

/// Angle in rad by which a point of a direction cell may be nearer to an axis than its corners.
const CELL_MARGIN: f64 = 0.5;

fn items<'a>(tree: &'a BoundsTree, node: &TreeNode) -> &'a [u32] {
    &tree.order[node.first as usize..(node.first + node.count) as usize]
}

impl NormalCone {
    fn of(facets: &[PreparedFacet], items: &[u32]) -> NormalCone {
        let normals = || items.iter().map(|k| facets[*k as usize].polygon().normal());
        let first = normals().next().unwrap_or(Vec3::ZERO);
        let parallel =
            normals().all(|n| n.dot(first) >= 1.0 - 1e-15 && n.cross(first).length() < PARALLEL_HALF_ANGLE);
        let axis = if parallel { first } else { normals().fold(Vec3::ZERO, |s, n| s + n).normalized() };
        let half_angle = if parallel {
            0.0
        } else if axis.length() < 0.5 {
            std::f64::consts::PI
        } else {
            normals().fold(0.0f64, |s, n| s.max(axis.dot(n).clamp(-1.0, 1.0).acos())) + 1e-7
        };
        let corners = items.iter().flat_map(|k| facets[*k as usize].polygon().corners());
        let offset = corners.fold(f64::INFINITY, |s, c| s.min(axis.dot(*c)));
        NormalCone { axis, half_angle, offset }
    }
}

/// The face of a cube that a direction points to, 0 to 5.
fn face_of_cube(n: Vec3) -> u8 {
    let a = n.array();
    let axis = (0..3).max_by(|i, j| a[*i].abs().total_cmp(&a[*j].abs())).unwrap_or(0);
    2 * axis as u8 + u8::from(a[axis] < 0.0)
}

/// The distance below which polygons of these coordinates count as touching, m: two roundings of the largest coordinate where all are stored in
/// single precision, else a tiny share of the extent.
pub(crate) fn contact_distance(polygons: &[&ConvexPolygon]) -> f64 {
    let coordinates = || polygons.iter().flat_map(|p| p.corners()).flat_map(|c| c.array());
    let largest = coordinates().fold(0.0f64, |s, x| s.max(x.abs()));
    let single = coordinates()
        .all(|x| (x - f64::from(x as f32)).abs() <= SINGLE_PRECISION_TEXT.min(SINGLE_PRECISION * x.abs()));
    if single { 2.0 * SINGLE_PRECISION * largest } else { DOUBLE_PRECISION_CONTACT * largest }
}

impl PreparedFacet {
    /// The facet displaced.
    pub(crate) fn shifted(&self, by: Vec3) -> PreparedFacet {
        PreparedFacet::new(self.polygon().translated(by).unwrap_or_else(|| self.polygon().clone()))
    }
}
