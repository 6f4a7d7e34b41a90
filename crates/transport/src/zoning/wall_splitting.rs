//! Splitting of patches along the walls that stand on them.
//!
//! A facet g divides a patch p when it reaches to the front of p's plane and the segment g ∩ plane(p), its foot, runs through the
//! interior of p. Every piece that the foot runs through is then split along the foot's line, so that no piece has a wall in its
//! middle. A facet that lies close in front of p (a lamp under a ceiling, a carpet on a floor) divides it along its outline; the
//! part under its black back is not a zone. Small parts are split off only where one part is hidden and the other is not: the
//! visible strip of a patch behind a column is a zone of its own, however narrow.
//!
//! Panes and sheets that transmit divide a patch in the same way, at any distance from its edge: the part on their other side stands in other light, and a mean
//! over both would carry it through the glass. Glass seldom touches its frame exactly, so that a pane stands on a patch from which it is less than the distance
//! of contact.

use crate::intersect::PreparedPlate;
use crate::transport::{Hit, Transport};
use zonal_math::Vec3;
use zonal_scene::{Plate, PlateKind, Sides};

/// Smallest piece that a wall splits off, as a fraction of the patch's area.
const MIN_PIECE_SHARE_AT_WALL: f64 = 2e-3;
/// Smallest piece that the outline of a facet in contact splits off, as a fraction of the patch's area.
const MIN_PIECE_SHARE_AT_OUTLINE: f64 = 0.04;
/// Smallest piece that a pane or a sheet that transmits splits off, as a fraction of the patch's area.
const MIN_PIECE_SHARE_AT_GLASS: f64 = 1e-4;
/// Smallest piece that is split off where one part is mostly hidden and the other is not, as a fraction of the patch's area.
const MIN_PIECE_SHARE_IF_HIDDEN: f64 = 1e-3;
/// Difference of the hidden fractions of two parts from which they count as hidden and visible.
const HIDDEN_SHARE_DIFFERENCE: f64 = 0.6;
/// A foot shorter than this fraction of the piece's diameter does not divide it.
const MIN_FOOT_LENGTH_SHARE: f64 = 0.02;
/// A facet within this fraction of a patch's diameter in front of it is in contact with it.
const CONTACT_DISTANCE_SHARE: f64 = 0.02;
/// Corners nearer to a plane than this multiple of [`Transport::epsilon`] lie in it: meshes come in single precision.
const IN_PLANE_EPSILONS: f64 = 100.0;
/// Surfaces nearer to each other than this multiple of [`Transport::epsilon`] are in contact.
const CONTACT_EPSILONS: f64 = 1e3;
/// Normals whose cosine is within this distance of ±1 are parallel.
const PARALLEL_COSINE_TOLERANCE: f64 = 1e-6;
/// Most pieces of a patch.
const MAX_PIECES: usize = 32;

type Polygon = Vec<Vec3>;

/// A convex polygon of a patch's plane with its edges.
struct Piece {
    corners: Polygon,
    /// Of each edge the unit normal m into the polygon, in its plane, and m·x on the edge.
    edges: Vec<(Vec3, f64)>,
    /// Largest distance of a corner from the first.
    diameter: f64,
}

impl Piece {
    fn of_plate(plate: &Plate) -> Piece {
        let (corners, n) = plate.corners();
        Piece::new(corners[..n].to_vec(), plate.normal())
    }

    fn new(corners: Polygon, normal: Vec3) -> Piece {
        let n = corners.len();
        let edge = |i: usize| {
            let m = normal.cross(corners[(i + 1) % n] - corners[i]).normalized();
            (m, m.dot(corners[i]))
        };
        let edges = (0..n).map(edge).collect();
        let diameter = corners.iter().map(|p| (*p - corners[0]).length()).fold(0.0, f64::max);
        Piece { corners, edges, diameter }
    }

    /// True when the foot passes through the interior over at least [`MIN_FOOT_LENGTH_SHARE`].
    fn is_crossed_by(&self, foot: &WallFoot) -> bool {
        let (mut t0, mut t1) = (0.0f64, 1.0f64);
        let [a, b] = foot.ends;
        for (m, c) in &self.edges {
            let (ha, hb) = (m.dot(a) - c, m.dot(b) - c);
            if ha < 0.0 && hb < 0.0 {
                return false;
            }
            if ha < 0.0 {
                t0 = t0.max(ha / (ha - hb));
            } else if hb < 0.0 {
                t1 = t1.min(ha / (ha - hb));
            }
        }
        let middle = a + (b - a) * (0.5 * (t0 + t1));
        (t1 - t0) * (b - a).length() > MIN_FOOT_LENGTH_SHARE * self.diameter
            && self.edges.iter().all(|(m, c)| m.dot(middle) - c > 1e-6 * self.diameter)
    }
}

