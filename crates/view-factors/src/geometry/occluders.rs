//! Occluders: the polygons of a mesh with coplanar neighbours merged, so that a wall of many facets is one obstruction.
//!
//! Facets that share an edge and a plane form a component. A component whose outline is convex becomes one polygon. The facets of any other
//! component are merged in pairs along common edges as long as the union is convex. Holes that are openings of solids are filled first: what passes
//! there has met the solid. Components that bound a convex solid are one obstruction, which is
//! hidden by its silhouette. The union of the occluders is that of the facets and of these solids; corners move by at most the contact distance,
//! onto the plane of the component's first facet.

use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap, HashSet};
use zonal_exchange::polygon::visible::{ConvexBody, ConvexPolygon};
use zonal_math::Vec3;

/// Sine of the angle between two edges below which their common corner is no corner.
const MAX_SINE_OF_STRAIGHT_EDGES: f64 = 1e-6;
/// Rounds of merging in pairs; each at least halves what a row or a column of facets leaves.
const MAX_MERGING_ROUNDS: usize = 32;

/// A corner by number.
type Corner = u32;

/// Polygons by numbered corners.
struct Outlines {
    points: Vec<Vec3>,
    loops: Vec<Vec<Corner>>,
}

impl Outlines {
    /// Numbers the corners; corners within `contact` (m) of each other are one.
    fn new(polygons: &[&ConvexPolygon], contact: f64) -> Outlines {
        let cell_size = (4.0 * contact).max(f64::MIN_POSITIVE);
        let mut cells: HashMap<[i64; 3], Vec<Corner>> = HashMap::new();
        let mut points: Vec<Vec3> = Vec::new();
        let mut number = |p: &Vec3| {
            let cell = p.array().map(|x| (x / cell_size).floor() as i64);
            let near = (0..27).find_map(|k| {
                let beside = [k % 3, k / 3 % 3, k / 9];
                let at = std::array::from_fn(|i| cell[i].saturating_add(beside[i] - 1));
                let close = |c: &&Corner| (points[**c as usize] - *p).max_abs() <= contact;
                cells.get(&at).and_then(|list| list.iter().find(close)).copied()
            });
            near.unwrap_or_else(|| {
                points.push(*p);
                let made = (points.len() - 1) as Corner;
                cells.entry(cell).or_default().push(made);
                made
            })
        };
        let loops = polygons.iter().map(|p| p.corners().iter().map(&mut number).collect()).collect();
        Outlines { points, loops }
    }

    fn point(&self, c: Corner) -> Vec3 {
        self.points[c as usize]
    }

    /// The directed edges of a loop.
    fn edges(outline: &[Corner]) -> impl Iterator<Item = (Corner, Corner)> + '_ {
        (0..outline.len()).map(|k| (outline[k], outline[(k + 1) % outline.len()]))
    }

    /// The loop without corners between edges of one direction.
    fn without_straight_corners(&self, outline: &[Corner], normal: Vec3) -> Vec<Corner> {
        let n = outline.len();
        let turns =
            |k: usize| self.turn([outline[(k + n - 1) % n], outline[k], outline[(k + 1) % n]], normal);
        (0..n).filter(|k| turns(*k).abs() > MAX_SINE_OF_STRAIGHT_EDGES).map(|k| outline[k]).collect()
    }

    /// Sine of the turn at the middle one of three corners, positive to the left as seen from the tip of the normal.
    fn turn(&self, [a, b, c]: [Corner; 3], normal: Vec3) -> f64 {
        let (e, f) = (self.point(b) - self.point(a), self.point(c) - self.point(b));
        let lengths = e.length() * f.length();
        if lengths > 0.0 { normal.dot(e.cross(f)) / lengths } else { 0.0 }
    }

    fn is_convex(&self, outline: &[Corner], normal: Vec3) -> bool {
        let n = outline.len();
        let left = |k: usize| {
            self.turn([outline[k], outline[(k + 1) % n], outline[(k + 2) % n]], normal)
                >= -MAX_SINE_OF_STRAIGHT_EDGES
        };
        // A loop that turns left at every corner may still wind twice: its turns sum to one circle only in a simple one.
        let angle = |k: usize| {
            let (a, b, c) = (outline[k], outline[(k + 1) % n], outline[(k + 2) % n]);
            let (e, f) = (self.point(b) - self.point(a), self.point(c) - self.point(b));
            normal.dot(e.cross(f)).atan2(e.dot(f))
        };
        n >= 3 && (0..n).all(left) && (0..n).map(angle).sum::<f64>() < 3.0 * std::f64::consts::PI
    }

    fn polygon(&self, outline: &[Corner], at: Vec3, normal: Vec3) -> Option<ConvexPolygon> {
        let on_plane = |c: &Corner| {
            let p = self.point(*c);
            p - normal * normal.dot(p - at)
        };
        ConvexPolygon::new(outline.iter().map(on_plane).collect())
    }
}

