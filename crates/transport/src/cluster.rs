//! A tree over the facets of a shining surface: which of them to ask from a point.
//!
//! A node knows the area A of its facets and a ball (centre c, radius ρ) about them. From a point p, with the normal n of the surface
//! there, if any, it counts with
//!
//! ```text
//! w = A max(0, n·(c − p) + ρ)/(d d²),   d² = max(|c − p|², ρ²)        A/d² in free space
//! ```
//!
//! a bound of the cosine times what it would send from afar. A number in [0,1) goes down the tree, to either child with the chance of
//! its weight. Nodes are cut where the sum of count × surface of the boxes of both parts is least, until a leaf has few facets and no
//! cut would part them well: the flames of a chandelier are a leaf each.

use crate::direct::Receiver;
use std::ops::Range;
use zonal_math::Vec3;
use zonal_scene::Plate;

/// Facets of a leaf at most.
pub(crate) const LEAF: usize = 16;
/// Nodes that wait while the tree is gone through, at most; the rest counts as a whole.
const DEEP: usize = 64;
/// A node of a smaller radius over its distance counts as one.
const LOOKS_SMALL: f64 = 0.3;
/// A leaf is cut nevertheless where that lessens count × surface to this part.
const PARTED: f64 = 0.4;

#[derive(Clone, Debug)]
struct Node {
    centre: Vec3,
    radius: f64,
    area: f64,
    facets: Range<usize>,
    /// Index of the second child, the first being the next node; 0 for a leaf.
    second: usize,
}

/// The tree; its leaves are clusters of facets.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
    leaves: Vec<usize>,
}

/// What going down the tree found.
pub(crate) struct Leaf {
    /// Its facets.
    pub facets: Range<usize>,
    /// Centre, m, and radius, m, of the ball about them.
    pub ball: (Vec3, f64),
    /// The chance with which it is found.
    pub chance: f64,
}

impl Tree {
    /// The tree over facets with these plates; puts `facets` into its order.
    pub(crate) fn new<T>(facets: &mut [T], plate: impl Fn(&T) -> Plate) -> Tree {
        let mut tree = Tree::default();
        if !facets.is_empty() {
            tree.grow(facets, 0, &plate);
        }
        tree
    }

    fn grow<T>(&mut self, facets: &mut [T], first: usize, plate: &impl Fn(&T) -> Plate) {
        let (lo, hi) = facets.iter().map(|f| plate(f).bounds()).fold(EMPTY, join);
        let here = self.nodes.len();
        self.nodes.push(Node {
            centre: (lo + hi) * 0.5,
            radius: 0.5 * (hi - lo).length(),
            area: facets.iter().map(|f| plate(f).area()).sum(),
            facets: first..first + facets.len(),
            second: 0,
        });
        let Some((axis, at, cost)) = best_cut(facets, plate) else {
            return self.leaves.push(here);
        };
        if facets.len() <= LEAF && cost > PARTED * facets.len() as f64 * surface((lo, hi)) {
            return self.leaves.push(here);
        }
        sort(facets, axis, plate);
        let (left, right) = facets.split_at_mut(at);
        self.grow(left, first, plate);
        self.nodes[here].second = self.nodes.len();
        self.grow(right, first + at, plate);
    }

    /// Number of leaves.
    pub(crate) fn len(&self) -> usize {
        self.leaves.len()
    }

    /// Centre, radius and facets of leaf `k`.
    pub(crate) fn leaf(&self, k: usize) -> (Vec3, f64, Range<usize>) {
        let node = &self.nodes[self.leaves[k]];
        (node.centre, node.radius, node.facets.clone())
    }

    /// The leaf for the share `s` ∈ [0,1) as `p` counts them; `None` where none sends anything there.
    pub(crate) fn descend(&self, p: Vec3, receiver: Receiver, mut s: f64) -> Option<Leaf> {
        let (mut at, mut chance) = (0, 1.0);
        let mut node = self.nodes.first()?;
        while node.second > 0 {
            let (a, b) = (self.weight(at + 1, p, receiver), self.weight(node.second, p, receiver));
            let share = a / (a + b);
            if share.is_nan() {
                return None;
            }
            if s < share {
                (at, s, chance) = (at + 1, s / share, chance * share);
            } else {
                (at, s, chance) = (node.second, (s - share) / (1.0 - share), chance * (1.0 - share));
            }
            node = &self.nodes[at];
        }
        Some(Leaf { facets: node.facets.clone(), ball: (node.centre, node.radius), chance })
    }

    /// About Σ A cosθ⁺/d² over all of it, and no less than half where all of it faces `p`: from the largest nodes that look small.
    pub(crate) fn estimate(&self, p: Vec3, receiver: Receiver) -> f64 {
        let (mut sum, mut open, mut top) = (0.0, [0; DEEP], 1);
        while top > 0 {
            top -= 1;
            let k = open[top];
            let Some(node) = self.nodes.get(k) else { continue };
            let near = (node.centre - p).length2() * LOOKS_SMALL * LOOKS_SMALL < node.radius * node.radius;
            if near && node.second > 0 && top + 2 <= DEEP {
                (open[top], open[top + 1]) = (k + 1, node.second);
                top += 2;
            } else {
                sum += self.weight(k, p, receiver);
            }
        }
        sum
    }

