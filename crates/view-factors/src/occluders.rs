//! Occluders: the polygons of a mesh with coplanar neighbours merged, so that a wall of many facets is one obstruction.
//!
//! Facets that share an edge and a plane form a component. A component whose outline is convex becomes one polygon. The facets of any other
//! component are merged in pairs along common edges as long as the union is convex. The union of the occluders is that of the
//! facets; corners move by at most the contact distance, onto the plane of the component's first facet.

use std::collections::HashMap;
use zonal_exchange::polygon::visible::ConvexPolygon;
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

/// Polygons that hide, and the convex solids that some of them bound.
#[derive(Clone, Debug, Default)]
pub(crate) struct MergedOccluders {
    /// Each polygon with its solid, if any.
    pub polygons: Vec<(ConvexPolygon, Option<u32>)>,
    pub solids: Vec<ConvexSolid>,
}

/// The occluders of `polygons`: facets within `contact` (m) of a common plane are merged; a sheet given from both sides counts once.
pub(crate) fn merged_occluders(polygons: &[&ConvexPolygon], contact: f64) -> MergedOccluders {
    let outlines = Outlines::new(polygons, contact);
    let single = without_twins(&outlines.loops);
    let components = coplanar_components(&outlines, polygons, &single, contact);
    let (solid_of, solids) = convex_solids(&outlines, polygons, &components, contact);
    let mut made = MergedOccluders { polygons: Vec::new(), solids };
    for (component, solid) in components.iter().zip(&solid_of) {
        let merged = merged_component(&outlines, polygons, component);
        made.polygons.extend(merged.into_iter().map(|p| (p, *solid)));
    }
    made
}

/// The facets of one plane in few convex polygons.
fn merged_component(
    outlines: &Outlines,
    polygons: &[&ConvexPolygon],
    component: &[usize],
) -> Vec<ConvexPolygon> {
    let (at, normal) = (polygons[component[0]].corners()[0], polygons[component[0]].normal());
    let facets = || component.iter().map(|k| polygons[*k].clone()).collect();
    if component.len() == 1 {
        return facets();
    }
    if let Some(whole) =
        convex_outline(outlines, component, normal).and_then(|o| outlines.polygon(&o, at, normal))
    {
        return vec![whole];
    }
    let loops = component.iter().map(|k| outlines.loops[*k].clone()).collect();
    let merged = merge_in_pairs(outlines, loops, normal);
    // Where rounding makes a union of pairs concave, the facets serve.
    merged.iter().map(|o| outlines.polygon(o, at, normal)).collect::<Option<_>>().unwrap_or_else(facets)
}

/// The planes of a convex solid that holds nothing visible: no segment passes through it.
#[derive(Clone, Debug)]
pub(crate) struct ConvexSolid {
    /// (n, c): n·x ≤ c inside.
    pub planes: Vec<(Vec3, f64)>,
}

/// Planes of a solid at most: the test takes all of them.
const MAX_SOLID_PLANES: usize = 24;

/// The solid of each component, if any. Components that meet in convex edges form a shell. It bounds a solid if all its corners lie
/// behind all its planes and its open edges lie in one plane: a segment that enters through that opening leaves through the shell.
fn convex_solids(
    outlines: &Outlines,
    polygons: &[&ConvexPolygon],
    components: &[Vec<usize>],
    contact: f64,
) -> (Vec<Option<u32>>, Vec<ConvexSolid>) {
    let mut component_of = vec![usize::MAX; polygons.len()];
    for (c, members) in components.iter().enumerate() {
        members.iter().for_each(|k| component_of[*k] = c);
    }
    let mut by_edge: HashMap<(Corner, Corner), usize> = HashMap::new();
    for k in components.iter().flatten() {
        Outlines::edges(&outlines.loops[*k]).for_each(|e| {
            by_edge.insert(e, *k);
        });
    }
    let behind = |p: usize, q: usize| polygons[q].corners().iter().all(|c| polygons[p].height(*c) <= contact);
    let mut solid_of = vec![None; components.len()];
    let mut visited = vec![false; components.len()];
    let mut solids = Vec::new();
    for seed in 0..components.len() {
        if std::mem::replace(&mut visited[seed], true) {
            continue;
        }
        let (mut shell, mut open, mut next) = (vec![seed], Vec::new(), 0);
        while next < shell.len() {
            for &k in &components[shell[next]] {
                for (a, b) in Outlines::edges(&outlines.loops[k]) {
                    match by_edge.get(&(b, a)).map(|o| (*o, component_of[*o])) {
                        Some((_, c)) if c == shell[next] => {}
                        Some((o, c)) if behind(k, o) && behind(o, k) => {
                            if !std::mem::replace(&mut visited[c], true) {
                                shell.push(c);
                            }
                        }
                        _ => open.extend([a, b]),
                    }
                }
            }
            next += 1;
        }
        if let Some(solid) = solid_of_shell(outlines, polygons, components, (&shell, &open), contact) {
            shell.iter().for_each(|c| solid_of[*c] = Some(solids.len() as u32));
            solids.push(solid);
        }
    }
    (solid_of, solids)
}