/// An obstruction.
#[derive(Clone, Debug)]
pub(crate) struct MergedOccluder {
    pub body: ConvexBody,
    /// True if the last face of a solid is its opening: no facet lies there.
    pub has_opening: bool,
}

/// The obstructions of `polygons`, plates and solids: facets within `contact` (m) of a common plane are merged; a sheet given from both sides
/// counts once.
pub(crate) fn merged_occluders(polygons: &[&ConvexPolygon], contact: f64) -> Vec<MergedOccluder> {
    let outlines = Outlines::new(polygons, contact);
    let (single, has_twin) = without_twins(&outlines.loops);
    let components = coplanar_components(&outlines, polygons, &single, contact);
    let SolidShells { is_part, solids: mut made, openings } =
        convex_solids(&outlines, polygons, &components, &has_twin, contact);
    let others = components.iter().zip(&is_part).filter(|(_, is_part)| !**is_part);
    let plates = others.flat_map(|(c, _)| merged_component(&outlines, polygons, c, &openings)).collect();
    let plate = |p: &ConvexPolygon| MergedOccluder { body: ConvexBody::plate(p), has_opening: false };
    made.extend(merged_plates(plates, contact).iter().map(plate));
    made
}

/// Plates merged again as long as some join: components whose facets did not share edges may have outlines that do.
pub(crate) fn merged_plates(mut plates: Vec<ConvexPolygon>, contact: f64) -> Vec<ConvexPolygon> {
    for _ in 0..MAX_MERGING_ROUNDS {
        let polygons: Vec<&ConvexPolygon> = plates.iter().collect();
        let outlines = Outlines::new(&polygons, contact);
        let all: Vec<usize> = (0..plates.len()).collect();
        let components = coplanar_components(&outlines, &polygons, &all, contact);
        let merge = |c: &Vec<usize>| merged_component(&outlines, &polygons, c, &HashSet::new());
        let merged: Vec<ConvexPolygon> = components.iter().flat_map(merge).collect();
        let is_final = merged.len() == plates.len();
        plates = merged;
        if is_final {
            break;
        }
    }
    plates
}

/// Directed edges.
type Edges = HashSet<(Corner, Corner)>;

/// The solids of a mesh.
struct SolidShells {
    /// Whether each component is part of a solid.
    is_part: Vec<bool>,
    solids: Vec<MergedOccluder>,
    /// The outline of each opening from its smallest corner on, in the direction of a face that closes it from outside.
    openings: HashSet<Vec<Corner>>,
}

/// The facets of one plane in few convex polygons.
fn merged_component(
    outlines: &Outlines,
    polygons: &[&ConvexPolygon],
    component: &[usize],
    openings: &HashSet<Vec<Corner>>,
) -> Vec<ConvexPolygon> {
    let (at, normal) = (polygons[component[0]].corners()[0], polygons[component[0]].normal());
    let facets = || component.iter().map(|k| polygons[*k].clone()).collect();
    if component.len() == 1 {
        return facets();
    }
    // Holes that are openings are filled.
    let boundary = loops_of(boundary(outlines, component).into_iter()).unwrap_or_default();
    let is_filled = |outline: &Vec<Corner>| {
        openings.contains(&from_smallest(outlines.without_straight_corners(outline, normal)))
    };
    let (filled, open): (Vec<_>, Vec<_>) = boundary.into_iter().partition(is_filled);
    if let [outline] = open.as_slice()
        && let Some(outline) = convex_outline(outlines, outline, normal)
        && let Some(whole) = outlines.polygon(&outline, at, normal)
    {
        return vec![whole];
    }
    let mut loops: Vec<Vec<Corner>> = component.iter().map(|k| outlines.loops[*k].clone()).collect();
    loops.extend(filled.into_iter().map(|outline| outline.into_iter().rev().collect()));
    let merged = merge_in_pairs(outlines, loops, normal);
    // Where rounding makes a union of pairs concave, the facets serve.
    merged.iter().map(|o| outlines.polygon(o, at, normal)).collect::<Option<_>>().unwrap_or_else(facets)
}

