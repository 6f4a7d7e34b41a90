//! Topology of a set of plates: the defects of a mesh, each with its count and first place.
//!
//! Corners are welded (`weld.rs`). A *face* is a polygon of one or more plates; its outline is the set of directed edges that no other plate
//! of the face traverses the other way. Two faces with equal outlines are **repeated**, two with reversed outlines **opposite**, if their corners
//! agree within the rounding of single precision and `COPY_SHARE` of their size: sheets close to one another remain two. Edges are
//! counted over the plates that no earlier face repeats:
//!
//! | defect | meaning |
//! |---|---|
//! | free edge | one plate: a border or a hole |
//! | crowded edge | three or more plates, not equally many in both directions: a wall on a wall, a face too many |
//! | flipped edge | two plates that traverse it in one direction: their fronts are on opposite sides |
//! | T-junction | a free edge with a corner of another free edge in its interior: no hole, but the edges do not pair |
//! | sliver | a plate whose longest edge exceeds `SLIVER_ASPECT_RATIO` heights |
//!
//! **Cost:** O(n log n) for n plates, and the search for T-junctions (`t_junctions.rs`).

use crate::base::diagnostic::Diagnostic;
use crate::geometry::plate::Plate;
use crate::geometry::shells::{EdgeUse, WELD_TOLERANCE, edge_uses};
use crate::geometry::t_junctions::TJunctions;
use crate::geometry::weld::WeldedCorners;
use crate::scene::Scene;
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use zonal_math::Vec3;

/// Longest edge of a plate over its height, above which it is a sliver.
const SLIVER_ASPECT_RATIO: f64 = 200.0;

/// Distance of the corners of two faces that are copies, relative to the size of the face.
const COPY_SHARE: f64 = 1e-5;
/// The same, relative to the largest coordinate: some units of single precision.
const COORDINATE_ROUNDING: f64 = 4e-7;

/// A kind of defect: how often it occurs, and where first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Defect {
    /// Number of edges or faces.
    pub count: usize,
    first: Option<DefectPlace>,
}

/// Where a defect is.
#[derive(Clone, Copy, Debug, PartialEq)]
struct DefectPlace {
    /// Index of the face, from 0.
    face: usize,
    /// Index of the other face of a repeated or opposite pair, from 0.
    other: Option<usize>,
    /// The ends of the edge, m; the centre of a face twice.
    ends: [Vec3; 2],
}

impl Defect {
    /// The first place, as text with faces counted from 1 and coordinates in the unit of the plates: `face 3 at (0, 0, 0) to (1, 0, 0)`.
    #[must_use]
    pub fn first_place(&self) -> Option<String> {
        self.first.map(|place| place.to_string())
    }

    fn add(&mut self, place: DefectPlace) {
        self.count += 1;
        self.first.get_or_insert(place);
    }
}

impl std::fmt::Display for DefectPlace {
    /// `face 3 at (0, 0, 0) to (1, 0, 0)`; faces count from 1 as in mesh files.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let point = |p: Vec3| p.array().map(|x| format!("{}", (1e6 * x).round() / 1e6)).join(", ");
        write!(f, "face {}", self.face + 1)?;
        if let Some(other) = self.other {
            write!(f, " and face {}", other + 1)?;
        }
        write!(f, " at ({})", point(self.ends[0]))?;
        if self.ends[0] == self.ends[1] { Ok(()) } else { write!(f, " to ({})", point(self.ends[1])) }
    }
}

/// Relation of a face to an earlier one with the same corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaceCopy {
    /// The corners run the same way: the same face again.
    Repeated(usize),
    /// The corners run the other way: the other side of a plate of no thickness.
    Opposite(usize),
}

/// The defects of a set of plates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Topology {
    /// Edges of one plate.
    pub free_edges: Defect,
    /// Edges of three or more plates that are not traversed equally often in both directions.
    pub crowded_edges: Defect,
    /// Edges of two plates with opposite orientations.
    pub flipped_edges: Defect,
    /// Faces with the outline of an earlier face.
    pub repeated_faces: Defect,
    /// Faces with the reversed outline of an earlier face.
    pub opposite_faces: Defect,
    /// Free edges that have a corner in their interior.
    pub t_junctions: Defect,
    /// Needles and slivers.
    pub slivers: Defect,
}