fn solid_of_shell(
    outlines: &Outlines,
    polygons: &[&ConvexPolygon],
    components: &[Vec<usize>],
    (shell, open): (&[usize], &[Corner]),
    contact: f64,
) -> Option<ConvexSolid> {
    if shell.len() < 2 || shell.len() >= MAX_SOLID_PLANES {
        return None;
    }
    let corners = || shell.iter().flat_map(|c| &components[*c]).flat_map(|k| polygons[*k].corners());
    let plane = |c: &usize| {
        let first = polygons[components[*c][0]];
        (first.normal(), first.normal().dot(first.corners()[0]))
    };
    let mut planes: Vec<(Vec3, f64)> = shell.iter().map(plane).collect();
    if let Some(cap) = opening_plane(outlines, open, contact)? {
        let side = corners()
            .map(|c| cap.0.dot(*c) - cap.1)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        match side {
            (_, high) if high <= contact => planes.push(cap),
            (low, _) if low >= -contact => planes.push((-cap.0, -cap.1)),
            _ => return None,
        }
    }
    let convex = planes.iter().all(|(n, c)| corners().all(|x| n.dot(*x) - c <= contact));
    convex.then_some(ConvexSolid { planes })
}

/// The plane of the open edges: Some(None) without open edges, None if they lie in no plane.
fn opening_plane(outlines: &Outlines, open: &[Corner], contact: f64) -> Option<Option<(Vec3, f64)>> {
    let Some(first) = open.first().map(|c| outlines.point(*c)) else { return Some(None) };
    let points = || open.iter().map(|c| outlines.point(*c) - first);
    let far = points().max_by(|a, b| a.length2().total_cmp(&b.length2()))?;
    let normal =
        points().map(|p| p.cross(far)).max_by(|a, b| a.length2().total_cmp(&b.length2()))?.normalized();
    let flat = normal.length() > 0.5 && points().all(|p| normal.dot(p).abs() <= contact);
    flat.then_some(Some((normal, normal.dot(first))))
}

/// The polygons without those whose corners another one has in any order.
fn without_twins(loops: &[Vec<Corner>]) -> Vec<usize> {
    let mut seen = std::collections::HashSet::new();
    let key = |k: &usize| {
        let mut corners = loops[*k].clone();
        corners.sort_unstable();
        corners
    };
    (0..loops.len()).filter(|k| seen.insert(key(k))).collect()
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

/// The outline of a component if it is one convex loop.
fn convex_outline(outlines: &Outlines, component: &[usize], normal: Vec3) -> Option<Vec<Corner>> {
    let edges: std::collections::HashSet<(Corner, Corner)> =
        component.iter().flat_map(|k| Outlines::edges(&outlines.loops[*k])).collect();
    let mut next: HashMap<Corner, Corner> = HashMap::new();
    for &(a, b) in edges.iter().filter(|(a, b)| !edges.contains(&(*b, *a))) {
        if next.insert(a, b).is_some() {
            return None;
        }
    }
    let start = *next.keys().min()?;
    let mut outline = vec![start];
    loop {
        let to = *next.get(outline.last()?)?;
        if to == start {
            break;
        }
        outline.push(to);
        if outline.len() > next.len() {
            return None;
        }
    }
    if outline.len() != next.len() {
        return None;
    }
    let outline = outlines.without_straight_corners(&outline, normal);
    outlines.is_convex(&outline, normal).then_some(outline)
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
                    outlines.without_straight_corners(&joined(&loops[k], &loops[other], (a, b)), normal);
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
fn joined(first: &[Corner], second: &[Corner], (a, b): (Corner, Corner)) -> Vec<Corner> {
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

    #[test]
    fn a_wall_of_triangles_is_one_occluder() {
        let wall = grid(5, 3, &[]);
        let merged = merged_occluders(&wall.iter().collect::<Vec<_>>(), 1e-9);
        assert_eq!((merged.polygons.len(), merged.solids.len()), (1, 0));
        let wall = &merged.polygons[0].0;
        assert_eq!((wall.corners().len(), wall.area()), (4, 15.0));
        assert_eq!(wall.normal(), vec3(0.0, 0.0, 1.0));
    }

    #[test]
    fn merged_occluders_have_the_area_of_the_facets() {
        let ground = grid(6, 6, &[(2, 2), (2, 3), (4, 0)]);
        let merged = merged_occluders(&ground.iter().collect::<Vec<_>>(), 1e-9).polygons;
        let area: f64 = merged.iter().map(|p| p.0.area()).sum();
        assert!((area - 33.0).abs() < 1e-9 && merged.len() < 16, "{area} {}", merged.len());
    }

    #[test]
    fn folds_and_twins_are_kept_apart() {
        let (a, b, c, d) = ([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]);
        let fold = [triangle([a, b, c]), triangle([a, c, d]), triangle([c, b, a])];
        assert_eq!(merged_occluders(&fold.iter().collect::<Vec<_>>(), 1e-9).polygons.len(), 2);
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
    fn a_box_with_at_most_one_open_side_is_a_solid() {
        for (missing, solids, planes) in
            [(vec![], 1, 6), (vec![4], 1, 6), (vec![4, 5], 0, 0), (vec![0, 2], 0, 0)]
        {
            let faces = cube(&missing);
            let merged = merged_occluders(&faces.iter().collect::<Vec<_>>(), 1e-9);
            assert_eq!(
                (merged.polygons.len(), merged.solids.len()),
                (6 - missing.len(), solids),
                "{missing:?}"
            );
            assert!(merged.solids.iter().all(|s| s.planes.len() == planes));
        }
    }
}