/// The foot of a wall in the patch's plane.
struct WallFoot {
    ends: [Vec3; 2],
    /// Normal to the foot, in the patch's plane.
    across: Vec3,
    /// Smallest piece that it may split off, m².
    min_area: f64,
    id: u32,
}

impl WallFoot {
    /// The foot between two points of a plane of this normal, if it divides the patch with the outline `whole`.
    fn dividing(
        whole: &Piece,
        ends: [Vec3; 2],
        normal: Vec3,
        min_area: f64,
        id: u32,
        tolerance: f64,
    ) -> Option<WallFoot> {
        let along = (ends[1] - ends[0]).normalized();
        let foot = WallFoot { ends, across: normal.cross(along), min_area, id };
        ((ends[1] - ends[0]).length() > tolerance && whole.is_crossed_by(&foot)).then_some(foot)
    }
}

/// The pieces of `plate`, a part of facet `own`, each split off by opaque walls with at least `min_area` m²; the plate itself when no wall
/// stands on it.
pub(super) fn split_along_walls(
    transport: &Transport,
    own: usize,
    plate: &Plate,
    min_area: f64,
) -> Vec<Plate> {
    let (normal, area, whole) = (plate.normal(), plate.area(), Piece::of_plate(plate));
    // Collect the feet, the longest first.
    let (mut feet, may_be_covered) = wall_feet(transport, own, plate, &whole, min_area);
    pane_feet(transport, plate, &whole, &mut feet);
    if feet.is_empty() {
        return vec![*plate];
    }
    let length = |f: &WallFoot| (f.ends[1] - f.ends[0]).length();
    feet.sort_by(|a, b| length(b).total_cmp(&length(a)).then(a.id.cmp(&b.id)));
    let mut pieces = vec![whole];
    let differ_in_visibility = |a: &Polygon, b: &Polygon| {
        let [a, b] = [a, b].map(|p| hidden_share_of_polygon(transport, own, p, normal));
        (a - b).abs() > HIDDEN_SHARE_DIFFERENCE
    };
    let may_be_hidden = may_be_covered || transport.has_solids();
    // Split at every foot; in a second pass, when all large pieces are made, also off small hidden parts.
    for (foot, second_pass) in feet.iter().map(|f| (f, false)).chain(feet.iter().map(|f| (f, true))) {
        for k in 0..pieces.len() {
            if pieces.len() >= MAX_PIECES || !pieces[k].is_crossed_by(foot) {
                continue;
            }
            let level = foot.across.dot(foot.ends[0]);
            let (a, b) = (
                clip(&pieces[k].corners, foot.across, level),
                clip(&pieces[k].corners, -foot.across, -level),
            );
            let smaller = polygon_area(&a, normal).min(polygon_area(&b, normal));
            let large_enough = smaller > foot.min_area;
            if large_enough
                || second_pass
                    && may_be_hidden
                    && smaller > MIN_PIECE_SHARE_IF_HIDDEN * area
                    && differ_in_visibility(&a, &b)
            {
                pieces[k] = Piece::new(a, normal);
                pieces.push(Piece::new(b, normal));
            }
        }
    }
    if pieces.len() == 1 {
        return vec![*plate];
    }
    pieces.iter().flat_map(|p| polygon_plates(&p.corners, normal)).collect()
}

