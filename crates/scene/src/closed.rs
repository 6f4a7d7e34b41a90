//! Closed parts of a set of plates: bodies (normals outward) and rooms (normals inward).
//!
//! Corners are welded on a grid. An edge is **balanced** when as many plates run through it forwards as backwards; a set of plates whose edges
//! are all balanced has no boundary, so that the winding number of a point is defined. Plates are joined across edges; where an edge has more
//! than one plate a direction, the plates around it are paired by angle, each with the plate at the other end of the wedge behind it:
//!
//! ```text
//!     wedge of a plate at edge a → b:  from its direction u (square to the edge, into the plate) towards −n
//! ```
//!
//! Bodies that touch along edges or faces are thus separate components. A component is closed when all its edges are balanced; the sign of
//! its volume Σ a·(b × c)/6 tells a body from a room.

use crate::Plate;
use std::collections::HashMap;
use zonal_math::Vec3;

/// Kind of the component of a plate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shell {
    /// Some edge is not balanced, or no volume is enclosed.
    Open,
    /// Closed with normals outward.
    Body,
    /// Closed with normals inward.
    Room,
}

/// A connected set of plates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Component {
    /// Open, or which way it looks.
    pub shell: Shell,
    /// Volume enclosed, m³; negative for a room.
    pub volume: f64,
    /// Area, m².
    pub area: f64,
    /// Sum of the area vectors, m²: zero of a closed component.
    pub area_vector: Vec3,
    /// Edges without a partner.
    pub free_edges: usize,
    /// Edges at which all plates run the same way: a neighbour's normal points to the other side.
    pub turned_edges: usize,
}

/// Components of a list of plates.
#[derive(Clone, Debug, Default)]
pub struct Shells {
    component: Vec<u32>,
    list: Vec<Component>,
}

/// A plate at an edge between two welded corners, the lower one first.
#[derive(Clone, Copy)]
struct EdgeUse {
    corners: (u32, u32),
    plate: u32,
    /// The plate's corner at which the edge begins.
    first: u8,
    forwards: bool,
}

/// Angles around an edge that differ by less than this are equal, radians.
const EQUAL_ANGLE: f64 = 1e-6;
/// Volume that rounding may enclose, in units of the area to the power 3/2: two sheets back to back are no body.
const LEAST_VOLUME: f64 = 1e-9;
/// Shift of the weld grid, in its steps: no multiple of a simple fraction lies on the border of a cell.
const GRID_SHIFT: f64 = 0.286_391_7;

impl Shells {
    /// Finds the components; corners nearer than about `weld` times the extent of all plates are one.
    pub fn find(plates: &[Plate], weld: f64) -> Shells {
        let uses = edge_uses(plates, weld);
        let mut parent: Vec<u32> = (0..plates.len() as u32).collect();
        let mut unbalanced: Vec<(u32, bool)> = Vec::new();
        for group in uses.chunk_by(|a, b| a.corners == b.corners) {
            let forwards = group.iter().filter(|u| u.forwards).count();
            if 2 * forwards == group.len() && group.len() > 2 {
                for (a, b) in paired(plates, group) {
                    join(&mut parent, a, b);
                }
                continue;
            }
            group.windows(2).for_each(|w| join(&mut parent, w[0].plate, w[1].plate));
            if 2 * forwards != group.len() {
                unbalanced.push((group[0].plate, group.len() > 1 && forwards % group.len() == 0));
            }
        }
        let mut shells = Shells { component: vec![u32::MAX; plates.len()], list: Vec::new() };
        let mut number = vec![u32::MAX; plates.len()];
        let origin = plates.first().map_or(Vec3::ZERO, |p| p.origin);
        for (i, p) in plates.iter().enumerate() {
            let r = root(&mut parent, i as u32) as usize;
            if number[r] == u32::MAX {
                number[r] = shells.list.len() as u32;
                shells.list.push(Component {
                    shell: Shell::Open,
                    volume: 0.0,
                    area: 0.0,
                    area_vector: Vec3::ZERO,
                    free_edges: 0,
                    turned_edges: 0,
                });
            }
            shells.component[i] = number[r];
            let (c, n) = p.corners();
            let own = &mut shells.list[number[r] as usize];
            for k in 1..n - 1 {
                let (a, b, d) = (c[0] - origin, c[k] - origin, c[k + 1] - origin);
                own.volume += a.dot(b.cross(d)) / 6.0;
            }
            own.area += p.area();
            own.area_vector += p.normal() * p.area();
        }
        for (plate, turned) in unbalanced {
            let c = &mut shells.list[shells.component[plate as usize] as usize];
            *(if turned { &mut c.turned_edges } else { &mut c.free_edges }) += 1;
        }
        for c in &mut shells.list {
            c.shell = match c.volume {
                _ if c.free_edges + c.turned_edges > 0 => Shell::Open,
                v if v > LEAST_VOLUME * c.area.powf(1.5) => Shell::Body,
                v if v < -LEAST_VOLUME * c.area.powf(1.5) => Shell::Room,
                _ => Shell::Open,
            };
        }
        shells
    }