/// Directed edges of the outline of a face, sorted.
fn outline(corners: &[[u32; 4]], counts: &[usize]) -> Vec<(u32, u32)> {
    let mut edges: Vec<(u32, u32)> = Vec::with_capacity(4 * corners.len());
    for (own, n) in corners.iter().zip(counts) {
        for k in 0..*n {
            let edge = (own[k], own[(k + 1) % n]);
            match edges.iter().position(|e| *e == (edge.1, edge.0)) {
                Some(inner) if corners.len() > 1 => {
                    edges.swap_remove(inner);
                }
                _ if edge.0 == edge.1 => {}
                _ => edges.push(edge),
            }
        }
    }
    edges.sort_unstable();
    edges
}

/// True if the corners of two faces with the same numbers are at the same places.
fn agree(plates: &[Plate], welded: &WeldedCorners, runs: [&std::ops::Range<usize>; 2]) -> bool {
    let places = runs.map(|run| {
        let of_plate = run.clone().flat_map(|i| {
            let (c, n) = plates[i].corners();
            (0..n).map(move |k| (welded.of_plate[i][k], c[k]))
        });
        let mut list: Vec<(u32, Vec3)> = of_plate.collect();
        list.sort_by_key(|x| x.0);
        list.dedup_by_key(|x| x.0);
        list
    });
    let [first, second] = &places;
    let Some((_, origin)) = first.first() else { return false };
    let size = first.iter().map(|x| (x.1 - *origin).length()).fold(0.0, f64::max);
    let largest = first.iter().map(|x| x.1.max_abs()).fold(0.0, f64::max);
    let tolerance = COPY_SHARE * size + COORDINATE_ROUNDING * largest;
    first.len() == second.len()
        && first.iter().zip(second).all(|(a, b)| a.0 == b.0 && (a.1 - b.1).length() <= tolerance)
}

fn hash_of(group: usize, edges: &[(u32, u32)]) -> u64 {
    let mut hasher = DefaultHasher::new();
    (group, edges).hash(&mut hasher);
    hasher.finish()
}

/// For each face the earlier face that it copies, if any. A face is a run of plates with one number `face_of[i]`, and only faces of one group
/// (a material, a kind) are compared.
///
/// ```
/// use zonal_math::vec3;
/// use zonal_scene::Plate;
/// use zonal_scene::topology::{FaceCopy, copies};
/// let (a, b, c) = (vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
/// let plates = [Plate::triangle(a, b, c), Plate::triangle(b, c, a), Plate::triangle(a, c, b)];
/// let found = copies(&plates, &[0, 1, 2], &|_| 0);
/// assert_eq!(found, [None, Some(FaceCopy::Repeated(0)), Some(FaceCopy::Opposite(0))]);
/// ```
pub fn copies(
    plates: &[Plate],
    face_of: &[usize],
    group_of: &dyn Fn(usize) -> usize,
) -> Vec<Option<FaceCopy>> {
    let welded = WeldedCorners::of(plates, WELD_TOLERANCE);
    copies_of(plates, face_of, group_of, &welded)
}

fn copies_of(
    plates: &[Plate],
    face_of: &[usize],
    group_of: &dyn Fn(usize) -> usize,
    welded: &WeldedCorners,
) -> Vec<Option<FaceCopy>> {
    let counts: Vec<usize> = plates.iter().map(|p| p.corners().1).collect();
    let mut runs: Vec<std::ops::Range<usize>> = Vec::new();
    for i in 0..plates.len() {
        match runs.last_mut() {
            Some(run) if face_of[run.start] == face_of[i] => run.end = i + 1,
            _ => runs.push(i..i + 1),
        }
    }
    let outline_of =
        |run: &std::ops::Range<usize>| outline(&welded.of_plate[run.clone()], &counts[run.clone()]);
    // Runs by the hash of their outlines, the last first.
    let mut last_of_hash: HashMap<u64, usize> = HashMap::with_capacity(runs.len());
    let mut before = vec![usize::MAX; runs.len()];
    let mut out = vec![None; plates.len()];
    for r in 0..runs.len() {
        let own = outline_of(&runs[r]);
        let group = group_of(runs[r].start);
        let mut reversed: Vec<(u32, u32)> = own.iter().map(|(a, b)| (*b, *a)).collect();
        reversed.sort_unstable();
        let find = |wanted: &[(u32, u32)]| {
            let (mut at, mut found) = (last_of_hash.get(&hash_of(group, wanted)).copied(), None);
            while let Some(k) = at.filter(|k| *k != usize::MAX) {
                if group_of(runs[k].start) == group
                    && outline_of(&runs[k]) == wanted
                    && agree(plates, welded, [&runs[k], &runs[r]])
                {
                    found = Some(k);
                }
                at = Some(before[k]);
            }
            found
        };
        let same = if own.is_empty() { None } else { find(&own) };
        let other = if own.is_empty() || same.is_some() { None } else { find(&reversed) };
        let copy = same
            .map(|k| FaceCopy::Repeated(face_of[runs[k].start]))
            .or(other.map(|k| FaceCopy::Opposite(face_of[runs[k].start])));
        out[runs[r].clone()].fill(copy);
        if same.is_none() {
            before[r] = last_of_hash.insert(hash_of(group, &own), r).unwrap_or(usize::MAX);
        }
    }
    out
}