/// The solids, and whether each component is part of one. Components that meet in convex edges form a shell. It bounds a solid if all its corners
/// lie behind all its planes and its open edges lie in one plane: a segment that enters through that opening leaves through the shell. A shell with a facet that
/// has a twin bounds none: something is seen from within.
fn convex_solids(
    outlines: &Outlines,
    polygons: &[&ConvexPolygon],
    components: &[Vec<usize>],
    has_twin: &[bool],
    contact: f64,
) -> SolidShells {
    let adjacency = Adjacency::new(outlines, polygons, components, contact);
    let mut made =
        SolidShells { is_part: vec![false; components.len()], solids: Vec::new(), openings: HashSet::new() };
    let mut visited = vec![false; components.len()];
    for seed in 0..components.len() {
        if std::mem::replace(&mut visited[seed], true) {
            continue;
        }
        let (shell, open) = adjacency.shell(seed, &mut visited);
        if shell.iter().flat_map(|c| &components[*c]).any(|k| has_twin[*k]) {
            continue;
        }
        let opening = if open.is_empty() { None } else { opening(outlines, open, contact) };
        if let Some(solid) = solid_of_shell(outlines, polygons, &shell, components, opening.as_ref(), contact)
        {
            shell.iter().for_each(|c| made.is_part[*c] = true);
            made.solids.push(solid);
            made.openings.extend(opening);
        }
    }
    made
}

/// Which components meet in convex edges.
struct Adjacency<'a> {
    outlines: &'a Outlines,
    polygons: &'a [&'a ConvexPolygon],
    components: &'a [Vec<usize>],
    component_of: Vec<usize>,
    by_edge: HashMap<(Corner, Corner), usize>,
    contact: f64,
}

impl<'a> Adjacency<'a> {
    fn new(
        outlines: &'a Outlines,
        polygons: &'a [&'a ConvexPolygon],
        components: &'a [Vec<usize>],
        contact: f64,
    ) -> Adjacency<'a> {
        let mut component_of = vec![usize::MAX; polygons.len()];
        for (c, members) in components.iter().enumerate() {
            members.iter().for_each(|k| component_of[*k] = c);
        }
        let edges_of = |k: &usize| {
            let k = *k;
            Outlines::edges(&outlines.loops[k]).map(move |e| (e, k))
        };
        let by_edge = components.iter().flatten().flat_map(edges_of).collect();
        Adjacency { outlines, polygons, components, component_of, by_edge, contact }
    }

    /// True if facets `p` and `q`, which share an edge, lie behind each other.
    fn is_convex_edge(&self, p: usize, q: usize) -> bool {
        let behind = |p: usize, q: usize| {
            self.polygons[q].corners().iter().all(|c| self.polygons[p].height(*c) <= self.contact)
        };
        behind(p, q) && behind(q, p)
    }

    /// The components that convex edges connect with `seed`, and their other edges, each in the direction of a face that would close them.
    fn shell(&self, seed: usize, visited: &mut [bool]) -> (Vec<usize>, Vec<(Corner, Corner)>) {
        let (mut shell, mut open, mut next) = (vec![seed], Vec::new(), 0);
        while next < shell.len() {
            for &k in &self.components[shell[next]] {
                for (a, b) in Outlines::edges(&self.outlines.loops[k]) {
                    match self.by_edge.get(&(b, a)).map(|o| (*o, self.component_of[*o])) {
                        Some((_, c)) if c == shell[next] => {}
                        Some((o, c)) if self.is_convex_edge(k, o) => {
                            if !std::mem::replace(&mut visited[c], true) {
                                shell.push(c);
                            }
                        }
                        _ => open.push((b, a)),
                    }
                }
            }
            next += 1;
        }
        (shell, open)
    }
}