    /// Kind of the component of a plate.
    pub fn of(&self, plate: usize) -> Shell {
        self.list[self.component[plate] as usize].shell
    }
    /// Number of the component of a plate.
    pub fn component(&self, plate: usize) -> usize {
        self.component[plate] as usize
    }
    /// All components, in the order of their first plates.
    pub fn components(&self) -> &[Component] {
        &self.list
    }
}

fn root(parent: &mut [u32], mut i: u32) -> u32 {
    while parent[i as usize] != i {
        parent[i as usize] = parent[parent[i as usize] as usize];
        i = parent[i as usize];
    }
    i
}

fn join(parent: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(parent, a), root(parent, b));
    parent[a.max(b) as usize] = a.min(b);
}

/// The edges of all plates, sorted by their corners, then by plate.
fn edge_uses(plates: &[Plate], weld: f64) -> Vec<EdgeUse> {
    let empty = (Vec3::splat(f64::INFINITY), Vec3::splat(f64::NEG_INFINITY));
    let (lo, hi) = plates.iter().map(Plate::bounds).fold(empty, |(lo, hi), (a, b)| (lo.min(a), hi.max(b)));
    let step = ((hi - lo).max_abs() * weld).max(f64::MIN_POSITIVE);
    let mut ids: HashMap<[i64; 3], u32> = HashMap::with_capacity(plates.len());
    let mut uses = Vec::with_capacity(4 * plates.len());
    for (plate, p) in plates.iter().enumerate() {
        let (c, n) = p.corners();
        let id = c.map(|q| {
            let d = q - lo;
            let key = [0, 1, 2].map(|k| (d[k] / step + GRID_SHIFT).round() as i64);
            let next = ids.len() as u32;
            *ids.entry(key).or_insert(next)
        });
        for k in 0..n {
            let (a, b) = (id[k], id[(k + 1) % n]);
            if a != b {
                let corners = (a.min(b), a.max(b));
                uses.push(EdgeUse { corners, plate: plate as u32, first: k as u8, forwards: a < b });
            }
        }
    }
    uses.sort_unstable_by_key(|u| (u.corners, u.plate, u.first));
    uses
}