impl Topology {
    /// The topology of plates whose faces have the numbers `face_of`.
    ///
    /// ```
    /// use zonal_math::vec3;
    /// use zonal_scene::Plate;
    /// use zonal_scene::topology::Topology;
    /// let square = Plate::parallelogram(vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
    /// let found = Topology::of(&[square, square], &[0, 1]);
    /// assert_eq!((found.repeated_faces.count, found.free_edges.count), (1, 4));
    /// ```
    #[must_use]
    pub fn of(plates: &[Plate], face_of: &[usize]) -> Topology {
        let mut out = Topology::default();
        let welded = WeldedCorners::of(plates, WELD_TOLERANCE);
        let copies = copies_of(plates, face_of, &|_| 0, &welded);
        let mut counted = usize::MAX;
        for (i, (p, copy)) in plates.iter().zip(&copies).enumerate() {
            let (face, c) = (face_of[i], p.centre());
            if let Some(copy) = copy.filter(|_| face != counted) {
                counted = face;
                let (list, other) = match copy {
                    FaceCopy::Repeated(k) => (&mut out.repeated_faces, k),
                    FaceCopy::Opposite(k) => (&mut out.opposite_faces, k),
                };
                list.add(DefectPlace { face, other: Some(other), ends: [c; 2] });
            }
            if aspect_ratio(p) > SLIVER_ASPECT_RATIO {
                out.slivers.add(DefectPlace { face, other: None, ends: [c; 2] });
            }
        }
        let is_repeated = |i: usize| matches!(copies[i], Some(FaceCopy::Repeated(_)));
        let mut uses = edge_uses(plates, &welded);
        uses.retain(|u| !is_repeated(u.plate as usize));
        let mut free: Vec<(u32, u32, usize)> = Vec::new();
        for group in uses.chunk_by(|a, b| a.corners == b.corners) {
            let EdgeUse { corners: (a, b), plate, .. } = group[0];
            let forwards = group.iter().filter(|u| u.forwards).count();
            if 2 * forwards == group.len() {
                continue;
            }
            let face = face_of[plate as usize];
            let ends = [a, b].map(|k| welded.points[k as usize]);
            match group.len() {
                1 => {
                    free.push((a, b, face));
                    &mut out.free_edges
                }
                2 => &mut out.flipped_edges,
                _ => &mut out.crowded_edges,
            }
            .add(DefectPlace { face, other: None, ends });
        }
        let corners: Vec<(u32, u32)> = free.iter().map(|(a, b, _)| (*a, *b)).collect();
        for k in TJunctions::of(&corners, &welded).hosts() {
            let (a, b, face) = free[k];
            let ends = [a, b].map(|k| welded.points[k as usize]);
            out.t_junctions.add(DefectPlace { face, other: None, ends });
        }
        out
    }

    /// The defects as pairs of a description and the defect, those that exist.
    pub fn list(&self) -> impl Iterator<Item = (&'static str, Defect)> {
        [
            ("edges of one face", self.free_edges),
            ("edges of three or more faces", self.crowded_edges),
            ("edges between faces of opposite orientation", self.flipped_edges),
            ("repeated faces", self.repeated_faces),
            ("faces with the corners of another in reverse (plates of no thickness)", self.opposite_faces),
            ("edges with a corner of a neighbour in their interior (T-junctions)", self.t_junctions),
            ("needles or slivers", self.slivers),
        ]
        .into_iter()
        .filter(|(_, d)| d.count > 0)
    }
}

/// Longest edge over height.
fn aspect_ratio(p: &Plate) -> f64 {
    let (c, n) = p.corners();
    let longest = (0..n).map(|k| (c[(k + 1) % n] - c[k]).length()).fold(0.0, f64::max);
    let whole = p.e1.cross(p.e2).length();
    longest * longest / whole
}

