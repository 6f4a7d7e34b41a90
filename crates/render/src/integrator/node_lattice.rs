//! Lattices of nodes on patches, as dense as a camera resolves them.
//!
//! A patch of diameter d at the distance r from the camera has n = d/(p r α) intervals along each edge, with α the angle between pixels and p the
//! wanted pixels between nodes. Values at the (n + 1)² nodes are computed when a camera ray needs them, and interpolated linearly along both
//! parameters of the plate, or on the triangles of a triangle.
//!
//! Most fields are smooth. A block of [`INTERVALS_PER_BLOCK`] × [`INTERVALS_PER_BLOCK`] intervals whose middle node agrees with its corners is interpolated between these; the
//! other nodes of the block are not computed.

use crate::interpolation::lazy_values::LazyValues;
use zonal_math::Vec3;
use zonal_scene::{Band, Bands, Plate, PlateKind};
use zonal_transport::patch_locator::clamped_parameters;

/// Share of the way from a node to the centre of its patch at which it is evaluated: nodes on the border lie on the surfaces that stand there.
const NODE_INSET: f64 = 1e-3;

/// Intervals along the edge of a block.
const INTERVALS_PER_BLOCK: usize = 4;
/// Largest deviation of the middle of a smooth block from its corners, and largest difference of these, over the scale of the values.
const MAX_DEVIATION: f64 = 0.02;
const MAX_DIFFERENCE: f64 = 0.25;

/// A camera as the density of the nodes depends on it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Viewpoint {
    /// Position, m.
    pub origin: Vec3,
    /// Angle between pixels, rad.
    pub pixel_angle: f64,
}

impl Viewpoint {
    /// Intervals along an edge of a plate with `pixels` between nodes, at most `max`; 0 where the plate is not larger.
    pub(crate) fn intervals(&self, plate: &Plate, pixels: f64, max: usize) -> usize {
        let size = plate.diameter();
        let distance = ((plate.centre() - self.origin).length() - 0.5 * size).max(0.0);
        (size / (pixels * distance * self.pixel_angle)).min(max as f64) as usize
    }
}

/// The nodes of one patch.
pub(crate) struct NodeLattice {
    intervals: usize,
    values: LazyValues<Bands>,
}

impl NodeLattice {
    /// A lattice of about `intervals` intervals along each edge, at least one: whole blocks, or fewer than a block.
    pub(crate) fn new(intervals: usize) -> NodeLattice {
        let intervals = if intervals < INTERVALS_PER_BLOCK {
            intervals.max(1)
        } else {
            intervals - intervals % INTERVALS_PER_BLOCK
        };
        NodeLattice { intervals, values: LazyValues::new((intervals + 1) * (intervals + 1)) }
    }

    /// The value at a point of the plate, from nodes that `node` evaluates. `scale` is added to the size of the values where smoothness is judged.
    pub(crate) fn at(&self, plate: &Plate, point: Vec3, scale: Bands, node: &dyn Fn(Vec3) -> Bands) -> Bands {
        let n = self.intervals;
        let value = |[a, b]: [usize; 2]| {
            let at = plate.at(a as f64 / n as f64, b as f64 / n as f64);
            let inside = at + (plate.centre() - at) * NODE_INSET;
            *self.values.get(a * (n + 1) + b, || node(inside))
        };
        let at = clamped_parameters(plate, point).map(|u| u * n as f64);
        let blocks = NodeBlock::around(at, INTERVALS_PER_BLOCK, n);
        let block = blocks.filter(|b| b.is_smooth(plate.kind, n, scale, &value));
        match block.or_else(|| NodeBlock::around(at, 1, n)) {
            Some(block) => block.interpolated(plate.kind, n, at, &value),
            None => value([0, 0]),
        }
    }
}

/// The intervals `first` to `first + size` along both parameters.
#[derive(Clone, Copy)]
struct NodeBlock {
    first: [usize; 2],
    size: usize,
}

impl NodeBlock {
    /// The block of a size that holds a point; `None` where a lattice of `n` intervals has no such blocks.
    fn around(at: [f64; 2], size: usize, n: usize) -> Option<NodeBlock> {
        (n >= size).then(|| NodeBlock { first: at.map(|x| (x as usize / size * size).min(n - size)), size })
    }

    fn corner(&self, a: usize, b: usize) -> [usize; 2] {
        [self.first[0] + a * self.size, self.first[1] + b * self.size]
    }

    /// True for a block of a triangle of which only the half below the diagonal belongs to it.
    fn is_half(&self, kind: PlateKind, n: usize) -> bool {
        kind == PlateKind::Triangle && self.first[0] + self.first[1] + 2 * self.size > n
    }

