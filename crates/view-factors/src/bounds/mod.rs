//! Axis-aligned boxes and binary trees over them.

pub(crate) mod direction_cell;
pub(crate) mod shaft;

use zonal_math::Vec3;

/// An axis-aligned box, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub lo: Vec3,
    pub hi: Vec3,
}

impl Bounds {
    /// The box of points.
    pub(crate) fn of(points: &[Vec3]) -> Bounds {
        let start = Bounds { lo: Vec3::splat(f64::INFINITY), hi: Vec3::splat(f64::NEG_INFINITY) };
        points.iter().fold(start, |b, p| Bounds { lo: b.lo.min(*p), hi: b.hi.max(*p) })
    }
    pub(crate) fn union(self, o: Bounds) -> Bounds {
        Bounds { lo: self.lo.min(o.lo), hi: self.hi.max(o.hi) }
    }
    pub(crate) fn shifted(self, by: Vec3) -> Bounds {
        Bounds { lo: self.lo + by, hi: self.hi + by }
    }
    pub(crate) fn centre(self) -> Vec3 {
        (self.lo + self.hi) * 0.5
    }
    /// Half the diagonal, m.
    pub(crate) fn radius(self) -> f64 {
        0.5 * (self.hi - self.lo).length()
    }
    /// The eight corners.
    pub(crate) fn corners(self) -> [Vec3; 8] {
        std::array::from_fn(|k| {
            let pick = |bit: usize, lo: f64, hi: f64| if k >> bit & 1 == 0 { lo } else { hi };
            zonal_math::vec3(
                pick(0, self.lo.x, self.hi.x),
                pick(1, self.lo.y, self.hi.y),
                pick(2, self.lo.z, self.hi.z),
            )
        })
    }
    /// Largest value of n·x.
    pub(crate) fn support(self, n: Vec3) -> f64 {
        let pick = |n: f64, lo: f64, hi: f64| n * if n > 0.0 { hi } else { lo };
        pick(n.x, self.lo.x, self.hi.x) + pick(n.y, self.lo.y, self.hi.y) + pick(n.z, self.lo.z, self.hi.z)
    }
}

/// The mean of points, and the largest distance from it, m.
pub(crate) fn ball_about_middle(points: &[Vec3]) -> (Vec3, f64) {
    let middle = points.iter().fold(Vec3::ZERO, |s, p| s + *p) / points.len() as f64;
    (middle, points.iter().fold(0.0f64, |s, p| s.max((*p - middle).length())))
}

/// A node: items `first .. first + count` of the order; children follow for an inner node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TreeNode {
    pub bounds: Bounds,
    pub first: u32,
    pub count: u32,
    /// The two children of an inner node.
    pub children: Option<[u32; 2]>,
}

/// A binary tree over boxes; node 0 is the root.
#[derive(Clone, Debug)]
pub(crate) struct BoundsTree {
    pub nodes: Vec<TreeNode>,
    /// Items in the order of the leaves.
    pub order: Vec<u32>,
}

impl BoundsTree {
    /// Halves at the median of the longest side of the centres, within `groups` of items that stay together at the top; leaves have at most
    /// `leaf_size` items.
    pub(crate) fn new(boxes: &[Bounds], groups: &[u8], leaf_size: usize) -> BoundsTree {
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        order.sort_by_key(|k| groups[*k as usize]);
        let mut tree = BoundsTree { nodes: Vec::new(), order };
        if !boxes.is_empty() {
            tree.build(boxes, groups, 0..boxes.len(), leaf_size);
        }
        tree
    }

    fn build(
        &mut self,
        boxes: &[Bounds],
        groups: &[u8],
        range: std::ops::Range<usize>,
        leaf_size: usize,
    ) -> u32 {
        let items = &self.order[range.clone()];
        let bounds =
            items.iter().map(|k| boxes[*k as usize]).reduce(Bounds::union).expect("a range with items");
        let at = self.nodes.len() as u32;
        let (first, count) = (range.start as u32, range.len() as u32);
        self.nodes.push(TreeNode { bounds, first, count, children: None });
        let (low, high) = (groups[items[0] as usize], groups[items[range.len() - 1] as usize]);
        if range.len() <= leaf_size && low == high {
            return at;
        }
        let middle = if low == high {
            self.halve(boxes, range.clone());
            range.start + range.len() / 2
        } else {
            let split = low + (high - low).div_ceil(2);
            range.start + items.partition_point(|k| groups[*k as usize] < split)
        };
        let left = self.build(boxes, groups, range.start..middle, leaf_size);
        let right = self.build(boxes, groups, middle..range.end, leaf_size);
        self.nodes[at as usize].children = Some([left, right]);
        at
    }

    /// Orders a range by the centres along their longest side.
    fn halve(&mut self, boxes: &[Bounds], range: std::ops::Range<usize>) {
        let centres: Vec<Vec3> =
            self.order[range.clone()].iter().map(|k| boxes[*k as usize].centre()).collect();
        let extent = Bounds::of(&centres);
        let size = (extent.hi - extent.lo).array();
        let axis = (0..3).max_by(|a, b| size[*a].total_cmp(&size[*b])).unwrap_or(0);
        self.order[range].sort_by(|a, b| {
            let along = |k: &u32| boxes[*k as usize].centre().array()[axis];
            along(a).total_cmp(&along(b)).then(a.cmp(b))
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    #[test]
    fn trees_hold_every_item_once_and_keep_groups_together() {
        let boxes: Vec<Bounds> = (0..97)
            .map(|k| {
                let p = vec3((k * 37 % 101) as f64, (k * 53 % 89) as f64, (k % 7) as f64);
                Bounds { lo: p, hi: p + Vec3::ONE }
            })
            .collect();
        let groups: Vec<u8> = (0..97).map(|k| (k % 5) as u8).collect();
        let tree = BoundsTree::new(&boxes, &groups, 4);
        let mut seen = tree.order.clone();
        seen.sort_unstable();
        assert_eq!(seen, (0..97).collect::<Vec<u32>>());
        for n in tree.nodes.iter().filter(|n| n.children.is_none()) {
            let items = &tree.order[n.first as usize..(n.first + n.count) as usize];
            assert!(
                items.iter().all(|k| groups[*k as usize] == groups[items[0] as usize]) && items.len() <= 4
            );
        }
    }
}