/// The pairs of plates around a balanced edge that bound one wedge behind both.
fn paired(plates: &[Plate], group: &[EdgeUse]) -> Vec<(u32, u32)> {
    let along = |u: &EdgeUse| {
        let (c, n) = plates[u.plate as usize].corners();
        let d = c[(u.first as usize + 1) % n] - c[u.first as usize];
        (d.normalized(), plates[u.plate as usize].normal())
    };
    // Directions into the plates are measured from that of the first.
    let (d, n) = along(&group[0]);
    let axis = if group[0].forwards { d } else { -d };
    let zero = n.cross(d);
    let quarter = axis.cross(zero);
    let mut around: Vec<(i64, bool, u32)> = group
        .iter()
        .map(|u| {
            let (d, n) = along(u);
            let into = n.cross(d);
            let angle = into.dot(quarter).atan2(into.dot(zero)).rem_euclid(std::f64::consts::TAU);
            let steps = (angle / EQUAL_ANGLE).round() as i64;
            let turn = (std::f64::consts::TAU / EQUAL_ANGLE).round() as i64;
            // The wedge behind begins at a plate that runs backwards and ends at one that runs forwards; ends come first.
            (if steps >= turn { 0 } else { steps }, !u.forwards, u.plate)
        })
        .collect();
    around.sort_unstable();
    let (mut begun, mut pairs): (Vec<u32>, Vec<(u32, u32)>) = (Vec::new(), Vec::new());
    let mut ended = vec![false; around.len()];
    for round in 0..2 {
        for (k, &(_, begins, plate)) in around.iter().enumerate() {
            if begins && round == 0 {
                begun.push(plate);
            } else if !begins
                && !ended[k]
                && let Some(other) = begun.pop()
            {
                ended[k] = true;
                pairs.push((other, plate));
            }
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    /// A cuboid of twelve triangles with normals outward, or inward.
    fn cuboid(lo: Vec3, hi: Vec3, inward: bool) -> Vec<Plate> {
        let e = hi - lo;
        let (x, y, z) = (vec3(e.x, 0.0, 0.0), vec3(0.0, e.y, 0.0), vec3(0.0, 0.0, e.z));
        let sides = [(lo, y, x), (lo, z, y), (lo, x, z), (hi, -x, -y), (hi, -y, -z), (hi, -z, -x)];
        sides
            .into_iter()
            .flat_map(|(o, a, b)| {
                [Plate::triangle(o, o + a, o + b), Plate::triangle(o + a + b, o + b, o + a)]
            })
            .map(|p| if inward { p.flipped() } else { p })
            .collect()
    }
    fn count(plates: &[Plate]) -> Vec<(Shell, f64)> {
        let mut list: Vec<(Shell, f64)> =
            Shells::find(plates, 1e-6).components().iter().map(|c| (c.shell, c.volume)).collect();
        list.sort_by(|a, b| a.1.total_cmp(&b.1));
        list
    }

    #[test]
    fn touching_bodies_are_separate_components() {
        let first = cuboid(Vec3::ZERO, Vec3::ONE, false);
        // On an edge, on a whole face, and on a corner.
        for shift in [vec3(1.0, 1.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0), Vec3::ONE] {
            let second = cuboid(shift, shift + Vec3::ONE, false);
            let both = [first.clone(), second].concat();
            let found = count(&both);
            assert_eq!(found.len(), 2, "{shift:?}");
            assert!(found.iter().all(|(s, v)| *s == Shell::Body && (v - 1.0).abs() < 1e-12), "{found:?}");
        }
        // Four around one edge.
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
        let four: Vec<Plate> = corners
            .iter()
            .flat_map(|&(x, y)| cuboid(vec3(x, y, 0.0), vec3(x + 1.0, y + 1.0, 1.0), false))
            .collect();
        assert_eq!(count(&four).len(), 4);
        assert!(count(&four).iter().all(|c| c.0 == Shell::Body));
    }

    #[test]
    fn two_skins_without_a_distance_are_a_body_and_a_room() {
        let skins = [cuboid(Vec3::ZERO, Vec3::ONE, false), cuboid(Vec3::ZERO, Vec3::ONE, true)].concat();
        let found = count(&skins);
        assert_eq!(found.iter().map(|c| c.0).collect::<Vec<_>>(), [Shell::Room, Shell::Body], "{found:?}");
    }

    #[test]
    fn turned_and_missing_faces_are_counted() {
        let mut body = cuboid(Vec3::ZERO, Vec3::ONE, false);
        body[3] = body[3].flipped();
        let c = Shells::find(&body, 1e-6).components()[0];
        assert_eq!((c.shell, c.turned_edges, c.free_edges), (Shell::Open, 3, 0));
        body.remove(3);
        let c = Shells::find(&body, 1e-6).components()[0];
        assert_eq!((c.shell, c.turned_edges, c.free_edges), (Shell::Open, 0, 3));
        assert!(Shells::find(&[], 1e-6).components().is_empty());
    }

    #[test]
    fn two_sheets_back_to_back_are_open() {
        let sheet = Plate::parallelogram(vec3(0.1, 0.2, 0.3), vec3(1.0, 0.3, 0.1), vec3(-0.3, 1.0, 0.7));
        let c = Shells::find(&[sheet, sheet.flipped()], 1e-6).components()[0];
        assert_eq!((c.shell, c.free_edges, c.turned_edges), (Shell::Open, 0, 0), "{c:?}");
    }

    #[test]
    fn corners_at_any_fraction_of_the_extent_are_welded() {
        // Corners that differ by rounding at k/128 of the extent lie on the border between cells of a grid that is not shifted.
        let mut plates = cuboid(Vec3::ZERO, Vec3::splat(128.0), true);
        for (k, p) in cuboid(vec3(1.0, 3.0, 5.0), vec3(7.0, 9.0, 11.0), false).into_iter().enumerate() {
            let off = if k % 2 == 0 { 1e-10 } else { -1e-10 };
            plates.push(Plate { origin: p.origin + Vec3::splat(off), ..p });
        }
        assert_eq!(count(&plates).iter().map(|c| c.0).collect::<Vec<_>>(), [Shell::Room, Shell::Body]);
    }
}
