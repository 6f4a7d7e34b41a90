//! Light tree: a hierarchy over the facets of an emitter, for choosing facets by their contribution to a point.
//!
//! A node stores the area A of its facets and a ball (centre c, radius ρ) about them. At a point p, with the normal n of the
//! receiving surface, if any, its importance is
//!
//! ```text
//! w = A max(0, n·(c − p) + ρ)/(d d²),   d² = max(|c − p|², ρ²)        A/d² in free space
//! ```
//!
//! a bound of the cosine times the far-field contribution (Conty Estevez and Kulla 2018). A number in [0,1) descends the tree, to
//! either child with the probability of its importance. Nodes are split where the sum of count × surface of the boxes of both parts
//! is least, until a leaf has few facets and no split would separate them well: the flames of a chandelier become one leaf each.

use super::receiver::Receiver;
use std::ops::Range;
use zonal_math::Vec3;
use zonal_scene::Plate;

/// Most facets of a leaf.
pub(crate) const MAX_LEAF_FACETS: usize = 16;
/// Most nodes on the stack of [`LightTree::estimate`]; further nodes count undivided.
const MAX_PENDING_NODES: usize = 64;
/// A node whose radius over its distance is smaller counts undivided.
const SMALL_RADIUS_OVER_DISTANCE: f64 = 0.3;
/// A leaf is split nevertheless where that reduces count × surface to this fraction.
const SPLIT_COST_SHARE: f64 = 0.4;

#[derive(Clone, Debug)]
struct LightTreeNode {
    ball: LightBall,
    area: f64,
    facets: Range<usize>,
    /// Index of the second child, the first being the next node; 0 for a leaf.
    second: usize,
}

/// A ball about facets of an emitter, or about a point light.
#[derive(Clone, Copy, Debug)]
pub struct LightBall {
    /// Centre, m.
    pub centre: Vec3,
    /// Radius, m; 0 of a point light.
    pub radius: f64,
}

impl LightBall {
    /// An upper bound of the solid angle, sr, of an area, m², within this ball from any point of another; infinite where they touch.
    pub(crate) fn solid_angle_bound(&self, area: f64, other: &LightBall) -> f64 {
        let gap = (self.centre - other.centre).length() - self.radius - other.radius;
        if gap > 0.0 { area / (gap * gap) } else { f64::INFINITY }
    }
}

/// The tree. Its leaves are clusters of facets.
#[derive(Clone, Debug, Default)]
pub(crate) struct LightTree {
    nodes: Vec<LightTreeNode>,
    leaves: Vec<usize>,
}

/// A leaf chosen by importance.
pub(crate) struct SampledLeaf {
    /// The facets of the leaf.
    pub facets: Range<usize>,
    /// The ball about them.
    pub ball: LightBall,
    /// The probability of the choice.
    pub probability: f64,
}

impl LightTree {
    /// Builds the tree over facets with these plates; sorts `facets` into the order of the leaves.
    pub(crate) fn new<T>(facets: &mut [T], plate: impl Fn(&T) -> Plate) -> LightTree {
        let mut tree = LightTree::default();
        if !facets.is_empty() {
            tree.build_subtree(facets, 0, &plate);
        }
        tree
    }

    /// Appends the subtree over `facets`, the first of which is number `first` of all.
    fn build_subtree<T>(&mut self, facets: &mut [T], first: usize, plate: &impl Fn(&T) -> Plate) {
        let bounds =
            facets.iter().map(|f| PlateBounds::of(&plate(f))).fold(PlateBounds::EMPTY_BOX, PlateBounds::join);
        let here = self.nodes.len();
        self.nodes.push(LightTreeNode {
            ball: LightBall {
                centre: (bounds.lo + bounds.hi) * 0.5,
                radius: 0.5 * (bounds.hi - bounds.lo).length(),
            },
            area: facets.iter().map(|f| plate(f).area()).sum(),
            facets: first..first + facets.len(),
            second: 0,
        });
        let Some((axis, at, cost)) = cheapest_split(facets, plate) else {
            return self.leaves.push(here);
        };
        if facets.len() <= MAX_LEAF_FACETS
            && cost > SPLIT_COST_SHARE * facets.len() as f64 * bounds.half_surface_area()
        {
            return self.leaves.push(here);
        }
        sort_by_centre(facets, axis, plate);
        let (left, right) = facets.split_at_mut(at);
        self.build_subtree(left, first, plate);
        self.nodes[here].second = self.nodes.len();
        self.build_subtree(right, first + at, plate);
    }