    fn weight(&self, k: usize, p: Vec3, receiver: Receiver) -> f64 {
        let Node { centre, radius, area, .. } = &self.nodes[k];
        let way = *centre - p;
        let d2 = way.length2().max(radius * radius);
        match receiver {
            Receiver::Free => area / d2,
            Receiver::Surface(n) => area * (n.dot(way) + radius).max(0.0) / (d2 * d2.sqrt()),
        }
    }
}

type Bounds = (Vec3, Vec3);
const EMPTY: Bounds = (
    Vec3 { x: f64::INFINITY, y: f64::INFINITY, z: f64::INFINITY },
    Vec3 { x: f64::NEG_INFINITY, y: f64::NEG_INFINITY, z: f64::NEG_INFINITY },
);

fn join(a: Bounds, b: Bounds) -> Bounds {
    (a.0.min(b.0), a.1.max(b.1))
}

fn surface((lo, hi): Bounds) -> f64 {
    let d = hi - lo;
    d.x * d.y + d.y * d.z + d.z * d.x
}

fn sort<T>(facets: &mut [T], axis: usize, plate: &impl Fn(&T) -> Plate) {
    facets.sort_by(|a, b| plate(a).centre()[axis].total_cmp(&plate(b).centre()[axis]));
}

/// Axis, count of the first part and count × surface of the best cut; `None` of fewer than two facets.
fn best_cut<T>(facets: &mut [T], plate: &impl Fn(&T) -> Plate) -> Option<(usize, usize, f64)> {
    let mut best: Option<(usize, usize, f64)> = None;
    for axis in 0..3 {
        sort(facets, axis, plate);
        let bounds: Vec<Bounds> = facets.iter().map(|f| plate(f).bounds()).collect();
        let mut behind = vec![EMPTY; bounds.len() + 1];
        for k in (0..bounds.len()).rev() {
            behind[k] = join(behind[k + 1], bounds[k]);
        }
        let mut before = EMPTY;
        // Never much to one side where there are many: the tree stays shallow, whatever lies on one spot.
        let least = if bounds.len() > LEAF { bounds.len() / 8 } else { 1 };
        for k in 1..bounds.len() {
            before = join(before, bounds[k - 1]);
            let cost = k as f64 * surface(before) + (bounds.len() - k) as f64 * surface(behind[k]);
            if k >= least && k <= bounds.len() - least && best.is_none_or(|b| cost < b.2) {
                best = Some((axis, k, cost));
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::{sequence, vec3};

    /// Triangles in twos at the corners of a grid.
    fn pairs() -> Vec<Plate> {
        let place = |i: usize| vec3((i % 4) as f64, (i / 4 % 3) as f64, (i / 12) as f64 * 2.0);
        let small =
            |o: Vec3, k: f64| Plate::triangle(o, o + vec3(0.02, 0.0, 0.01 * k), o + vec3(0.0, 0.02, 0.0));
        (0..48).map(|i| small(place(i / 2), (i % 2) as f64)).collect()
    }

    #[test]
    fn groups_that_stand_apart_are_leaves_and_chances_sum_to_one() {
        let mut plates = pairs();
        let tree = Tree::new(&mut plates, |p| *p);
        assert!(tree.len() >= 24 && (0..tree.len()).all(|k| tree.leaf(k).1 < 0.05));
        let p = vec3(0.3, 0.4, 1.1);
        for receiver in [Receiver::Free, Receiver::Surface(vec3(0.0, 0.0, 1.0))] {
            let (mut seen, n) = (std::collections::BTreeMap::new(), 20000);
            let mut nothing = 0.0;
            for i in 0..n {
                // Where a ball reaches over the horizon, and nothing in it does, nothing is found.
                let Some(leaf) = tree.descend(p, receiver, (i as f64 + 0.5) / n as f64) else {
                    nothing += 1.0 / n as f64;
                    continue;
                };
                let entry = seen.entry(leaf.facets.start).or_insert((0usize, leaf.chance));
                entry.0 += 1;
            }
            let total: f64 = nothing + seen.values().map(|x| x.1).sum::<f64>();
            assert!((total - 1.0).abs() < 1e-3, "{total}");
            for (count, chance) in seen.values() {
                assert!((*count as f64 - chance * n as f64).abs() < 3.0, "{count} {chance}");
            }
        }
        let below =
            tree.descend(vec3(0.0, 0.0, 5.0), Receiver::Surface(vec3(0.0, 0.0, 1.0)), sequence::unit(1));
        assert!(below.is_none(), "all of it lies behind the surface");
    }
}
