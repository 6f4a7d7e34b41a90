//! Connected shells of a set of plates: open shells, solids (closed, normals outward) and enclosures (closed, normals inward).
//!
//! Corners are welded (`weld.rs`). An edge is **balanced** if equal numbers of plates traverse it forwards and backwards; a set of plates
//! whose edges are all balanced has no boundary, and the winding number of a point is defined. Plates are joined across edges
//! (union–find); at an edge with several plates in each direction the plates are sorted by angle, and each is paired with the plate at the
//! other end of the wedge behind it:
//!
//! ```text
//!     wedge of a plate at edge a → b:  from the direction u (normal to the edge, into the plate) towards −n
//! ```
//!
//! Solids that touch along edges or faces are thus separate shells. A shell is closed if all its edges are balanced, or if those that are not pair at
//! T-junctions (`t_junctions.rs`) and its area vectors cancel; the sign of its volume Σ a·(b × c)/6 distinguishes a solid from an enclosure.
//!
//! **Cost:** O(n log n) for n plates.

use crate::geometry::plate::Plate;
use crate::geometry::t_junctions::TJunctions;
use crate::geometry::weld::WeldedCorners;
use zonal_math::Vec3;

/// Kind of a shell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ShellKind {
    /// An edge is unbalanced, or no volume is enclosed.
    #[default]
    Open,
    /// Closed with normals outward.
    Solid,
    /// Closed with normals inward.
    Enclosure,
}

impl ShellKind {
    /// All kinds.
    pub const VARIANTS: [ShellKind; 3] = [ShellKind::Open, ShellKind::Solid, ShellKind::Enclosure];

    /// Suffix of the name of a surface, for meshes whose shells are of several kinds.
    pub fn name_suffix(self) -> &'static str {
        ["", " (solid)", " (room)"][self as usize]
    }
}

/// Distance of corners of a mesh that are welded, relative to the extent of the mesh.
pub const WELD_TOLERANCE: f64 = 1e-6;

/// Properties of a connected set of plates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shell {
    /// Open, solid or enclosure.
    pub kind: ShellKind,
    /// Enclosed volume, m³; negative for an enclosure.
    pub volume: f64,
    /// Area, m².
    pub area: f64,
    /// Sum of the area vectors, m²: zero for a closed shell.
    pub area_vector: Vec3,
    /// Number of edges without a second plate.
    pub free_edges: usize,
    /// Number of edges that both of their two plates traverse in one direction: the normals of neighbours are inconsistent.
    pub flipped_edges: usize,
    /// Number of edges of three or more plates that are not traversed equally often in both directions.
    pub crowded_edges: usize,
    /// Number of plates.
    pub plates: usize,
}

/// The shells of a list of plates.
#[derive(Clone, Debug, Default)]
pub struct Shells {
    shell_of_plate: Vec<u32>,
    shells: Vec<Shell>,
}

/// One plate at an edge between two welded corners, the lower index first.
#[derive(Clone, Copy)]
pub(crate) struct EdgeUse {
    pub(crate) corners: (u32, u32),
    pub(crate) plate: u32,
    /// The corner of the plate at which the edge begins.
    first: u8,
    pub(crate) forwards: bool,
}

/// Angles around an edge that differ by less than this count as equal, radians.
const EQUAL_ANGLE_TOLERANCE: f64 = 1e-6;
/// Volume below which a shell counts as open, in units of its area to the power 3/2: rounding errors of two sheets back to back.
const MIN_SHELL_VOLUME: f64 = 1e-9;
/// Length of the sum of the area vectors, over the area, below which a shell with T-junctions may be closed.
const MAX_CLOSED_AREA_FRACTION: f64 = 1e-5;

impl Shell {
    /// Adds volume (relative to `origin`), area and area vector of a plate.
    fn add_plate(&mut self, p: &Plate, origin: Vec3) {
        let (c, n) = p.corners();
        for k in 1..n - 1 {
            let (a, b, d) = (c[0] - origin, c[k] - origin, c[k + 1] - origin);
            self.volume += a.dot(b.cross(d)) / 6.0;
        }
        self.area += p.area();
        self.area_vector += p.normal() * p.area();
        self.plates += 1;
    }

    /// The kind by unbalanced edges and volume.
    fn classify(&self) -> ShellKind {
        match self.volume {
            _ if self.free_edges + self.flipped_edges + self.crowded_edges > 0 => ShellKind::Open,
            v if v > MIN_SHELL_VOLUME * self.area.powf(1.5) => ShellKind::Solid,
            v if v < -MIN_SHELL_VOLUME * self.area.powf(1.5) => ShellKind::Enclosure,
            _ => ShellKind::Open,
        }
    }
}