    /// Number of leaves.
    pub(crate) fn len(&self) -> usize {
        self.leaves.len()
    }

    /// Centre, radius and facets of leaf `k`.
    pub(crate) fn leaf(&self, k: usize) -> (Vec3, f64, Range<usize>) {
        let node = &self.nodes[self.leaves[k]];
        (node.ball.centre, node.ball.radius, node.facets.clone())
    }

    /// The leaf for the number `s` ∈ [0,1), by importance at `p`; `None` where all importances are zero.
    pub(crate) fn sample(&self, p: Vec3, receiver: Receiver, mut s: f64) -> Option<SampledLeaf> {
        let (mut at, mut probability) = (0, 1.0);
        let mut node = self.nodes.first()?;
        while node.second > 0 {
            let (a, b) = (self.importance(at + 1, p, receiver), self.importance(node.second, p, receiver));
            let share = a / (a + b);
            if share.is_nan() {
                return None;
            }
            if s < share {
                (at, s, probability) = (at + 1, s / share, probability * share);
            } else {
                (at, s, probability) =
                    (node.second, (s - share) / (1.0 - share), probability * (1.0 - share));
            }
            node = &self.nodes[at];
        }
        Some(SampledLeaf { facets: node.facets.clone(), ball: node.ball, probability })
    }

    /// Estimate of Σ A cosθ⁺/d² over the tree, at least half of it where all facets face `p`: from the largest nodes of small angular
    /// size.
    pub(crate) fn estimate(&self, p: Vec3, receiver: Receiver) -> f64 {
        let (mut sum, mut open, mut top) = (0.0, [0; MAX_PENDING_NODES], 1);
        while top > 0 {
            top -= 1;
            let k = open[top];
            let Some(node) = self.nodes.get(k) else { continue };
            let is_near =
                (node.ball.centre - p).length2() * SMALL_RADIUS_OVER_DISTANCE * SMALL_RADIUS_OVER_DISTANCE
                    < node.ball.radius * node.ball.radius;
            if is_near && node.second > 0 && top + 2 <= MAX_PENDING_NODES {
                (open[top], open[top + 1]) = (k + 1, node.second);
                top += 2;
            } else {
                sum += self.importance(k, p, receiver);
            }
        }
        sum
    }

    /// True if `is_true` holds for the facets of a leaf all of whose balls, of this centre and radius, fulfil `may_hold`.
    pub(crate) fn any_facet(
        &self,
        may_hold: impl Fn(Vec3, f64) -> bool,
        is_true: impl Fn(Range<usize>) -> bool,
    ) -> bool {
        let mut open = vec![0];
        while let Some(k) = open.pop() {
            let Some(node) = self.nodes.get(k) else { continue };
            if !may_hold(node.ball.centre, node.ball.radius) {
                continue;
            }
            if node.second > 0 {
                open.extend([node.second, k + 1]);
            } else if is_true(node.facets.clone()) {
                return true;
            }
        }
        false
    }

    /// An upper bound of Σ A/d² over the tree from any point of a ball, sr: from the largest nodes of small angular size; infinite near a leaf.
    pub(crate) fn solid_angle_bound(&self, ball: &LightBall) -> f64 {
        let (mut sum, mut open) = (0.0, vec![0]);
        while let Some(k) = open.pop() {
            let Some(node) = self.nodes.get(k) else { continue };
            let is_near = node.ball.radius + ball.radius
                > SMALL_RADIUS_OVER_DISTANCE * (node.ball.centre - ball.centre).length();
            if is_near && node.second > 0 {
                open.extend([node.second, k + 1]);
            } else {
                sum += node.ball.solid_angle_bound(node.area, ball);
            }
        }
        sum
    }

    fn importance(&self, k: usize, p: Vec3, receiver: Receiver) -> f64 {
        let LightTreeNode { ball: LightBall { centre, radius }, area, .. } = &self.nodes[k];
        let offset = *centre - p;
        let d2 = offset.length2().max(radius * radius);
        match receiver {
            Receiver::Free => area / d2,
            Receiver::Surface(n) => area * (n.dot(offset) + radius).max(0.0) / (d2 * d2.sqrt()),
        }
    }
}

/// The bounds of some plates, m.
#[derive(Clone, Copy)]
struct PlateBounds {
    lo: Vec3,
    hi: Vec3,
}