/// The solid of a shell, which lists its components, closed by a face over its opening.
fn solid_of_shell(
    outlines: &Outlines,
    polygons: &[&ConvexPolygon],
    shell: &[usize],
    components: &[Vec<usize>],
    opening: Option<&Vec<Corner>>,
    contact: f64,
) -> Option<MergedOccluder> {
    if shell.len() < 2 {
        return None;
    }
    let face = |c: &usize| {
        let normal = polygons[components[*c][0]].normal();
        match loops_of(boundary(outlines, &components[*c]).into_iter())?.as_slice() {
            [outline] => convex_outline(outlines, outline, normal),
            _ => None,
        }
    };
    let mut faces: Vec<Vec<Corner>> = shell.iter().map(face).collect::<Option<_>>()?;
    faces.extend(opening.cloned());
    let mut numbers: Vec<Corner> = faces.iter().flatten().copied().collect();
    numbers.sort_unstable();
    numbers.dedup();
    let number = |c: &Corner| numbers.binary_search(c).ok().map(|k| k as u32);
    let faces: Vec<Vec<u32>> = faces.iter().map(|f| f.iter().map(number).collect()).collect::<Option<_>>()?;
    let body = ConvexBody::solid(numbers.iter().map(|c| outlines.point(*c)).collect(), &faces, contact)?;
    Some(MergedOccluder { body, has_opening: opening.is_some() })
}

/// The outline of an opening from its smallest corner on, if its directed edges lie in one plane and form one convex loop.
fn opening(outlines: &Outlines, edges: Vec<(Corner, Corner)>, contact: f64) -> Option<Vec<Corner>> {
    let loops = loops_of(edges.into_iter())?;
    let [outline] = loops.as_slice() else { return None };
    let at = |k: usize| outlines.point(outline[k]) - outlines.point(outline[0]);
    let normal = (2..outline.len()).fold(Vec3::ZERO, |s, k| s + at(k - 1).cross(at(k))).normalized();
    let is_flat = normal.length() > 0.5 && (0..outline.len()).all(|k| normal.dot(at(k)).abs() <= contact);
    is_flat.then(|| convex_outline(outlines, outline, normal)).flatten().map(from_smallest)
}

/// The polygons without those whose corners an earlier one has in any order, and whether each polygon has such a twin.
fn without_twins(loops: &[Vec<Corner>]) -> (Vec<usize>, Vec<bool>) {
    let mut first: HashMap<Vec<Corner>, usize> = HashMap::new();
    let (mut single, mut has_twin) = (Vec::new(), vec![false; loops.len()]);
    for (k, outline) in loops.iter().enumerate() {
        let mut corners = outline.clone();
        corners.sort_unstable();
        match first.entry(corners) {
            Entry::Vacant(place) => {
                place.insert(k);
                single.push(k);
            }
            Entry::Occupied(place) => (has_twin[*place.get()], has_twin[k]) = (true, true),
        }
    }
    (single, has_twin)
}

/// Polygons that share edges and a plane, each component in the order in which it was found.
fn coplanar_components(
    outlines: &Outlines,
    polygons: &[&ConvexPolygon],
    single: &[usize],
    contact: f64,
) -> Vec<Vec<usize>> {
    let mut by_edge: HashMap<(Corner, Corner), Option<usize>> = HashMap::new();
    for &k in single {
        // An edge that two polygons have in the same direction joins nothing.
        for e in Outlines::edges(&outlines.loops[k]) {
            by_edge.entry(e).and_modify(|owner| *owner = None).or_insert(Some(k));
        }
    }
    let mut taken = vec![false; polygons.len()];
    let mut components = Vec::new();
    for &seed in single {
        if std::mem::replace(&mut taken[seed], true) {
            continue;
        }
        let mut component = vec![seed];
        let coplanar = |k: usize| {
            polygons[k].normal().dot(polygons[seed].normal()) > 0.0
                && polygons[k].corners().iter().all(|c| polygons[seed].height(*c).abs() <= contact)
        };
        let mut next = 0;
        while next < component.len() {
            for (a, b) in Outlines::edges(&outlines.loops[component[next]]) {
                if let Some(Some(k)) = by_edge.get(&(b, a)).copied()
                    && !taken[k]
                    && coplanar(k)
                {
                    taken[k] = true;
                    component.push(k);
                }
            }
            next += 1;
        }
        components.push(component);
    }
    components
}