/// An edge that is not balanced.
struct UnbalancedEdge {
    corners: (u32, u32),
    /// One of its plates.
    plate: u32,
    /// The number of its plates.
    plates: usize,
}

/// Joins plates across their edges. Returns the parents of the union–find forest, and the unbalanced edges.
fn join_across_edges(plates: &[Plate], welded: &WeldedCorners) -> (Vec<u32>, Vec<UnbalancedEdge>) {
    let uses = edge_uses(plates, welded);
    let mut parent: Vec<u32> = (0..plates.len() as u32).collect();
    let mut unbalanced = Vec::new();
    for group in uses.chunk_by(|a, b| a.corners == b.corners) {
        let forwards = group.iter().filter(|u| u.forwards).count();
        if 2 * forwards == group.len() && group.len() > 2 {
            for (a, b) in pair_around_edge(plates, group) {
                join(&mut parent, a, b);
            }
            continue;
        }
        group.windows(2).for_each(|w| join(&mut parent, w[0].plate, w[1].plate));
        if 2 * forwards != group.len() {
            let EdgeUse { corners, plate, .. } = group[0];
            unbalanced.push(UnbalancedEdge { corners, plate, plates: group.len() });
        }
    }
    (parent, unbalanced)
}

impl Shells {
    /// Finds the shells; corners nearer than about `weld` times the extent of all plates are identified.
    ///
    /// ```
    /// use zonal_math::vec3;
    /// use zonal_scene::Plate;
    /// use zonal_scene::shells::{ShellKind, Shells};
    /// let (a, b, c, d) = (vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0));
    /// let tetrahedron = [(a, c, b), (a, b, d), (a, d, c), (b, c, d)].map(|(p, q, r)| Plate::triangle(p, q, r));
    /// let shells = Shells::find(&tetrahedron, 1e-6);
    /// assert_eq!(shells.of(0), ShellKind::Solid);
    /// assert_eq!(Shells::find(&tetrahedron[..3], 1e-6).of(0), ShellKind::Open);
    /// ```
    pub fn find(plates: &[Plate], weld: f64) -> Shells {
        // Join plates across edges and collect unbalanced edges.
        let welded = WeldedCorners::of(plates, weld);
        let (mut parent, unbalanced) = join_across_edges(plates, &welded);
        // Number the sets and sum volumes, areas and area vectors.
        let mut shells = Shells { shell_of_plate: vec![u32::MAX; plates.len()], shells: Vec::new() };
        let mut number = vec![u32::MAX; plates.len()];
        let origin = plates.first().map_or(Vec3::ZERO, |p| p.origin);
        for (i, p) in plates.iter().enumerate() {
            let r = root(&mut parent, i as u32) as usize;
            if number[r] == u32::MAX {
                number[r] = shells.shells.len() as u32;
                shells.shells.push(Shell::default());
            }
            shells.shell_of_plate[i] = number[r];
            shells.shells[number[r] as usize].add_plate(p, origin);
        }
        // Count unbalanced edges and classify.
        for edge in &unbalanced {
            let c = &mut shells.shells[shells.shell_of_plate[edge.plate as usize] as usize];
            *match edge.plates {
                1 => &mut c.free_edges,
                2 => &mut c.flipped_edges,
                _ => &mut c.crowded_edges,
            } += 1;
        }
        shells.close_at_t_junctions(&unbalanced, &welded);
        shells.shells.iter_mut().for_each(|c| c.kind = c.classify());
        shells
    }

    /// Takes the free edges from shells in which all of them pair at T-junctions.
    fn close_at_t_junctions(&mut self, unbalanced: &[UnbalancedEdge], welded: &WeldedCorners) {
        let may_close = |c: &Shell| {
            c.free_edges > 0
                && c.flipped_edges + c.crowded_edges == 0
                && c.area_vector.length() < MAX_CLOSED_AREA_FRACTION * c.area
        };
        let mut edges: Vec<(u32, (u32, u32))> = unbalanced
            .iter()
            .map(|e| (self.shell_of_plate[e.plate as usize], e.corners))
            .filter(|e| may_close(&self.shells[e.0 as usize]))
            .collect();
        edges.sort_unstable();
        for own in edges.chunk_by(|a, b| a.0 == b.0) {
            let corners: Vec<(u32, u32)> = own.iter().map(|e| e.1).collect();
            if TJunctions::of(&corners, welded).pair_all_edges() {
                self.shells[own[0].0 as usize].free_edges = 0;
            }
        }
    }