/// The feet of all facets that divide `plate`, a part of facet `own` with the outline `whole`; and false where no black back can lie on it.
fn wall_feet(
    transport: &Transport,
    own: usize,
    plate: &Plate,
    whole: &Piece,
    min_area: f64,
) -> (Vec<WallFoot>, bool) {
    let tolerance = IN_PLANE_EPSILONS * transport.epsilon();
    let (lo, hi) = plate.bounds();
    let normal = plate.normal();
    let contact = CONTACT_DISTANCE_SHARE * plate.diameter();
    let pad = Vec3::splat(contact);
    let (mut out, mut may_be_covered) = (Vec::new(), false);
    for id in transport.facets_overlapping(lo - pad, hi + pad) {
        if id as usize == own {
            continue;
        }
        // Heights of the wall's corners above the patch's plane.
        let wall = &transport.scene().facets()[id as usize].plate;
        let (x, k) = wall.corners();
        let h: Vec<f64> = x[..k].iter().map(|p| (*p - plate.origin).dot(normal)).collect();
        let top = h.iter().fold(f64::MIN, |m, y| m.max(*y));
        let bottom = h.iter().fold(f64::MAX, |m, y| m.min(*y));
        may_be_covered |= wall.normal().dot(normal) > 0.0
            && top > 0.0
            && bottom <= contact
            && has_black_back(transport, id as usize);
        let scene = transport.scene();
        let transmits = scene.surfaces()[scene.facets()[id as usize].surface].transmission.is_some();
        let mut add = |ends: [Vec3; 2], share: f64| {
            let min_area = if transmits {
                MIN_PIECE_SHARE_AT_GLASS * plate.area()
            } else {
                (share * plate.area()).max(min_area)
            };
            out.extend(WallFoot::dividing(whole, ends, normal, min_area, id, tolerance));
        };
        // The base of a solid on the plane is ignored: the solid's sides divide the patch.
        if is_solid(transport, id as usize)
            && top.max(-bottom) <= tolerance
            && wall.normal().dot(normal) < -1.0 + PARALLEL_COSINE_TOLERANCE
        {
            continue;
        }
        if bottom > -tolerance && top <= contact {
            // A facet in contact: its outline divides the patch.
            let foot_of = |i: usize| x[i] - normal * h[i];
            (0..k).for_each(|i| add([foot_of(i), foot_of((i + 1) % k)], MIN_PIECE_SHARE_AT_OUTLINE));
        } else if top > tolerance
            && bottom <= tolerance
            && let Some(ends) =
                plane_crossing(&x[..k], &h, normal.cross(wall.normal()).normalized(), tolerance)
        {
            add(ends, MIN_PIECE_SHARE_AT_WALL);
        }
    }
    (out, may_be_covered)
}

/// Adds the feet of the panes that divide `plate` with the outline `whole`.
fn pane_feet(transport: &Transport, plate: &Plate, whole: &Piece, out: &mut Vec<WallFoot>) {
    let tolerance = IN_PLANE_EPSILONS * transport.epsilon();
    let contact = CONTACT_DISTANCE_SHARE * plate.diameter();
    let (normal, min_area) = (plate.normal(), MIN_PIECE_SHARE_AT_GLASS * plate.area());
    let (lo, hi) = plate.bounds();
    let (pad, facets) = (Vec3::splat(contact), transport.scene().facets().len());
    for (pane, number) in transport.pane_plates_overlapping(lo - pad, hi + pad) {
        let plates = &transport.scene().panes()[pane as usize].plates;
        let part = &plates[number as usize];
        let (x, k) = part.corners();
        let height = |p: Vec3| (p - plate.origin).dot(normal);
        let h: Vec<f64> = x[..k].iter().map(|p| height(*p)).collect();
        let (bottom, top) = h.iter().fold((f64::MAX, f64::MIN), |(b, t), y| (b.min(*y), t.max(*y)));
        let mut add = |ends: [Vec3; 2]| {
            let (ends, id) = (ends.map(|p| p - normal * height(p)), facets as u32 + pane);
            out.extend(WallFoot::dividing(whole, ends, normal, min_area, id, tolerance));
        };
        if bottom > -tolerance && top <= contact {
            // A pane in contact: its outline divides the patch.
            let edges = (0..k).map(|i| [x[i], x[(i + 1) % k]]);
            let is_outer =
                |edge: &[Vec3; 2]| plates.iter().filter(|p| has_edge(p, edge, tolerance)).count() == 1;
            edges.filter(is_outer).for_each(&mut add);
        } else if top > contact && bottom <= contact {
            let along = normal.cross(part.normal()).normalized();
            plane_crossing(&x[..k], &h, along, contact).into_iter().for_each(&mut add);
        }
    }
}

