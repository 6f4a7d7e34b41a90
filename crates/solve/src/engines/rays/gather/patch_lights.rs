//! The patches as lights of a gather: a tree over them by power, and for each receiver a probability of every patch.
//!
//! Φ_j is the power of patch j (area times a mean radiosity of all light groups). A node has the sum of Φ, the mean normal n̄ of its patches by
//! power, and a ball with the centre c and the radius ρ about them. Its importance at a receiver at x with the normal n is
//!
//! ```text
//! w = Φ ⟨cos θ_x⟩ ⟨cos θ_y⟩/max(|c − x|², ρ²)      ⟨cos θ_x⟩ = min(1, n·e + ρ/d)⁺      ⟨cos θ_y⟩ = min(1, −n̄·e + ρ/d + (1 − |n̄|)/2)⁺
//! ```
//!
//! with e the direction from x to c. The nodes of largest w and angular size are divided until a given number of them covers all patches (a cut of
//! the tree; Walter et al. 2005). A node of the cut has a probability in proportion to w, a patch of the node one in proportion to Φ:
//!
//! ```text
//! p_j = (w/Σ w) (Φ_j/Φ_node)
//! ```
//!
//! The probability is a choice only: the gather is correct with any.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use zonal_math::Vec3;

/// A node whose radius over its distance is smaller counts undivided.
const SMALL_RADIUS_OVER_DISTANCE: f64 = 0.15;
/// No patch is in the tree.
const ABSENT: u32 = u32::MAX;

/// A patch as a light.
#[derive(Clone, Copy)]
pub(crate) struct PatchLight {
    /// Number of the patch.
    pub patch: u32,
    /// Centre, m.
    pub centre: Vec3,
    /// Half of its largest diameter, m.
    pub radius: f64,
    /// Unit normal.
    pub normal: Vec3,
    /// Φ, W.
    pub power: f64,
}

struct Node {
    centre: Vec3,
    radius: f64,
    /// Mean normal by power.
    normal: Vec3,
    power: f64,
    /// Positions of its patches in the order of the tree.
    first: u32,
    end: u32,
    /// Index of the second child, the first being the next node; 0 for one patch.
    second: u32,
}

/// The receiver of a gather: a point, the extent of the zone about it, and the normal of a surface.
#[derive(Clone, Copy)]
pub(crate) struct ReceiverBall {
    /// Centre, m.
    pub centre: Vec3,
    /// Radius, m.
    pub radius: f64,
    /// Unit normal of a patch; `None` for a zone that receives from all sides.
    pub normal: Option<Vec3>,
}

/// The tree over all patches of positive power.
pub(crate) struct PatchLightTree {
    nodes: Vec<Node>,
    /// Patches in the order of the tree.
    patches: Vec<u32>,
    /// Sum of Φ before each position, and of all.
    power_before: Vec<f64>,
    /// Position of every patch.
    position: Vec<u32>,
}

impl PatchLightTree {
    /// Builds the tree; `patches` is the number of patches of the scene.
    pub(crate) fn new(mut lights: Vec<PatchLight>, patches: usize) -> PatchLightTree {
        lights.retain(|l| l.power > 0.0 && l.power.is_finite());
        let mut nodes = Vec::with_capacity(2 * lights.len());
        if !lights.is_empty() {
            build(&mut lights, 0, &mut nodes);
        }
        let mut position = vec![ABSENT; patches];
        lights.iter().enumerate().for_each(|(k, l)| position[l.patch as usize] = k as u32);
        let mut sum = 0.0;
        let mut power_before = vec![0.0];
        power_before.extend(lights.iter().map(|l| {
            sum += l.power;
            sum
        }));
        PatchLightTree { nodes, patches: lights.iter().map(|l| l.patch).collect(), power_before, position }
    }

    fn power_of(&self, first: u32, end: u32) -> f64 {
        self.power_before[end as usize] - self.power_before[first as usize]
    }

