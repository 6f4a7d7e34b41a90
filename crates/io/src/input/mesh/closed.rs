//! Which parts of a mesh are closed, and which way they look.
//!
//! Corners are welded on a grid of 1e-6 of the mesh's diagonal. Faces that share edges form a component; it is closed when
//! each of its edges is run through once in each direction. The signed volume tells a body (normals outward) from a room.

use std::collections::HashMap;
use zonal_math::Vec3;
use zonal_scene::Plate;

/// What the component of a face is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shell {
    /// Some edge is free or shared by more than two faces.
    Open,
    /// Closed with normals outward.
    Body,
    /// Closed with normals inward.
    Room,
}

/// The shell of each plate.
pub(crate) fn shells(plates: &[Plate]) -> Vec<Shell> {
    let weld = Weld::new(plates);
    let mut ids: HashMap<[i64; 3], u32> = HashMap::new();
    let corners: Vec<Vec<u32>> = plates
        .iter()
        .map(|p| {
            let (c, n) = p.corners();
            let mut id = |q: &Vec3| {
                let next = ids.len() as u32;
                *ids.entry(weld.key(*q)).or_insert(next)
            };
            c[..n].iter().map(&mut id).collect()
        })
        .collect();
    // Each edge: how often it is run through forwards and backwards, and one face on it.
    let mut edges: HashMap<(u32, u32), (u32, u32, usize)> = HashMap::new();
    let mut parent: Vec<usize> = (0..plates.len()).collect();
    for (face, c) in corners.iter().enumerate() {
        for i in 0..c.len() {
            let (a, b) = (c[i], c[(i + 1) % c.len()]);
            if a == b {
                continue;
            }
            let e = edges.entry((a.min(b), a.max(b))).or_insert((0, 0, face));
            if a < b {
                e.0 += 1;
            } else {
                e.1 += 1;
            }
            let (x, y) = (root(&mut parent, face), root(&mut parent, e.2));
            parent[x] = y;
        }
    }
    let mut open = vec![false; plates.len()];
    for (forwards, backwards, face) in edges.into_values() {
        if (forwards, backwards) != (1, 1) {
            let r = root(&mut parent, face);
            open[r] = true;
        }
    }
    let mut volume = vec![0.0; plates.len()];
    for (face, p) in plates.iter().enumerate() {
        let r = root(&mut parent, face);
        let (c, n) = p.corners();
        for i in 1..n - 1 {
            let (a, b, d) = (c[0] - weld.origin, c[i] - weld.origin, c[i + 1] - weld.origin);
            volume[r] += a.dot(b.cross(d)) / 6.0;
        }
    }
    (0..plates.len())
        .map(|face| {
            let r = root(&mut parent, face);
            match (open[r], volume[r]) {
                (false, v) if v > 0.0 => Shell::Body,
                (false, v) if v < 0.0 => Shell::Room,
                _ => Shell::Open,
            }
        })
        .collect()
}

/// Refuses plates that do not bound a body.
pub(crate) fn check_closed(plates: &[Plate]) -> Result<(), String> {
    let open = shells(plates).iter().filter(|s| **s == Shell::Open).count();
    match open {
        0 => Ok(()),
        n => Err(format!(
            "{n} of the {} faces belong to no closed body, so that nothing is inside; close the mesh",
            plates.len()
        )),
    }
}

fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

struct Weld {
    origin: Vec3,
    step: f64,
}

impl Weld {
    fn new(plates: &[Plate]) -> Weld {
        let empty = (Vec3::splat(f64::INFINITY), Vec3::splat(f64::NEG_INFINITY));
        let (lo, hi) =
            plates.iter().map(Plate::bounds).fold(empty, |(lo, hi), (a, b)| (lo.min(a), hi.max(b)));
        Weld {
            origin: if lo.is_finite() { lo } else { Vec3::ZERO },
            step: ((hi - lo).max_abs() * 1e-6).max(f64::MIN_POSITIVE),
        }
    }
    fn key(&self, p: Vec3) -> [i64; 3] {
        let d = p - self.origin;
        [0, 1, 2].map(|k| (d[k] / self.step).round() as i64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::shapes::faces;
    use zonal_math::vec3;

    #[test]
    fn bodies_rooms_and_open_shells_are_told_apart() {
        let outer = faces(Vec3::ZERO, Vec3::splat(4.0), true);
        let inner = faces(Vec3::ONE, Vec3::splat(2.0), false);
        let lid = Plate::triangle(vec3(9.0, 0.0, 0.0), vec3(10.0, 0.0, 0.0), vec3(9.0, 1.0, 0.0));
        let all: Vec<Plate> = outer.into_iter().chain(inner).chain([lid]).collect();
        let s = shells(&all);
        assert!(s[..6].iter().all(|s| *s == Shell::Room));
        assert!(s[6..12].iter().all(|s| *s == Shell::Body));
        assert_eq!(s[12], Shell::Open);
        assert!(shells(&inner[..5]).iter().all(|s| *s == Shell::Open));
        let mut turned = inner;
        turned[2] = turned[2].flipped();
        assert!(shells(&turned).iter().all(|s| *s == Shell::Open));
        assert!(shells(&[]).is_empty());
    }
}