/// The edges of a component that only one of its facets has.
fn boundary(outlines: &Outlines, component: &[usize]) -> Edges {
    let edges: Edges = component.iter().flat_map(|k| Outlines::edges(&outlines.loops[*k])).collect();
    edges.iter().filter(|(a, b)| !edges.contains(&(*b, *a))).copied().collect()
}

/// A loop without its straight corners, if it is convex.
fn convex_outline(outlines: &Outlines, outline: &[Corner], normal: Vec3) -> Option<Vec<Corner>> {
    let outline = outlines.without_straight_corners(outline, normal);
    outlines.is_convex(&outline, normal).then_some(outline)
}

/// A loop from its smallest corner on.
fn from_smallest(mut outline: Vec<Corner>) -> Vec<Corner> {
    let smallest = (0..outline.len()).min_by_key(|k| outline[*k]).unwrap_or(0);
    outline.rotate_left(smallest);
    outline
}

/// The loops that directed edges form, each from its smallest corner on, in ascending order; None if two begin at one corner or one does not close.
fn loops_of(edges: impl Iterator<Item = (Corner, Corner)>) -> Option<Vec<Vec<Corner>>> {
    let mut next: BTreeMap<Corner, Corner> = BTreeMap::new();
    for (a, b) in edges {
        if next.insert(a, b).is_some() {
            return None;
        }
    }
    let mut loops = Vec::new();
    while let Some((start, mut to)) = next.pop_first() {
        let mut outline = vec![start];
        while to != start {
            outline.push(to);
            to = next.remove(&to)?;
        }
        loops.push(outline);
    }
    Some(loops)
}

/// Loops merged in pairs along a common edge while the union is convex.
fn merge_in_pairs(outlines: &Outlines, mut loops: Vec<Vec<Corner>>, normal: Vec3) -> Vec<Vec<Corner>> {
    for _ in 0..MAX_MERGING_ROUNDS {
        let by_edge: HashMap<(Corner, Corner), usize> =
            loops.iter().enumerate().flat_map(|(k, l)| Outlines::edges(l).map(move |e| (e, k))).collect();
        let mut merged = vec![false; loops.len()];
        let mut after = Vec::new();
        for k in 0..loops.len() {
            if merged[k] {
                continue;
            }
            let partner = Outlines::edges(&loops[k]).find_map(|(a, b)| {
                let other = *by_edge.get(&(b, a))?;
                (other != k && !merged[other]).then_some(())?;
                let union =
                    outlines.without_straight_corners(&joined(&loops[k], &loops[other], a, b), normal);
                outlines.is_convex(&union, normal).then_some((other, union))
            });
            if let Some((other, union)) = partner {
                (merged[k], merged[other]) = (true, true);
                after.push(union);
            }
        }
        if after.is_empty() {
            break;
        }
        after.extend((0..loops.len()).filter(|k| !merged[*k]).map(|k| loops[k].clone()));
        loops = after;
    }
    loops
}