    fn importance(&self, node: &Node, receiver: &ReceiverBall) -> (f64, f64) {
        let offset = node.centre - receiver.centre;
        let distance = offset.length();
        let radius = node.radius + receiver.radius;
        let apparent = radius / distance.max(1e-300);
        let e = offset / distance.max(1e-300);
        let at_receiver = receiver.normal.map_or(1.0, |n| (n.dot(e) + apparent).clamp(0.0, 1.0));
        let spread = 0.5 * (1.0 - node.normal.length());
        let at_node = (apparent + spread - node.normal.dot(e)).clamp(0.0, 1.0);
        let weight = node.power * at_receiver * at_node / (distance * distance).max(radius * radius);
        (weight, apparent)
    }

    /// The probabilities of all patches at a receiver, by a cut of at most `max_nodes` nodes.
    pub(crate) fn cut(&self, receiver: &ReceiverBall, max_nodes: usize, cut: &mut LightCut) {
        cut.clear();
        if self.nodes.is_empty() {
            return;
        }
        let candidate = |k: u32| {
            let (weight, apparent) = self.importance(&self.nodes[k as usize], receiver);
            Candidate { priority: weight * apparent.min(1.0), weight, node: k, apparent }
        };
        cut.open.push(candidate(0));
        let mut count = 1;
        while let Some(top) = cut.open.pop() {
            let node = &self.nodes[top.node as usize];
            let divides = node.second != 0 && top.apparent > SMALL_RADIUS_OVER_DISTANCE && top.weight > 0.0;
            if divides && count < max_nodes {
                cut.open.push(candidate(top.node + 1));
                cut.open.push(candidate(node.second));
                count += 1;
            } else if top.weight > 0.0 {
                cut.chosen.push((node.first, node.end, top.weight));
            }
        }
        cut.chosen.sort_unstable_by_key(|c| c.0);
        for &(first, end, weight) in &cut.chosen {
            cut.total += weight;
            cut.cumulative.push(cut.total);
            cut.scale.push(weight / self.power_of(first, end));
        }
    }

    /// The patch for the number `u` ∈ [0, 1) and its probability; `None` without lights.
    pub(crate) fn sample(&self, cut: &LightCut, u: f64) -> Option<(u32, f64)> {
        if cut.is_dark() {
            return None;
        }
        let at = u * cut.total;
        let k = cut.cumulative.partition_point(|c| *c <= at).min(cut.chosen.len() - 1);
        let (first, end, weight) = cut.chosen[k];
        let within = ((at - (cut.cumulative[k] - weight)) / weight).clamp(0.0, 1.0);
        let power = self.power_before[first as usize] + within * self.power_of(first, end);
        let list = &self.power_before[first as usize + 1..=end as usize];
        let position = first + (list.partition_point(|p| *p <= power) as u32).min(end - first - 1);
        Some((self.patches[position as usize], self.probability_at(cut, k, position)))
    }

    fn probability_at(&self, cut: &LightCut, k: usize, position: u32) -> f64 {
        cut.scale[k] * self.power_of(position, position + 1) / cut.total
    }

    /// The probability of patch `patch`.
    pub(crate) fn probability(&self, cut: &LightCut, patch: u32) -> f64 {
        let position = self.position[patch as usize];
        if position == ABSENT || cut.chosen.is_empty() {
            return 0.0;
        }
        let k = cut.chosen.partition_point(|c| c.0 <= position);
        match k.checked_sub(1) {
            Some(k) if position < cut.chosen[k].1 => self.probability_at(cut, k, position),
            _ => 0.0,
        }
    }
}

/// A node that may be divided.
struct Candidate {
    priority: f64,
    weight: f64,
    apparent: f64,
    node: u32,
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Candidate) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Candidate {}
impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Candidate) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Candidate {
    fn cmp(&self, other: &Candidate) -> Ordering {
        self.priority.total_cmp(&other.priority).then(other.node.cmp(&self.node))
    }
}

/// A cut of the tree for one receiver. Its memory is used again for the next.
#[derive(Default)]
pub(crate) struct LightCut {
    open: BinaryHeap<Candidate>,
    /// First and end position and w of each node, in order.
    chosen: Vec<(u32, u32, f64)>,
    cumulative: Vec<f64>,
    /// w over the power of each node.
    scale: Vec<f64>,
    total: f64,
}