/// True if a plate has an edge between two points.
fn has_edge(plate: &Plate, edge: &[Vec3; 2], tolerance: f64) -> bool {
    let (corners, n) = plate.corners();
    edge.iter().all(|p| corners[..n].iter().any(|c| (*c - *p).length() <= tolerance))
}

/// The intersection of a wall with corners `x` at heights `h` with the plane of height zero: the ends of the segment, which has the
/// direction `along`.
fn plane_crossing(x: &[Vec3], h: &[f64], along: Vec3, tolerance: f64) -> Option<[Vec3; 2]> {
    let mut ends: Option<[(f64, Vec3); 2]> = None;
    let mut extend_to = |p: Vec3| {
        let at = (along.dot(p), p);
        let [a, b] = ends.unwrap_or([at, at]);
        ends = Some([if at.0 < a.0 { at } else { a }, if at.0 > b.0 { at } else { b }]);
    };
    let k = x.len();
    for i in 0..k {
        let j = (i + 1) % k;
        if h[i].abs() <= tolerance {
            extend_to(x[i]);
        } else if h[i] * h[j] < 0.0 && h[j].abs() > tolerance {
            extend_to(x[i] + (x[j] - x[i]) * (h[i] / (h[i] - h[j])));
        }
    }
    ends.map(|[a, b]| [a.1, b.1])
}

/// The part of the polygon with m·x ≥ level.
fn clip(polygon: &[Vec3], m: Vec3, level: f64) -> Polygon {
    let mut out = Polygon::new();
    for (i, &p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let (hp, hq) = (m.dot(p) - level, m.dot(q) - level);
        if hp >= 0.0 {
            out.push(p);
        }
        if hp * hq < 0.0 {
            out.push(p + (q - p) * (hp / (hp - hq)));
        }
    }
    out
}

fn polygon_area(p: &[Vec3], normal: Vec3) -> f64 {
    (1..p.len().max(1) - 1).map(|i| 0.5 * (p[i] - p[0]).cross(p[i + 1] - p[0]).dot(normal)).sum()
}

/// A convex polygon as triangles, or as one parallelogram where it is one.
fn polygon_plates(polygon: &[Vec3], normal: Vec3) -> Vec<Plate> {
    let size = polygon.iter().map(|p| (*p - polygon[0]).length()).fold(0.0, f64::max);
    let mut p = polygon.to_vec();
    p.dedup_by(|a, b| (*a - *b).length() < 1e-9 * size);
    // Remove corners on a straight edge.
    let n = p.len();
    let bends = |i: usize| {
        let (a, b, c) = (p[(i + n - 1) % n], p[i], p[(i + 1) % n]);
        (b - a).cross(c - b).dot(normal) > 1e-12 * size * size
    };
    let p: Polygon = (0..n).filter(|&i| bends(i)).map(|i| p[i]).collect();
    let n = p.len();
    if n < 3 {
        return Vec::new();
    }
    if n == 4 && (p[0] - p[1] + p[2] - p[3]).length() < 1e-9 * size {
        return vec![Plate::parallelogram(p[0], p[1] - p[0], p[3] - p[0])];
    }
    // Triangulate as a fan from the corner whose smallest triangle is largest.
    let fan = |start: usize| {
        (1..n - 1).map({
            let p = &p;
            move |i| Plate::triangle(p[start], p[(start + i) % n], p[(start + i + 1) % n])
        })
    };
    let smallest = |s: usize| fan(s).map(|t| t.area()).fold(f64::MAX, f64::min);
    let start = (1..n).fold(0, |b, s| if smallest(s) > smallest(b) * (1.0 + 1e-9) { s } else { b });
    fan(start).collect()
}

/// True when the front of `plate`, a part of facet `own`, is hidden.
pub(super) fn is_covered(transport: &Transport, own: usize, plate: &Plate) -> bool {
    sample_points(plate.kind).iter().all(hides(transport, own, plate))
}

/// Fraction of four points of `plate`, a part of facet `own`, whose front is hidden.
fn hidden_share(transport: &Transport, own: usize, plate: &Plate) -> f64 {
    let points = sample_points(plate.kind);
    points.iter().copied().filter(hides(transport, own, plate)).count() as f64 / points.len() as f64
}

/// The mean hidden fraction of a convex polygon, a part of facet `own`.
fn hidden_share_of_polygon(transport: &Transport, own: usize, p: &[Vec3], normal: Vec3) -> f64 {
    let parts = polygon_plates(p, normal);
    let sum: f64 = parts.iter().map(|x| x.area() * hidden_share(transport, own, x)).sum();
    sum / polygon_area(p, normal)
}

