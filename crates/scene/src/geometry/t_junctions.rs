//! T-junctions: free edges with a corner of another free edge in their interior.
//!
//! Two faces meet along a line that one of them divides by a corner and the other does not: no hole, but the edges do not pair. A *host* is a free edge
//! with such a corner. Faces whose every free edge is a host, or lies on one, pair geometrically.
//!
//! **Cost:** O(n log n) for n free edges that are short beside the whole, at most `MAX_TESTS` tests.

use crate::geometry::weld::WeldedCorners;
use zonal_math::Vec3;

/// Most tests of a corner against an edge.
const MAX_TESTS: usize = 1 << 24;

/// The T-junctions of a set of free edges.
pub(crate) struct TJunctions<'a> {
    edges: &'a [(u32, u32)],
    /// Each corner in the interior of an edge, with the number of the edge, in ascending order.
    corners: Vec<(u32, usize)>,
    /// All tests were made.
    is_complete: bool,
}

impl<'a> TJunctions<'a> {
    /// Finds them among edges between welded corners.
    pub(crate) fn of(edges: &'a [(u32, u32)], welded: &WeldedCorners) -> TJunctions<'a> {
        let mut ends: Vec<u32> = edges.iter().flat_map(|e| [e.0, e.1]).collect();
        ends.sort_unstable();
        ends.dedup();
        let at = |k: u32| welded.points[k as usize];
        ends.sort_by(|a, b| at(*a).x.total_cmp(&at(*b).x).then(a.cmp(b)));
        let mut out = TJunctions { edges, corners: Vec::new(), is_complete: true };
        let mut tests = 0;
        for (edge, &(a, b)) in edges.iter().enumerate() {
            let (p, q) = (at(a), at(b));
            let (low, high) = (p.x.min(q.x) - welded.tolerance, p.x.max(q.x) + welded.tolerance);
            let from = ends.partition_point(|k| at(*k).x < low);
            let near = ends[from..].iter().copied().take_while(|k| at(*k).x <= high);
            let inside = near
                .inspect(|_| tests += 1)
                .take(MAX_TESTS)
                .filter(|k| *k != a && *k != b && is_between(at(*k), [p, q], welded.tolerance));
            out.corners.extend(inside.map(|k| (k, edge)));
            if tests > MAX_TESTS {
                out.is_complete = false;
                break;
            }
        }
        out.corners.sort_unstable();
        out
    }

    /// Numbers of the edges that have a corner in their interior, ascending.
    pub(crate) fn hosts(&self) -> Vec<usize> {
        let mut out: Vec<usize> = self.corners.iter().map(|c| c.1).collect();
        out.sort_unstable();
        out.dedup();
        out
    }

    /// True if there are T-junctions and every edge is a host or lies on one.
    pub(crate) fn pair_all_edges(&self) -> bool {
        let hosts = self.hosts();
        let is_paired = |edge: usize| {
            let (a, b) = self.edges[edge];
            let on_another = |k: u32, l: u32| self.hosts_of(k).any(|h| h != edge && self.is_on(l, h));
            hosts.binary_search(&edge).is_ok() || on_another(a, b) || on_another(b, a)
        };
        self.is_complete && !hosts.is_empty() && (0..self.edges.len()).all(is_paired)
    }

    /// The edges with a corner in their interior.
    fn hosts_of(&self, corner: u32) -> impl Iterator<Item = usize> + '_ {
        let from = self.corners.partition_point(|c| c.0 < corner);
        self.corners[from..].iter().take_while(move |c| c.0 == corner).map(|c| c.1)
    }

    /// True if a corner is an end of an edge or in its interior.
    fn is_on(&self, corner: u32, edge: usize) -> bool {
        let (a, b) = self.edges[edge];
        corner == a || corner == b || self.hosts_of(corner).any(|h| h == edge)
    }
}

/// True for a point on an edge within a tolerance, m.
fn is_between(point: Vec3, [p, q]: [Vec3; 2], tolerance: f64) -> bool {
    let (d, r) = (q - p, point - p);
    let t = r.dot(d) / d.length2();
    (0.0..=1.0).contains(&t) && (r - d * t).length() <= tolerance
}