/// Notes about the meshes of a scene and about its inline shapes: one for each that has defects.
#[must_use]
pub fn survey(scene: &Scene) -> Vec<Diagnostic> {
    let table = scene.faces();
    let starts: Vec<usize> = table
        .meshes
        .iter()
        .scan(0, |next, m| {
            *next += m.faces;
            Some(*next - m.faces)
        })
        .collect();
    let inline = starts.len();
    let mut parts: Vec<(Vec<Plate>, Vec<usize>)> = vec![Default::default(); inline + 1];
    for (k, f) in scene.facets().iter().enumerate() {
        let (part, face) = match table.face_of(k) {
            Some(face) => {
                let mesh = starts.partition_point(|s| *s <= face).saturating_sub(1);
                (mesh, face - starts[mesh])
            }
            None => (inline, k),
        };
        parts[part].0.push(f.plate);
        parts[part].1.push(face);
    }
    let mut out = Vec::new();
    for (m, (plates, faces)) in parts.iter().enumerate().filter(|(_, p)| !p.0.is_empty()) {
        let found = Topology::of(plates, faces);
        if m < inline {
            let text: Vec<String> =
                found.list().map(|(what, d)| described(what, &d, &|p| p.to_string())).collect();
            let place = format!("mesh of surface '{}'", table.meshes[m].name);
            out.extend((!text.is_empty()).then(|| Diagnostic::note("topology", text.join("; ")).at(place)));
            continue;
        }
        // Shapes of a scene stand apart: their borders are no defect.
        let name = |k: usize| scene.surfaces()[scene.facets()[k].surface].name.as_str();
        let place = |p: &DefectPlace| match p.other {
            Some(other) => format!("surfaces '{}' and '{}'", name(other), name(p.face)),
            None => format!("surface '{}'", name(p.face)),
        };
        let defects = found.list().filter(|(_, d)| *d != found.free_edges && *d != found.t_junctions);
        let text: Vec<String> = defects.map(|(what, d)| described(what, &d, &place)).collect();
        out.extend(
            (!text.is_empty())
                .then(|| Diagnostic::note("topology", text.join("; ")).at("shapes of the scene")),
        );
    }
    out
}

fn described(what: &str, d: &Defect, place: &dyn Fn(&DefectPlace) -> String) -> String {
    let first = d.first.map_or(String::new(), |p| format!(" (first: {})", place(&p)));
    format!("{} {what}{first}", d.count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    fn square(at: Vec3) -> Plate {
        Plate::parallelogram(at, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0))
    }

    fn of(plates: &[Plate]) -> Topology {
        Topology::of(plates, &(0..plates.len()).collect::<Vec<_>>())
    }

    #[test]
    fn sheets_close_to_one_another_are_no_copies() {
        // The far plate makes the welding tolerance a centimetre.
        let far = square(vec3(1e4, 0.0, 0.0));
        for (gap, copies) in [(0.0, 1), (1e-7, 1), (5e-3, 0), (5e-2, 0)] {
            let found = of(&[square(Vec3::ZERO), square(vec3(0.0, 0.0, gap)), far]);
            assert_eq!(found.repeated_faces.count, copies, "{gap}");
        }
    }

    #[test]
    fn edges_of_three_faces_and_turned_neighbours_are_counted() {
        let wall = Plate::parallelogram(vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0));
        let next = square(vec3(1.0, 0.0, 0.0));
        let three = of(&[square(Vec3::ZERO), next, wall]);
        assert_eq!((three.crowded_edges.count, three.free_edges.count), (1, 9));
        let place = three.crowded_edges.first.unwrap();
        assert!(place.ends.iter().all(|p| p.x == 1.0 && p.z == 0.0), "{place}");
        let turned = of(&[square(Vec3::ZERO), next.flipped()]);
        assert_eq!((turned.flipped_edges.count, turned.free_edges.count), (1, 6));
        // Repeated faces do not crowd edges.
        let twice = of(&[square(Vec3::ZERO), next, next, next.flipped()]);
        assert_eq!((twice.repeated_faces.count, twice.opposite_faces.count), (1, 1));
    }

    #[test]
    fn slivers_and_t_junctions_are_counted() {
        let needle = Plate::triangle(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.5, 1e-3, 0.0));
        assert_eq!(of(&[needle]).slivers.count, 1);
        assert_eq!(of(&[square(Vec3::ZERO)]).slivers.count, 0);
        let half = |x: f64| Plate::parallelogram(vec3(x, 1.0, 0.0), vec3(0.5, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        let found = of(&[square(Vec3::ZERO), half(0.0), half(0.5)]);
        assert_eq!(found.t_junctions.count, 1);
        assert_eq!(found.t_junctions.first.unwrap().face, 0);
    }
}