impl PlateBounds {
    const EMPTY_BOX: PlateBounds = PlateBounds {
        lo: Vec3 { x: f64::INFINITY, y: f64::INFINITY, z: f64::INFINITY },
        hi: Vec3 { x: f64::NEG_INFINITY, y: f64::NEG_INFINITY, z: f64::NEG_INFINITY },
    };

    fn of(plate: &Plate) -> PlateBounds {
        let (lo, hi) = plate.bounds();
        PlateBounds { lo, hi }
    }

    fn join(self, other: PlateBounds) -> PlateBounds {
        PlateBounds { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// Half the surface area of the box, m².
    fn half_surface_area(&self) -> f64 {
        let d = self.hi - self.lo;
        d.x * d.y + d.y * d.z + d.z * d.x
    }
}

fn sort_by_centre<T>(facets: &mut [T], axis: usize, plate: &impl Fn(&T) -> Plate) {
    facets.sort_by(|a, b| plate(a).centre()[axis].total_cmp(&plate(b).centre()[axis]));
}

/// Axis, count of the first part and count × surface of the cheapest split; `None` for fewer than two facets.
fn cheapest_split<T>(facets: &mut [T], plate: &impl Fn(&T) -> Plate) -> Option<(usize, usize, f64)> {
    let mut best: Option<(usize, usize, f64)> = None;
    for axis in 0..3 {
        sort_by_centre(facets, axis, plate);
        let bounds: Vec<PlateBounds> = facets.iter().map(|f| PlateBounds::of(&plate(f))).collect();
        let mut behind = vec![PlateBounds::EMPTY_BOX; bounds.len() + 1];
        for k in (0..bounds.len()).rev() {
            behind[k] = behind[k + 1].join(bounds[k]);
        }
        let mut before = PlateBounds::EMPTY_BOX;
        // Long lists are split at an eighth or more, so that the tree stays shallow for coincident facets.
        let min_part = if bounds.len() > MAX_LEAF_FACETS { bounds.len() / 8 } else { 1 };
        for k in 1..bounds.len() {
            before = before.join(bounds[k - 1]);
            let cost = k as f64 * before.half_surface_area()
                + (bounds.len() - k) as f64 * behind[k].half_surface_area();
            if k >= min_part && k <= bounds.len() - min_part && best.is_none_or(|b| cost < b.2) {
                best = Some((axis, k, cost));
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::{low_discrepancy, vec3};

    /// Pairs of triangles at the corners of a grid.
    fn pairs() -> Vec<Plate> {
        let place = |i: usize| vec3((i % 4) as f64, (i / 4 % 3) as f64, (i / 12) as f64 * 2.0);
        let small =
            |o: Vec3, k: f64| Plate::triangle(o, o + vec3(0.02, 0.0, 0.01 * k), o + vec3(0.0, 0.02, 0.0));
        (0..48).map(|i| small(place(i / 2), (i % 2) as f64)).collect()
    }

    #[test]
    fn separate_groups_are_leaves_and_probabilities_sum_to_one() {
        let mut plates = pairs();
        let tree = LightTree::new(&mut plates, |p| *p);
        assert!(tree.len() >= 24 && (0..tree.len()).all(|k| tree.leaf(k).1 < 0.05));
        let p = vec3(0.3, 0.4, 1.1);
        for receiver in [Receiver::Free, Receiver::Surface(vec3(0.0, 0.0, 1.0))] {
            let (mut seen, n) = (std::collections::BTreeMap::new(), 20000);
            let mut none = 0.0;
            for i in 0..n {
                // A ball may reach above the horizon while its facets do not: then no leaf is found.
                let Some(leaf) = tree.sample(p, receiver, (i as f64 + 0.5) / n as f64) else {
                    none += 1.0 / n as f64;
                    continue;
                };
                let entry = seen.entry(leaf.facets.start).or_insert((0usize, leaf.probability));
                entry.0 += 1;
            }
            let total: f64 = none + seen.values().map(|x| x.1).sum::<f64>();
            assert!((total - 1.0).abs() < 1e-3, "{total}");
            for (count, probability) in seen.values() {
                assert!((*count as f64 - probability * n as f64).abs() < 3.0, "{count} {probability}");
            }
        }
        let below = tree.sample(
            vec3(0.0, 0.0, 5.0),
            Receiver::Surface(vec3(0.0, 0.0, 1.0)),
            low_discrepancy::hash_to_unit(1),
        );
        assert!(below.is_none(), "all facets lie behind the surface");
    }
}