    /// Kind of the shell of a plate.
    pub fn of(&self, plate: usize) -> ShellKind {
        self.shells[self.shell_of_plate[plate] as usize].kind
    }
    /// Index of the shell of a plate.
    pub fn shell_index(&self, plate: usize) -> usize {
        self.shell_of_plate[plate] as usize
    }
    /// All shells, in the order of their first plates.
    pub fn shells(&self) -> &[Shell] {
        &self.shells
    }
}

/// The representative of the set of `i`, with path halving.
fn root(parent: &mut [u32], mut i: u32) -> u32 {
    while parent[i as usize] != i {
        parent[i as usize] = parent[parent[i as usize] as usize];
        i = parent[i as usize];
    }
    i
}

/// Unites the sets of `a` and `b`.
fn join(parent: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(parent, a), root(parent, b));
    parent[a.max(b) as usize] = a.min(b);
}

/// The edges of plates with welded corners, sorted by corners, then by plate.
pub(crate) fn edge_uses(plates: &[Plate], welded: &WeldedCorners) -> Vec<EdgeUse> {
    let mut uses = Vec::with_capacity(4 * plates.len());
    for (plate, (p, id)) in plates.iter().zip(&welded.of_plate).enumerate() {
        let n = p.corners().1;
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

/// Maximum number of plates at an edge whose plates count as neighbours.
const MAX_PLATES_AT_EDGE: usize = 8;

/// Pairs of plates that share an edge and traverse it in opposite directions, so that their fronts lie on one side, by ascending edge; corners nearer than
/// about `weld` times the extent of all plates are identified. Edges with more than eight plates have none.
#[must_use]
pub fn edge_neighbours(plates: &[Plate], weld: f64) -> Vec<[u32; 2]> {
    let uses = edge_uses(plates, &WeldedCorners::of(plates, weld));
    let mut pairs = Vec::new();
    for group in uses.chunk_by(|a, b| a.corners == b.corners).filter(|g| g.len() <= MAX_PLATES_AT_EDGE) {
        for a in group.iter().filter(|u| u.forwards) {
            pairs.extend(group.iter().filter(|u| !u.forwards).map(|b| [a.plate, b.plate]));
        }
    }
    pairs
}

/// Pairs of plates around a balanced edge that bound a common wedge behind both.
fn pair_around_edge(plates: &[Plate], group: &[EdgeUse]) -> Vec<(u32, u32)> {
    let direction_and_normal = |u: &EdgeUse| {
        let (c, n) = plates[u.plate as usize].corners();
        let d = c[(u.first as usize + 1) % n] - c[u.first as usize];
        (d.normalized(), plates[u.plate as usize].normal())
    };
    // Measure angles from the direction into the first plate.
    let (d, n) = direction_and_normal(&group[0]);
    let axis = if group[0].forwards { d } else { -d };
    let zero = n.cross(d);
    let quarter = axis.cross(zero);
    let mut around: Vec<(i64, bool, u32)> = group
        .iter()
        .map(|u| {
            let (d, n) = direction_and_normal(u);
            let into = n.cross(d);
            let angle = into.dot(quarter).atan2(into.dot(zero)).rem_euclid(std::f64::consts::TAU);
            let steps = (angle / EQUAL_ANGLE_TOLERANCE).round() as i64;
            let turn = (std::f64::consts::TAU / EQUAL_ANGLE_TOLERANCE).round() as i64;
            // The wedge behind begins at a backward plate and ends at a forward plate; ends are sorted first.
            (if steps >= turn { 0 } else { steps }, !u.forwards, u.plate)
        })
        .collect();
    around.sort_unstable();
    // Match begins and ends as parentheses; a second round closes wedges that contain the zero angle.
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
    fn count(plates: &[Plate]) -> Vec<(ShellKind, f64)> {
        let mut list: Vec<(ShellKind, f64)> =
            Shells::find(plates, 1e-6).shells().iter().map(|c| (c.kind, c.volume)).collect();
        list.sort_by(|a, b| a.1.total_cmp(&b.1));
        list
    }

    #[test]
    fn solids_with_t_junctions_are_closed() {
        let [x, y, z] = [vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0)];
        let half = |at: Vec3| Plate::parallelogram(z + at, 0.5 * x, y);
        let solid = [
            Plate::parallelogram(Vec3::ZERO, y, x),
            Plate::parallelogram(Vec3::ZERO, x, z),
            Plate::parallelogram(y, z, x),
            Plate::parallelogram(Vec3::ZERO, z, y),
            Plate::parallelogram(x, y, z),
            half(Vec3::ZERO),
            half(0.5 * x),
        ];
        assert_eq!(count(&solid), [(ShellKind::Solid, 1.0)]);
        let room = solid.map(|p| p.flipped());
        assert_eq!(count(&room), [(ShellKind::Enclosure, -1.0)]);
        assert_eq!(count(&solid[..6])[0].0, ShellKind::Open);
        // A part that is turned is no boundary.
        let mut turned = solid;
        turned[6] = turned[6].flipped();
        assert!(count(&turned).iter().all(|c| c.0 == ShellKind::Open));
    }

    #[test]
    fn touching_solids_are_separate_shells() {
        let first = cuboid(Vec3::ZERO, Vec3::ONE, false);
        // On an edge, on a whole face, and on a corner.
        for shift in [vec3(1.0, 1.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0), Vec3::ONE] {
            let second = cuboid(shift, shift + Vec3::ONE, false);
            let both = [first.clone(), second].concat();
            let found = count(&both);
            assert_eq!(found.len(), 2, "{shift:?}");
            assert!(
                found.iter().all(|(s, v)| *s == ShellKind::Solid && (v - 1.0).abs() < 1e-12),
                "{found:?}"
            );
        }
        // Four around one edge.
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
        let four: Vec<Plate> = corners
            .iter()
            .flat_map(|&(x, y)| cuboid(vec3(x, y, 0.0), vec3(x + 1.0, y + 1.0, 1.0), false))
            .collect();
        assert_eq!(count(&four).len(), 4);
        assert!(count(&four).iter().all(|c| c.0 == ShellKind::Solid));
    }

    #[test]
    fn coincident_opposite_skins_are_a_solid_and_an_enclosure() {
        let skins = [cuboid(Vec3::ZERO, Vec3::ONE, false), cuboid(Vec3::ZERO, Vec3::ONE, true)].concat();
        let found = count(&skins);
        assert_eq!(
            found.iter().map(|c| c.0).collect::<Vec<_>>(),
            [ShellKind::Enclosure, ShellKind::Solid],
            "{found:?}"
        );
    }

    #[test]
    fn flipped_and_missing_faces_are_counted() {
        let mut body = cuboid(Vec3::ZERO, Vec3::ONE, false);
        body[3] = body[3].flipped();
        let c = Shells::find(&body, 1e-6).shells()[0];
        assert_eq!((c.kind, c.flipped_edges, c.free_edges), (ShellKind::Open, 3, 0));
        body.remove(3);
        let c = Shells::find(&body, 1e-6).shells()[0];
        assert_eq!((c.kind, c.flipped_edges, c.free_edges), (ShellKind::Open, 0, 3));
        assert!(Shells::find(&[], 1e-6).shells().is_empty());
    }

    #[test]
    fn sheets_back_to_back_are_open() {
        let sheet = Plate::parallelogram(vec3(0.1, 0.2, 0.3), vec3(1.0, 0.3, 0.1), vec3(-0.3, 1.0, 0.7));
        let c = Shells::find(&[sheet, sheet.flipped()], 1e-6).shells()[0];
        assert_eq!((c.kind, c.free_edges, c.flipped_edges), (ShellKind::Open, 0, 0), "{c:?}");
    }

    #[test]
    fn corners_at_simple_fractions_of_the_extent_are_welded() {
        // Corners at k/128 of the extent lie on cell borders of an unshifted grid; rounding errors would then separate them.
        let mut plates = cuboid(Vec3::ZERO, Vec3::splat(128.0), true);
        for (k, p) in cuboid(vec3(1.0, 3.0, 5.0), vec3(7.0, 9.0, 11.0), false).into_iter().enumerate() {
            let off = if k % 2 == 0 { 1e-10 } else { -1e-10 };
            plates.push(Plate { origin: p.origin + Vec3::splat(off), ..p });
        }
        assert_eq!(
            count(&plates).iter().map(|c| c.0).collect::<Vec<_>>(),
            [ShellKind::Enclosure, ShellKind::Solid]
        );
    }
}