impl LightCut {
    fn clear(&mut self) {
        self.open.clear();
        self.chosen.clear();
        self.cumulative.clear();
        self.scale.clear();
        self.total = 0.0;
    }

    /// True where no patch lights the receiver.
    pub(crate) fn is_dark(&self) -> bool {
        self.total <= 0.0
    }
}

/// Appends the subtree over `lights`, the first of which is number `first`; sorts them into its order.
fn build(lights: &mut [PatchLight], first: u32, nodes: &mut Vec<Node>) {
    let infinite = Vec3::splat(f64::INFINITY);
    let (lo, hi) =
        lights.iter().fold((infinite, -infinite), |(lo, hi), l| (lo.min(l.centre), hi.max(l.centre)));
    let centre = (lo + hi) * 0.5;
    let power: f64 = lights.iter().map(|l| l.power).sum();
    let normal = lights.iter().fold(Vec3::ZERO, |n, l| n + l.normal * (l.power / power));
    let radius = lights.iter().fold(0.0f64, |r, l| r.max((l.centre - centre).length() + l.radius));
    let here = nodes.len();
    nodes.push(Node { centre, radius, normal, power, first, end: first + lights.len() as u32, second: 0 });
    if lights.len() < 2 {
        return;
    }
    let axis = (hi - lo).largest_axis();
    let middle = lights.len() / 2;
    lights.select_nth_unstable_by(middle, |a, b| {
        a.centre[axis].total_cmp(&b.centre[axis]).then(a.patch.cmp(&b.patch))
    });
    let (left, right) = lights.split_at_mut(middle);
    build(left, first, nodes);
    nodes[here].second = nodes.len() as u32;
    build(right, first + middle as u32, nodes);
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    /// Patches on a floor below the receiver, of different powers.
    fn lights() -> Vec<PatchLight> {
        (0..200)
            .map(|k| PatchLight {
                patch: k,
                centre: vec3((k % 20) as f64, (k / 20) as f64, 0.0),
                radius: 0.7,
                normal: vec3(0.0, 0.0, 1.0),
                power: 1.0 + (k * 7 % 13) as f64,
            })
            .collect()
    }

    #[test]
    fn probabilities_sum_to_one_and_are_those_of_the_samples() {
        let tree = PatchLightTree::new(lights(), 200);
        let receiver =
            ReceiverBall { centre: vec3(3.0, 4.0, 1.5), radius: 0.2, normal: Some(vec3(0.0, 0.0, -1.0)) };
        let mut cut = LightCut::default();
        for nodes in [1, 5, 64, 1000] {
            tree.cut(&receiver, nodes, &mut cut);
            let sum: f64 = (0..200).map(|j| tree.probability(&cut, j)).sum();
            assert!((sum - 1.0).abs() < 1e-12, "{nodes}: {sum}");
            let n = 20_000;
            let mut hits = vec![0usize; 200];
            for k in 0..n {
                let (j, p) = tree.sample(&cut, (k as f64 + 0.5) / n as f64).expect("the floor is lit");
                assert_eq!(p, tree.probability(&cut, j));
                hits[j as usize] += 1;
            }
            for (j, h) in hits.iter().enumerate() {
                let p = tree.probability(&cut, j as u32);
                assert!((*h as f64 - p * n as f64).abs() <= 2.0, "{nodes}, patch {j}: {h} {p}");
            }
        }
    }

    #[test]
    fn a_receiver_that_faces_away_has_no_lights() {
        let tree = PatchLightTree::new(lights(), 200);
        let receiver =
            ReceiverBall { centre: vec3(3.0, 4.0, 90.0), radius: 0.1, normal: Some(vec3(0.0, 0.0, 1.0)) };
        let mut cut = LightCut::default();
        tree.cut(&receiver, 64, &mut cut);
        assert!(cut.is_dark());
        assert!(tree.sample(&cut, 0.5).is_none());
        assert_eq!(tree.probability(&cut, 3), 0.0);
    }
}