/// The union of two loops along edge (a, b) of the first, which is (b, a) of the second.
fn joined(first: &[Corner], second: &[Corner], a: Corner, b: Corner) -> Vec<Corner> {
    let from = |outline: &[Corner], start: Corner| {
        let k = outline.iter().position(|c| *c == start).unwrap_or(0);
        outline.iter().cycle().skip(k).take(outline.len()).copied().collect::<Vec<_>>()
    };
    // From b around the first to a, then from a around the second to b.
    let (one, two) = (from(first, b), from(second, a));
    one.iter().chain(&two[1..two.len() - 1]).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    fn triangle(c: [[f64; 3]; 3]) -> ConvexPolygon {
        ConvexPolygon::new(c.map(Vec3::from_array).to_vec()).expect("a triangle")
    }

    /// n × m cells of two triangles each, without the cells in `holes`.
    fn grid(n: usize, m: usize, holes: &[(usize, usize)]) -> Vec<ConvexPolygon> {
        let at = |i: usize, j: usize| [i as f64, j as f64, 0.0];
        let mut out = Vec::new();
        for i in 0..n {
            for j in (0..m).filter(|j| !holes.contains(&(i, *j))) {
                let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                out.push(triangle([a, b, c]));
                out.push(triangle([a, c, d]));
            }
        }
        out
    }

    /// The area of a plate's outline.
    fn area(plate: &ConvexBody) -> f64 {
        ConvexPolygon::new(plate.corners().to_vec()).expect("a plate").area()
    }

    #[test]
    fn a_wall_of_triangles_is_one_occluder() {
        let wall = grid(5, 3, &[]);
        let merged = merged_occluders(&wall.iter().collect::<Vec<_>>(), 1e-9);
        assert!(merged.len() == 1 && merged[0].body.is_plate());
        assert_eq!((merged[0].body.corners().len(), area(&merged[0].body)), (4, 15.0));
        assert_eq!(merged[0].body.planes()[0].0, vec3(0.0, 0.0, 1.0));
    }

    #[test]
    fn merged_occluders_have_the_area_of_the_facets() {
        let ground = grid(6, 6, &[(2, 2), (2, 3), (4, 0)]);
        let merged = merged_occluders(&ground.iter().collect::<Vec<_>>(), 1e-9);
        let area: f64 = merged.iter().map(|o| area(&o.body)).sum();
        assert!((area - 33.0).abs() < 1e-9 && merged.len() < 16, "{area} {}", merged.len());
    }

    #[test]
    fn folds_and_twins_are_kept_apart() {
        let (a, b, c, d) = ([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]);
        let fold = [triangle([a, b, c]), triangle([a, c, d]), triangle([c, b, a])];
        assert_eq!(merged_occluders(&fold.iter().collect::<Vec<_>>(), 1e-9).len(), 2);
    }

    /// The faces of the unit cube in triangles, outwards, without those in `missing`.
    fn cube(missing: &[usize]) -> Vec<ConvexPolygon> {
        let mut out = Vec::new();
        for face in (0..6).filter(|f| !missing.contains(f)) {
            let (axis, high) = (face / 2, face % 2);
            let at = |u: usize, v: usize| {
                let mut x = [0.0; 3];
                (x[axis], x[(axis + 1) % 3], x[(axis + 2) % 3]) = (high as f64, u as f64, v as f64);
                x
            };
            let mut c = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
            if high == 0 {
                c.reverse();
            }
            out.extend([triangle([c[0], c[1], c[2]]), triangle([c[0], c[2], c[3]])]);
        }
        out
    }

    #[test]
    fn a_box_of_two_sides_is_no_solid() {
        let mut faces = cube(&[]);
        let backs: Vec<ConvexPolygon> = faces
            .iter()
            .map(|p| ConvexPolygon::new(p.corners().iter().rev().copied().collect()).expect("a triangle"))
            .collect();
        faces.extend(backs);
        let merged = merged_occluders(&faces.iter().collect::<Vec<_>>(), 1e-9);
        assert!(merged.len() == 6 && merged.iter().all(|o| o.body.is_plate()), "{}", merged.len());
    }

    /// A box without its bottom that stands on a ground with a hole of that size.
    #[test]
    fn the_ground_under_a_solid_is_filled() {
        let mut all = cube(&[4]);
        for (i, j) in (-1..2).flat_map(|i| (-1..2).map(move |j| (f64::from(i), f64::from(j)))) {
            if (i, j) != (0.0, 0.0) {
                let c = [[i, j, 0.0], [i + 1.0, j, 0.0], [i + 1.0, j + 1.0, 0.0], [i, j + 1.0, 0.0]];
                all.extend([triangle([c[0], c[1], c[2]]), triangle([c[0], c[2], c[3]])]);
            }
        }
        let merged = merged_occluders(&all.iter().collect::<Vec<_>>(), 1e-9);
        assert_eq!(merged.iter().map(|o| o.body.is_plate()).collect::<Vec<_>>(), [false, true]);
        assert_eq!(area(&merged[1].body), 9.0);
    }

    #[test]
    fn a_box_with_at_most_one_open_side_is_a_solid() {
        for (missing, solids, plates) in
            [(vec![], 1, 0), (vec![4], 1, 0), (vec![4, 5], 0, 4), (vec![0, 2], 0, 4)]
        {
            let faces = cube(&missing);
            let merged = merged_occluders(&faces.iter().collect::<Vec<_>>(), 1e-9);
            let of_kind = |plate: bool| merged.iter().filter(|o| o.body.is_plate() == plate).count();
            assert_eq!((of_kind(false), of_kind(true)), (solids, plates), "{missing:?}");
            assert!(merged.iter().filter(|o| !o.body.is_plate()).all(|o| o.body.planes().len() == 6));
        }
    }
}