/// Parameters of the points of a plate at which its front may be hidden.
fn sample_points(kind: PlateKind) -> &'static [[f64; 2]; 4] {
    match kind {
        PlateKind::Triangle => &[[0.33, 0.34], [0.6, 0.2], [0.2, 0.6], [0.2, 0.2]],
        PlateKind::Parallelogram => &[[0.51, 0.49], [0.2, 0.25], [0.75, 0.2], [0.3, 0.8]],
    }
}

/// True for the parameters of a point of `plate`, a part of facet `own`, whose front is hidden: under the black back of a facet in contact, in solid material,
/// against another solid, or behind the wall of a room into which its body is sunk. The wall and the body decide by one distance, so that both lose the
/// contact or neither.
fn hides(transport: &Transport, own: usize, plate: &Plate) -> impl Fn(&[f64; 2]) -> bool {
    let normal = plate.normal();
    let lift = normal * contact_gap(transport);
    let contact = CONTACT_DISTANCE_SHARE * plate.diameter();
    let solid = is_solid(transport, own);
    move |[u, v]: &[f64; 2]| {
        let p = plate.at(*u, *v);
        // Only a black back covers: a thin gap in front of an exchanging side remains a gap.
        let is_black_back = |h: Hit| !h.front && has_black_back(transport, h.facet);
        let covered =
            transport.closest_hit(p, normal, transport.epsilon(), contact).is_some_and(is_black_back);
        covered
            || transport.inside_solid(p + lift)
            || (solid && touches_opposite_facet(transport, own, plate, p) && transport.inside_solid(p - lift))
            || (solid && is_sunk(transport, plate, p, contact))
    }
}

/// The largest gap between a body and a surface that is a contact, m.
pub(super) fn contact_gap(transport: &Transport) -> f64 {
    CONTACT_EPSILONS * transport.epsilon()
}

/// True when a point `p` of a body's plate lies up to `reach` behind a parallel wall with a black back that is no body, and the body goes on in front of the wall:
/// the plate is outside the room in which its body stands. The wall of a hollow in the body has no body in front of it.
fn is_sunk(transport: &Transport, plate: &Plate, p: Vec3, reach: f64) -> bool {
    let hit = transport.closest_hit(p, -plate.normal(), transport.epsilon(), reach);
    hit.is_some_and(|h| {
        let wall = &transport.scene().facets()[h.facet].plate;
        let is_parallel = wall.normal().dot(plate.normal()) < -1.0 + PARALLEL_COSINE_TOLERANCE;
        let beyond = p - plate.normal() * (h.t + contact_gap(transport));
        !h.front
            && is_parallel
            && has_black_back(transport, h.facet)
            && !is_solid(transport, h.facet)
            && transport.inside_solid(beyond)
    })
}

/// True where the back of a facet is black.
fn has_black_back(transport: &Transport, facet: usize) -> bool {
    let scene = transport.scene();
    scene.surfaces()[scene.facets()[facet].surface].sides == Sides::Front
}

/// True where the facet belongs to a closed body.
fn is_solid(transport: &Transport, facet: usize) -> bool {
    let scene = transport.scene();
    scene.surfaces()[scene.facets()[facet].surface].solid
}

/// True when a facet of opposite normal lies at `p` of the plate: a box on a floor.
fn touches_opposite_facet(transport: &Transport, own: usize, plate: &Plate, p: Vec3) -> bool {
    let tolerance = contact_gap(transport);
    let pad = Vec3::splat(tolerance);
    let near = transport.facets_overlapping(p - pad, p + pad);
    near.into_iter().filter(|&id| id as usize != own).any(|id| {
        let other = &transport.scene().facets()[id as usize].plate;
        let in_plane = PreparedPlate::new(other).height(p).abs() <= tolerance;
        let opposite = other.normal().dot(plate.normal()) < -1.0 + PARALLEL_COSINE_TOLERANCE;
        let [u, v] = other.parameters(p);
        let within = match other.kind {
            PlateKind::Triangle => u >= 0.0 && v >= 0.0 && u + v <= 1.0,
            PlateKind::Parallelogram => (0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v),
        };
        in_plane && opposite && within
    })
}