    fn is_smooth(
        &self,
        kind: PlateKind,
        n: usize,
        scale: Bands,
        value: &dyn Fn([usize; 2]) -> Bands,
    ) -> bool {
        let diagonal = [self.corner(1, 0), self.corner(0, 1)].map(value);
        // The middle lies on the diagonal, where a half block ends.
        let others = if self.is_half(kind, n) {
            [value(self.corner(0, 0)); 2]
        } else {
            [self.corner(0, 0), self.corner(1, 1)].map(value)
        };
        let middle = value(self.first.map(|x| x + self.size / 2));
        let all = [diagonal[0], diagonal[1], others[0], others[1]];
        Band::all().all(|k| {
            let (low, high) = all.iter().fold((f64::MAX, f64::MIN), |r, v| (r.0.min(v[k]), r.1.max(v[k])));
            let size = scale[k] + high.abs().max(low.abs());
            let mean = |v: [Bands; 2]| 0.5 * (v[0][k] + v[1][k]);
            let off = |m: f64| (middle[k] - m).abs() <= MAX_DEVIATION * size;
            high - low <= MAX_DIFFERENCE * size
                && off(mean(diagonal))
                && (self.is_half(kind, n) || off(mean(others)))
        })
    }

    /// The value at a point, between the corners.
    fn interpolated(
        &self,
        kind: PlateKind,
        n: usize,
        at: [f64; 2],
        value: &dyn Fn([usize; 2]) -> Bands,
    ) -> Bands {
        let [s, t] = [0, 1].map(|k| (at[k] - self.first[k] as f64) / self.size as f64);
        let corner = |a: usize, b: usize| value(self.corner(a, b));
        if kind == PlateKind::Parallelogram {
            let row = |b: usize| corner(0, b) * (1.0 - s) + corner(1, b) * s;
            return row(0) * (1.0 - t) + row(1) * t;
        }
        if s + t <= 1.0 || self.is_half(kind, n) {
            return corner(0, 0) * (1.0 - s - t) + corner(1, 0) * s + corner(0, 1) * t;
        }
        corner(1, 1) * (s + t - 1.0) + corner(1, 0) * (1.0 - t) + corner(0, 1) * (1.0 - s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::{low_discrepancy, vec3};

    #[test]
    fn linear_fields_are_exact() {
        let f = |p: Vec3| Bands::splat(1.0 + 2.0 * p.x - p.y);
        let edges = (vec3(1.0, 0.2, 0.0), vec3(0.0, 0.5, 0.0));
        for plate in [
            Plate::parallelogram(Vec3::ZERO, edges.0, edges.1),
            Plate::triangle(Vec3::ZERO, edges.0, edges.1),
        ] {
            for n in [1, 3, 5, 16] {
                let lattice = NodeLattice::new(n);
                for k in 0..200 {
                    let [u, v] = plate.warp(low_discrepancy::r2(k, [0.0; 2]));
                    let p = plate.at(u, v);
                    let off = lattice.at(&plate, p, Bands::ZERO, &f).first() - f(p).first();
                    assert!(off.abs() < 4.0 * NODE_INSET, "{p:?}: {off}");
                }
            }
        }
    }

    #[test]
    fn blocks_of_smooth_fields_need_few_nodes() {
        let plate = Plate::parallelogram(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        let count = |f: &dyn Fn(Vec3) -> f64| {
            let (lattice, nodes) = (NodeLattice::new(16), std::cell::Cell::new(0));
            let node = |p: Vec3| {
                nodes.set(nodes.get() + 1);
                Bands::splat(f(p))
            };
            let mut worst = 0.0f64;
            for k in 0..2000 {
                let [u, v] = low_discrepancy::r2(k, [0.0; 2]);
                let off = lattice.at(&plate, plate.at(u, v), Bands::ZERO, &node).first() - f(plate.at(u, v));
                worst = worst.max(off.abs());
            }
            (nodes.get(), worst)
        };
        // 25 corners and 16 middles of blocks.
        let (nodes, worst) = count(&|p| 2.0 + 0.3 * p.x * p.y);
        assert!(nodes == 41 && worst < 0.01, "{nodes} {worst}");
        // A shadow of two intervals across the plate: the blocks on it have all nodes.
        let (nodes, _) = count(&|p| if (0.5..0.625).contains(&p.x) { 0.0 } else { 1.0 });
        assert!((100..200).contains(&nodes), "{nodes}");
    }

    #[test]
    fn nodes_are_as_dense_as_the_camera_resolves() {
        let plate = Plate::parallelogram(vec3(-0.5, -0.5, 10.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        let at = |z: f64| Viewpoint { origin: vec3(0.0, 0.0, z), pixel_angle: 0.01 };
        // √2 m at 10 m less half of it: 4 pixels of 0.01 rad are 0.37 m.
        assert_eq!(at(0.0).intervals(&plate, 4.0, 64), 3);
        assert_eq!(at(-1000.0).intervals(&plate, 4.0, 64), 0);
        assert_eq!(at(10.0).intervals(&plate, 4.0, 64), 64);
    }
}
